//! Impacts of one or many stops at one instant (docs/assembly-law.md (A7) to (A9)).

use super::box_qp::{BoxProblem, Jam};
use super::{Sizes, ZERO};
use crate::mode::Contact;
use crate::system::System;
use nalgebra::DVector;

/// Largest number of impacts at one instant; after them the velocities are projected (`project`).
const MAX_IMPACTS: usize = 1000;

/// One impact: the stops with an impulse, and its energies.
#[derive(Clone, Debug, PartialEq)]
pub struct Impact {
    /// Index of each stop with an impulse, its closing speed before, and the impulse.
    pub stops: Vec<(usize, f64, f64)>,
    /// Energy lost, J.
    pub lost: f64,
    /// Work of prescribed motions, J.
    pub work: f64,
}

/// The impacts of one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Impacts {
    /// The impacts, in order of occurrence.
    pub sequence: Vec<Impact>,
    /// Whether the sequence was ended by a projection.
    pub projected: bool,
    /// Energy lost by the projection, J.
    pub projected_loss: f64,
    /// For each coordinate, the largest sum, over the impulses of one impact, of the sizes of the
    /// changes of its velocity. It bounds the rounding where changes cancel (docs/assembly-law.md
    /// (A18)); 0 if there was only one impulse.
    pub shares: Vec<f64>,
}

impl Impacts {
    /// The greatest closing speed of a stop that took an impulse.
    pub fn fastest(&self, stop: usize) -> f64 {
        let all = self.sequence.iter().flat_map(|impact| &impact.stops);
        all.filter(|s| s.0 == stop).map(|s| s.1).fold(0.0, f64::max)
    }
}

/// The machine and its touching stops at an instant.
pub struct Instant<'a> {
    /// The machine.
    pub system: &'a System,
    /// Sizes that define the zero tolerance.
    pub sizes: &'a Sizes,
    /// Indices of the rigid stops with e = gap.
    pub touching: &'a [usize],
    /// Restitution coefficient of each stop; 0 if its chatter ends.
    pub restitution: &'a [f64],
    /// Indices of the freewheels that count as having e' = 0 before the impacts, whatever the
    /// rounded value of e'.
    pub engaged: &'a [usize],
}

/// Decides which stops without closing speed stay closed. Arguments: the state, the indices of
/// these stops, the indices of the stops that close, and the number of earlier impacts at the
/// instant.
pub type StayClosed<'a> = dyn FnMut(&DVector<f64>, &[usize], &[usize], usize) -> Result<Vec<bool>, Jam> + 'a;

