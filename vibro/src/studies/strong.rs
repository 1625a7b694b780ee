//! Strong coupling against simulation (figures 18, 19).

use super::Study;
use super::compare::{SHOWN, amplitude_table, caption_lines, no_motion, not_compared, simulate};
use super::steady::four_panels;
use super::steady_motion::SteadyMotion;
use crate::Result;
use crate::figures::canvas::palette::{BLACK, BLUE, GREEN, VERMILLION};
use crate::figures::chart::{Axis, Dash, Layer, Mark, Panel, Path};
use std::f64::consts::PI;
use vibro_analysis::{ParameterSet, short};
use vibro_impact::steady::strong_coupling::modified_sawtooth;

/// Figures 18 and 19: Z*, and section 5's closed form against the simulation.
///
/// # Errors
/// What theory or simulator refuse, e.g. a coupling at which the closed form is singular.
pub fn strong_case(set: &ParameterSet) -> Result<Study> {
    let p = set.parameters();
    let Some(theory) = SteadyMotion::strong(set.groups())? else {
        return Ok(no_motion("compare-19", "strong coupling"));
    };
    let found = simulate(p, &theory)?;
    let reason = not_compared(&theory, &found);
    let (table, mut remarks) =
        amplitude_table("strong_coupling", theory.amplitudes(p), found.amplitudes, reason.as_deref());
    remarks.insert(0, format!("parameters here: {}", set.caption()));
    let history = theory.history(p, f64::from(SHOWN));
    let mut figure = four_panels(
        "Strong coupling against simulation (cf. figures 18, 19)",
        set,
        (&history, "closed form"),
        (&found.samples, "simulation"),
    );
    figure.caption.splice(0..0, caption_lines(reason.as_deref()));
    figure.panels.insert(0, sawtooth_panel(set.groups().beta2.sqrt()));
    figure.panels.insert(3, amplitude_panel(theory.amplitudes(p), found.amplitudes));
    let titles = [
        "(a) Modified sawtooth Z*",
        "(b) U and W",
        "(c) U and W",
        "(d) Amplitudes",
        "(e) X₁, X₂, X₃",
        "(f) X₁, X₂, X₃",
    ];
    for (panel, title) in figure.panels.iter_mut().zip(titles) {
        panel.title = title.into();
    }
    figure.shared_legend = false;
    figure.columns = 3;
    figure.panel = (1500, 1100);
    let what = "strong coupling as in figures 18 and 19, closed form against simulation";
    Ok(Study::of("compare-19", what, &table, figure)?.with_remarks(remarks).with_set(set))
}

fn sawtooth_panel(beta: f64) -> Panel {
    // β̂ = 0 is the plain sawtooth; past 1 the block overshoots the stop's place.
    let mut betas = vec![0.0, 0.8, 1.4];
    if !betas.iter().any(|b| (b - beta).abs() < 1e-9) {
        betas.push(beta);
    }
    let dash = [Dash::Solid, Dash::Dashed, Dash::Dotted, Dash::Solid];
    let curve = |((&b, colour), dash): ((&f64, _), _)| {
        let path = (0..=400).map(|i| f64::from(i) / 100.0).map(|s| (s, modified_sawtooth(b, s * PI).0));
        Layer::line(&format!("β̂ = {}", short(b)), colour, dash, path.collect())
    };
    Panel {
        title: String::new(),
        x: Axis::over("phase s/π (–)", 0.0, 4.0),
        y: Axis::new("Z* (–)"),
        layers: betas.iter().zip([BLACK, BLUE, GREEN, VERMILLION]).zip(dash).map(curve).collect(),
    }
}

fn amplitude_panel(theory: [f64; 4], simulation: [f64; 4]) -> Panel {
    let at = |values: [f64; 4]| (1..).map(f64::from).zip(values).collect::<Path>();
    let highest = theory.into_iter().chain(simulation).fold(0.0, f64::max);
    let layers = vec![
        Layer::marks("closed form", BLUE, Mark::Disc, at(theory)).stroke(18),
        Layer::marks("simulation", BLACK, Mark::Cross, at(simulation)).stroke(18),
    ];
    let names = ["B", "A₁", "A₂", "A₃"].map(String::from).to_vec();
    Panel {
        title: String::new(),
        x: Axis { names, ..Axis::over("amplitude of U, X₁, X₂, X₃", 0.5, 4.5) },
        y: Axis::over("amplitude (units of L)", 0.0, 1.2 * highest),
        layers,
    }
}
