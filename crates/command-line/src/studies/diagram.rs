//! Bifurcation diagrams and exponents of described machines.

use super::Study;
use super::design_sweep::Labelled;
use super::panels::{
    DIRECTIONS, contact_panel, hysteresis, maxima_rows, reach, remarks, shaded, window_table,
};
use super::paper::sweep::letters;
use crate::Result;
use crate::table::{TextTable, exact};
use vibro_figures::canvas::palette::{FAMILY, GREY};
use vibro_figures::chart::{Axis, Dash, Figure, Layer, Panel, Path, THIN};
use vibro_studies::diagram::{AssemblyPoint, DiagramRequest};
use vibro_studies::paper::bifurcation::Diagram;
use vibro_studies::significant;
use vibro_studies::{Machine, Start, runs_on, settle, settled};

/// Lengths below this, m, are shown in mm.
const SMALL: f64 = 0.1;

/// How the values of a diagram follow one another.
const CHAINED: &str = "rising and falling, the last state being the next start";

/// The study of a diagram, with its tables.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output) if a table cannot be made; an error if the machine does
/// not have a quantity.
pub fn assembly_diagram(
    machine: &Machine,
    request: &DiagramRequest,
    diagram: &Diagram<AssemblyPoint>,
    name: &str,
) -> Result<Study> {
    let apart = diagram.apart();
    let (axis, of) = (&request.axis, request.of.to_string());
    let parameter = &axis.name;
    let drawn = if request.at_section { "Values at the section" } else { "Local maxima" };
    let x = || Axis { range: Some(axis.edges()), ..machine.axis(parameter) };
    let unit = request.of.find(&machine.description)?.unit;
    let range = reach(diagram, &|_, value| value, 0.0);
    let (factor, symbol) = match unit {
        "m" if range.0.abs().max(range.1.abs()) < SMALL => (1e3, "mm".to_owned()),
        unit => (1.0, unit.replace('.', "·").replace("s2", "s²")),
    };
    let label = format!("{of} ({symbol})");
    let mut panels = vec![Panel {
        title: format!("{drawn} of {of}"),
        x: x(),
        y: Axis::over(label, range.0, range.1).times(factor),
        layers: shaded((axis, request.keep), diagram, &apart, (range, &|_, value| value)),
    }];
    if request.exponents.is_some() {
        let zero = Layer::line("", GREY, Dash::Dotted, vec![(axis.edges().0, 0.0), (axis.edges().1, 0.0)]);
        let exponent = |p: &AssemblyPoint| Some((p.value, p.settled.exponent?.value));
        let points = diagram.up.iter().flatten().filter_map(exponent).filter(|p| p.1.is_finite());
        let curve: Path = points.collect();
        panels.push(Panel {
            title: "Largest Lyapunov exponent, value rising".into(),
            x: x(),
            y: Axis::new("λ₁ (1/s)"),
            layers: vec![zero.stroke(THIN), Layer::line("", FAMILY[0], Dash::Solid, curve).stroke(THIN)],
        });
    }
    if !machine.description.stops.is_empty() {
        panels.push(contact_panel("Impacts and first touches a period", x(), "contacts a period", diagram));
    }
    if request.anew {
        let falls = |layer: &Layer| layer.name.as_ref().is_some_and(|name| name.starts_with("value falling"));
        panels.iter_mut().for_each(|panel| panel.layers.retain(|layer| !falls(layer)));
    }
    letters(&mut panels);
    let method = format!(
        "Up to {} periods discarded and {} kept at each of {} values, {}.",
        request.discard,
        request.keep,
        axis.count,
        match (request.anew, request.start.is_own()) {
            (true, true) => "each started as the file says".into(),
            (true, false) => format!("each started at {}", request.start),
            (false, true) => CHAINED.into(),
            (false, false) => format!("{CHAINED}, the first {}", request.start),
        }
    );
    let figure = Figure {
        title: format!("{}: {of} over {parameter}", machine.description.name),
        caption: vec![method, format!("Elsewhere {}", machine.caption_but(std::slice::from_ref(parameter)))],
        panels,
        columns: 1,
        panel: (2900, 1150),
        shared_legend: false,
    };
    let column = format!("{of}_{}", if request.at_section { "section" } else { "maximum" });
    let told = |value: f64| machine.told(parameter, value);
    let directions = if request.anew { "each value started anew" } else { "both directions" };
    let what = format!("{} of {of} over {parameter}, {directions}", drawn.to_lowercase());
    // With `anew` there is one direction.
    let remarks = remarks(parameter, diagram, (!request.anew).then_some(&apart[..]), &told);
    Ok(Study {
        tables: vec![
            (name.into(), maxima_rows((parameter, &column), diagram, &exact)?),
            (format!("{name}-points"), point_table(parameter, diagram, &apart).csv()?),
            (format!("{name}-windows"), window_table(parameter, diagram).csv()?),
        ],
        figure: Some(figure),
        subject: machine.caption_of_all(std::slice::from_ref(parameter)),
        ..Study::without_figure(name, what).with_remarks(remarks)
    })
}

