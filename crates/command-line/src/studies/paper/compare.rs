//! Comparison of steady motion by theory with simulation (figures 8, 16, 17).

use super::lengths::Lengths;
use super::steady::{comparison_panel, four_panels};
use super::steady_motion::{MotionSample, SteadyMotion, simulated};
use super::sweep::overlay;
use crate::Result;
use crate::studies::diagram::maxima_table;
use crate::studies::{PANEL, Study};
use crate::table::{TextTable, exact};
use rayon::prelude::*;
use vibro_figures::canvas::palette::{BLOCK, BOX, CENTRE, SECONDARY};
use vibro_figures::chart::{Axis, Dash, Figure, Layer, Mark, Panel, Path, Shape, THIN};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::State;
use vibro_studies::diagram::diagram;
use vibro_studies::paper::attractor::{Attractor, observe};
use vibro_studies::paper::bifurcation::Sweep;
use vibro_studies::paper::maxima::Displacement;
use vibro_studies::paper::motion::{amplitude, record_flights, settled_simulator};
use vibro_studies::paper::plane::ParameterAxis;
use vibro_studies::paper::{ParameterSet, find_group, short};
use vibro_studies::parts::Task;

/// Product of ε and the number of drive periods after which a transient is below round-off, for
/// dampings of order one. A transient decays over a time of order 1/ε.
const SETTLING: f64 = 60.0;
/// Number of drive periods shown of a simulated steady motion.
pub(super) const SHOWN: u32 = 2;
/// Periods discarded and kept at each value of figure 16.
const DISCARDED: u32 = 400;
const KEPT: u32 = 200;
/// Names of the amplitudes compared.
const NAMES: [&str; 4] = ["B", "A1", "A2", "A3"];

/// A simulated steady motion.
pub(super) struct SimulatedMotion {
    /// Amplitudes B, A1, A2, A3 in units of L.
    pub(super) amplitudes: [f64; 4],
    /// Its record over [`SHOWN`] periods.
    pub(super) samples: Vec<MotionSample>,
    /// Its period, its impacts and its symmetry.
    motion: Attractor,
}

