//! Free flights about the centre of an interval, one in each lane: their series, the first passage
//! of a stop with its proof, and the state at the passage.

use super::rows::LaneSystems;
use crate::flow::{CENTRED, remainder};
use crate::model::{BOX, BOX_RATE, DRIVE_COS, DRIVE_SIN, RELATIVE, RELATIVE_RATE, SECONDARY, SECONDARY_RATE};
use crate::simulator::batch::vectors::{LaneRow, Mask, Wide};
use pulp::Simd;

/// 1/k!.
const FACTORIALS: [f64; CENTRED] = {
    let mut r = [1.0; CENTRED];
    let mut k = 2;
    while k < CENTRED {
        r[k] = r[k - 1] / k as f64;
        k += 1;
    }
    r
};
/// Radius about its centre within which a series is used, in half intervals. It reaches a tenth of
/// an interval beyond the interval's end. The remainder there, 0.09¹⁰/9!, is still under the
/// rounding of a double (docs/numerics.md, section 1). A block that is just short of the stop at
/// the interval's end can thus be followed into the next interval.
pub(super) const REACH: f64 = 6.0 / 5.0;
const _: () = assert!(remainder(CENTRED, 0.075 * REACH) < 9.8e-17);
/// Limit for the first iterate of a search, in half intervals. Up to this limit the bounds within
/// [`REACH`] are still strong enough (docs/numerics.md, section 7).
const BEYOND: f64 = 5.0 / 4.0;
/// REACH^k.
const POWERS: [f64; CENTRED] = {
    let mut r = [1.0; CENTRED];
    let mut k = 1;
    while k < CENTRED {
        r[k] = r[k - 1] * REACH;
        k += 1;
    }
    r
};
/// Bound on the error of a root, in half intervals, up to which the root counts as found: the
/// rounding of 1.
const RESOLUTION: f64 = 0.5 * f64::EPSILON;

/// Derivatives of the motions at their centres, with half an interval as unit of time.
pub(super) struct CentredFlights<S: Simd> {
    /// x1, w, x3.
    positions: [Wide<S>; 3],
    /// Derivatives of the rates of x1, w, x3, `[order][coordinate]`.
    rates: [[Wide<S>; 3]; CENTRED],
    /// cos θ and sin θ.
    cos: Wide<S>,
    sin: Wide<S>,
}

impl<S: Simd> CentredFlights<S> {
    /// Derivatives order by order from the equations of motion, docs/theory.md (6) and (8). This
    /// is `Series::expand` for vectors of systems; `second_method_flights_are_the_series` compares
    /// the two.
    #[inline(always)]
    pub(super) fn expand(simd: S, systems: &LaneSystems, v: usize, z: &[Wide<S>; 8]) -> Self {
        let load = |row: &LaneRow| Wide::load(simd, row, v);
        let (k1, c1, k2) = (load(&systems.k1), load(&systems.c1), load(&systems.k2));
        let (k3, c3, k32) = (load(&systems.k3), load(&systems.c3), load(&systems.k32));
        let (drive, omega, radius) = (load(&systems.drive), load(&systems.omega), load(&systems.radius));
        let positions = [z[BOX], z[RELATIVE], z[SECONDARY]];
        let mut rates =
            [[z[BOX_RATE] * radius, z[RELATIVE_RATE] * radius, z[SECONDARY_RATE] * radius]; CENTRED];
        // Derivatives of the drive's force, even and odd orders: each is -ω² times the one two
        // orders below.
        let square = -(omega * omega);
        let mut push = [drive * z[DRIVE_SIN], drive * omega * z[DRIVE_COS]];
        let mut x = positions;
        for k in 0..CENTRED - 1 {
            let v = rates[k];
            let stretch = (x[BOX] - x[SECONDARY]) + x[RELATIVE];
            let back = k1.mul_add(x[BOX], c1.mul_add(v[BOX], -push[k % 2])); // minus the derivative of x1''
            rates[k + 1] = [
                -back,
                k2.neg_mul_add(stretch, back),
                k32.mul_add(stretch, -k3.mul_add(x[SECONDARY], c3 * v[SECONDARY])),
            ];
            push[k % 2] = push[k % 2] * square;
            x = v;
        }
        Self { positions, rates, cos: z[DRIVE_COS], sin: z[DRIVE_SIN] }
    }

    /// Polynomials side·w - L: the excess of the block past the stop `side`, negative inside.
    #[inline(always)]
    pub(super) fn excess(&self, side: Wide<S>, gap: Wide<S>) -> Excess<S> {
        let zero = side.uniform(0.0);
        let mut excess = Excess { c: [zero; CENTRED], d: [zero; CENTRED - 1] };
        excess.c[0] = side * self.positions[RELATIVE] - gap;
        for k in 1..CENTRED {
            let derivative = side * self.rates[k - 1][RELATIVE];
            excess.c[k] = derivative * side.uniform(FACTORIALS[k]);
            excess.d[k - 1] = derivative * side.uniform(FACTORIALS[k - 1]);
        }
        excess
    }

