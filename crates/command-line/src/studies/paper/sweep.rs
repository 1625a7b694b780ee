//! Bifurcation diagrams with exponents (figure 14), the table of spectra (table 2), A2 and the
//! maxima (figure 16).

use super::diagram_orbits::{DiagramOrbits, end_cells, end_in_words};
use super::lengths::Lengths;
use crate::Result;
use crate::studies::Study;
use crate::studies::panels::{
    DIRECTIONS, WIDE, contact_panel, hysteresis, maxima_panel, maxima_rows, method, remarks, window_table,
};
use crate::table::{TextTable, exact};
use vibro_figures::canvas::palette::{BLOCK, FAMILY, GREY};
use vibro_figures::chart::{Axis, Dash, Figure, Layer, Panel, Path, THIN};
use vibro_studies::MotionClass;
use vibro_studies::paper::bifurcation::{Diagram, Sweep, SweepPoint};
use vibro_studies::paper::maxima::Displacement;
use vibro_studies::paper::plane::{Method, ParameterAxis};
use vibro_studies::paper::response::{ResponsePoint, response};
use vibro_studies::paper::{ParameterSet, short};

/// Nodes of the branches drawn over maxima.
const NODES: usize = 400;
/// Decimals of an exponent in words: the accuracy after a thousand periods.
const DECIMALS: usize = 4;

/// The study of a sweep: maxima, impacts and, if computed, exponents, with their tables.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn sweep(set: &ParameterSet, sweep: &Sweep, diagram: &Diagram, name: &str) -> Result<Study> {
    let apart = diagram.apart();
    let (axis, lengths) = (&sweep.axis, Lengths::of(set));
    let (symbol, along) = (lengths.displacement(sweep.of.symbol()), set.symbol(axis.name));
    // The paper shows the block.
    let as_paper = sweep.of == Displacement::X2 && axis.name.name() == "f10" && !set.is_si();
    let (cf, alike) = if as_paper { (" (cf. the paper's figure 14)", " as in figure 14") } else { ("", "") };
    let mut panels = vec![maxima_panel(set, sweep, diagram, &apart)];
    if sweep.exponents.is_some() {
        panels.push(exponent_panel(set, axis, &diagram.up));
    }
    let x = crate::studies::parameter_axis(set, axis.name, axis.edges());
    panels.push(contact_panel("Impacts per drive period", x, "impacts per drive period", diagram));
    letters(&mut panels);
    let figure = Figure {
        title: format!("Bifurcation diagram of {symbol} over {along}{cf}"),
        caption: vec![method(sweep), format!("Elsewhere {}", set.caption_but(&[axis.name]))],
        panels,
        columns: 1,
        panel: (2900, 1150),
        shared_legend: false,
    };
    let remarks = remarks(axis.name.name(), diagram, Some(&apart), &|value| set.with_unit(axis.name, value));
    let what = format!("local maxima of {symbol} over {along}{alike}, both directions");
    Ok(Study {
        tables: vec![
            (name.into(), maxima_table(sweep, diagram)?),
            (format!("{name}-points"), point_table(axis, diagram, &apart).csv()?),
            (format!("{name}-windows"), window_table(axis.name.name(), diagram).csv()?),
        ],
        figure: Some(figure),
        ..Study::without_figure(name, what).with_remarks(remarks)
    })
}

pub(in crate::studies) fn letters(panels: &mut [Panel]) {
    for (letter, panel) in ('a'..).zip(panels) {
        panel.title = format!("({letter}) {}", panel.title);
    }
}

fn exponent_panel(set: &ParameterSet, axis: &ParameterAxis, points: &[Option<SweepPoint>]) -> Panel {
    let x = axis.edges();
    let curve = |index: usize| -> Path {
        points
            .iter()
            .flatten()
            .filter_map(|p| Some((p.value, p.spectrum.as_ref()?.exponents[index])))
            .collect()
    };
    let colours = [FAMILY[0], FAMILY[2], FAMILY[4]];
    let mut layers = vec![Layer::line("", GREY, Dash::Dotted, vec![(x.0, 0.0), (x.1, 0.0)]).stroke(THIN)];
    for (index, name) in ["λ₁", "λ₂", "λ₃"].into_iter().enumerate() {
        layers.push(Layer::line("", colours[index], Dash::Solid, curve(index)).stroke(THIN).labelled(name));
    }
    Panel {
        title: "The three largest Lyapunov exponents, value rising".into(),
        x: crate::studies::parameter_axis(set, axis.name, x),
        y: Axis::new("λ (per unit of τ)"),
        layers,
    }
}

/// Table of all maxima with their counts.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn maxima_table(sweep: &Sweep, diagram: &Diagram) -> Result<Vec<u8>> {
    let maximum = format!("{}_maximum", sweep.of.name());
    maxima_rows((sweep.axis.name.name(), &maximum), diagram, &|x| format!("{x:.6}"))
}

fn point_table(axis: &ParameterAxis, diagram: &Diagram, apart: &[Option<bool>]) -> TextTable {
    let mut header = vec![axis.name.name(), "direction", "class", "period", "impacts_upper", "impacts_lower"];
    header.extend(["rests", "symmetric", "hysteresis"]);
    header.extend(["lambda1", "lambda2", "lambda3", "lambda4", "lambda5", "lambda6", "lambda7"]);
    header.extend(["deviation", "periods"]);
    let mut table = TextTable::new(&header);
    for (direction, points) in DIRECTIONS.into_iter().zip([&diagram.up, &diagram.down]) {
        for (point, apart) in points.iter().zip(apart) {
            let Some(p) = point else { continue };
            let a = &p.attractor;
            let mut row = vec![exact(p.value), direction.into(), p.class.name()];
            row.push(a.period.map_or(String::new(), |n| n.to_string()));
            row.extend(a.impacts.map(exact));
            // The symmetry of a settling motion is undecided.
            let periodic = matches!(p.class, MotionClass::Periodic(_));
            let symmetric = if periodic { a.is_symmetric().to_string() } else { String::new() };
            row.extend([a.rests.to_string(), symmetric, hysteresis(*apart)]);
            match &p.spectrum {
                Some(s) => {
                    row.extend(s.exponents.map(exact));
                    row.extend([exact(s.deviation), s.periods.to_string()]);
                }
                None => row.extend((0..9).map(|_| String::new())),
            }
            table.rows.push(row);
        }
    }
    table
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
    // In a coarse sweep, several values may have one nearest point, which is listed once.
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
