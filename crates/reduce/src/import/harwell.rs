//! Harwell-Boeing files of assembled real matrices, as Ansys writes them by `HBMAT`, and Ansys'
//! mapping of equations to dofs.

use super::words::{lines, number, refused};
use super::{Matrix, Names};
use crate::dofs::{Direction, Dof};
use crate::sparse::{Entry, Listed};
use crate::{Error, Result};

/// Fields on a line and their width, of a format such as `(4E20.12)` or `(1P,3D25.16)`.
fn format(text: &str) -> Option<(usize, usize)> {
    let text: String = text.to_ascii_uppercase().chars().filter(|c| !"() ".contains(*c)).collect();
    // A scale factor, `1P`, with or without a comma.
    let own = match text.split_once('P') {
        Some((scale, own)) if scale.chars().all(|c| c.is_ascii_digit()) => own.trim_start_matches(','),
        _ => &text,
    };
    let at = own.find(['I', 'E', 'D', 'F', 'G'])?;
    let count = if at == 0 { 1 } else { own[..at].parse().ok()? };
    let width = own[at + 1..].split('.').next()?.parse().ok()?;
    ((1..=1000).contains(&count) && (1..=100).contains(&width)).then_some((count, width))
}

/// Reading of numbers in fields of fixed width.
struct Fields<'t, L: Iterator<Item = (usize, &'t str)>> {
    lines: L,
    file: &'t str,
    last: usize,
}

impl<'t, L: Iterator<Item = (usize, &'t str)>> Fields<'t, L> {
    fn line(&mut self, what: &str) -> Result<&'t str> {
        let next = self.lines.next();
        let (line, text) = next.ok_or_else(|| {
            Error::new(format!("{}:{}", self.file, self.last), format!("the file ends; expected {what}"))
        })?;
        self.last = line;
        Ok(text)
    }

    /// Reads `count` numbers of a format.
    fn numbers<T>(
        &mut self,
        count: usize,
        (on_line, width): (usize, usize),
        what: &str,
        read: impl Fn(&str) -> Option<T>,
    ) -> Result<Vec<T>> {
        let mut found = Vec::new();
        while found.len() < count {
            let text = self.line(what)?;
            for k in 0..on_line.min(count - found.len()) {
                // A shorter field would be a number that is cut off.
                let field = text.get(k * width..(k + 1) * width);
                let value = field.and_then(&read).ok_or_else(|| {
                    refused(
                        self.file,
                        self.last,
                        text,
                        &format!("expected {what} in full fields of {width} characters"),
                    )
                })?;
                found.push(value);
            }
        }
        Ok(found)
    }
}

/// Reads a matrix of the types RSA (symmetric, one triangle) and RUA (both triangles).
///
/// # Errors
/// An error with the line for other types, and for a file that is cut off or is none.
pub fn matrix(text: &str, file: &str) -> Result<Matrix> {
    let mut fields = Fields { lines: lines(text), file, last: 0 };
    fields.line("a title")?;
    let cards = fields.line("five numbers of lines")?;
    let kinds = fields.line("the type RSA, and the numbers of rows, columns and entries")?;
    let kind = kinds.get(..3).unwrap_or("").to_ascii_uppercase();
    let listed = match kind.as_str() {
        "RSA" => Listed::Once,
        "RUA" => Listed::Both,
        _ => {
            let expected = "expected the type RSA or RUA: real, symmetric or not, assembled";
            return Err(refused(file, fields.last, kinds, expected));
        }
    };
    let sizes: Vec<usize> = kinds[3..].split_whitespace().filter_map(|word| word.parse().ok()).collect();
    // Each row and each entry takes a character and more.
    let (count, total) = match sizes[..] {
        [rows, columns, total, ..] if rows == columns && rows > 0 && rows.max(total) <= text.len() => {
            (rows, total)
        }
        _ => {
            let expected = "expected the same numbers of rows and columns, and a number of entries that the file can hold";
            return Err(refused(file, fields.last, kinds, expected));
        }
    };
    let formats = fields.line("three formats")?;
    let part = |from: usize, to: usize| {
        formats.get(from..to.min(formats.len())).and_then(format).ok_or_else(|| {
            refused(
                file,
                4,
                formats,
                "expected formats such as (10I8), (10I8) and (4E20.12) in columns 1, 17 and 33",
            )
        })
    };
    let (pointers, indices, values) = (part(0, 16)?, part(16, 32)?, part(32, 52)?);
    let right = cards.split_whitespace().nth(4).and_then(|word| word.parse().ok()).unwrap_or(0_usize);
    if right > 0 {
        fields.line("the right-hand side's type")?;
    }
    let whole = |text: &str| text.trim().parse::<usize>().ok();
    let starts = fields.numbers(count + 1, pointers, "starts of columns", whole)?;
    let rises = starts.windows(2).all(|two| two[0] <= two[1]);
    if starts[0] != 1 || starts[count] != total + 1 || !rises {
        let problem =
            format!("starts of columns must rise from 1 to {}, one more than the entries", total + 1);
        return Err(Error::new(file, problem));
    }
    let places =
        fields.numbers(total, indices, "rows", |text| whole(text).filter(|k| (1..=count).contains(k)))?;
    let numbers = fields.numbers(total, values, "finite numbers", number)?;
    let mut entries = Vec::with_capacity(total);
    for column in 0..count {
        let own = starts[column] - 1..starts[column + 1] - 1;
        entries.extend(own.map(|k| Entry { row: places[k] - 1, column, value: numbers[k] }));
    }
    let names = Names::Rows(count);
    Ok(Matrix { file: file.into(), entries, listed, names, penalty: f64::INFINITY })
}

/// Reads Ansys' mapping: equation, node, and the label or number of a dof on each line after
/// headings.
///
/// # Errors
/// An error with the line for anything else, or if an equation is missing.
pub fn mapping(text: &str, file: &str) -> Result<Vec<Dof>> {
    let mut found = Vec::new();
    for (line, text) in lines(text).filter(|(_, text)| !text.trim().is_empty()) {
        let words: Vec<&str> = text.split([' ', '\t', ',']).filter(|word| !word.is_empty()).collect();
        let equation = words[0].parse::<usize>();
        if found.is_empty() && equation.is_err() {
            continue;
        }
        let expected = format!(
            "expected equation {}, a node, and a dof UX, UY, UZ, ROTX, ROTY, ROTZ. Temperatures, pressures and \
             other dofs are not reduced",
            found.len() + 1
        );
        let dof = match (equation, &words[1..]) {
            (Ok(own), [node, label]) if own == found.len() + 1 && node.parse::<u64>().is_ok() => {
                Direction::of_name(label).map(|direction| Dof::new(*node, direction))
            }
            _ => None,
        };
        found.push(dof.ok_or_else(|| refused(file, line, text, &expected))?);
    }
    if found.is_empty() { Err(Error::new(file, "it maps no equation")) } else { Ok(found) }
}
