//! The equations of an orbit with a given word, along a parameter.
//!
//! Unknowns, scaled to size one: the state after the first event and at each further node of the
//! word; the times of free events, in radians of the drive (an autonomous machine has the period
//! as the first one); a drift per period along each direction in which the state is free; the
//! parameter. Equations:
//! the state returns except for the drift; the motion from each node arrives at the next; each
//! event function is zero at its event's time; the state has a given position along each free
//! direction.

use super::cycle::{Cycle, Derivatives};
use super::directions::Direction;
use super::place::{Family, Place, with_signals};
use super::word::{Letter, Word};
use crate::curve::STEP_ROUNDING;
use crate::curve::{Equations, Linearization};
use crate::obstacle::Obstacle;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::sync::Arc;
use vibro_studies::carried;

/// Tolerance for convergence with accumulating impacts, as the relative size of a Newton step.
const CHATTER_ROUNDING: f64 = 1e-10;
/// Limit of a Newton step that may be rounding: an event whose function hardly rises has only half
/// of the digits.
const STALLED: f64 = 1e-7;
/// Limit of a flight's shortening in one Newton step, as a fraction of the flight.
const SHORTENING: f64 = 0.5;
/// Tolerance for a signal's change over a period, relative to its values: rounding.
const EXACT: f64 = 1e-9;

/// The equations of a word's orbits.
#[derive(Clone, Debug)]
pub struct Problem {
    pub(super) family: Arc<Family>,
    pub(super) word: Word,
    pub(super) units: Units,
    /// Directions in which the state is free.
    pub(super) directions: Vec<Direction>,
    /// The state's position along each of these directions.
    pub(super) fixed: Vec<f64>,
    /// Time of the start of a word without events, s.
    pub(super) origin: f64,
}

/// Units of the unknowns.
#[derive(Clone, Debug)]
pub(super) struct Units {
    /// For each variable of the state (q, q').
    pub state: Vec<f64>,
    /// Unit of time of an autonomous machine: one radian of its period, s.
    pub time: f64,
}

/// Unknowns of an orbit in SI units.
#[derive(Clone, Debug)]
pub(super) struct Numbers {
    /// The state (q, q') at each node of the word; the first is the state after the first event.
    pub states: Vec<Vec<f64>>,
    /// Times of the events, s; for a word without events, the time of the start.
    pub times: Vec<f64>,
    /// The period, s.
    pub period: f64,
    /// Drifts per period along the directions in which the state is free.
    pub drifts: Vec<f64>,
}

/// Values of the equations.
pub(super) struct Residual {
    pub value: DVector<f64>,
    /// Derivatives with respect to all unknowns except the parameter, on request.
    pub matrix: Option<DMatrix<f64>>,
    /// The motion.
    pub cycle: Cycle,
}

impl Problem {
    /// Number of unknowns without the parameter.
    pub(super) fn size(&self) -> usize {
        self.first_time() + self.word.free().len() + self.directions.len()
    }

    /// Index of the first free event's time among the unknowns, and of its function among the
    /// equations.
    pub(super) fn first_time(&self) -> usize {
        self.units.state.len() * self.word.nodes().len()
    }

    /// The parameter's value at a point.
    pub(super) fn value(&self, u: &DVector<f64>) -> f64 {
        u[self.size()] * self.family.unit()
    }

    /// The machine at a point.
    pub(super) fn place(&self, u: &DVector<f64>) -> Result<Place, Obstacle> {
        Ok(self.family.place(self.value(u))?)
    }

    /// One radian of time, s.
    pub(super) fn radian(&self, place: &Place) -> f64 {
        place.period.map_or(self.units.time, |period| period / TAU)
    }

    /// The orbit's period if the drive determines it, s.
    pub(super) fn driven_period(&self, place: &Place) -> Option<f64> {
        Some(place.period? * f64::from(self.word.periods?))
    }