/// The simulated steady motion, from a start near the theory's motion.
pub(super) fn simulate(parameters: &Parameters, near: &SteadyMotion) -> Result<SimulatedMotion> {
    let p = parameters;
    let start = start(p, near);
    let mut simulator = settled_simulator(p, &start, (SETTLING * p.box_mass / p.block_mass).ceil())?;
    let flights = record_flights(&mut simulator, SHOWN)?;
    let epsilon = p.block_mass / p.box_mass;
    let q = [[1.0, epsilon, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let amplitudes = q.map(|q| amplitude(&flights, p, q) / p.stop_gap);
    Ok(SimulatedMotion { amplitudes, samples: simulated(&flights, p), motion: observe(&mut simulator)? })
}

/// Reason why the errors of a theory's amplitudes have no meaning: the theory's motion is
/// unstable, so that a simulation leaves it, or the simulated motion is of another kind. Otherwise
/// `None`.
pub(super) fn not_compared(theory: &SteadyMotion, simulated: &SimulatedMotion) -> Option<String> {
    let mut reasons = Vec::new();
    if !theory.is_stable() {
        reasons.push("theory unstable: its motion is unstable or not admissible".to_owned());
    }
    let m = &simulated.motion;
    let symmetric = m.is_symmetric();
    if !(m.period == Some(1) && m.impacts == [1.0; 2] && symmetric && !m.rests) {
        let period = m.period.map_or("without a period".into(), |n| format!("of period {n}T"));
        let all = short(m.impacts[0] + m.impacts[1]);
        let [upper, lower] = m.impacts.map(short);
        let symmetry = if symmetric { "symmetric" } else { "not symmetric" };
        let rests = if m.rests { ", with rest at a stop" } else { "" };
        reasons.push(format!(
            "another motion: the simulated one is {period}, has {all} impacts a period of the drive ({upper} upper, \
             {lower} lower) and is {symmetry}{rests}, while the theory's has 2 and is symmetric"
        ));
    }
    (!reasons.is_empty()).then(|| reasons.join("; "))
}

/// The theory's state at t = 0 in SI. The block is put between the stops: an approximation may
/// place it slightly beyond.
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

/// Table and description of the amplitudes by theory and simulation with the theory's errors. If
/// the motions are not comparable, the reason replaces the errors.
pub(super) fn amplitude_table(
    name: &str,
    analytical: [f64; 4],
    simulated: [f64; 4],
    not_compared: Option<&str>,
) -> (TextTable, Vec<String>) {
    let mut table = TextTable::new(&["amplitude", name, "simulation", "relative_error", "not_compared"]);
    let mut remarks: Vec<String> = not_compared.map(str::to_owned).into_iter().collect();
    for ((name, a), s) in NAMES.into_iter().zip(analytical).zip(simulated) {
        let error = a / s - 1.0;
        let (cell, percent) = match not_compared {
            Some(_) => (String::new(), String::new()),
            None => (exact(error), format!(", {:+.2} %", 100.0 * error)),
        };
        table.rows.push(vec![name.into(), exact(a), exact(s), cell, not_compared.unwrap_or_default().into()]);
        remarks.push(format!("{name}: {a:.6} by theory, {s:.6} simulated{percent}"));
    }
    (table, remarks)
}

/// The reason, as lines of a caption.
pub(super) fn caption_lines(not_compared: Option<&str>) -> Vec<String> {
    not_compared.iter().flat_map(|reason| reason.split("; ")).map(str::to_owned).collect()
}

/// Figure 8 and the simulation: time histories and phase portraits, and the amplitudes.
///
/// # Errors
/// The errors of theory and simulator.
pub fn histories(set: &ParameterSet) -> Result<Study> {
    let p = set.parameters();
    let Some(theory) = SteadyMotion::multiple_scales(set.groups())? else {
        return Ok(no_motion("compare-8", "multiple scales"));
    };
    let found = simulate(p, &theory)?;
    let reason = not_compared(&theory, &found);
    let (table, remarks) =
        amplitude_table("multiple_scales", theory.amplitudes(p), found.amplitudes, reason.as_deref());
    let mut figure = four_panels(
        "Multiple scales against simulation (cf. the paper's figure 8)",
        set,
        (&theory.history(p, f64::from(SHOWN)), "multiple scales"),
        (&found.samples, "simulation"),
    );
    figure.caption.splice(0..0, caption_lines(reason.as_deref()));
    let what = "time histories and phase portraits as in figure 8, multiple scales against simulation";
    Ok(Study::of("compare-8", what, &table, figure)?.with_remarks(remarks))
}

/// Figure 16: A2 over the excitation amplitude, by multiple scales and the exact orbit, over the
/// maxima of X2 of a sweep up and down.
///
/// # Errors
/// An error if the range is not valid; the errors of theory and simulator.
pub fn force_overlay(
    set: &ParameterSet,
    range: (f64, f64),
    count: usize,
    done: &(dyn Fn() + Sync),
) -> Result<Study> {
    let axis = ParameterAxis::new(find_group("f10")?, range, count)?;
    let sweep = Sweep::new(axis, Displacement::X2, (DISCARDED, KEPT));
    let found = diagram(set, &sweep, &Task { done: &|_| done(), ..Task::ALL })?;
    // All parts are computed here, so the diagram is complete.
    let Some(found) = found else { return Ok(no_motion("compare-16", "the sweep")) };
    let mut study = overlay(set, &sweep, &found, "compare-16")?;
    study.tables.push(("compare-16-maxima".into(), maxima_table(&sweep, &found)?));
    Ok(study)
}

/// One ε of figure 17: motions and amplitudes by theory and by simulation.
struct EpsilonComparison {
    epsilon: f64,
    theory: Vec<MotionSample>,
    simulation: Vec<MotionSample>,
    predicted: [f64; 4],
    simulated: [f64; 4],
    not_compared: Option<String>,
}

impl EpsilonComparison {
    /// Computes both motions; `None` if multiple scales has no motion.
    fn new(set: &ParameterSet, epsilon: f64) -> Result<Option<Self>> {
        let p = set.parameters();
        let Some(theory) = SteadyMotion::multiple_scales(set.groups())? else { return Ok(None) };
        let found = simulate(p, &theory)?;
        let not_compared = not_compared(&theory, &found);
        let (simulated, samples) = (found.amplitudes, found.samples);
        let simulation = samples.into_iter().filter(|s| s.time <= 1.0).collect();
        let (theory, predicted) = (theory.history(p, 1.0), theory.amplitudes(p));
        Ok(Some(Self { epsilon, theory, simulation, predicted, simulated, not_compared }))
    }

    /// Relative errors of B, A1, A2, A3; `None` if they have no meaning.
    fn errors(&self) -> Option<[f64; 4]> {
        self.not_compared.is_none().then(|| self.relative_errors())
    }

    fn relative_errors(&self) -> [f64; 4] {
        std::array::from_fn(|k| self.predicted[k] / self.simulated[k] - 1.0)
    }

    fn panel(&self, letter: char, lengths: &Lengths) -> Panel {
        let [u, w] = ["U", "W"].map(|s| lengths.displacement(s));
        let title = format!("({letter}) {u} and {w}, ε = {}", short(self.epsilon));
        let theory = (&self.theory[..], "multiple scales");
        comparison_panel(&title, lengths, (&[0, 1], false), theory, (&self.simulation, "simulation"))
    }
}

/// Figure 17: U and W for some ε, and the errors of the amplitudes over ε with their slopes.
///
/// # Errors
/// An error if a value of ε is not valid; the errors of theory and simulator.
pub fn accuracy(set: &ParameterSet, epsilons: &[f64]) -> Result<Study> {
    let group = find_group("epsilon")?;
    let run = |&epsilon: &f64| EpsilonComparison::new(&set.with(group, epsilon)?, epsilon);
    let runs = epsilons.par_iter().map(run).collect::<Result<Vec<_>>>()?;
    let runs: Vec<_> = runs.into_iter().flatten().collect();
    if runs.is_empty() {
        return Ok(no_motion("compare-17", "multiple scales"));
    }
    let mut shown = vec![0, runs.len() / 2, runs.len() - 1];
    shown.dedup();
    let lengths = Lengths::of(set);
    let mut panels: Vec<_> =
        ('a'..).zip(&shown).map(|(letter, &i)| runs[i].panel(letter, &lengths)).collect();
    let (panel, slopes) = error_panel(char::from(b'a' + shown.len() as u8), &runs);
    // Without a comparable ε there is nothing to draw.
    if !panel.layers.is_empty() {
        panels.push(panel);
    }
    let mut caption = vec!["Errors are relative to the simulation; ε differs between the panels.".into()];
    let apart: Vec<_> = runs.iter().filter(|r| r.not_compared.is_some()).map(|r| short(r.epsilon)).collect();
    if !apart.is_empty() {
        let values = apart.join(", ");
        caption.push(format!("No errors at ε = {values}: theory unstable or another motion, see the table."));
    }
    caption.push(set.caption_but(&[group.into()]));
    let figure = Figure {
        title: "Accuracy of multiple scales (cf. the paper's figure 17)".into(),
        caption,
        panels,
        columns: 2,
        panel: PANEL,
        shared_legend: true,
    };
    let what = "U and W for some ε and the amplitudes' errors over ε as in figure 17, multiple scales against simulation";
    Ok(Study::of("compare-17", what, &error_table(&runs), figure)?.with_remarks(slopes))
}

fn error_table(runs: &[EpsilonComparison]) -> TextTable {
    let columns = ["epsilon", "amplitude", "multiple_scales", "simulation", "relative_error", "not_compared"];
    let mut table = TextTable::new(&columns);
    for run in runs {
        let errors = run.errors();
        for (k, name) in NAMES.into_iter().enumerate() {
            let [predicted, simulated] = [run.predicted[k], run.simulated[k]].map(exact);
            let error = errors.map_or(String::new(), |e| exact(e[k]));
            let reason = run.not_compared.clone().unwrap_or_default();
            table.rows.push(vec![exact(run.epsilon), name.into(), predicted, simulated, error, reason]);
        }
    }
    table
}

/// Panel of the errors over ε in per cent, and their slopes in words.
fn error_panel(letter: char, runs: &[EpsilonComparison]) -> (Panel, Vec<String>) {
    let percent = |k: usize| -> Path {
        runs.iter().filter_map(|r| Some((r.epsilon, 100.0 * r.errors()?[k].abs()))).collect()
    };
    let errors: [Path; 4] = std::array::from_fn(percent);
    let names = ["B, centre of mass", "A₁, box", "A₂, block", "A₃, secondary"];
    let marks = [Mark::Disc, Mark::Square, Mark::Triangle, Mark::Ring];
    let reason =
        |r: &EpsilonComparison| Some(format!("epsilon = {}: {}", short(r.epsilon), r.not_compared.as_ref()?));
    let (mut layers, mut remarks) = (Vec::new(), runs.iter().filter_map(reason).collect::<Vec<_>>());
    for (k, path) in errors.iter().enumerate() {
        if path.is_empty() {
            continue;
        }
        // A slope needs two values.
        let slope = (path.len() > 1).then(|| slope(path));
        let rises = slope.map_or(String::new(), |slope| format!(", slope {slope:.3} in the logarithms"));
        remarks.push(format!(
            "error of {}: {:.2} % at the largest epsilon{}",
            NAMES[k],
            path.iter().fold((0.0, 0.0), |m, p| if p.0 > m.0 { *p } else { m }).1,
            rises
        ));
        let colour = [CENTRE, BOX, BLOCK, SECONDARY][k];
        let name = slope.map_or(names[k].into(), |slope| format!("{}, slope {slope:.2}", names[k]));
        layers.push(Layer::marks(&name, colour, marks[k], path.clone()));
        layers.push(Layer::line("", colour, Dash::Solid, path.clone()).stroke(THIN));
    }
    let title = format!("({letter}) Errors of the amplitudes");
    let (x, y) = (Axis::log("ε (–)"), Axis::log("relative error (%)"));
    let panel = match runs {
        [one] if !layers.is_empty() => single_panel(format!("{title}, ε = {}", short(one.epsilon)), layers),
        _ => Panel { title, x, y, layers },
    };
    (panel, remarks)
}

/// Errors at a single ε, side by side on a linear axis from zero.
fn single_panel(title: String, mut layers: Vec<Layer>) -> Panel {
    layers.retain(|layer| layer.name.is_some());
    let mut highest = 0.0_f64;
    for (place, layer) in (1..).map(f64::from).zip(&mut layers) {
        if let Shape::Marks { points, .. } = &mut layer.shape {
            points.iter_mut().for_each(|p| p.0 = place);
            highest = points.iter().fold(highest, |h, p| h.max(p.1));
        }
    }
    let names = ["B", "A₁", "A₂", "A₃"].map(String::from).to_vec();
    let x = Axis { names, ..Axis::over("amplitude", 0.5, 4.5) };
    let layers = layers.into_iter().map(|layer| layer.stroke(18)).collect();
    Panel { title, x, y: Axis::over("relative error (%)", 0.0, 1.1 * highest), layers }
}

/// Least-squares slope of the logarithms.
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
