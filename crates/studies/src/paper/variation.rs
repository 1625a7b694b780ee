//! Variations of a motion due to variations of its start: exact transition matrices between
//! events, and the jump at each event.
//!
//! A variation has the coordinates of docs/theory.md (83): centre of mass of box and block, w, x3
//! and their rates, with lengths in L and times in 1/rate, and (δcos θ, δsin θ) = δθ (-sin θ, cos
//! θ) for the phase of the drive (docs/theory.md (82)). In these coordinates an impact changes w
//! and w', and it changes the rate of the centre only through the damper's force. Coming to rest
//! is therefore a projection without cancellation.

mod single;

pub(crate) use self::single::SingleVariation;

use super::smooth_pieces::{PieceEnd, SmoothPiece};
use vibro_impact::flow::{Series, WHOLE, remainder};
use vibro_impact::model::{Augmented, COORDINATES, Model, RELATIVE, RELATIVE_RATE, Saltation, SmoothMode};

/// Number of exponents: six coordinates and the phase of the drive.
pub(crate) const DIMENSION: usize = 7;
/// Matrix by columns, each with the coordinates of an augmented state.
type Matrix = [Augmented; COORDINATES];
/// Orthonormal variations, the most expanding one first.
pub(crate) type Frame = [Augmented; DIMENSION];

/// Distance of neighbouring nodes of the grid, times the model's rate. Any time is at most half of
/// this distance from its nearest node.
const GRID_TIMES_RATE: f64 = 0.16;
/// Number of nodes: flights of up to 10/rate need one product.
const NODES: usize = 64;
/// Terms of the series around a node. The remainder is below 3.4e-15 of the variation's size, in
/// which the drive's phase is weighted by the acceleration that it causes (docs/numerics.md,
/// section 1).
const TERMS: usize = 9;
const _: () = assert!(remainder(TERMS, 0.5 * GRID_TIMES_RATE) < 3.4e-15);

const fn identity() -> Matrix {
    let mut m = [[0.0; COORDINATES]; COORDINATES];
    let mut i = 0;
    while i < COORDINATES {
        m[i][i] = 1.0;
        i += 1;
    }
    m
}

/// The product `a b`.
#[inline(always)]
fn product<const N: usize>(a: &Matrix, b: &[Augmented; N]) -> [Augmented; N] {
    let mut c = [[0.0; COORDINATES]; N];
    for (cj, bj) in c.iter_mut().zip(b) {
        for (ak, &x) in a.iter().zip(bj) {
            for (ci, &ai) in cj.iter_mut().zip(ak) {
                *ci += ai * x;
            }
        }
    }
    c
}

/// Transition matrices of one mode over any time.
#[derive(Clone, Debug)]
pub(crate) struct ModeTransition {
    /// Powers of the generator over their factorials, times the same power of the node distance.
    terms: [Matrix; TERMS],
    nodes: Vec<Matrix>,
    spacing: f64,
}

impl ModeTransition {
    pub(crate) fn new(model: &Model, mode: SmoothMode) -> Self {
        let spacing = GRID_TIMES_RATE / model.rate;
        let (share, speed) = (model.block_share, model.gap * model.rate);
        // Columns of the flow over the spacing as Taylor coefficients, in the coordinates of
        // variations.
        let mut coefficients = [[[0.0; COORDINATES]; COORDINATES]; WHOLE];
        for column in 0..COORDINATES {
            let mut unit = [0.0; COORDINATES];
            unit[column] = 1.0;
            let z = physical(&unit, share, model.gap, speed);
            let series = Series::<WHOLE>::expand(model, mode, &z, None, spacing);
            for (c, state) in coefficients.iter_mut().zip(&series.states) {
                c[column] = varied(state, share, model.gap, speed);
            }
        }
        let mut over = [[0.0; COORDINATES]; COORDINATES];
        for c in coefficients.iter().rev() {
            for (sum, x) in over.iter_mut().flatten().zip(c.iter().flatten()) {
                *sum += x;
            }
        }
        let mut nodes = vec![identity()];
        for i in 1..=NODES {
            let next = product(&over, &nodes[i - 1]);
            nodes.push(next);
        }
        Self { terms: std::array::from_fn(|k| coefficients[k]), nodes, spacing }
    }

    /// Propagates variations over `span` s.
    #[inline(always)]
    pub(crate) fn propagate(&self, frame: &mut Frame, span: f64) {
        let steps = span / self.spacing;
        let mut node = steps.round() as usize;
        let part = steps - node as f64;
        let mut near = self.terms[TERMS - 1];
        for term in self.terms[..TERMS - 1].iter().rev() {
            for (n, t) in near.iter_mut().zip(term) {
                for (ni, ti) in n.iter_mut().zip(t) {
                    *ni = *ni * part + ti;
                }
            }
        }
        while node > NODES {
            *frame = product(&self.nodes[NODES], frame);
            node -= NODES;
        }
        *frame = product(&near, &product(&self.nodes[node], frame));
    }
}

/// A variation in the coordinates of the model (docs/theory.md (83)).
fn physical(v: &Augmented, share: f64, gap: f64, speed: f64) -> Augmented {
    let (x1, rate1) = (v[0] - share * v[RELATIVE], v[3] - share * v[RELATIVE_RATE]);
    [gap * x1, gap * v[1], gap * v[2], speed * rate1, speed * v[4], speed * v[5], v[6], v[7]]
}

/// Converts a variation from the model's coordinates to this module's (docs/theory.md (83)).
fn varied(z: &Augmented, share: f64, gap: f64, speed: f64) -> Augmented {
    let (centre, rate) = (z[0] + share * z[RELATIVE], z[3] + share * z[RELATIVE_RATE]);
    [centre / gap, z[1] / gap, z[2] / gap, rate / speed, z[4] / speed, z[5] / speed, z[6], z[7]]
}