    /// State at u, the time since the centre in half intervals.
    #[inline(always)]
    pub(super) fn state_at(&self, systems: &LaneSystems, simd: S, v: usize, u: Wide<S>) -> [Wide<S>; 8] {
        let zero = u.uniform(0.0);
        let mut rate = self.rates[CENTRED - 1];
        let mut displacement = self.rates[CENTRED - 2];
        for k in (1..CENTRED).rev() {
            let part = u * u.uniform(1.0 / k as f64);
            for (rate, order) in rate.iter_mut().zip(self.rates[k - 1]) {
                *rate = rate.mul_add(part, order);
            }
            if k < CENTRED - 1 {
                // Order k + 1 of the displacement has the factor u/(k + 1).
                let part = u * u.uniform(1.0 / (k + 1) as f64);
                for (displacement, order) in displacement.iter_mut().zip(self.rates[k - 1]) {
                    *displacement = displacement.mul_add(part, order);
                }
            }
        }
        let per = u.uniform(1.0) / Wide::load(simd, &systems.radius, v);
        let mut z = [zero; 8];
        for j in 0..3 {
            z[j] = displacement[j].mul_add(u, self.positions[j]);
            z[j + 3] = rate[j] * per;
        }
        let angle = u * Wide::load(simd, &systems.omega, v);
        let square = angle * angle;
        let (mut cos, mut sin) = (zero, zero);
        for k in (0..CENTRED / 2).rev() {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            cos = cos.mul_add(square, u.uniform(sign * FACTORIALS[2 * k]));
            sin = sin.mul_add(square, u.uniform(sign * FACTORIALS[2 * k + 1]));
        }
        let sin = sin * angle;
        z[DRIVE_COS] = sin.neg_mul_add(self.sin, cos * self.cos);
        z[DRIVE_SIN] = sin.mul_add(self.cos, cos * self.sin);
        z
    }
}

/// Polynomials p(u) = side·w - L.
pub(super) struct Excess<S: Simd> {
    /// Coefficients of p, lowest order first.
    c: [Wide<S>; CENTRED],
    /// Coefficients of p'.
    d: [Wide<S>; CENTRED - 1],
}

/// Upward zeros of the polynomials.
pub(super) struct Crossing<S: Simd> {
    pub(super) u: Wide<S>,
    /// Lanes with a proof that u is the first zero.
    pub(super) found: Mask<S>,
    /// Numbers of Newton steps.
    pub(super) iterations: Wide<S>,
}

impl<S: Simd> Excess<S> {
    /// Divides the polynomials `chosen` by u: each starts at a stop, and its zero at the start is
    /// not a return.
    #[inline(always)]
    pub(super) fn divide_by_u(&mut self, chosen: Mask<S>) {
        let zero = self.c[0].uniform(0.0);
        for k in 0..CENTRED {
            let next = if k + 1 < CENTRED { self.c[k + 1] } else { zero };
            self.c[k] = chosen.select(next, self.c[k]);
            if k > 0 {
                let slope = self.c[k] * zero.uniform(k as f64);
                self.d[k - 1] = chosen.select(slope, self.d[k - 1]);
            }
        }
    }

    /// Lanes with a proof that the polynomials stay below zero and above -2 `gap` from `from` to
    /// [`REACH`], so that the block meets neither stop.
    ///
    /// Two proofs are tried. First, the parabola of the first three orders is largest at an end or
    /// at its vertex, and the sizes of the other terms bound their sum. Second, for `from` = 0,
    /// omitting the negative terms of order two and more gives an upper bound of the polynomial.
    /// This bound is convex, so it suffices that it is negative at both ends.
    #[inline(always)]
    pub(super) fn stays_negative(&self, from: Wide<S>, gap: Wide<S>) -> Mask<S> {
        let c = &self.c;
        let splat = |x| from.uniform(x);
        let (zero, reach) = (splat(0.0), splat(REACH));
        let (mut rest, mut rise) = (zero, zero);
        for k in (3..CENTRED).rev() {
            rest = c[k].abs().mul_add(splat(POWERS[k]), rest);
            rise = c[k].max(zero).mul_add(splat(POWERS[k]), rise);
        }
        let parabola = |u: Wide<S>| u.mul_add(u.mul_add(c[2], c[1]), c[0]);
        let ends = parabola(from).max(parabola(reach));
        let top = -(c[1] / (c[2] + c[2]));
        let inside = c[2].less_than(zero) & from.less_than(top) & top.less_than(reach);
        let most = inside.select(ends.max(parabola(top)), ends);
        let low = (most + rest).less_than(zero);
        let end = c[1].mul_add(reach, c[2].max(zero).mul_add(splat(POWERS[2]), rise));
        let convex = zero.at_most(from) & c[0].less_than(zero) & (c[0] + end).less_than(zero);
        let path = c[0].abs() + c[1].abs().mul_add(reach, c[2].abs().mul_add(splat(POWERS[2]), rest));
        (low | convex) & path.less_than(gap)
    }

