//! Simulated motions: time histories (figure 13), phase portraits (figure 15), running exponents.

use super::lengths::Lengths;
use super::steady_motion::{MotionSample, simulated};
use crate::Result;
use crate::studies::{PANEL, Study};
use crate::table::{TextTable, exact};
use rayon::prelude::*;
use vibro_figures::canvas::palette::{BLOCK, BOX, FAMILY, RELATIVE, SECONDARY};
use vibro_figures::chart::{Axis, Colour, Dash, Figure, Layer, Panel, Path, THIN};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Simulator, State};
use vibro_studies::paper::bifurcation::{Diagram, SweepPoint};
use vibro_studies::paper::lyapunov::{Convergence, SpectrumOptions, dimensionless};
use vibro_studies::paper::motion::{Flight, record_flights, settled_simulator};
use vibro_studies::paper::stroboscopic::{StroboscopicState, dimensional, moving_block};
use vibro_studies::paper::{Name, ParameterSet, short};

/// Drive periods discarded before a history begins.
const TRANSIENT: f64 = 400.0;
/// Number of drive periods shown of a steady motion.
const STEADY: u32 = 4;
/// Number of drive periods shown of a modulated motion.
const MODULATED: u32 = 50;
/// Drive periods in a portrait of a motion without a period.
const WANDERING: u32 = 60;
/// Symbols of the seven exponents.
const EXPONENTS: [&str; 7] = ["λ₁", "λ₂", "λ₃", "λ₄", "λ₅", "λ₆", "λ₇"];

/// Quantities of histories and portraits, W, X1 and X3, by their indices in [`MotionSample`].
const SHOWN: [DrawnQuantity; 3] = [(1, "W", RELATIVE), (2, "X₁", BOX), (4, "X₃", SECONDARY)];

/// Modulation of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modulation {
    /// Largest and smallest |X1| within a period, over all periods shown.
    pub box_amplitude: (f64, f64),
    /// Largest and smallest |X3| within a period, over all periods shown.
    pub secondary_amplitude: (f64, f64),
    /// Share of the periods with one impact at each stop.
    pub resonant: f64,
}

fn modulation(points: &[MotionSample], flights: &[Flight], periods: u32) -> Modulation {
    let first = points.first().map_or(0.0, |p| p.time);
    let mut tops = vec![[0.0f64; 2]; periods as usize];
    for p in points {
        if let Some(top) = tops.get_mut((p.time - first).max(0.0) as usize) {
            *top = [top[0].max(p.x[2].abs()), top[1].max(p.x[4].abs())];
        }
    }
    let range = |i: usize| {
        let all = tops.iter().map(|t| t[i]);
        all.fold((0.0f64, f64::INFINITY), |(most, least), t| (most.max(t), least.min(t)))
    };
    // An impact is where one flight ends and the next begins.
    let mut counts = vec![[0u32; 2]; periods as usize];
    for flight in &flights[..flights.len().saturating_sub(1)] {
        if let Some(i) = flight.last()
            && let Some(count) = counts.get_mut(i.time as usize)
        {
            count[usize::from(i.state.x[1] > i.state.x[0])] += 1;
        }
    }
    let resonant = counts.iter().filter(|c| **c == [1, 1]).count() as f64 / f64::from(periods);
    Modulation { box_amplitude: range(0), secondary_amplitude: range(1), resonant }
}

