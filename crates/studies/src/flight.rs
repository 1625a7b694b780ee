//! Flights of a described machine's motion and the events between them. During a flight one linear
//! system z' = A z holds.
//!
//! Everything observed along a motion (extrema, mean squares, maxima, variations) comes from
//! [`follow`]: the engine decides where flights end, and within a flight the states are a power
//! series.

use nalgebra::{DMatrix, DVector, DVectorView};
use std::collections::HashMap;
use std::sync::Arc;
use vibro_machine::flow::{Ahead, FlowTable, ORDERS, Sparse, SparseMatrix};
use vibro_machine::functional::StateRow;
use vibro_machine::linear::Linear;
use vibro_machine::mode::{Mode, Watch};
use vibro_machine::motion::{Event, Reached};
use vibro_machine::norm::rate_bound;
use vibro_machine::system::System;
use vibro_machine::{Error, Motion, Quantity};
use vibro_numerics::events::turns;

/// Bound of the norm of A times the length of a stretch. A series of [`ORDERS`] terms then omits
/// less than 2²⁶/26! of the state.
const RADIUS: f64 = 2.0;
/// Bound of a term relative to the state, below which a series ends.
const REMAINDER: f64 = 1e-19;

/// Bound of the norm of A times the fraction of a span whose series is squared.
const PART: f64 = 0.5;

/// Length of a stretch, as a fraction of the engine's series with curved forces: the first omitted
/// term is then smaller by the factor 0.7²⁶ < 1e-4.
const CURVED_PART: f64 = 0.7;
/// Length of a series, relative to a flight, from which it is used as a whole.
const SHORTEST: f64 = 1e-9;

/// Length of a flight, in stretches, above which variations are carried by a matrix, by squaring.
const MANY: f64 = 64.0;
/// Largest size of an augmented state for this matrix: products cost the cube of the size.
const LARGE: usize = 160;

/// Power series of the states over a stretch of a flight; its variable is the fraction of the
/// stretch.
#[derive(Clone, Debug, Default)]
pub struct Series {
    size: usize,
    terms: Vec<f64>,
}

impl Series {
    /// Terms of the series, beginning with the initial state.
    pub fn terms(&self) -> impl DoubleEndedIterator<Item = &[f64]> {
        self.terms.chunks_exact(self.size.max(1))
    }
}

/// Linear system of a mode, by rows.
#[derive(Debug)]
pub struct Flow {
    /// The mode.
    pub mode: Mode,
    /// A.
    a: SparseMatrix,
    /// Bound of the norm of A, 1/s.
    rate: f64,
    /// Forces of the mode's independent contacts.
    pub lambda: Vec<Sparse>,
    /// Event functions that end the mode, each negative inside it.
    pub watched: Vec<(Watch, StateRow)>,
    /// The engine's flow, for curved forces, which its series contains.
    curved: Option<FlowTable>,
}

impl Flow {
    /// The linear system of a mode.
    pub fn new(system: &System, mode: &Mode) -> Self {
        let Linear { a, lambda, watched, .. } = system.linear(mode);
        let rate = rate_bound(&a, system.signals.one);
        let dense = |row: &Sparse| StateRow::from_vec(row.dense(system.signals.size));
        let watched = watched.into_iter().map(|(watch, row)| (watch, dense(&row))).collect();
        let curved = (!system.curved.is_empty()).then(|| FlowTable::of_mode(system, mode));
        Self { mode: mode.clone(), a, rate, lambda, watched, curved }
    }

    /// z' at a state.
    pub fn derivative(&self, z: &[f64]) -> Vec<f64> {
        if let Some(table) = &self.curved {
            let mut rates = z.to_vec();
            table.derivative(1, &mut rates);
            return rates;
        }
        self.a.rows_times(0..z.len(), z).as_slice().to_vec()
    }

    /// Row of the rate of a functional: r A.
    pub fn rate_of(&self, row: &[f64]) -> Vec<f64> {
        let mut rate = vec![0.0; row.len()];
        self.a.after_row(row, 1.0, &mut rate);
        rate
    }

