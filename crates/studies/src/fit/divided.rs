//! Test of a fitted motion against its own segments.
//!
//! A segment that begins in free states fits the noise of a record, too: the cost then falls by
//! about one variance for each free state. At a wrong minimum with residuals as small as noise, the
//! cost falls farther. This is the likelihood ratio test (S. Wilks, Annals of Mathematical
//! Statistics 9, 1938).

use super::bounds::Bounds;
use super::errors::{is_white, persistence};
use super::evaluated::{Evaluated, NEXT_RECORD, Solved};
use super::joint::Joint;
use super::loss::Loss;
use super::problem::Problem;
use super::segments;
use super::solver::{Convergence, solve};
use super::ties::give_up;
use crate::error::Result;

/// Standard deviations of a normal distribution. Above `SUSPECT`, the search continues from the
/// segments: one right minimum in 44 exceeds it. Above `WRONG`, the minimum is not certain: one
/// right minimum in 4000 exceeds it.
const SUSPECT: f64 = 2.0;
const WRONG: f64 = 3.5;
/// Factors of the ties between segments before segments are joined. The best one differs from
/// record to record.
const TIGHTER: [f64; 3] = [3.0, 10.0, 30.0];

/// Segments of a fitted motion at their least cost.
pub(super) struct Divided {
    found: Solved,
    /// Decrease of the cost against the single motion, as the normal deviation that is exceeded as
    /// often.
    deviations: f64,
}

/// Normal deviation that is exceeded as often as a sum of `count` squares of normal numbers
/// exceeds `sum` (E. Wilson and M. Hilferty, Proceedings of the National Academy of Sciences 17,
/// 1931).
fn normal(sum: f64, count: usize) -> f64 {
    let part = 2.0 / (9.0 * count as f64);
    ((sum / count as f64).max(0.0).cbrt() - 1.0 + part) / part.sqrt()
}

/// Variance of slow noise relative to the variance of all noise, for residuals whose correlation
/// decreases as its powers; at least 1, and 1 for white residuals. States follow slow noise.
fn slow(at: &Evaluated) -> f64 {
    let all: Vec<f64> = at.residuals().collect();
    let own = persistence(at, &all);
    if is_white(own, all.len()) { 1.0 } else { ((1.0 + own) / (1.0 - own)).max(1.0) }
}

impl Divided {
    /// Segments of the best motion; `None` if their cost tells nothing about it: without growth of
    /// small changes there is one segment, and with outliers or rounding the cost is not a sum of
    /// squares of normal numbers.
    pub fn of(
        joint: &Joint,
        bounds: &Bounds,
        best: &Solved,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Self>> {
        let is_tested = best.reach.is_whole()
            && joint.has_stops()
            && joint.loss() == Loss::Linear
            && !joint.is_of_contacts()
            && go_on()
            && joint.is_noisy(&best.point, &best.reach)?
            && joint.fits(&best.point, &best.reach)?;
        if !is_tested {
            return Ok(None);
        }
        let one = |(k, model)| segments::divided(model, &joint.values_of(k, &best.point.values));
        let all = joint.models.iter().enumerate().map(one).collect::<Result<Vec<_>>>()?;
        let begin = joint.together(&all, best.point.values.clone());
        let states = begin.point.states.iter().map(Vec::len).sum();
        if states == 0 {
            return Ok(None);
        }
        let found = solve(joint, bounds, &begin.point, (&begin.reach, Convergence::Whole), go_on)?;
        let at = joint.evaluate(&best.point, &best.reach)?;
        let variance = joint.variance(best.cost, best.point.values.len()) * slow(&at);
        let deviations = normal((best.cost - found.cost) / variance, states);
        Ok(Some(Self { found, deviations }))
    }

    /// Whether another minimum may be better than the single motion.
    pub fn is_suspect(&self) -> bool {
        self.deviations > SUSPECT
    }

    /// Reason why the single motion is not certain.
    pub fn doubt(&self, bounds: &Bounds) -> Option<String> {
        let told = || {
            format!(
                "segments of the motion fit better than chance permits, with {}",
                bounds.told(&self.found.point.values)
            )
        };
        (self.deviations > WRONG).then(told)
    }

    /// The best single motion that joining segments gives. First the ties tighten. Then every
    /// second segment continues the previous one, until one segment is left.
    pub fn joined(
        &self,
        joint: &Joint,
        bounds: &Bounds,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Solved>> {
        let mut all = Vec::new();
        for factor in TIGHTER {
            let mut own = self.found.clone();
            own.reach.weights.iter_mut().for_each(|weight| *weight *= factor);
            loop {
                own = solve(joint, bounds, &own.point, (&own.reach, Convergence::Rough), go_on)?;
                if own.reach.is_whole() || !go_on() {
                    break;
                }
                keep_every_second(&mut own);
            }
            all.extend(own.reach.is_whole().then_some(own));
        }
        Ok(all.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost)))
    }
}

/// Removes the first node of each pair of a record's nodes, with the state there.
fn keep_every_second(own: &mut Solved) {
    let nodes = own.reach.nodes.clone();
    let mut is_first = false;
    give_up(&mut own.point, &mut own.reach, |k| {
        is_first = nodes[k] != NEXT_RECORD && !is_first;
        is_first
    });
}

#[cfg(test)]
mod tests {
    use super::super::evaluated::{Point, Reach};
    use super::super::statistics::tests::normal as noise;
    use super::super::{FitRequest, Free, Measured, Segments};
    use super::*;
    use crate::{Machine, Start};
    use vibro_machine::file::no_records;

