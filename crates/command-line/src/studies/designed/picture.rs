//! Picture of a design search: the goal over the evaluations, and over the varied parameters.

use crate::studies::design_sweep::Labelled;
use crate::wording::{self, axis};
use vibro_design::{DesignRequest, Designed, Evaluation, Stage};
use vibro_figures::canvas::palette::{BLUE, GREY, ORANGE, PURPLE, VERMILLION};
use vibro_figures::chart::{Axis, Colour, Dash, Figure, Layer, Mark, Panel, Path, lettered};

/// Largest number of panels over varied parameters.
const NUMBERS: usize = 5;
/// When minimising, designs up to this multiple of the best goal are drawn; worse ones would hide
/// the differences.
const WORST: f64 = 6.0;

const STAGES: [(Stage, Colour, Mark); 5] = [
    (Stage::Own, PURPLE, Mark::Diamond),
    (Stage::Sobol, GREY, Mark::Disc),
    (Stage::Evolution, BLUE, Mark::Disc),
    (Stage::Gradient, VERMILLION, Mark::Triangle),
    (Stage::Nearby, ORANGE, Mark::Disc),
];

/// The picture; `None` if no design has a value.
pub fn figure(request: &DesignRequest, found: &Designed) -> Option<Figure> {
    let machine = &request.machine;
    let goal = |own: &Evaluation| own.goal.map(|goal| goal.value);
    let all: Vec<(usize, &Evaluation, f64)> =
        found.evaluations.iter().enumerate().filter_map(|(i, own)| Some((i + 1, own, goal(own)?))).collect();
    let best =
        all.iter().map(|own| own.2).reduce(|a, b| if request.goal.maximize { a.max(b) } else { a.min(b) })?;
    let is_drawn = |value: f64| request.goal.maximize || value <= WORST * best.abs().max(f64::MIN_POSITIVE);
    let drawn = || all.iter().filter(|own| is_drawn(own.2));
    let size = drawn().fold(0.0, |most: f64, own| most.max(own.2.abs()));
    let unit = request.goal.measure.unit(&machine.description);
    let words = wording::measure(&machine.description, &request.goal.measure);
    let y = || axis(&words, unit, size);
    let marks = |x: &dyn Fn(usize, &Evaluation) -> f64| -> Vec<Layer> {
        let one = |(stage, colour, mark): (Stage, Colour, Mark)| {
            let own = drawn().filter(|(_, own, _)| own.stage == stage);
            let points: Path = own.map(|(i, own, goal)| (x(*i, own), *goal)).collect();
            (!points.is_empty()).then(|| Layer::marks(stage.words(), colour, mark, points).stroke(8))
        };
        STAGES.into_iter().filter_map(one).collect()
    };
    let mut layers = marks(&|i, _| i as f64);
    let mut so_far: Path = Vec::new();
    for (i, own, value) in &all {
        let last = so_far.last().map(|own| own.1);
        let is_better = |last: f64| if request.goal.maximize { *value > last } else { *value < last };
        if own.is_feasible() && last.is_none_or(is_better) {
            so_far.extend(last.map(|last| (*i as f64, last)));
            so_far.push((*i as f64, *value));
        }
    }
    if let Some((_, last)) = so_far.last().copied() {
        so_far.push((found.evaluations.len() as f64, last));
        layers.push(Layer::line("best within the limits so far", VERMILLION, Dash::Solid, so_far));
    }
    let x = Axis::counts("evaluation");
    let mut panels = vec![Panel { title: String::new(), x, y: y(), layers }];
    for (k, own) in request.vary.iter().enumerate().take(NUMBERS) {
        let x = Axis { range: Some((own.from, own.to)), ..machine.axis(&own.name) };
        panels.push(Panel { title: String::new(), x, y: y(), layers: marks(&|_, own| own.values[k]) });
    }
    lettered(&mut panels);
    Some(Figure {
        title: format!("{}: design by {words}", wording::title(&machine.description.name)),
        caption: vec![format!("verdict: {}", found.verdict)],
        columns: panels.len().min(2),
        panels,
        panel: (1500, 900),
        shared_legend: true,
    })
}