    /// Writes at most [`ORDERS`] terms of the power series of the states over a time `span`. The
    /// variable of the series is the fraction of `span`, from 0 to 1.
    fn series(&self, z: &[f64], span: f64, to: &mut Series) {
        let count = z.len();
        to.size = count;
        to.terms.clear();
        to.terms.extend_from_slice(z);
        let mut size = 1.0;
        for k in 1..ORDERS {
            let factor = span / k as f64;
            to.terms.resize((k + 1) * count, 0.0);
            let (before, next) = to.terms.split_at_mut(k * count);
            self.a.rows_times_to(0, &before[(k - 1) * count..], factor, next);
            size *= self.rate * factor;
            if size < REMAINDER {
                break;
            }
        }
    }

    /// Approximate length of a flight in sub-steps of the mode; for a sub-step, rate times time is
    /// at most 3.
    pub fn sub_steps_of(&self, span: f64) -> f64 {
        self.rate * span / 3.0
    }

    /// Number of stretches of a flight.
    pub fn stretches_of(&self, span: f64) -> f64 {
        (self.rate * span / RADIUS).ceil().max(1.0)
    }

    /// Variation with a parameter at the end of a flight, from the state and the variation at its
    /// beginning. The system varies as well: `beside` are the systems at parameter values that are
    /// `width` apart. All systems must number their states alike.
    pub fn varied(&self, beside: [&Self; 2], width: f64, [z, v]: [&[f64]; 2], span: f64) -> Vec<f64> {
        if self.is_curved() {
            let [below, above] = beside.map(|flow| flow.after(z, span));
            let mut variation =
                (self.transition(z, span).1 * DVectorView::from_slice(v, v.len())).as_slice().to_vec();
            let sources = above.iter().zip(&below).map(|(above, below)| (above - below) / width);
            variation.iter_mut().zip(sources).for_each(|(v, source)| *v += source);
            return variation;
        }
        let (count, size) = (self.stretches_of(span), z.len());
        let part = span / count;
        let (mut state, mut variation) = (z.to_vec(), v.to_vec());
        let mut buffers = [const { Vec::new() }; 5];
        buffers.iter_mut().for_each(|buffer| buffer.resize(size, 0.0));
        let [x, y, next, below, above] = &mut buffers;
        for _ in 0..count as u64 {
            x.copy_from_slice(&state);
            y.copy_from_slice(&variation);
            let mut bound = 1.0;
            for k in 1..ORDERS {
                let factor = part / k as f64;
                beside[0].a.rows_times_to(0, x, factor / width, below);
                beside[1].a.rows_times_to(0, x, factor / width, above);
                self.a.rows_times_to(0, y, factor, next);
                (0..size).for_each(|i| y[i] = next[i] + (above[i] - below[i]));
                self.a.rows_times_to(0, x, factor, next);
                std::mem::swap(x, next);
                (0..size).for_each(|i| {
                    state[i] += x[i];
                    variation[i] += y[i];
                });
                bound *= self.rate * factor.abs();
                if bound < REMAINDER {
                    break;
                }
            }
        }
        variation
    }

    /// Calls `visit` with the series and length, s, of each stretch. Returns the state at the end.
    pub fn stretches(&self, z: &[f64], span: f64, visit: &mut dyn FnMut(&Series, f64)) -> Vec<f64> {
        if let Some(table) = &self.curved {
            return curved_stretches(table, z, span, visit);
        }
        let count = self.stretches_of(span);
        let part = span / count;
        let (mut state, mut series) = (z.to_vec(), Series::default());
        for _ in 0..count as u64 {
            self.series(&state, part, &mut series);
            visit(&series, part);
            state.fill(0.0);
            for term in series.terms().rev() {
                state.iter_mut().zip(term).for_each(|(sum, x)| *sum += x);
            }
        }
        state
    }

    /// Carries variations, and with curved forces the state, over a part of a flight.
    pub fn carry_along(&self, state: &mut [f64], variations: &mut [Vec<f64>], span: f64) {
        match &self.curved {
            Some(table) => table.carry_along(state, variations, span),
            None => variations.iter_mut().for_each(|v| *v = self.stretches(v, span, &mut |_, _| ())),
        }
    }

