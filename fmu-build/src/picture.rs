//! The picture of a run: time histories and phase portraits.

use crate::run::{ComparedRun, STEPS_PER_PERIOD};
use vibro_figures::canvas::palette::{BLACK, BLOCK, BOX, RELATIVE, SECONDARY};
use vibro_figures::chart::{Axis, Colour, Dash, Figure, Layer, Panel, Path};
use vibro_impact::State;

/// Periods of the first time history: the transient.
const TRANSIENT: u32 = 12;
/// Periods of the second time history, and of the phase portraits.
const STEADY: u32 = 3;
/// Name and colour of box, block and secondary oscillator; the colours also differ in lightness.
const BODIES: [(&str, Colour); 3] = [("box x₁", BOX), ("block x₂", BLOCK), ("secondary x₃", SECONDARY)];

/// The picture of a run.
pub fn picture(run: &ComparedRun) -> Figure {
    let from = run.periods.saturating_sub(STEADY);
    Figure {
        title: "A run from the FMU's start values".into(),
        caption: Vec::new(),
        panels: vec![
            history("(a) Transient", run, 0, TRANSIENT.min(run.periods)),
            history(&format!("(b) Periods {from} to {}", run.periods), run, from, run.periods),
            relative(run, from),
            portraits(run, from),
        ],
        columns: 2,
        panel: (1320, 850),
        shared_legend: true,
    }
}

/// The motion between two times in periods, cut at its impacts.
fn path(run: &ComparedRun, from: u32, to: u32) -> Vec<Vec<(f64, State)>> {
    let period = run.parameters.period();
    // Half a communication step of margin for the rounding of communication points.
    let half = 0.5 / f64::from(STEPS_PER_PERIOD);
    run.path((f64::from(from) - half) * period, (f64::from(to) + half) * period)
}

/// The pieces as one curve: at an impact positions are continuous and velocities jump.
fn curve(pieces: &[Vec<(f64, State)>], point: impl Fn(f64, &State) -> (f64, f64)) -> Path {
    pieces.iter().flatten().map(|(time, state)| point(*time, state)).collect()
}

fn history(title: &str, run: &ComparedRun, from: u32, to: u32) -> Panel {
    let (period, pieces) = (run.parameters.period(), path(run, from, to));
    let layer = |(body, (name, colour)): (usize, (&str, Colour))| {
        Layer::line(name, colour, Dash::Solid, curve(&pieces, |time, state| (time / period, state.x[body])))
            .labelled(name)
    };
    Panel {
        title: title.into(),
        x: Axis::over("time t/T (–)", f64::from(from), f64::from(to)),
        y: Axis::new("displacement x (m)"),
        layers: BODIES.into_iter().enumerate().map(layer).collect(),
    }
}

/// Relative displacement and velocity; an impact is a jump along the stop.
fn relative(run: &ComparedRun, from: u32) -> Panel {
    let gap = run.parameters.stop_gap;
    let orbit = curve(&path(run, from, run.periods), |_, s| (s.x[1] - s.x[0], s.v[1] - s.v[0]));
    let speed = 1.15 * orbit.iter().map(|(_, v)| v.abs()).fold(0.0, f64::max);
    let stops = [-gap, gap].map(|w| vec![(w, -speed), (w, speed)]).to_vec();
    Panel {
        title: format!("(c) Block in the box, last {STEADY} periods"),
        x: Axis::over("relative displacement w (m)", -1.15 * gap, 1.15 * gap),
        y: Axis::new("relative velocity dw/dt (m/s)"),
        layers: vec![
            Layer::lines("stops ±L", BLACK, Dash::Dashed, stops).labelled("stop"),
            Layer::line("w = x₂ − x₁", RELATIVE, Dash::Solid, orbit).labelled("w = x₂ − x₁"),
        ],
    }
}

fn portraits(run: &ComparedRun, from: u32) -> Panel {
    let pieces = path(run, from, run.periods);
    let layer = |(body, (name, colour)): (usize, (&str, Colour))| {
        Layer::line(name, colour, Dash::Solid, curve(&pieces, |_, state| (state.x[body], state.v[body])))
            .labelled(name)
    };
    Panel {
        title: format!("(d) Phase portraits, last {STEADY} periods"),
        x: Axis::new("displacement x (m)"),
        y: Axis::new("velocity v (m/s)"),
        layers: BODIES.into_iter().enumerate().map(layer).collect(),
    }
}
