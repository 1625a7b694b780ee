//! Polynomials on [0, 1] in Bernstein form: bounds that prove a sign, and extrema exact to
//! round-off.
//!
//! A polynomial lies within the range of its Bernstein coefficients. Each halving of the interval
//! (de Casteljau's subdivision) reduces the distance between range and polynomial by a factor of
//! four, so a sign is proved without sampling. The number of sign changes of the coefficients'
//! differences bounds the number of turning points (Descartes' rule), so every extremum is
//! isolated before it is computed. See G. Farin, Curves and Surfaces for CAGD.

/// Degree of the Taylor polynomial of a piece of a flight. With rate × step ≤ [`RATE_STEP`], the
/// first neglected term of displacement and velocity is less than 5e-16 of the amplitude.
pub const DEGREE: usize = 16;

/// Largest product of the rate of the fastest mode and the length of one Taylor piece.
pub const RATE_STEP: f64 = 0.75;

/// A polynomial in t ∈ [0, 1], given by its monomial coefficients, lowest power first.
pub type Polynomial = [f64; DEGREE + 1];

/// Largest number of halvings of an interval: each reduces the distance of a bound from the
/// polynomial by a factor of four, down to round-off.
const DEPTH: u32 = 30;

/// Largest number of subdivisions in one proof. A tangency needs about 50: two intervals for each
/// of about 25 halvings.
const SUBDIVISIONS: u32 = 512;

/// Tolerance of a bound, relative to the largest value found before: round-off.
const BOUND_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Largest number of Newton steps. Each is safeguarded by bisection; bisection alone would need
/// about 30.
const NEWTON_STEPS: usize = 80;

/// Tolerance for the argument at a turning point. Half of the digits suffice, because the value
/// depends on the argument only to second order.
const TURNING_POINT: f64 = 1e-9;

/// `C(i, k) / C(DEGREE, k)`: Bernstein coefficient i is the sum over k ≤ i of this factor times
/// monomial coefficient k.
const TO_BERNSTEIN: [[f64; DEGREE + 1]; DEGREE + 1] = {
    let mut table = [[0.0; DEGREE + 1]; DEGREE + 1];
    let mut i = 0;
    while i <= DEGREE {
        let mut k = 0;
        table[i][0] = 1.0;
        while k < i {
            table[i][k + 1] = table[i][k] * (i - k) as f64 / (DEGREE - k) as f64;
            k += 1;
        }
        i += 1;
    }
    table
};

/// Value and derivative at t, by Horner's rule.
pub fn evaluate(polynomial: &Polynomial, t: f64) -> (f64, f64) {
    let (mut value, mut slope) = (0.0, 0.0);
    for &coefficient in polynomial.iter().rev() {
        slope = slope * t + value;
        value = value * t + coefficient;
    }
    (value, slope)
}

/// Adds the Taylor polynomial of amplitude·sin(angle + rate t); |rate| ≤ [`RATE_STEP`] keeps the
/// truncation error below round-off.
pub fn add_sine(polynomial: &mut Polynomial, amplitude: f64, rate: f64, angle: f64) {
    let (sin, cos) = angle.sin_cos();
    let (mut now, mut next) = (amplitude * sin, amplitude * cos * rate);
    for (k, coefficient) in polynomial.iter_mut().enumerate() {
        *coefficient += now;
        (now, next) = (next, -now * rate * rate / ((k + 1) * (k + 2)) as f64);
    }
}

/// Bernstein coefficients on [0, 1].
fn to_bernstein(polynomial: &Polynomial) -> Polynomial {
    std::array::from_fn(|i| (0..=i).map(|k| TO_BERNSTEIN[i][k] * polynomial[k]).sum())
}

