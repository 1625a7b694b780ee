//! Brent's method.

/// Steps after which Brent's method gives up; bisection alone needs about 60 for a double.
const BRENT_STEPS: usize = 200;

/// Brent's method: the root of `f` between `a` and `b`, where `f` has opposite signs, to `tolerance` in the
/// argument. `None` when there is no change of sign or `f` is not a number.
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
    let (mut c, mut fc) = (a, fa);
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

    /// Brent's method is asked for this much in the argument.
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
