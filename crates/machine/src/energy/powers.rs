//! The powers in a mode: products of two functionals of the state. Gauss's rule computes their
//! means over an interval.

use super::long::WorkIntegral;
use super::nodes::NodeStates;
use crate::flow::{FlowTable, Ladder, RADIUS, taylor};
use crate::functional::Functional;
use crate::kernel::{AtNodes, EIGHT, NODES, SHORT, Sparse, SparseColumns};
use crate::mode::Mode;
use crate::system::{Account, Losses, Power, System};
use std::sync::Arc;

/// Number of Taylor coefficients of a functional over a sub-step: for a rate times length of at
/// most 3, the first omitted term is below 3³²/32! < 8e-21 of the largest coordinate.
const TERMS: usize = 32;

/// Number of Taylor coefficients up to rate times span [`SHORT`]: 1.2²⁴/24! < 2e-22.
const FEW: usize = 24;

/// Powers of the nodes' abscissas, by order.
const fn powers_at<const G: usize, const T: usize>(nodes: &[(f64, f64); G]) -> [[f64; G]; T] {
    let mut powers = [[1.0; G]; T];
    let mut k = 1;
    while k < T {
        let mut i = 0;
        while i < G {
            powers[k][i] = powers[k - 1][i] * nodes[i].0;
            i += 1;
        }
        k += 1;
    }
    powers
}

const AT_NODES: [AtNodes; TERMS] = powers_at(&NODES);
const AT_EIGHT: [[f64; EIGHT.len()]; FEW] = powers_at(&EIGHT);

/// The weights of nodes.
const fn weights<const G: usize>(nodes: &[(f64, f64); G]) -> [f64; G] {
    let mut weights = [0.0; G];
    let mut i = 0;
    while i < G {
        weights[i] = nodes[i].1;
        i += 1;
    }
    weights
}

const WEIGHTS: AtNodes = weights(&NODES);
const WEIGHTS_OF_EIGHT: [f64; EIGHT.len()] = weights(&EIGHT);

/// Gauss's rule for a span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// [`EIGHT`] nodes.
    Eight,
    /// The [`NODES`].
    Twelve,
}

impl Rule {
    /// The rule for a span, by rate times span.
    #[inline(always)]
    pub fn of(radius: f64) -> Self {
        if radius <= SHORT { Self::Eight } else { Self::Twelve }
    }
}

/// The states within an interval of time, for the computation of powers.
pub enum Samples<'a> {
    /// The initial state and the interval's fraction of a sub-step; requires
    /// [stored coefficients](Powers::are_dense).
    Start(&'a [f64], f64),
    /// The coordinates at the nodes of a rule; the first coordinates may be missing.
    Coordinates(&'a [AtNodes], Rule),
    /// The states at the [`NODES`], one after the other, each of this length.
    States(&'a [f64], usize),
}

/// Construction of the rows' Taylor coefficients, compiled for each set of vector instructions.
struct Columns<'a> {
    rows: &'a [Sparse],
    table: &'a FlowTable,
}

impl pulp::WithSimd for Columns<'_> {
    type Output = Vec<SparseColumns<TERMS>>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Self::Output {
        let Self { rows, table } = self;
        let dense: Vec<_> = rows.iter().map(|row| row.dense(table.a.len())).collect();
        let all = taylor(&table.a.transpose(), &dense, table.length);
        all.iter().map(|columns| SparseColumns::of(columns)).collect()
    }
}

/// The powers in a mode.
#[derive(Clone, Debug, Default)]
pub struct Powers {
    rows: Arc<Vec<Sparse>>,
    /// Whether any of these rows has entries on coordinates.
    needs_places: bool,
    /// For each row: Taylor coefficients by coordinate, with time in units of a sub-step.
    columns: Vec<SparseColumns<TERMS>>,
    all: Vec<Power>,
    /// Work of each power over 2^k sub-steps, made on first use if tables are kept.
    long: Ladder<Vec<WorkIntegral>>,
}

impl Powers {
    /// The powers of a machine in a mode.
    pub fn new(system: &System, mode: &Mode, table: &FlowTable) -> Self {
        let system = &*system.at_mode(mode);
        if !table.is_dense() && !system.has_motions {
            return Self::of_losses(system, mode);
        }
        let mut powers = Self::default();
        powers.add_losses(system.losses(), mode);
        if system.has_motions {
            powers.add_motions(system, mode, table);
        }
        powers.needs_places = true;
        if table.is_dense() {
            powers.columns = crate::vectors::Vectors::new().dispatch(Columns { rows: &powers.rows, table });
        }
        powers
    }

    /// The powers of a machine without prescribed bodies, which share the machine's rows.
    fn of_losses(system: &System, mode: &Mode) -> Self {
        let losses = system.losses();
        let all: Vec<Power> = losses.of_mode(mode).cloned().collect();
        let is_place = |(j, _): &(usize, f64)| *j < system.coordinates;
        let has_places = |row: usize| losses.rows[row].terms().iter().any(is_place);
        let needs_places = all.iter().any(|power| power.of.into_iter().any(has_places));
        Self { rows: losses.rows.clone(), needs_places, all, ..Self::default() }
    }

