//! Quadratic model of the worst value around a design: linear pieces and one curvature.
//!
//! Let d be the step in the unit box, t the worst goal and s the worst excess of a limit. The step
//! solves
//!
//! ```text
//! least t + ρ s + ½ dᵀ B d  with  f_i + g_i·d ≤ t,  c_j + h_j·d ≤ s,  s ≥ 0,  |d| ≤ half width
//! ```
//!
//! where f_i are peaks of the goal and c_j excesses of limited peaks. B is the curvature of the
//! Lagrangian by the formula of Broyden, Fletcher, Goldfarb and Shanno, with Powell's damping.

use nalgebra::{DMatrix, DVector};

/// Weight ρ of a limit's excess compared with the goal, both in their units.
pub(crate) const WEIGHT: f64 = 100.0;
/// Largest number of iterations of a quadratic problem; usually ten to twenty suffice.
const ITERATIONS: usize = 60;
/// Mean product of slack and multiplier at which a quadratic problem is solved; far below it,
/// rounding spoils the multipliers.
const GAP: f64 = 1e-16;
/// Tolerance for the residual, and for the mean product of slack and multiplier, of an accepted
/// solution when rounding ends the iteration.
const ACCEPTED: f64 = 1e-8;
/// Fraction of the distance to the nearest constraint that an iteration moves.
const INSIDE: f64 = 0.995;
/// Smallest fraction of the curvature along a step after an update (Powell).
const KEPT: f64 = 0.2;

/// A linear piece of the model: a peak at the design or at a nearby design.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Piece {
    /// Whether it belongs to the goal.
    pub is_goal: bool,
    /// Value at d = 0, in its unit; for a limit, the excess.
    pub value: f64,
    /// Derivatives in the unit box.
    pub gradient: Vec<f64>,
}

impl Piece {
    fn at(&self, d: &[f64]) -> f64 {
        self.value + dot(&self.gradient, d)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Worst goal plus the weighted worst excess of a limit, after a step.
pub(crate) fn merit(pieces: &[Piece], d: &[f64]) -> f64 {
    let most = |is_goal: bool| {
        let own = pieces.iter().filter(|own| own.is_goal == is_goal).map(|own| own.at(d));
        own.fold(f64::NEG_INFINITY, f64::max)
    };
    most(true) + WEIGHT * most(false).max(0.0)
}

/// Curvature of the Lagrangian.
#[derive(Clone, Debug)]
pub(crate) struct Curvature(Vec<Vec<f64>>);

impl Curvature {
    /// The identity matrix: a goal in its own unit curves by about as much over the unit box.
    pub fn unit(numbers: usize) -> Self {
        Self((0..numbers).map(|i| (0..numbers).map(|j| f64::from(u8::from(i == j))).collect()).collect())
    }

    fn times(&self, d: &[f64]) -> Vec<f64> {
        self.0.iter().map(|row| dot(row, d)).collect()
    }

    /// Updates the curvature with the change of the Lagrangian's gradient over a step.
    pub fn update(&mut self, step: &[f64], change: &[f64]) {
        let carried = self.times(step);
        let (own, found) = (dot(step, &carried), dot(step, change));
        if own <= 0.0 || !found.is_finite() {
            return;
        }
        let part = if found >= KEPT * own { 1.0 } else { (1.0 - KEPT) * own / (own - found) };
        let mixed: Vec<f64> = change.iter().zip(&carried).map(|(y, b)| part * y + (1.0 - part) * b).collect();
        let along = dot(step, &mixed);
        for (i, row) in self.0.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry += mixed[i] * mixed[j] / along - carried[i] * carried[j] / own;
            }
        }
    }
}

/// A step of the model, with the weights of its pieces in the Lagrangian. The goal's weights sum
/// to 1.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    pub d: Vec<f64>,
    pub weights: Vec<f64>,
}

