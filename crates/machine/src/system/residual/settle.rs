//! The states of the forces on residual flexibility by values, and the search for consistent
//! states.

use super::{Acting, Residual};
use crate::system::{Part, System};
use std::collections::HashSet;

/// A value counts as zero up to this fraction of its size.
const ZERO: f64 = 1e-13;

/// The search tries at most this number of combinations one by one.
const MOST_TRIED: usize = 1 << 16;

impl Residual {
    /// The states after a force has taken another state: the slider of a contact follows its
    /// normal. Without friction it has no force in any state.
    pub fn flipped(&self, acting: &[Acting], place: usize, to: Acting) -> Vec<Acting> {
        let mut all = acting.to_vec();
        all[place] = to;
        for (own, component) in all.iter_mut().zip(&self.components) {
            if let Some((_, friction)) = component.limit.filter(|limit| limit.0 == place) {
                *own = if friction == 0.0 { Acting::Off } else { to };
            }
        }
        all
    }

    /// Finds states that no force contradicts. `wrong` returns a force that does, with
    /// the state that it requires. Each step changes the state of one force, as in Murty's method
    /// for matrices with positive principal minors; if the steps go in a circle, all combinations of
    /// the forces that they have changed are tried.
    pub fn search<E>(
        &self,
        begin: Vec<Acting>,
        mut wrong: impl FnMut(&[Acting]) -> Result<Option<(usize, Acting)>, E>,
    ) -> Result<Option<Vec<Acting>>, E> {
        let (mut acting, mut met, mut changed) = (begin, HashSet::new(), Vec::new());
        while met.insert(acting.clone()) {
            let Some((place, to)) = wrong(&acting)? else { return Ok(Some(acting)) };
            acting = self.flipped(&acting, place, to);
            let normal = self.components[place].limit.map_or(place, |limit| limit.0);
            if !changed.contains(&normal) {
                changed.push(normal);
            }
        }
        let mut all = vec![acting];
        for normal in changed {
            let states = |own: &Vec<Acting>| self.states_of(own, normal);
            all = all.iter().flat_map(states).collect();
            if all.len() > MOST_TRIED {
                return Ok(None);
            }
        }
        for acting in all.into_iter().filter(|own| !met.contains(own)) {
            if wrong(&acting)?.is_none() {
                return Ok(Some(acting));
            }
        }
        Ok(None)
    }

    /// All states of the contact with this force along its normal.
    fn states_of(&self, acting: &[Acting], normal: usize) -> Vec<Vec<Acting>> {
        let on = self.flipped(acting, normal, Acting::On);
        let slides = (0..acting.len()).find(|&t| self.components[t].limit.is_some_and(|own| own.0 == normal));
        let slipping = slides.into_iter().flat_map(|t| [Acting::Up, Acting::Down].map(|to| (t, to)));
        let slipping: Vec<_> = slipping.map(|(t, to)| self.flipped(&on, t, to)).collect();
        [self.flipped(acting, normal, Acting::Off), on].into_iter().chain(slipping).collect()
    }

    /// The forces by values of x.
    fn values(&self, acting: &[Acting], x: &[f64]) -> Vec<f64> {
        let active = self.active(acting);
        let right = nalgebra::DVector::from_iterator(active.len(), active.iter().map(|&i| x[i]));
        // A system without forces needs no solution.
        let solve = || self.matrix(acting, &active).lu().solve(&right);
        let found = if active.is_empty() { None } else { solve() };
        let mut forces = vec![0.0; acting.len()];
        for (&i, force) in active.iter().zip(found.iter().flat_map(|own| own.iter())) {
            forces[i] = *force;
        }
        for (i, own) in self.components.iter().enumerate() {
            if let Some((normal, friction)) = own.limit {
                let direction = acting[i].direction();
                if direction != 0.0 {
                    forces[i] = direction * friction * forces[normal];
                }
            }
        }
        forces
    }

    /// The stretch (A69) at one of the forces.
    fn stretched(&self, place: usize, forces: &[f64]) -> f64 {
        let all = forces.iter().enumerate().map(|(j, force)| self.between[(place, j)] * force);
        all.sum::<f64>() + self.components[place].compliance * forces[place]
    }

    /// A force that contradicts its state by values, with the state that it requires.
    fn contradiction(&self, acting: &[Acting], x: &[f64], sizes: &[f64]) -> Option<(usize, Acting)> {
        let forces = self.values(acting, x);
        for (i, component) in self.components.iter().enumerate() {
            let alone = component.compliance + self.between[(i, i)];
            let zero = ZERO * sizes[i];
            match (component.limit, acting[i]) {
                (None, Acting::On) if !matches!(component.part, Part::Stop(_)) => {}
                (None, Acting::On) if alone * forces[i] < -zero => return Some((i, Acting::Off)),
                (None, Acting::Off) if x[i] - self.stretched(i, &forces) > zero => {
                    return Some((i, Acting::On));
                }
                (Some((normal, friction)), Acting::On) if acting[normal] == Acting::On => {
                    let beyond = forces[i].abs() - friction * forces[normal];
                    if alone * beyond > zero {
                        let to = if forces[i] > 0.0 { Acting::Up } else { Acting::Down };
                        return Some((i, to));
                    }
                }
                (Some(_), Acting::Up | Acting::Down) => {
                    let slipped = x[i] - self.stretched(i, &forces);
                    if acting[i].direction() * slipped < -zero {
                        return Some((i, Acting::On));
                    }
                }
                _ => {}
            }
        }
        None
    }
}

impl System {
    /// The states of the forces on residual flexibility by the values of an augmented state; `None`
    /// without such forces.
    pub(crate) fn acting_at(&self, z: &[f64]) -> Option<Vec<Acting>> {
        let own = self.residual.as_ref()?;
        let x: Vec<f64> = own.components.iter().map(|own| own.x.at(z)).collect();
        let sizes: Vec<f64> = z.iter().map(|x| x.abs()).collect();
        let sizes: Vec<f64> = own.components.iter().map(|own| own.x.size(&sizes)).collect();
        let wrong = |acting: &[Acting]| Ok::<_, ()>(own.contradiction(acting, &x, &sizes));
        let found = own.search(own.apart(), wrong).ok().flatten();
        Some(found.unwrap_or_else(|| own.apart()))
    }

    /// Moves the sliders on residual flexibility until no force exceeds its limit. Returns the
    /// distance by branch.
    pub(crate) fn settle_residual(&self, z: &mut [f64]) -> Vec<f64> {
        let mut ways = vec![0.0; self.branches.len()];
        let (Some(own), Some(acting)) = (&self.residual, self.acting_at(z)) else { return ways };
        let x: Vec<f64> = own.components.iter().map(|own| own.x.at(z)).collect();
        let forces = own.values(&acting, &x);
        for (c, component) in own.components.iter().enumerate() {
            if let (Part::Branch(i), true) = (component.part, acting[c] != Acting::On) {
                let stretch = own.stretched(c, &forces);
                ways[i] = x[c] - stretch;
                z[self.branches[i].place] = stretch;
            }
        }
        ways
    }
}
