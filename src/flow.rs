//! Exact propagation of a smooth mode: Taylor series about a point, and tables of the transition
//! matrix over a sub-step (docs/theory.md (8); docs/numerics.md, "Exact flow").
//!
//! # Why tables
//!
//! A smooth mode is linear with constant coefficients, so the state at any later time is a matrix
//! times the present state. These matrices depend on the parameters alone: they are computed once
//! per parameter set, and a sub-step costs a few 8 × 8 products instead of an integration.
//!
//! A sub-step of length H is divided into 16 intervals. A [`SubstepTable`] holds the event
//! functional (w in flight, the free relative acceleration in rest) at the 16 interval ends, the
//! transition matrices to the 16 interval centres and to the sub-step's end, and a bound on the
//! functional's second derivative. All are stored as columns that act on the augmented state.
//!
//! # What must not change without proof
//!
//! - Sub-step length and number of series coefficients depend on each other. The assertions below
//!   bound the remainders at compile time; the derivation is docs/numerics.md,
//!   section 1, and `tests/bounds.rs` compares it with machines chosen to break it.
//! - The order of operations: states are compared bit by bit (`tests/state_bits.rs`). Tables are
//!   bit-identical for all instruction sets, because they are filled without fused operations.
//! - The bound on the second derivative. The proof that no event is missed depends on it:
//!   `invariant_the_bound_holds_between_the_samples` in `tests/bounds.rs`.
//!
//! # Changes
//!
//! - Another entry of the table: a field of [`SubstepTable`], filled in `propagate`. If events are
//!   searched on the entry, `bound_between_centres` gives its bound.
//! - Another time-dependent force: `Forces` and [`LOAD`] for its coefficients, `UnitColumn::rate`
//!   and [`Series::expand`] for its derivatives.

mod polynomial;
mod series;

use crate::model::{
    Augmented, BOX_RATE, COORDINATES, DRIVE_COS, DRIVE_SIN, Forces, Model, RELATIVE, RELATIVE_RATE,
    SECONDARY_RATE, SmoothMode,
};
pub use polynomial::polynomial;
use polynomial::{PLACES, at_interval_ends, at_places};
use pulp::Simd;
pub use series::{ANCHORED, CENTRED, PIECE, Series, WHOLE, expand_along, remainder};
use vibro_numerics::simd::{PADDED, StateRows, product, row};

/// Intervals of a sub-step.
pub const INTERVALS: usize = 16;
/// Length of a sub-step times the fastest rate. At 2.4, most flights between the two impacts of a
/// period take one or two sub-steps; the series about an interval's centre has radius 0.075/rate.
const SUBSTEP_TIMES_RATE: f64 = 2.4;
// Remainders of the series, as in the table of docs/numerics.md, section 1.
const _: () = {
    let interval = SUBSTEP_TIMES_RATE / INTERVALS as f64;
    assert!(remainder(WHOLE, SUBSTEP_TIMES_RATE) < 4e-20);
    assert!(remainder(ANCHORED, interval) < 4e-18 && remainder(CENTRED, 0.5 * interval) < 1.6e-17);
};
/// Number of columns of the augmented state.
pub const CORE: usize = COORDINATES;
/// Number of columns of the loads: 3 forces, each with its value and 3 derivatives.
pub const LOAD: usize = 12;
/// Factor that covers the rounding of the bound itself. The rounding of the samples needs no
/// factor: docs/numerics.md, "Events".
const BOUND_MARGIN: f64 = 1.0 + 1e-9;

/// Interval centres as fractions of the sub-step, in groups that are evaluated side by side.
const CENTRES: [[f64; PLACES]; INTERVALS / PLACES] = {
    let mut places = [[0.0; PLACES]; INTERVALS / PLACES];
    let mut i = 0;
    while i < INTERVALS {
        places[i / PLACES][i % PLACES] = (i as f64 + 0.5) / INTERVALS as f64;
        i += 1;
    }
    places
};

/// Forces and their derivatives a time `dt` later.
#[inline(always)]
pub fn shifted(forces: &Forces, dt: f64) -> Forces {
    forces.map(|d| {
        [
            d[0] + dt * (d[1] + dt * (0.5 * d[2] + dt * d[3] / 6.0)),
            d[1] + dt * (d[2] + dt * 0.5 * d[3]),
            d[2] + dt * d[3],
            d[3],
        ]
    })
}

