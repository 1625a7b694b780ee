//! The picture of a motion: coordinates, speeds of sliding, forces of stops and friction, loops of
//! friction, and the speeds of impacts.

mod loops;

use super::{MotionRecord, forces_of, is_contact};
use crate::wording::{self, ORDINALS, axis, spoken};
use vibro_figures::chart::{Axis, COLOURS, Figure, Layer, Mark, Panel, Path, STYLES, THIN, lettered, style};
use vibro_machine::description::Dimension;
use vibro_machine::motion::EventKind;
use vibro_machine::{Element, Quantity, What};
use vibro_studies::Extreme;

/// Largest number of samples in a curve; its extremes between samples are added to them.
const POINTS: usize = 4000;
/// Size of a panel in units of the drawing.
const PANEL: (u32, u32) = (2600, 900);
/// Distance, relative to a curve's size, below which two points count as equal.
const SAME: f64 = 1e-9;
/// Half the size of the marks of impacts.
const SMALL: u32 = 8;

/// Nouns and units of a dimension.
#[derive(Clone, Copy)]
struct Words {
    dimension: Dimension,
    coordinate: &'static str,
    unit: &'static str,
    speed: &'static str,
    rate: &'static str,
    force: &'static str,
    force_unit: &'static str,
}

/// The dimensions in the order of their panels.
const WORDS: [Words; 2] = [
    Words {
        dimension: Dimension::Translation,
        coordinate: "displacement",
        unit: "m",
        speed: "relative velocity",
        rate: "m/s",
        force: "force",
        force_unit: "N",
    },
    Words {
        dimension: Dimension::Rotation,
        coordinate: "angle",
        unit: "rad",
        speed: "relative angular velocity",
        rate: "rad/s",
        force: "torque",
        force_unit: "N.m",
    },
];

/// The picture; `None` if there are fewer than two samples.
pub fn figure(record: &MotionRecord, caption: Vec<String>) -> Option<Figure> {
    if record.rows.len() < 2 {
        return None;
    }
    let d = &record.assembly.description;
    let mut panels = Vec::new();
    for Words { dimension, coordinate, unit, .. } in WORDS {
        let bodies = d.bodies.iter().enumerate().filter(|(_, b)| b.dimension == dimension && !b.is_inner());
        let curves =
            bodies.filter_map(|(i, b)| curve(record, spoken(&b.name), Quantity::of_body(i, What::S)));
        panels.extend(curves_over_time(record, coordinate, unit, curves.collect()));
    }
    // Without stops, sliding and sticking are all that happens.
    if d.stops.is_empty() {
        panels
            .extend(WORDS.into_iter().filter_map(|own| sliding(record, own.dimension, own.speed, own.rate)));
    }
    for Words { dimension, force, force_unit, .. } in WORDS {
        let of = |e: &Element| is_contact(*e) && e.dimension(d) == dimension;
        let these = d.elements().enumerate().filter(|(_, element)| of(element));
        let forces = these.flat_map(|(i, e)| forces_of(i, e).map(move |quantity| (e.name(), quantity)));
        let curves = forces.filter_map(|(name, quantity)| match quantity.what {
            What::F => curve(record, spoken(name), quantity),
            What::TangentF(Some(k)) => {
                curve(record, format!("{}, {} tangential", spoken(name), ORDINALS[k]), quantity)
            }
            _ => curve(record, format!("{}, tangential", spoken(name)), quantity),
        });
        // A stop without a force at any time has no curve.
        let curves = curves.filter(|curve| curve.size() != 0.0).collect();
        panels.extend(curves_over_time(record, force, force_unit, curves));
    }
    panels.extend(loops::panel(record));
    panels.extend(WORDS.into_iter().filter_map(|own| impacts(record, own.dimension, own.rate)));
    lettered(&mut panels);
    let title = wording::title(&d.name);
    Some(Figure { title, caption, panels, columns: 1, panel: PANEL, shared_legend: false })
}

fn time_axis(record: &MotionRecord) -> Axis {
    let time = |row: Option<&Vec<f64>>| row.map_or(0.0, |row| row[0]);
    let (from, to) = (time(record.rows.first()), time(record.rows.last()));
    Axis { range: Some((from, to)), ..axis("time", "s", from.abs().max(to.abs())) }
}

/// A drawn quantity: its name and its points in order of time.
struct MotionCurve {
    name: String,
    points: Path,
}

impl MotionCurve {
    /// Largest absolute value.
    fn size(&self) -> f64 {
        self.points.iter().fold(0.0, |most, point| most.max(point.1.abs()))
    }

    /// Whether both curves have the same points, apart from rounding.
    fn equals(&self, other: &Self, size: f64) -> bool {
        let near = |(a, b): (&(f64, f64), &(f64, f64))| (a.1 - b.1).abs() <= SAME * size;
        self.points.len() == other.points.len() && self.points.iter().zip(&other.points).all(near)
    }
}

