//! Parameter files: TOML with a table `[si]` of structured names, a table `[groups]`, or both.
//!
//! ```toml
//! [si]
//! box.m = 2.0
//! stop.gap = "10 mm"
//!
//! [groups]
//! f10 = 1.5
//! ```

use crate::{Error, Result};
use std::path::Path;
use vibro_studies::paper::{
    GROUPS, Name, ParameterSet, Unit, find_field, find_group, number, physical_parameters, typed_unit,
};

/// Tables of a parameter file.
const TABLES: [&str; 2] = ["si", "groups"];

/// Applies a parameter file to a parameter set: first `[si]`, then `[groups]`.
///
/// # Errors
/// [`Error::File`] if the file cannot be read; [`Error::Config`] with the file if its content is
/// not valid. After an error the parameter set is unchanged.
pub fn read(set: &mut ParameterSet, path: &Path) -> Result<()> {
    let text = std::fs::read_to_string(path).map_err(Error::file("reading", path))?;
    apply(set, &text)
        .map_err(|e| Error::Config { path: path.into(), problem: e.to_string().trim_end().into() })
}

/// Whether a file has the tables of a parameter file and no others.
pub fn is_at(path: &Path) -> bool {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let table = text.parse::<toml::Table>().unwrap_or_default();
    !table.is_empty() && table.keys().all(|key| TABLES.contains(&key.as_str()))
}

/// Applies the text of a parameter file.
///
/// # Errors
/// [`Error::Output`] if the text is not TOML; [`vibro_studies::Error::Form`] if it has other
/// tables; the errors of [`ParameterSet::assign`].
pub fn apply(set: &mut ParameterSet, text: &str) -> Result<()> {
    let table: toml::Table = text.parse().map_err(|error| explained(text, &error))?;
    if let Some(key) = table.keys().find(|k| !TABLES.contains(&k.as_str())) {
        return Err(Error::form(
            key,
            "only the tables [si] and [groups]; give a machine's file without --config: `vibro run FILE`",
        ));
    }
    let si = |name: &str| match Name::find(name) {
        Ok(Name::Group(_)) if find_field(name).is_err() => {
            Err(misplaced(name, "a group: it belongs in [groups]"))
        }
        _ => find_field(name).map(Name::Si),
    };
    let group = |name: &str| match Name::find(name) {
        Ok(Name::Si(_)) => Err(misplaced(name, "a physical parameter: it belongs in [si]")),
        _ => find_group(name).map(Name::Group),
    };
    let mut assignments = Vec::new();
    if let Some(value) = table.get("si") {
        collect("", value, &si, &mut assignments)?;
    }
    if let Some(value) = table.get("groups") {
        collect("", value, &group, &mut assignments)?;
    }
    set.assign(&assignments.iter().map(|a| (a.0, a.1)).collect::<Vec<_>>())?;
    assignments.into_iter().for_each(|(name, _, unit)| set.show_in(name, unit));
    Ok(())
}

