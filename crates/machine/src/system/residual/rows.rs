//! The rows of a configuration.

use super::{Acting, Component, Residual};
use crate::description::{DampingLimit, StopLaw};
use crate::functional::Functional;
use crate::system::{Part, System};
use nalgebra::DMatrix;
use std::sync::OnceLock;

/// The rows of the forces on residual flexibility while they are in given states.
#[derive(Clone, Debug)]
pub(crate) struct Configuration {
    /// The states.
    pub acting: Vec<Acting>,
    /// Each force.
    pub forces: Vec<Functional>,
    /// Each force's rate.
    pub rates: Vec<Functional>,
    /// Elongation and rate of each element.
    pub elongations: Vec<[Functional; 2]>,
    /// Coordinate and rate of each node.
    pub nodes: Vec<[Functional; 2]>,
}

impl Residual {
    /// C + G of (A68) for the forces `active`, with the forces of slipping sliders expressed by
    /// the forces along their normals.
    pub(super) fn matrix(&self, acting: &[Acting], active: &[usize]) -> DMatrix<f64> {
        let slips = |j: usize| {
            let own = self.components.iter().zip(acting).enumerate();
            own.filter_map(move |(t, (own, acts))| {
                let (normal, friction) = own.limit?;
                (normal == j && acts.direction() != 0.0).then(|| (t, acts.direction() * friction))
            })
        };
        DMatrix::from_fn(active.len(), active.len(), |row, column| {
            let (i, j) = (active[row], active[column]);
            let own = if i == j { self.components[i].compliance } else { 0.0 };
            let slipping: f64 = slips(j).map(|(t, factor)| factor * self.between[(i, t)]).sum();
            own + self.between[(i, j)] + slipping
        })
    }

    /// The forces that the elongations determine.
    pub(crate) fn active(&self, acting: &[Acting]) -> Vec<usize> {
        (0..acting.len()).filter(|&i| acting[i] == Acting::On).collect()
    }

    /// The inverse of [`matrix`](Self::matrix), whose determinant is positive in a checked machine.
    pub(crate) fn inverse(&self, acting: &[Acting], active: &[usize]) -> DMatrix<f64> {
        let inverse = || self.matrix(acting, active).lu().try_inverse();
        let inverse = if active.is_empty() { None } else { inverse() };
        inverse.unwrap_or_else(|| DMatrix::zeros(active.len(), active.len()))
    }

    /// The rows of all forces, from a row for each force (A68).
    fn forces(&self, acting: &[Acting], of: fn(&Component) -> &Functional) -> Vec<Functional> {
        let active = self.active(acting);
        let inverse = self.inverse(acting, &active);
        let mut forces = vec![Functional::zeros(self.size); acting.len()];
        for (row, &i) in active.iter().enumerate() {
            let terms = active.iter().enumerate();
            let terms = terms.map(|(column, &j)| (inverse[(row, column)], of(&self.components[j])));
            forces[i] = Functional::sum(self.size, terms);
        }
        for (i, own) in self.components.iter().enumerate() {
            if let (Some((normal, friction)), true) = (own.limit, acting[i].direction() != 0.0) {
                forces[i] = acting[i].direction() * friction * &forces[normal];
            }
        }
        forces
    }

    /// Σ factor · force.
    fn sum(&self, forces: &[Functional], factors: impl Fn(usize) -> f64) -> Functional {
        let terms = forces.iter().enumerate().map(|(j, force)| (factors(j), force));
        Functional::sum(self.size, terms.filter(|term| term.0 != 0.0))
    }

    /// The rows of a configuration.
    fn configuration(&self, acting: Vec<Acting>) -> Configuration {
        let forces = self.forces(&acting, |own| &own.x);
        // A held slider keeps its place: the rate of its x is the rate of its elongation.
        let rates = self.forces(&acting, |own| &own.rate);
        let elongations = self.components.iter().enumerate().map(|(c, own)| {
            let taken = |forces: &[Functional]| self.sum(forces, |j| self.between[(c, j)]);
            [&own.e - &taken(&forces), &own.rate - &taken(&rates)]
        });
        let elongations = elongations.collect();
        let nodes = self.nodes.iter().map(|node| {
            let taken = |forces: &[Functional]| self.sum(forces, |j| node.by[j]);
            [&node.own[0] - &taken(&forces), &node.own[1] - &taken(&rates)]
        });
        let nodes = nodes.collect();
        Configuration { acting, forces, rates, elongations, nodes }
    }

