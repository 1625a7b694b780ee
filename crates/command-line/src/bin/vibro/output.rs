//! Output to the screen.

use crate::common_arguments::Common;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use vibro::studies::Study;
use vibro::subject::Subject;
use vibro::table::TextTable;
use vibro::{Error, Result};

/// Prints the content and place of each picture, remarks, parameters, and tables for the screen.
pub fn print(studies: &[Study], subject: &dyn Subject, folder: &Path, common: &Common) -> Result<()> {
    let mut text = String::new();
    let drawn: Vec<&str> = studies.iter().filter(|s| s.figure.is_some()).map(|s| s.name.as_str()).collect();
    // Writing to a string cannot fail.
    let _ = match studies {
        [one] => writeln!(text, "{}", first_line(one, folder)),
        _ if drawn.is_empty() => writeln!(text, "wrote tables into {}:", folder.display()),
        _ => writeln!(text, "drew {} into {} as SVG and PNG, with CSV:", drawn.join(", "), folder.display()),
    };
    text.push_str(&apart(folder, common));
    for study in studies {
        if studies.len() > 1 {
            let _ = writeln!(text, "{}: {}", study.name, study.what);
        }
        for remark in &study.remarks {
            let _ = writeln!(text, "  {remark}");
        }
    }
    let own = studies.iter().find_map(|study| study.subject.clone());
    let _ = writeln!(text, "parameters: {}", own.unwrap_or_else(|| subject.caption()));
    for table in studies.iter().filter_map(|s| s.shown.as_ref()) {
        text.push('\n');
        text.push_str(&side_by_side(table));
    }
    say(text.trim_end_matches('\n'))
}

/// A line that explains why results have a separate folder; empty if they do not.
pub fn apart(folder: &Path, common: &Common) -> String {
    if folder == common.out {
        return String::new();
    }
    let out = common.out.display();
    format!("{out} holds results of other parameters; the new results are in {}\n", folder.display())
}

/// Prints a line to standard output.
pub fn say(words: &str) -> Result<()> {
    crate::progress::clear();
    match std::io::stdout().write_all(format!("{words}\n").as_bytes()) {
        // The reader closed the pipe, as `head` does.
        Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        other => other.map_err(Error::file("writing", Path::new("standard output"))),
    }
}

fn first_line(study: &Study, folder: &Path) -> String {
    let stem = folder.join(&study.name);
    let tables = study.tables.iter().map(|t| format!("{}.csv", t.0)).chain(study.files.iter().cloned());
    let tables: Vec<_> = tables.map(|name| folder.join(name).display().to_string()).collect();
    match study.figure {
        Some(_) => {
            format!("drew {} into {}.svg and .png, with {}", study.what, stem.display(), tables.join(", "))
        }
        None => format!("{}; numbers in {}", study.what, tables.join(", ")),
    }
}

/// The long table (quantity, unit, theory, root, value) with a column for each theory and root.
fn side_by_side(table: &TextTable) -> String {
    let mut columns: Vec<(&str, &str)> = Vec::new();
    let mut quantities: Vec<(&str, &str)> = Vec::new();
    for row in &table.rows {
        let (quantity, column) = ((row[0].as_str(), row[1].as_str()), (row[2].as_str(), row[3].as_str()));
        if !columns.contains(&column) {
            columns.push(column);
        }
        if !quantities.contains(&quantity) {
            quantities.push(quantity);
        }
    }
    let cell = |quantity: (&str, &str), column: (&str, &str)| {
        let same = |r: &&Vec<String>| {
            (r[0].as_str(), r[2].as_str(), r[3].as_str()) == (quantity.0, column.0, column.1)
        };
        table.rows.iter().find(same).map_or(String::new(), |r| readable(&r[4]))
    };
    let mut text = format!("{:34}", "");
    for (theory, root) in &columns {
        let _ = write!(text, "{:>24}", format!("{theory}, {root}"));
    }
    for quantity in quantities {
        let name = if quantity.1.is_empty() {
            quantity.0.into()
        } else {
            format!("{} [{}]", quantity.0, quantity.1)
        };
        let _ = write!(text, "\n{name:34}");
        for column in &columns {
            let _ = write!(text, "{:>24}", cell(quantity, *column));
        }
    }
    text.push('\n');
    text
}

/// A number with ten digits; other text unchanged.
fn readable(value: &str) -> String {
    match value.parse::<f64>() {
        Ok(x) if x == 0.0 || (1e-4..1e6).contains(&x.abs()) => format!("{x:.9}"),
        Ok(x) => format!("{x:.9e}"),
        Err(_) => value.into(),
    }
}
