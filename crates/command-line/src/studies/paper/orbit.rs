//! One periodic orbit: its impacts and multipliers as a table; gap, portrait and multipliers as a
//! picture.

use super::lengths::Lengths;
use crate::studies::Study;
use crate::table::{CsvRows, exact};
use crate::{Error, Result};
use std::f64::consts::TAU;
use vibro_figures::canvas::palette::{BLACK, GREY, RELATIVE, VERMILLION};
use vibro_figures::chart::{Axis, Dash, Figure, Layer, Mark, Panel, Path, THIN};
use vibro_impact::parameters::FIELDS;
use vibro_orbits::paper::Orbit;
use vibro_studies::paper::ParameterSet;

/// Points of a curve per drive period.
const SAMPLES: u32 = 400;

/// The study of the first orbit in `found`, with its shortest word.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn orbit(set: &ParameterSet, found: &[Orbit]) -> Result<Study> {
    let asked = found.first().ok_or_else(|| Error::form("orbits", "at least one"))?;
    let (orbit, passages) = asked.shortest();
    let orbit = &orbit;
    let word = orbit.word();
    let what = format!("the periodic orbit {} (period {}T)", word.signed(), word.period());
    let stability = if orbit.is_stable() { "stable" } else { "unstable" };
    let start = orbit.start_state();
    let mut remarks: Vec<String> = shorter(asked, orbit, passages).into_iter().collect();
    remarks.push(format!("{stability}: {}", largest_multiplier(orbit)));
    remarks.push(format!("start: x = {:?} m, v = {:?} m/s at time 0", start.x, start.v));
    if word.closing() > 0 && orbit.system().is_symmetric() {
        remarks.push("it is not symmetric; its mirror image is another orbit".into());
    }
    let own = found.iter().skip(1).filter(|o| o.is_shortest()).count();
    if own > 0 {
        remarks.push(format!(
            "{own} other orbits of this word were found; the orbit nearest to stability is shown"
        ));
    }
    let short = found.len() - 1 - own;
    if short > 0 {
        remarks
            .push(format!("{short} more are repetitions of an orbit of a shorter word, or symmetric orbits"));
    }
    let figure = Figure {
        title: format!("Periodic orbit {} of period {}T", word.signed(), word.period()),
        caption: vec![format!("{stability}; {}", set.caption())],
        panels: vec![
            history(orbit, &Lengths::of(set)),
            portrait(orbit, &Lengths::of(set)),
            multipliers(orbit),
        ],
        columns: 3,
        panel: (1150, 1150),
        shared_legend: false,
    };
    Ok(Study {
        tables: vec![
            ("orbit-impacts".into(), impact_table(orbit)?),
            ("orbit-multipliers".into(), multiplier_table(orbit)?),
            ("orbit-start".into(), start_table(orbit)?),
        ],
        figure: Some(figure),
        ..Study::without_figure("orbit", what).with_remarks(remarks)
    })
}

/// Remark that the orbit of a word is an orbit of a shorter word; `None` if it is not.
fn shorter(asked: &Orbit, orbit: &Orbit, passages: u32) -> Option<String> {
    if asked.word() == orbit.word() {
        return None;
    }
    let (long, short) = (asked.word().signed(), orbit.word().signed());
    let period = orbit.word().period();
    let symmetric = match (asked.word().closing(), orbit.word().closing()) {
        (1, -1) => ", a symmetric orbit, whose second half is the mirror image of the first",
        _ => "",
    };
    Some(match passages {
        1 => format!("{long} is {short}{symmetric}"),
        _ => format!(
            "{long} over {}T is {short} of {period}T passed {passages} times{symmetric}; no orbit of its own was found for it",
            asked.word().period()
        ),
    })
}

/// The largest multiplier in words; for a symmetric orbit, the largest multipliers of half a
/// period and of the whole period.
fn largest_multiplier(orbit: &Orbit) -> String {
    let (radius, period) = (orbit.spectral_radius(), orbit.word().period());
    if orbit.word().closing() < 0 {
        let whole = radius * radius;
        format!("largest multiplier {radius:.9} of half the period, so {whole:.9} of the whole ({period}T)")
    } else {
        format!("largest multiplier {radius:.9} of the whole period ({period}T)")
    }
}

fn impact_table(orbit: &Orbit) -> Result<Vec<u8>> {
    let mut table = CsvRows::new(["impact", "stop", "phase", "approach_speed"])?;
    let letters = orbit.word().letters();
    for (i, ((stop, phase), speed)) in letters.iter().zip(orbit.phases()).zip(orbit.speeds()).enumerate() {
        table.push([i.to_string(), stop.to_string(), exact(*phase), exact(*speed)])?;
    }
    table.text()
}

