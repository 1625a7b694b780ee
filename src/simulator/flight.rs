//! Sub-steps of free flight without loads, which make up most of a motion's time.

use super::Simulator;
use super::points::{SeriesPoint, SubstepStart};
use crate::flow::{ANCHORED, INTERVALS, Series};
use crate::model::{Augmented, RELATIVE, SmoothMode};
use pulp::Simd;
use vibro_numerics::double_double::DoubleDouble;
use vibro_numerics::events::flight_crossing;
use vibro_numerics::simd::{at_least, excess_over, polynomial, product};

/// Samples of w over a sub-step, and the intervals that they leave to be searched.
pub(super) struct DisplacementSamples {
    /// w at the interval ends.
    w: [f64; INTERVALS],
    /// Limit on |w|, m. Between two samples below it no stop is reached.
    limit: f64,
    /// Whether the first interval must be searched.
    pub(super) first: bool,
    /// Bit set of the other intervals that must be searched.
    pub(super) search: u64,
}

/// Impact found in interval `index` at `u`, at the stop `side`.
pub(super) struct LocatedImpact {
    pub(super) index: usize,
    pub(super) u: f64,
    pub(super) side: f64,
}

impl Simulator {
    /// A sub-step of free flight. 16 samples of w and the `bound` on |w''| select the intervals
    /// whose block may reach a stop; only these are searched. Moves to the first impact and
    /// returns its stop, or passes over the sub-step.
    #[inline(always)]
    pub(super) fn flight_substep<S: Simd, const ACCOUNTS: bool>(
        &mut self,
        simd: S,
        z: &mut Augmented,
        bound: f64,
        remaining: f64,
        end: DoubleDouble,
    ) -> Option<f64> {
        let interval = self.interval();
        let samples = self.sample_displacement(simd, z, bound);
        if samples.first {
            let found = self.first_interval(*z, bound, interval.min(remaining));
            if let Some((arrived, side)) = found {
                *z = arrived;
                return Some(side);
            }
        }
        let whole = remaining >= self.substep;
        let mut search = samples.search;
        while search != 0 {
            let index = search.trailing_zeros() as usize;
            search &= search - 1;
            if !whole && index as f64 * interval >= remaining {
                break;
            }
            if let Some(aim) = self.locate_impact(simd, z, &samples, index, remaining) {
                *z = self.move_to_impact::<S, ACCOUNTS>(simd, z, &aim);
                return Some(aim.side);
            }
        }
        if whole {
            self.advance_whole_substep(z, &SubstepStart::<0> { z: *z, forces: [], bound });
        } else {
            let index = ((remaining / interval) as usize).min(INTERVALS - 1);
            let u = (remaining - (index as f64 + 0.5) * interval) / (0.5 * interval);
            *z = self.state_in_interval::<S, ACCOUNTS>(simd, z, index, u);
            self.hybrid.time = end;
        }
        None
    }

    /// A step within one interval. It is taken if the block is farther from the stops at both ends
    /// than its acceleration, at most `bound`, can bend its path between them. Otherwise returns
    /// false and changes nothing, and the interval must be searched. Not inlined, because the long
    /// sub-steps use all registers.
    #[inline(never)]
    pub(super) fn short_flight_substep<S: Simd, const ACCOUNTS: bool>(
        &mut self,
        simd: S,
        z: &mut Augmented,
        bound: f64,
        remaining: f64,
        end: DoubleDouble,
    ) -> bool {
        struct ShortFlight<'a, const ACCOUNTS: bool>(
            &'a mut Simulator,
            &'a mut Augmented,
            f64,
            f64,
            DoubleDouble,
        );
        impl<const ACCOUNTS: bool> pulp::WithSimd for ShortFlight<'_, ACCOUNTS> {
            type Output = bool;