    /// The SI values of a point.
    pub(super) fn numbers(&self, place: &Place, u: &DVector<f64>) -> Numbers {
        let (first, radian, free) = (self.first_time(), self.radian(place), self.word.free());
        let scaled = |node: &[f64]| node.iter().zip(&self.units.state).map(|(x, unit)| unit * x).collect();
        let states = u.as_slice()[..first].chunks(self.units.state.len().max(1)).map(scaled).collect();
        let system = place.assembly.system();
        let mut unknown = u.as_slice()[first..].iter().map(|time| radian * time);
        let time = |letter: &Letter| match letter.timed() {
            Some(timed) => timed.time(system),
            None => unknown.next().unwrap_or_default(),
        };
        let mut times: Vec<f64> = self.word.letters.iter().map(time).collect();
        let period = match self.driven_period(place) {
            Some(period) => period,
            // An autonomous orbit without events has no period: `residual` refuses it.
            None => times.first_mut().map_or(0.0, |first| std::mem::replace(first, 0.0)),
        };
        if self.word.is_empty() {
            times.push(self.origin);
        }
        let first = first + free.len();
        let drifts = (0..self.directions.len()).map(|k| u[first + k]).collect();
        Numbers { states, times, period, drifts }
    }

    /// The time one period after the start, s.
    pub(super) fn end(&self, place: &Place, start: f64, period: f64) -> f64 {
        let first = self.word.letters.first().and_then(Letter::timed);
        let turns = i64::from(self.word.periods.unwrap_or(0));
        first.map_or(start + period, |first| first.later(turns).time(place.assembly.system()))
    }

    /// The largest fraction of a step, up to 1, that keeps the order of the events.
    pub(super) fn orderly(&self, place: &Place, u: &DVector<f64>, step: &DVector<f64>) -> f64 {
        let (first, m, radian) = (self.first_time(), self.word.len(), self.radian(place));
        let Numbers { times, period, .. } = self.numbers(place, u);
        let is_autonomous = self.driven_period(place).is_none();
        let mut moved = vec![0.0; m];
        let own = self.word.free().iter().enumerate().filter(|(_, k)| !(is_autonomous && **k == 0));
        own.for_each(|(i, &k)| moved[k] = radian * step[first + i]);
        let spans = (1..m).map(|k| (times[k] - times[k - 1], moved[k] - moved[k - 1]));
        // The next period begins at a fixed time.
        let last =
            self.word.is_timed().then(|| (self.end(place, times[0], period) - times[m - 1], -moved[m - 1]));
        let shrinking = spans.chain(last).filter(|(span, change)| *span > 0.0 && *change < 0.0);
        shrinking.fold(1.0, |part: f64, (span, change)| part.min(SHORTENING * span / -change))
    }

    /// The point with given SI values.
    pub(super) fn point(&self, place: &Place, numbers: &Numbers, value: f64) -> DVector<f64> {
        let radian = self.radian(place);
        let scaled = |state: &Vec<f64>| -> Vec<f64> {
            state.iter().zip(&self.units.state).map(|(x, unit)| x / unit).collect()
        };
        let state = numbers.states.iter().flat_map(scaled);
        let is_driven = self.driven_period(place).is_some();
        let time = |k: usize| if k == 0 && !is_driven { numbers.period } else { numbers.times[k] };
        let times = self.word.free().iter().map(|k| time(*k) / radian);
        let all = state.chain(times).chain(numbers.drifts.iter().copied());
        DVector::from_iterator(self.size() + 1, all.chain([value / self.family.unit()]))
    }

    /// The motion at a point.
    pub(super) fn cycle(&self, place: &Place, u: &DVector<f64>) -> Result<Cycle, Obstacle> {
        let Numbers { states, times, period, .. } = self.numbers(place, u);
        let end = self.end(place, times[0], period);
        Ok(Cycle::follow(place, &self.word, &states, (&times, end), false)?.0)
    }

