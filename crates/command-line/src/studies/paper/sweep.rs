//! Bifurcation diagrams with exponents (figure 14), the table of spectra (table 2), A2 and the
//! maxima (figure 16).

use super::diagram_orbits::{DiagramOrbits, end_cells, end_in_words};
use super::lengths::Lengths;
use super::maxima_panel::maxima_panel;
use crate::Result;
use crate::studies::Study;
use crate::studies::diagram::{ShownDiagram, method};
use crate::studies::panels::WIDE;
use crate::table::{TextTable, exact};
use vibro_figures::canvas::palette::{BLOCK, FAMILY};
use vibro_figures::chart::{Colour, Dash, Figure, Layer, Panel, Path, THIN};
use vibro_studies::MotionClass;
use vibro_studies::paper::bifurcation::{Diagram, Sweep, SweepPoint};
use vibro_studies::paper::lyapunov::SpectrumOptions;
use vibro_studies::paper::maxima::Displacement;
use vibro_studies::paper::plane::Method;
use vibro_studies::paper::response::{ResponsePoint, response};
use vibro_studies::paper::{ParameterSet, short};

/// Nodes of the branches drawn over maxima.
const NODES: usize = 400;
/// Decimals of an exponent in words: the accuracy after a thousand periods.
const DECIMALS: usize = 4;

impl ShownDiagram for ParameterSet {
    const SETTLES_EARLY: bool = false;
    const HEADINGS: [&'static [&'static str]; 2] = [
        &["impacts_upper", "impacts_lower", "rests", "symmetric"],
        &[
            "lambda1",
            "lambda2",
            "lambda3",
            "lambda4",
            "lambda5",
            "lambda6",
            "lambda7",
            "deviation",
            "periods",
        ],
    ];
    const IMPACTS: [&'static str; 2] = ["Impacts per drive period", "impacts per drive period"];

    fn titles(&self, sweep: &Sweep) -> [String; 3] {
        let (lengths, name) = (Lengths::of(self), sweep.axis.name);
        let (symbol, along) = (lengths.displacement(sweep.of.symbol()), self.symbol(name));
        // The paper shows the block.
        let as_paper = sweep.of == Displacement::X2 && name.name() == "f10" && !self.is_si();
        let (cf, alike) =
            if as_paper { (" (cf. the paper's figure 14)", " as in figure 14") } else { ("", "") };
        [format!("Bifurcation diagram of {symbol} over {along}{cf}"), symbol, format!("{along}{alike}")]
    }

    fn exponents_in_words(o: &SpectrumOptions) -> String {
        format!(" Exponents over {} periods after {}.", o.periods, o.align)
    }

    fn column(of: &Displacement) -> String {
        of.name().into()
    }

    fn maximum(value: f64) -> String {
        format!("{value:.6}")
    }

    fn maxima_panel(&self, sweep: &Sweep, diagram: &Diagram, apart: &[Option<bool>]) -> Result<Panel> {
        Ok(maxima_panel(self, sweep, diagram, apart))
    }

    fn exponent_titles() -> [&'static str; 2] {
        ["The three largest Lyapunov exponents, value rising", "λ (per unit of τ)"]
    }

    fn exponent_curves(points: &[Option<SweepPoint>]) -> Vec<Layer> {
        let curve = |index: usize| -> Path {
            let exponent = |p: &SweepPoint| Some((p.value, p.spectrum.as_ref()?.exponents[index]));
            points.iter().flatten().filter_map(exponent).collect()
        };
        let layer = |(index, (name, colour)): (usize, (&str, Colour))| {
            Layer::line("", colour, Dash::Solid, curve(index)).stroke(THIN).labelled(name)
        };
        let named = [("λ₁", FAMILY[0]), ("λ₂", FAMILY[2]), ("λ₃", FAMILY[4])];
        named.into_iter().enumerate().map(layer).collect()
    }

    fn has_impacts(&self) -> bool {
        true
    }

    fn cells(SweepPoint { attractor, class, spectrum, .. }: &SweepPoint) -> [Vec<String>; 2] {
        let period = attractor.period.map_or(String::new(), |n| n.to_string());
        let [upper, lower] = attractor.impacts.map(exact);
        // The symmetry of a settling motion is undecided.
        let periodic = matches!(class, MotionClass::Periodic(_));
        let symmetric = if periodic { attractor.is_symmetric().to_string() } else { String::new() };
        let exponents = spectrum.as_ref().map_or(vec![String::new(); 9], |s| {
            let own = s.exponents.into_iter().chain([s.deviation]).map(exact);
            own.chain([s.periods.to_string()]).collect()
        });
        [vec![period, upper, lower, attractor.rests.to_string(), symmetric], exponents]
    }
}

