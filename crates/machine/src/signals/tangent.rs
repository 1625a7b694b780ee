//! The derivative of all signals by one parameter (docs/assembly-law.md (A33)).

use super::integral::{Integral, Integrand};
use super::pieces::{Knots, Pieces};
use super::sweep::SweepPiece;
use super::{Course, Parts, SignalPiece, Signals, harmonic};
use crate::description::{Harmonic, Record};
use nalgebra::DVector;
use std::f64::consts::TAU;
use vibro_numerics::double_double::DoubleDouble;

/// The derivative of the signals by one parameter: of each signal's row, of the coordinates at a
/// fixed time, and of the times of knots.
#[derive(Clone, Debug, Default)]
pub struct SignalTangent {
    /// Derivative of each signal's row.
    pub rows: Vec<DVector<f64>>,
    /// Index of each cosine that varies, with the derivative of its angular frequency.
    frequencies: Vec<(usize, f64)>,
    pieces: Vec<PieceTangent>,
    sweeps: Vec<SweepPiece>,
}

/// The derivative of a piece at a fixed time.
#[derive(Clone, Debug)]
struct PieceTangent {
    first: usize,
    count: usize,
    rate: f64,
    steps: Option<Pieces<1>>,
    table: Option<Pieces<4>>,
    integral: Option<Integral>,
    /// Start time of an added part, with the value and rate that it adds.
    carried: (f64, [f64; 2]),
    /// Times of the steps in `later`.
    knots: Knots,
    later: Vec<StepTime>,
}

/// A step whose time varies.
#[derive(Clone, Copy, Debug)]
pub struct StepTime {
    /// Index of the coordinate that the step changes.
    pub place: usize,
    /// Height of the step.
    pub height: f64,
    /// Derivative of the step's time.
    pub later: f64,
}

impl Signals {
    /// The derivative of `signals`, for which these coordinates were laid out. `along` is the
    /// direction: signals with the same parts, whose numbers are derivatives.
    pub(crate) fn tangent(&self, signals: &[Course], along: &[Course]) -> SignalTangent {
        let mut tangent = SignalTangent::default();
        for (parts, (of, along)) in self.parts.iter().zip(signals.iter().zip(along)) {
            let (row, growth) = self.row_tangent(parts, of, along);
            for (&(place, ..), by) in parts.harmonics.iter().zip(&along.signal.harmonics) {
                if by.frequency != 0.0 {
                    tangent.frequencies.push((self.one + 1 + 2 * place, TAU * by.frequency));
                }
            }
            let piece = parts.piece.map(|p| PieceTangent::of(&self.pieces[p], of, along, growth));
            let sweeps = tangent.sweeps.len();
            for (&i, by) in parts.sweeps.iter().zip(&along.signal.sweeps) {
                let varies = [by.amplitude, by.from, by.to, by.duration, by.phase].iter().any(|x| *x != 0.0);
                tangent.sweeps.extend(varies.then(|| self.sweeps[i].along(by)));
            }
            // The piece may have to cancel changes of the integral's other parts (`go_on`).
            let is_moved = of.order > 0 && (row.amax() > 0.0 || tangent.sweeps.len() > sweeps);
            tangent.pieces.extend(piece.filter(|piece| is_moved || piece.is_needed()));
            tangent.rows.push(row);
        }
        tangent
    }

    /// Derivative of a signal's row, and of the rate at which its harmonics grow with time.
    fn row_tangent(&self, parts: &Parts, course: &Course, along: &Course) -> (DVector<f64>, f64) {
        let (mut row, mut growth) = (DVector::zeros(self.size), 0.0);
        row[self.one] = if course.order == 0 { along.signal.constant } else { along.s };
        let harmonics = course.signal.harmonics.iter().zip(&along.signal.harmonics);
        for (&(place, ..), (h, by)) in parts.harmonics.iter().zip(harmonics) {
            let [cosine, sine, constant, grows] = harmonic_by(h, by, course.order);
            row[self.one + 1 + 2 * place] += cosine;
            row[self.one + 2 + 2 * place] += sine;
            row[self.one] += constant;
            growth += grows;
        }
        (row, growth)
    }

