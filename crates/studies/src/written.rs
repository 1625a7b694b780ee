//! Units of the numbers in a machine's file. These units also apply to numbers given elsewhere
//! without a unit.

use super::{Machine, Start};
use crate::error::Result;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use vibro_machine::description::Description;
use vibro_machine::file::{self, Records};
use vibro_machine::refusal::Refusal;
use vibro_numerics::quantities::{Quantity, Unit, quantity_in};

impl Machine {
    /// Reads a machine's file, including the written units of its parameters.
    ///
    /// # Errors
    /// As [`vibro_machine::file::read`].
    pub fn read(path: &Path) -> Result<Self> {
        Self::read_by(path, file::read)
    }

    /// Reads a machine's file as [`vibro_machine::file::read_draft`], with its units.
    ///
    /// # Errors
    /// As [`vibro_machine::file::read_draft`].
    pub fn read_draft(path: &Path) -> Result<Self> {
        Self::read_by(path, file::read_draft)
    }

    fn read_by(path: &Path, read: fn(&Path) -> std::result::Result<Description, Refusal>) -> Result<Self> {
        let mut machine = Self::new(read(path)?);
        // The file was read just before.
        let text = std::fs::read_to_string(path).unwrap_or_default();
        machine.units = units(&text, &machine.description);
        Ok(machine)
    }

    /// Parses the text of a machine's file, with its units; `name` is its name in messages.
    ///
    /// # Errors
    /// As [`vibro_machine::file::parse`].
    ///
    /// # Examples
    /// Parameters are shown in the units of the file:
    ///
    /// ```
    /// use vibro_studies::Machine;
    ///
    /// let text = r#"
    ///     name = "Lid"
    ///     body.block = { mass = "350 g" }
    ///     stop.lid = { between = ["ground", "block"], gap = "4 mm", restitution = 0.7 }
    /// "#;
    /// let machine = Machine::parse(text, "lid.toml", &vibro_machine::file::no_records)?;
    /// assert_eq!(machine.told("stop.lid.gap", 0.0055), "5.5 mm");
    /// assert_eq!(machine.told("body.block.mass", 0.35), "350 g");
    /// # Ok::<(), vibro_studies::Error>(())
    /// ```
    pub fn parse(text: &str, name: &str, records: Records) -> Result<Self> {
        let mut machine = Self::new(file::parse(text, name, records)?);
        machine.units = units(text, &machine.description);
        Ok(machine)
    }

    /// Parses a value of a parameter, in SI, with its unit. A number without a unit is in the
    /// parameter's unit from the file or from a later call of [`note_unit`](Self::note_unit).
    /// Without such a unit it is in SI.
    ///
    /// # Errors
    /// [`Error::Refusal`](crate::Error::Refusal) for an unknown name and for a value out of range.
    pub fn quantity(&self, name: &str, text: &str) -> Result<Quantity> {
        let parameter = self.description.parameter(name)?;
        let typed = quantity_in(parameter.unit, text.trim()).and_then(|q| q.unit);
        let is_bare = text.trim().parse::<f64>().is_ok();
        Ok(match self.written_unit(&parameter.name).filter(|_| is_bare) {
            Some(own) => {
                let value = parameter.read(&format!("{} {}", text.trim(), own.plain()))?;
                Quantity { value, unit: Some(own) }
            }
            None => Quantity { value: parameter.read(text)?, unit: typed },
        })
    }

    /// Sets a number of a start from a text. A number without a unit is in the unit that the file
    /// uses for this number of its own start. This unit is returned if it is not SI.
    ///
    /// # Errors
    /// [`Error::Refusal`](crate::Error::Refusal) for an unknown name and for a value out of range.
    pub fn set_start(&self, start: &mut Start, name: &str, text: &str) -> Result<Option<&'static Unit>> {
        let plain = name.strip_prefix("body.").unwrap_or(name);
        let own = plain.split_once('.').map(|(body, key)| format!("body.{body}.start.{key}"));
        let is_bare = text.trim().parse::<f64>().is_ok_and(|x| x != 0.0);
        let unit = own.and_then(|own| self.written_unit(&own)).filter(|unit| is_bare && !unit.is_si());
        match unit {
            Some(unit) => {
                start.set_text(&self.description, name, &format!("{} {}", text.trim(), unit.plain()))?;
            }
            None => start.set_text(&self.description, name, text)?,
        }
        Ok(unit)
    }

    /// If `text` contains a unit, makes it the parameter's unit for reading and display.
    pub fn note_unit(&mut self, name: &str, text: &str) {
        let Ok(parameter) = self.description.parameter(name) else { return };
        if let Some(unit) = quantity_in(parameter.unit, text.trim()).and_then(|q| q.unit) {
            self.units.insert(parameter.name, unit.plain().into());
        }
    }
}