/// Table 2: spectra at the sweep's values nearest to `values`, value rising; if branches were
/// followed, with the ends of the stable range of each motion's branch.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn spectra(
    set: &ParameterSet,
    sweep: &Sweep,
    diagram: &Diagram,
    values: &[f64],
    orbits: Option<&DiagramOrbits>,
    name: &str,
) -> Result<(TextTable, Study)> {
    let mut header = vec![sweep.axis.name.name()];
    header.extend(["lambda1", "lambda2", "lambda3", "lambda4", "lambda5", "lambda6", "lambda7", "class"]);
    let (mut table, mut page) = (TextTable::new(&header), TextTable::new(&header));
    if orbits.is_some() {
        table.header.extend(["stable_from", "label_from", "stable_to", "label_to"].map(String::from));
        page.header.push("stable orbit between".into());
    }
    let mut remarks = Vec::new();
    // In a coarse sweep, several values may have the same nearest point, which is listed once.
    let mut points: Vec<_> = values.iter().filter_map(|value| diagram.nearest(*value)).collect();
    points.dedup_by_key(|point| point.value);
    for point in points {
        let Some(s) = &point.spectrum else { continue };
        let rounded = |e: f64| (e * 1e4).round() / 1e4 + 0.0;
        let numbers = s.exponents.map(|e| format!("{:.DECIMALS$}", rounded(e)).replace('-', "−"));
        let range = orbits.and_then(|orbits| orbits.range_at(0, point.value));
        let between = range.map(|r| {
            let end = |end| end_in_words(set, sweep.axis.name, end);
            format!("{} and {}", end(r.from), end(r.to))
        });
        let told = between.as_ref().map_or(String::new(), |ends| format!(", stable between {ends}"));
        remarks.push(format!("{}: {}; {}{told}", short(point.value), numbers.join(", "), point.class.name()));
        let mut row = vec![exact(point.value)];
        row.extend(s.exponents.map(exact));
        row.push(point.class.name());
        let (mut own, mut shown) = (row.clone(), row);
        if orbits.is_some() {
            own.extend([range.map(|r| r.from), range.map(|r| r.to)].into_iter().flat_map(end_cells));
            shown.push(between.unwrap_or_default());
        }
        table.rows.push(own);
        page.rows.push(shown);
    }
    let what = "spectra of Lyapunov exponents at selected values as in table 2, per unit of τ";
    let tables = vec![(name.into(), table.csv()?)];
    let study = Study { tables, ..Study::without_figure(name, what).with_remarks(remarks) };
    Ok((page, study))
}

/// Figure 16: A2 by multiple scales and by the exact orbit, drawn over the maxima of a sweep over
/// f10. The maxima are in the sweep's own table.
///
/// # Errors
/// The errors of the theories; [`Error::Output`](crate::Error::Output) if a table cannot be made.
pub fn overlay(set: &ParameterSet, sweep: &Sweep, diagram: &Diagram, name: &str) -> Result<Study> {
    let axis = &sweep.axis;
    let apart = diagram.apart();
    let mut panel = maxima_panel(set, sweep, diagram, &apart);
    panel.title = String::new();
    let mut table = TextTable::new(&[axis.name.name(), "theory", "A2", "stable"]);
    let lengths = Lengths::of(set);
    let amplitude = |p: &ResponsePoint| lengths.ratio(axis.name, p.value) * p.a[1];
    for method in [Method::MultipleScales, Method::ExactOrbit] {
        let found = response(set, axis.name, (axis.from, axis.to), method, NODES)?;
        let (mut stable, mut unstable): (Vec<Path>, Vec<Path>) = (Vec::new(), Vec::new());
        for pair in found.curves.iter().flat_map(|c| c.windows(2)).filter(|w| w[0].clear && w[0].right) {
            let into = if pair[0].stable { &mut stable } else { &mut unstable };
            let (a, b) = ((pair[0].value, amplitude(&pair[0])), (pair[1].value, amplitude(&pair[1])));
            match into.last_mut().filter(|p| p.last() == Some(&a)) {
                Some(path) => path.push(b),
                None => into.push(vec![a, b]),
            }
        }
        for p in found.curves.iter().flatten() {
            table.rows.push(vec![exact(p.value), method.name().into(), exact(p.a[1]), p.stable.to_string()]);
        }
        for (what, dash, pieces) in [("stable", Dash::Solid, stable), ("unstable", Dash::Dashed, unstable)] {
            let name = format!("A₂, {}, {what}", method.name());
            let curve = Layer::lines(&name, BLOCK, dash, pieces);
            let wide = method == Method::MultipleScales;
            panel.layers.push(if wide { curve.stroke(WIDE).pale() } else { curve.stroke(THIN) });
        }
    }
    let figure = Figure {
        title: format!(
            "Force response over the simulated maxima of {} (cf. the paper's figure 16)",
            lengths.displacement("X₂")
        ),
        caption: vec![method(sweep), set.caption_but(&[axis.name])],
        panels: vec![panel],
        columns: 1,
        panel: (2700, 1600),
        shared_legend: true,
    };
    let what = "force response A₂(f̂₁₀) over the simulated maxima of X₂ as in figure 16";
    Study::of(name, what, &table, figure)
}

/// Ranges (from, to) of values, in one direction, whose motion is neither chaotic nor unsettled.
pub fn periodic_ranges(points: &[Option<SweepPoint>]) -> Vec<(f64, f64)> {
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut open = false;
    for point in points.iter().flatten() {
        // Quasi-periodic or settling motion between periodic values belongs to a torus or a
        // bifurcation.
        let regular = point.class != MotionClass::Chaotic && point.class != MotionClass::NotSettled;
        match found.last_mut().filter(|_| open && regular) {
            Some(range) => range.1 = point.value,
            None if regular => found.push((point.value, point.value)),
            None => {}
        }
        open = regular;
    }
    found
}
