//! Energy accounts: work of loads and of prescribed motions, and losses in dashpots, compliant stops, friction and impacts, found
//! without the mechanical energy, so that the balance is a test (docs/assembly-law.md (A16) to (A18)).

use crate::flow::Table;
pub use crate::kernel::NODES;
use crate::kernel::Sparse;
use crate::mode::{Mode, StopState};
use crate::system::{Row, System};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use vibro_impact::numerics::double_double::DoubleDouble;

/// Values at the [`NODES`] of a flight.
pub type AtNodes = [f64; NODES.len()];

/// Gauss's mean of a function over a flight.
#[inline(always)]
fn mean(values: &AtNodes) -> f64 {
    values.iter().zip(&NODES).map(|(value, node)| node.1 * value).sum()
}

/// Orders of a flight's series, at most.
const MOST_ORDERS: usize = 40;

/// Powers of the nodes' places, by order.
const POWERS: [AtNodes; MOST_ORDERS] = {
    let mut powers = [[1.0; NODES.len()]; MOST_ORDERS];
    let mut k = 1;
    while k < MOST_ORDERS {
        let mut i = 0;
        while i < NODES.len() {
            powers[k][i] = powers[k - 1][i] * NODES[i].0;
            i += 1;
        }
        k += 1;
    }
    powers
};

/// A flight as rows of states.
pub enum Samples<'a> {
    /// The states at the nodes, one after another, of so many coordinates.
    States(&'a [f64], usize),
    /// The coefficients of the power series in the part that has passed, likewise.
    Series(&'a [f64], usize),
}

impl Samples<'_> {
    /// A functional at the nodes.
    #[inline(always)]
    fn of(&self, row: &Sparse) -> AtNodes {
        match *self {
            Self::States(states, size) => std::array::from_fn(|k| row.dot(&states[k * size..])),
            Self::Series(terms, size) => {
                let mut sum = [0.0; NODES.len()];
                for (term, powers) in terms.chunks_exact(size).zip(&POWERS) {
                    let coefficient = row.dot(term);
                    sum.iter_mut().zip(powers).for_each(|(sum, power)| *sum += coefficient * power);
                }
                sum
            }
        }
    }

    /// The state at a node.
    fn state(&self, node: usize, to: &mut [f64]) {
        match *self {
            Self::States(states, size) => to.copy_from_slice(&states[node * size..][..size]),
            Self::Series(terms, size) => {
                to.fill(0.0);
                for (term, powers) in terms.chunks_exact(size).zip(&POWERS) {
                    to.iter_mut().zip(term).for_each(|(sum, x)| *sum += powers[node] * x);
                }
            }
        }
    }
}

/// Sums since the start, J. Losses are positive.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
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

    /// A flight of length `dt` in a mode; `point` is memory for a state.
    #[inline(always)]
    pub fn add(
        &mut self,
        (system, mode, table): (&System, &Mode, &Table),
        dt: f64,
        samples: &Samples,
        point: &mut DVector<f64>,
    ) {
        if !self.enabled || dt == 0.0 {
            return;
        }
        self.add_losses(system, mode, samples, dt);
        if system.has_motions {
            let power = std::array::from_fn(|k| {
                samples.state(k, point.as_mut_slice());
                power_of_motions(system, mode, table, point)
            });
            self.motions = self.motions.plus(dt * mean(&power));
        }
    }

    /// Whether they are kept.
    pub(crate) fn are_kept(&self) -> bool {
        self.enabled
    }

    #[inline(always)]
    fn add_losses(&mut self, system: &System, mode: &Mode, samples: &Samples, dt: f64) {
        let add = |sum: &mut DoubleDouble, power: &AtNodes| *sum = sum.plus(dt * mean(power));
        let product = |a: &AtNodes, b: &AtNodes| std::array::from_fn(|k| a[k] * b[k]);
        for (sum, (row, &body)) in
            self.loads.iter_mut().zip(system.load_terms.iter().zip(&system.load_bodies))
        {
            if !row.terms().is_empty() {
                add(sum, &product(&samples.of(row), &samples.of(&system.bodies[body].v_terms)));
            }
        }
        for (sum, spring) in self.dashpots.iter_mut().zip(&system.springs) {
            if spring.damping > 0.0 {
                let rate = samples.of(&spring.elongation.rate_terms);
                add(sum, &rate.map(|rate| spring.damping * rate * rate));
            }
        }
        for (i, sum) in self.stops.iter_mut().enumerate() {
            let stop = &system.stops[i];
            // What the force does beyond the stored energy ½ k max(0, e - gap)².
            let spring = || samples.of(&stop.spring_terms);
            let excess: AtNodes = match mode.stops[i] {
                StopState::Open | StopState::Closed | StopState::Below => continue,
                StopState::Pressed => {
                    let (force, spring) = (samples.of(&stop.force_terms), spring());
                    std::array::from_fn(|k| force[k] - spring[k].max(0.0))
                }
                StopState::Free => spring().map(|spring| -spring.max(0.0)),
                StopState::Capped => spring().map(|spring| 2.0 * spring - spring.max(0.0)),
            };
            add(sum, &product(&excess, &samples.of(&stop.elongation.rate_terms)));
        }
        for (i, sum) in self.frictions.iter_mut().enumerate() {
            let direction = mode.frictions[i].direction();
            if direction != 0.0 {
                let friction = &system.frictions[i];
                let (level, rate) =
                    (samples.of(&friction.level_terms), samples.of(&friction.elongation.rate_terms));
                add(sum, &product(&level.map(|level| direction * level), &rate));
            }
        }
    }
}

/// The power that prescribed bodies put in (docs/assembly-law.md (A17)).
#[inline(never)]
fn power_of_motions(system: &System, mode: &Mode, table: &Table, z: &DVector<f64>) -> f64 {
    let n = system.coordinates;
    let prescribed = |rate: &Row| rate.dot(z) - rate.rows(n, n).dot(&z.rows(n, n));
    let mut power = 0.0;
    for (row, &body) in system.loads.iter().zip(&system.load_bodies) {
        power -= row.dot(z) * prescribed(&system.bodies[body].v);
    }
    for spring in &system.springs {
        power += spring.force.dot(z) * prescribed(&spring.elongation.rate);
    }
    for (i, stop) in system.stops.iter().enumerate() {
        if let Some(force) = system.stop_force_at(i, mode.stops[i], z) {
            power += force * prescribed(&stop.elongation.rate);
        }
    }
    for (i, friction) in system.frictions.iter().enumerate() {
        if let Some(force) = system.friction_force_at(i, mode.frictions[i], z) {
            power += force * prescribed(&friction.elongation.rate);
        }
    }
    for (&contact, row) in mode.basis.iter().zip(&table.lambda) {
        power += row.dot(z) * prescribed(&system.elongation_of(contact).rate);
    }
    // Links that tie free bodies to prescribed ones carry these bodies' inertia and weight.
    for (i, body) in system.bodies.iter().enumerate() {
        let rate = prescribed(&body.v);
        if system.inertias[i] > 0.0 && rate != 0.0 {
            let weights = body.weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0);
            let free: f64 = weights.map(|(k, w)| w * table.a.row_times(n + k, z.as_slice())).sum();
            power += (system.inertias[i] * (free + body.drift.dot(z)) - system.weights[i]) * rate;
        }
    }
    power
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
