//! Monotone piecewise cubic interpolation.

/// Slopes at the samples, by F. N. Fritsch and J. Butland (SIAM J. Sci. Stat. Comput. 5 (1984)
/// 300–304): the harmonic mean of the adjacent chords, weighted by their lengths, and zero if the
/// chords differ in sign; at the ends the three-point formula, limited so that the cubic stays
/// monotone. Two samples give a straight line.
pub fn monotone_slopes(samples: &[(f64, f64)]) -> Vec<f64> {
    let steps: Vec<(f64, f64)> = samples
        .windows(2)
        .map(|pair| (pair[1].0 - pair[0].0, (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0)))
        .collect();
    let last = steps.len() - 1;
    if last == 0 {
        return vec![steps[0].1; 2];
    }
    let mut slopes = vec![end_slope(steps[0], steps[1])];
    for pair in steps.windows(2) {
        let ((h0, c0), (h1, c1)) = (pair[0], pair[1]);
        let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
        let agree = c0 * c1 > 0.0 || (c0 != 0.0 && c1 != 0.0 && (c0 > 0.0) == (c1 > 0.0));
        slopes.push(if agree { (w0 + w1) / (w0 / c0 + w1 / c1) } else { 0.0 });
    }
    slopes.push(end_slope(steps[last], steps[last - 1]));
    slopes
}

/// Slope at an end, from the step there and the next one inwards, each with its length and chord:
/// the slope of the parabola through the three samples, but zero if it differs in sign from the
/// chord at the end, and at most three times this chord if the two chords differ in sign.
fn end_slope((h0, c0): (f64, f64), (h1, c1): (f64, f64)) -> f64 {
    let slope = c0 + (c0 - c1) * (h0 / (h0 + h1));
    if slope * c0 <= 0.0 {
        0.0
    } else if c0 * c1 <= 0.0 && slope.abs() > 3.0 * c0.abs() {
        3.0 * c0
    } else {
        slope
    }
}
