//! The motion over a period for given event times, which is linear in the initial state unless
//! forces are curved.
//!
//! An event at a given time is a linear map of the augmented state, also if it changes the
//! velocities. The motion over a word therefore follows from its start and its event times. It is
//! an orbit if it returns to its start and each event function is zero at its event's time.
//! Sensitivities to start and times are computed with the motion. Instability does not make the
//! sensitivities grow, because the times are fixed. Fixed times of the word (a knot that changes a
//! contact, a sample) have no event function; other knots of signals are not events of the word.

use super::corners::Piece;
use super::place::{Place, with_signals};
use super::word::{Cause, Chatter, Letter, Word};
use crate::obstacle::Obstacle;
use nalgebra::DMatrix;
use std::sync::Arc;
use vibro_machine::Motion;
use vibro_machine::mode::StopState;
use vibro_machine::motion::{Crossing, Reached, keep};
use vibro_machine::system::System;
use vibro_studies::flight::{Flow, dot, multiply};

/// The flight after an event, or after the run of impacts that begins with it.
#[derive(Clone, Debug)]
pub struct Leg {
    /// The run of impacts before it: time and augmented state after the first impact.
    pub(super) run: Option<(f64, Vec<f64>)>,
    /// Start time, s.
    pub time: f64,
    /// Duration, s.
    pub span: f64,
    /// Augmented states at its start, after the event's law, and at its end.
    pub states: [Vec<f64>; 2],
    /// Knots of signals within it.
    pub(super) knots: Vec<KnotWithin>,
    /// Its linear system.
    pub flow: Arc<Flow>,
    /// Derivative of the state at its end with respect to the state at its start: exp(A span)
    /// without curved forces.
    pub(super) propagator: DMatrix<f64>,
    /// z' at its end.
    pub(super) rate: Vec<f64>,
    /// Index in `flow.watched` of the function of the event at its end.
    pub(super) ending: Option<usize>,
}

/// The motion over a period.
#[derive(Clone, Debug)]
pub struct Cycle {
    /// The flights in their order.
    pub legs: Vec<Leg>,
    /// The augmented state after the last event's law.
    pub back: Vec<f64>,
    /// The state (q, v) on arrival at each node except the first, after the event's law.
    pub(super) arrivals: Vec<Vec<f64>>,
}

/// Derivatives of a cycle with respect to the states at its nodes, then the times of its free
/// events.
pub(super) struct Derivatives {
    /// Gradient of each free event's function at the end of its leg, with the event's index.
    pub ends: Vec<(usize, Vec<f64>)>,
    /// Derivatives of the state after the last event's law.
    pub back: DMatrix<f64>,
    /// Derivatives of the states that arrive at the other nodes.
    pub arrivals: Vec<DMatrix<f64>>,
}

/// Index of the letter's event function in `flow.watched`; `None` for events at fixed times.
fn ending(flow: &Flow, letter: &Letter) -> Result<Option<usize>, Obstacle> {
    let Cause::Passes { watch, place } = letter.cause else { return Ok(None) };
    let own = flow.watched.iter().enumerate().filter(|(_, (own, _))| *own == watch);
    own.map(|(place, _)| place).nth(place).map(Some).ok_or(Obstacle::Order)
}

/// A knot of signals within a flight: time, s, and augmented states before and after it.
pub(super) type KnotWithin = (f64, [Vec<f64>; 2]);

/// A part of a flight between knots of signals.
#[derive(Clone, Copy, Debug)]
pub(super) struct LegPart<'a> {
    /// Start time, s.
    pub time: f64,
    /// Duration, s.
    pub span: f64,
    /// Augmented state at its start.
    pub start: &'a [f64],
}

impl Leg {
    /// The parts of the flight between knots of signals, in their order.
    pub(super) fn parts(&self) -> impl Iterator<Item = LegPart<'_>> {
        let begins = std::iter::once((self.time, &self.states[0]));
        let begins = begins.chain(self.knots.iter().map(|(time, states)| (*time, &states[1])));
        let ends = self.knots.iter().map(|knot| knot.0).chain([self.time + self.span]);
        begins.zip(ends).map(|((time, start), end)| LegPart { time, span: end - time, start })
    }

    /// The augmented state after the event before it: at its start, or at the start of its run.
    pub(super) fn entered(&self) -> &[f64] {
        self.run.as_ref().map_or(&self.states[0], |(_, z)| z)
    }
}

