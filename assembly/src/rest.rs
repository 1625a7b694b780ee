//! Static equilibrium, the start at rest (docs/assembly-law.md (A19), (A20)).

use crate::description::{Description, StopLaw};
use crate::error::Error;
use crate::law::box_qp::Problem;
use crate::system::{Row, System};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use vibro_impact::numerics::double_double::DoubleDouble;

/// The proximal weight falls by this factor a step, from the largest stiffness per inertia to [`LEAST_WEIGHT`] of it: far enough
/// for stiffnesses 1e9 apart, and not so far that the factors lose all digits.
const FALL: f64 = 0.1;
const LEAST_WEIGHT: f64 = 1e-10;
/// Steps, of which each at the least weight takes an error down by 1e-10 of the largest over the least stiffness.
const STEPS: usize = 100;
/// A force that is left counts as rounding under this part of the forces' sizes.
const BALANCED: f64 = 1e-13;
/// A step counts as rounding under this part of the coordinates' sizes.
const STANDS: f64 = 1e-15;

/// What holds a machine at rest beside its springs.
struct Holding {
    /// By contact: its direction, its elongation where it begins to act at q = 0, bounds of its force, and its compliance.
    contacts: Vec<Contact>,
    /// Direction and stiffness of each spring.
    springs: Vec<(DVector<f64>, f64)>,
    /// The force on the coordinates at q = 0 but for the contacts.
    force: DVector<f64>,
    /// Its terms' sizes.
    sizes: DVector<f64>,
}

struct Contact {
    w: DVector<f64>,
    excess: f64,
    force: (f64, f64),
    compliance: f64,
}

/// Which level of friction holds.
#[derive(Clone, Copy, PartialEq)]
enum Friction {
    None,
    Slipping,
    Static,
}

/// The coordinates at which a machine stands still at time 0. Friction bears nothing where there is an equilibrium without it;
/// else it resists the way from the coordinates' zero. Of coordinates on which nothing acts, the nearest to zero are taken.
///
/// # Errors
/// [`Error::NoEquilibrium`], with the body that is accelerated most.
pub fn equilibrium(d: &Description, system: &System) -> Result<DVector<f64>, Error> {
    let mut z = Row::zeros(system.signals.size);
    let inputs = vec![(0.0, [0.0; 4]); system.signals.inputs];
    system.signals.fill(DoubleDouble::default(), &inputs, z.as_mut_slice());
    let n = system.coordinates;
    let stiffness = -system.forces.columns(0, n).into_owned();
    let mut worst = None;
    for friction in [Friction::None, Friction::Slipping, Friction::Static] {
        match Holding::new(system, &z, friction).settle(&stiffness, &system.mass) {
            Ok(q) => return Ok(q),
            Err(left) => worst = Some(left),
        }
    }
    let left = system.inertia.solve(&worst.unwrap_or_else(|| DVector::zeros(n)));
    let body = (0..n).max_by(|&a, &b| left[a].abs().total_cmp(&left[b].abs()));
    let name = body.map_or(String::new(), |k| d.bodies[system.bodies_of[k]].name.clone());
    Err(Error::NoEquilibrium { body: name, acceleration: body.map_or(0.0, |k| left[k]) })
}

impl Holding {
    /// What holds a machine whose augmented state is `z` at q = 0.
    fn new(system: &System, z: &Row, friction: Friction) -> Self {
        let mut force = &system.forces * z;
        let mut sizes = system.forces.abs() * z.abs();
        let mut contacts = Vec::new();
        for stop in &system.stops {
            let compliance = match stop.law {
                StopLaw::Rigid { .. } => 0.0,
                StopLaw::Compliant { stiffness, .. } if stiffness > 0.0 => 1.0 / stiffness,
                StopLaw::Compliant { .. } => continue,
            };
            let (w, excess) = (stop.elongation.w.clone(), stop.excess.dot(z));
            contacts.push(Contact { w, excess, force: (0.0, f64::INFINITY), compliance });
        }
        for rows in &system.frictions {
            let rate = rows.elongation.rate.dot(z);
            let level = if friction == Friction::Static { &rows.static_level } else { &rows.level };
            let level = level.dot(z).max(0.0);
            let w = &rows.elongation.w;
            if rate != 0.0 {
                // A body that moves as prescribed rubs against those at rest.
                force.axpy(-rate.signum() * rows.level.dot(z).max(0.0), w, 1.0);
                sizes += w.abs() * level;
            } else if friction != Friction::None && level > 0.0 {
                contacts.push(Contact { w: w.clone(), excess: 0.0, force: (-level, level), compliance: 0.0 });
            }
        }
        let springs = system.springs.iter().map(|s| (s.elongation.w.clone(), s.stiffness)).collect();
        Self { contacts, springs, force, sizes }
    }

