//! A single variation without a component in the drive's phase, from event to event.
//!
//! Its growth is needed to only a few digits, so it is cheaper than the frames of `variation`: six
//! columns, shorter series, fewer nodes. The memory is reused for one machine after another.

use super::{GRID_TIMES_RATE, physical, saltation, varied};
use vibro_impact::flow::{Series, remainder};
use vibro_impact::model::{Augmented, COORDINATES, Model, Saltation, SmoothMode};

/// Number of coordinates without the coordinates of the drive.
const COLUMNS: usize = 6;
/// Terms of the series from one node to the next. The remainder is below 3.1e-14 of the
/// variation's size (docs/numerics.md, section 1).
const STEP: usize = 10;
const _: () = assert!(remainder(STEP, GRID_TIMES_RATE) < 3.1e-14);
/// Terms of the series around a node. Without the drive's phase a coefficient of order k is at
/// most (3 + k/2) (rT)ᵏ/k! of the variation's size (docs/numerics.md, section 1). The remainder is
/// below 5 · 0.08⁴/4! (1 + 0.02) < 9e-6, negligible relative to the growth between events.
const TERMS: usize = 4;
/// Index of the last node (there are NODES + 1): flights of up to 5/rate need one product.
const NODES: usize = 32;

/// A matrix by columns.
type Columns = [Augmented; COLUMNS];

/// Product of a matrix and a variation. Even and odd columns are summed independently.
#[inline(always)]
fn transit(a: &Columns, v: &Augmented) -> Augmented {
    let mut sums = [[0.0; COORDINATES]; 2];
    for (k, (column, &x)) in a.iter().zip(v).enumerate() {
        for (sum, &c) in sums[k % 2].iter_mut().zip(column) {
            *sum += c * x;
        }
    }
    let [mut even, odd] = sums;
    for (even, odd) in even.iter_mut().zip(odd) {
        *even += odd;
    }
    even
}

/// Transition matrices of one mode over any time.
#[derive(Clone, Debug)]
#[repr(C, align(64))] // so that a column is one cache line
struct SingleTransition {
    /// (generator · node distance)ᵏ / k!, for k = 0, 1, …
    terms: [Columns; TERMS],
    nodes: [Columns; NODES + 1],
    /// Reciprocal of the node distance, 1/s.
    per_spacing: f64,
}

impl SingleTransition {
    const ZERO: Self = Self {
        terms: [[[0.0; COORDINATES]; COLUMNS]; TERMS],
        nodes: [[[0.0; COORDINATES]; COLUMNS]; NODES + 1],
        per_spacing: 0.0,
    };

    #[inline(always)]
    fn fill(&mut self, model: &Model, mode: SmoothMode) {
        let spacing = GRID_TIMES_RATE / model.rate;
        self.per_spacing = 1.0 / spacing;
        let (share, speed) = (model.block_share, model.gap * model.rate);
        let mut step = [[0.0; COORDINATES]; COLUMNS];
        for column in 0..COLUMNS {
            let mut unit = [0.0; COORDINATES];
            unit[column] = 1.0;
            let z = physical(&unit, share, model.gap, speed);
            let series = Series::<STEP>::expand(model, mode, &z, None, spacing);
            let mut sum = [0.0; COORDINATES];
            for (k, state) in series.states.iter().enumerate().rev() {
                let term = varied(state, share, model.gap, speed);
                if let Some(kept) = self.terms.get_mut(k) {
                    kept[column] = term;
                }
                for (sum, x) in sum.iter_mut().zip(term) {
                    *sum += x;
                }
            }
            step[column] = sum;
            self.nodes[0][column] = unit;
        }
        for i in 1..=NODES {
            for column in 0..COLUMNS {
                self.nodes[i][column] = transit(&step, &self.nodes[i - 1][column]);
            }
        }
    }

    /// Propagates a variation over `span` s. The matrices commute, so the products of the series
    /// with the variation depend neither on each other nor on the node.
    #[inline(always)]
    fn propagate(&self, v: &mut Augmented, span: f64) {
        let steps = span * self.per_spacing;
        let mut node = (steps + 0.5) as u32 as usize;
        let part = steps - node as f64;
        let (mut power, mut sum) = (1.0, *v);
        for term in &self.terms[1..] {
            power *= part;
            for (x, y) in sum.iter_mut().zip(transit(term, v)) {
                *x += power * y;
            }
        }
        while node > NODES {
            sum = transit(&self.nodes[NODES], &sum);
            node -= NODES;
        }
        *v = transit(&self.nodes[node], &sum);
    }
}

/// Operation of a [`SingleVariation`], compiled for each instruction set. No operation is fused,
/// so that all instruction sets give the same bits.
enum VariationOperation<'a> {
    Fill(&'a mut SingleTransition, &'a Model, SmoothMode),
    Propagate(&'a SingleTransition, &'a mut Augmented, f64),
}

impl pulp::WithSimd for VariationOperation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        match self {
            Self::Fill(transition, model, mode) => transition.fill(model, mode),
            Self::Propagate(transition, v, span) => transition.propagate(v, span),
        }
    }
}

/// Transition matrices of both modes and the jumps at events.
#[derive(Clone, Debug)]
pub(crate) struct SingleVariation {
    model: Model,
    /// Transition matrices of flight and of rest, and whether they belong to the model.
    transitions: [Box<SingleTransition>; 2],
    ready: [bool; 2],
}

impl SingleVariation {
    pub(crate) fn new(model: &Model) -> Self {
        let transitions = [Box::new(SingleTransition::ZERO), Box::new(SingleTransition::ZERO)];
        Self { model: *model, transitions, ready: [false; 2] }
    }

    /// Changes to another machine.
    pub(crate) fn renew(&mut self, model: &Model) {
        (self.model, self.ready) = (*model, [false; 2]);
    }

    /// Fastest rate of the machine, 1/s.
    pub(crate) fn rate(&self) -> f64 {
        self.model.rate
    }

    /// Propagates a variation for `span` s in one mode and, if this ends with an impact, through
    /// its jump. The impact is given by w' before it and the state after it.
    pub(crate) fn propagate(
        &mut self,
        v: &mut Augmented,
        (mode, span): (SmoothMode, f64),
        impact: Option<(f64, &Augmented)>,
    ) {
        let index = usize::from(mode == SmoothMode::Rest);
        let transition = &mut *self.transitions[index];
        if !self.ready[index] {
            pulp::Arch::new().dispatch(VariationOperation::Fill(transition, &self.model, mode));
            self.ready[index] = true;
        }
        pulp::Arch::new().dispatch(VariationOperation::Propagate(transition, v, span));
        if let Some((rate, after)) = impact {
            saltation(&self.model, rate, after).apply(v);
        }
    }

    /// Carries a variation through the merge into rest after an impact.
    pub(crate) fn merge(&self, v: &mut Augmented) {
        Saltation::merge(&self.model, v, self.model.rate);
    }
}
