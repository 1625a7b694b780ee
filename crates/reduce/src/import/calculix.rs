//! CalculiX's files of `*FREQUENCY, SOLVER=MATRIXSTORAGE`: `.sti`, `.mas` and `.dof`.

use super::words::{lines, number, refused, row, whole};
use super::{Matrix, Names};
use crate::dofs::Dof;
use crate::sparse::{Entry, Listed};
use crate::{Error, Result};

const ENTRY: &str = "expected row, column (both counted from 1) and a finite number";
const DOF: &str = "expected a name such as 428.1 or 428.x: node and direction (1 to 6, x, y, z, rx, ry, rz). \
                   Temperatures and pressures are not reduced";

/// Reads `row column value` from each line.
///
/// # Errors
/// An error with the line for anything else, and for a file without entries.
pub fn matrix(text: &str, file: &str) -> Result<Matrix> {
    whole(text, file)?;
    let (mut entries, mut count) = (Vec::new(), 0);
    for (line, text) in lines(text) {
        let mut words = text.split_ascii_whitespace();
        let Some(first) = words.next() else { continue };
        let entry = || {
            let (row, column) = (row(first)?, row(words.next()?)?);
            let value = number(words.next()?)?;
            words.next().is_none().then_some(Entry { row, column, value })
        };
        let entry = { entry }().ok_or_else(|| refused(file, line, text, ENTRY))?;
        count = count.max(entry.row.max(entry.column) + 1);
        entries.push(entry);
    }
    if entries.is_empty() {
        return Err(Error::new(file, "it has no entries"));
    }
    let names = Names::Rows(count);
    Ok(Matrix { file: file.into(), entries, listed: Listed::Either, names, penalty: f64::INFINITY })
}

/// Reads the name of a dof from each line, in the order of the rows.
///
/// # Errors
/// An error with the line for anything else, and for a file without names.
pub fn dofs(text: &str, file: &str) -> Result<Vec<Dof>> {
    whole(text, file)?;
    let mut found = Vec::new();
    for (line, text) in lines(text).filter(|(_, text)| !text.trim().is_empty()) {
        let words: Vec<&str> = text.split([' ', '\t', ',']).filter(|word| !word.is_empty()).collect();
        let dof = match words[..] {
            [name] => Dof::read(name),
            [node, direction] => Dof::read(&format!("{node}.{direction}")),
            _ => None,
        };
        found.push(dof.ok_or_else(|| refused(file, line, text, DOF))?);
    }
    if found.is_empty() { Err(Error::new(file, "it names no dofs")) } else { Ok(found) }
}
