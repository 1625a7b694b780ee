//! Derivative of an orbit's equations with respect to the parameter, carried along the cycle.
//!
//! Its sources are the changes of flights' systems, event laws, signals and event functions (each
//! a difference of two nearby machines) and of the times with the drive period. A difference of
//! whole motions would not do: at given event times, each stiff contact magnifies rounding once
//! more.

use super::cycle::{Cycle, Leg, close};
use super::place::{Place, with_signals};
use super::problem::{Numbers, Problem};
use super::word::{Chatter, Letter, Word};
use crate::curve::slope;
use crate::obstacle::Obstacle;
use nalgebra::{DMatrix, DVector};
use vibro_studies::flight::{Flow, dot};

/// Distance of the two machines from the present one, in the parameter's unit. Rounding and the
/// third derivative leave an error of about 1e-10 in each source.
const STEP: f64 = 1e-5;
/// Distance for accumulating impacts: their number jumps, which moves the state by about 1e-12.
const CHATTER_STEP: f64 = 1e-4;

/// Machines on both sides of the present one, for a difference quotient.
struct Beside {
    places: [Place; 2],
    /// Distance between them, in the parameter's unit.
    width: f64,
    /// Whether one of them is the present one.
    is_one_sided: bool,
}

impl Beside {
    /// If one side is not allowed, the present machine takes its place. `None` if the machines
    /// have different signals, as near a rate of zero.
    fn of(
        problem: &Problem,
        (place, u): (&Place, &DVector<f64>),
        step: f64,
    ) -> Result<Option<Self>, Obstacle> {
        let at = |by: f64| {
            let mut moved = u.clone();
            moved[problem.size()] += by;
            problem.place(&moved)
        };
        let size = |place: &Place| place.assembly.system().signals.size;
        let (places, width, is_one_sided) = match (at(-step), at(step)) {
            (Ok(below), Ok(above)) => ([below, above], 2.0 * step, false),
            (Ok(below), Err(_)) => ([below, at(0.0)?], step, true),
            (Err(_), above) => ([at(0.0)?, above?], step, true),
        };
        let is_alike = places.iter().all(|beside| size(beside) == size(place));
        Ok(is_alike.then_some(Self { places, width, is_one_sided }))
    }

    /// Whether the fixed times of a word are the same for both machines.
    fn keeps_times(&self, word: &Word) -> bool {
        let mut fixed = word.letters.iter().filter_map(Letter::timed);
        let [below, above] = self.places.each_ref().map(|place| place.assembly.system());
        fixed.all(|timed| timed.time(below) == timed.time(above))
    }

    /// Derivative of a number of the machine with respect to the parameter.
    fn rate(&self, of: impl Fn(&Place) -> f64) -> f64 {
        (of(&self.places[1]) - of(&self.places[0])) / self.width
    }

    /// Adds the derivative of a vector with respect to the parameter.
    fn add(&self, to: &mut [f64], of: impl Fn(&Place) -> Result<Vec<f64>, Obstacle>) -> Result<(), Obstacle> {
        let [below, above] = [of(&self.places[0])?, of(&self.places[1])?];
        let rates = below.iter().zip(&above).map(|(a, b)| (b - a) / self.width);
        to.iter_mut().zip(rates).for_each(|(to, rate)| *to += rate);
        Ok(())
    }

    /// Replaces the signals' part of a variation by its value at a time.
    fn signals(&self, time: f64, own: usize, v: &mut [f64]) {
        let [below, above] = [0, 1].map(|side| {
            let mut z = vec![0.0; v.len()];
            with_signals(self.places[side].assembly.system(), time, &mut z);
            z
        });
        (own..v.len()).for_each(|i| v[i] = (above[i] - below[i]) / self.width);
    }
}

