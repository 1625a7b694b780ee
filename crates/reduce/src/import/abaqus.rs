//! Abaqus' files of `*MATRIX GENERATE` with `*MATRIX OUTPUT`: `FORMAT=MATRIX INPUT` with names of
//! the dofs, `FORMAT=COORDINATE` without.

use super::words::{lines, number, refused, row, whole};
use super::{Matrix, Met, Names};
use crate::dofs::{Direction, Dof};
use crate::sparse::{Entry, Listed};
use crate::{Error, Result};

/// Diagonal entry of a dof that a boundary condition holds: the program adds 1e36.
const PENALTY: f64 = 1e35;
const NAMED: &str = "expected node, dof, node, dof, value";
const NUMBERED: &str = "expected row, column (both counted from 1) and a finite number";

/// Reads either format, which is recognised by the first line of numbers.
///
/// # Errors
/// An error with the line for anything else, Lagrange multipliers, and dofs that are not
/// displacements or rotations.
pub fn matrix(text: &str, file: &str) -> Result<Matrix> {
    whole(text, file)?;
    let data = || lines(text).filter(|(_, line)| !line.trim().is_empty() && !line.starts_with(['*', '%']));
    let Some((_, first)) = data().next() else { return Err(Error::new(file, "it has no entries")) };
    let is_named = words(first).len() == 5;
    let (mut met, mut entries, mut count) = (Met::default(), Vec::new(), 0);
    for (line, text) in data() {
        let words = words(text);
        let entry = match words[..] {
            [n1, d1, n2, d2, x] if is_named => {
                let (one, other) = (dof(n1, d1), dof(n2, d2));
                let of = |dof: std::result::Result<Dof, &str>| {
                    dof.map_err(|text_| refused(file, line, text, text_))
                };
                let (one, other) = (of(one)?, of(other)?);
                number(x).map(|value| Entry { row: met.row(one), column: met.row(other), value })
            }
            [i, j, x] if !is_named => match (row(i), row(j), number(x)) {
                (Some(row), Some(column), Some(value)) => Some(Entry { row, column, value }),
                _ => None,
            },
            _ => None,
        };
        let expected = if is_named { NAMED } else { NUMBERED };
        let entry = entry.ok_or_else(|| refused(file, line, text, expected))?;
        count = count.max(entry.row.max(entry.column) + 1);
        entries.push(entry);
    }
    let names = if is_named { Names::Dofs(met.into_list()) } else { Names::Rows(count) };
    Ok(Matrix { file: file.into(), entries, listed: Listed::Either, names, penalty: PENALTY })
}

fn words(line: &str) -> Vec<&str> {
    line.split([',', ' ', '\t']).filter(|word| !word.is_empty()).collect()
}

fn dof<'t>(node: &str, direction: &str) -> std::result::Result<Dof, &'t str> {
    let number: i64 = node.parse().map_err(|_| NAMED)?;
    if number <= 0 {
        return Err(
            "the node is not positive: a Lagrange multiplier of a connector or a tie. Such models have \
                    no definite stiffness; replace the constraint by elimination (*MPC, *KINEMATIC COUPLING)",
        );
    }
    let direction: u32 = direction.parse().map_err(|_| NAMED)?;
    match Direction::of_number(direction) {
        Some(Direction::None) | None => {
            Err("expected a dof 1 to 6: warping, pressures, temperatures and potentials are not reduced")
        }
        Some(direction) => Ok(Dof::new(node, direction)),
    }
}
