//! Global search: differential evolution in a box, from known designs.

use crate::evaluation::{Evaluator, Score, Stage};
use metaheuristics_nature as mh;
use mh::Strategy;

/// Seed of the random numbers: a search with the same request gives the same designs.
const SEED: u64 = 63;
/// Spread of a generation, as a fraction of its box, below which it has converged.
const CONVERGED: f64 = 1e-4;

/// Number of designs in a generation: four per varied parameter, to preserve several basins; at
/// least eight, to preserve differences between the designs.
pub(crate) fn population(numbers: usize) -> usize {
    (4 * numbers).clamp(8, 32)
}

/// The designs in a box, as objective of the crate `metaheuristics_nature`.
struct Designs<'a> {
    evaluator: &'a Evaluator<'a>,
    bounds: Vec<[f64; 2]>,
    stage: Stage,
}

impl mh::Bounded for Designs<'_> {
    fn bound(&self) -> &[[f64; 2]] {
        &self.bounds
    }
}

impl mh::ObjFunc for Designs<'_> {
    type Ys = Score;

    fn fitness(&self, unit: &[f64]) -> Score {
        let values = self.evaluator.values(unit);
        self.evaluator.evaluate(values, self.stage).map_or(Score::WORST, |(own, _)| own.score)
    }
}

/// Evolves designs in a box of the unit box with at most `budget` evaluations, from ranked points.
/// Does nothing with fewer than five points, or with a budget smaller than their number.
pub(crate) fn evolve(
    evaluator: &Evaluator,
    bounds: Vec<[f64; 2]>,
    points: Vec<(Vec<f64>, Score)>,
    (budget, stage): (usize, Stage),
) {
    let size = points.len();
    if size < 5 || budget < size {
        return;
    }
    let first = evaluator.count();
    let (pool, ranks) = points.into_iter().unzip();
    let widths: Vec<f64> = bounds.iter().map(|own| own[1] - own[0]).collect();
    let mut sorted = first;
    let over = |ctx: &mh::Ctx<Designs>| {
        evaluator.sort_from(sorted);
        sorted = evaluator.count();
        let spread = |i: usize| {
            let own = || ctx.pool.iter().map(|unit| unit[i]);
            own().fold(f64::NEG_INFINITY, f64::max) - own().fold(f64::INFINITY, f64::min)
        };
        let is_converged = widths.iter().enumerate().all(|(i, width)| spread(i) <= CONVERGED * width);
        is_converged || sorted - first + size > budget || !(evaluator.control.go_on)()
    };
    let designs = Designs { evaluator, bounds, stage };
    let strategy = mh::De::new().strategy(Strategy::C1F3);
    let solver = mh::Solver::build(strategy, designs).seed(SEED);
    // The evaluator records all designs.
    drop(solver.init_pool(mh::Pool::Ready { pool, pool_y: ranks }).task(over).solve());
}