    /// First zero in (`from`, [`REACH`]), proved as in
    /// [`vibro_numerics::events::flight_crossing`], its counterpart for one motion. It is found
    /// only for a path that rises and is nearly straight.
    /// `second_method_crossings_and_their_absence` compares the two.
    #[inline(always)]
    pub(super) fn upward_crossing(&self, from: Wide<S>, gap: Wide<S>) -> Crossing<S> {
        let Self { c, d } = self;
        let splat = |x| from.uniform(x);
        let (zero, half, one) = (splat(0.0), splat(0.5), splat(1.0));
        let (mut sums, mut curvatures) = ([zero; 2], [zero; 2]);
        for k in 1..CENTRED - 1 {
            let (size, chain) = (d[k].abs(), k % 2);
            sums[chain] = size.mul_add(splat(POWERS[k]), sums[chain]);
            curvatures[chain] = size.mul_add(splat(k as f64 * POWERS[k - 1]), curvatures[chain]);
        }
        let (sum, curvature) = (sums[0] + sums[1], curvatures[0] + curvatures[1]);
        // Within REACH the slope is at least `spare` and the second derivative at most
        // `curvature`.
        let spare = d[0] - sum;
        let straight = zero.less_than(spare) & curvature.less_than(half * spare);
        let squares = half * curvature / spare;

        // Starting value by third-order reversion of the series.
        let scale = one / c[1];
        let linear = -(c[0] * scale);
        let (bend, twist) = (c[2] * scale, c[3] * scale);
        let inner = (bend + bend).mul_add(bend, -twist);
        let start = linear * linear.neg_mul_add(linear.neg_mul_add(inner, bend), one);
        // If K = `squares` and K m ≤ 1, the error after a step m is at most 4 K m². If K m > 1,
        // `last` is too large and nothing is found (docs/numerics.md, section 7).
        let step = polynomial(c, start) / polynomial(d, start);
        let error = splat(4.0) * squares * step * step;
        let once = start - step;
        let inverse = one / polynomial(d, once);
        let twice = once - polynomial(c, once) * inverse;
        let rest = squares * error * error;
        // The third step uses the slope of the second, which was evaluated at most error + rest
        // away from the zero. The slope's error is at most max |p''| times that distance.
        let thrice = twice - polynomial(c, twice) * inverse;
        let last = (squares + squares) * (error + rest) * rest;
        // In a search from a start (`from` = 0) the resolution is relative to u, so that the last
        // bounces of a chatter run are found as accurately as the first.
        let centred = from.at_most(-one);
        let resolution = splat(RESOLUTION) * centred.select(one, once.abs());
        let (enough, soon) = (rest.at_most(resolution), error.at_most(resolution));
        let u = soon.select(once, enough.select(twice, thrice));
        let reach = splat(REACH);
        let near = start.abs().less_than(reach) & once.abs().less_than(splat(BEYOND));
        let inside = near & from.less_than(u) & u.less_than(reach);
        // A path that rises from c[0] to zero stays between these values. If a zero at the start
        // was divided out, the block stays within REACH |c[0]| of its stop until it returns. In
        // both cases the block does not reach the other stop.
        let alone = centred | (-c[0]).less_than(gap);
        Crossing {
            u,
            found: straight & last.at_most(resolution) & inside & alone,
            iterations: soon.select(one, enough.select(splat(2.0), splat(3.0))),
        }
    }
}

/// Σ_k c_k u^k by pairs of neighbouring orders (Estrin's scheme), whose short chains of operations
/// run side by side.
#[inline(always)]
fn polynomial<S: Simd, const N: usize>(c: &[Wide<S>; N], u: Wide<S>) -> Wide<S> {
    let square = u * u;
    let fourth = square * square;
    let pair = |k: usize| if k + 1 < N { c[k + 1].mul_add(u, c[k]) } else { c[k] };
    let low = pair(2).mul_add(square, pair(0));
    let middle = pair(6).mul_add(square, pair(4));
    pair(8).mul_add(fourth * fourth, middle.mul_add(fourth, low))
}

#[cfg(test)]
mod tests;