    /// The equilibrium by proximal steps: each is the minimum of the energy and a weight times the distance from the last in the
    /// inertia's metric. `Err` is the force that is left.
    fn settle(&self, stiffness: &DMatrix<f64>, mass: &DMatrix<f64>) -> Result<DVector<f64>, DVector<f64>> {
        let n = self.force.len();
        let ratio = |k: usize| stiffness[(k, k)] / mass[(k, k)];
        let mut largest = (0..n).map(ratio).fold(0.0, f64::max);
        for contact in self.contacts.iter().filter(|c| c.compliance > 0.0) {
            let each = (0..n).map(|k| contact.w[k] * contact.w[k] / contact.compliance / mass[(k, k)]);
            largest = each.fold(largest, f64::max);
        }
        let largest = if largest > 0.0 { largest } else { 1.0 };
        let (mut q, mut lambda) = (DVector::zeros(n), DVector::zeros(self.contacts.len()));
        let (mut weight, mut left, mut balanced) = (largest, self.force.clone(), false);
        let mut sizes;
        for _ in 0..STEPS {
            let Some(factor) = Cholesky::new(stiffness + weight * mass) else { break };
            let Some((by_q, by_lambda)) = self.step(&factor, &left, &q, &lambda) else { break };
            let moves = by_q.amax() > STANDS * (q.amax() + by_q.amax());
            q += by_q;
            lambda += by_lambda;
            // Spring by spring, so that what a stiff one's rounding does to two bodies has no sum.
            (left, sizes) = (self.force.clone(), self.sizes.clone());
            for (w, k) in &self.springs {
                left.axpy(-k * w.dot(&q), w, 1.0);
                sizes += w.abs() * (k * w.abs().dot(&q.abs()));
            }
            for (contact, lambda) in self.contacts.iter().zip(lambda.iter()) {
                left.axpy(-lambda, &contact.w, 1.0);
                sizes += contact.w.abs() * lambda.abs();
            }
            balanced = left.amax() <= BALANCED * sizes.amax();
            if weight <= LEAST_WEIGHT * largest && balanced && !moves {
                return Ok(q);
            }
            weight = (FALL * weight).max(LEAST_WEIGHT * largest);
        }
        if balanced { Ok(q) } else { Err(left) }
    }

    /// The changes of q and of the contacts' forces λ that lead to the minimum of ½ δᵀHδ - leftᵀδ and the contacts' energies, with
    /// H by its Cholesky factor. `None` where stops cannot be satisfied together.
    fn step(
        &self,
        factor: &Cholesky<f64, Dyn>,
        left: &DVector<f64>,
        q: &DVector<f64>,
        lambda: &DVector<f64>,
    ) -> Option<(DVector<f64>, DVector<f64>)> {
        let (n, m) = (left.len(), self.contacts.len());
        let free = factor.solve(left);
        // A compliant contact yields by itself: a coordinate of its own, of which the square is the compliance.
        let mut columns = DMatrix::zeros(n + m, m);
        let (mut b, mut zero) = (DVector::zeros(m), DVector::zeros(m));
        for (k, contact) in self.contacts.iter().enumerate() {
            let mut column = contact.w.clone();
            factor.l_dirty().solve_lower_triangular_mut(&mut column);
            columns.view_mut((0, k), (n, 1)).copy_from(&column);
            columns[(n + k, k)] = contact.compliance.sqrt();
            let yielded = contact.compliance * lambda[k];
            b[k] = contact.w.dot(&(q + &free)) + contact.excess - yielded;
            zero[k] =
                STANDS * (contact.w.abs().dot(&(q.abs() + free.abs())) + contact.excess.abs() + yielded);
        }
        let bound =
            |of: fn(&(f64, f64)) -> f64| DVector::from_fn(m, |k, _| of(&self.contacts[k].force) - lambda[k]);
        let problem = Problem { columns, b, lo: bound(|f| f.0), hi: bound(|f| f.1), zero };
        let change = problem.solve().ok()?.lambda;
        let mut forces = left.clone();
        for (contact, change) in self.contacts.iter().zip(change.iter()) {
            forces.axpy(-change, &contact.w, 1.0);
        }
        Some((factor.solve(&forces), change))
    }
}