    /// For each coordinate of the augmented state, its index in the augmented state of `other`,
    /// which has the same parts in another layout; `None` for a coordinate that is zero there.
    pub(crate) fn places_in(&self, other: &Self) -> Vec<Option<usize>> {
        let mut places: Vec<Option<usize>> =
            (0..self.size).map(|j| Some(j).filter(|&j| j <= self.one)).collect();
        for (own, others) in self.parts.iter().zip(&other.parts) {
            for (&(place, ..), &(there, ..)) in own.harmonics.iter().zip(&others.harmonics) {
                for part in 1..3 {
                    places[self.one + 2 * place + part] = Some(other.one + 2 * there + part);
                }
            }
            for (&i, &there) in own.sweeps.iter().zip(&others.sweeps) {
                let places_of = self.sweeps[i].places().zip(other.sweeps[there].places());
                places_of.for_each(|(own, there)| places[own] = Some(there));
            }
            if let (Some(piece), Some(there)) = (own.piece, others.piece) {
                let (piece, there) = (&self.pieces[piece], &other.pieces[there]);
                (0..piece.count.min(there.count))
                    .for_each(|k| places[piece.first + k] = Some(there.first + k));
            }
        }
        places
    }
}

/// Derivative of a [`harmonic`] or of its integral: of its amplitudes, its constant part and its
/// growing part.
fn harmonic_by(h: &Harmonic, by: &Harmonic, order: usize) -> [f64; 4] {
    let (sine, cosine) = h.phase.sin_cos();
    let first = by.amplitude * sine + h.amplitude * cosine * by.phase;
    let second = by.amplitude * cosine - h.amplitude * sine * by.phase;
    if order == 0 {
        return [first, second, 0.0, 0.0];
    }
    // First by amplitude and phase at fixed frequency, then by frequency in powers of 1/ω.
    let turned = Harmonic { amplitude: first.hypot(second), phase: first.atan2(second), ..*h };
    let (by_size, whole) = (harmonic(&turned, order), harmonic(h, order));
    let powers = [order as f64, order as f64, order as f64, 1.0];
    let relative = by.frequency / h.frequency;
    std::array::from_fn(|k| by_size[k] - powers[k] * relative * whole[k])
}

/// Derivative of a record by its scale factor, in the direction `along`.
fn record_by(record: Option<&Record>, along: Option<&Record>, repeat: Option<f64>) -> Option<Pieces<4>> {
    let factor = along.and_then(|along| along.scale).filter(|factor| *factor != 0.0)?;
    record.map(|record| Pieces::of_record(record, factor, repeat))
}

impl PieceTangent {
    fn of(piece: &SignalPiece, course: &Course, along: &Course, growth: f64) -> Self {
        let (signal, by, repeat) = (course.signal, along.signal, course.signal.repeat);
        let table = record_by(signal.table.as_ref(), by.table.as_ref(), repeat);
        let raised = by.steps.iter().any(|by| by.height != 0.0);
        let mut heights = by.steps.clone();
        heights.iter_mut().zip(&signal.steps).for_each(|(by, step)| by.time = step.time);
        let steps = raised.then(|| Pieces::of_steps(&heights, repeat));
        let moved: Vec<_> = signal.steps.iter().zip(&by.steps).filter(|(_, by)| by.time != 0.0).collect();
        let order = course.order;
        let later = moved.iter().map(|(step, by)| StepTime {
            place: piece.first + order,
            height: step.height,
            later: by.time,
        });
        let later = later.collect();
        let knots = Knots { times: moved.iter().map(|(step, _)| step.time).collect(), repeat };
        let mut own = Self {
            first: piece.first,
            count: piece.count,
            rate: along.v + growth,
            steps,
            table,
            integral: None,
            carried: (0.0, [0.0; 2]),
            knots,
            later,
        };
        if order > 0 {
            // Delaying a step by δt reduces the first integral by the step's height times δt.
            let kicks: Vec<_> = moved.iter().map(|(step, by)| (step.time, -step.height * by.time)).collect();
            let (steps, table) = (own.steps.take(), own.table.take());
            if by.constant != 0.0 || steps.is_some() || table.is_some() || !kicks.is_empty() {
                let of = Integrand { constant: by.constant, table, steps, kicks, repeat };
                own.integral = Some(Integral::of(order, &of));
            }
        }
        own
    }

