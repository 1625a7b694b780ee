//! The picture of a motion: coordinates, forces of stops and friction, and the speeds of impacts over time.

use super::Record;
use vibro_assembly::description::Dimension;
use vibro_assembly::motion::EventKind;
use vibro_figures::canvas::palette::{BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION};
use vibro_figures::chart::{Axis, Colour, Dash, Figure, Layer, Mark, Panel, Path, THIN};

/// Colours of curves; no panel has more curves than these.
const COLOURS: [Colour; 8] = [BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK, GREY];
/// Most points of a curve.
const POINTS: usize = 4000;
/// Size of a panel in units of the drawing.
const PANEL: (u32, u32) = (2600, 900);
/// Lengths up to this, m, are shown in mm.
const SHORT: f64 = 0.1;
/// Half the size of the marks of impacts.
const SMALL: u32 = 8;

/// The picture; `None` where there are fewer than two samples.
pub fn figure(record: &Record, caption: Vec<String>) -> Option<Figure> {
    if record.rows.len() < 2 {
        return None;
    }
    let d = &record.assembly.description;
    let mut panels = Vec::new();
    for (dimension, label) in [(Dimension::Translation, "s (m)"), (Dimension::Rotation, "s (rad)")] {
        let bodies = d.bodies.iter().enumerate().filter(|(_, b)| b.dimension == dimension);
        let curves: Vec<_> = bodies.map(|(i, b)| (b.name.clone(), 3 * i)).collect();
        panels.extend(curves_over_time(record, "coordinates", label, &curves));
    }
    let first = 3 * (d.bodies.len() + d.springs.len());
    let contacts = d.stops.iter().map(|s| (&s.name, s.arms.dimension));
    let contacts = contacts.chain(d.frictions.iter().map(|f| (&f.name, f.arms.dimension)));
    let contacts: Vec<_> =
        contacts.enumerate().map(|(i, (name, dimension))| (name, dimension, first + 3 * i + 2)).collect();
    for (dimension, label) in [(Dimension::Translation, "f (N)"), (Dimension::Rotation, "f (N·m)")] {
        let these = contacts.iter().filter(|c| c.1 == dimension);
        // A stop that is never closed or pressed has no force to show.
        let acts = |column: usize| record.rows.iter().any(|row| row[1 + column] != 0.0);
        let curves: Vec<_> = these.filter(|c| acts(c.2)).map(|c| (c.0.clone(), c.2)).collect();
        panels.extend(curves_over_time(record, "forces of stops and friction", label, &curves));
    }
    panels.extend(impacts(record));
    let letters = 'a'..='z';
    for (letter, panel) in letters.zip(&mut panels) {
        panel.title = format!("({letter}) {}", panel.title);
    }
    Some(Figure { title: d.name.clone(), caption, panels, columns: 1, panel: PANEL, shared_legend: false })
}

fn time_axis(record: &Record) -> Axis {
    let time = |row: Option<&Vec<f64>>| row.map_or(0.0, |row| row[0]);
    Axis::over("time (s)", time(record.rows.first()), time(record.rows.last()))
}

fn curves_over_time(record: &Record, title: &str, label: &str, curves: &[(String, usize)]) -> Option<Panel> {
    if curves.is_empty() {
        return None;
    }
    let stride = record.rows.len().div_ceil(POINTS);
    let layers = curves.iter().zip(COLOURS).map(|((name, column), colour)| {
        let points: Path = record.rows.iter().step_by(stride).map(|row| (row[0], row[1 + column])).collect();
        Layer::line(name, colour, Dash::Solid, points).stroke(THIN)
    });
    let layers = layers.collect();
    // Small lengths are told in mm, so that the numbers at the axis are short.
    let sizes = record.rows.iter().flat_map(|row| curves.iter().map(|(_, column)| row[1 + column].abs()));
    let size = sizes.fold(0.0, f64::max);
    let y = match label {
        "s (m)" if size < SHORT => Axis::new("s (mm)").times(1e3),
        _ => Axis::new(label),
    };
    // Curves without a colour are left out, which the title says.
    let title = match curves.len() {
        all if all > COLOURS.len() => format!("{title}, the first {} of {all}", COLOURS.len()),
        _ => title.into(),
    };
    Some(Panel { title, x: time_axis(record), y, layers })
}

fn impacts(record: &Record) -> Option<Panel> {
    let d = &record.assembly.description;
    let mut layers = Vec::new();
    for (i, stop) in d.stops.iter().enumerate() {
        let hits = record.events.iter().filter_map(|event| match event.kind {
            EventKind::Impact { stop, speed, .. } if stop == i => Some((event.time, speed)),
            _ => None,
        });
        let hits: Path = hits.collect();
        if let (false, Some(&colour)) = (hits.is_empty(), COLOURS.get(layers.len())) {
            let stride = hits.len().div_ceil(POINTS);
            let points = hits.into_iter().step_by(stride).collect();
            layers.push(Layer::marks(&stop.name, colour, Mark::Disc, points).stroke(SMALL));
        }
    }
    let y = Axis::new("closing speed (SI)");
    let title = "impacts".into();
    (!layers.is_empty()).then(|| Panel { title, x: time_axis(record), y, layers })
}
