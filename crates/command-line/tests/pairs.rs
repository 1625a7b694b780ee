//! `vibro check` of every combination of element and body (`crates/pack/tests/pairs/main.rs`).

#[path = "../../pack/tests/pairs/machines.rs"]
mod machines;

use vibro_machine::description::Description;
use vibro_machine::file;

/// Numbers of the lines of natural frequencies in a summary, by line.
fn frequencies(d: &Description) -> Vec<Vec<f64>> {
    let text = vibro::machine::summary(d.clone()).unwrap();
    let (_, lines) = text.split_once("natural frequencies").expect("frequencies");
    let numbers = |line: &str| line.split([' ', ',']).filter_map(|word| word.parse().ok()).collect();
    lines.lines().skip(1).filter(|line| line.contains("Hz, ")).map(numbers).collect()
}

#[test]
fn second_method_check_gives_the_frequencies_of_the_other_writing() {
    // Six digits are printed.
    const DIGITS: f64 = 2e-5;
    for number in 0..machines::ELEMENTS.len() {
        let described = |text: &String| file::parse(text, "machine.toml", &file::no_records).unwrap();
        let [found, exact] = machines::machine(number).map(|text| frequencies(&described(&text)));
        assert!(found.len() == exact.len() && found.len() >= 4, "machine {number}: {found:?} {exact:?}");
        for (a, b) in found.iter().flatten().zip(exact.iter().flatten()) {
            assert!((a - b).abs() <= DIGITS * b.abs() + 1e-9, "machine {number}: {a} or {b} Hz");
        }
    }
}