    /// Values of the equations; on request with their derivatives with respect to all unknowns
    /// except the parameter.
    pub(super) fn residual(
        &self,
        place: &Place,
        u: &DVector<f64>,
        with_derivatives: bool,
    ) -> Result<Residual, Obstacle> {
        if self.word.is_empty() && self.driven_period(place).is_none() {
            // Neither events nor a drive determine the period.
            return Err(Obstacle::Order);
        }
        let (own, size, first) = (self.units.state.len(), self.size(), self.first_time());
        let Numbers { states, times, period, drifts } = self.numbers(place, u);
        let end = self.end(place, times[0], period);
        let (cycle, derivatives) =
            Cycle::follow(place, &self.word, &states, (&times, end), with_derivatives)?;
        let state = &states[0];
        let along = self.carried(place, times[0], period)?;
        let mut value = DVector::zeros(size);
        for i in 0..own {
            let free: f64 =
                self.directions.iter().zip(&drifts).map(|(own, drift)| own.change[i] * drift).sum();
            let moved = along.get(i).copied().unwrap_or(0.0);
            value[i] = (state[i] + moved - cycle.back[i]) / self.units.state[i] + free / self.units.state[i];
        }
        for (node, (state, arrival)) in states[1..].iter().zip(&cycle.arrivals).enumerate() {
            for i in 0..own {
                value[(node + 1) * own + i] = (state[i] - arrival[i]) / self.units.state[i];
            }
        }
        let free = self.word.free();
        let scales: Vec<f64> = free.iter().map(|&k| self.scale(&cycle, k)).collect();
        for (i, &k) in free.iter().enumerate() {
            let leg = cycle.before(k);
            let row = leg.ending.map(|place| leg.flow.watched[place].1.as_slice()).unwrap_or(&[]);
            value[first + i] = row.iter().zip(&leg.states[1]).map(|(a, x)| a * x).sum::<f64>() / scales[i];
        }
        let m = free.len();
        let system = place.assembly.system();
        for (k, own) in self.directions.iter().enumerate() {
            let at = own.position(system, state, times[0]);
            value[first + m + k] = (at - self.fixed[k]) / self.length(&own.row(system));
        }
        let matrix = derivatives.map(|by| self.matrix(place, &by, &scales, (&along, period, times[0])));
        Ok(Residual { value, matrix, cycle })
    }

    /// Displacement of the state in a period from `time` by uniformly moving bodies.
    pub(super) fn carried(&self, place: &Place, time: f64, period: f64) -> Result<Vec<f64>, Obstacle> {
        let (system, own) = (place.assembly.system(), self.units.state.len());
        let [before, after] = [time, self.end(place, time, period)].map(|time| {
            let mut z = vec![0.0; system.signals.size];
            with_signals(system, time, &mut z);
            z
        });
        let changes = before.iter().zip(&after).enumerate().map(|(i, (a, b))| {
            let is_signal = i >= own && (b - a).abs() > EXACT * (a.abs() + b.abs()).max(1.0);
            if is_signal { b - a } else { 0.0 }
        });
        let change: Vec<f64> = changes.collect();
        if change.iter().all(|x| *x == 0.0) {
            return Ok(Vec::new());
        }
        let along = carried(system, &change, false).ok_or(Obstacle::NoConvergence)?;
        Ok(along.iter().copied().collect())
    }

    /// Size of an event function in the units of the state.
    pub(super) fn scale(&self, cycle: &Cycle, k: usize) -> f64 {
        let leg = cycle.before(k);
        let Some(place) = leg.ending else { return 1.0 };
        let row = leg.flow.watched[place].1.as_slice();
        let own: f64 = row.iter().zip(&self.units.state).map(|(a, unit)| (a * unit).abs()).sum();
        let terms: f64 = row.iter().zip(&leg.states[1]).map(|(a, x)| (a * x).abs()).sum();
        own.max(terms).max(f64::MIN_POSITIVE)
    }

    /// Size of a direction's row in the units of the state.
    pub(super) fn length(&self, n: &[f64]) -> f64 {
        n.iter().zip(&self.units.state).map(|(n, unit)| (n * unit).abs()).sum::<f64>().max(f64::MIN_POSITIVE)
    }