    /// Carries variations over a flight that begins in the state `start`: each by its series or,
    /// over many stretches, all by the matrix exp(A t), computed by squaring.
    pub fn carry(&self, start: &[f64], variations: &mut [Vec<f64>], span: f64) {
        if let Some(table) = &self.curved {
            return table.carry_along(&mut start.to_vec(), variations, span);
        }
        let (count, size) = (self.stretches_of(span), variations.first().map_or(0, Vec::len));
        if count <= MANY || size > LARGE {
            for v in variations.iter_mut() {
                *v = self.stretches(v, span, &mut |_, _| ());
            }
            return;
        }
        let matrix = self.propagator(span);
        for v in variations.iter_mut() {
            let end = &matrix * DVector::from_column_slice(v);
            v.copy_from_slice(end.as_slice());
        }
    }

    /// State after a span of either sign, and its derivative with respect to the state at the
    /// start: exp(A t) without curved forces.
    pub fn transition(&self, z: &[f64], span: f64) -> (Vec<f64>, DMatrix<f64>) {
        let Some(table) = &self.curved else {
            let matrix = self.propagator(span);
            let end = &matrix * DVectorView::from_slice(z, z.len());
            return (end.as_slice().to_vec(), matrix);
        };
        let unit = |i: usize| (0..z.len()).map(|k| f64::from(u8::from(k == i))).collect();
        let (mut end, mut columns) = (z.to_vec(), (0..z.len()).map(unit).collect::<Vec<Vec<f64>>>());
        table.carry_along(&mut end, &mut columns, span);
        (end, DMatrix::from_iterator(z.len(), z.len(), columns.into_iter().flatten()))
    }

    /// State after a span of either sign.
    pub fn after(&self, z: &[f64], span: f64) -> Vec<f64> {
        match &self.curved {
            Some(_) => self.stretches(z, span, &mut |_, _| ()),
            None => self.transition(z, span).0,
        }
    }

    /// Writes the curved forces into a state.
    pub fn fill(&self, z: &mut [f64]) {
        if let Some(table) = &self.curved {
            table.fill_curves(z);
        }
    }

    /// Whether the machine has curved forces.
    pub fn is_curved(&self) -> bool {
        self.curved.is_some()
    }

    /// exp(A t) over a span of either sign: the series over a fraction of it, repeatedly squared.
    /// E - 1 is squared, so that a short span keeps its digits.
    pub fn propagator(&self, span: f64) -> DMatrix<f64> {
        let size = self.a.len();
        let doublings = (self.rate * span.abs() / PART).log2().ceil().max(0.0);
        let part = span / doublings.exp2();
        // Columns of these matrices are rows of the terms.
        let mut term = DMatrix::identity(size, size);
        let (mut change, mut next) = (DMatrix::zeros(size, size), DMatrix::zeros(size, size));
        let mut bound = 1.0;
        for k in 1..ORDERS {
            let factor = part / k as f64;
            let rows = term.as_slice().chunks_exact(size.max(1));
            for (row, to) in rows.zip(next.as_mut_slice().chunks_exact_mut(size.max(1))) {
                self.a.after_row(row, factor, to);
            }
            std::mem::swap(&mut term, &mut next);
            change += &term;
            bound *= self.rate * factor.abs();
            if bound < REMAINDER {
                break;
            }
        }
        for _ in 0..doublings as u32 {
            multiply(&change, &change, 1.0, &mut next);
            next.iter_mut().zip(change.iter()).for_each(|(square, x)| *square += 2.0 * x);
            std::mem::swap(&mut change, &mut next);
        }
        for i in 0..size {
            change[(i, i)] += 1.0;
        }
        change.transpose()
    }
}

