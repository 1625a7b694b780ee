//! Parameters that would reduce the residuals of a fit that is not accepted: element parameters
//! that are not free, and dry friction that the machine does not have.
//!
//! A score test selects the candidates (C. R. Rao, Proc. Cambridge Phil. Soc. 44, 1948). It
//! projects the residuals on a candidate's column of the Jacobian, orthogonalised against the free
//! parameters. Each candidate is then fitted together with the free parameters.

use super::bounds::Bounds;
use super::elimination::Triangle;
use super::evaluated::{Evaluated, Point, Reach, Solved};
use super::horizons::over_horizons;
use super::loss::Loss;
use super::model::Model;
use super::solver::{Convergence, solve};
use super::{FitRequest, Free, WAYS};
use crate::Machine;
use crate::error::Result;
use nalgebra::DVector;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use vibro_machine::description::{Arms, Description, Friction, Signal};

/// Caps on the fitted candidates and on the reported suspects.
const TRIED: usize = 4;
const TOLD: usize = 3;
/// Smallest reduction of the sum of squares by a suspect: less may be chance or a kink.
const LEAST: f64 = 0.2;
/// Largest number of steps over growing horizons with a candidate.
const STEPS: u32 = 60;
/// Largest number of events of a motion with a candidate: this number, plus this multiple of the
/// fitted motion's contacts. A body of almost no mass has ten thousands of contacts, which take
/// minutes and explain no record.
const EVENTS: (usize, usize) = (1000, 20);
/// Linear reduction above which a candidate is fitted.
const PROMISING: f64 = 0.02;
/// Sections of the machine's file whose parameters are candidates.
const SECTIONS: [&str; 6] = ["body.", "spring.", "damper.", "stop.", "friction.", "load."];
/// Parts of names of parameters that are not candidates: starts, shares of gravity, levers.
const NOT: [&str; 3] = [".start", ".gravity", ".arms"];

/// A parameter that is not free and would reduce the residuals.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspect {
    /// Name of the parameter, or a description of friction that the machine does not have.
    pub name: String,
    /// SI unit; `1` for a dimensionless parameter.
    pub unit: &'static str,
    /// Value in the machine, SI.
    pub value: f64,
    /// Value that fits best together with the free parameters, SI.
    pub better: f64,
    /// Ratio of the root mean square residuals with this value and without it.
    pub left: f64,
}

/// Friction that the machine does not have, with its description.
struct Added {
    friction: Friction,
    words: String,
}

impl Added {
    /// Frictions of 0 N between bodies that are joined by a spring or stop, but not by friction.
    fn of(d: &Description) -> Vec<Self> {
        let bodies = |arms: &Arms| {
            let mut bodies: Vec<usize> = arms.terms.iter().map(|(body, _)| *body).collect();
            bodies.sort_unstable();
            bodies
        };
        let mut joined: Vec<Vec<usize>> = d.frictions.iter().map(|own| bodies(&own.arms)).collect();
        let mut found: Vec<Self> = Vec::new();
        let springs = d.springs.iter().map(|own| &own.arms);
        for arms in springs.chain(d.stops.iter().map(|own| &own.arms)).filter(|arms| !arms.levers) {
            if joined.contains(&bodies(arms)) {
                continue;
            }
            joined.push(bodies(arms));
            let body = |sign: f64| {
                let term = arms.terms.iter().find(|(_, arm)| *arm == sign);
                term.map_or("ground", |(body, _)| &*d.bodies[*body].name)
            };
            let words = format!("friction between {} and {}", body(-1.0), body(1.0));
            let mut name = format!("added{}", found.len());
            while d.elements().any(|own| own.name() == name) {
                name.push('_');
            }
            let force = Signal::constant(0.0);
            let friction = Friction {
                name,
                arms: arms.clone(),
                force,
                static_force: None,
                follows: None,
                stribeck: None,
                viscous: None,
            };
            found.push(Self { friction, words });
        }
        found
    }

    /// Name of the friction's force as a parameter.
    fn parameter(&self) -> String {
        format!("friction.{}.force", self.friction.name)
    }
}

/// Linear reduction of the sum of squares by each column after the first `free` ones, as a
/// fraction, and the corresponding change.
fn scores(at: &Evaluated, free: usize, count: usize) -> Option<Vec<(f64, f64)>> {
    let triangle = Triangle::of(at, Loss::Linear, &Point::default(), 0.0, &vec![false; count]);
    let jacobian = triangle.reduced(at, count)?;
    let residuals = DVector::from_iterator(jacobian.nrows(), at.residuals());
    let basis = jacobian.columns(0, free).into_owned().qr().q();
    let squares = residuals.norm_squared().max(f64::MIN_POSITIVE);
    let score = |j: usize| {
        let column = jacobian.column(j).into_owned();
        let own = &column - &basis * basis.tr_mul(&column);
        let length = own.norm_squared();
        let product = own.dot(&residuals);
        if length > 0.0 { (product.powi(2) / (length * squares), -product / length) } else { (0.0, 0.0) }
    };
    Some((free..count).map(score).collect())
}