/// Tables of a sub-step for C columns of the augmented state or of the load coefficients. The
/// order of the fields keeps each vector of a column within one cache line.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct SubstepTable<const C: usize> {
    /// Event functional at the interval ends, `[column][interval]`.
    pub sample: [[f64; INTERVALS]; C],
    /// Augmented state at the sub-step's end, `[column][coordinate]`.
    pub full: [Augmented; C],
    /// Augmented state at the interval centres, `[interval][column][coordinate]`.
    pub centre: [[Augmented; C]; INTERVALS],
    /// |functional''| ≤ Σ_j bound_j |column_j| throughout the sub-step.
    pub bound: [f64; C],
    /// Largest |functional''| at the centres, for each column.
    peak: [f64; C],
}

/// Linear maps from a state in free flight without loads to the coefficients of its [`Series`].
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Local {
    /// Coefficients of the augmented state, `[order][column][coordinate]`.
    states: [[Augmented; CORE]; CENTRED],
    /// Coefficients of w about the interval centres, from the state at the sub-step's start,
    /// `[interval][column][order]`. Orders from [`CENTRED`] on are zero and pad to whole vectors.
    relative: [[[f64; PADDED]; CORE]; INTERVALS],
}

impl Local {
    /// All zero, to be filled.
    pub fn zero() -> Self {
        Self { states: [[[0.0; COORDINATES]; CORE]; CENTRED], relative: [[[0.0; PADDED]; CORE]; INTERVALS] }
    }

    /// Fills the maps; `core` is the table of flight over the same sub-step `h`.
    #[inline(always)]
    pub fn fill(&mut self, core: &SubstepTable<CORE>, model: &Model, h: f64) {
        let radius = 0.5 * h / INTERVALS as f64;
        let mut relative = [[0.0; PADDED]; CORE];
        for (c, orders) in relative.iter_mut().enumerate() {
            let series =
                Series::<CENTRED>::expand(model, SmoothMode::Flight, &UnitColumn::unit(c).z, None, radius);
            for (k, state) in series.states.iter().enumerate() {
                self.states[k][c] = *state;
                orders[k] = state[RELATIVE];
            }
        }
        for (columns, centre) in self.relative.iter_mut().zip(&core.centre) {
            for (column, state) in columns.iter_mut().zip(centre) {
                *column = product(pulp::Scalar, &relative, state);
            }
        }
    }

    /// Coefficients of w about an interval's centre, for the state `z` at the sub-step's start.
    #[inline(always)]
    pub fn relative<S: pulp::Simd>(&self, simd: S, interval: usize, z: &Augmented) -> [f64; PADDED] {
        product(simd, &self.relative[interval], z)
    }

    /// Coefficients of the augmented state about `z`.
    #[inline(always)]
    pub fn states<S: pulp::Simd>(&self, simd: S, z: &Augmented) -> StateRows<S, CENTRED> {
        let [a, b, c, d, e, f, g, h, i, j] = &self.states;
        let of = |columns| row(simd, columns, z);
        [of(a), of(b), of(c), of(d), of(e), of(f), of(g), of(h), of(i), of(j)]
    }
}

/// Table of the rate of a displacement q = a x1 + b w + c x3 over a sub-step of free flight: its
/// samples and the bound between them, as in [`SubstepTable`] for the event functional.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct RateTable {
    /// Rate at the interval ends, `[column][interval]`.
    pub sample: [[f64; INTERVALS]; CORE],
    /// |rate''| ≤ Σ_j bound_j |column_j| throughout the sub-step.
    pub bound: [f64; CORE],
}

