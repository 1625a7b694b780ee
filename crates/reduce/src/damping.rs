//! Damping ratios of modes.

use crate::{Error, Result};
use std::f64::consts::PI;

/// How the modes are damped.
#[derive(Clone, Debug, PartialEq)]
pub enum Damping {
    /// The same ratio for all modes.
    Ratio(f64),
    /// Frequencies in Hz, rising, with ratios; linear between them and constant beyond.
    Table(Vec<[f64; 2]>),
    /// C = α M + β K, with α in 1/s and β in s.
    Rayleigh(f64, f64),
}

impl Damping {
    /// Reads a table of frequencies and ratios: two numbers a line, after an optional heading.
    ///
    /// # Errors
    /// An error with the line for anything else.
    pub fn of_table(text: &str, file: &str) -> Result<Self> {
        let mut table: Vec<[f64; 2]> = Vec::new();
        for (i, line) in text.lines().enumerate() {
            let words: Vec<&str> =
                line.split([',', ';', '\t', ' ']).filter(|word| !word.is_empty()).collect();
            let numbers: Vec<f64> =
                words.iter().filter_map(|word| word.parse().ok().filter(|x: &f64| *x >= 0.0)).collect();
            let is_good = numbers.len() == 2 && words.len() == 2 && numbers.iter().all(|x| x.is_finite());
            if words.is_empty() || (i == 0 && numbers.is_empty()) {
                continue;
            }
            if !is_good || table.last().is_some_and(|last| last[0] >= numbers[0]) {
                let problem =
                    "expected a frequency in Hz, greater than the one before, and a damping ratio >= 0";
                return Err(Error::new(format!("{file}:{}", i + 1), problem));
            }
            table.push([numbers[0], numbers[1]]);
        }
        if table.is_empty() { Err(Error::new(file, "it has no numbers")) } else { Ok(Self::Table(table)) }
    }

    /// Damping ratios of modes with these frequencies in Hz; of a rigid mode 0.
    ///
    /// # Errors
    /// An error if a rigid mode would be damped by α.
    pub fn ratios(&self, frequencies: &[f64]) -> Result<Vec<f64>> {
        let one = |f: &f64| match self {
            _ if *f == 0.0 => 0.0,
            Self::Ratio(ratio) => *ratio,
            Self::Table(table) => interpolated(table, *f),
            Self::Rayleigh(alpha, beta) => alpha / (4.0 * PI * f) + beta * PI * f,
        };
        if matches!(self, Self::Rayleigh(alpha, _) if *alpha > 0.0) && frequencies.contains(&0.0) {
            let problem =
                "the body has rigid-body modes, and a rigid mode has no damping ratio; expected alpha 0";
            return Err(Error::new("--rayleigh", problem));
        }
        Ok(frequencies.iter().map(one).collect())
    }
}

fn interpolated(table: &[[f64; 2]], f: f64) -> f64 {
    let above = table.partition_point(|row| row[0] <= f);
    match (above.checked_sub(1).map(|k| table[k]), table.get(above)) {
        (Some([f0, z0]), Some([f1, z1])) => z0 + (z1 - z0) * (f - f0) / (f1 - f0),
        (Some([_, z]), None) => z,
        (None, Some([_, z])) => *z,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ratios of a few roundings.
    const ROUNDING: f64 = 1e-15;

    #[test]
    fn closed_form_ratios_of_each_kind() {
        let table = Damping::of_table("f,zeta\n10, 0.01\n20, 0.03\n", "d.csv").unwrap();
        for (damping, f, expected) in [
            (Damping::Ratio(0.02), 5.0, 0.02),
            (table.clone(), 5.0, 0.01),
            (table.clone(), 15.0, 0.02),
            (table.clone(), 99.0, 0.03),
            (table, 0.0, 0.0),
            (Damping::Rayleigh(2.0 * PI, 0.02 / PI), 1.0, 0.52),
        ] {
            assert!((damping.ratios(&[f]).unwrap()[0] - expected).abs() < ROUNDING, "{damping:?}");
        }
        assert!(Damping::Rayleigh(1.0, 0.0).ratios(&[0.0, 1.0]).is_err());
    }

    #[test]
    fn invariant_tables_that_are_none_are_refused_with_their_line() {
        for (text, line) in [
            ("1 0.1\n1 0.2", ":2"),
            ("1 0.1\n2", ":2"),
            ("1 0.1\nx y", ":2"),
            ("1 -1", ":1"),
            ("", "no numbers"),
        ] {
            let error = Damping::of_table(text, "d.csv").unwrap_err().to_string();
            assert!(error.contains(line), "{text}: {error}");
        }
    }
}
