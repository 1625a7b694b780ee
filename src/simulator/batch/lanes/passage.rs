//! Free flights about the centre of an interval, one in each lane: their series, the stop's passage and the state there.

use super::rows::LaneSystems;
use crate::flow::CENTRED;
use crate::simulator::batch::vectors::{Mask, Row, Wide};
use pulp::Simd;

/// 1/k!
const FACTORIALS: [f64; CENTRED] = {
    let mut r = [1.0; CENTRED];
    let mut k = 2;
    while k < CENTRED {
        r[k] = r[k - 1] / k as f64;
        k += 1;
    }
    r
};
/// How far about the centre the series serves: a third of an interval beyond the end it still has all but 3e-17 of the
/// largest coordinate, and a gap that is only just short of the stop at the end is followed into the next interval.
pub(super) const REACH: f64 = 4.0 / 3.0;
const POWERS: [f64; CENTRED] = {
    let mut r = [1.0; CENTRED];
    let mut k = 1;
    while k < CENTRED {
        r[k] = r[k - 1] * REACH;
        k += 1;
    }
    r
};
/// A root is found when the proof leaves less than this of an interval's half: the rounding of 1.
const RESOLUTION: f64 = 0.5 * f64::EPSILON;

/// The derivatives at the centre in the time unit of half an interval.
pub(super) struct Flights<S: Simd> {
    /// x1, w, x3.
    place: [Wide<S>; 3],
    /// Of their rates, `[order][coordinate]`; those of the places are the same one order on.
    rates: [[Wide<S>; 3]; CENTRED],
    cos: Wide<S>,
    sin: Wide<S>,
}

impl<S: Simd> Flights<S> {
    /// By the equations of motion, order after order; the accelerations are those of [`crate::model::Model::acceleration`].
    #[inline(always)]
    pub(super) fn expand(simd: S, systems: &LaneSystems, v: usize, z: &[Wide<S>; 8]) -> Self {
        let of = |row: &Row| Wide::of(simd, row, v);
        let (k1, c1, k2, k3, c3, k32) = (
            of(&systems.k1),
            of(&systems.c1),
            of(&systems.k2),
            of(&systems.k3),
            of(&systems.c3),
            of(&systems.k32),
        );
        let (drive, turn, radius) = (of(&systems.drive), of(&systems.turn), of(&systems.radius));
        let place = [z[0], z[1], z[2]];
        let mut rates = [[z[3] * radius, z[4] * radius, z[5] * radius]; CENTRED];
        // The drive's derivatives: each second one is the first times -turn².
        let square = -(turn * turn);
        let mut push = [drive * z[7], drive * turn * z[6]];
        let mut x = place;
        for k in 0..CENTRED - 1 {
            let v = rates[k];
            let stretch = (x[0] - x[2]) + x[1];
            let back = k1.mul_add(x[0], c1.mul_add(v[0], -push[k % 2])); // -x1''
            rates[k + 1] =
                [-back, k2.neg_mul_add(stretch, back), k32.mul_add(stretch, -k3.mul_add(x[2], c3 * v[2]))];
            push[k % 2] = push[k % 2] * square;
            x = v;
        }
        Self { place, rates, cos: z[6], sin: z[7] }
    }

    /// The gap over the stops `side`, negative while the block is inside.
    #[inline(always)]
    pub(super) fn paths(&self, side: Wide<S>, gap: Wide<S>) -> Paths<S> {
        let zero = side.all(0.0);
        let mut paths = Paths { c: [zero; CENTRED], d: [zero; CENTRED - 1] };
        paths.c[0] = side * self.place[1] - gap;
        for k in 1..CENTRED {
            let derivative = side * self.rates[k - 1][1];
            paths.c[k] = derivative * side.all(FACTORIALS[k]);
            paths.d[k - 1] = derivative * side.all(FACTORIALS[k - 1]);
        }
        paths
    }

    /// The state at u.
    #[inline(always)]
    pub(super) fn at(&self, systems: &LaneSystems, simd: S, v: usize, u: Wide<S>) -> [Wide<S>; 8] {
        let zero = u.all(0.0);
        let mut rate = self.rates[CENTRED - 1];
        let mut path = self.rates[CENTRED - 2];
        for k in (1..CENTRED).rev() {
            let part = u * u.all(1.0 / k as f64);
            for (rate, order) in rate.iter_mut().zip(self.rates[k - 1]) {
                *rate = rate.mul_add(part, order);
            }
            if k < CENTRED - 1 {
                // Order k + 1 of the path has the factor u/(k + 1).
                let part = u * u.all(1.0 / (k + 1) as f64);
                for (path, order) in path.iter_mut().zip(self.rates[k - 1]) {
                    *path = path.mul_add(part, order);
                }
            }
        }
        let per = u.all(1.0) / Wide::of(simd, &systems.radius, v);
        let mut z = [zero; 8];
        for j in 0..3 {
            z[j] = path[j].mul_add(u, self.place[j]);
            z[j + 3] = rate[j] * per;
        }
        let angle = u * Wide::of(simd, &systems.turn, v);
        let square = angle * angle;
        let (mut cos, mut sin) = (zero, zero);
        for k in (0..CENTRED / 2).rev() {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            cos = cos.mul_add(square, u.all(sign * FACTORIALS[2 * k]));
            sin = sin.mul_add(square, u.all(sign * FACTORIALS[2 * k + 1]));
        }
        let sin = sin * angle;
        z[6] = sin.neg_mul_add(self.sin, cos * self.cos);
        z[7] = sin.mul_add(self.cos, cos * self.sin);
        z
    }
}

