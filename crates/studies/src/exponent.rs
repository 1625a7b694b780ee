//! Largest Lyapunov exponent of a motion, with its error and its sign.

use serde::{Deserialize, Serialize};

/// Threshold for the sign of an exponent, per unit of the dimensionless time τ. If the drive's
/// frequency is less than ω10, the unit is the drive's time for 1 rad. Over 1500 periods,
/// estimates of a zero exponent are within a few 1e-4.
pub const ZERO_EXPONENT: f64 = 1e-3;
/// Distance of an exponent from the threshold, in standard errors, beyond which its sign is
/// decided. LEAST_GROWTH must be exceeded as well.
pub(crate) const CONFIDENCE: f64 = 6.0;

/// Growth or decay of the variation, as a logarithm, needed to decide a sign. On a torus the
/// length of the variation stays within some powers of ten for ever.
pub(crate) const LEAST_GROWTH: f64 = 20.0;

/// Largest exponent of a motion, without the zero exponent of the drive's phase.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LargestExponent {
    /// Estimate, 1/s; -∞ if all variations end in rest.
    pub value: f64,
    /// Standard error of the estimate, 1/s.
    pub error: f64,
    /// Counted drive periods.
    pub periods: u32,
}

/// Sign of an exponent, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExponentSign {
    /// Certainly positive.
    Positive,
    /// Certainly negative.
    Negative,
    /// Between the thresholds, ± [`ZERO_EXPONENT`](ZERO_EXPONENT) times ω10 or ω1, after a time in
    /// which a larger exponent would have changed the variation by e²⁰.
    Zero,
    /// Unknown.
    Undecided,
}

impl LargestExponent {
    /// The sign at a threshold in 1/s, for a period in s.
    pub(crate) fn sign_beyond(&self, threshold: f64, period: f64) -> ExponentSign {
        let time = f64::from(self.periods) * period;
        let clear = self.value.abs() - CONFIDENCE * self.error > threshold;
        match (clear, self.value > 0.0) {
            (true, positive) if self.value.abs() * time > LEAST_GROWTH => {
                if positive {
                    ExponentSign::Positive
                } else {
                    ExponentSign::Negative
                }
            }
            _ if self.value.abs() <= threshold && threshold * time > LEAST_GROWTH => ExponentSign::Zero,
            _ => ExponentSign::Undecided,
        }
    }
}