/// [`Flow::stretches`] with curved forces. A stretch is shorter than the engine's series, so that
/// its [`ORDERS`] terms suffice.
fn curved_stretches(
    table: &FlowTable,
    z: &[f64],
    span: f64,
    visit: &mut dyn FnMut(&Series, f64),
) -> Vec<f64> {
    let (mut state, mut ahead, mut left) = (z.to_vec(), Ahead::towards(span < 0.0), span.abs());
    let mut series = Series { size: z.len(), terms: Vec::new() };
    while left > 0.0 {
        ahead.find(table, &state, left / CURVED_PART, |_| (0, 0.0));
        if ahead.span == 0.0 {
            break;
        }
        // A series that ends at the edge of a power is used as a whole once it is short: by parts of
        // the way the edge would never be reached.
        let is_short = ahead.span < SHORTEST * span.abs();
        let length = left.min(if is_short { ahead.span } else { CURVED_PART * ahead.span });
        let is_last = length == left || ahead.span >= left / CURVED_PART;
        let part = (length / ahead.span).copysign(span);
        series.terms.clear();
        let mut power = 1.0;
        for term in ahead.series.terms().take(ORDERS) {
            series.terms.extend(term.iter().map(|x| x * power));
            power *= part;
        }
        visit(&series, length.copysign(span));
        ahead.series.at(part, &mut state);
        table.fill_curves(&mut state);
        left = if is_last { 0.0 } else { left - length };
    }
    state
}

/// Matrix size up to which a product is summed in place: a library's product first packs its
/// factors, which takes longer than such a small product.
const SMALL: usize = 32;

/// Writes `factor` a b to a matrix of the product's shape.
pub fn multiply(a: &DMatrix<f64>, b: &DMatrix<f64>, factor: f64, to: &mut DMatrix<f64>) {
    if a.nrows() > SMALL {
        return to.gemm(factor, a, b, 0.0);
    }
    let rows = a.nrows();
    let columns = b.as_slice().chunks_exact(b.nrows());
    for (to, b) in to.as_mut_slice().chunks_exact_mut(rows).zip(columns) {
        to.fill(0.0);
        for (a, b) in a.as_slice().chunks_exact(rows).zip(b).filter(|(_, b)| **b != 0.0) {
            let b = factor * b;
            to.iter_mut().zip(a).for_each(|(sum, a)| *sum += b * a);
        }
    }
}

/// Product of a row and a state.
pub fn dot(row: &[f64], z: &[f64]) -> f64 {
    row.iter().zip(z).map(|(a, b)| a * b).sum()
}

/// Coefficients of a functional along a series.
pub fn coefficients(row: &[f64], series: &Series) -> [f64; ORDERS] {
    let mut c = [0.0; ORDERS];
    c.iter_mut().zip(series.terms()).for_each(|(c, term)| *c = dot(row, term));
    c
}

/// Value of a polynomial.
pub fn value_at(q: &[f64; ORDERS], u: f64) -> f64 {
    q.iter().rev().fold(0.0, |sum, c| sum * u + c)
}

/// Visits the values of a polynomial at 0, at every extremum in between and at 1, in this order.
/// The polynomial is monotone between two of them.
pub fn monotone_pieces(q: &[f64; ORDERS], visit: &mut dyn FnMut(f64)) {
    turning_points(q, &mut |_, value| visit(value));
}

/// [`monotone_pieces`] with the arguments of the values.
pub fn turning_points(q: &[f64; ORDERS], visit: &mut dyn FnMut(f64, f64)) {
    visit(0.0, q[0]);
    let spread: f64 = q[1..].iter().map(|c| c.abs()).sum();
    if spread > 0.0 {
        let slope: [f64; ORDERS] =
            std::array::from_fn(|k| if k + 1 < ORDERS { (k + 1) as f64 * q[k + 1] } else { 0.0 });
        turns(&slope, (0.0, 1.0), &mut (slope[0] > 0.0), |u, _| visit(u, value_at(q, u)));
    }
    visit(1.0, value_at(q, 1.0));
}

/// Flight as an observer receives it.
#[derive(Clone, Copy, Debug)]
pub struct ObservedFlight<'a> {
    /// Time of its beginning, s.
    pub time: f64,
    /// Linear system that holds during the flight.
    pub flow: &'a Flow,
    /// Augmented state at its beginning.
    pub start: &'a [f64],
    /// Duration, s.
    pub span: f64,
}

