//! Reading of matrices and of the names of their dofs.
//!
//! Each module below reads the text of one format into a [`Matrix`]; this one finds the format and
//! the role of each file, and makes a [`Model`] of stiffness and mass.

pub mod abaqus;
pub mod calculix;
pub mod files;
pub mod harwell;
pub mod market;
pub mod punch;
pub mod words;

use crate::dofs::{Dof, Dofs};
use crate::model::Model;
use crate::sparse::{Entry, Listed, Symmetric};
use crate::{Error, Result};
use std::collections::HashMap;

/// Names of a matrix's rows.
#[derive(Clone, Debug, PartialEq)]
pub enum Names {
    /// None, but a number of rows: the one of the file, or its largest row.
    Rows(usize),
    /// The dof of each row.
    Dofs(Vec<Dof>),
}

/// A matrix as a file lists it.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// The file, for messages.
    pub file: String,
    /// The entries.
    pub entries: Vec<Entry>,
    /// Whether both triangles are listed.
    pub listed: Listed,
    /// Names of the rows.
    pub names: Names,
    /// Lower limit of a penalty: a larger diagonal entry clamps its dof.
    pub penalty: f64,
}

/// Rows of named dofs, in the order of their first entries.
#[derive(Default)]
pub struct Met {
    list: Vec<Dof>,
    places: HashMap<Dof, usize>,
}

impl Met {
    /// Row of a dof, which is new if it was not met before.
    pub fn row(&mut self, dof: Dof) -> usize {
        if let Some(&row) = self.places.get(&dof) {
            return row;
        }
        self.places.insert(dof.clone(), self.list.len());
        self.list.push(dof);
        self.list.len() - 1
    }

    /// The dofs.
    pub fn into_list(self) -> Vec<Dof> {
        self.list
    }
}

/// The model of a stiffness and a mass matrix, and of a damping matrix if there is one, in the
/// units of the files. `dofs` are the names of the rows from a file of their own.
///
/// # Errors
/// An error if sizes or names do not fit, or if a matrix is not symmetric.
pub fn model(
    stiffness: Matrix,
    mass: Matrix,
    damping: Option<Matrix>,
    dofs: Option<(String, Vec<Dof>)>,
) -> Result<Model> {
    let (mut stiffness, mut mass) = (stiffness, mass);
    let dofs = match (&stiffness.names, &mass.names, dofs) {
        (Names::Dofs(one), Names::Dofs(other), None) => Dofs::new(joined(one, other, &mut mass.entries))?,
        (Names::Rows(_), Names::Rows(_), Some((file, list))) => {
            [&stiffness, &mass].into_iter().try_for_each(|own| rows_within(own, &file, list.len()))?;
            rows_reach(&stiffness, &file, list.len())?;
            Dofs::new(list)?
        }
        (Names::Rows(one), Names::Rows(other), None) => numbered(&stiffness, &mass, *one.max(other))?,
        (_, _, Some((file, _))) => {
            let problem = format!(
                "the names of dofs are already in {} or {}; omit this file",
                stiffness.file, mass.file
            );
            return Err(Error::new(file, problem));
        }
        _ => {
            let problem = format!(
                "only one of this file and {} contains the names of dofs; expected two matrices of one program",
                mass.file
            );
            return Err(Error::new(&stiffness.file, problem));
        }
    };
    let penalty = stiffness.penalty;
    let held: Vec<usize> = (stiffness.entries.iter())
        .filter(|e| e.row == e.column && e.value >= penalty)
        .map(|e| e.row)
        .collect();
    if !held.is_empty() {
        // Rows of penalties go; so do their entries, which would hide other dofs' rounding.
        let mut is_held = vec![false; dofs.len()];
        held.iter().for_each(|&row| is_held[row] = true);
        stiffness.entries.retain(|e| e.row == e.column || !(is_held[e.row] || is_held[e.column]));
    }
    let matrix = |own: &Matrix| {
        let name = |row: usize| dofs.list()[row].to_string();
        let made = Symmetric::assemble(dofs.len(), &own.entries, own.listed, &name);
        made.map_err(|e| Error::new(&own.file, e.to_string()))
    };
    let (k, m) = (matrix(&stiffness)?, matrix(&mass)?);
    let placed = |own: Matrix| matrix(&on_rows(own, &dofs, &stiffness.file)?);
    let damping = damping.map(placed).transpose()?;
    let mut model = Model { damping, ..Model::new(k, m, dofs)? };
    if !held.is_empty() {
        let first = model.name(held[0]);
        model.remarks.push(format!(
            "{} dofs have a stiffness of {penalty:.0e} or more, a penalty of the program: they are clamped (the first is {first})",
            held.len()
        ));
    }
    model.clamp(&held)
}

/// The dofs of one matrix, then further dofs of the other matrix, whose entries get new rows.
fn joined(one: &[Dof], other: &[Dof], entries: &mut [Entry]) -> Vec<Dof> {
    let mut met = Met::default();
    one.iter().for_each(|dof| {
        met.row(dof.clone());
    });
    let places: Vec<usize> = other.iter().map(|dof| met.row(dof.clone())).collect();
    for e in entries {
        (e.row, e.column) = (places[e.row], places[e.column]);
    }
    met.into_list()
}

/// The damping matrix with the rows of the model.
fn on_rows(mut matrix: Matrix, dofs: &Dofs, file: &str) -> Result<Matrix> {
    if let Names::Dofs(names) = &matrix.names {
        let places: HashMap<&Dof, usize> = dofs.list().iter().enumerate().map(|(i, dof)| (dof, i)).collect();
        let place = |dof: &Dof| {
            let problem = format!("has the dof {dof}, which {file} does not have");
            places.get(dof).copied().ok_or_else(|| Error::new(&matrix.file, problem))
        };
        let rows = names.iter().map(place).collect::<Result<Vec<usize>>>()?;
        for e in &mut matrix.entries {
            (e.row, e.column) = (rows[e.row], rows[e.column]);
        }
    }
    rows_within(&matrix, file, dofs.len())?;
    Ok(matrix)
}

fn rows_within(matrix: &Matrix, file: &str, count: usize) -> Result<()> {
    match matrix.entries.iter().find(|e| e.row.max(e.column) >= count) {
        None => Ok(()),
        Some(e) => {
            let row = e.row.max(e.column) + 1;
            Err(Error::new(&matrix.file, format!("has a row {row}, but {file} names {count} dofs")))
        }
    }
}

/// Refuses a stiffness matrix without an entry for the last dof.
fn rows_reach(matrix: &Matrix, file: &str, count: usize) -> Result<()> {
    let most = matrix.entries.iter().map(|e| e.row.max(e.column) + 1).max().unwrap_or(0);
    if most >= count {
        return Ok(());
    }
    let problem = format!(
        "its last row is {most}, but {file} names {count} dofs; expected a stiffness for each dof; the file may be truncated"
    );
    Err(Error::new(&matrix.file, problem))
}

/// Dofs without names. Each must have an entry of its own in a matrix, so that a huge number of a
/// row does not ask for as much memory.
fn numbered(stiffness: &Matrix, mass: &Matrix, count: usize) -> Result<Dofs> {
    let entries = stiffness.entries.len() + mass.entries.len();
    if count > entries {
        let problem = format!(
            "there are {count} rows, but only {entries} entries in both matrices; expected an entry for each row"
        );
        return Err(Error::new(&stiffness.file, problem));
    }
    Ok(Dofs::numbered(count))
}