/// Figure 13: histories and portraits at the parameter set's own f10 and at `other`.
///
/// # Errors
/// The errors of the simulator.
pub fn histories_of(set: &ParameterSet, name: Name, other: f64) -> Result<(Study, Modulation)> {
    let mut table = TextTable::new(&[name.name(), "time", "W", "X1", "X2", "X3", "dW", "dX1", "dX2", "dX3"]);
    let mut panels = Vec::new();
    let mut found = None;
    let (own, lengths) = (name.value(set), Lengths::of(set));
    for (value, periods, letters) in [(own, STEADY, "abc"), (other, MODULATED, "def")] {
        let p = *set.with(name, value)?.parameters();
        let mut simulator = settled_simulator(&p, &moving_block(&p), TRANSIENT)?;
        let flights = record_flights(&mut simulator, periods)?;
        let points = simulated(&flights, &p);
        let first = points.first().map_or(0.0, |p| p.time);
        for i in &points {
            let mut row = vec![exact(value), exact(i.time - first)];
            row.extend([i.x[1], i.x[2], i.x[3], i.x[4], i.v[1], i.v[2], i.v[3], i.v[4]].map(exact));
            table.rows.push(row);
        }
        found = Some(modulation(&points, &flights, periods));
        let mut letters = letters.chars();
        let mut title =
            |what: &str| format!("({}) {what}, {}", letters.next().unwrap_or(' '), set.told(name, value));
        let width = if periods > STEADY { 2 } else { THIN };
        let shown = DrawnMotion { lengths: &lengths, points: &points, width };
        panels.push(shown.history(&title(&lengths.displacement("W")), &SHOWN[..1]));
        panels.push(shown.history(&title(&lengths.displacements(&["X₁", "X₃"])), &SHOWN[1..]));
        panels.push(shown.portrait(&title("phase portraits"), &SHOWN));
    }
    let Some(modulation) = found else { unreachable!("two values") };
    let figure = Figure {
        title: "Simulated motions (cf. the paper's figure 13)".into(),
        caption: vec![format!("{TRANSIENT} periods discarded. {}", set.caption_but(&[name]))],
        panels,
        columns: 3,
        panel: (1500, 1100),
        shared_legend: true,
    };
    let (most, least) = modulation.box_amplitude;
    let remark = format!(
        "{} = {}: the amplitude of X1 goes from {least:.3} to {most:.3}; {:.0} % of the periods have one impact at each stop",
        name.name(),
        short(other),
        100.0 * modulation.resonant
    );
    let what = "time histories and phase portraits of a steady and of a modulated motion as in figure 13";
    Ok((Study::of("figure-13", what, &table, figure)?.with_remarks(vec![remark]), modulation))
}

/// A quantity: index in [`MotionSample`], symbol, colour.
type DrawnQuantity = (usize, &'static str, Colour);

/// A motion to be drawn in panels.
struct DrawnMotion<'a> {
    lengths: &'a Lengths,
    points: &'a [MotionSample],
    width: u32,
}

impl DrawnMotion<'_> {
    fn curves(&self, of: &[DrawnQuantity], point: impl Fn(&MotionSample, usize) -> (f64, f64)) -> Vec<Layer> {
        let curve = |(q, symbol, colour): &DrawnQuantity| {
            let path: Path = self.points.iter().map(|p| point(p, *q)).collect();
            let line = Layer::line("", *colour, Dash::Solid, path).stroke(self.width);
            line.labelled(self.lengths.displacement(symbol))
        };
        of.iter().map(curve).collect()
    }

    fn symbols(of: &[DrawnQuantity]) -> Vec<&'static str> {
        of.iter().map(|q| q.1).collect()
    }

    fn history(&self, title: &str, of: &[DrawnQuantity]) -> Panel {
        let first = self.points.first().map_or(0.0, |p| p.time);
        let end = self.points.last().map_or(1.0, |p| p.time - first);
        Panel {
            title: title.into(),
            x: Axis::over("time Ω₁τ/2π (drive periods)", 0.0, end),
            y: self.lengths.axis(&self.lengths.displacements(&Self::symbols(of))),
            layers: self.curves(of, |p, q| (p.time - first, p.x[q])),
        }
    }

    fn portrait(&self, title: &str, of: &[DrawnQuantity]) -> Panel {
        let symbols = Self::symbols(of);
        Panel {
            title: title.into(),
            x: self.lengths.axis(&self.lengths.displacements(&symbols)),
            y: self.lengths.rates(&symbols),
            layers: self.curves(of, |p, q| (p.x[q], p.v[q])),
        }
    }
}

/// A state in SI from a stroboscopic one, with the block moved between the stops, since rounding
/// may place it slightly beyond.
fn inside(p: &Parameters, s: &StroboscopicState) -> State {
    let mut state = dimensional(p, s);
    let w = (state.x[1] - state.x[0]).clamp(-p.stop_gap, p.stop_gap);
    state.x[1] = state.x[0] + w;
    state
}

/// Figure 15: portraits of X2 at the values of a diagram nearest to `values`, from the settled
/// states of the diagram.
///
/// # Errors
/// The errors of the simulator.
pub fn portraits(set: &ParameterSet, name: Name, diagram: &Diagram, values: &[f64]) -> Result<Study> {
    let mut table = TextTable::new(&[name.name(), "class", "time", "X2", "dX2"]);
    let (mut panels, lengths) = (Vec::new(), Lengths::of(set));
    for (letter, value) in ('a'..).zip(values) {
        let Some(point) = diagram.nearest(*value) else { continue };
        let samples = continued(set.with(name, point.value)?.parameters(), point)?;
        for sample in &samples {
            let state = [sample.time, sample.x[3], sample.v[3]].map(exact);
            table.rows.push([vec![exact(point.value), point.class.name()], state.to_vec()].concat());
        }
        let title = format!("({letter}) {}: {}", set.told(name, point.value), point.class.name());
        let width = if point.attractor.period.is_some() { THIN } else { 2 };
        let shown = DrawnMotion { lengths: &lengths, points: &samples, width };
        panels.push(shown.portrait(&title, &[(3, "X₂", BLOCK)]));
    }
    let figure = Figure {
        title: "Phase portraits of the block (cf. the paper's figure 15)".into(),
        caption: vec![
            format!(
                "Motions of the sweep with {} rising, over their period, or over {WANDERING} periods.",
                set.symbol(name)
            ),
            format!("Elsewhere {}", set.caption_but(&[name])),
        ],
        panels,
        columns: 3,
        panel: (1400, 1150),
        shared_legend: true,
    };
    Study::of("figure-15", "phase portraits of X₂ as in figure 15", &table, figure)
}

