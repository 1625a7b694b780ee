//! Contacts with a normal stiffness and friction along a tangent.

use crate::common::*;
use vibro_machine::Motion;
use vibro_machine::motion::{Event, EventKind};

/// The words of events of contacts.
fn words(events: &[Event]) -> Vec<(&'static str, f64)> {
    let word = |event: &Event| {
        let word = match event.kind {
            EventKind::Press { .. } => "press",
            EventKind::Free { .. } => "free",
            EventKind::Yield { direction, .. } if direction > 0.0 => "slip+",
            EventKind::Yield { .. } => "slip-",
            EventKind::Hold { .. } => "stick",
            _ => return None,
        };
        Some((word, event.time))
    };
    events.iter().filter_map(word).collect()
}

#[test]
fn smoke() {
    let text = r#"
        name = "A"
        body.n = { motion = { constant = 0.1, amplitude = 0.2, frequency = 1.0 } }
        body.t = { motion = { amplitude = 0.3, frequency = 1.3 } }
        body.box = { mass = 1.0 }
        spring.k = { between = ["ground", "box"], stiffness = 1.0 }
        contact.c = { normal = ["ground", "n"], tangent = ["box", "t"], gap = 0.0, stiffness = 100.0, tangential_stiffness = 50.0, friction = 0.4 }
    "#;
    let mut m: Motion = motion(machine(text));
    let begin = unaccounted(&m);
    for own in words(&events(&mut m, 5.0)) {
        println!("{own:?}");
    }
    println!("{:e} {:?}", unaccounted(&m) - begin, m.energy());
    panic!();
}
