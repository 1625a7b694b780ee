//! Units of the matrices of a file, which no file states.

use crate::dofs::Direction;
use crate::{Error, Result};

/// Units of force, length, mass and, if given, time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    force: f64,
    length: f64,
    mass: f64,
    time: f64,
}

const FORCES: [(&str, f64); 4] = [("N", 1.0), ("mN", 1e-3), ("kN", 1e3), ("MN", 1e6)];
const LENGTHS: [(&str, f64); 4] = [("m", 1.0), ("mm", 1e-3), ("um", 1e-6), ("cm", 1e-2)];
const MASSES: [(&str, f64); 4] = [("kg", 1.0), ("t", 1e3), ("g", 1e-3), ("mg", 1e-6)];
const TIMES: [(&str, f64); 2] = [("s", 1.0), ("ms", 1e-3)];
const EXPECTED: &str = "expected SI, or the units of force, length, mass and time: N,mm,t,s or kN,mm,kg,ms";

impl Units {
    /// Newton, metre, kilogram, second.
    pub const SI: Self = Self { force: 1.0, length: 1.0, mass: 1.0, time: 1.0 };

    /// Reads `SI`, `N,mm,t,s`, or `N,mm,t`.
    ///
    /// # Errors
    /// An error for unknown units, and if the unit of force is not mass times length over time².
    pub fn read(text: &str) -> Result<Self> {
        if text.trim().eq_ignore_ascii_case("si") {
            return Ok(Self::SI);
        }
        let words: Vec<&str> = text.split(',').map(str::trim).collect();
        let refused = |problem: String| Error::new(format!("--units {text}"), problem);
        let of = |units: &[(&str, f64)], word: &str| {
            let found = units.iter().find(|unit| unit.0 == word).map(|unit| unit.1);
            found.ok_or_else(|| {
                let names: Vec<&str> = units.iter().map(|unit| unit.0).collect();
                refused(format!("{word}: expected one of {}; {EXPECTED}", names.join(", ")))
            })
        };
        let (force, length, mass, time) = match words[..] {
            [force, length, mass] => (force, length, mass, None),
            [force, length, mass, time] => (force, length, mass, Some(time)),
            _ => return Err(refused(EXPECTED.into())),
        };
        let found = Self {
            force: of(&FORCES, force)?,
            length: of(&LENGTHS, length)?,
            mass: of(&MASSES, mass)?,
            time: time.map_or(Ok(1.0), |time| of(&TIMES, time))?,
        };
        if let Some(time) = time {
            let own = found.mass * found.length / found.time.powi(2);
            if (own / found.force - 1.0).abs() > 1e-9 {
                return Err(refused(format!(
                    "not consistent: 1 {mass} {length}/{time}² is {own:.6} N, not 1 {force}. Give the units in which the \
                     program computed (kg, mm, ms compute in kN: kN,mm,kg,ms), or, if stiffness is in {force}/{length} and mass in \
                     {mass} regardless of the time, leave out the time: {force},{length},{mass}"
                )));
            }
        }
        Ok(found)
    }

    /// Factor to SI of the stiffness between two directions. A rotation has no unit of length.
    pub fn stiffness(&self, one: Direction, other: Direction) -> f64 {
        self.force / self.length * self.lengths(one) * self.lengths(other)
    }

    /// Factor to SI of the damping between two directions; without a unit of time, of seconds.
    pub fn damping(&self, one: Direction, other: Direction) -> f64 {
        self.stiffness(one, other) * self.time
    }

    /// Factor to SI of the mass between two directions.
    pub fn mass(&self, one: Direction, other: Direction) -> f64 {
        self.mass * self.lengths(one) * self.lengths(other)
    }

    /// Factor that makes a displacement of a rotation.
    fn lengths(&self, direction: Direction) -> f64 {
        if direction.is_rotation() { self.length } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Products of a few powers of ten.
    const ROUNDING: f64 = 1e-15;

    #[test]
    fn closed_form_units_are_powers_of_ten() {
        let near = |one: f64, other: f64| assert!((one / other - 1.0).abs() < ROUNDING, "{one} {other}");
        let tonnes = Units::read("N,mm,t,s").unwrap();
        let (x, rx) = (Direction::X, Direction::Rx);
        near(tonnes.stiffness(x, x), 1e3);
        near(tonnes.stiffness(x, rx), 1.0);
        near(tonnes.stiffness(rx, rx), 1e-3);
        near(tonnes.mass(x, x), 1e3);
        near(tonnes.mass(rx, rx), 1e-3);
        near(Units::read("kN,mm,kg,ms").unwrap().stiffness(x, x), 1e6);
        near(Units::read("N, mm, kg").unwrap().stiffness(x, x), 1e3);
        assert_eq!(Units::read("si"), Ok(Units::SI));
        assert_eq!(Units::read("N,mm,t"), Ok(tonnes));
    }

    #[test]
    fn invariant_units_that_do_not_fit_are_refused() {
        let text = Units::read("N,mm,kg,ms").unwrap_err().to_string();
        assert!(text.contains("not 1 N") && text.contains("kN,mm,kg,ms"), "{text}");
        for text in ["", "N", "N,mm", "N,mm,t,h", "lbf,in,lb,s", "N,mm,t,s,s"] {
            assert!(Units::read(text).unwrap_err().to_string().contains("SI"), "{text}");
        }
    }
}