/// Written units of the parameters in the text of a machine's file.
fn units(text: &str, d: &Description) -> BTreeMap<String, String> {
    let Ok(root) = DeTable::parse(text) else { return BTreeMap::new() };
    let unit = |name: &str, si: &str| {
        quantity_in(si, written(root.get_ref(), name)?.get_ref().as_str()?.trim())?.unit
    };
    let all = d.parameters().into_iter();
    all.filter_map(|p| Some((unit(&p.name, p.unit)?.plain().to_owned(), p.name)))
        .map(|(unit, name)| (name, unit))
        .collect()
}

/// Byte range of each parameter's value in the text of a machine's file. Parameters that the text
/// does not contain are left out.
pub fn places(text: &str, d: &Description) -> BTreeMap<String, Range<usize>> {
    let Ok(root) = DeTable::parse(text) else { return BTreeMap::new() };
    let place = |name: String| Some((written(root.get_ref(), &name)?.span(), name));
    let all = d.parameters().into_iter().filter_map(|p| place(p.name));
    all.map(|(span, name)| (name, span)).collect()
}

/// Entry of the file for a parameter.
fn written<'t>(root: &'t DeTable<'t>, name: &str) -> Option<&'t Spanned<DeValue<'t>>> {
    let below = || {
        let (first, rest) = name.split_once('.').unwrap_or((name, ""));
        let begin = in_table(root, first)?;
        rest.split('.').filter(|part| !part.is_empty()).try_fold(begin, step)
    };
    let named = || in_table(root.get("parameters")?.get_ref().as_table()?, name);
    let found = below().or_else(named)?;
    // The level of a friction element may be a table with only a constant.
    found.get_ref().as_table().map_or(Some(found), |table| table.get("constant"))
}

/// Entry of a table for a part of a name, such as `harmonics[1]`.
fn in_table<'t>(table: &'t DeTable<'t>, part: &str) -> Option<&'t Spanned<DeValue<'t>>> {
    let (key, places) = split(part)?;
    let harmonic =
        || table.get("harmonics")?.get_ref().as_array()?.iter().next()?.get_ref().as_table()?.get(key);
    let offset = || table.get("offset").filter(|_| key == "constant");
    item(table.get(key).or_else(harmonic).or_else(offset)?, &places)
}

/// The key of a part of a name, and its indices: one in a list, two in a matrix.
fn split(part: &str) -> Option<(&str, Vec<usize>)> {
    let Some((key, places)) = part.split_once('[') else { return Some((part, Vec::new())) };
    let places = places.trim_end_matches(']').split(',').map(|place| place.parse().ok());
    Some((key, places.collect::<Option<_>>()?))
}

fn item<'t>(found: &'t Spanned<DeValue<'t>>, places: &[usize]) -> Option<&'t Spanned<DeValue<'t>>> {
    places.iter().try_fold(found, |found, &place| found.get_ref().as_array()?.get(place))
}

