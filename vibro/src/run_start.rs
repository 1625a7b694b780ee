//! Where a run starts: `orbit`, or coordinates with or without units, as `x1=0.2,v2=1` or `block.s=5mm`.

use crate::{Error, Result};
use vibro_analysis::quantity_in;
use vibro_analysis::stroboscopic::{COORDINATES, MOVING_BLOCK, dimensional};
use vibro_impact::{Parameters, State};

/// The names of the FMU for the same coordinates, whose numbers are in SI.
const SI_NAMES: [&str; 6] = ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"];

const EXPECTED: &str = "name=value,… with names of x1 x2 x3 (units of L) v1 v2 v3 (L omega10) box.s block.s secondary.s (m) box.v \
                        block.v secondary.v (m/s), each also with a unit of length or speed, e.g. x1=0.2,v2=1 or block.s=5mm; \
                        or orbit";

/// The start of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// Coordinates; what is not named is zero.
    Coordinates([Coordinate; 6]),
    /// On the exact orbit where that is stable.
    Orbit,
}

/// A coordinate of a start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coordinate {
    /// In units of L and L ω10.
    Scaled(f64),
    /// In m and m/s.
    Si(f64),
}

impl Default for Start {
    /// The [moving block](MOVING_BLOCK).
    fn default() -> Self {
        Self::Coordinates(MOVING_BLOCK.map(Coordinate::Scaled))
    }
}

impl std::str::FromStr for Start {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        if text.trim() == "orbit" {
            return Ok(Self::Orbit);
        }
        let form = || Error::form(text, EXPECTED);
        let mut start = [Coordinate::Scaled(0.0); 6];
        for assignment in text.split(',') {
            let (name, value) = assignment.split_once('=').ok_or_else(form)?;
            let place = |names: [&str; 6]| names.iter().position(|n| *n == name.trim());
            let (index, named_si) = match (place(COORDINATES), place(SI_NAMES)) {
                (Some(index), _) => (index, false),
                (None, Some(index)) => (index, true),
                (None, None) => return Err(form()),
            };
            let unit = if index < 3 { "m" } else { "m/s" };
            let found = quantity_in(unit, value).filter(|q| q.value.is_finite()).ok_or_else(form)?;
            let si = named_si || found.unit.is_some();
            start[index] = if si { Coordinate::Si(found.value) } else { Coordinate::Scaled(found.value) };
        }
        Ok(Self::Coordinates(start))
    }
}

impl std::fmt::Display for Start {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self::Coordinates(start) = self else { return f.write_str("orbit") };
        let word = |i: usize| match start[i] {
            Coordinate::Scaled(0.0) | Coordinate::Si(0.0) => None,
            Coordinate::Scaled(value) => Some(format!("{}={value}", COORDINATES[i])),
            Coordinate::Si(value) => Some(format!("{}={value}", SI_NAMES[i])),
        };
        let words: Vec<String> = (0..6).filter_map(word).collect();
        f.write_str(if words.is_empty() { "x1=0" } else { "" })?;
        f.write_str(&words.join(","))
    }
}

/// The state with these coordinates, in SI.
pub fn state(p: &Parameters, start: &[Coordinate; 6]) -> State {
    let scaled = start.map(|c| if let Coordinate::Scaled(value) = c { value } else { 0.0 });
    let mut state = dimensional(p, &scaled);
    for (place, c) in state.x.iter_mut().chain(&mut state.v).zip(start) {
        if let Coordinate::Si(value) = c {
            *place = *value;
        }
    }
    state
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_of_starts_with_and_without_units() {
        let p = Parameters { stop_gap: 0.01, box_stiffness: 4.0, ..Parameters::default() };
        let read = |text: &str| match text.parse().unwrap() {
            Start::Coordinates(c) => state(&p, &c),
            Start::Orbit => panic!("{text}"),
        };
        // L = 0.01 m, ω10 = 2 rad/s.
        assert_eq!(read("x1=0.5,v2=1"), State { x: [0.005, 0.0, 0.0], v: [0.0, 0.02, 0.0] });
        let si = State { x: [0.0, 0.005, 0.0], v: [0.0, 0.0, -0.25] };
        for text in ["block.s=5mm,secondary.v=-0.25", "x2=5mm, v3=-25 cm/s", "block.s=0.005,v3=-250mm/s"] {
            assert_eq!(read(text), si, "{text}");
        }
    }

    #[test]
    fn words_become_starts_and_starts_words() {
        for (text, words) in [
            ("orbit", "orbit"),
            ("v2=1.0", "v2=1"),
            ("x1=0", "x1=0"),
            ("v2=1,block.s = 5 mm", "block.s=0.005,v2=1"),
        ] {
            assert_eq!(text.parse::<Start>().unwrap().to_string(), words);
        }
        assert_eq!("v2=1".parse::<Start>().unwrap(), Start::default());
        for wrong in ["", "x4=1", "v2", "v2=fast", "v2=inf", "v2=1mm", "block.s=1kg", "block.v=1e999 m/s"] {
            assert!(wrong.parse::<Start>().unwrap_err().to_string().contains("block.s=5mm"), "{wrong}");
        }
    }
}