/// Polynomials with their slopes' coefficients.
pub(super) struct Paths<S: Simd> {
    c: [Wide<S>; CENTRED],
    d: [Wide<S>; CENTRED - 1],
}

/// Where they pass zero.
pub(super) struct Crossing<S: Simd> {
    pub(super) u: Wide<S>,
    /// Where the proof holds.
    pub(super) found: Mask<S>,
    pub(super) iterations: Wide<S>,
}

impl<S: Simd> Paths<S> {
    /// Divides the `chosen` by u: the root at zero, at which they start, is no return.
    #[inline(always)]
    pub(super) fn divide(&mut self, chosen: Mask<S>) {
        let zero = self.c[0].all(0.0);
        for k in 0..CENTRED {
            let next = if k + 1 < CENTRED { self.c[k + 1] } else { zero };
            self.c[k] = chosen.select(next, self.c[k]);
            if k > 0 {
                let slope = self.c[k] * zero.all(k as f64);
                self.d[k - 1] = chosen.select(slope, self.d[k - 1]);
            }
        }
    }

    /// Where there is proof that they stay below zero, and above -2 `gap`, from `from` to [`REACH`].
    #[inline(always)]
    pub(super) fn stay(&self, from: Wide<S>, gap: Wide<S>) -> Mask<S> {
        let c = &self.c;
        let of = |x| from.all(x);
        let (zero, reach) = (of(0.0), of(REACH));
        let (mut rest, mut rise) = (zero, zero);
        for k in (3..CENTRED).rev() {
            rest = c[k].abs().mul_add(of(POWERS[k]), rest);
            rise = c[k].max(zero).mul_add(of(POWERS[k]), rise);
        }
        // A parabola and what the rest can add.
        let parabola = |u: Wide<S>| u.mul_add(u.mul_add(c[2], c[1]), c[0]);
        let ends = parabola(from).max(parabola(reach));
        let top = -(c[1] / (c[2] + c[2]));
        let inside = c[2].less(zero) & from.less(top) & top.less(reach);
        let most = inside.select(ends.max(parabola(top)), ends);
        let low = (most + rest).less(zero);
        // From zero on a sum of convex functions is greatest at an end.
        let end = c[1].mul_add(reach, c[2].max(zero).mul_add(of(POWERS[2]), rise));
        let convex = zero.at_most(from) & c[0].less(zero) & (c[0] + end).less(zero);
        let path = c[0].abs() + c[1].abs().mul_add(reach, c[2].abs().mul_add(of(POWERS[2]), rest));
        (low | convex) & path.less(gap)
    }

    /// The passage upwards in (`from`, [`REACH`]). As [`crate::events::flight_crossing`], and like it sure of a path that rises
    /// and is nearly straight only.
    #[inline(always)]
    pub(super) fn crossing(&self, from: Wide<S>, gap: Wide<S>) -> Crossing<S> {
        let Self { c, d } = self;
        let of = |x| from.all(x);
        let (zero, half, one) = (of(0.0), of(0.5), of(1.0));
        let (mut sums, mut curvatures) = ([zero; 2], [zero; 2]);
        for k in 1..CENTRED - 1 {
            let (size, chain) = (d[k].abs(), k % 2);
            sums[chain] = size.mul_add(of(POWERS[k]), sums[chain]);
            curvatures[chain] = size.mul_add(of(k as f64 * POWERS[k - 1]), curvatures[chain]);
        }
        let (sum, curvature) = (sums[0] + sums[1], curvatures[0] + curvatures[1]);
        let spare = d[0] - sum;
        let straight = zero.less(spare) & curvature.less(half * spare);
        let squares = half * curvature / spare;

        let scale = one / c[1];
        let linear = -(c[0] * scale);
        let (bend, twist) = (c[2] * scale, c[3] * scale);
        let inner = (bend + bend).mul_add(bend, -twist);
        let start = linear * linear.neg_mul_add(linear.neg_mul_add(inner, bend), one);
        // Newton's method squares the error: after the first step it is at most this.
        let step = polynomial(c, start) / polynomial(d, start);
        let error = of(4.0) * squares * step * step;
        let once = start - step;
        let inverse = one / polynomial(d, once);
        let twice = once - polynomial(c, once) * inverse;
        let rest = squares * error * error;
        // A third step with the slope of the second: |p''| times the way to there is all by which that slope is wrong.
        let thrice = twice - polynomial(c, twice) * inverse;
        let last = (squares + squares) * (error + rest) * rest;
        // The last bounces of a run take as many digits as the first.
        let centred = from.at_most(-one);
        let resolution = of(RESOLUTION) * centred.select(one, once.abs());
        let (enough, soon) = (rest.at_most(resolution), error.at_most(resolution));
        let u = soon.select(once, enough.select(twice, thrice));
        let reach = of(REACH);
        let inside = start.abs().less(reach) & from.less(u) & u.less(reach);
        // What rises from c[0] to zero keeps to it in between: the path of a return is at most REACH times that long.
        let alone = centred | (-c[0]).less(gap);
        Crossing {
            u,
            found: straight & last.at_most(resolution) & inside & alone,
            iterations: soon.select(one, enough.select(of(2.0), of(3.0))),
        }
    }
}

/// Σ_k c_k u^k by pairs of neighbouring orders, so that nothing waits long for anything.
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