/// A motion of a sweep from its settled state, over its period or [`WANDERING`] drive periods.
fn continued(p: &Parameters, point: &SweepPoint) -> Result<Vec<MotionSample>> {
    let start = inside(p, &point.attractor.states[0]);
    let mut simulator = Simulator::new(p, &start, 0.0)?.without_energy_accounts();
    let periods = point.attractor.period.unwrap_or(WANDERING);
    Ok(simulated(&record_flights(&mut simulator, periods)?, p))
}

/// The running exponents at some values of a parameter, from the default start (v2 = 1).
///
/// # Errors
/// The errors of the simulator.
pub fn running(
    set: &ParameterSet,
    along: Name,
    values: &[f64],
    discard: u32,
    options: &SpectrumOptions,
    name: &str,
) -> Result<Study> {
    let run = |value: &f64| -> Result<(f64, Convergence)> {
        let p = *set.with(along, *value)?.parameters();
        let mut simulator = settled_simulator(&p, &moving_block(&p), f64::from(discard))?;
        Ok((*value, dimensionless(&mut simulator, options)?))
    };
    let runs = values.par_iter().map(run).collect::<Result<Vec<_>>>()?;
    let panels: Vec<_> =
        ('a'..).zip(&runs).map(|(letter, run)| running_panel(letter, set, along, run)).collect();
    let figure = Figure {
        title: "Lyapunov exponents on their way".into(),
        caption: vec![format!("Elsewhere {}", set.caption_but(&[along]))],
        columns: panels.len().clamp(1, 2),
        panels,
        panel: PANEL,
        shared_legend: true,
    };
    let what = "running Lyapunov exponents over the periods counted";
    let remarks = runs.iter().map(|run| running_remark(along, run)).collect();
    Ok(Study::of(name, what, &running_table(along, &runs), figure)?.with_remarks(remarks))
}

fn running_table(name: Name, runs: &[(f64, Convergence)]) -> TextTable {
    let mut header = vec![name.name(), "period"];
    header.extend(["lambda1", "lambda2", "lambda3", "lambda4", "lambda5", "lambda6", "lambda7"]);
    let mut table = TextTable::new(&header);
    for (value, found) in runs {
        for (n, exponents) in (1..).zip(&found.running) {
            let mut row = vec![exact(*value), n.to_string()];
            row.extend(exponents.map(exact));
            table.rows.push(row);
        }
    }
    table
}

fn running_panel(
    letter: char,
    set: &ParameterSet,
    along: Name,
    (value, found): &(f64, Convergence),
) -> Panel {
    let path = |i: usize| (1..).zip(&found.running).map(|(n, e)| (f64::from(n), e[i])).collect();
    let colours = FAMILY.into_iter().cycle();
    let curve = |(i, (name, colour)): (usize, (&str, Colour))| {
        let dash = if i < FAMILY.len() { Dash::Solid } else { Dash::Dashed };
        Layer::line("", colour, dash, path(i)).stroke(THIN).labelled(name)
    };
    Panel {
        title: format!("({letter}) {}", set.told(along, *value)),
        x: Axis::over("drive periods", 0.0, f64::from(found.spectrum.periods)),
        y: Axis::new("λ (per unit of τ)"),
        layers: EXPONENTS.into_iter().zip(colours).enumerate().map(curve).collect(),
    }
}

fn running_remark(name: Name, (value, found): &(f64, Convergence)) -> String {
    let s = &found.spectrum;
    // The sum with zero turns -0 into 0.
    let exponents = s.exponents.map(|e| format!("{:.5}", e + 0.0).replace('-', "−"));
    format!(
        "{} = {}: {}; deviation {:.1e} over the last periods, {} periods",
        name.name(),
        short(*value),
        exponents.join(", "),
        s.deviation,
        s.periods
    )
}