fn multiplier_table(orbit: &Orbit) -> Result<Vec<u8>> {
    let mut table = CsvRows::new(["real", "imaginary", "modulus", "drive_periods", "of"])?;
    let periods = orbit.multiplier_periods();
    let of = if orbit.word().closing() < 0 { "half period" } else { "whole period" };
    for m in orbit.multipliers() {
        table.push([exact(m.re), exact(m.im), exact(m.norm()), exact(periods), of.into()])?;
    }
    table.text()
}

/// Table of parameters, loads and state at time 0 by the names of the FMU's variables: start
/// values for the motion on the orbit.
fn start_table(orbit: &Orbit) -> Result<Vec<u8>> {
    let mut table = CsvRows::new(["variable", "unit", "start"])?;
    let (parameters, start) = (orbit.system().parameters(), orbit.start_state());
    for field in FIELDS {
        table.push([field.name.to_owned(), field.unit.to_owned(), exact((field.get)(parameters))])?;
    }
    let bodies = ["box", "block", "secondary"];
    let forces = orbit.system().loads().forces;
    for (quantity, unit, values) in [("s", "m", start.x), ("v", "m/s", start.v), ("f", "N", forces)] {
        for (body, value) in bodies.into_iter().zip(values) {
            table.push([format!("{body}.{quantity}"), unit.to_owned(), exact(value)])?;
        }
    }
    table.text()
}

/// The relative displacement over the whole period, in L, and its rate in L ω10.
fn samples(orbit: &Orbit) -> Vec<(f64, f64, f64)> {
    let p = orbit.system().parameters();
    let first = orbit.phases().first().copied().unwrap_or(0.0);
    let count = SAMPLES * orbit.word().period();
    let speed = p.stop_gap * p.box_frequency();
    let at = |i: u32| {
        let phase = first + TAU * f64::from(i) / f64::from(SAMPLES);
        let state = orbit.state(phase);
        (phase, (state.x[1] - state.x[0]) / p.stop_gap, (state.v[1] - state.v[0]) / speed)
    };
    (0..=count).map(at).collect()
}

fn history(orbit: &Orbit, lengths: &Lengths) -> Panel {
    let points: Path = samples(orbit).into_iter().map(|(phase, w, _)| (phase / TAU, w)).collect();
    let (from, to) = (points[0].0, points[points.len() - 1].0);
    let stop = |w: f64| Layer::line("", GREY, Dash::Dotted, vec![(from, w), (to, w)]).stroke(THIN);
    let layers = vec![stop(1.0), stop(-1.0), Layer::line("", RELATIVE, Dash::Solid, points)];
    let x = Axis::over("phase of the drive (periods)", from, to);
    let y = lengths.axis_over(&lengths.displacement("W"), -1.1, 1.1);
    Panel { title: "(a) Block in the box; dotted: stops".into(), x, y, layers }
}

fn portrait(orbit: &Orbit, lengths: &Lengths) -> Panel {
    // A piece ends where the rate jumps.
    let mut pieces: Vec<Path> = vec![Vec::new()];
    let mut last: Option<(f64, f64)> = None;
    for (_, w, rate) in samples(orbit) {
        if last.is_some_and(|(before, old)| before.abs() > 0.9 && old * rate < 0.0 && w.abs() > 0.9) {
            pieces.push(Vec::new());
        }
        pieces.last_mut().into_iter().for_each(|piece| piece.push((w, rate)));
        last = Some((w, rate));
    }
    let layers = vec![Layer::lines("", RELATIVE, Dash::Solid, pieces)];
    let x = lengths.axis_over(&lengths.displacement("W"), -1.1, 1.1);
    Panel { title: "(b) Phase portrait".into(), x, y: lengths.rates(&["W"]), layers }
}

fn multipliers(orbit: &Orbit) -> Panel {
    let circle: Path =
        (0..=200).map(|i| (TAU * f64::from(i) / 200.0).sin_cos()).map(|(s, c)| (c, s)).collect();
    let points: Path = orbit.multipliers().iter().map(|m| (m.re, m.im)).collect();
    let reach = points.iter().fold(1.2_f64, |most, (a, b)| most.max(1.1 * a.abs()).max(1.1 * b.abs()));
    let layers = vec![
        Layer::line("unit circle", GREY, Dash::Dotted, circle).stroke(THIN),
        Layer::marks("multipliers", if orbit.is_stable() { BLACK } else { VERMILLION }, Mark::Disc, points),
    ];
    let axis = |label: &str| Axis::over(label, -reach, reach);
    let of = if orbit.word().closing() < 0 { "half the period" } else { "the period" };
    Panel { title: format!("(c) Multipliers of {of}"), x: axis("Re μ"), y: axis("Im μ"), layers }
}
