//! Contacts with friction against motions in 40 digits: words of events, rows of data, derivatives.

use super::assembled;
use vibro_machine::derivative::Gradient;
use vibro_machine::description::Description;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Differentiated, Quantity};

/// The words of a contact's events, with their times.
pub fn words(events: &[Event]) -> Vec<(&'static str, f64)> {
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

/// A column: numbers of a row of the data.
pub fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace().map(|x| x.parse().expect("a number")).collect()
}

/// Relative rounding of derivatives over some ten to twenty events.
pub const BY: f64 = 1e-9;

/// Compares derivatives at the end with rows of data: machine, end, number, and the derivatives of
/// the quantities `of` by this number. The gradient of a weighted sum must agree, too. Returns the
/// count of rows.
pub fn compare_derivatives(data: &str, of: impl Fn(&Description, usize) -> Quantity) -> usize {
    for row in data.lines() {
        let fields: Vec<&str> = row.split(';').collect();
        let assembly = assembled(&fields[0].replace('|', "\n"));
        let (end, name, exact) = (numbers(fields[1])[0], fields[2], numbers(fields[3]));
        let mut by = Differentiated::new(assembly.clone(), &[name]).unwrap();
        by.advance_to(end).unwrap();
        let size = exact.iter().fold(1e-3, |most: f64, x| most.max(x.abs()));
        let mut sum = Gradient::new(assembly.clone(), by.columns()).unwrap();
        sum.advance_to(end).unwrap();
        let mut total = 0.0;
        for (k, x) in exact.iter().enumerate() {
            let quantity = of(&assembly.description, k);
            let found = by.derivative(quantity, 0).unwrap();
            assert!((found - x).abs() < BY * size, "{found} {x} by {name} in {row}");
            let weight = 1.0 - 0.3 * k as f64;
            sum.add(quantity, weight);
            total += weight * x;
        }
        let found = sum.gradient().unwrap().remove(0).unwrap();
        assert!((found - total).abs() < 10.0 * BY * size, "{found} {total} by {name} in {row}");
    }
    data.lines().count()
}