            #[inline(always)]
            fn with_simd<S: Simd>(self, simd: S) -> bool {
                let Self(simulator, z, bound, remaining, end) = self;
                simulator.short_flight_substep_vectorized::<S, ACCOUNTS>(simd, z, bound, remaining, end)
            }
        }
        simd.vectorize(ShortFlight::<ACCOUNTS>(self, z, bound, remaining, end))
    }

    #[inline(always)]
    fn short_flight_substep_vectorized<S: Simd, const ACCOUNTS: bool>(
        &mut self,
        simd: S,
        z: &mut Augmented,
        bound: f64,
        remaining: f64,
        end: DoubleDouble,
    ) -> bool {
        let limit = self.model.gap - bound * remaining * remaining * 0.125;
        if !self.clears_first_interval(z, bound, limit) {
            return false;
        }
        self.work.expansions += 1;
        // If the series about the start reaches to the end, it is used, because it has the
        // smallest rounding for the shortest steps.
        let radius = 0.5 * self.interval();
        let centred = remaining > radius;
        let centre = if centred { product(simd, &self.flight.core.centre[0], z) } else { *z };
        let rows = self.flight.local.states(simd, &centre);
        let u = if centred { remaining - radius } else { remaining } / radius;
        let arrived = polynomial(simd, &rows, u);
        if arrived[RELATIVE].abs() >= limit {
            return false;
        }
        if ACCOUNTS {
            self.account_flight(simd, z, centred.then_some(0), &rows, (u, &arrived));
        }
        *z = arrived;
        self.hybrid.time = end;
        self.hybrid.departing = 0;
        true
    }

    /// Samples w at the interval ends of a sub-step.
    #[inline(always)]
    pub(super) fn sample_displacement<S: Simd>(
        &self,
        simd: S,
        z: &Augmented,
        bound: f64,
    ) -> DisplacementSamples {
        let interval = self.interval();
        let w = product(simd, &self.flight.core.sample, z);
        // Between the ends of an interval of length h, w deviates from its chord by at most bound
        // h²/8.
        let limit = self.model.gap - bound * interval * interval * 0.125;
        let near = at_least(simd, &w, limit);
        let clear = self.clears_first_interval(z, bound, limit);
        // An interval is searched when one of its ends is near.
        let search = (near | near << 1) & ((1 << INTERVALS) - 2);
        DisplacementSamples { w, limit, first: !clear || near & 1 != 0, search }
    }

    /// First impact in interval `index`, not the first interval, within `remaining` s of the
    /// sub-step's start.
    #[inline(always)]
    pub(super) fn locate_impact<S: Simd>(
        &mut self,
        simd: S,
        z: &Augmented,
        samples: &DisplacementSamples,
        index: usize,
        remaining: f64,
    ) -> Option<LocatedImpact> {
        let interval = self.interval();
        self.work.expansions += 1;
        let w = self.flight.local.relative(simd, index, z);
        let mut hi = 1.0;
        if remaining < self.substep {
            hi = ((remaining - (index as f64 + 0.5) * interval) / (0.5 * interval)).min(1.0);
        }
        let ends = [samples.w[index - 1], samples.w[index]];
        let (most, least) = (ends[0].max(ends[1]), ends[0].min(ends[1]));
        // The stop is selected without a branch, which the processor could not predict in chaotic
        // motion.
        let mut side = if most >= -least { 1.0 } else { -1.0 };
        let mut found = None;
        loop {
            let p = excess_over(simd, &w, side, self.model.gap);
            if let Some(u) = flight_crossing(simd, &p, -1.0, hi, &mut self.work.iterations) {
                found = Some(LocatedImpact { index, u, side });
                hi = u;
            }
            let both = most >= samples.limit && -least >= samples.limit;
            if !both || side != (if most >= -least { 1.0 } else { -1.0 }) {
                return found;
            }
            side = -side;
        }
    }

    /// Moves to a located impact: state, energy accounts and time.
    #[inline(always)]
    pub(super) fn move_to_impact<S: Simd, const ACCOUNTS: bool>(
        &mut self,
        simd: S,
        z: &Augmented,
        aim: &LocatedImpact,
    ) -> Augmented {
        let interval = self.interval();
        let base = (aim.index as f64 + 0.5) * interval;
        let arrived = self.state_in_interval::<S, ACCOUNTS>(simd, z, aim.index, aim.u);
        self.hybrid.time = self.hybrid.time.plus(base).plus(aim.u * (0.5 * interval));
        arrived
    }

    /// State at `u` of interval `index`; updates the energy accounts, but not the time.
    #[inline(always)]
    fn state_in_interval<S: Simd, const ACCOUNTS: bool>(
        &mut self,
        simd: S,
        z: &Augmented,
        index: usize,
        u: f64,
    ) -> Augmented {
        let centre = product(simd, &self.flight.core.centre[index], z);
        let rows = self.flight.local.states(simd, &centre);
        // The state before the accounts: the next sub-step waits only for the state.
        let arrived = polynomial(simd, &rows, u);
        if ACCOUNTS {
            self.account_flight(simd, z, Some(index), &rows, (u, &arrived));
        }
        self.hybrid.departing = 0;
        arrived
    }

    /// First event in the first interval, at whose start the block may be leaving a stop. Returns
    /// the state at the event and the stop.
    #[cold]
    fn first_interval(&mut self, mut z: Augmented, bound: f64, span: f64) -> Option<(Augmented, f64)> {
        self.work.expansions += 1;
        let start = SubstepStart::<0> { z, forces: [], bound };
        let series = Series::<ANCHORED>::expand(&self.model, SmoothMode::Flight, &z, None, span);
        let (u, side) = self.first_event_from_start(&series, &start, [true; 2], span)?;
        let arrival = SeriesPoint { series: &series, base: 0.0, radius: span, u, interval: None };
        self.advance_to_point(&mut z, &start, &arrival);
        Some((z, side))
    }
}