impl Instant<'_> {
    /// Closing speed e' of a stop.
    fn speed(&self, stop: usize, z: &DVector<f64>) -> f64 {
        self.system.stops[stop].elongation.rate.dot(z)
    }

    /// Applies impacts to the velocities in `z` until no touching stop closes. `stay_closed`
    /// decides which stops without closing speed take part in an impact (docs/assembly-law.md,
    /// Sequences).
    ///
    /// # Errors
    /// [`Jam`], whose contacts are indices of stops.
    pub fn collide(&self, z: &mut DVector<f64>, stay_closed: &mut StayClosed<'_>) -> Result<Impacts, Jam> {
        let mut impacts = self.collide_stops(z, stay_closed)?;
        if !self.system.freewheels().is_empty() {
            self.catch(z, &mut impacts)?;
        }
        Ok(impacts)
    }

    /// Applies the impacts of the rigid stops, without freewheels.
    fn collide_stops(&self, z: &mut DVector<f64>, stay_closed: &mut StayClosed<'_>) -> Result<Impacts, Jam> {
        let mut impacts = Impacts { shares: vec![0.0; self.system.coordinates], ..Impacts::default() };
        let mut largest = 0.0f64;
        loop {
            let speeds: Vec<f64> = self.touching.iter().map(|&i| self.speed(i, z)).collect();
            largest = speeds.iter().fold(largest, |most, &u| most.max(u));
            let zero = |place: usize| self.zero(self.touching[place], largest, &impacts);
            if (0..speeds.len()).all(|k| speeds[k] <= zero(k)) {
                return Ok(impacts);
            }
            if impacts.sequence.len() >= MAX_IMPACTS {
                self.project(z, &mut impacts)?;
                return Ok(impacts);
            }
            // Stops that leave do not take part until an impact makes them close.
            let mut taking: Vec<usize> = (0..speeds.len()).filter(|&k| speeds[k] >= -zero(k)).collect();
            let still = |&k: &usize| speeds[k] <= zero(k);
            if taking.iter().any(still) {
                let places = |of: &dyn Fn(&usize) -> bool| -> Vec<usize> {
                    taking.iter().filter(|k| of(k)).map(|&k| self.touching[k]).collect()
                };
                let (candidates, others) = (places(&still), places(&|k| !still(k)));
                let stay = stay_closed(z, &candidates, &others, impacts.sequence.len())?;
                let leaves =
                    |stop: usize| candidates.iter().zip(&stay).any(|(&i, stays)| i == stop && !stays);
                taking.retain(|&k| !leaves(self.touching[k]));
            }
            let stops: Vec<usize> = taking.iter().map(|&k| self.touching[k]).collect();
            let u: Vec<f64> = taking.iter().map(|&k| speeds[k].max(0.0)).collect();
            let zeros: Vec<f64> = taking.iter().map(|&k| zero(k)).collect();
            let impact = self.impact(&stops, &u, &zeros, z)?;
            // An impact without impulse changes nothing and would repeat without end. It occurs if
            // all speeds count as zero compared with the rounding of other stops on the body.
            if impact.stops.is_empty() {
                return Ok(impacts);
            }
            impacts.sequence.push(impact);
            self.take_shares(&mut impacts);
        }
    }

    /// Speed up to which a stop's speed counts as zero, given the instant's largest closing speed.
    fn zero(&self, stop: usize, largest: f64, impacts: &Impacts) -> f64 {
        let e = &self.system.stops[stop].elongation;
        let shares: f64 = e.w.size(&impacts.shares);
        (ZERO * largest.max(shares)).max(self.sizes.zero(&e.rate))
    }

    /// Applies the plastic impact of freewheels that removes e' > 0. After it no touching stop and
    /// no freewheel has e' > 0 (docs/assembly-law.md (A53)).
    fn catch(&self, z: &mut DVector<f64>, impacts: &mut Impacts) -> Result<(), Jam> {
        let wheels = self.system.freewheels();
        let before = impacts.sequence.iter().flat_map(|impact| &impact.stops);
        let largest = before.fold(0.0f64, |most, stop| most.max(stop.1));
        let turns = |wheel: usize| {
            let stands = impacts.sequence.is_empty() && self.engaged.contains(&wheel);
            !stands && self.speed(wheel, z) > self.zero(wheel, largest, impacts)
        };
        if !wheels.clone().any(turns) {
            return Ok(());
        }
        let all: Vec<usize> = self.touching.iter().copied().chain(wheels).collect();
        let u: Vec<f64> = all.iter().map(|&i| self.speed(i, z)).collect();
        let zeros: Vec<f64> = all.iter().map(|&i| self.zero(i, largest, impacts)).collect();
        let p = self.impulses(&all, DVector::from_column_slice(&u), &zeros)?;
        let mut impact = Impact { stops: Vec::new(), lost: 0.0, work: 0.0 };
        for (k, &stop) in all.iter().enumerate().filter(|(k, _)| p[*k] > 0.0) {
            impact.stops.push((stop, u[k].max(0.0), p[k]));
            impact.lost += 0.5 * u[k] * p[k];
            impact.work += p[k] * self.prescribed_speed(stop, z);
        }
        impact.work += self.apply(&all, &p, z);
        if !impact.stops.is_empty() {
            impacts.sequence.push(impact);
            self.take_shares(impacts);
        }
        Ok(())
    }

    /// Applies one impact of the stops with closing speeds `u`, by (A7).
    fn impact(&self, stops: &[usize], u: &[f64], zeros: &[f64], z: &mut DVector<f64>) -> Result<Impact, Jam> {
        let b = DVector::from_fn(u.len(), |k, _| (1.0 + self.restitution[stops[k]]) * u[k]);
        let p = self.impulses(stops, b, zeros)?;
        let mut impact = Impact { stops: Vec::new(), lost: 0.0, work: 0.0 };
        for (k, &stop) in stops.iter().enumerate() {
            if p[k] > 0.0 {
                impact.stops.push((stop, u[k], p[k]));
                impact.lost += 0.5 * (1.0 - self.restitution[stop]) * u[k] * p[k];
                impact.work += p[k] * self.prescribed_speed(stop, z);
            }
        }
        impact.work += self.apply(stops, &p, z);
        Ok(impact)
    }

    /// Includes the last impact in `shares`. The first impact of a single stop is left out: the
    /// sizes of the velocities before and after it suffice.
    fn take_shares(&self, impacts: &mut Impacts) {
        let alone = matches!(&impacts.sequence[..], [first] if first.stops.len() < 2);
        let Some(impact) = impacts.sequence.last().filter(|_| !alone) else { return };
        for (k, share) in impacts.shares.iter_mut().enumerate() {
            let of =
                |&(stop, _, p): &(usize, f64, f64)| p * self.system.stops[stop].elongation.mobility[k].abs();
            *share = share.max(impact.stops.iter().map(of).sum());
        }
    }

    /// Part of a stop's closing speed due to prescribed bodies.
    fn prescribed_speed(&self, stop: usize, z: &DVector<f64>) -> f64 {
        let n = self.system.coordinates;
        let e = &self.system.stops[stop].elongation;
        self.speed(stop, z) - e.w.dot(&z.rows(n, n))
    }

    /// Computes the impulses P: P ≥ 0, b - G P ≤ 0, complementary.
    fn impulses(&self, stops: &[usize], b: DVector<f64>, zeros: &[f64]) -> Result<DVector<f64>, Jam> {
        let contacts: Vec<Contact> = stops.iter().map(|&i| Contact::Stop(i)).collect();
        let count = stops.len();
        let problem = BoxProblem {
            columns: self.system.columns(&contacts),
            b,
            lo: DVector::zeros(count),
            hi: DVector::from_element(count, f64::INFINITY),
            zero: DVector::from_column_slice(zeros),
        };
        match problem.solve() {
            Ok(solution) => Ok(solution.lambda),
            Err(jam) => Err(Jam { contacts: jam.contacts.iter().map(|&k| stops[k]).collect() }),
        }
    }

    /// Changes velocities by impulses; returns the work of prescribed motions through links, J.
    fn apply(&self, stops: &[usize], p: &DVector<f64>, z: &mut DVector<f64>) -> f64 {
        let n = self.system.coordinates;
        let mut kick = DVector::zeros(n);
        for (k, &stop) in stops.iter().enumerate() {
            kick.axpy(p[k], &self.system.stops[stop].elongation.w, 1.0);
        }
        let change = self.system.inertia.solve(&kick);
        let work = self.system.carried(z).map_or(0.0, |carried| -carried.dot(&change));
        let mut v = z.rows_mut(n, n);
        v -= change;
        work
    }

    /// Projects the velocities, in the inertia's metric, so that no touching stop closes: an
    /// impact of all stops with restitution 0.
    fn project(&self, z: &mut DVector<f64>, impacts: &mut Impacts) -> Result<(), Jam> {
        let u: Vec<f64> = self.touching.iter().map(|&i| self.speed(i, z)).collect();
        let zeros: Vec<f64> =
            self.touching.iter().map(|&i| self.sizes.zero(&self.system.stops[i].elongation.rate)).collect();
        let p = self.impulses(self.touching, DVector::from_column_slice(&u), &zeros)?;
        for (k, &stop) in self.touching.iter().enumerate() {
            impacts.projected_loss += p[k] * (0.5 * u[k] - self.prescribed_speed(stop, z));
        }
        impacts.projected_loss -= self.apply(self.touching, &p, z);
        impacts.projected = true;
        Ok(())
    }
}
