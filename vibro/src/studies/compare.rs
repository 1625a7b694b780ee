//! SteadyMotion against simulation (figures 8, 16, 17).

use super::steady::{comparison_panel, four_panels};
use super::steady_motion::{MotionSample, SteadyMotion, simulated};
use super::sweep::{maxima_table, overlay};
use super::{PANEL, Study};
use crate::Result;
use crate::figures::canvas::palette::{BLOCK, BOX, CENTRE, SECONDARY};
use crate::figures::chart::{Axis, Dash, Figure, Layer, Mark, Panel, Path, THIN};
use crate::table::{Table, exact};
use rayon::prelude::*;
use vibro_analysis::bifurcation::{Sweep, diagram};
use vibro_analysis::motion::{amplitude, record_flights, settled_simulator};
use vibro_analysis::parts::Task;
use vibro_analysis::plane::ParameterAxis;
use vibro_analysis::{ParameterSet, find_group, short};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::State;

/// A transient decays over a time of order 1/ε: this number of periods divided by ε brings it under round-off for dampings of
/// order one.
const SETTLING: f64 = 60.0;
/// Periods shown of a simulated steady motion.
pub(super) const SHOWN: u32 = 2;
/// Figure 16: periods discarded and kept at each value.
const DISCARDED: u32 = 400;
const KEPT: u32 = 200;
/// Names of the amplitudes compared.
const NAMES: [&str; 4] = ["B", "A1", "A2", "A3"];

