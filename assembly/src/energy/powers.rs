//! The powers in a mode: products of two functionals of the state, whose means over an interval are
//! computed by Gauss's rule.

use super::long::WorkIntegral;
use super::{AtNodes, NODES};
use crate::description::StopLaw;
use crate::flow::{FlowTable, Ladder, Series, taylor};
use crate::kernel::{Sparse, SparseColumns};
use crate::mode::{Mode, StopState};
use crate::system::{StateRow, System};

/// Number of Taylor coefficients of a functional over a sub-step. With rate times length at most 3
/// the first omitted term is below 3³²/32! < 8e-21 of the largest coordinate.
const TERMS: usize = 32;

/// Powers of the [`NODES`]' abscissas, by order.
const POWERS: [AtNodes; TERMS] = {
    let mut powers = [[1.0; NODES.len()]; TERMS];
    let mut k = 1;
    while k < TERMS {
        let mut i = 0;
        while i < NODES.len() {
            powers[k][i] = powers[k - 1][i] * NODES[i].0;
            i += 1;
        }
        k += 1;
    }
    powers
};

/// The account to which a power belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Account {
    /// Work of a load.
    Load(usize),
    /// Work of prescribed motions.
    Motions,
    /// Loss in a spring's dashpot.
    Dashpot(usize),
    /// Loss in a compliant stop.
    Stop(usize),
    /// Loss in a friction.
    Friction(usize),
}