    /// Calls `take` with the account and the work of each power over 2^`k` sub-steps from `z`.
    pub fn for_each_work(&self, k: usize, table: &FlowTable, z: &[f64], mut take: impl FnMut(Account, f64)) {
        if table.is_dense() {
            let works = self.all.iter().zip(self.works(k, table));
            return works.for_each(|(power, work)| take(power.account, power.factor * work.of(z)));
        }
        let states = NodeStates::over(k, table, z);
        for power in &self.all {
            let [left, right] = power.of.map(|place| &self.rows[place]);
            take(power.account, power.factor * states.product(left, right));
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
                let rows: Vec<_> = self.rows.iter().map(|row| row.dense(size)).collect();
                let all = taylor(&table.a.transpose(), &rows, table.length);
                let at_nodes =
                    |columns: &Vec<_>| columns.iter().map(|c| at_nodes(c, &AT_NODES)).collect::<Vec<_>>();
                let rows: Vec<_> = all.iter().map(at_nodes).collect();
                self.all
                    .iter()
                    .map(|power| {
                        let [left, right] = power.of;
                        let right = (left != right).then(|| &rows[right][..]);
                        WorkIntegral::new(&rows[left], right, table.length)
                    })
                    .collect()
            }
        })
    }

    fn add(&mut self, account: Account, factor: f64, rows: [Sparse; 2]) {
        if factor == 0.0 || rows.iter().any(|row| row.terms().is_empty()) {
            return;
        }
        let of = rows.map(|row| {
            self.rows.iter().position(|known| *known == row).unwrap_or_else(|| {
                Arc::make_mut(&mut self.rows).push(row);
                self.rows.len() - 1
            })
        });
        self.all.push(Power { account, factor, of });
    }

    /// Adds the loads and losses of a mode; equal rows are stored once.
    fn add_losses(&mut self, losses: &Losses, mode: &Mode) {
        for Power { account, factor, of } in losses.of_mode(mode) {
            self.add(*account, *factor, of.map(|row| losses.rows[row].clone()));
        }
    }

    /// Adds the powers of prescribed bodies (docs/assembly-law.md (A21)).
    fn add_motions(&mut self, system: &System, mode: &Mode, table: &FlowTable) {
        let n = system.coordinates;
        let mut add = |factor: f64, force: &Functional, rate: &Functional| {
            let prescribed = rate.terms().iter().copied().filter(|term| !(n..2 * n).contains(&term.0));
            let force = AsRef::<Sparse>::as_ref(force).clone();
            self.add(Account::Motions, factor, [force, Sparse::from_terms(prescribed)]);
        };
        for (row, &body) in system.loads.iter().zip(&system.load_bodies) {
            add(-1.0, row, &system.bodies[body].v);
        }
        for spring in &system.springs {
            add(1.0, &spring.force, &spring.elongation.rate);
        }
        for (body, force) in system.gyroscopic_forces() {
            add(1.0, &Functional::of(force), &system.bodies[body].v);
        }
        for (i, branch) in system.branches.iter().enumerate() {
            add(1.0, &system.branch_force(i, mode.sliders[i]), &branch.elongation.rate);
        }
        for (i, stop) in system.stops.iter().enumerate() {
            if let Some(force) = system.stop_force(i, mode.stops[i]) {
                add(1.0, &force, &stop.elongation.rate);
            }
        }
        for (i, friction) in system.frictions.iter().enumerate() {
            if let Some(force) = system.friction_force(i, mode.frictions[i], &mode.stops) {
                add(1.0, &force, &friction.elongation.rate);
            }
        }
        for (&contact, force) in mode.basis.iter().zip(&table.lambda) {
            let force = Functional::from_terms(system.signals.size, force.terms().iter().copied());
            add(1.0, &force, &system.elongation_of(contact).rate);
        }
        // Links transmit the inertia and weight of free bodies to prescribed ones.
        for (i, body) in system.bodies.iter().enumerate().filter(|(i, _)| system.inertias[*i] > 0.0) {
            let size = system.signals.size;
            let row = |&(k, weight): &(usize, f64)| {
                let row = Functional::from_terms(size, table.a.row(n + k).iter().copied());
                (system.inertias[i] * weight, row)
            };
            let rows: Vec<(f64, Functional)> = body.weights.terms().iter().map(row).collect();
            let drift = std::iter::once((system.inertias[i], &body.drift));
            let (rows, weight) = (rows.iter().map(|own| (own.0, &own.1)), system.constant(system.weights[i]));
            let force = Functional::sum(size, drift.chain(rows).chain([(-1.0, &weight)]));
            add(1.0, &force, &body.v);
        }
    }

    /// Whether Taylor coefficients are stored, as [`Samples::Start`] requires.
    pub fn are_dense(&self) -> bool {
        !self.columns.is_empty() || self.all.is_empty()
    }

    /// Count of stored numbers.
    pub fn numbers(&self) -> usize {
        self.columns.iter().map(SparseColumns::numbers).sum::<usize>()
            + self.long.made().flatten().map(WorkIntegral::numbers).sum::<usize>()
    }

    /// Calls `take` with the account and the mean of each power over an interval. `values` is
    /// scratch memory.
    #[inline(always)]
    pub fn for_each(&self, samples: &Samples, values: &mut Vec<AtNodes>, take: impl FnMut(Account, f64)) {
        match *samples {
            Samples::Start(z, part) => {
                values.resize(self.rows.len(), [0.0; NODES.len()]);
                match Rule::of(RADIUS * part) {
                    Rule::Eight => {
                        self.rows_at(z, part, &AT_EIGHT, values);
                        self.means(&WEIGHTS_OF_EIGHT, |place| *first(&values[place]), take);
                    }
                    Rule::Twelve => {
                        self.rows_at(z, part, &AT_NODES, values);
                        self.means(&WEIGHTS, |place| values[place], take);
                    }
                }
            }
            Samples::Coordinates(at, Rule::Eight) => {
                self.means(&WEIGHTS_OF_EIGHT, |place| row_at(&self.rows[place], at), take);
            }
            Samples::Coordinates(at, Rule::Twelve) => {
                self.means(&WEIGHTS, |place| row_at(&self.rows[place], at), take);
            }
            Samples::States(states, size) => {
                let row = |row: &Sparse| std::array::from_fn(|node| row.dot(&states[node * size..][..size]));
                self.means(&WEIGHTS, |place| row(&self.rows[place]), take);
            }
        }
    }

    /// Values of the rows at the nodes from the state at the start, with one coefficient for each
    /// order in `powers`.
    #[inline(always)]
    fn rows_at<const T: usize, const G: usize>(
        &self,
        z: &[f64],
        part: f64,
        powers: &[[f64; G]; T],
        values: &mut [AtNodes],
    ) {
        let parts = powers_of::<T>(part);
        for (value, columns) in values.iter_mut().zip(&self.columns) {
            let mut c = columns.first_times(z);
            c.iter_mut().zip(&parts).for_each(|(c, part)| *c *= part);
            value[..G].copy_from_slice(&at_nodes(&c, powers));
        }
    }

    /// Calls `take` with the account and the mean of each power, from the values of the rows.
    #[inline(always)]
    fn means<const G: usize>(
        &self,
        weights: &[f64; G],
        row: impl Fn(usize) -> [f64; G],
        mut take: impl FnMut(Account, f64),
    ) {
        for power in &self.all {
            let [place, other] = power.of;
            let left = row(place);
            let right = if place == other { left } else { row(other) };
            let mut sums = [0.0; 4];
            for i in 0..G {
                sums[i % 4] += weights[i] * left[i] * right[i];
            }
            take(power.account, power.factor * ((sums[0] + sums[1]) + (sums[2] + sums[3])));
        }
    }

    /// First index on which any power depends: 0, or the first velocity.
    pub fn first(&self, coordinates: usize) -> usize {
        if self.needs_places { 0 } else { coordinates }
    }
}

