//! The section `[modal.NAME]` of a machine's file.

use crate::dofs::Direction;
use crate::interface::Interface;
use crate::reduction::{Method, Reduced};
use crate::statement::labels;
use crate::{Error, Result};
use nalgebra::DMatrix;
use std::fmt::Write;

/// Further contents of the section.
#[derive(Clone, Debug)]
pub struct Section<'r> {
    /// Name of the body.
    pub name: &'r str,
    /// Lines of the comment at the top.
    pub heading: Vec<String>,
    /// Damping ratio of each coordinate.
    pub damping_ratios: Vec<f64>,
    /// Weight of each coordinate by the machine's gravity, if it acts.
    pub gravity: Option<Vec<f64>>,
}

/// Refuses a name that a machine's file does not take.
///
/// # Errors
/// An error with the allowed characters.
pub fn check_name(name: &str) -> Result<()> {
    let is_first = name.starts_with(|c: char| c.is_ascii_alphabetic());
    if is_first && name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c)) {
        return Ok(());
    }
    let problem = "expected a name of letters, digits, _ and -, that begins with a letter";
    Err(Error::new(format!("--name {name}"), problem))
}

/// The text of the file.
pub fn text(reduced: &Reduced, interfaces: &[Interface], section: &Section) -> String {
    let mut out = String::new();
    for line in &section.heading {
        let _ = writeln!(out, "# {line}");
    }
    let _ = writeln!(out, "name = \"{0}\"\n\n[modal.{0}]", section.name);
    let _ = writeln!(out, "frequencies = {}", list(&reduced.frequencies()));
    let ratios = &section.damping_ratios;
    match ratios.first().filter(|first| reduced.rigid == 0 && ratios.iter().all(|own| own == *first)) {
        Some(one) => {
            let _ = writeln!(out, "damping_ratio = {one:?}");
        }
        None => {
            let _ = writeln!(out, "damping_ratio = {}", list(ratios));
        }
    }
    if let Some(gravity) = &section.gravity {
        let _ = writeln!(out, "gravity = {}", list(gravity));
    }
    if !interfaces.is_empty() {
        out.push_str(&residual(reduced, interfaces));
        let _ = writeln!(out, "\n[modal.{}.nodes]", section.name);
        let mut first = 0;
        for own in interfaces {
            let rows = reduced.rows.rows(first, own.dofs.len()).into_owned();
            out.push_str(&node(own, &rows));
            first += own.dofs.len();
        }
    }
    out
}

/// The residual flexibility. Where the coordinates have the whole flexibility, only rounding is
/// left, and nothing is written.
fn residual(reduced: &Reduced, interfaces: &[Interface]) -> String {
    if reduced.method != Method::MacNeal || reduced.residual.amax() <= 1e-9 * reduced.flexibility.amax() {
        return String::new();
    }
    let names: Vec<String> = labels(interfaces).iter().map(|name| format!("\"{name}\"")).collect();
    let flexibility = without_negative(&reduced.residual);
    let rows: Vec<String> = flexibility.row_iter().map(|row| list(row.transpose().as_slice())).collect();
    format!(
        "# Flexibility at the nodes that the modes lack, m/N.\n\
         residual = {{ nodes = [{}], flexibility = [{}] }}\n",
        names.join(", "),
        rows.join(", ")
    )
}

/// A symmetric matrix with its negative eigenvalues, which are rounding of the whole flexibility,
/// replaced by 0.
fn without_negative(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let mut own = (0.5 * (matrix + matrix.transpose())).symmetric_eigen();
    if own.eigenvalues.min() >= 0.0 {
        return matrix.clone();
    }
    own.eigenvalues.apply(|value| *value = value.max(0.0));
    let found = own.recompose();
    0.5 * (&found + found.transpose())
}

/// A node: one row, or a table of directions with a row each.
fn node(own: &Interface, rows: &DMatrix<f64>) -> String {
    let row = |k: usize, direction: Direction| {
        let numbers = list(rows.row(k).transpose().as_slice());
        if direction.is_rotation() {
            format!("{{ row = {numbers}, dimension = \"rotation\" }}")
        } else {
            numbers
        }
    };
    if let [(direction, _)] = own.dofs[..] {
        return format!("{} = {}\n", own.name, row(0, direction));
    }
    let of = |(k, (direction, _)): (usize, &(Direction, usize))| {
        let name = if *direction == Direction::None { "s" } else { direction.name() };
        format!("{name} = {}", row(k, *direction))
    };
    let parts: Vec<String> = own.dofs.iter().enumerate().map(of).collect();
    format!("{} = {{ {} }}\n", own.name, parts.join(", "))
}

fn list(numbers: &[f64]) -> String {
    let words: Vec<String> =
        numbers.iter().map(|x| format!("{:?}", if *x == 0.0 { 0.0 } else { *x })).collect();
    format!("[{}]", words.join(", "))
}