/// Effect of an event on the rank of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rank {
    /// All columns stay independent.
    Kept,
    /// At most this many stay independent.
    Limited(usize),
}

/// Transition matrices of both modes and the jumps at events.
#[derive(Clone, Debug)]
pub(crate) struct Variation {
    model: Model,
    flight: ModeTransition,
    rest: Option<Box<ModeTransition>>,
}

impl Variation {
    pub(crate) fn new(model: &Model) -> Self {
        Self { model: *model, flight: ModeTransition::new(model, SmoothMode::Flight), rest: None }
    }

    /// Propagates a frame along a piece and through the event at its end, by the best available
    /// instruction set. No operation is fused, so that all instruction sets give the same bits.
    pub(crate) fn propagate(&mut self, frame: &mut Frame, piece: &SmoothPiece) -> Rank {
        let model = &self.model;
        let transition = match piece.mode {
            SmoothMode::Flight => &self.flight,
            SmoothMode::Rest => {
                self.rest.get_or_insert_with(|| Box::new(ModeTransition::new(model, SmoothMode::Rest)))
            }
        };
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || transition.propagate(frame, piece.span),
        );
        // At a release the fields of rest and flight agree, since the contact force is zero: there
        // is no jump.
        let PieceEnd::Impact { rate, after, rests, .. } = &piece.end else { return Rank::Kept };
        let jump = saltation(&self.model, *rate, after);
        for v in frame.iter_mut() {
            jump.apply(v);
        }
        if *rests {
            frame.iter_mut().for_each(|v| Saltation::merge(&self.model, v, self.model.rate));
            return Rank::Limited(DIMENSION - 2);
        }
        if self.model.restitution == 0.0 { Rank::Limited(DIMENSION - 1) } else { Rank::Kept }
    }
}

/// The jump of variations at an impact with w' = `rate` before it, in the units of this module.
#[inline]
fn saltation(model: &Model, rate: f64, after: &Augmented) -> Saltation {
    Saltation::new(model, rate, after, model.constant_loads, model.rate)
}

/// Projects the phase's variation onto the tangent of the circle of (cos θ, sin θ), docs/theory.md
/// (82). A rounding error normal to the circle does not belong to a motion, and the flow would not
/// damp it.
#[inline(always)]
pub(crate) fn on_circle(frame: &mut Frame, (cosine, sine): (f64, f64)) {
    for v in frame.iter_mut() {
        let turn = cosine * v[7] - sine * v[6];
        (v[6], v[7]) = (-sine * turn, cosine * turn);
    }
}

/// Gram–Schmidt: makes each column orthogonal to the columns before it, and repeats this if the
/// first pass removed most of the column. Returns the lengths before scaling. A column that
/// vanishes or is past `rank` becomes zero with length zero.
#[inline(always)]
pub(crate) fn orthonormalize(frame: &mut Frame, rank: usize) -> [f64; DIMENSION] {
    let mut lengths = [0.0; DIMENSION];
    for (j, into) in lengths.iter_mut().enumerate() {
        let (done, rest) = frame.split_at_mut(j);
        let v = &mut rest[0];
        if j >= rank {
            *v = [0.0; COORDINATES];
            continue;
        }
        let mut length = dot(v, v).sqrt();
        for _ in 0..2 {
            for q in done.iter() {
                let along = dot(q, v);
                for (x, qx) in v.iter_mut().zip(q) {
                    *x -= along * qx;
                }
            }
            let left = dot(v, v).sqrt();
            let enough = left > 0.5 * length;
            length = left;
            if enough {
                break;
            }
        }
        *into = length;
        let scale = if length > 0.0 { 1.0 / length } else { 0.0 };
        for x in v.iter_mut() {
            *x *= scale;
        }
    }
    lengths
}

#[inline(always)]
fn dot(a: &Augmented, b: &Augmented) -> f64 {
    let four: [f64; 4] = std::array::from_fn(|i| a[i] * b[i] + a[i + 4] * b[i + 4]);
    (four[0] + four[2]) + (four[1] + four[3])
}

/// An orthonormal frame in general position. Coming to rest makes no more directions zero than
/// necessary. If bodies do not act on each other, as in flight, the first columns have components
/// along every body.
pub(crate) fn generic_frame(z: &Augmented) -> Frame {
    // The first column: a unit variation, reflected along a direction that is not a coordinate
    // axis.
    const FIRST: [f64; DIMENSION] = [0.815, -0.280, 0.137, -0.244, -0.221, 0.173, -0.316];
    let unit = unit_frame(z);
    let mut frame = [[0.0; COORDINATES]; DIMENSION];
    for (j, v) in frame.iter_mut().enumerate() {
        for (i, own) in unit.iter().enumerate() {
            // The remainders are irregular along rows and along columns.
            let k = DIMENSION * j + i + 1;
            let part = (k * k * k * 31 + k * k * 17) % 101;
            let part = if j == 0 { FIRST[i] } else { part as f64 / 50.0 - 1.0 };
            for (x, u) in v.iter_mut().zip(own) {
                *x += part * u;
            }
        }
    }
    orthonormalize(&mut frame, DIMENSION);
    frame
}

/// The frame of unit variations at a phase of the drive.
pub(crate) fn unit_frame(z: &Augmented) -> Frame {
    let mut frame = [[0.0; COORDINATES]; DIMENSION];
    for (i, v) in frame.iter_mut().enumerate().take(DIMENSION - 1) {
        v[i] = 1.0;
    }
    (frame[DIMENSION - 1][6], frame[DIMENSION - 1][7]) = (-z[7], z[6]);
    frame
}
