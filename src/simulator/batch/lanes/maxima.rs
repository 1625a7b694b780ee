//! Local maxima of a displacement q = a x1 + b x2 + c x3, found from the flow, not from samples.
//!
//! q is continuous, while its rate jumps at impacts. The rate passes from above to below zero at a
//! maximum. Either it has a root within a sub-step, which [`turns`] finds with the proof used for
//! the simulator's events, or an impact reverses it. A maximum of some duration (w while the block
//! rests at the upper stop) counts once, at its end.
//!
//! Over a sub-step of flight, 16 samples of the rate and a bound on its second derivative exclude
//! most intervals. Only the others are searched, as in the search for impacts.

use crate::flow::{ANCHORED, CENTRED, INTERVALS, RateTable, Series, expand_along, weighted_sum};
use crate::model::{Augmented, BOX, BOX_RATE, Forces, Model, SmoothMode};
use crate::simulator::Simulator;
use crate::simulator::batch::queue::Maximum;
use crate::simulator::batch::vectors::{LaneRow, Wide};
use pulp::Simd;
use vibro_numerics::events::turns;
use vibro_numerics::simd::{product, value, weigh};

/// Follows the sign of a displacement's rate along a motion.
pub(super) struct MaximumFinder {
    /// Weights of x1, w and x3: with x2 = x1 + w, docs/theory.md (5).
    weights: [f64; 3],
    rising: bool,
    table: RateTable,
}

impl MaximumFinder {
    /// Finder for a motion that is about to begin, with the weights of x1, x2 and x3.
    pub(super) fn new(simulator: &Simulator, [a, b, c]: [f64; 3]) -> Self {
        let weights = [a + b, b, c];
        let rising = weighted_sum(&weights, &simulator.augmented(), BOX_RATE) > 0.0;
        let table = rate_table(&simulator.model, &weights, simulator.substep);
        Self { weights, rising, table }
    }

    /// Shows `found` the maxima of a sub-step that begins at `time` and lasts `span` s.
    #[inline(always)]
    pub(super) fn search<S: Simd>(
        &mut self,
        simd: S,
        simulator: &Simulator,
        (mode, z, forces): (SmoothMode, &Augmented, Option<&Forces>),
        (time, span): (f64, f64),
        found: &mut dyn FnMut(Maximum),
    ) {
        match mode {
            SmoothMode::Flight if forces.is_none() => {
                self.search_flight(simd, simulator, z, (time, span), found);
            }
            SmoothMode::Flight | SmoothMode::Rest => {
                if span <= 0.0 {
                    return; // only the law of an impact
                }
                let mut begin = time;
                expand_along(&simulator.model, mode, (z, forces), span, |series, radius| {
                    self.search_series(series, (0.0, 1.0), (begin, radius), found);
                    begin += radius;
                });
            }
        }
    }

    #[inline(always)]
    fn search_flight<S: Simd>(
        &mut self,
        simd: S,
        simulator: &Simulator,
        z: &Augmented,
        (time, span): (f64, f64),
        found: &mut dyn FnMut(Maximum),
    ) {
        if span <= 0.0 {
            return; // only the law of an impact
        }
        let h = simulator.interval();
        // Between the ends of an interval the rate deviates from its chord by at most this margin.
        let margin = 0.125 * h * h * weigh::<S>(z, &self.table.bound);
        let start = weighted_sum(&self.weights, z, BOX_RATE);
        let rates = LaneRow(product(simd, &self.table.sample, z));
        // A sub-step may end a little beyond its last interval.
        let count = ((span / h).ceil() as usize).clamp(1, INTERVALS);
        let last = count - 1;
        let [mut above, mut below] = clear_of_zero(simd, start, &rates, margin);
        if count as f64 * h < span {
            (above, below) = (above & !(1 << last), below & !(1 << last));
        }
        let mut i = 0;
        loop {
            let clear = if self.rising { above } else { below };
            i += (!clear >> i).trailing_zeros() as usize;
            if i >= count {
                break;
            }
            let (before, after) = (if i == 0 { start } else { rates.0[i - 1] }, rates.0[i]);
            // A rate that grows by more than four margins grows on the whole interval, so that it
            // passes zero once. This is a minimum of q, which need not be located if the interval
            // is a whole one.
            if !self.rising && i != last && before < 0.0 && after > 0.0 && after - before > 4.0 * margin {
                self.rising = true;
            } else {
                let end = if i == last { span } else { (i as f64 + 1.0) * h };
                self.search_interval(simulator, z, (i, end), time, found);
            }
            i += 1;
        }
    }

