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
        let on_nodes = |arms: &Arms| on_nodes(&nodes, arms);
        let mut forces = Vec::new();
        let put = |forces: &mut Vec<ResidualForce>, by, arms: &Arms, stiffness: f64| {
            let arms = on_nodes(arms);
            if !arms.is_empty() {
                forces.push(ResidualForce { by, arms, compliance: stiffness.recip() });
            }
        };
        for (i, spring) in d.springs.iter().enumerate() {
            put(&mut forces, ResidualMaker::Spring(i), &spring.arms, spring.stiffness);
        }
        for (i, stop) in d.stops.iter().enumerate() {
            if let StopLaw::Compliant { stiffness, .. } = stop.law {
                put(&mut forces, ResidualMaker::Stop(i), &stop.arms, stiffness);
            }
        }
        for (i, contact) in d.contacts.iter().enumerate() {
            let count = forces.len();
            put(&mut forces, ResidualMaker::Normal(i), &contact.normal, contact.stiffness);
            // The check refuses two tangents. A tangent whose limit follows a force on residual
            // flexibility is one of these forces, even if it moves none of the nodes.
            for tangent in contact.tangents.iter().take(usize::from(forces.len() > count)) {
                let (arms, compliance) = (on_nodes(&tangent.arms), tangent.stiffness.recip());
                forces.push(ResidualForce { by: ResidualMaker::Tangent(i), arms, compliance });
            }
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
        let arms = |force: &ResidualForce| {
            let arms = match force.by {
                ResidualMaker::Spring(i) => Some(&along.springs[i].arms),
                ResidualMaker::Stop(i) => Some(&along.stops[i].arms),
                ResidualMaker::Normal(i) => Some(&along.contacts[i].normal),
                ResidualMaker::Tangent(i) => along.contacts[i].tangents.first().map(|own| &own.arms),
            };
            arms.map_or_else(Vec::new, |arms| on_nodes(&self.nodes, arms))
        };
        let by_arms: Vec<_> = self.forces.iter().map(arms).collect();
        let moved: Vec<_> = by_arms.iter().map(|arms| self.moved_by(arms)).collect();
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