impl RateTable {
    /// Table for the weights a, b, c over a sub-step `h`.
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, model: &Model, weights: &[f64; 3], h: f64) -> Self {
        let mut table = Self { sample: [[0.0; INTERVALS]; CORE], bound: [0.0; CORE] };
        for c in 0..CORE {
            let series = Series::<WHOLE>::expand(model, SmoothMode::Flight, &UnitColumn::unit(c).z, None, h);
            let mut rate = [0.0; WHOLE];
            for (value, state) in rate.iter_mut().zip(&series.states) {
                *value = weighted_sum(weights, state, BOX_RATE);
            }
            table.sample[c] = at_interval_ends(simd, &rate);
            for places in &CENTRES {
                for z in at_places(simd, &series.states, places) {
                    let centre = UnitColumn { z, ..UnitColumn::unit(c) };
                    let jerk = centre.rate(model, SmoothMode::Flight).rate(model, SmoothMode::Flight).z;
                    table.bound[c] = table.bound[c].max(weighted_sum(weights, &jerk, BOX_RATE).abs());
                }
            }
        }
        table.bound =
            bound_between_centres(model, SmoothMode::Flight, table.bound, 0.5 * h / INTERVALS as f64);
        table
    }
}

/// `Σ_i weights[i] z[first + i]`: a displacement for `first` = [`BOX`](crate::model::BOX), its
/// rate for `first` = [`BOX_RATE`].
#[inline(always)]
pub fn weighted_sum(weights: &[f64; 3], z: &Augmented, first: usize) -> f64 {
    weights[0] * z[first] + weights[1] * z[first + 1] + weights[2] * z[first + 2]
}

/// Column of the whole system: a unit augmented coordinate or a unit load coefficient, with its
/// derivatives.
#[derive(Clone, Copy)]
pub struct UnitColumn {
    /// Augmented state.
    pub z: Augmented,
    forces: Forces,
}

impl UnitColumn {
    /// Unit augmented coordinate for `index` < [`COORDINATES`], else unit load coefficient.
    #[inline(always)]
    pub fn unit(index: usize) -> Self {
        let mut column = Self { z: [0.0; COORDINATES], forces: [[0.0; 4]; 3] };
        if index < COORDINATES {
            column.z[index] = 1.0;
        } else {
            column.forces[(index - COORDINATES) / 4][(index - COORDINATES) % 4] = 1.0;
        }
        column
    }

    #[inline(always)]
    fn values(&self) -> [f64; 3] {
        [self.forces[0][0], self.forces[1][0], self.forces[2][0]]
    }

    /// Time derivative.
    #[inline(always)]
    fn rate(&self, model: &Model, mode: SmoothMode) -> Self {
        let a = model.acceleration(mode, &self.z, Some(self.values())).coordinates;
        let z = &self.z;
        Self {
            z: [
                z[BOX_RATE],
                z[RELATIVE_RATE],
                z[SECONDARY_RATE],
                a[0],
                a[1],
                a[2],
                -model.omega * z[DRIVE_SIN],
                model.omega * z[DRIVE_COS],
            ],
            forces: self.forces.map(|d| [d[1], d[2], d[3], 0.0]),
        }
    }

    /// Event functional: w in flight, the free relative acceleration in rest.
    #[inline(always)]
    fn functional(&self, model: &Model, mode: SmoothMode) -> f64 {
        match mode {
            SmoothMode::Flight => self.z[RELATIVE],
            SmoothMode::Rest => model.acceleration(mode, &self.z, Some(self.values())).free,
        }
    }

    #[inline(always)]
    fn entry(&self, index: usize) -> f64 {
        if index < COORDINATES {
            self.z[index]
        } else {
            self.forces[(index - COORDINATES) / 4][(index - COORDINATES) % 4]
        }
    }
}

impl<const C: usize> SubstepTable<C> {
    /// All zero, to be filled.
    pub fn zero() -> Self {
        Self {
            sample: [[0.0; INTERVALS]; C],
            full: [[0.0; COORDINATES]; C],
            centre: [[[0.0; COORDINATES]; C]; INTERVALS],
            bound: [0.0; C],
            peak: [0.0; C],
        }
    }

