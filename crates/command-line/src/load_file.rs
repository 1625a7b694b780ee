//! Loads of the command line: a constant force, or a record from a CSV file of time (s) and force
//! (N), read into a [`Load`].
//!
//! ```text
//! time [s];force [N]
//! 0;0
//! 0.001;12.5
//! ```
//!
//! The file is a [`Table`]: its heading may name other units of time and of force.

use crate::table::read_text;
use crate::{Error, Result};
use std::path::PathBuf;
use vibro_impact::load::{Body, Interpolation, Load};
use vibro_impact::parameters::LOADS;
use vibro_machine::table::{Table, in_unit};
use vibro_numerics::digest::fnv1a;
use vibro_studies::paper::{Name, ParameterSet, quantity_in};

/// Load of the command line: `box=record.csv` or `block=-3.4N`. A text that can be read as a force
/// is a force; a file with the name `5N` must be written `./5N`.
#[derive(Clone, Debug, PartialEq)]
pub enum LoadArgument {
    /// From a file.
    File(LoadFile),
    /// Constant force, N.
    Constant(Body, f64),
}

/// A body and the file of its load.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadFile {
    /// The body.
    pub body: Body,
    /// The file.
    pub path: PathBuf,
}

impl std::str::FromStr for LoadArgument {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let form = || {
            Error::form(
                text,
                "BODY=FORCE or BODY=FILE with a body of box, block, secondary, e.g. block=-3.4N or box=record.csv",
            )
        };
        let (name, what) = text.split_once('=').ok_or_else(form)?;
        let body = Body::ALL.into_iter().find(|b| b.name() == name.trim()).ok_or_else(form)?;
        match quantity_in("N", what) {
            Some(force) if force.value.is_finite() => Ok(Self::Constant(body, force.value)),
            Some(_) => Err(form()),
            None if what.trim().is_empty() => Err(form()),
            None => Ok(Self::File(LoadFile { body, path: what.into() })),
        }
    }
}

impl LoadArgument {
    /// Description for manifests: the force, or a digest of the file's contents. `None` for a file
    /// that cannot be read twice.
    pub fn in_words(&self) -> Option<String> {
        match self {
            Self::File(file) => file.contents_in_words(),
            Self::Constant(body, force) => Some(format!("{}={force} N", body.name())),
        }
    }
}

/// Loads that come from files.
pub fn files(loads: &[LoadArgument]) -> impl Iterator<Item = &LoadFile> {
    loads.iter().filter_map(|load| if let LoadArgument::File(file) = load { Some(file) } else { None })
}

/// Adds the constant loads to the loads of a parameter set.
///
/// # Errors
/// An error if a sum of loads is not finite.
pub fn apply_constant(set: &mut ParameterSet, loads: &[LoadArgument]) -> Result<()> {
    for load in loads {
        if let LoadArgument::Constant(body, force) = load {
            let name = Name::Si(&LOADS[*body as usize]);
            set.assign(&[(name, name.value(set) + force)])?;
        }
    }
    Ok(())
}

impl LoadFile {
    /// Reads the file.
    ///
    /// # Errors
    /// [`Error::File`] if the file cannot be read; [`Error::Config`] with the file, the line and
    /// the valid form if a line is not valid.
    pub fn read(&self, interpolation: Interpolation) -> Result<Load> {
        let text = read_text(&self.path)?;
        let problem = |problem| Error::Config { path: self.path.clone(), problem };
        parse(&text, self.body, interpolation).map_err(problem)
    }

    /// Body and digest of the file's contents, for manifests. Results of different contents are
    /// distinct; moving the file changes nothing. `None` for a file that cannot be read twice,
    /// such as a pipe.
    pub fn contents_in_words(&self) -> Option<String> {
        let bytes = self.path.is_file().then(|| std::fs::read(&self.path).ok()).flatten()?;
        Some(format!("{}=file of {} bytes, digest {:016x}", self.body.name(), bytes.len(), fnv1a(&bytes)))
    }
}

