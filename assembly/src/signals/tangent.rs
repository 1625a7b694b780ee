//! The derivative of all signals by one parameter (docs/assembly-law.md (A28)).

use super::{Parts, SignalPiece, Signals};
use crate::description::Signal;
use nalgebra::DVector;
use std::f64::consts::TAU;

/// A signal and the rate that is added to it.
pub type RatedSignal<'a> = (&'a Signal, f64);

/// The derivative of the signals by one parameter: that of each signal's row, of the coordinates at
/// a fixed time, and of the times of knots.
#[derive(Clone, Debug)]
pub struct SignalTangent {
    /// By signal: the derivative of its row.
    pub rows: Vec<DVector<f64>>,
    /// Place of a cosine, and the derivative of its angular frequency.
    frequencies: Vec<(usize, f64)>,
    pieces: Vec<PieceTangent>,
}

/// The derivative of a piece: of its rate, and of its steps by time.
#[derive(Clone, Debug)]
struct PieceTangent {
    first: usize,
    count: usize,
    rate: f64,
    steps: Vec<StepTangent>,
}

/// A step with the derivatives of its height and of its time.
#[derive(Clone, Copy, Debug)]
struct StepTangent {
    time: f64,
    size: f64,
    height: f64,
    later: f64,
}

/// A step whose time varies.
#[derive(Clone, Copy, Debug)]
pub struct StepTime {
    /// Place of the coordinate that it changes.
    pub place: usize,
    /// By how much.
    pub height: f64,
    /// Derivative of its time.
    pub later: f64,
}

impl Signals {
    /// The derivative of `signals`, which these coordinates were laid out for, along `along`:
    /// signals of the same parts, whose numbers are derivatives.
    pub(crate) fn tangent(&self, signals: &[RatedSignal], along: &[RatedSignal]) -> SignalTangent {
        let mut tangent = SignalTangent { rows: Vec::new(), frequencies: Vec::new(), pieces: Vec::new() };
        for (parts, (of, along)) in self.parts.iter().zip(signals.iter().zip(along)) {
            tangent.rows.push(self.row_tangent(parts, of.0, along.0));
            for (&(place, ..), by) in parts.harmonics.iter().zip(&along.0.harmonics) {
                if by.frequency != 0.0 {
                    tangent.frequencies.push((self.one + 1 + 2 * place, TAU * by.frequency));
                }
            }
            let piece = parts.piece.map(|p| PieceTangent::of(&self.pieces[p], of.0, *along));
            tangent.pieces.extend(piece.filter(PieceTangent::is_needed));
        }
        tangent
    }

    fn row_tangent(&self, parts: &Parts, signal: &Signal, along: &Signal) -> DVector<f64> {
        let mut row = DVector::zeros(self.size);
        row[self.one] = along.constant;
        for (&(place, ..), (h, by)) in
            parts.harmonics.iter().zip(signal.harmonics.iter().zip(&along.harmonics))
        {
            let (sine, cosine) = h.phase.sin_cos();
            row[self.one + 1 + 2 * place] += by.amplitude * sine + h.amplitude * cosine * by.phase;
            row[self.one + 2 + 2 * place] += by.amplitude * cosine - h.amplitude * sine * by.phase;
        }
        row
    }

    /// By coordinate of the augmented state its place in one with the signals of `other`, which has
    /// the same parts in another layout; `None` for a coordinate that is zero there.
    pub(crate) fn places_in(&self, other: &Self) -> Vec<Option<usize>> {
        let mut places: Vec<Option<usize>> =
            (0..self.size).map(|j| Some(j).filter(|&j| j <= self.one)).collect();
        for (own, others) in self.parts.iter().zip(&other.parts) {
            for (&(place, ..), &(there, ..)) in own.harmonics.iter().zip(&others.harmonics) {
                for part in 1..3 {
                    places[self.one + 2 * place + part] = Some(other.one + 2 * there + part);
                }
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

impl PieceTangent {
    fn of(piece: &SignalPiece, signal: &Signal, (along, rate): RatedSignal) -> Self {
        let steps = signal.steps.iter().zip(&along.steps);
        let steps = steps.map(|(s, by)| StepTangent {
            time: s.time,
            size: s.height,
            height: by.height,
            later: by.time,
        });
        let steps = steps.filter(|s| s.height != 0.0 || s.later != 0.0).collect();
        Self { first: piece.first, count: piece.count, rate, steps }
    }

    fn is_needed(&self) -> bool {
        self.rate != 0.0 || !self.steps.is_empty()
    }
}

impl SignalTangent {
    /// Writes the derivative of the signals' coordinates at a time, just after its knots, into the
    /// coordinates from `one` on.
    pub fn fill(&self, one: usize, time: f64, z: &[f64], to: &mut [f64]) {
        to[one..].fill(0.0);
        for &(cosine, omega) in &self.frequencies {
            to[cosine] = -omega * time * z[cosine + 1];
            to[cosine + 1] = omega * time * z[cosine];
        }
        for piece in &self.pieces {
            let steps = piece.steps.iter().filter(|s| s.time <= time);
            to[piece.first] += piece.rate * time + steps.map(|s| s.height).sum::<f64>();
            if piece.count > 1 {
                to[piece.first + 1] += piece.rate;
            }
        }
    }

    /// Whether the coordinates vary.
    pub fn varies(&self) -> bool {
        !(self.frequencies.is_empty() && self.pieces.is_empty())
    }

    /// Whether steps or rates vary.
    pub fn varies_pieces(&self) -> bool {
        !self.pieces.is_empty()
    }

    /// The part of the derivative of the row of a signal's time derivative that comes from
    /// frequencies.
    pub fn turned(&self, row: &DVector<f64>) -> DVector<f64> {
        let mut rate = DVector::zeros(row.len());
        for &(cosine, omega) in &self.frequencies {
            rate[cosine] = omega * row[cosine + 1];
            rate[cosine + 1] = -omega * row[cosine];
        }
        rate
    }

    /// The derivative of the signals' rows in z' = A z: by place, its one entry with its place.
    pub fn rates(&self) -> impl Iterator<Item = (usize, (usize, f64))> {
        let both = |&(c, omega): &(usize, f64)| [(c, (c + 1, -omega)), (c + 1, (c, omega))];
        self.frequencies.iter().flat_map(both)
    }

    /// The first step at `time` whose time varies, if there is one.
    pub fn later(&self, time: f64) -> Option<StepTime> {
        self.all_later(time).next()
    }

    /// The steps at `time` whose times vary: several where they follow from one parameter.
    pub fn all_later(&self, time: f64) -> impl Iterator<Item = StepTime> {
        self.pieces.iter().filter_map(move |piece| {
            let step = piece.steps.iter().find(|s| s.time == time && s.later != 0.0)?;
            Some(StepTime { place: piece.first, height: step.size, later: step.later })
        })
    }
}
