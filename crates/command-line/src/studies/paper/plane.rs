//! Planes of two parameters (figure 12).

use crate::Result;
use crate::studies::Study;
use crate::table::{csv_in_groups, exact};
use rayon::prelude::*;
use vibro_figures::canvas::palette::{BLUE, GREY, ORANGE};
use vibro_figures::chart::{Colour, Figure, Layer, Panel, Shape};
use vibro_studies::check_cells;
use vibro_studies::paper::ParameterSet;
use vibro_studies::paper::plane::{Method, ParameterAxis, Plane, SteadyStateClass, plane};

const LIGHT: Colour = Colour(205, 205, 205);
const PANEL: (u32, u32) = (1350, 1150);
/// Colour of points without a motion.
const PAPER: Colour = Colour(255, 255, 255);

/// Largest size of a row of the table, bytes.
const ROW: usize = 64;

/// Planes of pairs of parameters, classified by one theory; `done` is called after each row.
///
/// # Errors
/// An error if a pair is not a plane, if a range is not allowed, or if a plane does not fit into
/// memory.
pub fn planes(
    set: &ParameterSet,
    pairs: &[(ParameterAxis, ParameterAxis)],
    method: Method,
    done: &(dyn Fn() + Sync),
) -> Result<Study> {
    for (x, y) in pairs {
        check_cells("points of the plane", (x.count, y.count), size_of::<SteadyStateClass>() + ROW)?;
    }
    let planes =
        pairs.iter().map(|&(x, y)| Ok(plane(set, x, y, method, done)?)).collect::<Result<Vec<_>>>()?;
    let undefined = planes.iter().flat_map(|p| &p.classes).any(|c| *c == SteadyStateClass::Undefined);
    let mut panels: Vec<Panel> =
        planes.iter().enumerate().map(|(i, p)| panel(set, i, p, planes.len())).collect();
    if let Some(first) = panels.first_mut() {
        let entry = |name, colour, opacity| Layer::band(name, colour, opacity, Vec::new());
        first.layers.push(entry("one stable motion", BLUE, 1.0));
        first.layers.push(entry("motions exist, all unstable", LIGHT, 1.0));
        first.layers.push(entry("no motion with two symmetric impacts", PAPER, 1.0));
        if undefined {
            first.layers.push(entry("undefined", ORANGE, 1.0));
        }
    }
    let names: Vec<_> =
        pairs.iter().map(|(x, y)| format!("({}, {})", x.name.symbol(), y.name.symbol())).collect();
    // The caption of one plane leaves out both axes; with several planes each parameter holds in
    // some of them.
    let varied = if let [(x, y)] = pairs { vec![x.name, y.name] } else { Vec::new() };
    let figure = Figure {
        title: format!("Existence and stability, {} (cf. the paper's figure 12)", method.name()),
        caption: vec![format!("Elsewhere {}", set.caption_but(&varied))],
        columns: panels.len().clamp(1, 3),
        panels,
        panel: if pairs.len() == 1 { (2000, 1500) } else { PANEL },
        shared_legend: true,
    };
    let tables = planes.par_iter().map(csv).collect::<Result<Vec<_>>>()?;
    let remarks = planes.iter().map(shares).collect();
    let what =
        format!("existence and stability by {} on {} as in figure 12", method.name(), names.join(", "));
    Ok(Study { tables, figure: Some(figure), ..Study::without_figure("plane", what).with_remarks(remarks) })
}

fn panel(set: &ParameterSet, index: usize, plane: &Plane, count: usize) -> Panel {
    let (x, y) = (&plane.x, &plane.y);
    let (x_range, y_range) = (x.edges(), y.edges());
    let cells = Shape::Cells {
        x: x_range,
        y: y_range,
        columns: x.count,
        cells: plane.classes.iter().map(|c| *c as u8).collect(),
        colours: vec![None, Some(LIGHT), Some(BLUE), Some(ORANGE)],
    };
    let letter = char::from(b'a' + (index % 26) as u8);
    let pair = format!("({}, {})", set.symbol(x.name), set.symbol(y.name));
    Panel {
        title: if count > 1 { format!("({letter}) {pair}") } else { pair },
        x: crate::studies::parameter_axis(set, x.name, x_range),
        y: crate::studies::parameter_axis(set, y.name, y_range),
        layers: [vec![Layer::new("", GREY, cells)], crate::studies::here(set, x.name, y.name).into()]
            .concat(),
    }
}

fn csv(plane: &Plane) -> Result<(String, Vec<u8>)> {
    let (x, y) = (&plane.x, &plane.y);
    let xs: Vec<String> = (0..x.count).map(|i| exact(x.value(i))).collect();
    let text = csv_in_groups(&[x.name.name(), y.name.name(), "class"], y.count, |rows, j| {
        let value = exact(y.value(j));
        let classes = &plane.classes[j * x.count..];
        xs.iter().zip(classes).try_for_each(|(x, class)| rows.push([x, &value, class.name()]))
    })?;
    Ok((format!("plane-{}-{}", x.name.name(), y.name.name()), text))
}

fn shares(plane: &Plane) -> String {
    let part = |class: SteadyStateClass| {
        let count = plane.classes.iter().filter(|c| **c == class).count();
        100.0 * count as f64 / plane.classes.len() as f64
    };
    format!(
        "({}, {}): {:.1} % stable, {:.1} % unstable, {:.1} % without such a motion",
        plane.x.name.name(),
        plane.y.name.name(),
        part(SteadyStateClass::Stable),
        part(SteadyStateClass::Unstable),
        part(SteadyStateClass::None)
    )
}
