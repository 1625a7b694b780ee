//! Starts of motions: on the exact orbit, or a state given by its coordinates with or without
//! units, such as `x1=0.2,v2=1` or `block.s=5mm`. All starts use this grammar.

use crate::error::{Error, Result};
use crate::paper::parameter_set::quantity_in;
use crate::paper::plane::exact;
use crate::paper::stroboscopic::{COORDINATES, MOVING_BLOCK, StroboscopicState, dimensional, moving_block};
use serde::{Deserialize, Serialize};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::State;

/// Names of the coordinates in the FMU, whose numbers are in SI.
pub const SI_COORDINATES: [&str; 6] = ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"];

const EXPECTED: &str = "name=value,… with names of x1 x2 x3 (units of L) v1 v2 v3 (L omega10) \
                        box.s block.s secondary.s (m) box.v block.v secondary.v (m/s), each also \
                        with a unit of length or speed, e.g. x1=0.2,v2=1 or block.s=5mm; or orbit";

/// Rule for the starts of motions. Serialized as text.
///
/// ```
/// use vibro_studies::paper::start::StartRule;
///
/// let start: StartRule = "v2=1, block.s=5 mm".parse()?;
/// assert_eq!(start.to_string(), "block.s=0.005,v2=1");
/// let twice = "x2=0.1,block.s=5mm".parse::<StartRule>().unwrap_err().to_string();
/// assert!(twice.contains("x2 and block.s"), "{twice}");
/// # Ok::<(), vibro_studies::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum StartRule {
    /// All motions start in one state; coordinates without a value are zero.
    State([Coordinate; 6]),
    /// Each motion starts on the exact orbit if it is stable. Otherwise it starts with the [moving
    /// block](MOVING_BLOCK).
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

impl Default for StartRule {
    /// The [moving block](MOVING_BLOCK).
    fn default() -> Self {
        Self::scaled(MOVING_BLOCK)
    }
}

crate::text::written_as_text!(StartRule);

/// Finds a coordinate by either name. Returns its index, and whether its numbers are in SI.
pub(crate) fn coordinate(name: &str) -> Option<(usize, bool)> {
    let place = |names: [&str; 6]| names.iter().position(|own| *own == name.trim());
    place(COORDINATES).map(|index| (index, false)).or_else(|| Some((place(SI_COORDINATES)?, true)))
}

/// The value of a coordinate, with or without a unit of length or speed.
pub(crate) fn coordinate_value((index, named_si): (usize, bool), text: &str) -> Option<Coordinate> {
    let unit = if index < 3 { "m" } else { "m/s" };
    let found = quantity_in(unit, text).filter(|q| q.value.is_finite())?;
    let si = named_si || found.unit.is_some();
    Some(if si { Coordinate::Si(found.value) } else { Coordinate::Scaled(found.value) })
}

impl std::str::FromStr for StartRule {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        if text.trim() == "orbit" {
            return Ok(Self::Orbit);
        }
        let form = || Error::Form { text: text.into(), expected: EXPECTED };
        let mut start = [Coordinate::Scaled(0.0); 6];
        let mut named: [Option<&str>; 6] = [None; 6];
        for assignment in text.split(',') {
            let (name, value) = assignment.split_once('=').ok_or_else(form)?;
            let found = coordinate(name).ok_or_else(form)?;
            if let Some(first) = named[found.0].replace(name.trim()) {
                let text = format!("{text}`: `{first} and {}", name.trim());
                return Err(Error::Form {
                    text,
                    expected: "each coordinate once: these are two names of one coordinate",
                });
            }
            start[found.0] = coordinate_value(found, value).ok_or_else(form)?;
        }
        Ok(Self::State(start))
    }
}

impl std::fmt::Display for StartRule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self::State(start) = self else { return f.write_str("orbit") };
        let word = |i: usize| match start[i] {
            Coordinate::Scaled(0.0) | Coordinate::Si(0.0) => None,
            Coordinate::Scaled(value) => Some(format!("{}={value}", COORDINATES[i])),
            Coordinate::Si(value) => Some(format!("{}={value}", SI_COORDINATES[i])),
        };
        let words: Vec<String> = (0..6).filter_map(word).collect();
        f.write_str(if words.is_empty() { "x1=0" } else { "" })?;
        f.write_str(&words.join(","))
    }
}

impl StartRule {
    /// The start in a state in units of L and L ω10.
    pub fn scaled(state: StroboscopicState) -> Self {
        Self::State(state.map(Coordinate::Scaled))
    }

    /// The start of a machine, SI: the state with the coordinates. For [`Orbit`](Self::Orbit) it
    /// is the stable exact orbit at time 0, or the [moving block](MOVING_BLOCK) if no exact orbit
    /// is stable.
    ///
    /// # Errors
    /// For [`Orbit`](Self::Orbit), errors of the exact orbit, such as the refusal of constant
    /// loads.
    pub fn state(&self, p: &Parameters) -> Result<State> {
        Ok(match self {
            Self::State(start) => state(p, start),
            Self::Orbit => exact(p)?.1.map_or_else(|| moving_block(p), |orbit| orbit.state(p.drive_phase)),
        })
    }
}

/// The state with these coordinates, SI.
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
        let read = |text: &str| text.parse::<StartRule>().unwrap().state(&p).unwrap();
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
            ("x1=-0.25,v3=2", "x1=-0.25,v3=2"),
            ("x1=0", "x1=0"),
            ("v2=1,block.s = 5 mm", "block.s=0.005,v2=1"),
        ] {
            let start = text.parse::<StartRule>().unwrap();
            assert_eq!(start.to_string(), words);
        }
        assert_eq!("v2=1".parse::<StartRule>().unwrap(), StartRule::default());
        for wrong in ["", "x4=1", "v2", "v2=fast", "v2=inf", "v2=1mm", "block.s=1kg", "block.v=1e999 m/s"] {
            assert!(wrong.parse::<StartRule>().unwrap_err().to_string().contains("block.s=5mm"), "{wrong}");
        }
    }

    #[test]
    fn a_coordinate_that_is_given_twice_is_refused_by_both_names() {
        for (text, both) in [
            ("x2=.1,block.s=.3", "x2 and block.s"),
            ("v1=1,box.v=2 m/s", "v1 and box.v"),
            ("x2=.1,v2=1,x2=.1", "x2 and x2"),
        ] {
            let error = text.parse::<StartRule>().unwrap_err().to_string();
            assert!(error.contains(both) && error.contains("each coordinate once"), "{error}");
        }
    }
}