/// The step that solves the problem within bounds around 0; `None` if none is found.
pub(crate) fn step(pieces: &[Piece], curvature: &Curvature, bounds: &[(f64, f64)]) -> Option<Step> {
    let (n, m) = (bounds.len(), pieces.len());
    // Unknowns: d in widths of the bounds, t, s. Rows: pieces, s ≥ 0, bounds.
    let width = |i: usize| bounds[i].1 - bounds[i].0;
    let mut hessian = DMatrix::zeros(n + 2, n + 2);
    for (i, row) in curvature.0.iter().enumerate() {
        row.iter().enumerate().for_each(|(j, x)| hessian[(i, j)] = x * width(i) * width(j));
    }
    let mut linear = DVector::zeros(n + 2);
    (linear[n], linear[n + 1]) = (1.0, WEIGHT);
    let (mut rows, mut most) = (DMatrix::zeros(m + 1 + 2 * n, n + 2), DVector::zeros(m + 1 + 2 * n));
    for (k, piece) in pieces.iter().enumerate() {
        piece.gradient.iter().enumerate().for_each(|(i, x)| rows[(k, i)] = x * width(i));
        rows[(k, if piece.is_goal { n } else { n + 1 })] = -1.0;
        most[k] = -piece.value;
    }
    rows[(m, n + 1)] = -1.0;
    for (i, (low, high)) in bounds.iter().enumerate() {
        let k = m + 1 + 2 * i;
        (rows[(k, i)], most[k]) = (-1.0, -low / width(i));
        (rows[(k + 1, i)], most[k + 1]) = (1.0, high / width(i));
    }
    // A feasible point: the middle of the bounds, with t and s above all pieces there.
    let middle: Vec<f64> = bounds.iter().map(|own| 0.5 * (own.0 + own.1)).collect();
    let worst = |is_goal: bool| {
        let own = pieces.iter().filter(|own| own.is_goal == is_goal).map(|own| own.at(&middle));
        own.fold(0.0, f64::max)
    };
    let mut begin: Vec<f64> = middle.iter().enumerate().map(|(i, x)| x / width(i)).collect();
    begin.extend([worst(true) + 1.0, worst(false) + 1.0]);
    let (x, duals) = interior_point(&hessian, &linear, (&rows, &most), DVector::from_vec(begin))?;
    let unscaled = (0..n).map(|i| (x[i] * width(i)).clamp(bounds[i].0, bounds[i].1));
    Some(Step { d: unscaled.collect(), weights: duals.iter().take(m).copied().collect() })
}

