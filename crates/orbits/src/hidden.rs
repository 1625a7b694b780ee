//! Two zeros of a test within one step with the same sign at both ends.

use super::bifurcation::{Bracket, Test};
use super::position::{Examined, Position};
use super::step::Follower;
use vibro_numerics::sorting::sort_by;

/// Fraction of the test's smallest value at the ends below which its predicted extremum may hide a
/// pair of zeros; half of the value allows for an error of the parabola.
const DIP: f64 = 0.5;
/// Cap on the tried positions. Each improves the parabola.
const LOOKS: usize = 3;
/// Smallest distance of a new position from known ones, as a fraction of the step.
const APART: f64 = 1e-3;

impl Follower<'_> {
    /// Two brackets of a test with the same sign at both ends of a step. The parabola through an
    /// earlier position and both ends predicts an extremum of the other sign, and the test
    /// confirms it. Otherwise empty, also if a position within the step cannot be found.
    pub fn hidden(
        &self,
        test: Test,
        (earlier, before): &(Position<Examined>, f64),
        [last, next]: [&Position<Examined>; 2],
        arc: f64,
    ) -> Vec<Bracket> {
        let of = |at: &Position<Examined>| test.of(at, last);
        let ends = [of(last), of(next)];
        let least = ends[0].abs().min(ends[1].abs());
        // Arc and value of three positions.
        let mut known = [(-before, of(earlier)), (0.0, ends[0]), (arc, ends[1])];
        if known.iter().any(|(_, value)| value * ends[0] <= 0.0) {
            return Vec::new();
        }
        for _ in 0..LOOKS {
            let Some((at, value)) = extremum(&known) else { break };
            let is_apart = known.iter().all(|(own, _)| (own - at).abs() > APART * arc);
            let dips = value * ends[0].signum() < DIP * least;
            if !((0.0..arc).contains(&at) && is_apart && dips) {
                break;
            }
            let Ok(middle) = self.within(last, next, arc, at).and_then(|at| self.look(at)) else { break };
            let value = of(&middle);
            if value * ends[0] < 0.0 {
                let rest = middle.tangent.dot(&(&next.u - &middle.u));
                let first = Bracket { begin: 0.0, ends: [last.clone(), middle.clone()], arc: at };
                return vec![first, Bracket { begin: at, ends: [middle, next.clone()], arc: rest }];
            }
            // The two nearest positions and the new one.
            sort_by(&mut known, |a, b| (a.0 - at).abs().total_cmp(&(b.0 - at).abs()));
            known[2] = (at, value);
        }
        Vec::new()
    }
}

/// The extremum of the parabola through three points; `None` if they are on a line.
pub(super) fn extremum(points: &[(f64, f64); 3]) -> Option<(f64, f64)> {
    let [(a, fa), (b, fb), (c, fc)] = *points;
    let (slope, other) = ((fb - fa) / (b - a), (fc - fb) / (c - b));
    let bend = (other - slope) / (c - a);
    let at = 0.5 * (a + b) - 0.5 * slope / bend;
    let value = fa + (at - a) * (slope + bend * (at - b));
    value.is_finite().then_some((at, value))
}
