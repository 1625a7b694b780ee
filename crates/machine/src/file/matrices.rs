//! Reading of matrices: rows in the file, CSV files and Matrix Market files.

use super::numbers::finite;
use super::reading::{Entry, Reading};
use super::records::stays_inside;
use crate::check::MOST_COORDINATES;
use crate::table::Table;
use nalgebra::DMatrix;

const ALLOWED: &str = "expected a Matrix Market file such as \"M.mtx\", a file of rows such as \"M.csv\", \
                       or a list of rows of finite numbers";

/// Reads a matrix.
pub(super) fn read(reading: &mut Reading, entry: &Entry) -> Option<DMatrix<f64>> {
    let found = match entry.value.as_str() {
        Some(path) => of_file(reading, path),
        None => rows(entry).ok_or_else(|| ALLOWED.to_owned()),
    };
    let found = found.and_then(|own| match own.nrows().max(own.ncols()) {
        size if size > MOST_COORDINATES => {
            Err(format!("has {size} rows or columns; expected at most {MOST_COORDINATES}"))
        }
        _ => Ok(own),
    });
    found.map_err(|text| reading.refuse(entry, text)).ok()
}

fn rows(entry: &Entry) -> Option<DMatrix<f64>> {
    let row = |row: &toml::Spanned<toml::de::DeValue>| -> Option<Vec<f64>> {
        row.get_ref().as_array()?.iter().map(|x| finite(x.get_ref())).collect()
    };
    of_rows(entry.value.as_array()?.iter().map(row).collect::<Option<_>>()?)
}

fn of_rows(rows: Vec<Vec<f64>>) -> Option<DMatrix<f64>> {
    let columns = rows.first()?.len();
    let even = columns > 0 && rows.iter().all(|row| row.len() == columns);
    even.then(|| DMatrix::from_row_iterator(rows.len(), columns, rows.iter().flatten().copied()))
}

fn of_file(reading: &Reading, path: &str) -> Result<DMatrix<f64>, String> {
    stays_inside(path)?;
    let text = (reading.records)(path).map_err(|e| super::unread(&e, ALLOWED))?;
    let is_market = path.to_ascii_lowercase().ends_with(".mtx");
    match is_market || text.get(..14).is_some_and(|start| start.eq_ignore_ascii_case("%%MatrixMarket")) {
        // Its errors begin with the number of a line, or with a blank.
        true => market(&text).map_err(|e| e.strip_prefix(' ').map_or(format!("line {e}"), str::to_owned)),
        false => csv(&text),
    }
}

/// Reads rows of numbers from a [table](Table) without a heading.
fn csv(text: &str) -> Result<DMatrix<f64>, String> {
    let table = Table::read(text);
    let columns = table.rows.first().map_or(0, |row| row.cells.len());
    if let Some(row) =
        table.rows.get(MOST_COORDINATES).or(table.rows.first().filter(|_| columns > MOST_COORDINATES))
    {
        let expected = format!("expected at most {MOST_COORDINATES} rows and columns");
        return Err(row.refused(&format!("is beyond the limit; {expected}")));
    }
    let rows = table.rows.iter().map(|row| table.numbers(row, columns)).collect::<Result<Vec<_>, _>>()?;
    of_rows(rows).ok_or_else(|| "it has no numbers; expected rows of finite numbers".into())
}

fn value(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite())
}

/// Entries across the diagonal of a Matrix Market file.
#[derive(Clone, Copy, PartialEq)]
enum Across {
    Given,
    Equal,
    Opposite,
}

