//! Matrix Market files, sparse or dense.

use super::words::{lines, number, refused, row};
use super::{Matrix, Names};
use crate::sparse::{Entry, Listed};
use crate::{Error, Result};

const ENTRY: &str = "expected row, column (both counted from 1, at most the size) and a finite number; entries of a \
                     symmetric matrix must be on or below the diagonal";

/// Reads a real symmetric or general square matrix.
///
/// # Errors
/// An error with the line for another matrix, a wrong number of entries, and entries that are not
/// numbers.
pub fn matrix(text: &str, file: &str) -> Result<Matrix> {
    let mut lines = lines(text);
    let (_, heading) = lines.next().unwrap_or((1, ""));
    let words = heading.to_ascii_lowercase();
    let words: Vec<&str> = words.split_whitespace().collect();
    let ["%%matrixmarket", "matrix", layout, "real" | "integer", symmetry] = words[..] else {
        let expected = "expected a heading such as %%MatrixMarket matrix coordinate real symmetric";
        return Err(refused(file, 1, heading, expected));
    };
    let listed = match symmetry {
        "symmetric" => Listed::Once,
        "general" => Listed::Both,
        _ => return Err(refused(file, 1, heading, "expected a symmetric or general matrix")),
    };
    let mut lines = lines.filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('%'));
    let (line, sizes) = lines.next().ok_or_else(|| Error::new(file, "it has no sizes"))?;
    let numbers: Vec<usize> = sizes.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let (count, columns) = match (layout, &numbers[..]) {
        ("coordinate", [rows, columns, _]) | ("array", [rows, columns]) => (*rows, *columns),
        _ => return Err(refused(file, line, sizes, &format!("expected the sizes of a {layout} matrix"))),
    };
    if count != columns || count == 0 {
        return Err(refused(file, line, sizes, "expected a square matrix"));
    }
    let entries = match layout {
        "coordinate" => coordinates(lines, file, count, numbers[2], listed)?,
        _ => columns_of(lines, file, count, listed)?,
    };
    let names = Names::Rows(count);
    Ok(Matrix { file: file.into(), entries, listed, names, penalty: f64::INFINITY })
}

fn coordinates<'t>(
    lines: impl Iterator<Item = (usize, &'t str)>,
    file: &str,
    count: usize,
    expected: usize,
    listed: Listed,
) -> Result<Vec<Entry>> {
    let mut entries = Vec::new();
    for (line, text) in lines {
        let words: Vec<&str> = text.split_whitespace().collect();
        let entry = match words[..] {
            [i, j, x] => row(i).zip(row(j)).zip(number(x)),
            _ => None,
        };
        let is_inside = |i: usize, j: usize| i.max(j) < count && (listed == Listed::Both || j <= i);
        match entry.filter(|((i, j), _)| is_inside(*i, *j)) {
            Some(((row, column), value)) => entries.push(Entry { row, column, value }),
            None => return Err(refused(file, line, text, ENTRY)),
        }
    }
    if entries.len() != expected {
        let found = entries.len();
        return Err(Error::new(
            file,
            format!("it has {found} entries; expected {expected}, as given with its sizes"),
        ));
    }
    Ok(entries)
}

/// Entries of a dense matrix by columns, without zeros.
fn columns_of<'t>(
    mut lines: impl Iterator<Item = (usize, &'t str)>,
    file: &str,
    count: usize,
    listed: Listed,
) -> Result<Vec<Entry>> {
    let mut entries = Vec::new();
    for column in 0..count {
        let first = if listed == Listed::Once { column } else { 0 };
        for row in first..count {
            let (line, text) = lines.next().ok_or_else(|| Error::new(file, "it has too few numbers"))?;
            let value = number(text).ok_or_else(|| refused(file, line, text, "expected a finite number"))?;
            if value != 0.0 {
                entries.push(Entry { row, column, value });
            }
        }
    }
    match lines.next() {
        None => Ok(entries),
        Some((line, text)) => Err(refused(file, line, text, "it has too many numbers")),
    }
}