/// Parses a record. An error begins with the line's number.
fn parse(text: &str, body: Body, interpolation: Interpolation) -> std::result::Result<Load, String> {
    let table = Table::read(text);
    let (mut units, mut rows) = ([None, None], &table.rows[..]);
    if let Some(names) = table.heading() {
        let first = &table.rows[0];
        table.check(first, 2)?;
        for ((unit, name), si) in units.iter_mut().zip(&names).zip(["s", "N"]) {
            *unit = name.unit(si).map_err(|text| first.refused(&text))?;
        }
        rows = &table.rows[1..];
    }
    let sample = |row| -> std::result::Result<(f64, f64), String> {
        let numbers = table.numbers(row, 2)?;
        Ok((in_unit(units[0], numbers[0]), in_unit(units[1], numbers[1])))
    };
    let samples = rows.iter().map(sample).collect::<std::result::Result<Vec<_>, _>>()?;
    Load::new(body, &samples, interpolation).map_err(|error| match error {
        vibro_impact::Error::Sample { index, time, force, allowed } => {
            format!("line {}, time {time} s, force {force} N: expected {allowed}", rows[index].line)
        }
        other => other.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> std::result::Result<Load, String> {
        parse(text, Body::Box, Interpolation::Linear)
    }

    #[test]
    fn one_grammar_of_constant_loads_and_files() {
        let read = |text: &str| text.parse::<LoadArgument>();
        for (text, body, force) in [
            ("block=-3.4N", Body::Block, -3.4),
            ("box = 5 kN", Body::Box, 5000.0),
            ("secondary=0.02", Body::Secondary, 0.02),
        ] {
            assert_eq!(read(text).unwrap(), LoadArgument::Constant(body, force), "{text}");
        }
        for (text, file) in [("box=record.csv", "record.csv"), ("box=./5N", "./5N"), ("box=5N.csv", "5N.csv")]
        {
            assert_eq!(
                read(text).unwrap(),
                LoadArgument::File(LoadFile { body: Body::Box, path: file.into() })
            );
        }
        for wrong in ["box", "box=", "lid=3N", "block=inf", "block=1e999 N"] {
            assert!(
                read(wrong).unwrap_err().to_string().contains("block=-3.4N or box=record.csv"),
                "{wrong}"
            );
        }
        let mut set = ParameterSet::basic();
        let loads = ["block=-3N", "box=record.csv", "block=1N"].map(|text| read(text).unwrap());
        apply_constant(&mut set, &loads).unwrap();
        assert_eq!(files(&loads).count(), 1);
        assert_eq!(set.parameters().constant_loads, [0.0, -2.0, 0.0]);
    }

    #[test]
    fn closed_form_of_records_in_all_allowed_forms() {
        let expected = Load::new(Body::Box, &[(0.0, 1.0), (0.5, -2.5), (1.0, 0.0)], Interpolation::Linear);
        for text in [
            "0,1\n0.5,-2.5\n1,0",
            "time,force\n0,1\n0.5,-2.5\n1,0\n",
            "\u{feff}t [s]; F [N]\r\n0;1\r\n0.5;-25e-1\r\n\r\n1;0\r\n",
            "\"t; since the start [s]\";\"F [N]\"\n0;1\n\"0.5\"; \"-2.5\"\n1;0",
            "# from the shaker\n\"t (s)\",\"f (N)\"\n0, 1\n 0.5 , -2.5\n# end\n1,0",
            "t [ms],f (kN)\n0,0.001\n500,-0.0025\n1000,0\n",
        ] {
            assert_eq!(read(text), Ok(expected.clone().unwrap()), "{text}");
        }
    }

    #[test]
    fn what_is_no_record_is_refused_by_its_line() {
        for (text, line) in [
            ("t,f\n0,1\n1,NaN\n2,0", "line 3: `NaN` is not a number; expected a number"),
            ("t,f\n\n0,1\n1,inf\n2,0", "line 4: `inf` "),
            ("0,1\n1,2\n1,3\n", "line 3, time 1 s, force 3 N: expected a time later"),
            ("0,1\n2,2\n1,3\n", "line 3, "),
            ("0,1\n1,\n", "line 2: `1,` has an empty cell"),
            ("0,1\n1,2,3\n", "line 2: `1,2,3` has 3 cells; expected 2 cells"),
            ("0;1\n0,5;2\n", "line 2: `0,5` has a decimal comma; expected a decimal point"),
            ("t,f\nu,g\n", "line 2: `u` is not a number"),
            ("t,1\n0,1\n1,1\n", "line 1: `t` is not a number"),
            ("t [mm],f [N]\n0,1\n1,1\n", "line 1: `t` has the unit `mm`; expected one of s, ms"),
            ("t,f (kW)\n0,1\n1,1\n", "line 1: `f` has the unit `kW`; expected one of N, mN, kN"),
            ("t,f\n0,1\n", "a record of 1 samples: expected at least two"),
            ("", "a record of 0 samples"),
        ] {
            let words = read(text).unwrap_err();
            assert!(words.starts_with(line), "{text}: {words}");
        }
    }
}
