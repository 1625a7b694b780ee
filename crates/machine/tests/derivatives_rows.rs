//! Derivatives of parts that other tests omit: a matrix body, and a sample at a start that an
//! impact changes.

use crate::common::*;
use vibro_machine::Differentiated;

/// Rounding of some hundred operations on numbers of order one.
const ROUNDING: f64 = 1e-12;

fn derivatives(text: &str, parameter: &str, end: f64) -> Vec<f64> {
    let mut motion = Differentiated::new(assembled(text), &[parameter]).unwrap();
    motion.advance_to(end).unwrap();
    motion.state_derivative(0).expect("a derivative")
}

fn assert_near(found: &[f64], exact: &[f64]) {
    assert_eq!(found.len(), exact.len());
    let is_near = |(x, y): (&f64, &f64)| (x - y).abs() < ROUNDING * y.abs().max(1.0);
    assert!(found.iter().zip(exact).all(is_near), "{found:?} {exact:?}");
}

#[test]
fn closed_form_a_load_on_a_body_of_matrices() {
    // 2 s'' + 800 s = F from rest: ds/dF = (1 - cos 20t)/800.
    let text = "name = \"M\"\n[matrix.m]\nmass = [[2.0]]\nstiffness = [[800.0]]\nnodes = { end = 0 }\n\
                [load.l]\non = \"m.end\"\nconstant = 3.0\n";
    let t: f64 = 0.3;
    let exact = [(1.0 - (20.0 * t).cos()) / 800.0, (20.0 * t).sin() / 40.0];
    let mut motion = Differentiated::new(assembled(text), &["load.l.constant"]).unwrap();
    motion.advance_to(t).unwrap();
    let all = motion.motion().assembly().description.named_quantities();
    for (name, exact) in ["m.end.s", "m.end.v"].into_iter().zip(exact) {
        let quantity = all.iter().find(|q| q.name == name).unwrap().quantity;
        assert_near(&[motion.derivative(quantity, 0).unwrap()], &[exact]);
    }
}

#[test]
fn closed_form_the_first_sample_reads_the_speed_that_an_impact_leaves() {
    // The block meets the stop at time 0 and leaves it with -0.5 m/s, which the sample of time 0
    // reads: s'' = K v(0) until the next sample, so that ds/dK = -0.5 t²/2.
    let text = "name = \"S\"\n[body.a]\nmass = 1.0\nstart = { s = 0.2, v = 1.0 }\n\
                [stop.wall]\nbetween = [\"ground\", \"a\"]\ngap = 0.2\nrestitution = 0.5\n\
                [block.c]\ninputs = [\"a.v\"]\nd = [[3.0]]\noutputs = [\"u\"]\nsample = 1.0\n\
                [load.l]\non = \"a\"\nfrom = \"c.u\"\n";
    let t = 0.8;
    let found = derivatives(text, "block.c.d[0][0]", t);
    assert_near(&found[..2], &[-0.25 * t * t, -0.5 * t]);
}
