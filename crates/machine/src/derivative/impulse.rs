//! The derivative of the impacts at one instant (docs/assembly-law.md (A36)).

use super::columns::Columns;
use super::machine::{BESIDE, STILL};
use super::tangent::Tangent;
use super::weights::Weights;
use crate::law::ZERO;
use crate::motion::Impulse;
use crate::system::System;
use nalgebra::DVector;

impl Impulse {
    /// Carries all columns of the state's derivative over the impact. `tangents` has one tangent
    /// for each column.
    pub(super) fn carry(&self, system: &System, tangents: &[Tangent], deltas: &mut Columns) {
        let (width, n) = (deltas.width, system.coordinates);
        let elongation = |k: usize| &system.stops[self.stops[k]].elongation;
        // The right side of (A36), by stop and column. First (1 + ε) ė·δ, from the columns.
        let mut demands = vec![0.0; self.stops.len() * width];
        for (k, demand) in demands.chunks_exact_mut(width).enumerate() {
            for &(j, x) in elongation(k).rate.terms() {
                let factor = (1.0 + self.restitution[k]) * x;
                let own = &deltas.numbers[j * width..][..width];
                demand.iter_mut().zip(own).for_each(|(sum, delta)| *sum += factor * delta);
            }
            demand[0] = 0.0;
        }
        for (p, tangent) in tangents.iter().enumerate().filter(|(_, tangent)| !tangent.is_zero) {
            let kick = self.kick(system, tangent);
            for (k, demand) in demands.chunks_exact_mut(width).enumerate() {
                demand[p + 1] += self.own_demand(system, tangent, k);
                if let Some(kick) = &kick {
                    demand[p + 1] -= elongation(k).w.dot(kick);
                }
            }
            if let Some(kick) = &kick {
                let rates = deltas.numbers[n * width + p + 1..].iter_mut().step_by(width);
                rates.zip(kick.iter()).for_each(|(v, kick)| *v -= kick);
            }
        }
        for (k, own) in (0..self.stops.len()).map(|k| (k, elongation(k))) {
            let mut impulse = vec![0.0; width];
            for (i, demand) in demands.chunks_exact(width).enumerate() {
                let factor = self.inverse[(k, i)];
                impulse.iter_mut().zip(demand).for_each(|(sum, x)| *sum += factor * x);
            }
            for &i in &own.reach {
                let rates = &mut deltas.numbers[(n + i) * width..][..width];
                rates.iter_mut().zip(&impulse).for_each(|(v, p)| *v -= own.mobility[i] * p);
            }
        }
    }

    /// Returns (M⁻¹ W)' P, without the derivative of the impulses P; `None` if the column varies
    /// neither M nor W.
    fn kick(&self, system: &System, tangent: &Tangent) -> Option<DVector<f64>> {
        let own = |k: usize| &tangent.stops[self.stops[k]].elongation.w;
        let turns = (0..self.stops.len()).any(|k| own(k).iter().any(|x| *x != 0.0));
        if !turns && !tangent.varies_mass {
            return None;
        }
        let mut kick = DVector::zeros(system.coordinates);
        for (k, p) in self.impulses.iter().enumerate() {
            kick.axpy(*p, own(k), 1.0);
            kick.gemv(-p, &tangent.mass, &system.stops[self.stops[k]].elongation.mobility, 1.0);
        }
        Some(system.inertia.solve(&kick))
    }

    /// The size of the terms of [`kick`](Self::kick).
    pub(super) fn kick_size(&self, system: &System, tangent: &Tangent) -> f64 {
        let one = |(k, p): (usize, &f64)| {
            let mobility = &system.stops[self.stops[k]].elongation.mobility;
            let kick = &tangent.stops[self.stops[k]].elongation.w - &tangent.mass * &**mobility;
            p.abs() * system.inertia.solve(&kick).amax()
        };
        self.impulses.iter().enumerate().map(one).sum()
    }

