//! Energy accounts: work of loads and of prescribed motions, and losses in dashpots, compliant stops, friction and impacts, found
//! without the mechanical energy, so that the balance is a test (docs/assembly-law.md (A16) to (A18)).

use crate::flow::Table;
use crate::mode::{Contact, Mode};
use crate::system::{Row, System};
use nalgebra::DVector;
use vibro_impact::numerics::double_double::DoubleDouble;

/// Abscissas and weights of Gauss's rule with eight nodes on [-1, 1], the positive half (Abramowitz and Stegun, table 25.4).
/// The powers are products of two functions of rate r over a span of at most 2/r: the rule's error is under 1e-17 of their size.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_47),
    (0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
];

/// Sums since the start, J. Losses are positive.
#[derive(Clone, Debug, Default)]
pub struct Accounts {
    enabled: bool,
    /// Work of each load.
    pub loads: Vec<DoubleDouble>,
    /// Work of the prescribed motions.
    pub motions: DoubleDouble,
    /// Lost in each spring's dashpot.
    pub dashpots: Vec<DoubleDouble>,
    /// Lost in each compliant stop.
    pub stops: Vec<DoubleDouble>,
    /// Lost in each friction.
    pub frictions: Vec<DoubleDouble>,
    /// Lost at impacts.
    pub impacts: DoubleDouble,
}

impl Accounts {
    /// Empty accounts of a machine.
    pub fn new(system: &System) -> Self {
        let zero = |count: usize| vec![DoubleDouble::default(); count];
        Self {
            enabled: true,
            loads: zero(system.loads.len()),
            motions: DoubleDouble::default(),
            dashpots: zero(system.springs.len()),
            stops: zero(system.stops.len()),
            frictions: zero(system.frictions.len()),
            impacts: DoubleDouble::default(),
        }
    }

    /// Accounts that are not kept.
    pub fn off(mut self) -> Self {
        self.enabled = false;
        self
    }

    /// Work put in less losses, J: the change of the mechanical energy since the start.
    pub fn balance(&self) -> f64 {
        let minus = |sum: DoubleDouble, x: &DoubleDouble| sum.minus(*x);
        let put_in = self.loads.iter().fold(self.motions, |sum, x| sum + *x);
        let dashpots = self.dashpots.iter().fold(put_in, minus);
        let stops = self.stops.iter().fold(dashpots, minus);
        let frictions = self.frictions.iter().fold(stops, minus);
        frictions.minus(self.impacts).value()
    }

    /// An impact's loss and the work that prescribed motions did in it.
    pub fn impact(&mut self, lost: f64, work: f64) {
        self.impacts = self.impacts.plus(lost);
        self.motions = self.motions.plus(work);
    }

    /// A flight of length `dt` from `z` in a mode.
    pub fn add(&mut self, system: &System, mode: &Mode, table: &Table, z: &DVector<f64>, dt: f64) {
        if !self.enabled || dt == 0.0 {
            return;
        }
        for (x, weight) in GAUSS {
            for place in [0.5 * (1.0 - x), 0.5 * (1.0 + x)] {
                let there = table.state_after(z, place * dt);
                self.add_powers(system, mode, table, &there, 0.5 * weight * dt);
            }
        }
    }

    fn add_powers(&mut self, system: &System, mode: &Mode, table: &Table, z: &DVector<f64>, weight: f64) {
        let n = system.coordinates;
        let add = |sum: &mut DoubleDouble, power: f64| *sum = sum.plus(weight * power);
        let prescribed = |rate: &Row| rate.dot(z) - rate.rows(n, n).dot(&z.rows(n, n));
        let mut motions = 0.0;
        for (sum, (row, &body)) in self.loads.iter_mut().zip(system.loads.iter().zip(&system.load_bodies)) {
            let (force, v) = (row.dot(z), &system.bodies[body].v);
            add(sum, force * v.dot(z));
            motions -= force * prescribed(v);
        }
        for (sum, spring) in self.dashpots.iter_mut().zip(&system.springs) {
            let rate = spring.elongation.rate.dot(z);
            add(sum, spring.damping * rate * rate);
            motions += spring.force.dot(z) * prescribed(&spring.elongation.rate);
        }
        for (i, sum) in self.stops.iter_mut().enumerate() {
            let stop = &system.stops[i];
            let rate = stop.elongation.rate.dot(z);
            let force = system.stop_force(i, mode.stops[i]).map_or(0.0, |row| row.dot(z));
            // What the force does beyond the stored energy ½ k max(0, e - gap)².
            let stored = if stop.excess.dot(z) > 0.0 { stop.spring.dot(z) } else { 0.0 };
            add(sum, (force - stored) * rate);
            motions += force * prescribed(&stop.elongation.rate);
        }
        for (i, sum) in self.frictions.iter_mut().enumerate() {
            let friction = &system.frictions[i];
            if let Some(force) = system.friction_force(i, mode.frictions[i]) {
                let force = force.dot(z);
                add(sum, force * friction.elongation.rate.dot(z));
                motions += force * prescribed(&friction.elongation.rate);
            }
        }
        for (&contact, row) in mode.basis.iter().zip(&table.lambda) {
            let rate = match contact {
                Contact::Stop(i) => &system.stops[i].elongation.rate,
                Contact::Friction(i) => &system.frictions[i].elongation.rate,
            };
            motions += row.dot(z) * prescribed(rate);
        }
        // Links that tie free bodies to prescribed ones carry these bodies' inertia and weight.
        let acceleration = table.a.rows(n, n) * z;
        for (i, body) in system.bodies.iter().enumerate() {
            if system.inertias[i] > 0.0 {
                let s2 = body.weights.dot(&acceleration) + body.drift.dot(z);
                motions += (system.inertias[i] * s2 - system.weights[i]) * prescribed(&body.v);
            }
        }
        add(&mut self.motions, motions);
    }
}

/// Kinetic and stored energy, J: of springs ½ k e² + preload e, of compliant stops ½ k max(0, e - gap)², of weight.
pub fn mechanical(system: &System, z: &DVector<f64>) -> (f64, f64) {
    let (mut kinetic, mut stored) = (0.0, 0.0);
    for ((body, &inertia), &weight) in system.bodies.iter().zip(&system.inertias).zip(&system.weights) {
        let v = body.v.dot(z);
        kinetic += 0.5 * inertia * v * v;
        stored -= weight * body.s.dot(z);
    }
    for spring in &system.springs {
        let e = spring.elongation.e.dot(z);
        stored += e * (0.5 * spring.stiffness * e + spring.preload);
    }
    for stop in &system.stops {
        let excess = stop.excess.dot(z).max(0.0);
        stored += 0.5 * stop.spring.dot(z).max(0.0) * excess;
    }
    (kinetic, stored)
}