/// The first `G` values of a list for twelve nodes.
#[inline(always)]
fn first<const G: usize>(values: &AtNodes) -> &[f64; G] {
    values.first_chunk().expect("no rule has more nodes")
}

/// Values of a row at the nodes, from the values of the coordinates there.
#[inline(always)]
fn row_at<const G: usize>(row: &Sparse, at: &[AtNodes]) -> [f64; G] {
    let mut sum = [0.0; G];
    for &(j, x) in row.terms() {
        sum.iter_mut().zip(&at[j]).for_each(|(sum, y)| *sum += x * y);
    }
    sum
}

/// Powers of a fraction of a sub-step, by order.
#[inline(always)]
fn powers_of<const T: usize>(part: f64) -> [f64; T] {
    let mut powers = [1.0; T];
    for k in 1..4 {
        powers[k] = powers[k - 1] * part;
    }
    let fourth = powers[3] * part;
    for k in 4..T {
        powers[k] = powers[k - 4] * fourth;
    }
    powers
}

/// Values of a power series at nodes, from the nodes' powers.
#[inline(always)]
fn at_nodes<const T: usize, const G: usize>(coefficients: &[f64; T], powers: &[[f64; G]; T]) -> [f64; G] {
    let mut sum = [0.0; G];
    for (c, powers) in coefficients.iter().zip(powers) {
        for (sum, power) in sum.iter_mut().zip(powers) {
            *sum += c * power;
        }
    }
    sum
}

#[cfg(test)]
mod tests;
