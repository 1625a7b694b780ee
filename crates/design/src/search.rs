//! Phases of a search: global, local, comparison of the best designs, attractors of the best.

use crate::comparison::{APART, finish};
use crate::descent::descend;
use crate::evaluation::{Control, Evaluation, Evaluator, Score, Stage};
use crate::evolution::{evolve, population};
use crate::outcome::Designed;
use crate::request::DesignRequest;
use rayon::prelude::*;
use vibro_studies::Result;
use vibro_studies::design_sweep::searched;
use vibro_studies::sobol::coordinate;

/// Fractions of the evaluations for the Sobol sequence and for evolution; the rest is for the
/// local searches and for evolution near the best design.
const SOBOL: f64 = 0.35;
const EVOLUTION: f64 = 0.4;
/// Largest number of local searches, one for each basin.
const BASINS: usize = 3;
/// Half width of the box around the best design for the last evolution, in the unit box.
const NEARBY: f64 = 0.08;

/// Searches for the design with the best goal that meets the limits. The result does not depend on
/// the number of threads, unless the search is cancelled.
///
/// # Errors
/// As [`DesignRequest::check`].
///
/// # Examples
/// An oscillator follows a force with the largest amplitude F/(cω) at k = mω²:
///
/// ```
/// use vibro_design::{Control, DesignRequest, Goal, design};
/// use vibro_studies::Machine;
/// use vibro_studies::design_sweep::ParameterInterval;
///
/// # let text = r#"
/// #     name = "Shaken"
/// #     body.a = { mass = 1.0 }
/// #     spring.k = { between = ["ground", "a"], stiffness = 12.0, damping = 1.25 }
/// #     load.f = { on = "a", amplitude = 26.0, frequency = "4 rad/s" }
/// # "#;
/// let machine = Machine::parse(text, "shaken.toml", &vibro_machine::file::no_records)?;
/// let goal = Goal { measure: "amplitude.a.s".parse()?, maximize: true };
/// let name = "spring.k.stiffness".to_owned();
/// let vary = vec![ParameterInterval { name, from: 10.0, to: 30.0 }];
/// let request = DesignRequest { evaluations: 40, ..DesignRequest::new(machine, goal, vary) };
/// let best = design(&request, &Control { go_on: &|| true, progress: &|_| () })?.best.unwrap();
/// assert!((best.values[0] - 16.0).abs() < 1e-3); // the peak is flat
/// assert!((best.goal.value - 26.0 / 5.0).abs() < 1e-7);
/// # Ok::<(), vibro_studies::Error>(())
/// ```
pub fn design(request: &DesignRequest, control: &Control) -> Result<Designed> {
    request.check()?;
    let evaluator = Evaluator::new(request, control);
    own(&evaluator);
    global(&evaluator);
    let (orbits, found) = local(&evaluator);
    finish(&evaluator, orbits, &found)
}

/// Evaluates the machine's own values if they lie in the ranges.
fn own(evaluator: &Evaluator) {
    let d = &evaluator.request.machine.description;
    let own = |name: &String| d.get(name).ok();
    let Some(values) = evaluator.request.names().iter().map(own).collect::<Option<Vec<f64>>>() else {
        return;
    };
    if evaluator.unit(&values).iter().all(|u| (0.0..=1.0).contains(u)) {
        evaluator.evaluate(values, Stage::Own);
    }
}

/// Points of the Sobol sequence, then evolution from the best of them.
fn global(evaluator: &Evaluator) {
    let (budget, numbers) = (f64::from(evaluator.request.evaluations), evaluator.request.vary.len());
    let first = evaluator.count();
    let count = ((SOBOL * budget) as u32).max(population(numbers) as u32);
    (0..count).into_par_iter().for_each(|k| {
        // The first point of the sequence is a corner.
        let unit: Vec<f64> = (0..numbers).map(|i| coordinate(k + 1, i)).collect();
        evaluator.evaluate(evaluator.values(&unit), Stage::Sobol);
    });
    evaluator.sort_from(first);
    let ranked = evaluator.ranked();
    let points = ranked.iter().take(population(numbers)).map(|own| (evaluator.unit(&own.values), own.score));
    let bounds = vec![[0.0, 1.0]; numbers];
    evolve(evaluator, bounds, points.collect(), ((EVOLUTION * budget) as usize, Stage::Evolution));
}

/// Local searches from the best designs of different basins. Unless the best result is a minimum
/// that meets the limits, evolution around the best design follows. Returns the number of orbits,
/// and the resulting designs.
fn local(evaluator: &Evaluator) -> (usize, Vec<Evaluation>) {
    let mut orbits = 0;
    let mut known: Vec<Vec<f64>> = Vec::new();
    let mut found: Vec<(Evaluation, bool)> = Vec::new();
    for begin in evaluator.apart(APART, BASINS) {
        let row = searched(&evaluator.candidate, &evaluator.sweep, begin.values.clone());
        let descended = descend(evaluator, (begin, row), &known);
        orbits += descended.orbits;
        known.push(evaluator.unit(&descended.found.values));
        let is_of_gradients = descended.is_stationary || descended.found.stage == Stage::Gradient;
        if descended.has_gradients && is_of_gradients {
            found.push((descended.found, descended.is_stationary));
        }
    }
    found.sort_by(|a, b| a.0.score.order(&b.0.score));
    let is_done = found.first().is_some_and(|(own, is_stationary)| *is_stationary && own.is_feasible());
    let left = (evaluator.request.evaluations as usize).saturating_sub(evaluator.count());
    if let Some(top) = evaluator.ranked().first().filter(|_| !is_done) {
        nearby(evaluator, &evaluator.unit(&top.values), left);
    }
    (orbits, found.into_iter().map(|own| own.0).collect())
}

/// Evolution in a small box around a point of the unit box.
fn nearby(evaluator: &Evaluator, middle: &[f64], budget: usize) {
    let bounds: Vec<[f64; 2]> =
        middle.iter().map(|u| [(u - NEARBY).max(0.0), (u + NEARBY).min(1.0)]).collect();
    let size = population(middle.len());
    if budget < 2 * size {
        return;
    }
    let first = evaluator.count();
    let fill = |k: u32| {
        let inside = bounds.iter().enumerate().map(|(i, own)| own[0] + coordinate(k, i) * (own[1] - own[0]));
        let unit: Vec<f64> = inside.collect();
        let score = evaluator.evaluate(evaluator.values(&unit), Stage::Nearby)?.0.score;
        Some((unit, score))
    };
    let mut points: Vec<(Vec<f64>, Score)> = (1..size as u32).into_par_iter().filter_map(fill).collect();
    evaluator.sort_from(first);
    points.extend(evaluator.ranked().first().map(|own| (evaluator.unit(&own.values), own.score)));
    evolve(evaluator, bounds, points, (budget - size, Stage::Nearby));
}
