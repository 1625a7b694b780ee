//! Designs from a CSV file: a header with names of parameters, and a row of numbers for each
//! design.
//!
//! ```csv
//! block.m,stop.gap,stop.restitution
//! 1.2 kg,10 mm,0.6
//! 0.8,0.012,0.75
//! ```
//!
//! A cell is a number with or without a unit. A number without a unit is in the unit of its
//! heading (`stop.gap [mm]`). If the heading has no unit either, the number is in the unit that
//! the parameter file or `--set` used; otherwise in SI. The file is a [`Table`]. A number outside
//! its parameter's range is accepted here; its row in the sweep's table then says why the design
//! could not be computed.

use crate::table::read_text;
use crate::{Error, Result};
use std::path::Path;
use vibro_machine::table::{Heading, Table};
use vibro_numerics::digest::fnv1a;
use vibro_studies::design_sweep::Designs;
use vibro_studies::paper::{Name, ParameterSet};

/// Largest number of designs in a file. The manifest of the parts holds all designs.
const MOST: usize = 100_000;

/// Reads designs of a machine.
///
/// # Errors
/// [`Error::File`] if the file cannot be read; [`Error::Config`] if a name is unknown, a cell is
/// not a finite number, a row and the header have different lengths, or the file has no design or
/// too many; with the line, except for a file with no design or too many.
pub fn read(path: &Path, set: &ParameterSet) -> Result<Designs<Name>> {
    let text = read_text(path)?;
    parse(&text, set).map_err(|problem| Error::Config { path: path.into(), problem })
}

fn parse(text: &str, set: &ParameterSet) -> std::result::Result<Designs<Name>, String> {
    let (table, mut rows) = (Table::read(text), Vec::new());
    let headings = table.names();
    let name = |own: &Heading| {
        let found = Name::find(own.name).map_err(|e| format!("line {}: {e}", table.rows[0].line))?;
        own.unit(found.unit()).map_err(|text| table.rows[0].refused(&text))?;
        Ok(found)
    };
    let names = headings.iter().map(name).collect::<std::result::Result<Vec<_>, String>>()?;
    for row in table.rows.iter().skip(1) {
        table.check(row, names.len())?;
        let cell = |((name, heading), text): ((&Name, &Heading), &&str)| {
            let line = row.line;
            let text = match (heading.unit, text.parse::<f64>()) {
                (Some(unit), Ok(_)) => format!("{text} {unit}"),
                _ => (*text).to_owned(),
            };
            let value = set.quantity(*name, &text).map_err(|e| format!("line {line}: {e}"))?.value;
            let infinite = || format!("line {line}: {} = {text}: expected {}", name.name(), name.allowed());
            if value.is_finite() { Ok(value) } else { Err(infinite()) }
        };
        let values = names.iter().zip(&headings).zip(&row.cells).map(cell);
        rows.push(values.collect::<std::result::Result<Vec<_>, _>>()?);
        if rows.len() > MOST {
            return Err(format!("more than {MOST} designs"));
        }
    }
    if rows.is_empty() {
        return Err("no design: expected a header with names of parameters and rows of numbers".into());
    }
    Ok(Designs::Rows { names, rows })
}

/// Description of the designs for manifests; it depends only on names and values.
pub fn in_words(names: &[Name], rows: &[Vec<f64>]) -> String {
    let names: Vec<_> = names.iter().map(|n| n.name()).collect();
    let bytes: Vec<u8> = rows.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    format!("{} designs of {}, digest {:016x}", rows.len(), names.join(", "), fnv1a(&bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn designs_are_read_with_units() {
        let text = "\u{feff}m2, stop.gap\n# two of the same\n1.2 kg, 10 mm\n1.2,0.01\n";
        let Ok(Designs::Rows { names, rows }) = parse(text, &ParameterSet::basic()) else {
            panic!("no rows")
        };
        assert_eq!(names.iter().map(|n| n.name()).collect::<Vec<_>>(), ["block.m", "stop.gap"]);
        assert_eq!(rows, [[1.2, 0.01], [1.2, 0.01]]);
        // A number without a unit is in the parameter's written unit.
        let mut set = ParameterSet::basic();
        set.apply(&["stop.gap=5 mm"]).unwrap();
        let Ok(Designs::Rows { rows, .. }) = parse("stop.gap,block.m\n10,1.2\n1 cm,1.2\n", &set) else {
            panic!()
        };
        assert_eq!(rows, [[0.01, 1.2], [0.01, 1.2]]);
        let Ok(Designs::Rows { rows, .. }) = parse("stop.gap [cm];block.m (g)\n1;1200\n10 mm;1.2 kg\n", &set)
        else {
            panic!()
        };
        assert_eq!(rows, [[0.01, 1.2], [0.01, 1.2]]);
    }

    #[test]
    fn what_is_no_list_of_designs_is_refused_with_the_line() {
        for (text, expected) in [
            ("stop.gape\n1\n", "line 1: no parameter is named `stop.gape`; did you mean `stop.gap`?"),
            ("stop.gap\n1\nwide\n", "line 3: stop.gap = `wide` is not a number"),
            ("stop.gap\n1kg\n", "line 2: stop.gap: `kg` is not one of its units"),
            ("stop.gap\nNaN\n", "line 2: stop.gap = NaN: expected"),
            ("stop.gap,block.m\n1\n", "line 2: `1` has 1 cell; expected 2 cells"),
            ("stop.gap [kg]\n1\n", "line 1: `stop.gap` has the unit `kg`; expected one of m, "),
            ("stop.gap\n", "no design"),
            ("", "no design"),
        ] {
            let error = parse(text, &ParameterSet::basic()).unwrap_err();
            assert!(error.contains(expected), "{text:?}: {error}");
        }
    }
}
