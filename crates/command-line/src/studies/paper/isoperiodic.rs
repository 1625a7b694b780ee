//! Planes of the paper's machine: impacts at both stops, and comparison with the exact orbit.

use crate::studies::here;
use crate::studies::isoperiodic::{ClassifiedMotion, ShownPlane, number, percent, word};
use std::borrow::Cow;
use vibro_figures::canvas::palette::HERE;
use vibro_figures::chart::{Colour, Dash, LINE, Layer, Panel, Path, THIN};
use vibro_studies::paper::ParameterSet;
use vibro_studies::paper::isoperiodic::{Agreement, Isoperiodic, IsoperiodicRequest, PlanePoint};
use vibro_studies::paper::plane::SteadyStateClass;

impl ShownPlane for ParameterSet {
    const ONE_PERIOD: &str = "1T, others";
    const CONTACTS: &str = "Impacts per drive period";
    const COLUMNS: &[&str] = &[
        "class",
        "impacts_upper",
        "impacts_lower",
        "rests",
        "symmetric",
        "lambda1",
        "lambda1_error",
        "exact_orbit",
        "on_exact_orbit",
    ];

    fn motion(point: &PlanePoint) -> Option<ClassifiedMotion> {
        let motion = point.motion?;
        Some(ClassifiedMotion {
            class: motion.class,
            contacts: motion.impacts[0] + motion.impacts[1],
            rests: motion.rests,
            is_two_impact: motion.is_two_impact(),
        })
    }

    fn cells(point: &PlanePoint) -> Vec<Cow<'static, str>> {
        const EMPTY: Cow<str> = Cow::Borrowed("");
        let theory = point.theory.name().into();
        let Some(m) = &point.motion else {
            return vec!["refused".into(), EMPTY, EMPTY, EMPTY, EMPTY, EMPTY, EMPTY, theory, EMPTY];
        };
        let [upper, lower] = m.impacts.map(number);
        let [lambda, error] = m.exponent.map_or([EMPTY; 2], |e| e.map(number));
        let class = m.class.name().into();
        vec![class, upper, lower, word(m.rests), word(m.symmetric), lambda, error, theory, word(m.on_orbit)]
    }

    fn exponents_in_words(periods: u32) -> String {
        format!(" Exponents where there are impacts and no period, over at most {periods} periods.")
    }

    fn over(&self, request: &IsoperiodicRequest, plane: &Isoperiodic) -> Vec<Layer> {
        let border = border(request, plane);
        let edge = |name, colour| Layer::lines(name, colour, Dash::Solid, border.clone());
        let mut layers = vec![
            edge("", Colour(255, 255, 255)).stroke(LINE + 2 * THIN),
            edge("limit of the stable exact orbit", HERE),
        ];
        layers.extend(here(self, request.x.name, request.y.name));
        layers
    }

    fn more(&self, _: &IsoperiodicRequest, _: &Isoperiodic) -> Vec<Panel> {
        Vec::new()
    }

    fn remarks(plane: &Isoperiodic) -> Vec<String> {
        let Agreement { stable, reached, two_impact, predicted } = plane.agreement();
        let mut lines = vec![
            format!(
                "the exact orbit is stable at {stable} points; at {reached} of them ({:.1} %) the motion settles on it",
                percent(reached, stable)
            ),
            format!(
                "{two_impact} motions are symmetric with two impacts a period and without rest; {predicted} of them ({:.1} %) are the stable exact orbit",
                percent(predicted, two_impact)
            ),
        ];
        let resting = plane.points.iter().filter(|p| p.motion.is_some_and(|m| m.rests)).count();
        if resting > 0 {
            lines.push(format!("in {resting} motions the block rests at a stop"));
        }
        lines
    }
}

/// The limit of the points where the exact orbit is stable, along the edges of their cells.
fn border(request: &IsoperiodicRequest, plane: &Isoperiodic) -> Vec<Path> {
    let (columns, rows) = (request.x.count, request.y.count);
    let stable = |i: usize, j: usize| plane.points[j * columns + i].theory == SteadyStateClass::Stable;
    let part = |(from, to): (f64, f64), i: usize, count: usize| from + (to - from) * i as f64 / count as f64;
    let at = |i: usize, j: usize| (part(request.x.edges(), i, columns), part(request.y.edges(), j, rows));
    let across = (1..rows).flat_map(|j| {
        let edges = (0..columns).filter(move |&i| stable(i, j - 1) != stable(i, j));
        edges.map(move |i| vec![at(i, j), at(i + 1, j)])
    });
    let up = (1..columns).flat_map(|i| {
        let edges = (0..rows).filter(move |&j| stable(i - 1, j) != stable(i, j));
        edges.map(move |j| vec![at(i, j), at(i, j + 1)])
    });
    across.chain(up).collect()
}