/// A quantity at the samples, at most [`POINTS`] of them.
fn samples(record: &MotionRecord, quantity: Quantity) -> Option<Path> {
    let column = record.assembly.description.quantities().position(|column| column == quantity)?;
    let stride = record.rows.len().div_ceil(POINTS);
    Some(record.rows.iter().step_by(stride).map(|row| (row[0], row[1 + column])).collect())
}

/// The curve of a quantity by its samples and its extremes, so that peaks between samples are drawn.
fn curve(record: &MotionRecord, name: String, quantity: Quantity) -> Option<MotionCurve> {
    let extreme: &Extreme = record.extreme(quantity)?;
    let mut points = samples(record, quantity)?;
    points.extend(extreme.points());
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Apart from rounding, samples coincide with ends of flights.
    let end = points.last().map_or(0.0, |point| point.0);
    let near = |a: f64, b: f64, size: f64| (a - b).abs() <= SAME * size;
    points.dedup_by(|b, a| near(a.0, b.0, end) && near(a.1, b.1, extreme.largest));
    Some(MotionCurve { name, points })
}

/// The distinct curves. The name of a curve lists all curves that are equal to it.
fn distinct(curves: Vec<MotionCurve>) -> Vec<MotionCurve> {
    let size = curves.iter().map(MotionCurve::size).fold(0.0, f64::max);
    let mut found: Vec<MotionCurve> = Vec::new();
    for curve in curves {
        match found.iter_mut().find(|own| own.equals(&curve, size)) {
            Some(own) => own.name += &format!(" = {}", curve.name),
            None => found.push(curve),
        }
    }
    found
}

/// A panel of curves over time. A single curve is named on the axis; several have a legend.
fn curves_over_time(
    record: &MotionRecord,
    noun: &str,
    unit: &str,
    curves: Vec<MotionCurve>,
) -> Option<Panel> {
    let size = curves.iter().map(MotionCurve::size).fold(0.0, f64::max);
    let curves = distinct(curves);
    let words = match &curves[..] {
        [] => return None,
        [one] => format!("{noun} of {}", one.name),
        _ => noun.to_owned(),
    };
    // Curves without a style are left out, as the title states.
    let title = match curves.len() {
        all if all > STYLES => format!("the first {STYLES} of {all}"),
        _ => String::new(),
    };
    let one = curves.len() == 1;
    let layers = curves.into_iter().take(STYLES).enumerate().map(|(k, curve)| {
        let (colour, dash) = style(k);
        Layer::line(if one { "" } else { &curve.name }, colour, dash, curve.points).stroke(THIN)
    });
    let layers = layers.collect();
    Some(Panel { title, x: time_axis(record), y: axis(&words, unit, size), layers })
}

/// Speeds of sliding of frictions.
fn sliding(record: &MotionRecord, dimension: Dimension, noun: &str, unit: &str) -> Option<Panel> {
    let d = &record.assembly.description;
    let is_friction = |e: &Element| matches!(e, Element::Friction(_)) && e.dimension(d) == dimension;
    let these = d.elements().enumerate().filter(|(_, element)| is_friction(element));
    let curves = these.filter_map(|(i, element)| {
        let points = samples(record, Quantity::of_element(i, What::Rate))?;
        Some(MotionCurve { name: spoken(element.name()), points })
    });
    curves_over_time(record, noun, unit, curves.collect())
}

fn impacts(record: &MotionRecord, dimension: Dimension, unit: &str) -> Option<Panel> {
    let d = &record.assembly.description;
    let mut all: Vec<(String, Path)> = Vec::new();
    for (i, stop) in d.stops.iter().enumerate().filter(|(_, stop)| stop.arms.dimension == dimension) {
        let hits = record.events.iter().filter_map(|event| match event.kind {
            EventKind::Impact { stop, speed, .. } if stop == i => Some((event.time, speed)),
            _ => None,
        });
        let hits: Path = hits.collect();
        if !hits.is_empty() && all.len() < STYLES {
            let stride = hits.len().div_ceil(POINTS);
            all.push((spoken(&stop.name), hits.into_iter().step_by(stride).collect()));
        }
    }
    let largest = all.iter().flat_map(|own| &own.1).fold(0.0, |most: f64, hit| most.max(hit.1));
    let words = match &all[..] {
        [] => return None,
        [(name, _)] => format!("closing speed of {name}"),
        _ => "closing speed".into(),
    };
    let one = all.len() == 1;
    let layers = all.into_iter().enumerate().map(|(k, (name, points))| {
        let mark = if k < COLOURS { Mark::Disc } else { Mark::Ring };
        Layer::marks(if one { "" } else { &name }, style(k).0, mark, points).stroke(SMALL)
    });
    let y = axis(&words, unit, largest);
    Some(Panel { title: String::new(), x: time_axis(record), y, layers: layers.collect() })
}
