//! Nastran's punch files with `DMIG` cards, in fields of 8 and 16 characters or with commas.

use super::words::{lines, number, refused, whole};
use super::{Matrix, Met, Names};
use crate::dofs::{Direction, Dof};
use crate::sparse::{Entry, Listed};
use crate::{Error, Result};

const COLUMN: &str = "expected a matrix's name, a grid point and its component, 0 to 6";

/// A card: the number of its first line, and its data fields.
struct Card<'t> {
    line: usize,
    text: &'t str,
    fields: Vec<&'t str>,
}

/// The fields of a line without the first: 4 wide ones or 8 narrow ones.
fn fields(line: &str) -> Vec<&str> {
    if line.contains(',') {
        let mut words: Vec<&str> = line.split(',').skip(1).map(str::trim).collect();
        words.resize(8, "");
        return words;
    }
    let is_wide = line.get(..8).unwrap_or(line).contains('*');
    let (width, count) = if is_wide { (16, 4) } else { (8, 8) };
    (0..count)
        .map(|k| {
            let (from, to) = (8 + k * width, (8 + (k + 1) * width).min(line.len()));
            if from < line.len() { line.get(from..to).unwrap_or("").trim() } else { "" }
        })
        .collect()
}

/// The `DMIG` cards with their continuations.
fn cards<'t>(text: &'t str, file: &str) -> Result<Vec<Card<'t>>> {
    let mut found: Vec<Card> = Vec::new();
    let mut inside = false;
    for (line, text) in lines(text) {
        if text.trim().is_empty() || text.starts_with('$') {
            continue;
        }
        if !text.is_ascii() {
            return Err(refused(file, line, text, "expected plain text in fields of 8 or 16 characters"));
        }
        let first = text.split(',').next().unwrap_or("");
        let first = first.get(..8).unwrap_or(first).trim();
        match first.trim_end_matches('*').trim().to_ascii_uppercase().as_str() {
            "DMIG" => {
                inside = true;
                found.push(Card { line, text, fields: fields(text) });
            }
            own if inside && (own.is_empty() || first.starts_with(['*', '+'])) => {
                if let Some(card) = found.last_mut() {
                    card.fields.extend(fields(text));
                }
            }
            _ => inside = false,
        }
    }
    Ok(found)
}

/// A named matrix of a punch file.
struct Named {
    name: String,
    matrix: Matrix,
    met: Met,
}

/// Reads all matrices of a file by their names.
///
/// # Errors
/// An error with the line for complex and rectangular matrices, and for fields that are no
/// numbers.
pub fn matrices(text: &str, file: &str) -> Result<Vec<(String, Matrix)>> {
    whole(text, file)?;
    let mut found: Vec<Named> = Vec::new();
    for card in cards(text, file)? {
        let name = card.fields[0].to_ascii_uppercase();
        if card.fields[1] == "0" {
            let listed = listed(&card, file)?;
            if found.iter().any(|own| own.name == name) {
                return Err(refused(
                    file,
                    card.line,
                    card.text,
                    "this matrix has a second heading; expected one",
                ));
            }
            let (entries, names) = (Vec::new(), Names::Rows(0));
            let matrix =
                Matrix { file: format!("{file} {name}"), entries, listed, names, penalty: f64::INFINITY };
            found.push(Named { name, matrix, met: Met::default() });
            continue;
        }
        let Some(own) = found.iter_mut().find(|own| own.name == name) else {
            let expected = "expected the heading of this matrix first, such as DMIG,KAAX,0,6,2,0";
            return Err(refused(file, card.line, card.text, expected));
        };
        column(&card, file, own)?;
    }
    if found.is_empty() {
        return Err(Error::new(file, "it has no DMIG cards"));
    }
    let named = |own: Named| (own.name, Matrix { names: Names::Dofs(own.met.into_list()), ..own.matrix });
    Ok(found.into_iter().map(named).collect())
}

/// The form and the type of a matrix, from its heading.
fn listed(card: &Card, file: &str) -> Result<Listed> {
    let refuse = |expected: &str| Err(refused(file, card.line, card.text, expected));
    if !["1", "2"].contains(&card.fields[3]) {
        return refuse("expected a real matrix, of type 1 or 2");
    }
    match card.fields[2] {
        "6" => Ok(Listed::Either),
        "1" => Ok(Listed::Both),
        _ => refuse("expected a symmetric or square matrix, of form 6 or 1"),
    }
}

fn column(card: &Card, file: &str, own: &mut Named) -> Result<()> {
    let refuse = |expected: &str| refused(file, card.line, card.text, expected);
    let dof = |node: &str, component: &str| {
        let node: u64 = node.parse().ok().filter(|node| *node > 0)?;
        let component = if component.is_empty() { 0 } else { component.parse().ok()? };
        Some(Dof::new(node.to_string(), Direction::of_number(component)?))
    };
    let at = dof(card.fields[1], card.fields[2]).ok_or_else(|| refuse(COLUMN))?;
    let column = own.met.row(at);
    let rest = card.fields.get(4..).unwrap_or(&[]);
    let mut has_entries = false;
    for term in rest.chunks(4).filter(|term| term.iter().any(|field| !field.is_empty())) {
        let entry = dof(term[0], term.get(1).unwrap_or(&"")).zip(number(term.get(2).unwrap_or(&"")));
        let is_real = term.get(3).is_none_or(|field| field.is_empty());
        let Some((dof, value)) = entry.filter(|_| is_real) else {
            let shown = term.join(" ");
            let expected = format!(
                "[{shown}] in this column: expected a grid point, its component 0 to 6 and a finite number"
            );
            return Err(refuse(&expected));
        };
        let row = own.met.row(dof);
        own.matrix.entries.push(Entry { row, column, value });
        has_entries = true;
    }
    if has_entries { Ok(()) } else { Err(refuse("expected at least one entry in this column")) }
}