    fn is_needed(&self) -> bool {
        let parts = self.steps.is_some() || self.table.is_some() || self.integral.is_some();
        self.rate != 0.0 || parts || !self.later.is_empty()
    }

    /// Value and derivatives just after a time.
    fn at(&self, time: f64) -> [f64; 6] {
        let exact = DoubleDouble::new(time);
        let mut d = self.integral.as_ref().map_or([0.0; 6], |integral| integral.at(exact));
        if let Some(table) = &self.table {
            d[..4].copy_from_slice(&table.at(exact));
        }
        d[0] += self.rate * time + self.steps.as_ref().map_or(0.0, |steps| steps.sum(time));
        let (from, [place, rate]) = self.carried;
        d[0] += place + rate * (time - from);
        d[1] += self.rate + rate;
        d
    }
}

impl SignalTangent {
    /// Writes the derivative of the signals' coordinates at a time, just after its knots, into the
    /// coordinates, the first of index `one`.
    pub fn fill(&self, one: usize, time: f64, z: &[f64], to: &mut [f64]) {
        to[one..].fill(0.0);
        for &(cosine, omega) in &self.frequencies {
            to[cosine] = -omega * time * z[cosine + 1];
            to[cosine + 1] = omega * time * z[cosine];
        }
        for piece in &self.pieces {
            let place = piece.first..piece.first + piece.count;
            to[place].copy_from_slice(&piece.at(time)[..piece.count]);
        }
        self.sweeps.iter().for_each(|sweep| sweep.fill(DoubleDouble::new(time), to));
    }

    /// Makes the integral whose coordinates begin at `first` continue from its value at a time,
    /// however the parameters vary. Subtracts a derivative of its value and, for order 2, of its
    /// rate.
    pub(crate) fn go_on(&mut self, first: usize, time: f64, [place, rate]: [f64; 2]) {
        for piece in self.pieces.iter_mut().filter(|piece| piece.first == first) {
            piece.carried = (time, [-place, -rate]);
        }
    }

    /// Whether the coordinates depend on the parameter.
    pub fn varies(&self) -> bool {
        !self.frequencies.is_empty() || self.varies_pieces()
    }

    /// Whether steps, records, rates or sweeps depend on the parameter.
    pub fn varies_pieces(&self) -> bool {
        !(self.pieces.is_empty() && self.sweeps.is_empty())
    }

    /// Contribution of the frequencies to the derivative of the row of a signal's time derivative.
    pub fn turned(&self, row: &DVector<f64>) -> DVector<f64> {
        let mut rate = DVector::zeros(row.len());
        for &(cosine, omega) in &self.frequencies {
            rate[cosine] = omega * row[cosine + 1];
            rate[cosine + 1] = -omega * row[cosine];
        }
        rate
    }

    /// Derivatives of the signals' rows in z' = A z: row, and column and value of its one entry.
    pub fn rates(&self) -> impl Iterator<Item = (usize, (usize, f64))> {
        let both = |&(c, omega): &(usize, f64)| [(c, (c + 1, -omega)), (c + 1, (c, omega))];
        self.frequencies.iter().flat_map(both)
    }

    /// The first step at `time` whose time depends on the parameter.
    pub fn later(&self, time: f64) -> Option<StepTime> {
        self.all_later(time).next()
    }

    /// All steps at `time` whose times depend on the parameter.
    pub fn all_later(&self, time: f64) -> impl Iterator<Item = StepTime> {
        self.pieces.iter().filter_map(move |piece| {
            let (turn, place) = piece.knots.last(time)?;
            (piece.knots.at((turn, place)).value() == time).then(|| piece.later[place])
        })
    }
}
