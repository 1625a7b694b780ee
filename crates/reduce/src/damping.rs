//! Damping ratios of modes.

use crate::sparse::Symmetric;
use crate::{Error, Result};
use nalgebra::DMatrix;
use std::f64::consts::PI;

/// Damping of a rigid-body mode, relative to the largest entry of the projected matrix, that
/// counts as zero: rounding.
const UNDAMPED: f64 = 1e-9;

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

/// The damping of modes by a damping matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct Projected {
    /// Damping ratios φᵀ C φ/(2 ω) of modes of mass 1; 0 of a rigid mode.
    pub ratios: Vec<f64>,
    /// The largest damping between two modes, relative to the mean of their own: it is left out.
    pub left_out: f64,
}

/// Projects a damping matrix on modes of mass 1 with these eigenvalues ω².
///
/// # Errors
/// An error if the matrix damps a rigid-body mode or drives a mode.
pub fn projected(damping: &Symmetric, basis: &DMatrix<f64>, values: &[f64]) -> Result<Projected> {
    let own = basis.tr_mul(&damping.times(basis));
    let (rounding, mut ratios) = (UNDAMPED * own.amax(), Vec::new());
    for (k, &value) in values.iter().enumerate() {
        let c = own[(k, k)];
        if value == 0.0 && c.abs() > rounding {
            let problem = format!(
                "it damps the rigid-body mode {}, which has no damping ratio; expected a matrix of dampers inside the \
                 body, or --clamp",
                k + 1
            );
            return Err(Error::new("--damping", problem));
        }
        if c < -rounding {
            let problem =
                format!("mode {} has the damping {c:.3e}; expected a positive semidefinite matrix", k + 1);
            return Err(Error::new("--damping", problem));
        }
        ratios.push(if value == 0.0 { 0.0 } else { c.max(0.0) / (2.0 * value.sqrt()) });
    }
    let pairs = (0..values.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let shares = pairs.filter(|&(i, j)| own[(i, j)].abs() > rounding).map(|(i, j)| {
        let mean = (own[(i, i)].max(rounding) * own[(j, j)].max(rounding)).sqrt();
        own[(i, j)].abs() / mean
    });
    Ok(Projected { ratios, left_out: shares.fold(0.0, f64::max) })
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

    /// α M + β K has the ratios of `--rayleigh` and no damping between modes; a single dashpot has c φᵢφⱼ.
    #[test]
    fn closed_form_damping_matrices_on_modes() {
        let listed = |entries: &[(usize, usize, f64)]| {
            let list: Vec<_> = entries
                .iter()
                .map(|&(row, column, value)| crate::sparse::Entry { row, column, value })
                .collect();
            Symmetric::assemble(2, &list, crate::sparse::Listed::Once, &|row| row.to_string()).unwrap()
        };
        // Two masses of 1 with springs of 1 to ground and 1 between them: ω² = 1 and 3.
        let (values, half) = ([1.0, 3.0], 0.5f64.sqrt());
        let basis = DMatrix::from_row_slice(2, 2, &[half, half, half, -half]);
        let rayleigh = listed(&[(0, 0, 0.1 + 2.0 * 0.3), (1, 1, 0.1 + 2.0 * 0.3), (1, 0, -0.3)]);
        let found = projected(&rayleigh, &basis, &values).unwrap();
        let frequencies: Vec<f64> = values.iter().map(|value: &f64| value.sqrt() / (2.0 * PI)).collect();
        let exact = Damping::Rayleigh(0.1, 0.3).ratios(&frequencies).unwrap();
        assert!(
            found.left_out < 1e-8 && found.ratios.iter().zip(exact).all(|(a, b)| (a - b).abs() < ROUNDING)
        );
        let found = projected(&listed(&[(0, 0, 0.4)]), &basis, &values).unwrap();
        assert!((found.left_out - 1.0).abs() < ROUNDING);
        assert!(
            (found.ratios[0] - 0.1).abs() < ROUNDING
                && (found.ratios[1] - 0.1 / 3f64.sqrt()).abs() < ROUNDING
        );
        let refused =
            |entry, values: [f64; 2]| projected(&listed(&[entry]), &basis, &values).unwrap_err().to_string();
        assert!(refused((0, 0, 0.4), [0.0, 3.0]).contains("rigid-body mode 1"));
        assert!(refused((0, 0, -0.4), values).contains("mode 1 has the damping -2"));
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