    #[test]
    fn closed_form_half_of_all_sums_of_squares_exceed_their_median() {
        // Medians and upper 2.275 % points (two standard deviations) of χ², from tables.
        for (count, median, upper) in [(4, 3.3567, 11.365), (56, 55.335, 79.098)] {
            // The approximation is that accurate.
            assert!(normal(median, count).abs() < 0.01, "{}", normal(median, count));
            assert!((normal(upper, count) - 2.0).abs() < 0.05, "{}", normal(upper, count));
        }
    }

    /// Ball on a driven table, with noise of 1 mm on 800 samples.
    fn bouncing(noise: &[f64]) -> FitRequest {
        let text = "name = \"Ball\"\ngravity = 9.81\nbody.ball = { mass = 1.0, gravity = 1.0 }\n\
                    body.table = { motion = { amplitude = 0.01, frequency = 5.0 } }\n\
                    stop.floor = { between = [\"table\", \"ball\"], gap = 0.1, restitution = 0.8 }\n";
        let machine = Machine::parse(text, "ball.toml", &no_records).unwrap();
        let assembly =
            std::sync::Arc::new(vibro_machine::Assembly::new(machine.description.clone()).unwrap());
        let mut motion = vibro_machine::Motion::new(assembly).unwrap();
        let times: Vec<f64> = (0..800).map(|i| 0.005 * f64::from(i)).collect();
        let name: crate::QuantityName = "ball.s".parse().unwrap();
        let place = name.find(&machine.description).unwrap().quantity;
        let measured = |(time, noise): (&f64, &f64)| {
            motion.advance_to(*time).unwrap();
            motion.value(place) + 1e-3 * noise
        };
        let values = times.iter().zip(noise).map(measured).collect();
        let free = |name: &str| Free { name: name.into(), within: None, is_own: false };
        FitRequest {
            name: String::new(),
            machine,
            start: Start::default(),
            measured: Measured { times, columns: vec![(name, values)], contacts: Vec::new() },
            free: vec![free("stop.floor.restitution"), free("stop.floor.gap")],
            sigma: None,
            filters: Vec::new(),
            loss: Loss::Linear,
            segments: Segments::Auto,
            starts: 0,
        }
    }

    #[test]
    fn second_method_segments_exclude_a_wrong_motion_with_residuals_like_noise_and_lead_to_the_right_one() {
        let requests = [bouncing(&noise(800))];
        let joint = Joint::new(&requests).unwrap();
        let bounds = joint.bounds(&requests).unwrap();
        let begin = joint.single(bounds.begin.clone());
        let best =
            solve(&joint, &bounds, &begin.point, (&begin.reach, Convergence::Whole), &|| true).unwrap();
        let right = Divided::of(&joint, &bounds, &best, &|| true).unwrap().unwrap();
        assert!(!right.is_suspect() && right.doubt(&bounds).is_none(), "{}", right.deviations);
        // Some seven standard errors.
        let mut wrong = best.clone();
        wrong.point.values[0] += 1.6e-4;
        wrong.cost = joint.cost(&wrong).unwrap();
        let found = Divided::of(&joint, &bounds, &wrong, &|| true).unwrap().unwrap();
        assert!(found.is_suspect() && found.doubt(&bounds).is_some(), "{}", found.deviations);
        let joined = found.joined(&joint, &bounds, &|| true).unwrap().unwrap();
        // A rough descent ends with steps of 1e-5.
        assert!(joined.cost < best.cost * (1.0 + 1e-5), "{} {}", joined.cost, best.cost);
    }

    #[test]
    fn closed_form_slow_noise_of_correlated_residuals_has_a_larger_variance() {
        // xₖ = a xₖ₋₁ + noise has the spectral density (1 + a)/(1 - a) at 0, relative to its
        // variance.
        let a: f64 = 0.3;
        let mut last = 0.0;
        let correlated = noise(800).into_iter().map(|x| {
            last = a * last + x;
            last
        });
        let of = |noise: &[f64]| {
            let requests = [bouncing(noise)];
            let joint = Joint::new(&requests).unwrap();
            let truth = joint.single(joint.bounds(&requests).unwrap().begin);
            slow(&joint.evaluate(&truth.point, &truth.reach).unwrap())
        };
        // The correlation of 800 residuals is known to 0.035; three times that moves the ratio by
        // 0.45.
        let found = of(&correlated.collect::<Vec<_>>());
        assert!((found - (1.0 + a) / (1.0 - a)).abs() < 0.45, "{found}");
        assert_eq!(of(&noise(800)), 1.0);
    }

    #[test]
    fn invariant_segments_of_each_record_are_joined_in_pairs_until_one_is_left() {
        let nodes = vec![1.0, 2.0, 3.0, NEXT_RECORD, 1.0, NEXT_RECORD];
        let states = nodes.iter().map(|node| vec![*node]).collect();
        let mut own = Solved {
            point: Point { values: vec![], states },
            reach: Reach { nodes, ..Reach::whole(4.0) },
            cost: 0.0,
            is_continuous: false,
        };
        keep_every_second(&mut own);
        assert_eq!(own.reach.nodes, [2.0, NEXT_RECORD, NEXT_RECORD]);
        assert_eq!(own.point.states, [[2.0], [NEXT_RECORD], [NEXT_RECORD]]);
        keep_every_second(&mut own);
        assert!(own.reach.is_whole());
    }
}