    /// Fills all fields except the bound, for the columns with index `first` and above. `first` is 0
    /// for the augmented state and [`CORE`] for the loads.
    #[inline(always)]
    fn propagate<S: Simd>(&mut self, simd: S, model: &Model, mode: SmoothMode, first: usize, h: f64) {
        self.peak = [0.0; C];
        for c in 0..C {
            let start = UnitColumn::unit(first + c);
            let series =
                Series::<WHOLE>::expand(model, mode, &start.z, (first > 0).then_some(&start.forces), h);
            let mut functional = [0.0; WHOLE];
            for (k, value) in functional.iter_mut().enumerate() {
                *value = match mode {
                    SmoothMode::Flight => series.states[k][RELATIVE],
                    SmoothMode::Rest => series.free[k],
                };
            }
            self.sample[c] = at_interval_ends(simd, &functional);
            for (places, centres) in CENTRES.iter().zip(self.centre.chunks_exact_mut(PLACES)) {
                let states = at_places(simd, &series.states, places);
                for ((mid, z), there) in places.iter().zip(states).zip(centres) {
                    let centre = UnitColumn { z, forces: shifted(&start.forces, mid * h) };
                    let second = centre.rate(model, mode).rate(model, mode).functional(model, mode);
                    self.peak[c] = self.peak[c].max(second.abs());
                    there[c] = centre.z;
                }
            }
            self.full[c] = series.at(1.0);
        }
    }

    /// Adds `table · columns` to `z`.
    #[inline(always)]
    pub fn transit(table: &[Augmented; C], columns: &[f64; C], z: &mut Augmented) {
        for (column, &x) in table.iter().zip(columns) {
            for (zj, cj) in z.iter_mut().zip(column) {
                *zj += cj * x;
            }
        }
    }

    /// Adds the functional at the interval ends to `g`.
    #[inline(always)]
    pub fn samples(&self, columns: &[f64; C], g: &mut [f64; INTERVALS]) {
        for (column, &x) in self.sample.iter().zip(columns) {
            for (gj, cj) in g.iter_mut().zip(column) {
                *gj += cj * x;
            }
        }
    }

    /// Bound on |functional''| over the sub-step.
    #[inline(always)]
    pub fn curvature(&self, columns: &[f64; C]) -> f64 {
        let mut sum = 0.0;
        for (b, x) in self.bound.iter().zip(columns) {
            sum += b * x.abs();
        }
        sum
    }
}

impl SubstepTable<CORE> {
    /// Fills the table of state and drive for `mode` over a sub-step `h`.
    #[inline(always)]
    pub fn fill<S: Simd>(&mut self, simd: S, model: &Model, mode: SmoothMode, h: f64) {
        self.propagate(simd, model, mode, 0, h);
        self.bound = bound_between_centres(model, mode, self.peak, 0.5 * h / INTERVALS as f64);
    }
}

impl SubstepTable<LOAD> {
    /// Fills the table of the load coefficients; `core` is the table of the same mode and
    /// sub-step.
    pub fn fill(&mut self, core: &SubstepTable<CORE>, model: &Model, mode: SmoothMode, h: f64) {
        self.propagate(pulp::Scalar, model, mode, CORE, h);
        let mut peak = [0.0; CORE + LOAD];
        peak[..CORE].copy_from_slice(&core.peak);
        peak[CORE..].copy_from_slice(&self.peak);
        let bound = bound_between_centres(model, mode, peak, 0.5 * h / INTERVALS as f64);
        self.bound.copy_from_slice(&bound[CORE..]);
    }
}

/// Bound on |functional''| over an interval, from `row`, its largest magnitudes at the centres. If
/// M is the system matrix, a row r at a centre becomes r·exp(Mδ) at a distance |δ| ≤ `half`, and
/// |r exp(Mδ)| ≤ |r| exp(|M| half) entry by entry.
#[inline(always)]
fn bound_between_centres<const N: usize>(
    model: &Model,
    mode: SmoothMode,
    row: [f64; N],
    half: f64,
) -> [f64; N] {
    let rates: [UnitColumn; N] = std::array::from_fn(|c| UnitColumn::unit(c).rate(model, mode));
    let (mut sum, mut term) = (row, row);
    for k in 1..12 {
        let mut next = [0.0; N];
        for (n, rate) in next.iter_mut().zip(&rates) {
            for (j, t) in term.iter().enumerate() {
                *n += t * rate.entry(j).abs();
            }
            *n *= half / f64::from(k);
        }
        for (s, n) in sum.iter_mut().zip(&next) {
            *s += n;
        }
        term = next;
    }
    sum.map(|s| s * BOUND_MARGIN)
}

/// Length of a sub-step for a model, s.
pub fn substep(model: &Model) -> f64 {
    SUBSTEP_TIMES_RATE / model.rate
}