impl Model<'_> {
    /// Parameters that would reduce the residuals at a point, the best one first.
    pub(super) fn suspects(
        &self,
        request: &FitRequest,
        (point, reach): (&Point, &Reach),
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<Suspect>> {
        let mut machine = self.unknowns.with(&point.values)?.machine;
        let added = Added::of(&machine.description);
        machine.description.frictions.extend(added.iter().map(|own| own.friction.clone()));
        let names = candidates(&machine.description, &request.free);
        let all = self.with_free(request, &machine, &names);
        let model = self.like(&all)?;
        let mut values = point.values.clone();
        values.extend(&model.unknowns.begin[point.values.len()..]);
        let count = values.len();
        let wide = Point { values, states: point.states.clone() };
        let at = model.evaluate(&wide, reach)?;
        let Some(scores) = scores(&at, point.values.len(), count) else { return Ok(Vec::new()) };
        let mut order: Vec<usize> = (0..names.len()).filter(|&k| scores[k].0 > PROMISING).collect();
        order.sort_by(|&a, &b| scores[b].0.total_cmp(&scores[a].0));
        order.truncate(TRIED);
        // Residuals that the free numbers of this record alone take up say nothing of a suspect.
        let alone = self.with_free(request, &machine, &[]);
        let refit = self.like(&alone)?;
        let own = Bounds::of(&alone, &refit)?;
        let refit = solve(&refit, &own, point, (reach, Convergence::Rough), go_on).map(|own| own.cost);
        let (own, cost) = (point.clone(), f64::INFINITY);
        let now = Solved { point: own, reach: reach.clone(), cost, is_continuous: true };
        let before = self.cost(&now)?.min(refit.unwrap_or(f64::INFINITY));
        let most_events = EVENTS.0 + EVENTS.1 * self.beside(point, reach)?.events().count();
        let one = |k: &usize| -> Option<Suspect> {
            let one = self.with_free(request, &machine, &names[*k..=*k]);
            let model = self.like(&one).ok()?.with_most_events(most_events);
            let value = *model.unknowns.begin.last()?;
            let bounds = Bounds::of(&one, &model).ok()?;
            let changed = value + scores[*k].1;
            let from = |value: f64| {
                let values = bounds.cut([&point.values[..], &[value]].concat());
                let begin = Point { values, states: point.states.clone() };
                solve(&model, &bounds, &begin, (reach, Convergence::Rough), go_on).ok()
            };
            // The free parameters begin again too: without the candidate they may have moved far.
            let left = AtomicU32::new(STEPS);
            let take = |left: u32| left.checked_sub(1);
            let goes_on = || left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, take).is_ok() && go_on();
            let grown = || {
                let begin = bounds.cut([&self.unknowns.begin[..], &[changed]].concat());
                let found = over_horizons(&model, &bounds, &begin, WAYS[0], &goes_on).ok()?;
                // An early end leaves the cost over the last horizon.
                Some(Solved { cost: model.cost(&found).ok()?, ..found })
            };
            let grown = reach.nodes.is_empty().then(grown).flatten();
            let found = [value, changed].into_iter().filter_map(from).chain(grown);
            let found = found.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
            let better = *found.point.values.last()?;
            let left = (found.cost / before).sqrt();
            let own = added.iter().find(|own| own.parameter() == names[*k]);
            let name = own.map_or(&names[*k], |own| &own.words).clone();
            let unit = machine.description.parameter(&names[*k]).ok()?.unit;
            (better != value && 1.0 - left * left > LEAST).then_some(Suspect {
                name,
                unit,
                value,
                better,
                left,
            })
        };
        let mut found: Vec<Suspect> = order.par_iter().filter_map(one).collect();
        found.sort_by(|a, b| a.left.total_cmp(&b.left));
        found.truncate(TOLD);
        Ok(found)
    }

    /// Request with additional free parameters, from a fitted machine.
    fn with_free(&self, request: &FitRequest, machine: &Machine, names: &[String]) -> FitRequest {
        let mut own = FitRequest { machine: machine.clone(), ..request.clone() };
        let free = |name: &String| Free { name: name.clone(), within: None, is_own: false };
        own.free.iter_mut().for_each(|own| own.within = None);
        own.free.extend(names.iter().map(free));
        own
    }

    /// Model of another request of the same record, with the same weights.
    fn like<'r>(&self, request: &'r FitRequest) -> Result<Model<'r>> {
        Ok(Model::new(request)?.weighed_as(self))
    }

    /// The model with motions of at most `most` events.
    fn with_most_events(mut self, most: usize) -> Self {
        // A model that was just made shares its record with no other.
        if let Some(compared) = Arc::get_mut(&mut self.compared) {
            compared.most_events = most;
        }
        self
    }
}

/// Names of the candidates: element parameters that are not free, including added frictions.
fn candidates(d: &Description, free: &[Free]) -> Vec<String> {
    let is_free = |name: &str| free.iter().any(|own| own.name == name);
    let is_named = |name: &str| {
        SECTIONS.iter().any(|section| name.starts_with(section))
            && !NOT.iter().any(|part| name.contains(part))
    };
    let all = d.parameters().into_iter().map(|own| own.name);
    all.filter(|name| is_named(name) && !is_free(name)).collect()
}