/// The minimum of ½ xᵀ H x + c·x with A x ≤ b, and its multipliers, from a feasible point: S.
/// Mehrotra's predictor and corrector (SIAM J. Optim. 2 (1992) 575–601), dense.
fn interior_point(
    hessian: &DMatrix<f64>,
    linear: &DVector<f64>,
    (rows, most): (&DMatrix<f64>, &DVector<f64>),
    mut x: DVector<f64>,
) -> Option<(DVector<f64>, DVector<f64>)> {
    let count = most.len();
    let mut slack = most - rows * &x;
    let mut duals = DVector::from_element(count, 1.0);
    // Beyond the accuracy permitted by rounding, the iteration degrades again.
    let mut best: Option<(f64, DVector<f64>, DVector<f64>)> = None;
    for _ in 0..ITERATIONS {
        let stationary = hessian * &x + linear + rows.tr_mul(&duals);
        let primal = rows * &x + &slack - most;
        let gap = slack.dot(&duals) / count as f64;
        let is_accepted = stationary.amax().max(primal.amax()) < ACCEPTED && gap < ACCEPTED;
        if is_accepted && best.as_ref().is_none_or(|own| gap < own.0) {
            best = Some((gap, x.clone(), duals.clone()));
        }
        if gap < GAP {
            break;
        }
        let ratio = duals.component_div(&slack);
        let scaled = DMatrix::from_fn(count, x.len(), |i, j| ratio[i] * rows[(i, j)]);
        let factors = (hessian + rows.tr_mul(&scaled)).lu();
        // The Newton step to slack × multiplier = `wanted`.
        let newton = |wanted: &DVector<f64>| {
            let rest =
                (wanted - slack.component_mul(&duals) + duals.component_mul(&primal)).component_div(&slack);
            let dx = factors.solve(&(-&stationary - rows.tr_mul(&rest)))?;
            let d_slack = -&primal - rows * &dx;
            let d_duals =
                (wanted - slack.component_mul(&duals) - duals.component_mul(&d_slack)).component_div(&slack);
            Some((dx, d_slack, d_duals))
        };
        let longest = |of: &DVector<f64>, by: &DVector<f64>| {
            let ends = of.iter().zip(by.iter()).filter(|own| *own.1 < 0.0).map(|(x, dx)| -x / dx);
            ends.fold(1.0, f64::min)
        };
        let Some((_, d_slack, d_duals)) = newton(&DVector::zeros(count)) else { break };
        let part = longest(&slack, &d_slack).min(longest(&duals, &d_duals));
        let after = (&slack + &d_slack * part).dot(&(&duals + &d_duals * part)) / count as f64;
        let centre = DVector::from_element(count, gap * (after / gap).powi(3));
        let corrected = centre - d_slack.component_mul(&d_duals);
        let Some((dx, d_slack, d_duals)) = newton(&corrected) else { break };
        let part = INSIDE * longest(&slack, &d_slack).min(longest(&duals, &d_duals));
        let next = (&x + dx * part, &slack + d_slack * part, &duals + d_duals * part);
        // Rounding ends the iteration before its values become infinite or NaN.
        if !next.0.iter().chain(next.1.iter()).chain(next.2.iter()).all(|x| x.is_finite()) {
            break;
        }
        (x, slack, duals) = next;
    }
    best.map(|(_, x, duals)| (x, duals))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tolerance for solutions of small quadratic problems.
    const SOLVED: f64 = 1e-8;

    #[test]
    fn closed_form_the_step_to_the_kink_of_two_pieces_and_their_weights() {
        // The pieces ±(x - 0.1) + 0.4 y with the curvature (1, 4): minimum at x = 0.1, y = -0.1.
        let piece = |slope: f64| Piece { is_goal: true, value: -0.1 * slope, gradient: vec![slope, 0.4] };
        let pieces = [piece(1.0), piece(-1.0)];
        let mut curvature = Curvature::unit(2);
        curvature.update(&[0.0, 1.0], &[0.0, 4.0]);
        let bounds = [(-1.0, 1.0); 2];
        let found = step(&pieces, &curvature, &bounds).unwrap();
        // In y: 0.4 + 4 y = 0. In x the weights differ by 0.1, the slope of the curvature term.
        let Step { d, weights } = found;
        assert!((d[0] - 0.1).abs() < SOLVED && (d[1] + 0.1).abs() < SOLVED, "{d:?}");
        assert!((weights[0] - 0.45).abs() < SOLVED && (weights[1] - 0.55).abs() < SOLVED, "{weights:?}");
    }

    #[test]
    fn closed_form_a_limit_that_cannot_be_kept_is_passed_least() {
        // The limit x ≥ 2 within |x| ≤ 1, although the goal x is best at x = -1.
        let goal = Piece { is_goal: true, value: 0.0, gradient: vec![1.0] };
        let limit = Piece { is_goal: false, value: 2.0, gradient: vec![-1.0] };
        let found = step(&[goal, limit], &Curvature::unit(1), &[(-1.0, 1.0)]).unwrap();
        assert!((found.d[0] - 1.0).abs() < SOLVED, "{found:?}");
    }

    #[test]
    fn invariant_the_curvature_keeps_what_a_step_has_shown() {
        let mut curvature = Curvature::unit(3);
        let (step, change) = ([0.1, -0.2, 0.05], [0.3, -0.7, 0.2]);
        curvature.update(&step, &change);
        for (own, y) in curvature.times(&step).iter().zip(&change) {
            assert!((own - y).abs() < SOLVED, "{own} {y}");
        }
    }

    #[test]
    fn invariant_no_point_nearby_is_better_than_the_step_of_random_problems() {
        let mut seed = 1u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
        };
        for case in 0..300 {
            let (n, m) = (1 + case % 4, 1 + case % 7);
            let half = 0.2 * 0.3f64.powi(case as i32 % 11);
            let bounds: Vec<(f64, f64)> = (0..n).map(|_| (-half * random().abs(), half)).collect();
            let mut curvature = Curvature::unit(n);
            for _ in 0..3 {
                let step: Vec<f64> = (0..n).map(|_| random()).collect();
                let change: Vec<f64> = (0..n).map(|_| 10.0 * random()).collect();
                curvature.update(&step, &change);
            }
            let piece = |k: usize, x: &mut dyn FnMut() -> f64| Piece {
                is_goal: k == 0 || x() > 0.0,
                value: 1.0 + 0.1 * x(),
                gradient: (0..n).map(|_| 3.0 * x()).collect(),
            };
            let pieces: Vec<Piece> = (0..m).map(|k| piece(k, &mut random)).collect();
            let of = |d: &[f64]| merit(&pieces, d) + 0.5 * dot(d, &curvature.times(d));
            let found =
                step(&pieces, &curvature, &bounds).unwrap_or_else(|| panic!("{case} {pieces:?} {bounds:?}"));
            let own = of(&found.d);
            for _ in 0..50 {
                let d: Vec<f64> =
                    bounds.iter().map(|own| own.0 + (own.1 - own.0) * 0.5 * (1.0 + random())).collect();
                let near: Vec<f64> = found.d.iter().zip(&d).map(|(a, b)| a + 1e-3 * (b - a)).collect();
                for other in [d, near] {
                    assert!(of(&other) >= own - SOLVED, "{case}: {own} {} {found:?} {pieces:?}", of(&other));
                }
            }
            let sum: f64 =
                pieces.iter().zip(&found.weights).filter(|own| own.0.is_goal).map(|own| own.1).sum();
            assert!((sum - 1.0).abs() < SOLVED.sqrt(), "{case} {sum}");
        }
    }
}
