//! Poincaré sections of described machines.

use super::Study;
use super::design_sweep::Labelled;
use crate::table::{CsvRows, exact};
use crate::wording::{self, axis};
use crate::{Error, Result};
use std::fmt;
use vibro_figures::canvas::palette::FAMILY;
use vibro_figures::chart::{Axis, Figure, Layer, Mark, Panel, Path};
use vibro_machine::description::Dimension;
use vibro_studies::{
    Machine, Measure, PoincareRequest, QuantityName, Section, SectionPoint, columns, common_period,
};

/// Relative tolerance of equal points in the picture.
const SAME: f64 = 1e-6;
/// Cap on the count of distinct points.
const COUNTED: usize = 64;

/// A quantity of a point that an axis can show.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Number {
    Time,
    Phase,
    Speed,
    Column(usize),
}

/// Quantities on the axes of a section's picture, horizontal first.
#[derive(Clone, Debug)]
pub struct SectionAxes {
    numbers: [Number; 2],
    names: [String; 2],
}

impl fmt::Display for SectionAxes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.names.join(","))
    }
}

impl SectionAxes {
    /// Axes from two names with a comma between, or the default axes of the section.
    ///
    /// # Errors
    /// [`Error::Refused`] for another form and names that the section does not have.
    pub fn new(machine: &Machine, given: Option<&str>) -> Result<Self> {
        let d = &machine.description;
        let section = Section::of(d, &machine.section)?;
        let (is_driven, is_stop) = (common_period(d).is_some(), matches!(section, Section::Stop(_)));
        let own = || -> Option<String> {
            if is_driven && is_stop {
                return Some("phase,speed".into());
            }
            let body = Measure::usual(d).into_iter().find_map(|m| m.quantity().cloned())?.of;
            Some(format!("{body}.s,{body}.v"))
        };
        let text = given.map(str::to_owned).or_else(own).unwrap_or_default();
        let columns = columns(d);
        let number = |name: &str| -> Result<Number> {
            match name {
                "time" => Ok(Number::Time),
                "phase" if is_driven => Ok(Number::Phase),
                "speed" if is_stop => Ok(Number::Speed),
                _ => columns.iter().position(|own| own == name).map(Number::Column).ok_or_else(|| {
                    let further = ["time", "phase", "speed"];
                    let held = [true, is_driven, is_stop];
                    let further =
                        further.into_iter().zip(held).filter(|(_, held)| *held).map(|(name, _)| name);
                    let allowed: Vec<&str> = further.chain(columns.iter().map(String::as_str)).collect();
                    let fault = match name {
                        "speed" => "is a column of a section of a stop only",
                        "phase" => "is a column of a driven machine only",
                        _ => "is not a column of this section",
                    };
                    let problem = format!("{fault}; expected one of {}", allowed.join(", "));
                    Error::Refused { what: format!("--of {name}"), problem }
                }),
            }
        };
        let Some((x, y)) = text.split_once(',') else {
            return Err(Error::form(
                format!("--of {text}"),
                "two names separated by a comma, e.g. box.s,box.v",
            ));
        };
        let names = [x.trim().to_owned(), y.trim().to_owned()];
        Ok(Self { numbers: [number(&names[0])?, number(&names[1])?], names })
    }

    fn point(&self, of: &SectionPoint) -> Option<(f64, f64)> {
        let value = |number: Number| match number {
            Number::Time => Some(of.time),
            Number::Phase => of.phase,
            Number::Speed => of.speed,
            Number::Column(k) => Some(of.values[k]),
        };
        Some((value(self.numbers[0])?, value(self.numbers[1])?))
    }

    fn axis(&self, k: usize, machine: &Machine, largest: f64) -> Axis {
        let d = &machine.description;
        match self.numbers[k] {
            Number::Time => axis("time", "s", largest),
            Number::Phase => axis("phase", "rad", 1.0),
            Number::Speed => {
                let stop = match &Section::of(d, &machine.section) {
                    Ok(Section::Stop(i)) => d.stops.get(*i),
                    _ => None,
                };
                let turns = stop.is_some_and(|stop| stop.arms.dimension == Dimension::Rotation);
                axis("closing speed", if turns { "rad/s" } else { "m/s" }, largest)
            }
            Number::Column(_) => match self.names[k].parse::<QuantityName>() {
                Ok(name) => {
                    let unit = name.find(d).map_or("1", |found| found.unit);
                    axis(&wording::quantity(d, &name), unit, largest)
                }
                Err(_) => Axis::new(&self.names[k]),
            },
        }
    }
}

/// The study of a section: a table of all columns at its points, and a picture.
///
/// # Errors
/// [`Error::Output`].
pub fn section(
    machine: &Machine,
    request: &PoincareRequest,
    points: &[SectionPoint],
    axes: &SectionAxes,
    name: &str,
) -> Result<Study> {
    let d = &machine.description;
    let section = Section::of(d, &machine.section)?;
    let drawn: Path = points.iter().filter_map(|point| axes.point(point)).collect();
    let largest = |of: fn(&(f64, f64)) -> f64| drawn.iter().map(|p| of(p).abs()).fold(0.0, f64::max);
    let (x, y) = (largest(|p| p.0), largest(|p| p.1));
    let at = match request.phase {
        0.0 => section.in_words(d),
        phase => format!("{} at the phase {} rad", section.in_words(d), vibro_studies::significant(phase)),
    };
    let figure = Figure {
        title: format!("{}: section at {at}", wording::title(&d.name)),
        caption: vec![
            format!("{} points; up to {} periods discarded.", points.len(), request.discard),
            machine.caption_but(&[]),
        ],
        panels: vec![Panel {
            title: String::new(),
            x: axes.axis(0, machine, x),
            y: axes.axis(1, machine, y),
            layers: vec![Layer::marks("", FAMILY[0], Mark::Disc, drawn.clone()).stroke(5)],
        }],
        columns: 1,
        panel: (2100, 1700),
        shared_legend: false,
    };
    let what = format!("section at {at}: {} points", points.len());
    let remarks = match distinct(&drawn, (x, y)) {
        Some(count) => vec![format!("{count} distinct in the picture")],
        None => Vec::new(),
    };
    Ok(Study {
        tables: vec![(name.into(), table(machine, points)?)],
        figure: Some(figure),
        ..Study::without_figure(name, what).with_remarks(remarks)
    })
}

/// Number of distinct points, if it is small.
fn distinct(points: &[(f64, f64)], sizes: (f64, f64)) -> Option<usize> {
    let mut found: Vec<(f64, f64)> = Vec::new();
    for point in points {
        let is_near = |own: &(f64, f64)| {
            (own.0 - point.0).abs() <= SAME * sizes.0 && (own.1 - point.1).abs() <= SAME * sizes.1
        };
        if !found.iter().any(is_near) {
            found.push(*point);
        }
        if found.len() > COUNTED {
            return None;
        }
    }
    Some(found.len())
}

/// Table of the points: time, phase and closing speed if the section has them, and all columns.
fn table(machine: &Machine, points: &[SectionPoint]) -> Result<Vec<u8>> {
    let cell = |value: Option<f64>| value.map_or(String::new(), exact);
    let header = ["point", "time", "phase", "speed"].map(String::from);
    let mut table = CsvRows::new(header.into_iter().chain(columns(&machine.description)))?;
    for (k, point) in points.iter().enumerate() {
        let own = [k.to_string(), exact(point.time), cell(point.phase), cell(point.speed)];
        table.push(own.into_iter().chain(point.values.iter().map(|x| exact(*x))))?;
    }
    table.text()
}