/// Bernstein coefficients on both halves of the interval, by de Casteljau's subdivision.
fn halves(b: &Polynomial) -> (Polynomial, Polynomial) {
    let (mut left, mut right) = (*b, *b);
    for level in 1..=DEGREE {
        left[level - 1] = right[0];
        for i in 0..=DEGREE - level {
            right[i] = 0.5 * (right[i] + right[i + 1]);
        }
        // `right[..=DEGREE - level]` now holds this level; the rest already holds coefficients of
        // the right half.
    }
    left[DEGREE] = right[0];
    (left, right)
}

/// Whether it is proved that the polynomial stays within `low`..=`high` on [0, 1]. False if the
/// polynomial leaves this range, if a coefficient is NaN, or if the polynomial is so close to a
/// limit that the proof would need more than 512 subdivisions.
///
/// ```
/// use vibro_numerics::bernstein::{DEGREE, stays_within};
///
/// let mut parabola = [0.0; DEGREE + 1];
/// (parabola[1], parabola[2]) = (4.0, -4.0); // 4 t (1 - t), with the maximum 1
/// assert!(stays_within(&parabola, 0.0, 1.0 + 1e-12));
/// assert!(!stays_within(&parabola, 0.0, 0.999));
/// ```
pub fn stays_within(polynomial: &Polynomial, low: f64, high: f64) -> bool {
    fn proved(b: &Polynomial, low: f64, high: f64, budget: &mut u32) -> bool {
        let inside = |x: f64| x >= low && x <= high; // false for NaN
        if b.iter().all(|&x| inside(x)) {
            return true;
        }
        if *budget == 0 || !inside(b[0]) || !inside(b[DEGREE]) {
            return false; // the end coefficients are values of the polynomial
        }
        *budget -= 1;
        let (left, right) = halves(b);
        proved(&left, low, high, budget) && proved(&right, low, high, budget)
    }
    proved(&to_bernstein(polynomial), low, high, &mut { SUBDIVISIONS })
}

/// Raises `best` to the maximum of |polynomial| on [0, 1] if this maximum is larger.
pub fn raise_to_maximum(polynomial: &Polynomial, best: &mut f64) {
    let b = to_bernstein(polynomial);
    raise(polynomial, &b, 0.0, 1.0, best, DEPTH);
}

/// [`raise_to_maximum`] on [from, to], where the polynomial has the Bernstein coefficients `b`.
/// The interval is halved until the coefficients turn at most once or cannot exceed `best`.
fn raise(polynomial: &Polynomial, b: &Polynomial, from: f64, to: f64, best: &mut f64, depth: u32) {
    *best = best.max(b[0].abs()).max(b[DEGREE].abs());
    let bound = b.iter().fold(0.0_f64, |bound, x| bound.max(x.abs()));
    // NaN passes these comparisons undetected; callers have already checked the coefficients.
    if bound <= *best * (1.0 + BOUND_ROUNDING) || depth == 0 {
        return;
    }
    let turns = (1..=DEGREE).filter(|&i| b[i] != b[i - 1]).map(|i| b[i] > b[i - 1]);
    let mut previous = None;
    let mut changes = 0;
    for up in turns {
        changes += usize::from(previous.is_some_and(|was| was != up));
        previous = Some(up);
    }
    match changes {
        0 => {}
        1 => *best = best.max(evaluate(polynomial, turning_point(polynomial, from, to)).0.abs()),
        _ => {
            let (left, right) = halves(b);
            let middle = 0.5 * (from + to);
            raise(polynomial, &left, from, middle, best, depth - 1);
            raise(polynomial, &right, middle, to, best, depth - 1);
        }
    }
}