/// The end of a flight between two events.
struct Flown {
    /// Augmented state.
    end: Vec<f64>,
    /// Knots of signals within the flight.
    knots: Vec<KnotWithin>,
    /// Derivative of the end with respect to the start.
    propagator: DMatrix<f64>,
}

/// Flies between two events. A flight that ends at a fixed time keeps the signals before this
/// time.
///
/// A knot changes only the signals, whose rows in the linear system are the same on every piece.
/// Without curved forces, the propagator of the whole flight therefore gives the derivatives with
/// respect to states.
fn fly(
    system: &System,
    flow: &Flow,
    (z, span): (&[f64], f64),
    ([begin, end], is_timed): ([Piece; 2], bool),
) -> Flown {
    // The product of the parts' derivatives, for curved forces only.
    let mut product: Option<DMatrix<f64>> = None;
    let mut part = |from: &[f64], span: f64| {
        if !flow.is_curved() {
            return flow.stretches(from, span, &mut |_, _| ());
        }
        let (end, own) = flow.transition(from, span);
        product = Some(product.take().map_or_else(|| own.clone(), |before| &own * before));
        end
    };
    let mut knots: Vec<KnotWithin> = Vec::new();
    let mut time = begin.time;
    for knot in begin.knots(system, &end) {
        let before = part(knots.last().map_or(z, |(_, states)| &states[1]), knot - time);
        let mut after = before.clone();
        with_signals(system, knot, &mut after);
        flow.fill(&mut after);
        knots.push((knot, [before, after]));
        time = knot;
    }
    let (mut there, propagator) = match knots.last() {
        None => flow.transition(z, span),
        Some((_, states)) => {
            let there = part(&states[1], end.time - time);
            (there, product.unwrap_or_else(|| flow.propagator(span)))
        }
    };
    if !is_timed {
        end.renew(system, &mut there);
    }
    Flown { end: there, knots, propagator }
}

