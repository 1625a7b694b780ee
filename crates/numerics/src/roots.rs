//! Roots of functions of one variable, by Brent's method (R. P. Brent, Algorithms for Minimization
//! without Derivatives, 1973, chapter 4).

/// Largest number of steps of Brent's method. Bisection needs about 60 steps if root and interval
/// are of similar size, and Brent's method at most a few times this number.
const BRENT_STEPS: usize = 200;

/// Root of `f` between `a` and `b`, where `f` must have opposite signs, to `tolerance` (plus the
/// rounding of the root) in the argument. `None` if there is no change of sign or `f` returns NaN.
///
/// The interval between the current root `b` and `c` always encloses a change of sign, so the
/// method ends even if the function is not continuous. A step of inverse interpolation is taken if
/// it shrinks this interval fast enough, otherwise a bisection.
///
/// ```
/// use vibro_numerics::roots::brent;
///
/// let root = brent(|x| x * x - 2.0, 0.0, 2.0, 1e-15).expect("a change of sign");
/// assert!((root - 2f64.sqrt()).abs() < 1e-15);
/// ```
pub fn brent(mut f: impl FnMut(f64) -> f64, a: f64, b: f64, tolerance: f64) -> Option<f64> {
    let (mut a, mut b) = (a, b);
    let (mut fa, mut fb) = (f(a), f(b));
    if fa == 0.0 {
        return Some(a);
    }
    if fb == 0.0 {
        return Some(b);
    }
    if fa.is_nan() || fb.is_nan() || (fa > 0.0) == (fb > 0.0) {
        return None;
    }
    // b is the best approximation, a the previous one, and the root lies between b and c.
    let (mut c, mut fc) = (a, fa);
    // The current step and the previous one.
    let mut step = b - a;
    let mut before = step;
    for _ in 0..BRENT_STEPS {
        if (fb > 0.0) == (fc > 0.0) {
            (c, fc) = (a, fa);
            step = b - a;
            before = step;
        }
        if fc.abs() < fb.abs() {
            (a, b, c) = (b, c, b);
            (fa, fb, fc) = (fb, fc, fb);
        }
        let enough = 2.0 * f64::EPSILON * b.abs() + 0.5 * tolerance;
        let middle = 0.5 * (c - b);
        if middle.abs() <= enough || fb == 0.0 {
            return Some(b);
        }
        if before.abs() >= enough && fa.abs() > fb.abs() {
            // Step p/q of linear interpolation if only two points are known, otherwise of inverse
            // quadratic interpolation.
            let s = fb / fa;
            let (mut p, mut q) = if a == c {
                (2.0 * middle * s, 1.0 - s)
            } else {
                let (q, r) = (fa / fc, fb / fc);
                (s * (2.0 * middle * q * (q - r) - (b - a) * (r - 1.0)), (q - 1.0) * (r - 1.0) * (s - 1.0))
            };
            if p > 0.0 {
                q = -q;
            }
            p = p.abs();
            // The step is taken if it stays in the interval and is less than half of the last but
            // one.
            if 2.0 * p < (3.0 * middle * q - (enough * q).abs()).min((before * q).abs()) {
                before = step;
                step = p / q;
            } else {
                step = middle;
                before = middle;
            }
        } else {
            step = middle;
            before = middle;
        }
        (a, fa) = (b, fb);
        b += if step.abs() > enough { step } else { enough.copysign(middle) };
        fb = f(b);
        if fb.is_nan() {
            return None;
        }
    }
    Some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Requested accuracy: a hundred roundings of roots of order one.
    const TOLERANCE: f64 = 1e-14;

    #[test]
    fn closed_form_of_brents_roots() {
        let root = brent(|x| x * x * x - 2.0, 0.0, 2.0, TOLERANCE).unwrap();
        assert!((root - 2f64.cbrt()).abs() < TOLERANCE);
        let root = brent(|x| (x - 0.3).tanh() * 1e-9, -50.0, 80.0, TOLERANCE).unwrap();
        assert!((root - 0.3).abs() < TOLERANCE);
        assert_eq!(brent(|x| x * x + 1.0, -1.0, 1.0, TOLERANCE), None);
        assert_eq!(brent(|_| f64::NAN, -1.0, 1.0, TOLERANCE), None);
    }
}
