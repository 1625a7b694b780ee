//! The contacts' quadratic program at one order, and the decisions from its solution.

use super::{Friction, Selection, Stop, slipping};
use crate::functional::StateRow;
use crate::law::ZERO;
use crate::law::box_qp::{BoxProblem, Jam, Solution};
use crate::mode::{Contact, FrictionState, StopState};
use nalgebra::{DMatrix, DVector};

impl Selection<'_> {
    /// The quadratic program of the contacts at an order.
    pub(super) fn contact_problem(
        &self,
        order: usize,
        contacts: &[Contact],
        free: &DMatrix<f64>,
    ) -> BoxProblem {
        let m = contacts.len();
        let z = &self.derivatives[order];
        let (mut b, mut zero) = (DVector::zeros(m), DVector::zeros(m));
        let mut lo = DVector::from_element(m, f64::NEG_INFINITY);
        let mut hi = DVector::from_element(m, f64::INFINITY);
        // Sizes of the accelerations' terms, summed before forces on a body cancel.
        let sizes = self.sizes[order].of_rows(free);
        for (k, &contact) in contacts.iter().enumerate() {
            let e = self.system.elongation_of(contact);
            let row = along(free, &e.w) + &*e.drift;
            b[k] = row.dot(z);
            let terms: f64 = e.w.terms().iter().map(|&(k, w)| w.abs() * sizes[k]).sum();
            zero[k] = ZERO * (terms + self.sizes[order].of(&e.drift));
            match contact {
                Contact::Stop(i) => {
                    if self.stops[i] == Stop::Touching {
                        lo[k] = 0.0;
                    }
                }
                Contact::Friction(i) => {
                    let level = self.level(i).dot(&self.derivatives[order]);
                    match self.frictions[i] {
                        Friction::Resting(first) if order < first => (lo[k], hi[k]) = (0.0, 0.0),
                        Friction::Resting(first) if order == first => (lo[k], hi[k]) = (-level, level),
                        Friction::AtLevel(direction) => {
                            if direction > 0.0 {
                                hi[k] = level;
                            } else {
                                lo[k] = -level;
                            }
                        }
                        _ => {}
                    }
                }
                Contact::Slider(_) => {}
            }
        }
        BoxProblem { columns: self.system.columns(contacts), b, lo, hi, zero }
    }

    pub(super) fn solve_contacts(&self, problem: &BoxProblem, contacts: &[Contact]) -> Result<Solution, Jam> {
        problem.solve().map_err(|jam| Jam {
            contacts: jam
                .contacts
                .iter()
                .filter_map(|&k| if let Contact::Stop(i) = contacts[k] { Some(i) } else { None })
                .collect(),
        })
    }

    /// Returns the level up to which a resting friction holds: static until it is released.
    pub(super) fn level(&self, i: usize) -> &StateRow {
        let friction = &self.system.frictions[i];
        // If the followed stop has no force, the bound is not used.
        let own = friction.at(&self.pressing).unwrap_or(&friction.levels[0]);
        if self.released[i] { &own.level } else { &own.static_level }
    }

    /// Finds the orders at which levels that follow stops leave zero, and ends the friction if its
    /// stop pulls.
    pub(super) fn follow(&mut self, order: usize) {
        self.pressing = self.states().0;
        for (i, friction) in self.system.frictions.iter().enumerate() {
            if friction.follows.is_none() || self.ends[i] {
                continue;
            }
            let Some(own) = friction.at(&self.pressing) else {
                let mut stops = friction.follows.iter().flatten();
                if stops.all(|own| matches!(self.stops[own.0], Stop::Is(_))) {
                    (self.ends[i], self.frictions[i]) = (true, Friction::Is(FrictionState::Off));
                }
                continue;
            };
            // Once the level has left zero, its first derivative decides.
            if self.acts[i] {
                continue;
            }
            let sign = self.sign(&own.level, order);
            self.acts[i] = sign > 0.0;
            if sign < 0.0 {
                (self.ends[i], self.frictions[i]) = (true, Friction::Is(FrictionState::Off));
            }
            if self.acts[i] && self.frictions[i] == Friction::Resting(usize::MAX) {
                self.frictions[i] = Friction::Resting(order);
            }
        }
    }

    /// Returns the frictions that slip at their static level.
    pub(super) fn leaving(&self, contacts: &[Contact], solution: &Solution) -> Vec<usize> {
        let slips = |(k, &contact): (usize, &Contact)| match contact {
            Contact::Friction(i) if !matches!(self.frictions[i], Friction::Is(_)) => {
                let slips = solution.residual[k].abs() > solution.zero[k];
                (slips && self.system.frictions[i].has_static && !self.released[i]).then_some(i)
            }
            _ => None,
        };
        contacts.iter().enumerate().filter_map(slips).collect()
    }

    /// Decides elements by the solution of an order.
    pub(super) fn decide(
        &mut self,
        order: usize,
        contacts: &[Contact],
        problem: &BoxProblem,
        solution: &Solution,
    ) {
        for (k, &contact) in contacts.iter().enumerate() {
            let (force, left) = (solution.lambda[k], solution.residual[k]);
            let zero_force = problem.zero_force(k, solution);
            match contact {
                Contact::Stop(i) if self.stops[i] == Stop::Touching => {
                    if left < -solution.zero[k] {
                        self.stops[i] = Stop::Is(StopState::Open);
                    } else if force > zero_force {
                        self.stops[i] = Stop::Is(StopState::Closed);
                    }
                }
                Contact::Stop(_) | Contact::Slider(_) => {}
                Contact::Friction(i) => {
                    let level = self.level(i).dot(&self.derivatives[order]);
                    match self.frictions[i] {
                        Friction::Is(_) => {}
                        _ if left.abs() > solution.zero[k] => {
                            self.frictions[i] = Friction::Is(slipping(left));
                        }
                        Friction::Resting(first) if order == first => {
                            let room = level - force.abs();
                            self.frictions[i] = if room > self.sizes[order].zero(self.level(i)) + zero_force {
                                Friction::Is(FrictionState::Stuck)
                            } else {
                                self.at_level[i] = force.signum();
                                Friction::AtLevel(force.signum())
                            };
                        }
                        Friction::AtLevel(d)
                            if level - d * force > self.sizes[order].zero(self.level(i)) + zero_force =>
                        {
                            self.frictions[i] = Friction::Is(FrictionState::Stuck);
                        }
                        _ => {}
                    }
                }
            }
        }
    }

    /// Adds contacts whose force lies strictly inside its bounds to the preferred contacts, in the
    /// order of leaving their bounds.
    pub(super) fn prefer(&mut self, contacts: &[Contact], problem: &BoxProblem, solution: &Solution) {
        for &k in &solution.free {
            let (contact, force) = (contacts[k], solution.lambda[k]);
            let zero = problem.zero_force(k, solution);
            let inside = force > problem.lo[k] + zero && force < problem.hi[k] - zero;
            if inside && !self.preferred.contains(&contact) {
                self.preferred.push(contact);
            }
        }
    }
}

/// Returns the row of the acceleration along a direction w. Directions of one or two terms, as
/// most are, skip the zeros.
fn along(free: &DMatrix<f64>, w: &DVector<f64>) -> StateRow {
    let mut terms = w.iter().enumerate().filter(|(_, w)| **w != 0.0);
    let two = [terms.next(), terms.next()];
    if terms.next().is_some() {
        return free.tr_mul(w);
    }
    let mut row = StateRow::zeros(free.ncols());
    for (c, &w) in two.into_iter().flatten() {
        row.iter_mut().zip(free.row(c).iter()).for_each(|(sum, f)| *sum += f * w);
    }
    row
}
