//! Series and tables of random modes against exact terms: the remainders proved by (A6), the
//! bounds that exclude passages, and the states.

use super::super::*;
use super::wide::Wide;
use crate::file::{no_records, parse};
use crate::mode::{FrictionState, StopState};
use crate::system::System;
use crate::{Assembly, Motion};
use std::fmt::Write as _;
use std::sync::Arc;
use vibro_numerics::double_double::DoubleDouble;

/// Number of random modes, and of sub-steps of each.
const MODES: usize = 300;
const STEPS: usize = 8;
/// Order of the last exact term; 4^60/60! < 2e-46.
const LAST: usize = 60;
/// Tolerance for a state or functional, relative to the sum of all terms.
const STATE: f64 = 1e-15;
/// Relative tolerance for a bound, which is a sum of up to some hundred products.
const ROUNDING: f64 = 1e-12;

/// Fraction of each bound that is attained in at least one sub-step.
const ATTAINED: f64 = 0.9;

/// Pseudo-random numbers (xorshift).
struct Draw(u64);

impl Draw {
    /// A number from 0 to 1.
    fn part(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 * 0.5f64.powi(53)
    }

    fn between(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.part()
    }

    fn below(&mut self, count: usize) -> usize {
        (self.part() * count as f64) as usize
    }

    fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }
}

/// A machine of 1 to 16 bodies with inertias from 1e-3 to 1e3, springs, stops and frictions with
/// arms of any length, some bodies linked.
fn machine(draw: &mut Draw) -> Arc<Assembly> {
    let count = 1 + draw.below(16);
    // Frequencies are similar in spite of different inertias, or unrelated.
    let (spread, is_alike) = (draw.of(&[0.0, 1.0, 3.0]), draw.part() < 0.5);
    let masses: Vec<f64> = (0..count).map(|_| 10f64.powf(draw.between(-spread, spread))).collect();
    let mut text = "name = \"R\"\ngravity = 9.81\n".to_owned();
    for (i, mass) in masses.iter().enumerate() {
        let _ = writeln!(text, "[body.b{i}]\nmass = {mass:?}\ngravity = {:?}", draw.of(&[0.0, 1.0]));
        if i > 1 && draw.part() < 0.1 {
            let _ = writeln!(
                text,
                "[link.l{i}]\narms = {{ b{} = 1.0, b{i} = {:?} }}",
                i - 1,
                draw.between(0.5, 2.0)
            );
        }
    }
    for i in 0..count {
        for kind in ["spring", "spring", "stop", "stop", "friction"] {
            if draw.part() < 0.3 {
                continue;
            }
            let (other, arm) = (draw.below(count), draw.between(-2.0, 2.0));
            let arms = if other == i {
                format!("b{i} = {arm:?}")
            } else {
                format!("b{other} = {arm:?}, b{i} = 1.0")
            };
            let size = if is_alike { (masses[i] * masses[other]).sqrt() } else { 1.0 };
            let (k, c) = (size * 10f64.powf(draw.between(0.0, 4.0)), size * draw.between(0.0, 2.0));
            let _ = writeln!(text, "[{kind}.e{i}{}]\narms = {{ {arms} }}", text.len());
            let rest = match (kind, draw.below(4)) {
                ("spring", _) => format!("stiffness = {k:?}\ndamping = {c:?}"),
                ("friction", _) => format!("force = {:?}", size * draw.part()),
                (_, 0) => "gap = 1.0\nrestitution = 0.5".to_owned(),
                (_, 1) => format!("gap = 1.0\nstiffness = {k:?}\ndamping = {c:?}\nlaw = \"elastogap\""),
                _ => format!("gap = 1.0\nstiffness = {k:?}\ndamping = {c:?}"),
            };
            let _ = writeln!(text, "{rest}");
        }
    }
    let frequency = 10f64.powf(draw.between(-1.0, 1.0));
    let _ = writeln!(text, "[load.l]\non = \"b0\"\namplitude = 3.0\nfrequency = {frequency:?}");
    Arc::new(Assembly::new(parse(&text, "r.toml", &no_records).unwrap_or_else(|e| panic!("{e}"))).unwrap())
}