impl Cycle {
    /// The motion from the states (q, v) at the nodes of a word, each followed to the next node.
    /// The events are at `times`, s; the first is the start, and the motion ends at `last`, one
    /// period later. Derivatives on request.
    pub(super) fn follow(
        place: &Place,
        word: &Word,
        starts: &[Vec<f64>],
        (times, last): (&[f64], f64),
        with_derivatives: bool,
    ) -> Result<(Self, Option<Derivatives>), Obstacle> {
        let system = place.assembly.system();
        let (own, size, m) = (starts[0].len(), system.signals.size, word.len());
        if own != system.states() {
            return Err(Obstacle::Order);
        }
        word.letters.iter().filter_map(Letter::timed).try_for_each(|timed| timed.check(place))?;
        let (nodes, first_time, period) = (word.nodes(), own * starts.len(), last - times[0]);
        let column_of = |k: usize| word.free().binary_search(&k).ok();
        let stay = Letter::staying(word);
        let mut z = vec![0.0; size];
        z[..own].copy_from_slice(&starts[0]);
        let first = word.piece(system, 0, times[0], 0);
        first.fill(system, &place.flow(word.mode_after(0)), &mut z);
        let columns = if with_derivatives { first_time + word.free().len() } else { 0 };
        let mut c = DMatrix::zeros(size, columns);
        if with_derivatives {
            (0..own).for_each(|i| c[(i, i)] = 1.0);
        }
        let mut next_c = DMatrix::zeros(size, columns);
        let (mut legs, mut ends) = (Vec::with_capacity(m.max(1)), Vec::new());
        let (mut arrivals, mut arriving) = (Vec::new(), Vec::new());
        for k in 0..m.max(1) {
            let flow = place.flow(word.mode_after(k));
            if with_derivatives && k == 0 && column_of(0).is_some() && place.period.is_some() {
                let rate = place.flow(&word.letters[0].modes[1]).derivative(&z);
                (0..own).for_each(|i| c[(i, first_time)] = -rate[i]);
            }
            let time = times[k];
            let until = times.get(k + 1).copied().unwrap_or(last);
            let mut run = None;
            let mut time = time;
            let mut begin = word.piece(system, k, time, 0);
            if let Some(chatter) = word.letters.get(k).and_then(|letter| letter.chatter.as_ref()) {
                run = Some((time, z.clone()));
                time = close(place, chatter, (time, until + period), &mut z, &mut c)?;
                begin = Piece::fixed(time);
            }
            let (next, letter) = ((k + 1) % m.max(1), word.letters.get((k + 1) % m.max(1)));
            flow.fill(&mut z);
            let is_timed = letter.is_some_and(|letter| letter.timed().is_some());
            let end = word.piece(system, next, until, if next == 0 { word.turns() } else { 0 });
            let Flown { end, knots, propagator } =
                fly(system, &flow, (&z, until - time), ([begin, end], is_timed));
            let place_of = letter.map(|letter| ending(&flow, letter)).transpose()?.flatten();
            let by_time = column_of(next).filter(|_| with_derivatives && m > 0);
            let rate = flow.derivative(&end);
            if with_derivatives {
                multiply(&propagator, &c, 1.0, &mut next_c);
                std::mem::swap(&mut c, &mut next_c);
                if let (Some(place), Some(column)) = (place_of, by_time) {
                    let row = &flow.watched[place].1;
                    let mut by: Vec<f64> =
                        c.column_iter().map(|column| dot(row.as_slice(), column.as_slice())).collect();
                    by[first_time + column] += dot(row.as_slice(), &rate);
                    ends.push((column, by));
                }
            }
            let letter = letter.unwrap_or(&stay);
            let (mut after, mut jumped) = (letter.arrived(system, until, &end), rate.clone());
            // Most derivatives with respect to nodes and times before the last node are zero.
            let own_columns = c.as_mut_slice().chunks_mut(size).filter(|v| v.iter().any(|x| *x != 0.0));
            letter.apply(system, own_columns.chain([&mut after[..], &mut jumped[..]]));
            if let Some(column) = by_time {
                (0..own).for_each(|i| c[(i, first_time + column)] += jumped[i]);
            }
            if let Some(node) = nodes.iter().position(|&k| k == next).filter(|node| *node > 0) {
                arrivals.push(after[..own].to_vec());
                after[..own].copy_from_slice(&starts[node]);
                if with_derivatives {
                    arriving.push(c.rows(0, own).into_owned());
                    c.fill(0.0);
                    (0..own).for_each(|i| c[(i, node * own + i)] = 1.0);
                }
            }
            if let Some(column) = by_time.filter(|_| next > 0) {
                let leaving = place.flow(&letter.modes[1]).derivative(&after);
                (0..own).for_each(|i| c[(i, first_time + column)] -= leaving[i]);
            }
            let states = [z, end];
            legs.push(Leg {
                run,
                time,
                span: until - time,
                states,
                knots,
                flow,
                propagator,
                rate,
                ending: place_of,
            });
            z = after;
        }
        let back = c.rows(0, if with_derivatives { own } else { 0 }).into_owned();
        let derivatives = with_derivatives.then_some(Derivatives { ends, back, arrivals: arriving });
        Ok((Self { legs, back: z, arrivals }, derivatives))
    }

    /// The flight before event `k`, with the state before the event's law.
    pub(super) fn before(&self, k: usize) -> &Leg {
        &self.legs[(k + self.legs.len() - 1) % self.legs.len()]
    }

    /// The rate at which event `k`'s function reaches zero, per second; infinite without a
    /// function.
    pub(super) fn rise(&self, k: usize) -> f64 {
        let leg = self.before(k);
        let Some(place) = leg.ending else { return f64::INFINITY };
        let row = leg.flow.watched[place].1.as_slice();
        dot(row, &leg.rate)
    }

