//! Bodies with many coordinates, and nodes on them.

use super::{Arms, Body, BodyKind, Description, Dimension};
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// A body in modal coordinates. Mode i has the stiffness m (2π f)² and the damping 2 ζ m 2π f. Its
/// modal mass m is the inertia of body `first` + i (docs/assembly-law.md (A50)).
#[derive(Clone, Debug, PartialEq)]
pub struct Modal {
    /// Its name, unique among the elements.
    pub name: String,
    /// Index of the body that is the coordinate of mode 0; the other modes follow.
    pub first: usize,
    /// Frequency f of each mode, Hz; not negative.
    pub frequencies: Vec<f64>,
    /// Damping ratios ζ, not negative: one for all modes, or one for each mode.
    pub damping_ratios: Vec<f64>,
    /// Whether the modes have their own masses; otherwise each mass is 1.
    pub has_masses: bool,
    /// Static flexibility that the modes lack at nodes.
    pub residual: Option<Residual>,
}

/// Residual flexibility: the static displacements of nodes that the modes of a body lack. A force p
/// on node j adds `flexibility[(i, j)]` p to the displacement of node i (docs/assembly-law.md (A68)).
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    /// Indices of the nodes among the bodies.
    pub nodes: Vec<usize>,
    /// Flexibility, m/N; symmetric, without negative eigenvalues.
    pub flexibility: DMatrix<f64>,
}

/// A spring and a dashpot in parallel on coordinates.
pub(crate) struct Inner {
    pub arms: Arms,
    pub stiffness: f64,
    pub damping: f64,
}

impl Modal {
    /// Index of the damping ratio of mode `i`.
    fn place_of_ratio(&self, i: usize) -> usize {
        if self.damping_ratios.len() == 1 { 0 } else { i }
    }

    /// Name of the damping ratio of mode `i` as a parameter.
    pub(crate) fn name_of_ratio(&self, i: usize) -> String {
        match self.damping_ratios.len() {
            1 => format!("modal.{}.damping_ratio", self.name),
            _ => format!("modal.{}.damping_ratio[{i}]", self.name),
        }
    }

    /// The springs, one for each mode.
    pub(crate) fn springs(&self, d: &Description) -> Vec<Inner> {
        let spring = |(i, &f): (usize, &f64)| {
            let (m, omega, ratio) =
                (d.mass_of(self.first + i), TAU * f, self.damping_ratios[self.place_of_ratio(i)]);
            let arms = Arms::between(None, Some(self.first + i), Dimension::Translation);
            Inner { arms, stiffness: m * omega * omega, damping: 2.0 * ratio * m * omega }
        };
        self.frequencies.iter().enumerate().map(spring).collect()
    }

    /// Derivatives of the springs' stiffness and damping. `by` and `along` hold the derivatives of
    /// this body's numbers and of the machine's numbers.
    pub(crate) fn springs_by(&self, d: &Description, by: &Self, along: &Description) -> Vec<[f64; 2]> {
        let spring = |(i, (&f, &df)): (usize, (&f64, &f64))| {
            let (m, dm) = (d.mass_of(self.first + i), along.mass_of(self.first + i));
            let (ratio, dratio) = [self, by].map(|own| own.damping_ratios[self.place_of_ratio(i)]).into();
            let (omega, domega) = (TAU * f, TAU * df);
            let stiffness = dm * omega * omega + 2.0 * m * omega * domega;
            [stiffness, 2.0 * (dratio * m * omega + ratio * (dm * omega + m * domega))]
        };
        self.frequencies.iter().zip(&by.frequencies).enumerate().map(spring).collect()
    }
}

impl Body {
    /// Whether the body is a coordinate of a body with many coordinates. Such coordinates have no
    /// columns in tables and no curves.
    pub fn is_inner(&self) -> bool {
        self.name.contains('[')
    }
}

impl Description {
    /// Inertia of a body; 0 if it has none of its own.
    pub(crate) fn mass_of(&self, body: usize) -> f64 {
        match self.bodies.get(body).map(|body| &body.kind) {
            Some(BodyKind::Free(free)) => free.inertia,
            _ => 0.0,
        }
    }

    /// Name of a coordinate of a body with many coordinates.
    pub(crate) fn name_of_coordinate(name: &str, i: usize) -> String {
        format!("{name}.q[{i}]")
    }

    /// For a node, the indices of the bodies that it combines; for another body, its own index.
    pub fn behind(&self, body: usize) -> Vec<usize> {
        match &self.bodies[body].kind {
            BodyKind::Node(row) => row.iter().map(|term| term.0).collect(),
            _ => vec![body],
        }
    }
}