/// A mode with any state of each element.
fn mode(machine: &Arc<Assembly>, draw: &mut Draw) -> Mode {
    let system = machine.system();
    let mut mode = Motion::new(machine.clone()).unwrap().mode().clone();
    for (state, stop) in mode.stops.iter_mut().zip(&system.stops) {
        let inside = [StopState::Below, StopState::Pressed, StopState::Pressed, StopState::Free];
        *state = match (stop.restitution(), stop.is_elastogap()) {
            (Some(_), _) => draw.of(&[StopState::Open, StopState::Closed]),
            (None, true) if draw.part() < 0.2 => StopState::Capped,
            _ => draw.of(&inside),
        };
    }
    for state in &mut mode.frictions {
        *state = draw.of(&[FrictionState::Up, FrictionState::Down, FrictionState::Stuck]);
    }
    let contacts: Vec<_> = mode.contacts().collect();
    mode.basis = system.independent(&contacts);
    mode
}

/// A state whose coordinates and velocities are of similar size in the norm of (A6), or spread
/// over three decades of it.
fn state(system: &System, table: &FlowTable, draw: &mut Draw) -> Vec<f64> {
    let mut z = vec![0.0; system.signals.size];
    let inputs = system.signals.no_inputs();
    system.signals.fill(DoubleDouble::new(draw.between(0.0, 10.0)), &inputs, &mut z);
    let size = (system.signals.one..z.len()).map(|j| z[j].abs() * table.weights[j]).fold(0.0, f64::max);
    let (size, spread) = (size * 10f64.powf(draw.between(-3.0, 3.0)), draw.of(&[0.0, 3.0]));
    for (x, weight) in z.iter_mut().zip(&table.weights).take(table.one) {
        *x = draw.of(&[1.0, -1.0]) * draw.between(0.1, 1.0) * 10f64.powf(-spread * draw.part()) * size
            / weight;
    }
    z
}

/// The exact power series of a state over a time.
struct Exact(Vec<Vec<Wide>>);

impl Exact {
    fn new(table: &FlowTable, z: &[f64], time: f64) -> Self {
        let (rest, forces) = match &table.apart {
            Some(apart) => (&*apart.rest, &apart.forces[..]),
            None => (&table.a, &[][..]),
        };
        let dot = |terms: &[(usize, f64)], z: &[Wide]| {
            terms.iter().fold(Wide::default(), |sum, &(j, x)| sum.plus(z[j].times(x)))
        };
        let mut terms = vec![z.iter().map(|x| Wide::new(*x)).collect::<Vec<_>>()];
        for k in 1..=LAST {
            let before = &terms[k - 1];
            let mut next: Vec<Wide> = (0..z.len()).map(|i| dot(rest.row(i), before)).collect();
            for (force, by) in forces {
                let force = dot(force.terms(), before);
                by.terms().iter().for_each(|&(i, x)| next[i] = next[i].plus(force.times(-x)));
            }
            terms.push(next.into_iter().map(|x| x.times(time).over(k)).collect());
        }
        Self(terms)
    }

    /// The state after the fraction `part` of the time.
    fn at(&self, part: f64) -> Vec<Wide> {
        self.behind(0, part)
    }

    /// The sum of the terms of order `first` and above, without the factor `part`^`first`.
    fn behind(&self, first: usize, part: f64) -> Vec<Wide> {
        let mut sum = vec![Wide::default(); self.0[0].len()];
        for term in self.0[first..].iter().rev() {
            sum.iter_mut().zip(term).for_each(|(sum, x)| *sum = sum.times(part).plus(*x));
        }
        sum
    }