    /// Derivative of the state (q, v) after the last event's law with respect to the initial
    /// state; event times move with the state. Requires that each event function rises.
    ///
    /// # Errors
    /// [`Obstacle::Order`] if a run of impacts does not close its stop.
    pub(super) fn monodromy(&self, place: &Place, word: &Word) -> Result<DMatrix<f64>, Obstacle> {
        let system = place.assembly.system();
        let (own, size) = (system.states(), system.signals.size);
        let (mut c, mut next_c) = (DMatrix::identity(size, own), DMatrix::zeros(size, own));
        let stay = Letter::staying(word);
        // The start comes after the first event.
        let first = word.letters.first().unwrap_or(&stay);
        first.keep(system, c.as_mut_slice().chunks_mut(size));
        for (k, leg) in self.legs.iter().enumerate() {
            let chatter = word.letters.get(k).and_then(|letter| letter.chatter.as_ref());
            if let (Some(chatter), Some((time, z))) = (chatter, &leg.run) {
                let latest = leg.time + leg.span.abs() + self.period();
                close(place, chatter, (*time, latest), &mut z.clone(), &mut c)?;
            }
            multiply(&leg.propagator, &c, 1.0, &mut next_c);
            std::mem::swap(&mut c, &mut next_c);
            let next = (k + 1) % self.legs.len();
            let letter = word.letters.get(next).unwrap_or(&stay);
            if letter.timed().is_some() {
                letter.apply(system, c.as_mut_slice().chunks_mut(size));
                continue;
            }
            let state = match self.legs.get(k + 1) {
                Some(leg) => leg.entered(),
                None => &self.back,
            };
            let after = place.flow(&letter.modes[1]);
            let leaving = after.derivative(state);
            let crossing = Crossing {
                modes: [&letter.modes[0], &letter.modes[1]],
                states: [&leg.states[1], state],
                rates: [&leg.rate, &leaving],
                row: leg.ending.map(|place| leg.flow.watched[place].1.as_slice()),
                events: &letter.events,
            };
            crossing.carry(system, c.as_mut_slice().chunks_mut(size));
        }
        Ok(c.rows(0, own).into_owned())
    }
}

/// Simulates a run of impacts until its stop closes, with variations at fixed times. Returns the
/// time of closing.
pub(super) fn close(
    place: &Place,
    chatter: &Chatter,
    (time, latest): (f64, f64),
    z: &mut [f64],
    columns: &mut DMatrix<f64>,
) -> Result<f64, Obstacle> {
    let system = place.assembly.system();
    let failed = |_| Obstacle::Order;
    // An orbit has its first impact at the stop. Newton iterates are only near it: the run then
    // starts from the stop, with a derivative for the offset.
    let (stop, mut off) = (&system.stops[chatter.stop], vec![0.0; z.len()]);
    let e = &stop.elongation;
    let part = stop.excess.at(z) / e.w.dot(&e.mobility);
    off.iter_mut().zip(e.mobility.iter()).for_each(|(off, m)| *off = part * m);
    let begin: Vec<f64> = z.iter().zip(&off).map(|(x, off)| x - off).collect();
    let motion = Motion::from_state(place.assembly.clone(), time, &system.given(&begin)).map_err(failed)?;
    let mut motion = motion.without_energy_accounts();
    let mut variations: Vec<Vec<f64>> = columns.column_iter().map(|c| c.iter().copied().collect()).collect();
    variations.push(off);
    if motion.mode().stops[chatter.stop] == StopState::Closed {
        variations.iter_mut().for_each(|v| keep(system, motion.mode(), v));
    }
    while motion.mode().stops[chatter.stop] != StopState::Closed {
        if motion.advance_with(latest, &mut variations).map_err(failed)? == Reached::End {
            return Err(Obstacle::Order);
        }
        motion.pass_event_with(&mut variations).map_err(failed)?;
    }
    if *motion.mode() != chatter.mode {
        return Err(Obstacle::Order);
    }
    z.iter_mut().zip(motion.state()).zip(&variations[columns.ncols()]).for_each(|((z, x), off)| *z = x + off);
    for (mut column, variation) in columns.column_iter_mut().zip(&variations) {
        column.copy_from_slice(variation);
    }
    Ok(motion.time())
}