    /// Returns ė'·(z⁺ + ε z⁻) + ε' u of a stop.
    fn own_demand(&self, system: &System, tangent: &Tangent, k: usize) -> f64 {
        let [before, after] = &self.states;
        let (by, drate) = (&tangent.stops[self.stops[k]], &tangent.stops[self.stops[k]].elongation.rate);
        let varied = if self.closes[k] || by.restitution == 0.0 {
            0.0
        } else {
            by.restitution * system.stops[self.stops[k]].elongation.rate.dot(before)
        };
        drate.dot(after) + self.restitution[k] * drate.dot(before) + varied
    }

    /// Returns, for each impact, the touching stops that are [`tight`](Self::tight). A stop
    /// touches if its distance is zero within a fraction of the coordinates' `sizes`. Empty if
    /// fewer than two stops touch.
    pub(super) fn all_tight(system: &System, all: &[Self], sizes: &DVector<f64>) -> Vec<Vec<usize>> {
        let Some(first) = all.first() else { return Vec::new() };
        let touches = |&stop: &usize| {
            let stop = &system.stops[stop];
            let zero = BESIDE * ZERO * stop.excess.size(sizes.as_slice());
            stop.keeps_gap() && stop.excess.at(first.states[0].as_slice()).abs() <= zero
        };
        let touching: Vec<usize> = (0..system.stops.len()).filter(touches).collect();
        if touching.len() < 2 {
            return Vec::new();
        }
        all.iter().map(|impulse| impulse.tight(system, &touching)).collect()
    }

    /// Returns the stops at u⁺ = -ε u: the touching stops that satisfy it within rounding without
    /// an impulse and, if several stops are hit, these stops. Stops that no other impulse moves
    /// are left out. If a column moves a stop off this equality, only one-sided derivatives exist.
    fn tight(&self, system: &System, touching: &[usize]) -> Vec<usize> {
        let [before, after] = &self.states;
        // A body between two stops can have a small rate with the rounding error of large rates.
        // The tolerance therefore contains the largest rate.
        let rates = |z: &DVector<f64>| z.rows(system.coordinates, system.coordinates).amax();
        let largest = rates(before) + rates(after);
        let reaches = |stop: usize| {
            let w = &system.stops[stop].elongation.w;
            self.stops.iter().any(|&own| own != stop && w.dot(&system.stops[own].elongation.mobility) != 0.0)
        };
        let is_tight = |stop: usize| {
            let own = &system.stops[stop].elongation;
            let rate = &own.rate;
            let size = rate.size(before.as_slice()) + rate.size(after.as_slice()) + largest * own.w.amax();
            let (u, left) = (rate.dot(before), rate.dot(after));
            let takes = u >= -STILL * size;
            takes && (left + self.restitution_of(system, stop) * u).abs() <= STILL * size
        };
        let others = touching.iter().copied().filter(|stop| !self.stops.contains(stop));
        let own = self.stops.iter().copied().filter(|_| self.stops.len() > 1);
        own.chain(others.filter(|&stop| is_tight(stop))).filter(|&stop| reaches(stop)).collect()
    }

    fn restitution_of(&self, system: &System, stop: usize) -> f64 {
        let own = self.stops.iter().position(|&i| i == stop);
        own.map_or_else(|| system.stops[stop].restitution().unwrap_or(0.0), |k| self.restitution[k])
    }

    /// Carries one column over the impacts of one instant. `tight` is the result of
    /// [`all_tight`](Self::all_tight); `scale` has the largest size of each entry of the column so
    /// far.
    ///
    /// # Errors
    /// Index of the first [`tight`](Self::tight) stop that the column moves off u⁺ = -ε u.
    pub(super) fn carry_one(
        system: &System,
        tangent: &Tangent,
        (impacts, tight): (&[Self], &[Vec<usize>]),
        (delta, scale): (&DVector<f64>, &DVector<f64>),
    ) -> Result<DVector<f64>, usize> {
        let (mut delta, mut scale) = (delta.clone(), scale.clone());
        for (k, impulse) in impacts.iter().enumerate() {
            let tight = tight.get(k).map_or(&[][..], |stops| stops);
            let mut alone = Columns::zeros(delta.len(), 1);
            alone.put(0, &delta);
            impulse.carry(system, std::slice::from_ref(tangent), &mut alone);
            let after = alone.column(0);
            scale = scale.sup(&after.abs());
            let moves = |&stop: &usize| impulse.moves(system, tangent, stop, [&delta, &after, &scale]);
            if let Some(stop) = tight.iter().copied().find(moves) {
                return Err(stop);
            }
            delta = after;
        }
        Ok(delta)
    }

