//! Laying out signals as coordinates.

use super::integral::{Integral, Integrand};
use super::pieces::{Knots, Pieces};
use super::sweep::SweepPiece;
use super::{Course, Parts, SignalIntegral, SignalPiece, Signals, harmonic};
use crate::description::{Interpolation, Signal};
use crate::functional::Functional;
use crate::kernel::Sparse;

/// How signals become coordinates. A motion shares coordinates where it can; derivatives by a
/// frequency or by the rate of a prescribed body need separate coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// Whether each harmonic has a cosine and a sine of its own, even where frequencies are equal.
    pub frequencies_apart: bool,
    /// Whether each prescribed motion has a part that grows with time, even at the rate 0.
    pub rates: bool,
}

/// Builder of [`Signals`]: [`add`](Self::add) takes every signal, then [`finish`](Self::finish)
/// returns a row for each.
#[derive(Debug)]
pub struct Builder {
    signals: Signals,
    layout: Layout,
}

impl Builder {
    /// A builder for an augmented state whose first `one` coordinates are not signals.
    pub fn new(one: usize, layout: Layout) -> Self {
        let signals = Signals {
            one,
            frequencies: Vec::new(),
            pieces: Vec::new(),
            sweeps: Vec::new(),
            knots: Knots::default(),
            repeated: Vec::new(),
            repeated_of: Vec::new(),
            size: 0,
            curved: 0,
            inputs: 0,
            integrals: 0,
            rates: Vec::new(),
            parts: Vec::new(),
        };
        Self { signals, layout }
    }

    /// Adds a signal; returns its index.
    pub fn add(&mut self, signal: &Signal) -> usize {
        self.add_part(&signal.into(), false)
    }

    /// Adds the motion of a body; returns its index.
    pub fn add_motion(&mut self, course: &Course) -> usize {
        self.add_part(course, self.layout.rates || course.v != 0.0)
    }

    fn add_part(&mut self, course: &Course, grows: bool) -> usize {
        let Course { signal, order, s, v } = *course;
        let apart = self.layout.frequencies_apart;
        let (mut constant, mut rate) = (if order == 0 { signal.constant } else { s }, v);
        let mut harmonics = Vec::new();
        for h in &signal.harmonics {
            let frequencies = &mut self.signals.frequencies;
            let known = frequencies.iter().position(|&f| f == h.frequency && !apart);
            let place = known.unwrap_or_else(|| {
                frequencies.push(h.frequency);
                frequencies.len() - 1
            });
            let [cosine, sine, kept, growth] = harmonic(h, order);
            harmonics.push((place, cosine, sine));
            if order > 0 {
                constant += kept;
                rate += growth;
            }
        }
        let is = |kind: Interpolation| signal.table.as_ref().is_some_and(|t| t.interpolation == kind);
        let degree = match (signal.input || is(Interpolation::Cubic), is(Interpolation::Straight)) {
            (true, _) => 3,
            (_, true) => 1,
            _ => 0,
        };
        let degree = (degree + order).max(usize::from(grows));
        let sweeps = signal.sweeps.iter().map(|sweep| {
            let own = SweepPiece::new(sweep, order);
            self.signals.knots.times.push(own.end());
            self.signals.sweeps.push(own);
            self.signals.sweeps.len() - 1
        });
        let sweeps = sweeps.collect();
        let needs_piece = degree > 0 || !signal.steps.is_empty() || signal.table.is_some();
        let piece = needs_piece.then(|| self.add_piece(course, degree + 1, rate));
        self.signals.parts.push(Parts { constant, harmonics, piece, sweeps });
        self.signals.parts.len() - 1
    }

    fn add_piece(&mut self, course: &Course, count: usize, rate: f64) -> usize {
        let Course { signal, order, .. } = *course;
        let repeat = signal.repeat;
        let steps = (!signal.steps.is_empty()).then(|| Pieces::of_steps(&signal.steps, repeat));
        let table = signal.table.as_ref().map(|record| Pieces::of_record(record, record.factor(), repeat));
        let holds = signal.table.as_ref().is_some_and(|t| t.interpolation == Interpolation::Hold);
        // A repeated staircase has a piece at time 0, even without a jump: only jumps are knots.
        let knots = steps.iter().map(|steps| steps.changes(repeat.is_none()));
        for knots in knots.chain(table.iter().map(|table| table.changes(!holds))) {
            match repeat {
                Some(_) => {
                    self.signals.repeated.push(knots);
                    self.signals.repeated_of.push(self.signals.parts.len());
                }
                None => self.signals.knots.times.extend(knots.times),
            }
        }
        let input = signal.input.then(|| {
            self.signals.inputs += 1;
            self.signals.inputs - 1
        });
        let integral = (order > 0).then(|| {
            let (table, steps) = (table.clone(), steps.clone());
            let of = Integrand { constant: signal.constant, table, steps, kicks: Vec::new(), repeat };
            self.signals.integrals += 1;
            SignalIntegral { order, parts: Integral::of(order, &of), carried: self.signals.integrals - 1 }
        });
        self.signals.pieces.push(SignalPiece { first: 0, count, steps, table, rate, input, integral });
        self.signals.pieces.len() - 1
    }

    /// The coordinates, with `curved` coordinates for curved forces at the end, and the row of
    /// each signal in the order of [`add`](Self::add).
    pub fn finish(mut self, curved: usize) -> (Signals, Vec<Functional>) {
        let signals = &mut self.signals;
        let mut place = signals.one + 1 + 2 * signals.frequencies.len();
        for piece in &mut signals.pieces {
            piece.first = place;
            place += piece.count;
        }
        for sweep in &mut signals.sweeps {
            sweep.first = place;
            place = sweep.places().end;
        }
        signals.curved = place;
        signals.size = place + curved;
        for integral in signals.pieces.iter_mut().filter_map(|piece| piece.integral.as_mut()) {
            integral.carried += signals.inputs;
        }
        signals.knots.times.sort_by(f64::total_cmp);
        signals.rates = signals.rates_of_units();
        let rows = signals.parts.iter().map(|parts| {
            let mut row = vec![(signals.one, parts.constant)];
            for &(f, cosine, sine) in &parts.harmonics {
                row.push((signals.one + 1 + 2 * f, cosine));
                row.push((signals.one + 2 + 2 * f, sine));
            }
            row.extend(parts.piece.map(|p| (signals.pieces[p].first, 1.0)));
            row.extend(parts.sweeps.iter().map(|&i| (signals.sweeps[i].first, 1.0)));
            Functional::from_terms(signals.size, Sparse::summed(row).terms().iter().copied())
        });
        let rows = rows.collect();
        (self.signals, rows)
    }
}