/// The simulated steady motion from a start near the theory's: amplitudes B, A1, A2, A3 in units of L, and its record.
pub(super) fn simulate(
    parameters: &Parameters,
    near: &SteadyMotion,
) -> Result<([f64; 4], Vec<MotionSample>)> {
    let p = parameters;
    let start = start(p, near);
    let mut simulator = settled_simulator(p, &start, (SETTLING * p.box_mass / p.block_mass).ceil())?;
    let flights = record_flights(&mut simulator, SHOWN)?;
    let epsilon = p.block_mass / p.box_mass;
    let q = [[1.0, epsilon, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let amplitudes = q.map(|q| amplitude(&flights, p, q) / p.stop_gap);
    Ok((amplitudes, simulated(&flights, p)))
}

/// The theory's state at t = 0 in SI, with the block put between the stops, which an approximation may pass a little.
fn start(p: &Parameters, theory: &SteadyMotion) -> State {
    let at = theory.history(p, 1.0);
    let first = at.first().map_or(([0.0; 5], [0.0; 5]), |a| (a.x, a.v));
    let (length, speed) = (p.stop_gap, p.stop_gap * p.box_frequency());
    let [_, _, x1, x2, x3] = first.0.map(|x| x * length);
    let [_, _, v1, v2, v3] = first.1.map(|v| v * speed);
    let room = 0.999 * length;
    State { x: [x1, x1 + (x2 - x1).clamp(-room, room), x3], v: [v1, v2, v3] }
}

pub(super) fn no_motion(name: &str, theory: &str) -> Study {
    Study::without_figure(name, format!("no picture: {theory} has no motion with two symmetric impacts here"))
}

pub(super) fn amplitude_table(
    theory: &str,
    analytical: [f64; 4],
    simulated: [f64; 4],
) -> (Table, Vec<String>) {
    let mut table = Table::new(&["amplitude", theory, "simulation", "relative_error"]);
    let mut remarks = Vec::new();
    for ((name, a), s) in NAMES.into_iter().zip(analytical).zip(simulated) {
        let error = a / s - 1.0;
        table.rows.push(vec![name.into(), exact(a), exact(s), exact(error)]);
        remarks.push(format!("{name}: {a:.6} by theory, {s:.6} simulated, {:+.2} %", 100.0 * error));
    }
    (table, remarks)
}

/// Figure 8 against the simulation: time histories and phase portraits, and the amplitudes.
///
/// # Errors
/// What theory or simulator refuse.
pub fn histories(set: &ParameterSet) -> Result<Study> {
    let p = set.parameters();
    let Some(theory) = SteadyMotion::multiple_scales(set.groups())? else {
        return Ok(no_motion("compare-8", "multiple scales"));
    };
    let (amplitudes, points) = simulate(p, &theory)?;
    let (table, remarks) = amplitude_table("multiple_scales", theory.amplitudes(p), amplitudes);
    let figure = four_panels(
        "Multiple scales against simulation (cf. figure 8)",
        set,
        (&theory.history(p, f64::from(SHOWN)), "multiple scales"),
        (&points, "simulation"),
    );
    let what = "time histories and phase portraits as in figure 8, multiple scales against simulation";
    Ok(Study::of("compare-8", what, &table, figure)?.with_remarks(remarks))
}

/// Figure 16: A2 over the excitation amplitude, by multiple scales and the exact orbit, over the maxima of X2 of a sweep
/// up and down.
///
/// # Errors
/// Ranges that are not allowed; what theory or simulator refuse.
pub fn force_overlay(
    set: &ParameterSet,
    range: (f64, f64),
    count: usize,
    done: &(dyn Fn() + Sync),
) -> Result<Study> {
    let axis = ParameterAxis::new(find_group("f10")?, range, count)?;
    let sweep = Sweep { axis, discard: DISCARDED, keep: KEPT, exponents: None };
    let found = diagram(set, &sweep, &Task { done: &|_| done(), ..Task::ALL })?;
    // All parts are made here.
    let Some(found) = found else { return Ok(no_motion("compare-16", "the sweep")) };
    let mut study = overlay(set, &sweep, &found, "compare-16")?;
    study.tables.push(("compare-16-maxima".into(), maxima_table(&axis, &found)?));
    Ok(study)
}

/// One ε of figure 17: both motions over a period, both sets of amplitudes.
struct Run {
    epsilon: f64,
    theory: Vec<MotionSample>,
    simulation: Vec<MotionSample>,
    predicted: [f64; 4],
    simulated: [f64; 4],
}

impl Run {
    /// `None` where multiple scales has no motion.
    fn new(set: &ParameterSet, epsilon: f64) -> Result<Option<Self>> {
        let p = set.parameters();
        let Some(theory) = SteadyMotion::multiple_scales(set.groups())? else { return Ok(None) };
        let (simulated, samples) = simulate(p, &theory)?;
        let simulation = samples.into_iter().filter(|s| s.time <= 1.0).collect();
        let (theory, predicted) = (theory.history(p, 1.0), theory.amplitudes(p));
        Ok(Some(Self { epsilon, theory, simulation, predicted, simulated }))
    }

    /// Relative errors of B, A1, A2, A3.
    fn errors(&self) -> [f64; 4] {
        std::array::from_fn(|k| self.predicted[k] / self.simulated[k] - 1.0)
    }

    fn panel(&self, letter: char) -> Panel {
        let title = format!("({letter}) U and W, ε = {}", short(self.epsilon));
        let theory = (&self.theory[..], "multiple scales");
        comparison_panel(&title, &[0, 1], false, theory, (&self.simulation, "simulation"))
    }
}

/// Figure 17: U and W for some ε, and the errors of the amplitudes over ε with their slopes.
///
/// # Errors
/// Values of ε that are not allowed; what theory or simulator refuse.
pub fn accuracy(set: &ParameterSet, epsilons: &[f64]) -> Result<Study> {
    let group = find_group("epsilon")?;
    let run = |&epsilon: &f64| Run::new(&set.with(group, epsilon)?, epsilon);
    let runs = epsilons.par_iter().map(run).collect::<Result<Vec<_>>>()?;
    let runs: Vec<_> = runs.into_iter().flatten().collect();
    if runs.is_empty() {
        return Ok(no_motion("compare-17", "multiple scales"));
    }
    let mut shown = vec![0, runs.len() / 2, runs.len() - 1];
    shown.dedup();
    let mut panels: Vec<_> = ('a'..).zip(&shown).map(|(letter, &i)| runs[i].panel(letter)).collect();
    let (panel, slopes) = error_panel(char::from(b'a' + shown.len() as u8), &runs);
    panels.push(panel);
    let figure = Figure {
        title: "Accuracy of multiple scales (cf. figure 17)".into(),
        caption: vec![
            "Errors are relative to the simulation; ε differs between the panels.".into(),
            set.caption(),
        ],
        panels,
        columns: 2,
        panel: PANEL,
        shared_legend: true,
    };
    let what = "U and W for some ε and the amplitudes' errors over ε as in figure 17, multiple scales against simulation";
    Ok(Study::of("compare-17", what, &error_table(&runs), figure)?.with_remarks(slopes))
}

fn error_table(runs: &[Run]) -> Table {
    let mut table = Table::new(&["epsilon", "amplitude", "multiple_scales", "simulation", "relative_error"]);
    for run in runs {
        let errors = run.errors();
        for (k, name) in NAMES.into_iter().enumerate() {
            let numbers = [run.predicted[k], run.simulated[k], errors[k]].map(exact);
            table.rows.push([vec![exact(run.epsilon), name.into()], numbers.to_vec()].concat());
        }
    }
    table
}

/// The errors over ε in per cent, and in words their slopes.
fn error_panel(letter: char, runs: &[Run]) -> (Panel, Vec<String>) {
    let percent =
        |k: usize| -> Path { runs.iter().map(|r| (r.epsilon, 100.0 * r.errors()[k].abs())).collect() };
    let errors: [Path; 4] = std::array::from_fn(percent);
    let symbols = ["B", "A₁", "A₂", "A₃"];
    let marks = [Mark::Disc, Mark::Square, Mark::Triangle, Mark::Ring];
    let (mut layers, mut remarks) = (Vec::new(), Vec::new());
    for (k, path) in errors.iter().enumerate() {
        let slope = slope(path);
        remarks.push(format!(
            "error of {}: {:.2} % at the largest epsilon, slope {slope:.3} in the logarithms",
            NAMES[k],
            path.iter().fold((0.0, 0.0), |m, p| if p.0 > m.0 { *p } else { m }).1
        ));
        let colour = [CENTRE, BOX, BLOCK, SECONDARY][k];
        layers.push(Layer::marks(
            &format!("{}, slope {slope:.2}", symbols[k]),
            colour,
            marks[k],
            path.clone(),
        ));
        layers.push(Layer::line("", colour, Dash::Solid, path.clone()).stroke(THIN));
    }
    let panel = Panel {
        title: format!("({letter}) Errors of the amplitudes"),
        x: Axis::log("ε (–)"),
        y: Axis::log("relative error (%)"),
        layers,
    };
    (panel, remarks)
}

/// Least-squares slope in the logarithms.
fn slope(path: &Path) -> f64 {
    let logs: Vec<_> = path.iter().map(|p| (p.0.ln(), p.1.ln())).collect();
    let n = logs.len() as f64;
    let mean = logs.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
    let sums = logs.iter().fold((0.0, 0.0), |s, p| {
        let (x, y) = (p.0 - mean.0, p.1 - mean.1);
        (s.0 + x * y, s.1 + x * x)
    });
    sums.0 / sums.1
}