    /// Whether a column moves a [`tight`](Self::tight) stop off its equality. Uses the derivative
    /// of the state before and after the impact.
    fn moves(
        &self,
        system: &System,
        tangent: &Tangent,
        stop: usize,
        [before, after, scale]: [&DVector<f64>; 3],
    ) -> bool {
        let (row, by) = (&system.stops[stop].elongation.rate, &tangent.stops[stop]);
        let of = |k: usize, delta: &DVector<f64>| {
            let (z, drate) = (&self.states[k], &by.elongation.rate);
            let terms: f64 = drate.iter().zip(z.iter()).map(|(a, b)| (a * b).abs()).sum();
            (row.dot(delta) + drate.dot(z), row.size(scale.as_slice()) + terms)
        };
        let ((was, size_before), (is, size_after)) = (of(0, before), of(1, after));
        let (e, u) = (self.restitution_of(system, stop), row.dot(&self.states[0]));
        let closes = self.stops.iter().position(|&i| i == stop).is_some_and(|k| self.closes[k]);
        let de = if closes { 0.0 } else { by.restitution };
        let n = system.coordinates;
        let own = &system.stops[stop].elongation.w;
        let rates = scale.rows(n, n).amax() + self.kick_size(system, tangent);
        let size = size_before + size_after + (de * u).abs() + own.amax() * rates;
        let largest = own.amax() * self.states[0].rows(n, n).amax();
        let is_still = u.abs() <= STILL * (row.size(self.states[0].as_slice()) + largest);
        (is + e * was + de * u).abs() > STILL * size || (is_still && was.abs() > STILL * size)
    }

    /// Propagates an adjoint backwards through the impact (docs/assembly-law.md (A41)). On entry
    /// `state` is the derivative of a quantity with respect to the state after the impact, on
    /// return with respect to the state before it. `weights` receives the derivatives with respect
    /// to the matrices.
    pub(super) fn undo(&self, system: &System, state: &mut DVector<f64>, weights: &mut Weights) {
        let (n, [before, after]) = (system.coordinates, &self.states);
        let rows = |k: usize| &system.stops[self.stops[k]].elongation;
        let mut kick = state.rows(n, n).into_owned();
        let moved = DVector::from_iterator(
            self.stops.len(),
            (0..self.stops.len()).map(|k| rows(k).mobility.dot(&kick)),
        );
        let by_demands = self.inverse.tr_mul(&moved);
        for (k, &demand) in by_demands.iter().enumerate() {
            let e = self.restitution[k];
            kick.axpy(-demand, &rows(k).w, 1.0);
            state.axpy(-demand * (1.0 + e), &rows(k).rate, 1.0);
            let own = &mut weights.stops[self.stops[k]];
            own.elongation.rate.axpy(-demand, after, 1.0);
            own.elongation.rate.axpy(-demand * e, before, 1.0);
            if !self.closes[k] {
                own.restitution -= demand * rows(k).rate.dot(before);
            }
        }
        let (kick, mut moved) = (system.inertia.solve(&kick), DVector::zeros(n));
        for (k, &p) in self.impulses.iter().enumerate() {
            weights.add_direction(self.stops[k], p, &kick);
            moved.axpy(p, &rows(k).mobility, 1.0);
        }
        weights.add_mass(&kick, &moved);
    }

    /// Whether a stop was hit with restitution 0.
    pub(super) fn is_plastic(&self, system: &System) -> bool {
        self.stops.iter().any(|&i| system.stops[i].restitution() == Some(0.0))
    }

    /// Returns the first stop that was hit with restitution 0 and whose restitution depends on
    /// this parameter. A restitution cannot be negative, so the derivative there is one-sided.
    pub(super) fn at_limit(&self, system: &System, tangent: &Tangent) -> Option<usize> {
        let at_zero = |stop: usize| system.stops[stop].restitution() == Some(0.0);
        self.stops.iter().copied().find(|&stop| at_zero(stop) && tangent.stops[stop].restitution != 0.0)
    }
}