    fn matrix(
        &self,
        place: &Place,
        by: &Derivatives,
        scales: &[f64],
        (along, period, start): (&[f64], f64, f64),
    ) -> DMatrix<f64> {
        let (own, m, size, radian) =
            (self.units.state.len(), self.word.free().len(), self.size(), self.radian(place));
        let first = self.first_time();
        let unit = |j: usize| if j < first { self.units.state[j % own] } else { radian };
        let mut matrix = DMatrix::zeros(size, size);
        for j in 0..first + m {
            for (node, arriving) in std::iter::once(&by.back).chain(&by.arrivals).enumerate() {
                for i in 0..own {
                    matrix[(node * own + i, j)] = -arriving[(i, j)] * unit(j) / self.units.state[i];
                }
            }
            for (event, ends) in &by.ends {
                matrix[(first + event, j)] = ends[j] * unit(j) / scales[*event];
            }
        }
        (0..first).for_each(|i| matrix[(i, i)] += 1.0);
        if m > 0 && self.driven_period(place).is_none() {
            // The displacement by uniform motions is proportional to the period.
            along
                .iter()
                .enumerate()
                .for_each(|(i, x)| matrix[(i, first)] += x / period * radian / self.units.state[i]);
        }
        let system = place.assembly.system();
        // The time of the first event is an unknown of a driven machine only.
        let is_start_free = self.word.free().first() == Some(&0) && self.driven_period(place).is_some();
        for (k, direction) in self.directions.iter().enumerate() {
            let row = direction.row(system);
            let length = self.length(&row);
            for i in 0..own {
                matrix[(i, first + m + k)] = direction.change[i] / self.units.state[i];
                matrix[(first + m + k, i)] = row[i] * self.units.state[i] / length;
            }
            if is_start_free {
                matrix[(first + m + k, first)] = direction.rate(system, start) * radian / length;
            }
        }
        matrix
    }

    /// These equations for another word, at a state (q, q', ...) and a time of its start. The drifts
    /// along the machine's neutral directions stay.
    pub(super) fn with_word(&self, place: &Place, word: Word, numbers: &mut Numbers) -> Self {
        let directions = Direction::all(place, &word, &self.units.state);
        let neutral = directions.iter().filter(|own| own.is_neutral()).count();
        numbers.drifts.truncate(neutral);
        numbers.drifts.resize(directions.len(), 0.0);
        let mut other = Self { word, directions, ..self.clone() };
        other.hold(place, numbers);
        other
    }

    /// Holds the positions of given values along the free directions.
    pub(super) fn hold(&mut self, place: &Place, numbers: &Numbers) {
        let position =
            |own: &Direction| own.position(place.assembly.system(), &numbers.states[0], numbers.times[0]);
        self.fixed = self.directions.iter().map(position).collect();
    }
}

impl Equations for Problem {
    fn linearize(&self, u: &DVector<f64>, known: Option<&DMatrix<f64>>) -> Result<Linearization, Obstacle> {
        let place = self.place(u)?;
        let Residual { value, matrix, cycle } = self.residual(&place, u, true)?;
        let matrix = matrix.ok_or(Obstacle::NoConvergence)?;
        let last = self.size();
        // Under curved forces the column changes with the state: with an old one, steps would
        // converge only linearly.
        let column = match known.filter(|_| place.assembly.system().curved.is_empty()) {
            Some(known) => known.column(last).into_owned(),
            None => self.by_parameter((&place, u), &cycle, &matrix)?,
        };
        let mut whole = matrix.insert_column(last, 0.0);
        whole.set_column(last, &column);
        Ok(Linearization { value, matrix: whole })
    }

    fn rounding(&self) -> f64 {
        if self.word.has_run() { CHATTER_ROUNDING } else { STEP_ROUNDING }
    }

    fn stalled(&self) -> f64 {
        STALLED
    }
}
