//! Statistics of records and residuals: standard deviations and noise.

/// Noise estimates within this factor of the smallest one are averaged.
const SAME_NOISE: f64 = 1.2;

/// Standard deviation of the noise on a signal, from its differences of several orders: the mean
/// of all estimates near the smallest one.
///
/// Each estimate uses the lower quartile of the sizes of the differences: a quarter of normal
/// numbers are smaller than 0.3186 standard deviations. Differences of order m have √C(2m, m)
/// times the standard deviation of the noise. Coarse sampling of a motion makes the estimates of
/// low orders too large; contacts mostly make the estimates of high orders too large.
pub(super) fn noise(values: &[f64]) -> f64 {
    let (mut all, mut found, mut variance) = (values.to_vec(), Vec::new(), 1.0);
    for order in 1..=6 {
        all = all.windows(2).map(|pair| pair[1] - pair[0]).collect();
        variance *= f64::from(2 * (2 * order - 1)) / f64::from(order);
        let mut sizes: Vec<f64> = all.iter().map(|x| x.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let quarter = sizes.get(sizes.len() / 4).map_or(0.0, |size| size / (0.3186 * variance.sqrt()));
        if order > 1 {
            found.push(quarter);
        }
    }
    let least = found.iter().copied().fold(f64::INFINITY, f64::min);
    // The minimum of several similar estimates is biased low.
    let same: Vec<f64> = found.into_iter().filter(|own| *own <= SAME_NOISE * least).collect();
    same.iter().sum::<f64>() / same.len().max(1) as f64
}

/// Standard deviation of rounding: from the smallest step between two values.
pub(super) fn rounding(values: &[f64]) -> f64 {
    let mut all = values.to_vec();
    all.sort_by(f64::total_cmp);
    let steps = all.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0);
    let least = steps.fold(f64::INFINITY, f64::min);
    if least.is_finite() { least / 12f64.sqrt() } else { 0.0 }
}

/// Correlation of successive residuals; 0 for fewer than two.
pub(super) fn persistence(residuals: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = residuals.collect();
    let products: f64 = all.windows(2).map(|pair| pair[0] * pair[1]).sum();
    products / all.iter().map(|r| r * r).sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Correlation of residuals over several lags.
pub(super) struct Correlated {
    /// Sum of the squared correlations, less its mean for white noise: about the part of the
    /// variance that earlier residuals explain.
    pub share: f64,
    /// The same sum in standard deviations of its distribution for white noise.
    pub deviations: f64,
}

/// Largest number of lags, and smallest number of residuals for each lag.
const LAGS: (usize, usize) = (40, 4);

/// Correlation of residuals over up to [`LAGS`] lags: the portmanteau test of G. Ljung and G. Box,
/// Biometrika 65, 1978.
pub(super) fn correlated(residuals: &[f64]) -> Correlated {
    let n = residuals.len() as f64;
    let lags = LAGS.0.min(residuals.len() / LAGS.1);
    let squares = residuals.iter().map(|r| r * r).sum::<f64>().max(f64::MIN_POSITIVE);
    let of_lag = |lag: usize| {
        let products: f64 = residuals.iter().zip(&residuals[lag..]).map(|(a, b)| a * b).sum();
        (products / squares).powi(2) * (n + 2.0) / (n - lag as f64)
    };
    let mean = lags as f64 / n.max(1.0);
    let share = (1..=lags).map(of_lag).sum::<f64>() - mean;
    Correlated { share, deviations: share * n / (2.0 * lags.max(1) as f64).sqrt() }
}

/// Root mean square; 0 without residuals.
pub(super) fn rms(residuals: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = residuals.fold((0.0, 0usize), |(sum, count), r| (sum + r * r, count + 1));
    (sum / count.max(1) as f64).sqrt()
}

/// Standard deviation of normal residuals from the median of their sizes: the median is 0.6745
/// standard deviations, and few outliers do not move it.
pub(super) fn typical(residuals: impl Iterator<Item = f64>) -> f64 {
    let mut all: Vec<f64> = residuals.map(f64::abs).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).map_or(0.0, |median| median / 0.6745)
}

/// Standard deviation.
pub(super) fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    rms(values.iter().map(|x| x - mean))
}