impl Problem {
    /// Derivative of the equations at a point with respect to the parameter, in its unit. Requires
    /// the cycle with its propagators, and the derivatives with respect to the other unknowns.
    pub(super) fn by_parameter(
        &self,
        (place, u): (&Place, &DVector<f64>),
        cycle: &Cycle,
        matrix: &DMatrix<f64>,
    ) -> Result<DVector<f64>, Obstacle> {
        let step = if self.word.has_run() { CHATTER_STEP } else { STEP };
        // Knots may move with the parameter.
        let has_knots = !self.word.between.is_empty() || cycle.legs.iter().any(|leg| !leg.knots.is_empty());
        let at = |step: f64| -> Result<Option<Beside>, Obstacle> {
            let beside = if has_knots { None } else { Beside::of(self, (place, u), step)? };
            Ok(beside.filter(|beside| beside.keeps_times(&self.word)))
        };
        let Some(beside) = at(step)? else { return self.by_whole_motions(u, cycle, step) };
        let column = self.by_machines((place, u), cycle, matrix, &beside)?;
        // A one-sided difference becomes second order with another one twice as far away.
        let farther = if beside.is_one_sided { at(2.0 * step)? } else { None };
        match farther {
            Some(farther) => Ok(column * 2.0 - self.by_machines((place, u), cycle, matrix, &farther)?),
            None => Ok(column),
        }
    }

    /// Derivative with respect to the parameter, from differences of two machines.
    fn by_machines(
        &self,
        (place, u): (&Place, &DVector<f64>),
        cycle: &Cycle,
        matrix: &DMatrix<f64>,
        beside: &Beside,
    ) -> Result<DVector<f64>, Obstacle> {
        let (own, m, last) = (self.units.state.len(), self.word.len(), self.size());
        let (nodes, first, free) = (self.word.nodes(), self.first_time(), self.word.free());
        let Numbers { states, times, period, .. } = self.numbers(place, u);
        let mut carried = Carried {
            problem: self,
            place,
            beside,
            longer: beside.rate(|place| self.driven_period(place).unwrap_or(period)),
            v: vec![0.0; cycle.back.len()],
        };
        let mut column = DVector::zeros(last);
        beside.signals(times[0], own, &mut carried.v);
        for k in 0..cycle.legs.len() {
            let next = if m == 0 { 0 } else { (k + 1) % m };
            if let Some(moved) = carried.over_flight(cycle, k, next)? {
                let own = free.binary_search(&next).unwrap_or_default();
                column[first + own] = moved / self.scale(cycle, next);
            }
            carried.over_event(&cycle.legs[k], next)?;
            if let Some(node) = nodes.iter().position(|&k| k == next).filter(|node| *node > 0) {
                for (i, v) in carried.v.iter_mut().enumerate().take(own) {
                    column[node * own + i] = -std::mem::take(v) / self.units.state[i];
                }
            }
        }
        let v = carried.v;
        let mut along = vec![0.0; own];
        beside.add(&mut along, |place| {
            let period = self.driven_period(place).unwrap_or(period);
            self.carried(place, times[0], period)
                .map(|along| if along.is_empty() { vec![0.0; own] } else { along })
        })?;
        for i in 0..own {
            column[i] = (along[i] - v[i]) / self.units.state[i];
        }
        for (k, direction) in self.directions.iter().enumerate() {
            let position = |place: &Place| direction.position(place.assembly.system(), &states[0], times[0]);
            let length = self.length(&direction.row(place.assembly.system()));
            column[first + free.len() + k] = beside.rate(position) / length;
        }
        // The unknown event times are in radians of the drive.
        if self.driven_period(place).is_some() {
            let radian = self.radian(place);
            let slower = beside.rate(|place| self.radian(place)) / radian;
            (0..free.len()).for_each(|k| column.axpy(slower * u[first + k], &matrix.column(first + k), 1.0));
        }
        Ok(column)
    }
}

impl Problem {
    /// Derivative with respect to the parameter, as a difference of whole motions.
    fn by_whole_motions(&self, u: &DVector<f64>, cycle: &Cycle, step: f64) -> Result<DVector<f64>, Obstacle> {
        let first = self.first_time();
        // An event's scale has kinks, so the scale of the orbit is used on both sides.
        slope(step, |by| {
            let mut moved = u.clone();
            moved[self.size()] += by;
            let mut there = self.residual(&self.place(&moved)?, &moved, false)?;
            for (i, &k) in self.word.free().iter().enumerate() {
                there.value[first + i] *= self.scale(&there.cycle, k) / self.scale(cycle, k);
            }
            Ok(there.value.as_slice().to_vec())
        })
    }
}

