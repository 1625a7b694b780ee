//! A machine in which bodies feel gravity is drawn upright.

use crate::marks::{Marks, Rectangle};
use std::path::Path;
use vibro_machine::file::{no_records, parse, read};
use vibro_sketch::Sketch;

/// Rounding of the numbers of `flat`, which have 24 bits: pictures are a few thousand units wide.
const ROUNDING: f64 = 1e-3;

fn sketch(text: &str) -> Sketch {
    Sketch::new(&parse(&format!("name = \"A\"\n{text}"), "a.toml", &no_records).unwrap())
}

/// The boxes of bodies with their names.
fn boxes(sketch: &Sketch) -> Vec<(String, Rectangle)> {
    let names: Vec<String> = sketch.names().map(str::to_owned).collect();
    Marks::of(sketch).boxes.into_iter().map(|(item, place)| (names[item].clone(), place)).collect()
}

/// Everything of the ground and of legs.
fn ground(sketch: &Sketch) -> Rectangle {
    let lines = Marks::of(sketch).lines;
    let lines = lines.iter().filter(|line| line.0.is_none()).flat_map(|line| line.1);
    Rectangle::around(&lines.collect::<Vec<_>>())
}

/// A body of some cosine to gravity on an element to ground.
fn body(cosine: &str, element: &str) -> Sketch {
    sketch(&format!("gravity = 9.81\nbody.b = {{ mass = 1.0, gravity = {cosine} }}\n{element}\n"))
}

/// Displacement of the body's box when its coordinate grows by 50.
fn displacement(sketch: &Sketch) -> (f64, f64) {
    let place = |sketch: &Sketch| boxes(sketch)[0].1.0;
    let (before, after) = (place(sketch), place(&sketch.moved(&|_| 50.0, &|_| None)));
    (after[0] - before[0], after[1] - before[1])
}

#[test]
fn closed_form_coordinates_grow_downwards_along_gravity_and_upwards_against_it() {
    let spring = "spring.s = { between = [\"ground\", \"b\"], stiffness = 1.0 }";
    for (cosine, expected) in
        [("1.0", (0.0, 50.0)), ("0.5", (0.0, 50.0)), ("-1.0", (0.0, -50.0)), ("0.0", (50.0, 0.0))]
    {
        let found = displacement(&body(cosine, spring));
        let off = (found.0 - expected.0).abs().max((found.1 - expected.1).abs());
        assert!(off < ROUNDING, "{cosine}: {found:?} instead of {expected:?}");
    }
}

#[test]
fn invariant_the_floor_is_below() {
    let spring = "spring.s = { between = [\"ground\", \"b\"], stiffness = 1.0 }";
    // A stop limits e, the second end minus the first.
    let falls = "stop.s = { between = [\"ground\", \"b\"], gap = 1.0, restitution = 0.5 }";
    let rises = "stop.s = { between = [\"b\", \"ground\"], gap = 1.0, restitution = 0.5 }";
    for (cosine, element) in [("1.0", spring), ("-1.0", spring), ("1.0", falls), ("-1.0", rises)] {
        let sketch = body(cosine, element);
        let (body, floor) = (boxes(&sketch)[0].1, ground(&sketch));
        assert!(body.0[3] < floor.0[1], "{cosine}, {element}: {body:?} is not above {floor:?}");
    }
    // A stop on the other side is a ceiling.
    let (hung, ceiling) = (body("1.0", rises), ground(&body("1.0", rises)));
    assert!(ceiling.0[3] < boxes(&hung)[0].1.0[1]);
    // A chain of two bodies stands on the floor with the body that is held by ground.
    for cosine in ["1.0", "-1.0"] {
        let chain = sketch(&format!(
            "gravity = 9.81\nbody.upper = {{ mass = 1.0, gravity = {cosine} }}\n\
             body.lower = {{ mass = 1.0, gravity = {cosine} }}\n\
             spring.one = {{ between = [\"upper\", \"lower\"], stiffness = 1.0 }}\n\
             spring.two = {{ between = [\"lower\", \"ground\"], stiffness = 1.0 }}\n"
        ));
        let boxes = boxes(&chain);
        let of = |name: &str| boxes.iter().find(|own| own.0 == name).unwrap().1.0;
        assert!(of("upper")[3] < of("lower")[1] && of("lower")[3] < ground(&chain).0[1], "{cosine}");
    }
}

#[test]
fn golden_order_of_ten_beads_over_their_floor() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly/bead_column.toml");
    let sketch = Sketch::new(&read(&path).unwrap());
    let mut beads = boxes(&sketch);
    beads.sort_by(|a, b| b.1.0[3].total_cmp(&a.1.0[3]));
    assert!(beads[0].1.0[3] < ground(&sketch).0[1]);
    let expected: Vec<String> = (1..=10).map(|i| format!("bead{i}")).collect();
    assert_eq!(beads.into_iter().map(|bead| bead.0).collect::<Vec<_>>(), expected);
}

/// No direction is right for all bodies if gravity acts along the coordinates of some and against
/// those of others.
#[test]
fn invariant_bodies_that_fall_in_different_directions_are_side_by_side() {
    let sketch = sketch(
        "gravity = 9.81\nbody.a = { mass = 1.0, gravity = 1.0 }\nbody.b = { mass = 1.0, gravity = -1.0 }\n\
         link.rope = { arms = { a = 1.0, b = -1.0 } }\n",
    );
    let boxes = boxes(&sketch);
    assert_eq!((boxes[0].1.0[1], boxes[0].1.0[3]), (boxes[1].1.0[1], boxes[1].1.0[3]));
}