/// Event between two flights.
#[derive(Clone, Copy, Debug)]
pub struct Passage<'a> {
    /// Time, s.
    pub time: f64,
    /// Event function that ended the flight; `None` for a knot of a signal.
    pub watch: Option<Watch>,
    /// Linear systems before and after.
    pub flows: [&'a Flow; 2],
    /// States before and after the event's law.
    pub states: [&'a [f64]; 2],
    /// Reported events.
    pub events: &'a [Event],
    /// Energy lost at impacts of the event, J, from the engine's account; 0 without impacts.
    pub lost: f64,
}

/// Observer of a motion.
pub trait Observer {
    /// Receives a finished flight.
    fn flight(&mut self, system: &System, flight: ObservedFlight<'_>);
    /// Receives the event after a flight.
    fn passage(&mut self, system: &System, passage: Passage<'_>);
    /// Receives a reported event immediately, even if its law then fails.
    fn told(&mut self, _event: &Event) {}
}

/// Linear systems of the modes so far.
#[derive(Debug, Default)]
pub struct Flows(HashMap<Mode, Arc<Flow>>);

impl Flows {
    /// The linear system of a mode.
    pub fn of(&mut self, system: &System, mode: &Mode) -> Arc<Flow> {
        if let Some(flow) = self.0.get(mode) {
            return flow.clone();
        }
        let flow = Arc::new(Flow::new(system, mode));
        self.0.insert(mode.clone(), flow.clone());
        flow
    }
}

impl Flows {
    /// The value of a quantity now.
    pub fn value(&mut self, motion: &Motion, quantity: Quantity) -> f64 {
        let system = motion.assembly().system();
        let flow = self.of(system, motion.mode());
        dot(&flow.row_of(system, quantity), motion.state().as_slice())
    }
}

/// Follows a motion to a time, or to the first event for which `stops` returns true, and passes
/// its flights and events to the observers. Returns whether an event ended it.
///
/// # Errors
/// As [`Motion::advance_to`].
pub fn follow(
    motion: &mut Motion,
    flows: &mut Flows,
    end: f64,
    observers: &mut [&mut dyn Observer],
    stops: &mut dyn FnMut(&[Event]) -> bool,
) -> Result<bool, Error> {
    let assembly = motion.assembly().clone();
    let system = assembly.system();
    let mut events = Vec::new();
    // A knot at the end still has samples to process.
    while motion.time() < end || motion.has_time_event_until(end) {
        let (start, from) = (own(motion.state()), motion.time());
        let flow = flows.of(system, motion.mode());
        events.clear();
        let mut tell = |event: &Event| {
            observers.iter_mut().for_each(|o| o.told(event));
            events.push(event.clone());
        };
        let outcome = motion.advance_flight(end, &mut tell);
        let span = motion.time() - from;
        // A state that has overflowed is not observed.
        if span > 0.0 && !matches!(outcome, Err(Error::Beyond { .. })) {
            let flight = ObservedFlight { time: from, flow: &flow, start: &start, span };
            observers.iter_mut().for_each(|o| o.flight(system, flight));
        }
        if outcome? == Reached::Event {
            let (before, watch, time) = (own(motion.state()), motion.due(), motion.time());
            let impacts = motion.energy().impacts;
            let mut tell = |event: &Event| {
                observers.iter_mut().for_each(|o| o.told(event));
                events.push(event.clone());
            };
            motion.apply_event(&mut tell)?;
            let lost = motion.energy().impacts.minus(impacts).value();
            let (after, next) = (own(motion.state()), flows.of(system, motion.mode()));
            let (flows, states) = ([&*flow, &*next], [&before[..], &after[..]]);
            let passage = Passage { time, watch, flows, states, events: &events, lost };
            observers.iter_mut().for_each(|o| o.passage(system, passage));
            if stops(&events) {
                return Ok(true);
            }
        }
    }
    Ok(false)
}

fn own(z: &DVector<f64>) -> Vec<f64> {
    z.iter().copied().collect()
}

#[cfg(test)]
mod tests;