/// A variation with respect to the parameter, carried along a cycle.
struct Carried<'a> {
    problem: &'a Problem,
    place: &'a Place,
    beside: &'a Beside,
    /// Derivative of the period with respect to the parameter.
    longer: f64,
    v: Vec<f64>,
}

impl Carried<'_> {
    /// Carries the variation over the run of impacts and the flight before event `next`. Returns
    /// the derivative of the event's function at its time.
    fn over_flight(&mut self, cycle: &Cycle, k: usize, next: usize) -> Result<Option<f64>, Obstacle> {
        let (leg, beside) = (&cycle.legs[k], self.beside);
        let chatter = self.problem.word.letters.get(k).and_then(|letter| letter.chatter.as_ref());
        if let (Some(chatter), Some(run)) = (chatter, &leg.run) {
            self.v = through_run(self.place, beside, (chatter, leg), run, std::mem::take(&mut self.v))?;
        }
        let flows = beside.places.each_ref().map(|place| place.flow(&leg.flow.mode));
        self.v = leg.flow.varied([&flows[0], &flows[1]], beside.width, [&leg.states[0], &self.v], leg.span);
        beside.signals(leg.time + leg.span, self.problem.units.state.len(), &mut self.v);
        let Some(i) = leg.ending else { return Ok(None) };
        let value = |flow: &Flow| dot(flow.watched[i].1.as_slice(), &leg.states[1]);
        let moves = (value(&flows[1]) - value(&flows[0])) / beside.width;
        let row = leg.flow.watched[i].1.as_slice();
        let later = if next == 0 { self.longer * dot(row, &leg.rate) } else { 0.0 };
        Ok(Some(dot(row, &self.v) + moves + later))
    }

    /// Carries the variation over the law of event `next`, at the end of a flight.
    fn over_event(&mut self, leg: &Leg, next: usize) -> Result<(), Obstacle> {
        let Self { problem, place, beside, longer, v } = self;
        let stay = Letter::staying(&problem.word);
        let letter = problem.word.letters.get(next).unwrap_or(&stay);
        if next == 0 {
            // Includes the signals: an impact's law depends on the rates of prescribed bodies.
            v.iter_mut().zip(&leg.rate).for_each(|(v, rate)| *v += *longer * rate);
        }
        letter.apply(place.assembly.system(), [&mut v[..]]);
        let arrived = letter.arrived(place.assembly.system(), leg.time + leg.span, &leg.states[1]);
        beside.add(&mut v[..problem.units.state.len()], |place| {
            let mut after = arrived.clone();
            letter.apply(place.assembly.system(), [&mut after[..]]);
            Ok(after)
        })
    }
}

/// Carries a variation through a run of impacts, with the change of the run itself, to the time at
/// which its stop closes.
fn through_run(
    place: &Place,
    beside: &Beside,
    (chatter, leg): (&Chatter, &Leg),
    (time, z): &(f64, Vec<f64>),
    mut v: Vec<f64>,
) -> Result<Vec<f64>, Obstacle> {
    // Each of the two machines has its own signals.
    v[place.assembly.system().states()..].fill(0.0);
    let latest = leg.time + leg.span.max(0.0) + f64::EPSILON;
    let mut columns = DMatrix::from_vec(v.len(), 1, v);
    close(place, chatter, (*time, latest), &mut z.clone(), &mut columns)?;
    let mut v = columns.as_slice().to_vec();
    beside.add(&mut v, |place| {
        let (mut z, mut none) = (z.clone(), DMatrix::zeros(z.len(), 0));
        let closed = close(place, chatter, (*time, latest + leg.span.max(0.0)), &mut z, &mut none)?;
        let rate = place.flow(&leg.flow.mode).derivative(&z);
        z.iter_mut().zip(&rate).for_each(|(x, rate)| *x += rate * (leg.time - closed));
        Ok(z)
    })?;
    Ok(v)
}
