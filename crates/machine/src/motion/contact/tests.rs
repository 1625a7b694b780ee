//! Sizes below which values count as zero, and the verdicts of events.

use crate::file::{no_records, parse};
use crate::{Assembly, Motion};
use std::sync::Arc;

#[test]
fn closed_form_what_stands_by_forces_that_cancel_has_the_rounding_of_their_sizes() {
    // A weight of 6 N and an opposite load on 3 kg give 2 m/s² each: together a velocity of size 2
    // m/s over 0.5 s.
    let text = "name = \"A\"\ngravity = 2.0\n[body.b]\nmass = 3.0\ngravity = 1.0\n\
                [load.l]\non = \"b\"\ninput = true\n[spring.k]\nbetween = [\"ground\", \"b\"]\nstiffness = 1e-9\n";
    let machine = parse(text, "a.toml", &no_records).unwrap();
    let mut motion = Motion::new(Arc::new(Assembly::new(machine).unwrap())).unwrap();
    motion.set_input(0, [-6.0, 0.0, 0.0, 0.0]).unwrap();
    motion.advance_to(0.5).unwrap();
    assert!(motion.body(0).iter().all(|x| x.abs() < 1e-20), "{:?}", motion.body(0));
    motion.include_flight();
    let sizes = motion.hybrid.sizes.0.as_slice();
    // The coordinate's size is a hundredth of the travel due to these forces.
    assert!((sizes[1] - 2.0).abs() < 1e-12 && (sizes[0] - 0.01).abs() < 1e-14, "{sizes:?}");
}

#[test]
fn closed_form_an_impact_clears_the_flags_of_the_elements_that_it_moves() {
    let text = "name = \"A\"\n[body.a]\nmass = 1.0\n[body.b]\nmass = 2.0\nstart = { v = 1.0 }\n\
                [friction.fa]\nbetween = [\"ground\", \"a\"]\nforce = 1.0\n\
                [friction.fb]\nbetween = [\"ground\", \"b\"]\nforce = 1.0\n\
                [stop.sa]\nbetween = [\"ground\", \"a\"]\ngap = 1.0\nstiffness = 9.0\ndamping = 1.0\n\
                [stop.sb]\nbetween = [\"ground\", \"b\"]\ngap = 1.0\nstiffness = 9.0\ndamping = 1.0\n";
    let machine = parse(text, "a.toml", &no_records).unwrap();
    let motion = Motion::new(Arc::new(Assembly::new(machine).unwrap())).unwrap();
    let all = || vec![true; 2];
    let flags =
        super::Flags { stops: all(), resting: all(), edges: all(), limits: all(), sliders: Vec::new() };
    // Only the second body is hit; at its speed of 1 m/s a kick of 1e-14 m/s is rounding.
    for (kick, stays) in [(-0.5, false), (1e-14, true), (0.0, true)] {
        let kick = nalgebra::DVector::from_vec(vec![0.0, kick]);
        let after = flags.after(&kick, &motion.assembly.system, &motion.hybrid.sizes);
        assert_eq!((after.resting, after.limits), (vec![true, stays], vec![true, stays]));
        assert_eq!((after.stops, after.edges), (all(), all()));
    }
}