    /// The row of the stretch (A69) of a slider that does not hold.
    fn stretch(&self, place: usize, forces: &[Functional]) -> Functional {
        let all = self.sum(forces, |j| self.between[(place, j)]);
        &all + &(self.components[place].compliance * &forces[place])
    }
}

impl System {
    /// Takes the rows of a configuration.
    pub(super) fn configure(&mut self, acting: Vec<Acting>) {
        let Some(residual) = self.residual.clone() else { return };
        let own = residual.configuration(acting);
        for (c, component) in residual.components.iter().enumerate() {
            let alone = component.compliance + residual.between[(c, c)];
            match component.part {
                Part::Spring(i) => {
                    self.springs[i].stiffness = alone.recip();
                    self.springs[i].force = own.forces[c].clone();
                }
                Part::Stop(i) => {
                    let stop = &mut self.stops[i];
                    let (stiffness, limit) = (alone.recip(), DampingLimit::Pull);
                    stop.law = StopLaw::Compliant { stiffness, damping: 0.0, limit };
                    let others = |j: usize| if j == c { 0.0 } else { residual.between[(c, j)] };
                    if own.acting[c] == Acting::On {
                        // Without the shares of the other forces, x is (C + G) p of this force alone.
                        (stop.excess, stop.force) = (alone * &own.forces[c], own.forces[c].clone());
                    } else {
                        stop.excess = &component.x - &residual.sum(&own.forces, others);
                        stop.force = stiffness * &stop.excess;
                    }
                    stop.spring = stop.force.clone();
                }
                Part::Branch(i) => self.configure_branch(i, c, &residual, &own),
                Part::Friction(_) | Part::Load(_) => {}
            }
        }
        self.configuration = Some(own);
        (self.split, self.losses, self.soft) = (OnceLock::new(), OnceLock::new(), None);
        self.add_forces();
    }

    /// Takes the rows of a contact's tangent, after the rows of its normal.
    fn configure_branch(&mut self, i: usize, c: usize, residual: &Residual, own: &Configuration) {
        let component = &residual.components[c];
        let Some((normal, friction)) = component.limit else { return };
        let Part::Stop(stop) = residual.components[normal].part else { return };
        let level = friction * &self.stops[stop].force;
        let direction = own.acting[c].direction();
        let stretch = [&own.forces, &own.rates].map(|forces| residual.stretch(c, forces));
        let branch = &mut self.branches[i];
        branch.whole = component.e.clone();
        branch.rate = component.rate.clone();
        branch.inner = &component.e - &component.x;
        branch.force = own.forces[c].clone();
        branch.level = Some(level);
        // In the direction of the slip.
        branch.sliding = Some(direction * &stretch[1]);
        branch.slaved = (own.acting[c] != Acting::On).then_some(stretch);
        let place = branch.place - 2 * self.coordinates;
        self.first_order[place].rate = component.rate.clone();
    }
}

impl System {
    /// The rate of a stop's elongation; on residual flexibility the rate while the stop is open.
    pub(crate) fn rate_apart(&self, stop: usize, z: &[f64]) -> f64 {
        let place = self.residual.as_ref().and_then(|own| Some((own, own.place(Part::Stop(stop))?)));
        let (Some((residual, place)), Some(own)) = (place, &self.configuration) else {
            return self.stops[stop].elongation.rate.at(z);
        };
        if own.acting[place] == Acting::Off {
            return own.elongations[place][1].at(z);
        }
        let open = residual.configuration(residual.flipped(&own.acting, place, Acting::Off));
        open.elongations[place][1].at(z)
    }
}