    /// The coefficients of a functional.
    fn way(&self, row: &Sparse) -> Vec<f64> {
        let dot =
            |z: &Vec<Wide>| row.terms().iter().fold(Wide::default(), |sum, &(j, x)| sum.plus(z[j].times(x)));
        self.0.iter().map(|term| dot(term).value()).collect()
    }
}

/// The norm of (A6).
fn norm(table: &FlowTable, z: &[Wide]) -> f64 {
    z.iter().zip(&table.weights).map(|(x, weight)| x.value().abs() * weight).fold(0.0, f64::max)
}

/// The difference between a state and an exact one in that norm, for coordinates before `end`.
fn off(table: &FlowTable, z: &[f64], exact: &[Wide], end: usize) -> f64 {
    let left: Vec<Wide> = z.iter().zip(exact).map(|(x, exact)| exact.plus(Wide::new(-x))).collect();
    norm(table, &left[..end])
}

/// Numbers of sub-steps by series and by tables, and the largest quotients of a value and its
/// bound.
#[derive(Debug, Default)]
struct Found {
    steps: [usize; 2],
    /// Terms relative to (A6).
    norm: f64,
    /// Omitted terms relative to their bound: by the last term of a series; of tables.
    remainder: [f64; 2],
    /// Terms that a series omits, relative to 1e-18 of the largest of its first terms.
    orders: f64,
    /// Sums of coefficients.
    behind: f64,
    /// Second derivatives.
    bend: f64,
    /// Errors of states and functionals, relative to their tolerance.
    state: f64,
}

/// Asserts that a value is within its bound, and keeps the largest quotient.
fn hold(most: &mut f64, what: f64, bound: f64, name: &str) {
    let quotient = if what == 0.0 { 0.0 } else { what / bound };
    assert!(quotient <= 1.0 + ROUNDING, "{name}: {what:e} is beyond {bound:e}");
    *most = most.max(quotient);
}

/// Sum of a functional's entries in the norm's weights: its largest value at a state of norm 1.
fn row_norm(table: &FlowTable, row: &Sparse) -> f64 {
    row.terms().iter().map(|&(j, x)| x.abs() / table.weights[j]).sum()
}

/// (A6): each term is at most the previous term times rate times length over its order.
fn hold_norm(table: &FlowTable, exact: &Exact, length: f64, found: &mut Found) {
    let norms: Vec<f64> = exact.0.iter().map(|term| norm(table, term)).collect();
    for k in 1..=TERMS {
        hold(&mut found.norm, norms[k], norms[k - 1] * table.rate * length / k as f64, "(A6)");
    }
}

/// Checks one series of a state.
fn hold_series(table: &FlowTable, z: &[f64], found: &mut Found) {
    let mut ahead = Ahead::default();
    ahead.find(table, z, f64::INFINITY, |_| (0, 0.0));
    let exact = Exact::new(table, z, ahead.span);
    hold_norm(table, &exact, ahead.span, found);
    let last = ahead.coefficients() - 1;
    let (left, ratio) =
        (norm(table, &exact.behind(last + 1, 1.0)), table.rate * ahead.span / (last + 1) as f64);
    hold(&mut found.remainder[0], left, norm(table, &exact.0[last]) * ratio / (1.0 - ratio), "remainder");
    let own = |term: &Vec<Wide>| norm(table, &term[..table.one]);
    let size = exact.0.iter().take(3).map(own).fold(0.0, f64::max);
    hold(&mut found.orders, left, 1e-18 * size, "what the orders leave out");
    let largest: f64 = exact.0.iter().map(|term| norm(table, term)).sum();
    for part in [0.31, 1.0] {
        let mut to = z.to_vec();
        ahead.series.at(part, &mut to);
        let off = off(table, &to, &exact.at(part), z.len());
        hold(&mut found.state, off, STATE * largest, "state of a series");
    }
    for (place, w) in table.watched.iter().enumerate() {
        let behind: f64 = exact.way(&w.row)[2..].iter().map(|c| c.abs()).sum();
        let rounding = STATE * largest * row_norm(table, &w.row);
        hold(&mut found.behind, behind, ahead.head(place).behind + rounding, "sizes of coefficients");
    }
}

