//! The symbols of stops differ from those of other fields.

use crate::marks::Marks;
use vibro_machine::file::{no_records, parse};
use vibro_sketch::Sketch;

/// The lines of the rigid stop between two bodies, from the middle of its symbol, in whole units
/// and in order. `faces`: whether it limits an approach.
fn lines(faces: bool) -> Vec<[i64; 4]> {
    let ends = if faces { "\"a\", \"b\"" } else { "\"b\", \"a\"" };
    // Springs to ground keep the order of the file.
    let text = format!(
        "name = \"A\"\nbody.b = {{ mass = 1.0 }}\nbody.a = {{ mass = 1.0 }}\n\
         spring.s = {{ between = [\"ground\", \"b\"], stiffness = 1.0 }}\n\
         spring.t = {{ between = [\"a\", \"ground\"], stiffness = 1.0 }}\n\
         stop.x = {{ between = [{ends}], gap = 1.0, restitution = 0.5 }}\n"
    );
    let sketch = Sketch::new(&parse(&text, "a.toml", &no_records).unwrap());
    let item = sketch.names().position(|name| name == "x").unwrap();
    let marks = Marks::of(&sketch);
    let around = marks.around(item).0;
    let (x, y) =
        (0.5 * (around[0] + around[2]), marks.lines.iter().find(|line| line.0 == Some(item)).unwrap().1[0].1);
    let line = |[from, to]: [(f64, f64); 2]| {
        let [from, to] = [from, to].map(|at| ((at.0 - x).round() as i64, (at.1 - y).round() as i64));
        let [from, to] = [from.min(to), from.max(to)];
        [from.0, from.1, to.0, to.1]
    };
    let own = marks.lines.iter().filter(|line| line.0 == Some(item));
    let mut found: Vec<_> = own.map(|own| line(own.1)).collect();
    found.sort_unstable();
    found
}

/// The lines mirrored along or across the row.
fn mirrored(lines: &[[i64; 4]], along: i64, across: i64) -> Vec<[i64; 4]> {
    let line = |[x0, y0, x1, y1]: &[i64; 4]| {
        let [from, to] = [(along * x0, across * y0), (along * x1, across * y1)];
        let [from, to] = [from.min(to), from.max(to)];
        [from.0, from.1, to.0, to.1]
    };
    let mut found: Vec<_> = lines.iter().map(line).collect();
    found.sort_unstable();
    found
}

#[test]
fn invariant_a_stop_is_no_capacitor_and_no_dashpot() {
    // The symbol of a capacitor is the same from both ends.
    let stop = lines(true);
    assert_ne!(mirrored(&stop, -1, 1), stop);
    // That of a dashpot is the same from both sides.
    let reversed = lines(false);
    assert_ne!(mirrored(&reversed, 1, -1), reversed);
}