    /// Searches an interval of flight up to the time `end` since the sub-step's start.
    #[inline(never)]
    fn search_interval(
        &mut self,
        simulator: &Simulator,
        z: &Augmented,
        (index, end): (usize, f64),
        time: f64,
        found: &mut dyn FnMut(Maximum),
    ) {
        let model = &simulator.model;
        if index == 0 {
            // The series is about the start: if the block leaves a stop, the maximum of w is
            // exactly at the start.
            let series = Series::<ANCHORED>::expand(model, SmoothMode::Flight, z, None, end);
            return self.search_series(&series, (0.0, 1.0), (time, end), found);
        }
        let half = 0.5 * simulator.interval();
        let centre_time = (2 * index + 1) as f64 * half;
        // The last piece of a sub-step may reach beyond its interval by a tenth.
        let radius = half.max(end - centre_time);
        let (from, to) = (-half / radius, (end - centre_time) / radius);
        let centre = product(pulp::Scalar, &simulator.flight.core.centre[index], z);
        let series = Series::<CENTRED>::expand(model, SmoothMode::Flight, &centre, None, radius);
        self.search_series(&series, (from, to), (time + centre_time, radius), found);
    }

    /// Searches a series between two values of its variable; `time` is the time of its centre.
    #[inline(always)]
    fn search_series<const N: usize>(
        &mut self,
        series: &Series<N>,
        ends: (f64, f64),
        (time, radius): (f64, f64),
        found: &mut dyn FnMut(Maximum),
    ) {
        let rate: [f64; N] =
            std::array::from_fn(|k| weighted_sum(&self.weights, &series.states[k], BOX_RATE));
        let spread: f64 = rate[1..].iter().map(|c| c.abs()).sum();
        let steady = rate[0].abs() > spread && (rate[0] > 0.0) == self.rising;
        if steady {
            return;
        }
        let Self { weights, rising, .. } = self;
        turns(&rate, ends, rising, |u, is_maximum| {
            if is_maximum {
                let q: [f64; N] = std::array::from_fn(|k| weighted_sum(weights, &series.states[k], BOX));
                found(Maximum { time: time + u * radius, value: value(&q, u), corner: false });
            }
        });
    }

    /// Checks an impact for a maximum; `after` is the state after it.
    #[inline(always)]
    pub(super) fn pass_impact(&mut self, after: &Augmented, time: f64, found: &mut dyn FnMut(Maximum)) {
        let rate = weighted_sum(&self.weights, after, BOX_RATE);
        if self.rising && rate < 0.0 {
            found(Maximum { time, value: weighted_sum(&self.weights, after, BOX), corner: true });
        }
        // If the rate is zero after the impact, the later motion decides.
        if rate != 0.0 {
            self.rising = rate > 0.0;
        }
    }
}

/// Bit sets of the intervals of a sub-step, with the first interval in the lowest bit: the first
/// set has a rate above `margin` at both ends, the second a rate below `-margin`.
#[inline(always)]
fn clear_of_zero<S: Simd>(simd: S, start: f64, rates: &LaneRow, margin: f64) -> [u64; 2] {
    let (mut above, mut below) = (u64::from(start > margin), u64::from(-start > margin));
    let margin = Wide::splat(simd, margin);
    for v in 0..LaneRow::vectors::<S>() {
        let rate = Wide::load(simd, rates, v);
        above |= margin.less_than(rate).bits() << (v * S::F64_LANES + 1);
        below |= margin.less_than(-rate).bits() << (v * S::F64_LANES + 1);
    }
    [above & above >> 1, below & below >> 1]
}

/// Table of a displacement's rate, by the best instruction set of this machine.
fn rate_table(model: &Model, weights: &[f64; 3], substep: f64) -> RateTable {
    struct Fill<'a>(&'a Model, &'a [f64; 3], f64);
    impl pulp::WithSimd for Fill<'_> {
        type Output = RateTable;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> RateTable {
            RateTable::new(simd, self.0, self.1, self.2)
        }
    }
    pulp::Arch::new().dispatch(Fill(model, weights, substep))
}