/// Table of the largest exponent of a machine's motion from a start, over `periods` returns after
/// `discard` discarded returns.
///
/// # Errors
/// The errors of the machine and of its motion.
pub fn assembly_exponent(
    machine: &Machine,
    start: &Start,
    (discard, periods): (u32, u32),
    name: &str,
) -> Result<Study> {
    let (motion, section) = machine.motion(start)?;
    let mut motion = motion.without_energy_accounts();
    settle(&mut motion, &section, discard)?;
    if let Some(why) = runs_on(&machine.description, motion.time()) {
        let problem =
            "only what repeats has an exponent; allowed are changes within what is discarded (--discard)";
        return Err(crate::Error::Refused { what: why, problem: problem.into() });
    }
    let found = settled(&mut motion, &section, Some(periods))?;
    let mut table =
        TextTable::new(&["exponent", "error", "periods", "interval", "contacts", "rests", "class"]);
    let exponent = found.exponent;
    let number = |x: Option<f64>| x.map_or(String::new(), exact);
    table.rows.push(vec![
        number(exponent.map(|e| e.value)),
        number(exponent.map(|e| e.error)),
        exponent.map_or(String::new(), |e| e.periods.to_string()),
        exact(found.interval),
        exact(found.contacts),
        found.rests.to_string(),
        found.class.name(),
    ]);
    let told =
        exponent.map_or("undecided: the motion has not settled".into(), |e| match (e.value, found.period) {
            (f64::NEG_INFINITY, _) => {
                "-inf: contacts take every direction, or there is none but neutral ones".into()
            }
            (value, Some(period)) => {
                format!(
                    "{} 1/s, by the multipliers of {period}T to {}",
                    significant(value),
                    significant(e.error)
                )
            }
            (value, None) => format!(
                "{} 1/s, standard error {}, over {} returns",
                significant(value),
                significant(e.error),
                e.periods
            ),
        });
    let what = format!("largest Lyapunov exponent {told}");
    let remarks = vec![format!("class: {}", found.class.name())];
    Ok(Study {
        tables: vec![(name.into(), table.csv()?)],
        ..Study::without_figure(name, what).with_remarks(remarks)
    })
}

fn point_table(parameter: &str, diagram: &Diagram<AssemblyPoint>, apart: &[Option<bool>]) -> TextTable {
    let header =
        ["direction", "class", "period", "interval", "contacts", "rests", "hysteresis", "exponent", "error"];
    let mut table = TextTable::new(&[&[parameter][..], &header].concat());
    for (direction, points) in DIRECTIONS.into_iter().zip([&diagram.up, &diagram.down]) {
        for (point, apart) in points.iter().zip(apart) {
            let Some(AssemblyPoint { value, settled, .. }) = point else { continue };
            let number = |x: Option<f64>| x.map_or(String::new(), exact);
            table.rows.push(vec![
                exact(*value),
                direction.into(),
                settled.class.name(),
                settled.period.map_or(String::new(), |n| n.to_string()),
                exact(settled.interval),
                exact(settled.contacts),
                settled.rests.to_string(),
                hysteresis(*apart),
                number(settled.exponent.map(|e| e.value)),
                number(settled.exponent.map(|e| e.error)),
            ]);
        }
    }
    table
}
