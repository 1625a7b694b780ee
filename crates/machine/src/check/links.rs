//! Checks of links: each removes one more coordinate than the links before it.

use crate::description::{BodyKind, Description};
use crate::refusal::Problem;
use std::collections::BTreeMap;

/// Relative tolerance for zero in a link's row after elimination of the earlier links; an
/// elimination of 10,000 links leaves less rounding error.
const NOTHING: f64 = 1e-11;

/// Problems of the links; requires numbers within their ranges.
pub(super) fn check(machine: &Description, problems: &mut Vec<Problem>) {
    let free: Vec<_> = machine.bodies.iter().map(|b| matches!(b.kind, BodyKind::Free(_))).collect();
    let mut ties = Elimination { rows: Vec::new() };
    for link in &machine.links {
        let name = format!("link.{}", link.name);
        let terms = coordinates(machine, &link.arms.terms);
        let terms: Vec<_> = terms.into_iter().filter(|term| free[term.0]).collect();
        if terms.is_empty() {
            let text = "connects only bodies with prescribed motion; requires a body with mass or inertia";
            problems.push(Problem::new(name, None, text));
        } else if !ties.add(free.len(), &terms) {
            let text = "the links before it already determine its e; remove this link, which is redundant or contradicts them";
            problems.push(Problem::new(name, None, text));
        }
    }
    if let Some((last, others)) = machine.links.split_last()
        && problems.is_empty()
        && ties.rows.len() == machine.bodies.iter().filter(|b| !matches!(b.kind, BodyKind::Node(_))).count()
    {
        let others: Vec<_> = others.iter().map(|l| format!("link.{}", l.name)).collect();
        let with = if others.is_empty() { String::new() } else { format!("with {} ", others.join(", ")) };
        let text = format!(
            "{with}it holds every body still; use fewer links than bodies, or prescribe the motion of a body"
        );
        problems.push(Problem::new(format!("link.{}", last.name), None, text));
    }
}

/// The terms of an elongation, with nodes replaced by the coordinates behind them.
fn coordinates(machine: &Description, terms: &[(usize, f64)]) -> Vec<(usize, f64)> {
    let mut all = BTreeMap::new();
    for &(body, arm) in terms {
        match &machine.bodies[body].kind {
            BodyKind::Node(row) => {
                row.iter().for_each(|(k, factor)| *all.entry(*k).or_insert(0.0) += arm * factor);
            }
            _ => *all.entry(body).or_insert(0.0) += arm,
        }
    }
    all.into_iter().collect()
}

/// Rows in echelon form, each with the column of its pivot; pivots are 1.
struct Elimination {
    rows: Vec<(usize, Vec<(usize, f64)>)>,
}

impl Elimination {
    /// Adds a row; returns `false` if it depends on earlier rows.
    fn add(&mut self, columns: usize, terms: &[(usize, f64)]) -> bool {
        let (mut row, mut sizes) = (vec![0.0; columns], vec![0.0_f64; columns]);
        for &(column, arm) in terms {
            (row[column], sizes[column]) = (arm, arm.abs());
        }
        for (pivot, other) in &self.rows {
            let factor = row[*pivot];
            if factor == 0.0 {
                continue;
            }
            for &(column, arm) in other {
                row[column] -= factor * arm;
                sizes[column] = sizes[column].max((factor * arm).abs());
            }
            row[*pivot] = 0.0;
        }
        let left = |c: &usize| row[*c].abs() > NOTHING * sizes[*c];
        let Some(pivot) = (0..columns).filter(left).max_by(|&a, &b| row[a].abs().total_cmp(&row[b].abs()))
        else {
            return false;
        };
        let terms = (0..columns).filter(left).map(|c| (c, row[c] / row[pivot])).collect();
        self.rows.push((pivot, terms));
        true
    }
}