/// Flattens nested tables to structured names: `m` in the table `box` is `box.m`. Each value keeps
/// its written unit.
fn collect(
    prefix: &str,
    value: &toml::Value,
    find: &dyn Fn(&str) -> vibro_studies::Result<Name>,
    into: &mut Vec<(Name, f64, Option<&'static Unit>)>,
) -> vibro_studies::Result<()> {
    if let toml::Value::Table(table) = value {
        for (key, value) in table {
            let name = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
            collect(&name, value, find, into)?;
        }
        return Ok(());
    }
    let name = find(prefix)?;
    let (value, unit) = match value {
        toml::Value::Float(x) => (*x, None),
        toml::Value::Integer(i) => (*i as f64, None),
        toml::Value::String(text) => (number(name, text)?, typed_unit(name, text)),
        other => (number(name, &other.to_string())?, None),
    };
    into.push((name, value, unit));
    Ok(())
}

fn misplaced(name: &str, what: &str) -> vibro_studies::Error {
    vibro_studies::Error::UnknownName { name: name.into(), advice: format!("in this table: it is {what}") }
}

/// Error for a text that is not TOML. In the most common case, a number with a unit but without
/// quotation marks, the error names the parameter; the parser's own error would take a unit that
/// begins with `t` for the beginning of `true`.
fn explained(text: &str, error: &toml::de::Error) -> Error {
    let explain = || -> Option<Error> {
        let before = text.get(..error.span()?.start)?;
        let line = text.lines().nth(before.matches('\n').count())?;
        let (key, value) = line.split_once('=')?;
        let value = value.split('#').next().unwrap_or_default().trim();
        let plain = !value.is_empty() && !value.contains(['"', '\'', '[', '{', '=']);
        let name = Name::find(key.trim()).ok().filter(|_| plain)?;
        let problem = match number(name, value) {
            Ok(_) => format!("{} = {value}: a number with a unit requires quotation marks", name.name()),
            Err(error) => error.to_string(),
        };
        Some(Error::Refused { what: format!("line {}", before.matches('\n').count() + 1), problem })
    };
    explain().unwrap_or_else(|| Error::output("sense of the file")(error))
}

/// Parameter file with every parameter of one form: meaning, unit, allowed values, default.
pub fn template(groups: bool) -> String {
    let set = ParameterSet::basic();
    let mut text = String::from(
        "# Parameters of vibro. A parameter that is left out or commented out has its default: \
         a\n# reconstruction of the paper's machine, not its own data.\n",
    );
    let names: Vec<Name> = if groups {
        text.push_str("# Dimensionless groups. The machine in SI: vibro paper template --si\n\n[groups]\n");
        GROUPS.iter().map(Name::Group).collect()
    } else {
        text.push_str(
            "# A number is in the unit shown; a number with another unit requires quotation marks, e.g. \"48 kN/m\", \"2.5 mm\",\n\
             # \"350 g\", \"10 Hz\". Dimensionless groups: vibro paper template --groups\n\n[si]\n",
        );
        physical_parameters().map(Name::Si).collect()
    };
    for name in names {
        let unit = if name.unit() == "1" { "no unit" } else { name.unit() };
        // `alpha23` and `beta2` name one coupling: only one can be set.
        let second = if name.name() == "beta2" { "# " } else { "" };
        let (description, allowed) = (name.description(), name.allowed());
        let value = name.value(&set);
        text.push_str(&format!("# {description}; {unit}; {allowed}\n{second}{} = {value:?}\n", name.name()));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_hold_both_forms() {
        let mut set = ParameterSet::basic();
        apply(&mut set, "[si]\nbox.m = 2\nbox.k = 8.0\n[si.stop]\ngap = 0.01\n[groups]\nf10 = 1.25\n")
            .unwrap();
        assert_eq!((set.parameters().box_mass, set.parameters().stop_gap), (2.0, 0.01));
        assert_eq!(set.groups().f10, 1.25);
    }

    #[test]
    fn units_are_understood() {
        let mut set = ParameterSet::basic();
        apply(&mut set, "[si]\nbox.k = \"48 kN/m\"\nm1 = \"12 kg\"\ndrive.frequency = \"10 Hz\"\n").unwrap();
        let p = set.parameters();
        assert_eq!((p.box_stiffness, p.box_mass), (48_000.0, 12.0));
        assert_eq!(p.drive_frequency, 10.0 * std::f64::consts::TAU);
    }

    #[test]
    fn templates_come_back_as_the_default_set() {
        for groups in [false, true] {
            let mut set = ParameterSet::basic();
            apply(&mut set, &template(groups)).unwrap();
            let names = GROUPS.iter().map(Name::Group).chain(physical_parameters().map(Name::Si));
            for name in names {
                let (found, expected) = (name.value(&set), name.value(&ParameterSet::basic()));
                assert!((found - expected).abs() <= 1e-14 * (1.0 + expected.abs()), "{}", name.name());
            }
            // Every parameter of the form is listed with its range.
            let text = template(groups);
            let told =
                |name: Name| text.contains(&format!("{} = ", name.name())) && text.contains(name.allowed());
            assert!(if groups {
                GROUPS.iter().map(Name::Group).all(told)
            } else {
                physical_parameters().map(Name::Si).all(told)
            });
            assert_eq!(set.not_given(), []);
        }
    }

    #[test]
    fn what_is_no_parameter_file_is_refused_by_name() {
        let error = |text: &str| apply(&mut ParameterSet::basic(), text).unwrap_err().to_string();
        assert!(error("[si]\nkappa = 1").ends_with("it is a group: it belongs in [groups]"));
        assert!(error("[groups]\nbox.m = 1").contains("no parameter is named `box.m`"));
        assert!(error("[group]\nf10 = 1").contains("[si] and [groups]"));
        assert_eq!(
            error("[groups]\nkappa = \"high\""),
            "kappa = `high` is not a number: expected 0 <= kappa <= 1"
        );
        assert_eq!(
            error("[si]\nbox.m = twelve"),
            "line 2: box.m = `twelve` is not a number: expected a finite number > 0"
        );
        assert!(
            error("[si]\nbox.k = 48 kN/m # stiff")
                .contains("line 2: box.k = 48 kN/m: a number with a unit requires")
        );
        assert!(
            error("[si]\nbox.m = \"12 mm\"")
                .contains("box.m: `mm` is not one of its units; expected one of kg, g, mg, t, lb")
        );
        assert!(error("[groups\nf10 = 1").contains("line 1"));
    }
}
