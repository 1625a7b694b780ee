//! Growth of a variation from return to return, and the exponent with its error.

use crate::largest_exponent::{ExponentSign, LargestExponent};

/// Returns in which a variation aligns with its direction before growth counts.
pub const ALIGN: usize = 32;
/// Least number of blocks whose scatter is meaningful, and number from which each would be too
/// short to be independent of the next.
const LEAST_BLOCKS: usize = 8;
const MOST_BLOCKS: usize = 64;
/// Least number of returns that decide a sign.
const LEAST_RETURNS: usize = 64;
/// Distance of an exponent from the threshold, in standard errors, beyond which its sign is
/// decided; LEAST_GROWTH must be exceeded too.
const CONFIDENCE: f64 = 6.0;
/// Logarithm of the growth or shrinkage of the variation that a decided sign requires. On a torus
/// the variation stays within some powers of ten for ever.
const LEAST_GROWTH: f64 = 20.0;

/// Logarithms of a variation's growth, by return.
#[derive(Clone, Debug, Default)]
pub struct Growth {
    /// Returns left out at the beginning.
    turning: usize,
    /// Duration of the left-out returns, s.
    turned: f64,
    /// Growth and duration, s, of each counted return.
    counted: Vec<[f64; 2]>,
}

impl Growth {
    /// Adds the logarithm of the growth from one return to the next, and the seconds between them.
    pub fn add(&mut self, logarithm: f64, seconds: f64) {
        if self.turning < ALIGN && logarithm.is_finite() {
            self.turning += 1;
            self.turned += seconds;
        } else {
            self.counted.push([logarithm, seconds]);
        }
    }

    /// Sums of growth and of time, s.
    fn sums(&self) -> [f64; 2] {
        self.counted.iter().fold([0.0; 2], |[g, t], [growth, time]| [g + growth, t + time])
    }

    /// Number of counted returns.
    pub fn returns(&self) -> u32 {
        self.counted.len() as u32
    }

    /// Whether all directions are lost, so that the exponent is -∞.
    pub fn is_lost(&self) -> bool {
        self.counted.last().is_some_and(|last| last[0] == f64::NEG_INFINITY)
    }

    /// The exponent, 1/s.
    fn value(&self) -> f64 {
        let [growth, time] = self.sums();
        if time > 0.0 { growth / time } else { 0.0 }
    }

    /// Standard error of the mean, 1/s: the largest from the scatter of blocks of 1, 2, 4, …
    /// returns, as long as there are 8 to 63 of them. Growth depends on that of the return before:
    /// correlated growth scatters more in long blocks, and the turns of a complex multiplier, which
    /// cancel, less.
    fn scatter(&self) -> f64 {
        let (value, [_, time]) = (self.value(), self.sums());
        let mut rest: Vec<f64> = self.counted.iter().map(|[growth, time]| growth - value * time).collect();
        let mut largest = 0.0f64;
        while rest.len() >= LEAST_BLOCKS {
            let count = rest.len() as f64;
            if rest.len() < MOST_BLOCKS {
                let mean = rest.iter().sum::<f64>() / count;
                let square: f64 = rest.iter().map(|x| (x - mean).powi(2)).sum();
                largest = largest.max((square * count / (count - 1.0)).sqrt() / time);
            }
            rest = rest.chunks_exact(2).map(|pair| pair[0] + pair[1]).collect();
        }
        largest
    }

    /// The exponent with its error. A length that grows in proportion to time, as on a torus, gives
    /// ln(1 + T/T₀)/T instead of zero after the time T₀ of alignment; no scatter shows this share
    /// of the error.
    pub fn exponent(&self) -> LargestExponent {
        let periods = self.returns();
        if self.is_lost() {
            return LargestExponent { value: f64::NEG_INFINITY, error: 0.0, periods };
        }
        let [_, time] = self.sums();
        let bias = if time > 0.0 { (time / self.turned).ln_1p() / time } else { 0.0 };
        LargestExponent { value: self.value(), error: self.scatter().hypot(bias), periods }
    }

    /// Sign of the exponent at a threshold, 1/s, as far as it is known.
    pub fn sign(&self, threshold: f64) -> ExponentSign {
        if self.is_lost() {
            return ExponentSign::Negative;
        }
        let ([growth, time], value) = (self.sums(), self.value());
        let clear = self.counted.len() >= LEAST_RETURNS
            && growth.abs() > LEAST_GROWTH
            && value.abs() - CONFIDENCE * self.scatter() > threshold;
        match (clear, value > 0.0) {
            (true, true) => ExponentSign::Positive,
            (true, false) => ExponentSign::Negative,
            _ if value.abs() <= threshold && threshold * time > LEAST_GROWTH => ExponentSign::Zero,
            _ => ExponentSign::Undecided,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sequence with known standard errors: for x' = ρ x + noise the variance of means is (1 +
    /// ρ)/(1 - ρ) times that of independent numbers.
    #[test]
    fn closed_form_errors_of_correlated_growth_cover_the_mean_at_their_rate() {
        // 95 % of normal means lie within two standard errors; a few more lie outside, since there
        // are few blocks.
        const COVERED: std::ops::RangeInclusive<usize> = 176..=200;
        let mut seed = 1u64;
        let mut uniform = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut covered = 0;
        for _ in 0..200 {
            let (mut growth, mut x) = (Growth::default(), 0.0);
            for _ in 0..ALIGN + 1024 {
                x = 0.8 * x + (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
                growth.add(0.5 + x, 1.0);
            }
            covered += usize::from((growth.value() - 0.5).abs() <= 2.0 * growth.scatter());
        }
        assert!(COVERED.contains(&covered), "{covered}");
    }

    #[test]
    fn closed_form_a_shear_has_the_exponent_zero_within_its_error() {
        // Length 1 + t.
        let mut growth = Growth::default();
        for k in 0..3000 {
            growth.add((f64::from(k + 2) / f64::from(k + 1)).ln(), 1.0);
        }
        let found = growth.exponent();
        assert!(found.value > 0.0 && found.value < 1.1 * found.error, "{found:?}");
        assert_eq!(growth.sign(1e-2), ExponentSign::Zero);
    }
}
