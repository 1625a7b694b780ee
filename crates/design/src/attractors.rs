//! Other motions of a design: coexisting attractors at the place of its worst value.

use crate::candidate::of_machine;
use crate::evaluation::{Evaluator, Value};
use crate::request::DesignRequest;
use rayon::prelude::*;
use std::sync::Arc;
use vibro_machine::elements::Action;
use vibro_machine::{Assembly, Start};
use vibro_studies::design_sweep::{BARS, DesignMachine};
use vibro_studies::sobol::{DIMENSIONS, coordinate};
use vibro_studies::{Machine, Measure, Measured, MotionClass};

/// Number of further starts for finding attractors, besides the request's starts.
const STARTS: usize = 16;
/// Half width of the box of starts, in amplitudes of the settled motion.
const WIDER: f64 = 1.5;
/// Largest number of attempts per valid start between the stops.
const ATTEMPTS: u32 = 16;
/// Relative tolerance for the measures of motions of one class that are on one attractor.
const SAME: f64 = 1e-3;

/// An attractor of the best design.
#[derive(Clone, Debug, PartialEq)]
pub struct Attractor {
    /// Class of its motions.
    pub class: MotionClass,
    /// Impacts and first contacts of all stops per return.
    pub impacts: f64,
    /// The goal on it.
    pub goal: Value,
    /// Number of starts in its basin.
    pub starts: usize,
    /// One of these starts.
    pub start: Start,
    /// Whether a start of the request leads to it.
    pub is_requested: bool,
    /// Whether the goal is worse than the design's value, beyond both error bars.
    pub is_worse: bool,
}

/// The measures of the motion from a start; `None` without a motion, or if it has not settled.
fn measured(
    machine: &Machine,
    request: &DesignRequest,
    measures: &[Measure],
    start: &Start,
) -> Option<Measured> {
    let returns = (request.discard, request.periods);
    let sweep = of_machine(vec![start.clone()], returns, measures.to_vec());
    let (found, objection) = machine.outcomes(&sweep).into_iter().next()?;
    objection.is_none().then_some(found)
}

/// Starts around the settled motion of the request's first start, between the stops.
fn spread(machine: &Machine, request: &DesignRequest) -> Vec<Start> {
    let Ok(assembly) = Assembly::new(machine.description.clone()) else { return Vec::new() };
    let own = request.starts.first().cloned().unwrap_or_default();
    let names =
        Start::names(&assembly).into_iter().filter(|name| name.ends_with(".s") || name.ends_with(".v"));
    let sized: Vec<(String, Measure)> =
        names.filter_map(|name| Some((name.clone(), format!("amplitude.{name}").parse().ok()?))).collect();
    let measures: Vec<Measure> = sized.iter().map(|own| own.1.clone()).collect();
    let Some(sizes) = measured(machine, request, &measures, &own) else { return Vec::new() };
    let assembly = Arc::new(assembly);
    let start = |k: u32| {
        let mut start = own.clone();
        for (i, ((name, _), size)) in sized.iter().zip(&sizes.numbers).enumerate() {
            let x = WIDER * size.unwrap_or(0.0) * (2.0 * coordinate(k, i % DIMENSIONS) - 1.0);
            start.set(&machine.description, name, x).ok()?;
        }
        start.motion(assembly.clone()).ok()?;
        Some(start)
    };
    (1..=ATTEMPTS * STARTS as u32).filter_map(start).take(STARTS).collect()
}

/// The attractors of a machine reached from the request's starts and from further starts; the
/// request's come first.
pub(crate) fn attractors(evaluator: &Evaluator, machine: &Machine, worst: Value) -> Vec<Attractor> {
    let request = evaluator.request;
    let measures = [request.goal.measure.clone(), Measure::Impacts(None), Measure::Class];
    let mut starts = request.starts.clone();
    // A linear machine has one attractor.
    let is_linear =
        |action| matches!(action, Action::Linear | Action::Flexing | Action::Tying | Action::Driving);
    if !machine.description.elements().all(|element| is_linear(element.action())) {
        starts.extend(spread(machine, request));
    }
    let found: Vec<_> = starts
        .into_par_iter()
        .map(|start| {
            let own = (evaluator.control.go_on)().then(|| measured(machine, request, &measures, &start));
            (start, own.flatten())
        })
        .collect();
    let sign = evaluator.sweep.measures[0].sign();
    let mut all: Vec<Attractor> = Vec::new();
    for (index, (start, own)) in found.into_iter().enumerate() {
        let is_requested = index < request.starts.len();
        let Some(own) = own else { continue };
        let (Some(class), Some(&[Some(value), Some(impacts)])) = (own.class, own.numbers.first_chunk())
        else {
            continue;
        };
        let half = BARS * own.spreads.first().copied().unwrap_or(0.0);
        let apart = |other: &Attractor| (other.goal.value - value).abs();
        let near = |other: &Attractor| (half + other.goal.error()).max(SAME * value.abs());
        match all.iter_mut().find(|other| other.class == class && apart(other) <= near(other)) {
            Some(other) => other.starts += 1,
            None => {
                let goal = Value {
                    value,
                    bar: (value - half, value + half),
                    is_exact: half <= SAME * SAME * value.abs(),
                };
                let bar = (half + worst.error()).max(SAME * worst.value.abs());
                let is_worse = sign * (value - worst.value) > bar;
                all.push(Attractor { class, impacts, goal, starts: 1, start, is_requested, is_worse });
            }
        }
    }
    all
}
