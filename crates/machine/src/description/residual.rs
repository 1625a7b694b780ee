//! Forces on nodes with residual flexibility, as the law and the checks see them.

use super::{Arms, Description, StopLaw};
use nalgebra::DMatrix;

/// The element whose force acts on nodes with residual flexibility, by its index among its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ResidualMaker {
    /// A spring.
    Spring(usize),
    /// A stop.
    Stop(usize),
    /// A contact along its normal.
    Normal(usize),
    /// A contact along its tangent.
    Tangent(usize),
}

impl ResidualMaker {
    /// The arms of the element; of a contact along its tangent, the arms of the first tangent.
    pub fn arms(self, d: &Description) -> &Arms {
        match self {
            Self::Spring(i) => &d.springs[i].arms,
            Self::Stop(i) => &d.stops[i].arms,
            Self::Normal(i) => &d.contacts[i].normal,
            // The check refuses two tangents.
            Self::Tangent(i) => &d.contacts[i].tangents[0].arms,
        }
    }
}

/// A force on nodes with residual flexibility.
#[derive(Clone, Debug)]
pub(crate) struct ResidualForce {
    pub by: ResidualMaker,
    /// Arms of the nodes, by their indices in [`ResidualForces::nodes`].
    pub arms: Vec<(usize, f64)>,
    /// Reciprocal stiffness of the element, m/N.
    pub compliance: f64,
}

/// All forces on nodes with residual flexibility.
#[derive(Clone, Debug)]
pub(crate) struct ResidualForces {
    /// The nodes of all bodies, by their indices among the bodies.
    pub nodes: Vec<usize>,
    /// Their flexibility, m/N; a block for each body.
    pub flexibility: DMatrix<f64>,
    /// Forces of elements.
    pub forces: Vec<ResidualForce>,
    /// Loads, each with the index of its node in `nodes`.
    pub loads: Vec<(usize, usize)>,
}

impl ResidualForces {
    /// The forces of a machine; `None` if no body has residual flexibility.
    pub fn of(d: &Description) -> Option<Self> {
        let all: Vec<_> = d.modals.iter().filter_map(|modal| modal.residual.as_ref()).collect();
        if all.is_empty() {
            return None;
        }
        let nodes: Vec<usize> = all.iter().flat_map(|own| own.nodes.iter().copied()).collect();
        let mut flexibility = DMatrix::zeros(nodes.len(), nodes.len());
        let mut first = 0;
        for own in all {
            let count = own.nodes.len();
            flexibility.view_mut((first, first), (count, count)).copy_from(&own.flexibility);
            first += count;
        }
        // Rounding of a symmetric matrix.
        let flexibility = 0.5 * (&flexibility + flexibility.transpose());
        let force = |by: ResidualMaker, stiffness: f64| {
            let arms = on_nodes(&nodes, by.arms(d));
            ResidualForce { by, arms, compliance: stiffness.recip() }
        };
        let mut forces = Vec::new();
        for (i, spring) in d.springs.iter().enumerate() {
            forces.push(force(ResidualMaker::Spring(i), spring.stiffness));
        }
        for (i, stop) in d.stops.iter().enumerate() {
            if let StopLaw::Compliant { stiffness, .. } = stop.law {
                forces.push(force(ResidualMaker::Stop(i), stiffness));
            }
        }
        forces.retain(|own: &ResidualForce| !own.arms.is_empty());
        for (i, contact) in d.contacts.iter().enumerate() {
            let normal = force(ResidualMaker::Normal(i), contact.stiffness);
            if normal.arms.is_empty() {
                continue;
            }
            forces.push(normal);
            // The tangent's limit follows the normal force, even if the tangent moves no node.
            let tangent = contact.tangents.first();
            forces.extend(tangent.map(|own| force(ResidualMaker::Tangent(i), own.stiffness)));
        }
        let loads = d.loads.iter().enumerate();
        let loads = loads.filter_map(|(i, load)| Some((i, place(&nodes, load.body)?))).collect();
        Some(Self { nodes, flexibility, forces, loads })
    }

    /// The displacement of each node by a unit of a force.
    pub fn moved(&self, force: &ResidualForce) -> Vec<f64> {
        self.moved_by(&force.arms)
    }

    fn moved_by(&self, arms: &[(usize, f64)]) -> Vec<f64> {
        let by = |node: usize| arms.iter().map(|&(k, arm)| arm * self.flexibility[(node, k)]).sum();
        (0..self.nodes.len()).map(by).collect()
    }

    /// The derivatives of [`moved`](Self::moved) of each force and of [`between`](Self::between) by
    /// the arms; `along` has the derivatives of the machine's numbers.
    pub fn along(&self, along: &Description) -> (Vec<Vec<f64>>, DMatrix<f64>) {
        let by_arms = |force: &ResidualForce| self.moved_by(&on_nodes(&self.nodes, force.by.arms(along)));
        let moved: Vec<_> = self.forces.iter().map(by_arms).collect();
        // A half of each entry; the transpose has the other half.
        let half = |i: usize, j: usize| -> f64 {
            self.forces[i].arms.iter().map(|&(k, arm)| arm * moved[j][k]).sum()
        };
        let half = DMatrix::from_fn(self.forces.len(), self.forces.len(), half);
        (moved, &half + half.transpose())
    }

    /// The elongation of each force's element by a unit of each other force.
    pub fn between(&self) -> DMatrix<f64> {
        let moved: Vec<Vec<f64>> = self.forces.iter().map(|own| self.moved(own)).collect();
        let entry = |i: usize, j: usize| self.forces[i].arms.iter().map(|&(k, arm)| arm * moved[j][k]).sum();
        let count = self.forces.len();
        let all = DMatrix::from_fn(count, count, entry);
        0.5 * (&all + all.transpose())
    }

    /// The index of the force along the normal of the contact of a tangential force.
    pub fn normal_of(&self, force: usize) -> Option<usize> {
        let ResidualMaker::Tangent(contact) = self.forces[force].by else { return None };
        self.forces.iter().position(|own| own.by == ResidualMaker::Normal(contact))
    }
}

/// The index of a body among nodes.
fn place(nodes: &[usize], body: usize) -> Option<usize> {
    nodes.iter().position(|node| *node == body)
}

/// The arms on these nodes.
fn on_nodes(nodes: &[usize], arms: &Arms) -> Vec<(usize, f64)> {
    arms.terms.iter().filter_map(|&(body, arm)| Some((place(nodes, body)?, arm))).collect()
}

impl Description {
    /// Whether elements of different kinds see a body's node as rigid: whether it has residual
    /// flexibility.
    pub(crate) fn has_residual(&self, body: usize) -> bool {
        let own = self.modals.iter().filter_map(|modal| modal.residual.as_ref());
        own.into_iter().any(|own| own.nodes.contains(&body))
    }
}