/// Entry for a part of a name below a value.
fn step<'t>(value: &'t Spanned<DeValue<'t>>, part: &str) -> Option<&'t Spanned<DeValue<'t>>> {
    let (key, places) = split(part)?;
    match value.get_ref() {
        DeValue::Table(table) => in_table(table, part),
        DeValue::Array(pair) => {
            let place = match key {
                "time" | "e" => 0,
                "height" | "f" => 1,
                _ => return None,
            };
            item(pair.get(place)?, &places)
        }
        // A signal given as a number.
        _ => item(Some(value).filter(|_| key == "constant")?, &places),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibro_machine::file::no_records;

    const TEXT: &str = r#"
        name = "M"
        gravity = "9.81 m/s2"
        parameters = { play = "8 mm", twice = "= 2 * play" }
        body.a = { mass = "350 g", gravity = 1.0, start = { s = "2 mm" } }
        body.table = { motion = { offset = "1 cm", amplitude = "3 mm", frequency = "600 rpm" } }
        [body.shaft]
        motion = { rate = "1500 rpm", steps = [["20 ms", "5 deg"]] }
        [body.disc]
        inertia = 2.0
        [spring.k]
        between = ["ground", "a"]
        stiffness = "2 N/mm"
        [spring.t]
        arms = { disc = "50 mm", a = 1.0 }
        stiffness = 3.0
        [friction.f]
        between = ["table", "a"]
        force = { constant = "4 kN" }
        [friction.g]
        between = ["shaft", "disc"]
        force = "4 N mm"
        [load.two]
        on = "a"
        harmonics = [{ amplitude = 1.0, frequency = "2 Hz" }, { amplitude = "3 kN", frequency = "4 Hz", phase = "5 deg" }]
        [load.one]
        on = "a"
        harmonics = [{ amplitude = "7 mN", frequency = "6 rad/s" }]
    "#;

    /// A number without a unit is in the parameter's written unit.
    #[test]
    fn a_bare_number_is_in_the_unit_of_the_files_number() {
        let machine = Machine::parse(TEXT, "m.toml", &no_records).unwrap();
        for (name, number, value) in [
            ("body.a.mass", "350", 0.35),
            ("body.a.start.s", "2", 0.002),
            ("body.table.motion.constant", "1", 0.01),
            ("body.table.motion.amplitude", "3", 0.003),
            ("body.table.motion.frequency", "600", 10.0),
            ("body.shaft.motion.steps[0].time", "20", 0.02),
            ("spring.k.stiffness", "2", 2000.0),
            ("spring.t.arms.disc", "50", 0.05),
            ("friction.f.force", "4", 4000.0),
            ("friction.g.force", "4", 0.004),
            ("load.two.harmonics[1].amplitude", "3", 3000.0),
            ("load.one.amplitude", "7", 0.007),
            ("play", "8", 0.008),
            // The file does not give a unit.
            ("spring.t.stiffness", "3", 3.0),
            ("load.two.harmonics[0].amplitude", "1", 1.0),
            ("body.disc.inertia", "2", 2.0),
        ] {
            let read = machine.quantity(name, number).unwrap();
            assert_eq!((read.value, machine.description.get(name).unwrap()), (value, value), "{name}");
        }
        for (name, angle) in [
            ("body.shaft.motion.rate", 1500.0 * std::f64::consts::TAU / 60.0),
            ("body.shaft.motion.steps[0].height", 5f64.to_radians()),
            ("load.two.harmonics[1].phase", 5f64.to_radians()),
            ("load.one.frequency", 6.0 / std::f64::consts::TAU),
        ] {
            let text = machine.description.get(name).unwrap();
            assert!((text - angle).abs() < 1e-14 * angle && machine.units.contains_key(name), "{name}");
            let number = machine.written_unit(name).unwrap().number(text).round().to_string();
            assert!((machine.quantity(name, &number).unwrap().value - angle).abs() < 1e-14 * angle, "{name}");
        }
    }

    /// A matrix's number is found by its row and column.
    #[test]
    fn golden_places_of_the_numbers_of_a_matrix() {
        let text = "name = \"M\"\n[body.b]\nmass = 1.0\n[block.c]\ninputs = [\"b.s\", \"b.v\"]\nd = [[-1.0, 2.5], [3.5, 4.5]]\n\
                    outputs = [\"y\", \"z\"]\n[spring.k]\nbetween = [\"ground\", \"b\"]\nstiffness = 9.5\n";
        let machine = Machine::parse(text, "m.toml", &no_records).unwrap();
        let places = places(text, &machine.description);
        let at = |name: &str| &text[places[name].clone()];
        assert_eq!(["block.c.d[0,1]", "block.c.d[1,0]", "body.b.mass"].map(at), ["2.5", "3.5", "1.0"]);
    }

    #[test]
    fn a_unit_beside_the_number_counts_and_is_that_of_the_numbers_after_it() {
        let mut machine = Machine::parse(TEXT, "m.toml", &no_records).unwrap();
        assert_eq!(machine.quantity("body.a.mass", "2 kg").unwrap().value, 2.0);
        machine.note_unit("body.a.mass", "2 kg");
        assert_eq!(machine.quantity("body.a.mass", "3").unwrap().value, 3.0);
        let refused = machine.quantity("body.a.start.s", "far").unwrap_err().to_string();
        assert!(refused.contains("body.a.start.s = \"far\""), "{refused}");
        assert!(machine.quantity("body.a.maß", "3").is_err());
    }

    #[test]
    fn a_file_that_is_read_is_its_text() {
        let path = Path::new(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../examples/assembly/damper_with_buffer.toml"
        ));
        let read = Machine::read(path).unwrap();
        assert_eq!(
            read,
            Machine::parse(&std::fs::read_to_string(path).unwrap(), "m.toml", &no_records).unwrap()
        );
        assert_eq!(read.told("stop.steel.gap", 4.5e-3), "4.5 mm");
        assert_eq!(read.unit("spring.mount.stiffness"), (1e-3, "kN/m".to_owned()));
        // In SI, and without a unit.
        let plain = Machine::new(read.description);
        assert_eq!(plain.told("spring.mount.damping", 60.0), "60 N·s/m");
        assert_eq!(plain.told("stop.steel.restitution", 0.7), "0.7");
    }
}