/// Reads a matrix from a Matrix Market file with real or integer entries.
fn market(text: &str) -> Result<DMatrix<f64>, String> {
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    let header = lines.next().map_or("", |first| first.1).to_ascii_lowercase();
    let words: Vec<&str> = header.split_whitespace().collect();
    let ["%%matrixmarket", "matrix", layout, field, symmetry] = words[..] else {
        return Err("1: expected a heading such as %%MatrixMarket matrix coordinate real symmetric".into());
    };
    if !["coordinate", "array"].contains(&layout) {
        return Err(format!("1: {layout}: expected coordinate or array"));
    }
    if !["real", "integer"].contains(&field) {
        return Err(format!("1: {field}: expected real or integer entries"));
    }
    let across = match symmetry {
        "general" => Across::Given,
        "symmetric" => Across::Equal,
        "skew-symmetric" => Across::Opposite,
        _ => {
            return Err(format!("1: {symmetry}: expected a general, symmetric or skew-symmetric matrix"));
        }
    };
    let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('%'));
    let (number, sizes) = lines.next().ok_or(" it has no sizes")?;
    let sizes: Option<Vec<usize>> = sizes.split_whitespace().map(|word| word.parse().ok()).collect();
    let sizes = sizes.filter(|own| own.iter().take(2).all(|size| (1..=MOST_COORDINATES).contains(size)));
    if let Some([rows, columns, ..]) = sizes.as_deref().filter(|_| across != Across::Given)
        && rows != columns
    {
        return Err(format!("{number}: a {symmetry} matrix must be square"));
    }
    match (layout, sizes.as_deref()) {
        ("coordinate", Some(&[rows, columns, count])) => {
            of_entries(lines, DMatrix::zeros(rows, columns), count, across)
        }
        ("array", Some(&[rows, columns])) => of_columns(lines, DMatrix::zeros(rows, columns), across),
        _ => {
            let sizes = if layout == "array" { "ROWS COLUMNS" } else { "ROWS COLUMNS ENTRIES" };
            Err(format!(
                "{number}: expected the sizes of the matrix, {sizes}, with at most {MOST_COORDINATES} rows and columns"
            ))
        }
    }
}

fn put(a: &mut DMatrix<f64>, (i, j): (usize, usize), x: f64, across: Across) {
    a[(i, j)] = x;
    match across {
        Across::Given => {}
        Across::Equal => a[(j, i)] = x,
        Across::Opposite if i == j => {}
        Across::Opposite => a[(j, i)] = -x,
    }
}

fn of_entries<'l>(
    lines: impl Iterator<Item = (usize, &'l str)>,
    mut a: DMatrix<f64>,
    count: usize,
    across: Across,
) -> Result<DMatrix<f64>, String> {
    let mut seen = vec![false; a.len()];
    let mut found = 0;
    for (number, line) in lines {
        let words: Vec<&str> = line.split_whitespace().collect();
        let place = |word: &str, most: usize| {
            word.parse().ok().filter(|k| (1..=most).contains(k)).map(|k: usize| k - 1)
        };
        let entry = match words[..] {
            [i, j, x] => place(i, a.nrows()).zip(place(j, a.ncols())).zip(value(x)),
            _ => None,
        };
        let Some(((i, j), x)) =
            entry.filter(|((i, j), _)| across == Across::Given || j <= i && *i < a.ncols())
        else {
            return Err(format!(
                "{number}: {line}: expected row, column (both counted from 1) and a finite number; \
                 entries of a symmetric or skew-symmetric matrix must be on or below the diagonal"
            ));
        };
        if std::mem::replace(&mut seen[i * a.ncols() + j], true) {
            return Err(format!("{number}: {line}: this entry is given twice"));
        }
        put(&mut a, (i, j), x, across);
        found += 1;
    }
    match found == count {
        true => Ok(a),
        false => Err(format!(
            " it has {}; expected {count}, the number in its line of sizes",
            if found == 1 { "1 entry".into() } else { format!("{found} entries") }
        )),
    }
}

fn of_columns<'l>(
    lines: impl Iterator<Item = (usize, &'l str)>,
    mut a: DMatrix<f64>,
    across: Across,
) -> Result<DMatrix<f64>, String> {
    let mut lines = lines;
    let first = |j: usize| match across {
        Across::Given => 0,
        Across::Equal => j,
        Across::Opposite => j + 1,
    };
    for j in 0..a.ncols() {
        for i in first(j)..a.nrows() {
            let (number, line) = lines.next().ok_or(" it has fewer numbers than its line of sizes gives")?;
            let x = value(line).ok_or_else(|| format!("{number}: {line}: expected a finite number"))?;
            put(&mut a, (i, j), x, across);
        }
    }
    match lines.next() {
        None => Ok(a),
        Some((number, _)) => Err(format!("{number}: the file has more numbers than its line of sizes gives")),
    }
}
