//! Parameter files: TOML with a table `[si]` of structured names, a table `[groups]`, or both.
//!
//! ```toml
//! [si]
//! box.m = 2.0
//! stop.gap = 0.01
//!
//! [groups]
//! f10 = 1.5
//! ```

use crate::{Error, Result};
use std::path::Path;
use vibro_analysis::{Name, ParameterSet, find_field, find_group, number};

/// Applies a parameter file to a parameter set: first `[si]`, then `[groups]`.
///
/// # Errors
/// [`Error::File`] and [`Error::Config`]; both name the file. Nothing is changed then.
pub fn read(set: &mut ParameterSet, path: &Path) -> Result<()> {
    let text = std::fs::read_to_string(path).map_err(Error::file("reading", path))?;
    apply(set, &text)
        .map_err(|e| Error::Config { path: path.into(), problem: e.to_string().trim_end().into() })
}

/// Applies the text of a parameter file.
///
/// # Errors
/// [`Error::Output`] for what is not TOML, [`vibro_analysis::Error::Form`] for other tables, and as
/// [`ParameterSet::assign`].
pub fn apply(set: &mut ParameterSet, text: &str) -> Result<()> {
    let table: toml::Table = text.parse().map_err(Error::output("sense of the file"))?;
    if let Some(key) = table.keys().find(|k| !["si", "groups"].contains(&k.as_str())) {
        return Err(Error::form(key, "the tables [si] and [groups] and nothing else"));
    }
    let si = |name: &str| find_field(name).map(Name::Si);
    let group = |name: &str| find_group(name).map(Name::Group);
    let mut assignments = Vec::new();
    if let Some(value) = table.get("si") {
        collect("", value, &si, &mut assignments)?;
    }
    if let Some(value) = table.get("groups") {
        collect("", value, &group, &mut assignments)?;
    }
    Ok(set.assign(&assignments)?)
}

/// Flattens nested tables to structured names: `m` in the table `box` is `box.m`.
fn collect(
    prefix: &str,
    value: &toml::Value,
    find: &dyn Fn(&str) -> vibro_analysis::Result<Name>,
    into: &mut Vec<(Name, f64)>,
) -> vibro_analysis::Result<()> {
    if let toml::Value::Table(table) = value {
        for (key, value) in table {
            let name = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
            collect(&name, value, find, into)?;
        }
        return Ok(());
    }
    let name = find(prefix)?;
    let value = match value {
        toml::Value::Float(x) => *x,
        toml::Value::Integer(i) => *i as f64,
        other => number(name, &other.to_string())?,
    };
    into.push((name, value));
    Ok(())
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
    fn what_is_no_parameter_file_is_refused_by_name() {
        let error = |text: &str| apply(&mut ParameterSet::basic(), text).unwrap_err().to_string();
        assert!(error("[si]\nkappa = 1").contains("no parameter is named `kappa`; the nearest is"));
        assert!(error("[groups]\nbox.m = 1").contains("no parameter is named `box.m`"));
        assert!(error("[group]\nf10 = 1").contains("[si] and [groups]"));
        assert_eq!(
            error("[groups]\nkappa = \"high\""),
            "kappa = `\"high\"` is not a number: allowed is 0 <= kappa <= 1"
        );
        assert!(error("[groups\nf10 = 1").contains("line 1"));
    }
}
