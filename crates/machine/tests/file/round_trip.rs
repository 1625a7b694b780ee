//! A written machine reads back equal, to the last digit.

use crate::random::machine;
use proptest::prelude::*;
use vibro_machine::file::{no_records, parse, with_numbers};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn invariant_a_written_machine_reads_back_equal(machine in machine()) {
        let text = machine.to_toml();
        let read = parse(&text, "written.toml", &no_records);
        prop_assert!(read.is_ok(), "{}\n{text}", read.unwrap_err());
        prop_assert_eq!(read.unwrap(), machine, "{}", text);
    }

    #[test]
    fn invariant_numbers_that_are_set_in_a_text_read_back_equal(machine in machine()) {
        let text = machine.to_toml();
        // Many elements omit numbers that are 0 from the text.
        let moved = |value: f64, k: usize| if value == 0.0 { 1e-3 } else { value * (1.0 + 1e-3 * (k % 3) as f64) };
        let all = machine.parameters().into_iter().enumerate();
        let other = all.fold(machine.clone(), |other, (k, own)| {
            other.with([(own.name.as_str(), moved(own.value, k))]).unwrap_or(other)
        });
        let edited = with_numbers(&text, &no_records, &other);
        prop_assert!(edited.is_some(), "{text}\n{}", other.to_toml());
        prop_assert_eq!(parse(&edited.unwrap(), "edited.toml", &no_records).unwrap(), other, "{}", text);
    }
}

/// Numbers that depend on a named parameter keep their expressions; the parameter keeps its unit
/// and comment.
#[test]
fn golden_a_named_parameter_is_set_in_the_text_for_all_that_follows() {
    let text = "name = \"A\"\n[parameters]\ngap = \"5 mm\" # of both\n[body.b]\nmass = 1.0\n\
                [stop.right]\nbetween = [\"ground\", \"b\"]\ngap = \"= gap\"\nrestitution = 0.5\n\
                [stop.left]\nbetween = [\"b\", \"ground\"]\ngap = \"= 2 * gap\"\nrestitution = 0.5\n";
    let wider = parse(text, "a.toml", &no_records).unwrap().with([("gap", 7e-3)]).unwrap();
    let edited = with_numbers(text, &no_records, &wider);
    assert_eq!(edited.as_deref(), Some(text.replace("5 mm", "7 mm").as_str()));
}
