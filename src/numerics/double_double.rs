//! DoubleDouble-precision time and phase: an unevaluated sum of two doubles (about 32 digits), so that neither the
//! clock nor the drive's phase drifts however many sub-steps are added (T. J. Dekker, Numer. Math. 18, 1971).

use serde::{Deserialize, Serialize};

/// A number `hi + lo` with |lo| at most half a unit in the last place of `hi`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DoubleDouble {
    pub hi: f64,
    pub lo: f64,
}

/// 2π to 32 digits.
const TAU: DoubleDouble = DoubleDouble { hi: std::f64::consts::TAU, lo: 2.449_293_598_294_706_4e-16 };
/// 1/(2π) to 32 digits.
const INVERSE_TAU: DoubleDouble =
    DoubleDouble { hi: 0.159_154_943_091_895_35, lo: -9.839_338_440_020_25e-18 };

#[inline(always)]
fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let hi = a + b;
    let t = hi - a;
    DoubleDouble { hi, lo: (a - (hi - t)) + (b - t) }
}

#[inline(always)]
fn quick_two_sum(a: f64, b: f64) -> DoubleDouble {
    let hi = a + b;
    DoubleDouble { hi, lo: b - (hi - a) }
}

/// Exact product by Dekker's splitting: the same bits on machines with and without fused multiply-add.
#[inline(always)]
fn two_product(a: f64, b: f64) -> DoubleDouble {
    let split = |x: f64| {
        let t = 134_217_729.0 * x; // 2^27 + 1
        let high = t - (t - x);
        (high, x - high)
    };
    let hi = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    DoubleDouble { hi, lo: ((ah * bh - hi) + ah * bl + al * bh) + al * bl }
}

impl DoubleDouble {
    #[inline(always)]
    pub fn new(value: f64) -> Self {
        Self { hi: value, lo: 0.0 }
    }

    /// The sum of two doubles, exactly.
    #[inline(always)]
    pub fn sum(a: f64, b: f64) -> Self {
        two_sum(a, b)
    }

    #[inline(always)]
    pub fn plus(self, b: f64) -> Self {
        let s = two_sum(self.hi, b);
        quick_two_sum(s.hi, s.lo + self.lo)
    }

    #[inline(always)]
    pub fn add(self, b: Self) -> Self {
        let s = two_sum(self.hi, b.hi);
        let t = two_sum(self.lo, b.lo);
        let s = quick_two_sum(s.hi, s.lo + t.hi);
        quick_two_sum(s.hi, s.lo + t.lo)
    }

    #[inline(always)]
    pub fn minus(self, b: Self) -> Self {
        self.add(Self { hi: -b.hi, lo: -b.lo })
    }

    #[inline(always)]
    pub fn times(self, b: Self) -> Self {
        let p = two_product(self.hi, b.hi);
        quick_two_sum(p.hi, p.lo + (self.hi * b.lo + self.lo * b.hi))
    }

    #[inline(always)]
    pub fn value(self) -> f64 {
        self.hi + self.lo
    }

    /// The fraction in [-1/2, 1/2] left when the nearest whole number is taken away.
    #[inline(always)]
    pub fn fraction(self) -> Self {
        let whole = self.hi.round_ties_even();
        let rest = Self::new(self.hi - whole).plus(self.lo);
        let again = rest.hi.round_ties_even(); // lo may carry over a half
        Self { hi: rest.hi - again, lo: rest.lo }
    }
}

impl From<f64> for DoubleDouble {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self::new(value)
    }
}

/// The drive's phase in turns: `turns(t) = turns0 + ω (t - t0)/2π`, re-based when ω changes so that it stays continuous.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrivePhase {
    base: DoubleDouble,
    from: DoubleDouble,
}

/// Turns of a phase given in rad. 32 digits of π are too few for the largest doubles: the library's own reduction knows more.
fn turns_of(phase: f64) -> DoubleDouble {
    const PLAIN: f64 = 1e9;
    let phase = if phase.abs() <= PLAIN { phase } else { phase.sin().atan2(phase.cos()) };
    DoubleDouble::new(phase).times(INVERSE_TAU)
}

impl DrivePhase {
    /// The phase of `sin(ω t + phase)`.
    pub fn new(phase: f64) -> Self {
        Self { base: turns_of(phase).fraction(), from: DoubleDouble::default() }
    }

    #[inline(always)]
    fn turns(&self, omega: f64, time: DoubleDouble) -> DoubleDouble {
        let rate = INVERSE_TAU.times(DoubleDouble::new(omega));
        time.minus(self.from).times(rate).add(self.base).fraction()
    }

    /// The phase in [-π, π].
    #[inline(always)]
    pub fn angle(&self, omega: f64, time: DoubleDouble) -> f64 {
        self.turns(omega, time).times(TAU).value()
    }

    pub fn is_finite(&self) -> bool {
        [self.base, self.from].iter().all(|e| e.hi.is_finite() && e.lo.is_finite())
    }

    /// Goes on from `time` with another frequency (set by the caller) and a jump from one phase to another, rad.
    pub fn rebase(&mut self, omega: f64, time: DoubleDouble, (from, to): (f64, f64)) {
        let shift = turns_of(to).minus(turns_of(from));
        self.base = self.turns(omega, time).add(shift).fraction();
        self.from = time;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Units in the last place of an angle of order 1, and the rounding of its 2π.
    const ROUNDING: f64 = 1e-15;

    #[test]
    fn closed_form_phase_after_a_million_periods() {
        // After n periods of a frequency that is a power of two, ω t / 2π is n exactly where t = n 2π/ω in extended precision.
        let omega = 0.5;
        let time = TAU.times(DoubleDouble::new(2.0 * 1_000_000.0)).plus(0.25);
        let angle = DrivePhase::new(1.0).angle(omega, time);
        assert!((angle - 1.125).abs() < ROUNDING, "{angle}");
    }

    #[test]
    fn invariant_a_change_of_frequency_keeps_the_phase() {
        let mut phase = DrivePhase::new(0.3);
        let time = DoubleDouble::new(123_456.789);
        let before = phase.angle(1.04, time);
        phase.rebase(1.04, time, (0.3, 0.3));
        assert!((phase.angle(7.0, time) - before).abs() < ROUNDING);
    }

    #[test]
    fn closed_form_phases_of_any_size() {
        let far = [1e9, -3e12, 1e22, -9.2e305, f64::MAX];
        for from in far {
            let (sine, cosine) = DrivePhase::new(from).angle(1.0, DoubleDouble::default()).sin_cos();
            assert!(
                (sine - from.sin()).abs() < ROUNDING && (cosine - from.cos()).abs() < ROUNDING,
                "{from:e}"
            );
            for to in far {
                let mut phase = DrivePhase::new(from);
                phase.rebase(1.0, DoubleDouble::new(0.0), (from, to));
                let sine = phase.angle(1.0, DoubleDouble::default()).sin();
                assert!((sine - to.sin()).abs() < ROUNDING, "{from:e} {to:e}");
            }
        }
    }

    #[test]
    fn closed_form_sums_do_not_drift() {
        let mut time = DoubleDouble::default();
        for _ in 0..1_000_000 {
            time = time.plus(0.1);
        }
        // 10^6 additions of the double nearest 0.1, whose exact product with 10^6 is this:
        let exact = two_product(0.1, 1e6);
        assert!((time.minus(exact)).value().abs() < 1e-22, "{time:?}");
    }
}