/// The states within an interval of time, from which powers are computed.
pub enum Samples<'a> {
    /// The initial state and the interval's fraction of a sub-step; requires
    /// [stored coefficients](Powers::are_dense).
    Start(&'a [f64], f64),
    /// The state's power series over a sub-step, and the interval's fraction of it.
    Series(&'a Series, f64),
    /// The states at the [`NODES`] one after another, and the length of each.
    States(&'a [f64], usize),
}

/// A factor times the product of two functionals.
#[derive(Clone, Debug)]
struct Power {
    account: Account,
    factor: f64,
    /// Places of the two functionals.
    of: [usize; 2],
}

/// The powers in a mode.
#[derive(Clone, Debug, Default)]
pub struct Powers {
    rows: Vec<Sparse>,
    /// Taylor coefficients of each row, in units of a sub-step, by coordinate.
    columns: Vec<SparseColumns<TERMS>>,
    all: Vec<Power>,
    /// Work of each power over 2^k sub-steps, made on first use.
    long: Ladder<Vec<WorkIntegral>>,
}

impl Powers {
    /// The powers of a machine in a mode.
    pub fn new(system: &System, mode: &Mode, table: &FlowTable) -> Self {
        let mut powers = Self::default();
        powers.add_losses(system, mode);
        if system.has_motions {
            powers.add_motions(system, mode, table);
        }
        if table.is_dense() {
            let size = system.signals.size;
            let columns = |row: &Sparse| taylor(&table.a, &row.dense(size), 1.0, table.length);
            powers.columns = powers.rows.iter().map(|row| SparseColumns::of(columns(row))).collect();
        }
        powers
    }

    /// Calls `take` with the account and the work of each power over 2^`k` sub-steps from `z`.
    pub fn for_each_work(&self, k: usize, table: &FlowTable, z: &[f64], mut take: impl FnMut(Account, f64)) {
        for (power, work) in self.all.iter().zip(self.works(k, table)) {
            take(power.account, power.factor * work.of(z));
        }
    }

    fn works(&self, k: usize, table: &FlowTable) -> &[WorkIntegral] {
        self.long.at(k).get_or_init(|| match k.checked_sub(1) {
            Some(below) => {
                let rung = table.rung(below);
                self.works(below, table).iter().map(|work| work.doubled(rung)).collect()
            }
            None => {
                let size = table.a.len();
                let at_nodes = |row: &Sparse| {
                    let columns = taylor(&table.a, &row.dense(size), 1.0, table.length);
                    columns.iter().map(|c: &[f64; TERMS]| at_nodes(c)).collect::<Vec<_>>()
                };
                let rows: Vec<_> = self.rows.iter().map(at_nodes).collect();
                self.all
                    .iter()
                    .map(|power| WorkIntegral::new(power.of.map(|i| &rows[i][..]), table.length))
                    .collect()
            }
        })
    }

    fn add(&mut self, account: Account, factor: f64, left: &StateRow, right: &StateRow) {
        let rows = [left, right].map(|row| Sparse::of(row.as_slice()));
        if factor == 0.0 || rows.iter().any(|row| row.terms().is_empty()) {
            return;
        }
        let of = rows.map(|row| {
            self.rows.iter().position(|known| *known == row).unwrap_or_else(|| {
                self.rows.push(row);
                self.rows.len() - 1
            })
        });
        self.all.push(Power { account, factor, of });
    }

    /// Adds loads and losses. The loss of a compliant stop is the work of its force beyond the
    /// stored energy ½ k max(0, e - gap)².
    fn add_losses(&mut self, system: &System, mode: &Mode) {
        for (i, (row, &body)) in system.loads.iter().zip(&system.load_bodies).enumerate() {
            self.add(Account::Load(i), 1.0, row, &system.bodies[body].v);
        }
        for (i, spring) in system.springs.iter().enumerate() {
            let rate = &spring.elongation.rate;
            self.add(Account::Dashpot(i), spring.damping, rate, rate);
        }
        for (i, stop) in system.stops.iter().enumerate() {
            let (rate, account) = (&stop.elongation.rate, Account::Stop(i));
            match (mode.stops[i], stop.law) {
                (StopState::Pressed, StopLaw::Compliant { damping, .. }) => {
                    self.add(account, damping, rate, rate);
                }
                (StopState::Free, _) => self.add(account, -1.0, &stop.spring, rate),
                (StopState::Capped, _) => self.add(account, 1.0, &stop.spring, rate),
                _ => {}
            }
        }
        for (i, friction) in system.frictions.iter().enumerate() {
            let direction = mode.frictions[i].direction();
            self.add(Account::Friction(i), direction, &friction.level, &friction.elongation.rate);
        }
    }

    /// Adds the powers of prescribed bodies (docs/assembly-law.md (A17)).
    fn add_motions(&mut self, system: &System, mode: &Mode, table: &FlowTable) {
        let n = system.coordinates;
        let mut add = |factor: f64, force: &StateRow, rate: &StateRow| {
            let mut prescribed = rate.clone();
            prescribed.rows_mut(n, n).fill(0.0);
            self.add(Account::Motions, factor, force, &prescribed);
        };
        for (row, &body) in system.loads.iter().zip(&system.load_bodies) {
            add(-1.0, row, &system.bodies[body].v);
        }
        for spring in &system.springs {
            add(1.0, &spring.force, &spring.elongation.rate);
        }
        for (i, stop) in system.stops.iter().enumerate() {
            if let Some(force) = system.stop_force(i, mode.stops[i]) {
                add(1.0, &force, &stop.elongation.rate);
            }
        }
        for (i, friction) in system.frictions.iter().enumerate() {
            if let Some(force) = system.friction_force(i, mode.frictions[i]) {
                add(1.0, &force, &friction.elongation.rate);
            }
        }
        for (&contact, force) in mode.basis.iter().zip(&table.lambda) {
            add(1.0, force, &system.elongation_of(contact).rate);
        }
        // Links transmit the inertia and weight of free bodies to prescribed ones.
        for (i, body) in system.bodies.iter().enumerate().filter(|(i, _)| system.inertias[*i] > 0.0) {
            let mut force = system.inertias[i] * &body.drift;
            for (k, weight) in body.weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
                force.axpy(system.inertias[i] * weight, &table.a.row_of(n + k), 1.0);
            }
            force[system.signals.one] -= system.weights[i];
            add(1.0, &force, &body.v);
        }
    }

    /// Whether Taylor coefficients are stored, as [`Samples::Start`] requires.
    pub fn are_dense(&self) -> bool {
        !self.columns.is_empty() || self.rows.is_empty()
    }

    /// Count of stored numbers.
    pub fn numbers(&self) -> usize {
        self.columns.iter().map(SparseColumns::numbers).sum::<usize>()
            + self.long.made().flatten().map(WorkIntegral::numbers).sum::<usize>()
    }

    /// Calls `take` with the account and the mean of each power over an interval. `values` is
    /// scratch memory.
    #[inline(always)]
    pub fn for_each(&self, samples: &Samples, values: &mut Vec<AtNodes>, mut take: impl FnMut(Account, f64)) {
        values.resize(self.rows.len(), [0.0; NODES.len()]);
        match *samples {
            Samples::Start(z, part) => {
                let parts = powers_of(part);
                for (value, columns) in values.iter_mut().zip(&self.columns) {
                    let mut c = columns.times(z);
                    c.iter_mut().zip(&parts).for_each(|(c, part)| *c *= part);
                    *value = at_nodes(&c);
                }
            }
            Samples::Series(series, part) => {
                let parts = powers_of(part);
                for (value, row) in values.iter_mut().zip(&self.rows) {
                    let mut c = [0.0; TERMS];
                    for ((c, term), part) in c.iter_mut().zip(series.terms()).zip(&parts) {
                        *c = part * row.dot(term);
                    }
                    *value = at_nodes(&c);
                }
            }
            Samples::States(states, size) => {
                for (value, row) in values.iter_mut().zip(&self.rows) {
                    *value = std::array::from_fn(|k| row.dot(&states[k * size..]));
                }
            }
        }
        for power in &self.all {
            let [left, right] = power.of.map(|place| &values[place]);
            let mut mean = 0.0;
            for (k, node) in NODES.iter().enumerate() {
                mean += node.1 * left[k] * right[k];
            }
            take(power.account, power.factor * mean);
        }
    }
}

/// Powers of a fraction of a sub-step, by order.
#[inline(always)]
fn powers_of(part: f64) -> [f64; TERMS] {
    let mut parts = [1.0; TERMS];
    for k in 1..TERMS {
        parts[k] = parts[k / 2] * parts[(k - 1) / 2] * part;
    }
    parts
}

/// Values of a power series at the [`NODES`].
#[inline(always)]
fn at_nodes(coefficients: &[f64; TERMS]) -> AtNodes {
    let mut sum = [0.0; NODES.len()];
    for (c, powers) in coefficients.iter().zip(&POWERS) {
        for (sum, power) in sum.iter_mut().zip(powers) {
            *sum += c * power;
        }
    }
    sum
}

#[cfg(test)]
mod tests;
