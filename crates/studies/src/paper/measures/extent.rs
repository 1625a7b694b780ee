//! Extrema and mean square of a coordinate along the series of the flow.

use super::Coordinate;
use vibro_impact::flow::{PIECE, Series, weighted_sum};
use vibro_numerics::events::turns;
use vibro_numerics::simd::value;

/// Gauss–Legendre nodes and weights on [0, 1].
///
/// Along a series, whose time times the model's rate r is at most 1.2, the derivative of order k
/// of a displacement is at most rᵏ max(3 + k/2, k + 1) times the motion's size S
/// (docs/numerics.md, section 1), and r times as much for a rate. The sixteenth derivative of the
/// square is therefore at most 78 (2r)¹⁶ S², and the rule's error is below 78 (8!)⁴ 2.4¹⁶/(17
/// (16!)³) < 2e-15 of S² times the length.
const NODES: [(f64, f64); 8] = [
    (0.019_855_071_751_231_912, 0.050_614_268_145_188_53),
    (0.101_666_761_293_186_64, 0.111_190_517_226_687_23),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_55),
    (0.408_282_678_752_175_1, 0.181_341_891_689_180_83),
    (0.591_717_321_247_825, 0.181_341_891_689_180_83),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_55),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_23),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_53),
];

/// Extrema of a coordinate so far, and the integral of its square.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub coordinate: Coordinate,
    least: f64,
    largest: f64,
    /// Whether squares are integrated.
    squares: bool,
    /// ∫ q² dt, m² s or m²/s.
    pub square: f64,
}

impl Extent {
    pub const fn new(coordinate: Coordinate, squares: bool) -> Self {
        Self { coordinate, least: f64::INFINITY, largest: f64::NEG_INFINITY, squares, square: 0.0 }
    }

    /// Range of the values, clipped to ± a bound that only rounding can exceed.
    pub fn within(&self, bound: f64) -> (f64, f64) {
        (self.least.max(-bound), self.largest.min(bound))
    }

    /// Joins the extent of another stretch of the motion.
    pub fn join(&mut self, other: &Self) {
        self.least = self.least.min(other.least);
        self.largest = self.largest.max(other.largest);
        self.square += other.square;
    }

    #[inline(always)]
    fn meet(&mut self, value: f64) {
        self.least = self.least.min(value);
        self.largest = self.largest.max(value);
    }

    /// Includes a series of the flow, with its variable in [0, 1], over `radius` s.
    #[inline(always)]
    pub fn take(&mut self, series: &Series<PIECE>, radius: f64) {
        let (weights, first) = self.coordinate.weights();
        let q: [f64; PIECE] = std::array::from_fn(|k| weighted_sum(&weights, &series.states[k], first));
        if self.squares {
            let square = |u: f64| value(&q, u).powi(2);
            self.square += radius * NODES.iter().map(|(u, weight)| weight * square(*u)).sum::<f64>();
        }
        self.meet(q[0]);
        self.meet(value(&q, 1.0));
        let spread: f64 = q[1..].iter().map(|c| c.abs()).sum();
        // Between the ends the coordinate cannot exceed the extrema found so far.
        if q[0] + spread <= self.largest && q[0] - spread >= self.least {
            return;
        }
        let slope: [f64; PIECE] =
            std::array::from_fn(|k| if k + 1 < PIECE { (k + 1) as f64 * q[k + 1] } else { 0.0 });
        turns(&slope, (0.0, 1.0), &mut (slope[0] > 0.0), |u, _| self.meet(value(&q, u)));
    }
}
