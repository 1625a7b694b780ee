//! Bifurcation diagrams with exponents, and their tables.

mod described;

use super::Study;
use super::design_sweep::Labelled;
use super::panels::{
    DIRECTIONS, contact_panel, hysteresis, maxima_rows, remarks, same_contacts, window_table,
};
use crate::Result;
use crate::table::{TextTable, exact};
use vibro_figures::canvas::palette::GREY;
use vibro_figures::chart::{Axis, Dash, Figure, Layer, Panel, THIN, lettered};
use vibro_studies::diagram::{Diagram, DiagramMachine, DiagramPoint, DiagramRequest};

/// Relation of successive values of a diagram.
const CHAINED: &str = "rising and falling, the last state being the next start";

/// Machine whose diagrams have tables and pictures.
pub trait ShownDiagram: DiagramMachine + Labelled {
    /// Whether a motion that settles early ends the discarded periods.
    const SETTLES_EARLY: bool;
    /// Headings of the table of points for impacts, and for exponents.
    const HEADINGS: [&'static [&'static str]; 2];
    /// Titles of the panel of impacts and of its axis.
    const IMPACTS: [&'static str; 2];

    /// Title of the picture; drawn quantity and parameter, for the first line.
    fn titles(&self, request: &DiagramRequest<Self>) -> [String; 3];
    /// Description of exponents for the caption, with a leading space.
    fn exponents_in_words(exponents: &Self::Exponents) -> String;
    /// Quantity in the heading of a column.
    fn column(of: &Self::Of) -> String;
    /// A drawn value in the table.
    fn maximum(value: f64) -> String;
    /// Panel of the drawn values.
    ///
    /// # Errors
    /// Error for a quantity that the machine does not have.
    fn maxima_panel(
        &self,
        request: &DiagramRequest<Self>,
        diagram: &Diagram<Self::Point>,
        apart: &[Option<bool>],
    ) -> Result<Panel>;
    /// Title of the panel of exponents and label of its axis.
    fn exponent_titles() -> [&'static str; 2];
    /// Curves of the panel of exponents.
    fn exponent_curves(points: &[Option<Self::Point>]) -> Vec<Layer>;
    /// Whether the machine has anything to touch.
    fn has_impacts(&self) -> bool;
    /// Cells of a point's row: class, period and impacts; the exponents.
    fn cells(point: &Self::Point) -> [Vec<String>; 2];
}

/// Description of a diagram's method of computation.
pub(super) fn method<M: ShownDiagram>(request: &DiagramRequest<M>) -> String {
    let up_to = if M::SETTLES_EARLY { "Up to " } else { "" };
    let chained = match (request.anew, request.start == M::Start::default()) {
        (true, true) => "each started as the file says".into(),
        (true, false) => format!("each started at {}", request.start),
        (false, true) => CHAINED.into(),
        (false, false) => format!("{CHAINED}, the first {}", request.start),
    };
    let DiagramRequest { discard, keep, axis, exponents, .. } = request;
    let exponents = exponents.as_ref().map_or(String::new(), M::exponents_in_words);
    let count = axis.count;
    format!(
        "{up_to}{discard} periods discarded and {keep} kept at each of {count} values, {chained}.{exponents}"
    )
}

/// Axis of the parameter of a diagram, up to the edges of its cells.
pub(super) fn across<M: ShownDiagram>(machine: &M, request: &DiagramRequest<M>) -> Axis {
    Axis { range: Some(request.axis.edges()), ..machine.axis(&request.axis.name) }
}

/// The study of a diagram: maxima, impacts and, if computed, exponents, with their tables.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output) if a table cannot be made; an error if the machine does
/// not have a quantity.
pub fn diagram<M: ShownDiagram>(
    machine: &M,
    request: &DiagramRequest<M>,
    diagram: &Diagram<M::Point>,
    name: &str,
) -> Result<Study> {
    let (apart, along) = (diagram.apart(), std::slice::from_ref(&request.axis.name));
    let parameter = M::name(&request.axis.name);
    let mut panels = vec![machine.maxima_panel(request, diagram, &apart)?];
    if request.exponents.is_some() {
        let [title, label] = M::exponent_titles();
        let (from, to) = request.axis.edges();
        let zero = Layer::line("", GREY, Dash::Dotted, vec![(from, 0.0), (to, 0.0)]).stroke(THIN);
        panels.push(Panel {
            title: title.into(),
            x: across(machine, request),
            y: Axis::new(label),
            layers: [vec![zero], M::exponent_curves(&diagram.up)].concat(),
        });
    }
    let mut caption = vec![method(request), format!("Elsewhere {}", machine.caption_but(along))];
    if machine.has_impacts() {
        let [title, label] = M::IMPACTS;
        match same_contacts(diagram) {
            Some(count) => {
                caption.push(format!("Not drawn, since it is the same at all values: {count} {label}."))
            }
            None => {
                panels.push(contact_panel(title, across(machine, request), label, (&request.axis, diagram)))
            }
        }
    }
    if request.anew {
        let falls = |layer: &Layer| layer.name.as_ref().is_some_and(|name| name.starts_with("value falling"));
        panels.iter_mut().for_each(|panel| panel.layers.retain(|layer| !falls(layer)));
    }
    lettered(&mut panels);
    let [title, of, over] = machine.titles(request);
    let figure = Figure { title, caption, panels, columns: 1, panel: (2900, 1150), shared_legend: false };
    let drawn = if request.at_section { "values at the section" } else { "local maxima" };
    let directions = if request.anew { "each value from the same start" } else { "both directions" };
    let told = |value: f64| machine.with_unit(&request.axis.name, value);
    // If `anew` is set, there is one direction.
    let remarks = remarks(&parameter, diagram, (!request.anew).then_some(&apart[..]), &told);
    Ok(Study {
        tables: vec![
            (name.into(), maxima_table(request, diagram)?),
            (format!("{name}-points"), point_table::<M>(&parameter, diagram, &apart).csv()?),
            (format!("{name}-windows"), window_table(&parameter, diagram).csv()?),
        ],
        figure: Some(figure),
        subject: machine.caption_of_all(along),
        ..Study::without_figure(name, format!("{drawn} of {of} over {over}, {directions}"))
            .with_remarks(remarks)
    })
}

/// Table of all drawn values with their counts.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub(super) fn maxima_table<M: ShownDiagram>(
    request: &DiagramRequest<M>,
    diagram: &Diagram<M::Point>,
) -> Result<Vec<u8>> {
    let kind = if request.at_section { "section" } else { "maximum" };
    let column = format!("{}_{kind}", M::column(&request.of));
    maxima_rows((&M::name(&request.axis.name), &column), diagram, &M::maximum)
}

fn point_table<M: ShownDiagram>(
    parameter: &str,
    diagram: &Diagram<M::Point>,
    apart: &[Option<bool>],
) -> TextTable {
    let [impacts, exponents] = M::HEADINGS;
    let first = [parameter, "direction", "class", "period"];
    let mut table = TextTable::new(&[&first[..], impacts, &["hysteresis"], exponents].concat());
    for (direction, points) in DIRECTIONS.into_iter().zip([&diagram.up, &diagram.down]) {
        for (point, apart) in points.iter().zip(apart) {
            let Some(point) = point else { continue };
            let [own, exponents] = M::cells(point);
            let first = vec![exact(point.value()), direction.into(), point.class().name()];
            table.rows.push([first, own, vec![hysteresis(*apart)], exponents].concat());
        }
    }
    table
}
