//! Designs from a CSV file: a header with names of parameters, and a row of numbers for each
//! design.
//!
//! ```csv
//! block.m,stop.gap,stop.restitution
//! 1.2 kg,10 mm,0.6
//! 0.8,0.012,0.75
//! ```
//!
//! A cell is a number with or without a unit. A number without a unit is in the unit that the
//! machine's file or `--set` used for the parameter, otherwise in SI. A number outside its
//! parameter's range is accepted here; in the sweep's table, the row of that design gives the
//! reason.

use crate::{Error, Result};
use std::path::Path;
use vibro_analysis::design_sweep::Designs;
use vibro_analysis::{Name, ParameterSet};
use vibro_impact::numerics::digest::fnv1a;

/// Largest number of designs in a file. The manifest of the parts holds all designs.
const MOST: usize = 100_000;

/// Reads designs of a machine.
///
/// # Errors
/// [`Error::File`] if the file cannot be read; [`Error::Config`] with the line if a name is
/// unknown, a cell is not a finite number, a row and the header have different lengths, or the file
/// has no design or too many.
pub fn read(path: &Path, set: &ParameterSet) -> Result<Designs> {
    let text = std::fs::read(path).map_err(Error::file("reading", path))?;
    parse(&text, set).map_err(|problem| Error::Config { path: path.into(), problem })
}

fn parse(text: &[u8], set: &ParameterSet) -> std::result::Result<Designs, String> {
    // Byte order mark, which some spreadsheets write.
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let mut csv = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text);
    let header = csv.headers().map_err(|e| e.to_string())?.clone();
    let names = header.iter().map(|name| Name::find(name).map_err(|e| format!("line 1: {e}")));
    let names = names.collect::<std::result::Result<Vec<_>, _>>()?;
    let mut rows = Vec::new();
    for record in csv.records() {
        let record = record.map_err(|e| e.to_string())?;
        let line = record.position().map_or(0, csv::Position::line);
        let cell = |(name, text): (&Name, &str)| {
            let value = set.quantity(*name, text).map_err(|e| format!("line {line}: {e}"))?.value;
            let infinite = || format!("line {line}: {} = {text}: allowed is {}", name.name(), name.allowed());
            if value.is_finite() { Ok(value) } else { Err(infinite()) }
        };
        rows.push(names.iter().zip(record.iter()).map(cell).collect::<std::result::Result<Vec<_>, _>>()?);
        if rows.len() > MOST {
            return Err(format!("more than {MOST} designs"));
        }
    }
    if rows.is_empty() {
        return Err("no design: expected are a header with names of parameters and rows of numbers".into());
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
        let Ok(Designs::Rows { names, rows }) = parse(text.as_bytes(), &ParameterSet::basic()) else {
            panic!("no rows")
        };
        assert_eq!(names.iter().map(|n| n.name()).collect::<Vec<_>>(), ["block.m", "stop.gap"]);
        assert_eq!(rows, [[1.2, 0.01], [1.2, 0.01]]);
        // A number without a unit is in the unit in which its parameter was written.
        let mut set = ParameterSet::basic();
        set.apply(&["stop.gap=5 mm"]).unwrap();
        let Ok(Designs::Rows { rows, .. }) = parse(b"stop.gap,block.m\n10,1.2\n1 cm,1.2\n", &set) else {
            panic!()
        };
        assert_eq!(rows, [[0.01, 1.2], [0.01, 1.2]]);
    }

    #[test]
    fn what_is_no_list_of_designs_is_refused_with_the_line() {
        for (text, expected) in [
            ("stop.gape\n1\n", "line 1: no parameter is named `stop.gape`; the nearest is `stop.gap`"),
            ("stop.gap\n1\nwide\n", "line 3: stop.gap = `wide` is not a number"),
            ("stop.gap\n1kg\n", "line 2: stop.gap: `kg` is no unit of it"),
            ("stop.gap\nNaN\n", "line 2: stop.gap = NaN: allowed is"),
            ("stop.gap,block.m\n1\n", "line: 2"),
            ("stop.gap\n", "no design"),
            ("", "no design"),
        ] {
            let error = parse(text.as_bytes(), &ParameterSet::basic()).unwrap_err();
            assert!(error.contains(expected), "{text:?}: {error}");
        }
    }
}
