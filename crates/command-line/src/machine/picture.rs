//! The picture of a motion: coordinates, forces of stops and friction, and the speeds of impacts
//! over time.

use super::{MotionRecord, forces_of, is_contact};
use vibro_figures::canvas::palette::{BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION};
use vibro_figures::chart::{Axis, Colour, Dash, Figure, Layer, Mark, Panel, Path, THIN};
use vibro_machine::description::Dimension;
use vibro_machine::motion::EventKind;
use vibro_machine::{Element, Quantity, What};
use vibro_studies::Extreme;

/// Colours of curves; no panel has more curves.
const COLOURS: [Colour; 8] = [BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK, GREY];
/// Largest number of samples in a curve; its extremes between samples are added to them.
const POINTS: usize = 4000;
/// Size of a panel in units of the drawing.
const PANEL: (u32, u32) = (2600, 900);
/// Distance, relative to a curve's size, below which two points count as equal.
const SAME: f64 = 1e-9;
/// Lengths up to this, m, are shown in mm.
const SHORT: f64 = 0.1;
/// Half the size of the marks of impacts.
const SMALL: u32 = 8;

/// The picture; `None` if there are fewer than two samples.
pub fn figure(record: &MotionRecord, caption: Vec<String>) -> Option<Figure> {
    if record.rows.len() < 2 {
        return None;
    }
    let d = &record.assembly.description;
    let mut panels = Vec::new();
    for (dimension, label) in [(Dimension::Translation, "s (m)"), (Dimension::Rotation, "s (rad)")] {
        let bodies = d.bodies.iter().enumerate().filter(|(_, b)| b.dimension == dimension && !b.is_inner());
        let coordinate = |i| Quantity::of_body(i, What::S);
        let curves: Vec<_> =
            bodies.filter_map(|(i, b)| curve(record, b.name.clone(), coordinate(i))).collect();
        panels.extend(curves_over_time(record, "coordinates", label, &curves));
    }
    for (dimension, label) in [(Dimension::Translation, "f (N)"), (Dimension::Rotation, "f (N·m)")] {
        let of = |e: &Element| is_contact(*e) && e.dimension(d) == dimension;
        let these = d.elements().enumerate().filter(|(_, element)| of(element));
        let forces = these.flat_map(|(i, e)| forces_of(i, e).map(move |quantity| (e.name(), quantity)));
        let curves = forces.filter_map(|(name, quantity)| match quantity.what {
            What::F => curve(record, name.to_owned(), quantity),
            what => curve(record, format!("{name}.{}", what.word()), quantity),
        });
        // A stop without a force at any time has no curve.
        let curves: Vec<_> = curves.filter(|curve| curve.extreme.largest != 0.0).collect();
        panels.extend(curves_over_time(record, "forces of stops and friction", label, &curves));
    }
    for (dimension, label) in
        [(Dimension::Translation, "closing speed (m/s)"), (Dimension::Rotation, "closing speed (rad/s)")]
    {
        panels.extend(impacts(record, dimension, label));
    }
    let letters = 'a'..='z';
    for (letter, panel) in letters.zip(&mut panels) {
        panel.title = format!("({letter}) {}", panel.title);
    }
    Some(Figure { title: d.name.clone(), caption, panels, columns: 1, panel: PANEL, shared_legend: false })
}

fn time_axis(record: &MotionRecord) -> Axis {
    let time = |row: Option<&Vec<f64>>| row.map_or(0.0, |row| row[0]);
    Axis::over("time (s)", time(record.rows.first()), time(record.rows.last()))
}

fn curve(record: &MotionRecord, name: String, quantity: Quantity) -> Option<MotionCurve<'_>> {
    let column = record.assembly.description.quantities().position(|column| column == quantity)?;
    Some(MotionCurve { name, column, extreme: record.extreme(quantity)? })
}

/// A drawn quantity: its name, its column in the samples, and its extremes between samples.
struct MotionCurve<'a> {
    name: String,
    column: usize,
    extreme: &'a Extreme,
}

impl MotionCurve<'_> {
    /// Samples and extremes in order of time, so that no peak between samples is lost.
    fn points(&self, record: &MotionRecord) -> Path {
        let stride = record.rows.len().div_ceil(POINTS);
        let samples = record.rows.iter().step_by(stride).map(|row| (row[0], row[1 + self.column]));
        let mut points: Path = samples.chain(self.extreme.points()).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Apart from rounding, samples coincide with ends of flights.
        let end = points.last().map_or(0.0, |point| point.0);
        let near = |a: f64, b: f64, size: f64| (a - b).abs() <= SAME * size;
        points.dedup_by(|b, a| near(a.0, b.0, end) && near(a.1, b.1, self.extreme.largest));
        points
    }
}

fn curves_over_time(
    record: &MotionRecord,
    title: &str,
    label: &str,
    curves: &[MotionCurve],
) -> Option<Panel> {
    if curves.is_empty() {
        return None;
    }
    let layers = curves.iter().zip(COLOURS).map(|(curve, colour)| {
        Layer::line(&curve.name, colour, Dash::Solid, curve.points(record)).stroke(THIN)
    });
    let layers = layers.collect();
    // Small lengths are shown in mm, so that the numbers on the axis are short.
    let size = curves.iter().map(|curve| curve.extreme.largest).fold(0.0, f64::max);
    let y = match label {
        "s (m)" if size < SHORT => Axis::new("s (mm)").times(1e3),
        _ => Axis::new(label),
    };
    // Curves without a colour are left out, as the title states.
    let title = match curves.len() {
        all if all > COLOURS.len() => format!("{title}, the first {} of {all}", COLOURS.len()),
        _ => title.into(),
    };
    Some(Panel { title, x: time_axis(record), y, layers })
}

fn impacts(record: &MotionRecord, dimension: Dimension, label: &str) -> Option<Panel> {
    let d = &record.assembly.description;
    let mut layers = Vec::new();
    for (i, stop) in d.stops.iter().enumerate().filter(|(_, stop)| stop.arms.dimension == dimension) {
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
    let y = Axis::new(label);
    let title = "impacts".into();
    (!layers.is_empty()).then(|| Panel { title, x: time_axis(record), y, layers })
}