/// Checks the tables of a sub-step from a state.
fn hold_tables(table: &FlowTable, z: &[f64], found: &mut Found) {
    let exact = Exact::new(table, z, table.length);
    hold_norm(table, &exact, table.length, found);
    let size = norm(table, &exact.0[0]);
    let mut hold_left = |orders: usize, part: f64, bound: f64| {
        let left = norm(table, &exact.behind(orders, part)) * part.powi(orders as i32);
        hold(&mut found.remainder[1], left, bound * size, "what tables leave out");
    };
    hold_left(LOCAL, ENDS[0], 8e-21);
    hold_left(watched::WHOLE, 1.0, 7e-23);
    (0..INTERVALS).for_each(|i| hold_left(table.orders_to(i) + 1, ENDS[i], 1e-19));
    let (mut rates, mut second, mut heads) = (vec![], vec![], vec![]);
    table.look_ahead(z, [&mut rates, &mut second], &mut heads);
    let (mut to, mut ahead) = (z.to_vec(), Ahead::default());
    let bound = STATE * RADIUS.exp() * size;
    table.at_end(z, [&rates, &second], &mut to);
    hold(&mut found.state, off(table, &to, &exact.at(1.0), z.len()), bound, "state at the end");
    table.at_interval_start(3, z, &mut to);
    hold(&mut found.state, off(table, &to, &exact.at(ENDS[2]), z.len()), bound, "state at an interval");
    table.within(z, 0.6 * table.interval(), false, &mut ahead, &mut to);
    let within = exact.at(0.6 / INTERVALS as f64);
    hold(&mut found.state, off(table, &to, &within, table.one), bound, "state in an interval");
    for (place, w) in table.watched.iter().enumerate() {
        let (way, head) = (exact.way(&w.row), head_of(&heads, place));
        let at = |part: f64| way.iter().rev().fold(0.0, |sum, c| sum * part + c);
        let rounding = bound * row_norm(table, &w.row);
        for (sample, end) in table.samples(place, z).into_iter().zip(ENDS) {
            hold(&mut found.state, (sample - at(end)).abs(), rounding, "sample");
        }
        let local = table.local(place, z).iter().rev().fold(0.0, |sum, c| sum * 0.7 + c);
        hold(&mut found.state, (local - at(0.7 * ENDS[0])).abs(), rounding, "local series");
        let second: Vec<f64> = (2..way.len()).map(|k| (k * (k - 1)) as f64 * way[k]).collect();
        for part in [0.0, 0.2, 0.4, 0.6, 0.8, 1.0] {
            let bend = second.iter().rev().fold(0.0, |sum, c| sum * part + c);
            let most = head.bend * table.length * table.length + 10.0 * rounding;
            hold(&mut found.bend, bend.abs(), most, "second derivative");
        }
    }
}

#[test]
fn second_method_series_and_tables_of_random_modes_in_77_digits() {
    let mut draw = Draw(0x2545_f491_4f6c_dd1d);
    let mut found = Found::default();
    for _ in 0..MODES {
        let machine = machine(&mut draw);
        let (system, mode) = (machine.system(), mode(&machine, &mut draw));
        let table = FlowTable::of_mode(system, &mode);
        for _ in 0..STEPS {
            let z = state(system, &table, &mut draw);
            found.steps[usize::from(table.is_dense())] += 1;
            match table.is_dense() {
                true => hold_tables(&table, &z, &mut found),
                false => hold_series(&table, &z, &mut found),
            }
        }
    }
    assert!(found.steps.iter().all(|steps| *steps > MODES * STEPS / 4), "{found:?}");
    // Bounds that are never nearly attained would not be tested.
    let Found { norm, remainder: [series, tables], orders, behind, bend, .. } = found;
    assert!([norm, series, tables, orders, behind, bend].iter().all(|most| *most > ATTAINED), "{found:?}");
}