/// Standard deviation of the values up to each index.
pub(super) fn deviations(values: &[f64]) -> Vec<f64> {
    let (mut mean, mut squares) = (0.0, 0.0);
    let so_far = |(i, x): (usize, &f64)| {
        let off = x - mean;
        mean += off / (i + 1) as f64;
        squares += off * (x - mean);
        f64::sqrt(squares / (i + 1) as f64)
    };
    values.iter().enumerate().map(so_far).collect()
}

/// Size of a column: its standard deviation; if it is constant, its magnitude; if it is 0, 1.
pub(super) fn size(values: &[f64]) -> f64 {
    let largest = values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let sizes = [deviation(values), largest, 1.0];
    sizes.into_iter().find(|size| *size > 0.0).unwrap_or(1.0)
}

/// Mean interval of increasing times; for a single time, the time itself.
pub(super) fn interval(times: &[f64]) -> f64 {
    match times {
        [first, .., last] => (last - first) / (times.len() - 1) as f64,
        [only] => *only,
        [] => 1.0,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Normal numbers of standard deviation 1, by Box and Muller from a linear congruential
    /// generator.
    pub(in crate::fit) fn normal(count: usize) -> Vec<f64> {
        let mut state = 7u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 11) as f64 + 0.5) / (1u64 << 53) as f64
        };
        (0..count).map(|_| (-2.0 * uniform().ln()).sqrt() * (TAU * uniform()).cos()).collect()
    }

    #[test]
    fn closed_form_noise_of_a_made_signal_is_the_noise_that_was_added() {
        let all = normal(4000);
        let slow = |i: usize| 5.0 * (TAU * i as f64 / 700.0).sin();
        let signal: Vec<f64> = all.iter().enumerate().map(|(i, x)| slow(i) + 0.3 * x).collect();
        // Six standard deviations of an estimate from 4000 samples.
        assert!((noise(&signal) / 0.3 - 1.0).abs() < 0.1, "{}", noise(&signal));
        assert!((noise(&all) - 1.0).abs() < 0.1, "{}", noise(&all));
        // Two values have no second difference, and all second differences of a straight line are
        // 0.
        assert_eq!(noise(&[1.0, 2.0]), 0.0);
        assert_eq!(noise(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]), 0.0);
    }

    #[test]
    fn closed_form_earlier_values_explain_the_part_of_the_variance_that_was_made_of_them() {
        let all = normal(8000);
        // White noise explains nothing: the statistic is a sum of 40 squares of normal numbers.
        let white = correlated(&all);
        assert!(white.share.abs() < 0.01 && white.deviations.abs() < 4.0, "{}", white.deviations);
        // xₖ = a xₖ₋₁ + noise has the correlation aᵏ over k lags; the squares sum to a²/(1 - a²).
        let a: f64 = 0.3;
        let mut last = 0.0;
        let made = all.iter().map(|x| {
            last = a * last + x;
            last
        });
        let found = correlated(&made.collect::<Vec<_>>());
        // A correlation from 8000 samples is known to 0.011. Its square is then off by at most
        // 2 × 0.3 × 4 × 0.011, for four standard deviations.
        assert!((found.share - a * a / (1.0 - a * a)).abs() < 0.03, "{}", found.share);
        assert!(found.deviations > 50.0);
        assert_eq!(correlated(&[]).share, 0.0);
    }

    #[test]
    fn second_method_deviations_are_those_of_each_part_of_the_values() {
        let all: Vec<f64> = normal(50).iter().map(|x| 3.0 + 0.1 * x).collect();
        for (i, own) in deviations(&all).into_iter().enumerate() {
            // Rounding of 50 squares of numbers of size 3.
            assert!((own - deviation(&all[..=i])).abs() < 1e-13, "{i}");
        }
    }

    #[test]
    fn closed_form_a_few_outliers_move_the_typical_size_little_and_a_sum_of_neighbours_follows() {
        let mut all = normal(4000);
        (0..40).for_each(|k| all[100 * k] = 1e3);
        let found = typical(all.iter().copied());
        assert!((found - 1.0).abs() < 0.06, "{found}");
        let own = normal(4000);
        assert!(persistence(own.iter().copied()).abs() < 0.06);
        // Sums of two neighbours share one of two numbers.
        let sums = persistence(own.windows(2).map(|pair| pair[0] + pair[1]));
        assert!((sums - 0.5).abs() < 0.06, "{sums}");
    }
}
