//! Growth of a variation from return to return, and the exponent with its error.

use crate::exponent::{CONFIDENCE, ExponentSign, LEAST_GROWTH, LargestExponent};

/// Returns during which a variation aligns with the fastest direction before its growth counts.
pub const ALIGN: usize = 32;
/// Limits of the number of blocks: fewer have no meaningful scatter, and with more each block is
/// too short to be independent.
const LEAST_BLOCKS: usize = 8;
const MOST_BLOCKS: usize = 64;
/// Number of returns needed to decide a sign.
const LEAST_RETURNS: usize = 64;

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

    /// Standard error of the mean, 1/s: the largest one from the scatter of blocks of 1, 2, 4, …
    /// returns, while there are 8 to 63 blocks. Growth depends on the return before. Correlated
    /// growth scatters more in long blocks. Rotation by a complex multiplier cancels in long
    /// blocks.
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

    /// The exponent with its error. A length that grows in proportion to time, as on a torus,
    /// gives ln(1 + T/T₀)/T instead of zero after the time T₀ of alignment. The error includes
    /// this bias, which scatter does not show.
    pub fn exponent(&self) -> LargestExponent {
        let periods = self.returns();
        if self.is_lost() {
            return LargestExponent { value: f64::NEG_INFINITY, error: 0.0, periods };
        }
        let [_, time] = self.sums();
        let bias = if time > 0.0 { (time / self.turned).ln_1p() / time } else { 0.0 };
        LargestExponent { value: self.value(), error: self.scatter().hypot(bias), periods }
    }

    /// Sign of the exponent relative to a threshold, 1/s, if it is known.
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
    /// ρ)/(1 - ρ) times the variance for independent numbers.
    #[test]
    fn closed_form_errors_of_correlated_growth_cover_the_mean_at_their_rate() {
        // About 95 % of normal means are within two standard errors. If there are few blocks, a
        // few more means are outside.
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

    /// Growth of `counted` returns of 0.5 s after the alignment; `of` gives the growth of each.
    fn grown(counted: u32, of: impl Fn(u32) -> f64) -> Growth {
        let mut growth = Growth::default();
        (0..ALIGN).for_each(|_| growth.add(3.0, 0.5));
        (0..counted).for_each(|k| growth.add(of(k), 0.5));
        growth
    }

    /// Tolerance for sums of a few dozen numbers.
    const SUMMED: f64 = 1e-13;

    #[test]
    fn closed_form_of_even_growth_the_error_is_the_bias_alone() {
        for rate in [0.4, -0.4] {
            let found = grown(96, |_| 0.5 * rate).exponent();
            assert_eq!(found.periods, 96);
            assert!((found.value - rate).abs() < SUMMED, "{found:?}");
            // ln(1 + T/T0)/T: 48 s are counted after 16 s of alignment.
            assert!((found.error - 4f64.ln() / 48.0).abs() < SUMMED, "{found:?}");
        }
        // Nothing has been counted, so the counted time is zero.
        assert_eq!((grown(0, |_| 1.0).value(), grown(0, |_| 1.0).exponent().error), (0.0, 0.0));
    }

    #[test]
    fn closed_form_the_scatter_is_that_of_blocks_of_which_there_are_8_to_63() {
        let swing = |k: u32| if k.is_multiple_of(2) { 0.3 } else { -0.3 };
        for (counted, expected) in [
            (7, 0.0),
            // √(n Σx²/(n - 1))/T of 16 single returns; pairs cancel.
            (16, 0.3 * (16.0f64 * 16.0 / 15.0).sqrt() / 8.0),
            (62, 0.3 * (62.0f64 * 62.0 / 61.0).sqrt() / 31.0),
            (64, 0.0),
        ] {
            let found = grown(counted, swing).scatter();
            assert!((found - expected).abs() < SUMMED, "{counted}: {found} {expected}");
        }
        // 128 returns that alternate in fours cancel in the 32 blocks of four. In eights they give
        // 32 blocks of ±1.2.
        let [fours, eights] = [2, 4]
            .map(|half| grown(128, |k| if (k / half).is_multiple_of(2) { 0.3 } else { -0.3 }).scatter());
        let expected = 1.2 * (32.0f64 * 32.0 / 31.0).sqrt() / 64.0;
        assert!(fours < SUMMED && (eights - expected).abs() < SUMMED, "{fours} {eights} {expected}");
    }

    #[test]
    fn closed_form_even_growth_over_unequal_times_has_no_scatter() {
        let mut growth = Growth::default();
        for k in 0..ALIGN as u32 + 40 {
            let seconds = 0.5 + f64::from(k * k % 7);
            growth.add(-0.3 * seconds, seconds);
        }
        assert!((growth.value() + 0.3).abs() < SUMMED && growth.scatter() < SUMMED);
    }

    #[test]
    fn closed_form_a_sign_is_told_by_returns_growth_and_scatter_together() {
        use ExponentSign::{Negative, Positive, Undecided, Zero};
        for (rate, sign) in [(1.0, Positive), (-1.0, Negative)] {
            let even = |_| 0.5 * rate;
            assert_eq!(grown(64, even).sign(0.1), sign);
            assert_eq!(grown(63, even).sign(0.1), Undecided, "too few returns");
            assert_eq!(grown(100, |_| 0.19 * rate).sign(0.01), Undecided, "too little growth");
            assert_eq!(grown(64, even).sign(1.1), Zero, "under the threshold");
            assert_eq!(grown(64, even).sign(0.99), sign, "beyond it");
            // Growth of 40 in 80 s with a scatter of ±0.9 in blocks of eight: six standard errors
            // exceed it.
            let scattered = |k: u32| 0.25 * rate + if (k / 8).is_multiple_of(2) { 0.9 } else { -0.9 };
            assert_eq!(grown(160, scattered).sign(0.1), Undecided, "it scatters");
            assert_eq!(grown(160, |_| 0.25 * rate).sign(0.1), sign);
        }
        assert_eq!(grown(64, |_| 0.0).sign(0.6), Undecided, "32 s at 0.6/s are less than the least growth");
        assert_eq!(grown(64, |_| 0.0).sign(0.7), Zero);
    }

    #[test]
    fn what_is_lost_has_the_exponent_minus_infinity_at_once() {
        let mut growth = Growth::default();
        growth.add(0.5, 1.0);
        assert!(!growth.is_lost());
        growth.add(f64::NEG_INFINITY, 1.0);
        assert!(growth.is_lost());
        let found = growth.exponent();
        assert_eq!((found.value, found.error, found.periods), (f64::NEG_INFINITY, 0.0, 1));
        assert_eq!(growth.sign(f64::INFINITY), ExponentSign::Negative);
    }
}
