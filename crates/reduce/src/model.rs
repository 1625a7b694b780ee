//! Stiffness, mass and damping with the names of their dofs, and the checks before the reduction.

use crate::dofs::{Direction, Dofs};
use crate::sparse::Symmetric;
use crate::units::Units;
use crate::{Error, Result};
use nalgebra::DMatrix;

/// Standard gravity, m/s².
pub const STANDARD_GRAVITY: f64 = 9.806_65;

/// The matrices of a model in SI, without clamped dofs.
#[derive(Clone, Debug)]
pub struct Model {
    /// Stiffness.
    pub stiffness: Symmetric,
    /// Mass.
    pub mass: Symmetric,
    /// Damping, if a file gives it.
    pub damping: Option<Symmetric>,
    /// Names of the rows.
    pub dofs: Dofs,
    /// Names of the dofs that were clamped, by the files or by an option.
    pub clamped: Dofs,
    /// Remarks on the files.
    pub remarks: Vec<String>,
}

impl Model {
    /// A model of matrices in SI.
    ///
    /// # Errors
    /// An error if the sizes differ, or if a dof has neither stiffness nor mass.
    pub fn new(stiffness: Symmetric, mass: Symmetric, dofs: Dofs) -> Result<Self> {
        let (rows, names) = (stiffness.count(), dofs.len());
        if mass.count() != rows || names != rows {
            let problem = format!(
                "stiffness has {rows} rows, mass {}, and there are {names} names of dofs; expected equal numbers",
                mass.count()
            );
            return Err(Error::new("matrices", problem));
        }
        if rows == 0 {
            return Err(Error::new("matrices", "they have no rows; expected one row for each dof"));
        }
        Ok(Self { stiffness, mass, damping: None, dofs, clamped: Dofs::default(), remarks: Vec::new() })
    }

    /// The model in SI; its numbers are in `units`.
    pub fn in_units(mut self, units: &Units) -> Self {
        let list = self.dofs.list();
        self.stiffness.scale(|i, j| units.stiffness(list[i].direction, list[j].direction));
        self.mass.scale(|i, j| units.mass(list[i].direction, list[j].direction));
        if let Some(damping) = &mut self.damping {
            damping.scale(|i, j| units.damping(list[i].direction, list[j].direction));
        }
        self
    }

    /// The model with these rows clamped.
    ///
    /// # Errors
    /// An error if no row remains.
    pub fn clamp(self, rows: &[usize]) -> Result<Self> {
        if rows.is_empty() {
            return Ok(self);
        }
        let mut is_clamped = vec![false; self.dofs.len()];
        rows.iter().for_each(|&row| is_clamped[row] = true);
        let kept: Vec<usize> = (0..self.dofs.len()).filter(|&row| !is_clamped[row]).collect();
        if kept.is_empty() {
            return Err(Error::new("--clamp", "all dofs are clamped; expected one or more free dofs"));
        }
        let gone: Vec<usize> = (0..self.dofs.len()).filter(|&row| is_clamped[row]).collect();
        let both = [self.clamped.list(), self.dofs.kept(&gone).list()].concat();
        Ok(Self {
            stiffness: self.stiffness.kept(&kept),
            mass: self.mass.kept(&kept),
            damping: self.damping.map(|own| own.kept(&kept)),
            dofs: self.dofs.kept(&kept),
            clamped: Dofs::new(both)?,
            remarks: self.remarks,
        })
    }

    /// Name of a row.
    pub fn name(&self, row: usize) -> String {
        self.dofs.list()[row].to_string()
    }

    /// Refuses dofs without stiffness and mass.
    ///
    /// # Errors
    /// An error that names the first of them.
    pub fn check(&self) -> Result<()> {
        let empty = |a: &Symmetric, row: usize| a.column(row).all(|(_, x)| x == 0.0);
        let rows = 0..self.dofs.len();
        let found: Vec<usize> =
            rows.filter(|&row| empty(&self.stiffness, row) && empty(&self.mass, row)).collect();
        if found.is_empty() {
            return Ok(());
        }
        let names: Vec<String> = found.iter().take(3).map(|&row| self.name(row)).collect();
        let more = if found.len() > 3 { format!(" and {} more", found.len() - 3) } else { String::new() };
        let problem = "neither stiffness nor mass: clamp it, or leave it out of the model";
        Err(Error::new(format!("dof {}{more}", names.join(", ")), problem))
    }

    /// The directions of displacement that dofs of the model have.
    pub fn directions(&self) -> Vec<Direction> {
        let all = [Direction::None, Direction::X, Direction::Y, Direction::Z];
        all.into_iter().filter(|d| self.dofs.list().iter().any(|dof| dof.direction == *d)).collect()
    }

    /// Unit displacement of all dofs of a direction.
    pub fn translation(&self, direction: Direction) -> DMatrix<f64> {
        let list = self.dofs.list();
        DMatrix::from_fn(list.len(), 1, |i, _| f64::from(u8::from(list[i].direction == direction)))
    }

    /// Mass that moves in a direction, kg.
    pub fn total_mass(&self, direction: Direction) -> f64 {
        let r = self.translation(direction);
        r.dot(&self.mass.times(&r))
    }

    /// The dof with the largest share of the mass in its direction, and this share.
    pub fn largest_mass(&self) -> Option<(usize, f64)> {
        let diagonal = self.mass.diagonal();
        let totals: Vec<(Direction, f64)> =
            self.directions().into_iter().map(|d| (d, self.total_mass(d))).collect();
        let share = |row: usize| {
            let own = self.dofs.list()[row].direction;
            let total = totals.iter().find(|(d, _)| *d == own)?.1;
            (total > 0.0).then(|| (row, diagonal[row] / total))
        };
        (0..diagonal.len()).filter_map(share).max_by(|a, b| a.1.total_cmp(&b.1))
    }
}
