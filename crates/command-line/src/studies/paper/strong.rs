//! Strong coupling against simulation (figures 18, 19).

use super::compare::{SHOWN, amplitude_table, caption_lines, no_motion, not_compared, simulate};
use super::lengths::Lengths;
use super::steady::four_panels;
use super::steady_motion::SteadyMotion;
use crate::Result;
use crate::studies::Study;
use std::f64::consts::PI;
use vibro_figures::canvas::palette::{BLACK, BLOCK, BOX, CENTRE, FAMILY, SECONDARY};
use vibro_figures::chart::{Axis, Dash, Layer, Mark, Panel, Path};
use vibro_impact::steady::strong_coupling::modified_sawtooth;
use vibro_studies::paper::{ParameterSet, short};

/// Figures 18 and 19: Z*, and section 5's closed form against the simulation.
///
/// # Errors
/// The errors of theory and simulator, e.g. for a coupling at which the closed form is singular.
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
        "Strong coupling against simulation (cf. the paper's figures 18, 19)",
        set,
        (&history, "closed form"),
        (&found.samples, "simulation"),
    );
    let lengths = Lengths::of(set);
    figure.caption.splice(0..0, caption_lines(reason.as_deref()));
    figure.panels.insert(0, sawtooth_panel(set.groups().beta2.sqrt()));
    figure.panels.insert(3, amplitude_panel(&lengths, theory.amplitudes(p), found.amplitudes));
    let [two, three] = [&["U", "W"][..], &["X₁", "X₂", "X₃"]].map(|all| lengths.displacements(all));
    let titles = ["Modified sawtooth Z*", &two, &two, "Amplitudes", &three, &three];
    for ((letter, panel), title) in ('a'..).zip(&mut figure.panels).zip(titles) {
        panel.title = format!("({letter}) {title}");
    }
    figure.shared_legend = false;
    figure.columns = 3;
    figure.panel = (1500, 1100);
    let what = "strong coupling as in figures 18 and 19, closed form against simulation";
    Ok(Study::of("compare-19", what, &table, figure)?.with_remarks(remarks).with_set(set))
}

fn sawtooth_panel(beta: f64) -> Panel {
    // β̂ = 0 is the plain sawtooth; beyond 1 the block overshoots the stop's position.
    let mut betas = vec![0.0, 0.8, 1.4];
    if !betas.iter().any(|b| (b - beta).abs() < 1e-9) {
        betas.push(beta);
    }
    let dash = [Dash::Solid, Dash::Dashed, Dash::Dotted, Dash::Solid];
    let curve = |((&b, colour), dash): ((&f64, _), _)| {
        let path = (0..=400).map(|i| f64::from(i) / 100.0).map(|s| (s, modified_sawtooth(b, s * PI).0));
        Layer::line("", colour, dash, path.collect()).labelled(format!("β̂ = {}", short(b)))
    };
    Panel {
        title: String::new(),
        x: Axis::over("phase s/π (–)", 0.0, 4.0),
        y: Axis::new("Z* (–)"),
        layers: betas.iter().zip(FAMILY).zip(dash).map(curve).collect(),
    }
}

fn amplitude_panel(lengths: &Lengths, theory: [f64; 4], simulation: [f64; 4]) -> Panel {
    let at = |values: [f64; 4]| (1..).map(f64::from).zip(values).collect::<Path>();
    let highest = theory.into_iter().chain(simulation).fold(0.0, f64::max);
    let names = ["B", "A₁", "A₂", "A₃"].map(|s| lengths.amplitude(s)).to_vec();
    let bodies = at(theory).into_iter().zip([CENTRE, BOX, BLOCK, SECONDARY]).zip(&names);
    let closed = bodies.map(|((point, colour), name)| {
        Layer::marks(&format!("{name}, closed form"), colour, Mark::Disc, vec![point]).stroke(18)
    });
    let mut layers: Vec<_> = closed.collect();
    layers.push(Layer::marks("simulation", BLACK, Mark::Cross, at(simulation)).stroke(18));
    let x = format!("amplitude of {}", lengths.displacements(&["U", "X₁", "X₂", "X₃"]));
    Panel {
        title: String::new(),
        x: Axis { names, ..Axis::over(x, 0.5, 4.5) },
        y: lengths.axis_over("amplitude", 0.0, 1.2 * highest),
        layers,
    }
}