/// The only zero of the derivative in [from, to], by Newton's method safeguarded by bisection.
fn turning_point(polynomial: &Polynomial, from: f64, to: f64) -> f64 {
    let derivatives = |t: f64| {
        let (mut first, mut second) = (0.0, 0.0);
        for k in (1..=DEGREE).rev() {
            second = second * t + first;
            first = first * t + k as f64 * polynomial[k];
        }
        (first, second)
    };
    let (mut low, mut high) = (from, to);
    let rising = derivatives(low).0 < 0.0;
    let mut t = 0.5 * (low + high);
    for _ in 0..NEWTON_STEPS {
        let (first, second) = derivatives(t);
        if (first < 0.0) == rising {
            low = t
        } else {
            high = t
        }
        let newton = t - first / second;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - t).abs() < TURNING_POINT {
            return next;
        }
        t = next;
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over at most 0.75 rad the truncation error at degree 16 is 2e-17 for values and 5e-16 for
    /// slopes; rounding adds a few ulps.
    const TOLERANCE: f64 = 1e-15;

    /// cos(a + r t) on t ∈ [0, 1].
    fn cosine(a: f64, r: f64) -> Polynomial {
        let mut p = [0.0; DEGREE + 1];
        add_sine(&mut p, 1.0, r, a + std::f64::consts::FRAC_PI_2);
        p
    }

    #[test]
    fn second_method_sine_by_the_library() {
        let mut p = [0.0; DEGREE + 1];
        add_sine(&mut p, 2.0, 0.75, 1.1);
        for t in [0.0, 0.3, 1.0] {
            let (value, slope) = evaluate(&p, t);
            assert!((value - 2.0 * (1.1 + 0.75 * t).sin()).abs() < 4.0 * TOLERANCE);
            assert!((slope - 1.5 * (1.1 + 0.75 * t).cos()).abs() < 4.0 * TOLERANCE);
        }
    }

    #[test]
    fn closed_form_of_a_maximum() {
        for i in 0..40 {
            let a = 0.2 * f64::from(i);
            let mut best = 0.0;
            raise_to_maximum(&cosine(a, 0.7), &mut best);
            let turn = (a / std::f64::consts::PI).ceil() * std::f64::consts::PI;
            let expected = if turn <= a + 0.7 { 1.0 } else { a.cos().abs().max((a + 0.7).cos().abs()) };
            // The angle itself, up to 8, has a rounding error of 1e-15.
            assert!((best - expected).abs() < 4.0 * TOLERANCE, "a = {a}: {best} against {expected}");
        }
    }

    #[test]
    fn closed_form_of_touching_and_crossing() {
        let p = cosine(-0.3, 0.7); // maximum 1 inside
        assert!(stays_within(&p, 0.0, 1.0 + TOLERANCE));
        assert!(!stays_within(&p, 0.0, 1.0 - 1e-12));
        assert!(!stays_within(&p, 0.99, 2.0)); // end value cos(0.4) = 0.92
        assert!(!stays_within(&[f64::NAN; DEGREE + 1], -1.0, 1.0));
    }

    #[test]
    fn invariant_work_on_a_polynomial_along_its_limit() {
        // One plus noise: within a few ulps of the limit everywhere.
        let mut p = [0.0; DEGREE + 1];
        for (k, c) in p.iter_mut().enumerate() {
            *c = f64::EPSILON * if k % 2 == 0 { 1.0 } else { -1.0 };
        }
        p[0] = 1.0;
        stays_within(&p, -1.0, 1.0); // either answer is correct, but the call must end
        let mut best = 0.0;
        raise_to_maximum(&p, &mut best);
        assert!((best - 1.0).abs() < 20.0 * f64::EPSILON);
    }

    #[test]
    fn invariant_halves_are_the_same_polynomial() {
        let p = cosine(0.4, 0.6);
        let (left, right) = halves(&to_bernstein(&p));
        assert!((left[0] - evaluate(&p, 0.0).0).abs() < TOLERANCE);
        assert!((left[DEGREE] - evaluate(&p, 0.5).0).abs() < TOLERANCE);
        assert!((right[0] - evaluate(&p, 0.5).0).abs() < TOLERANCE);
        assert!((right[DEGREE] - evaluate(&p, 1.0).0).abs() < TOLERANCE);
    }
}
