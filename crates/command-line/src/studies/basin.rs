//! Pictures and tables of basins of attraction of described machines.

use super::Study;
use super::design_sweep::Labelled;
use super::orbits::shown_axis;
use super::paper::basin::{FURTHER, NOT_SETTLED, OTHERS, OUTSIDE, PAIRS, ROW, UNDECIDED};
use crate::Result;
use crate::table::{TextTable, csv_in_groups, exact};
use rayon::prelude::*;
use vibro_figures::canvas::palette::GREY;
use vibro_figures::chart::{Axis, Colour, Figure, Layer, Panel, Shape};
use vibro_machine::description::{Body, Dimension};
use vibro_orbits::Orbit;
use vibro_studies::MotionClass;
use vibro_studies::basin::{BasinAttractor, BasinCell, BasinRequest, Basins, StartAxis};
use vibro_studies::check_cells;
use vibro_studies::significant;
use vibro_studies::{Machine, QuantityName};

/// Largest number of attractors that are listed, and of which the orbit is found.
const SHOWN: usize = 64;
/// Attractors with a colour of their own.
const COLOURED: usize = 2 * PAIRS.len();

/// Checks that a plane of starts and its table fit into memory.
///
/// # Errors
/// [`TooMany`](vibro_studies::Error::TooMany), with the number that would fit.
pub fn check_assembly_basins(request: &BasinRequest) -> Result<()> {
    let held = size_of::<BasinCell>() + ROW;
    Ok(check_cells("points of the plane", (request.x.count, request.y.count), held)?)
}

/// The study of a plane of starts.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn assembly_basins(
    machine: &Machine,
    request: &BasinRequest,
    basins: &Basins,
    name: &str,
) -> Result<Study> {
    let listed: Vec<Listed> = basins
        .attractors
        .par_iter()
        .take(SHOWN)
        .enumerate()
        .map(|(number, attractor)| Listed::new(machine, basins, number, attractor))
        .collect();
    let count = basins.attractors.len();
    let (x, y) = (&request.x, &request.y);
    let attractors = if count == 1 { "attractor" } else { "attractors" };
    let of = match (count, basins.rest.is_empty()) {
        (0, false) => "rest".to_owned(),
        (_, false) => format!("{count} {attractors} and of rest"),
        (_, true) => format!("{count} {attractors}"),
    };
    let what = format!("basins of {of} over {} and {}", x.name, y.name);
    let method = format!(
        "{} × {} starts; up to {} periods discarded, and more where nothing is decided then. Motions without a period count as one \
         attractor of their class.",
        x.count, y.count, request.discard
    );
    let mut layers = vec![Layer::new("", GREY, cells(request, basins))];
    layers.extend(legend(basins, &listed));
    let figure = Figure {
        title: format!("{}: basins of attraction", machine.description.name),
        caption: vec![method, format!("Elsewhere {}", machine.caption_but(&[]))],
        panels: vec![Panel { title: String::new(), x: axis(machine, x), y: axis(machine, y), layers }],
        columns: 1,
        panel: (2300, 1700),
        shared_legend: true,
    };
    Ok(Study {
        tables: vec![
            (name.into(), cell_table(request, basins)?),
            (format!("{name}-attractors"), attractor_table(&listed).csv()?),
        ],
        figure: Some(figure),
        ..Study::without_figure(name, what).with_remarks(remarks(machine, basins, &listed))
    })
}

/// An attractor with its orbit in words.
struct Listed {
    number: usize,
    attractor: BasinAttractor,
    share: f64,
    /// Events of a period; empty without a period or events, and where no orbit was found.
    word: String,
    /// The orbit's stability, or why it was not found.
    stability: String,
}

impl Listed {
    fn new(machine: &Machine, basins: &Basins, number: usize, attractor: &BasinAttractor) -> Self {
        let (word, stability) = match attractor.settled.class {
            MotionClass::Periodic(_) => match Orbit::settled(machine, &attractor.start, 0) {
                Ok(orbit) => (orbit.word().in_words(&orbit.place().assembly), orbit.stability().to_string()),
                Err(_) => (String::new(), "orbit not found".into()),
            },
            _ => (String::new(), String::new()),
        };
        let share = basins.share(BasinCell::Attractor(number as u16));
        Self { number: number + 1, attractor: attractor.clone(), share, word, stability }
    }

    fn class(&self) -> String {
        self.attractor.settled.class.name()
    }
}

/// Table of attractors: class, events, share of the plane, and a start on each.
fn attractor_table(listed: &[Listed]) -> TextTable {
    let mut header: Vec<String> =
        ["attractor", "class", "contacts", "rests", "interval", "share", "word", "stability"]
            .map(String::from)
            .into();
    let names = listed.first().map_or(Vec::new(), |one| one.attractor.start.numbers());
    header.extend(names.into_iter().map(|(name, _)| name));
    let mut table = TextTable { header, rows: Vec::new() };
    for one in listed {
        let settled = &one.attractor.settled;
        let mut row = vec![
            one.number.to_string(),
            one.class(),
            exact(settled.contacts),
            settled.rests.to_string(),
            exact(settled.interval),
            exact(one.share),
            one.word.clone(),
            one.stability.clone(),
        ];
        row.extend(one.attractor.start.numbers().into_iter().map(|(_, value)| exact(value)));
        table.rows.push(row);
    }
    table
}

/// Table of starts, each with the number of its attractor.
fn cell_table(request: &BasinRequest, basins: &Basins) -> Result<Vec<u8>> {
    let (x, y) = (&request.x, &request.y);
    let header = [x.name.as_str(), y.name.as_str(), "attractor", "class"];
    let classes: Vec<String> = basins.attractors.iter().map(|a| a.settled.class.name()).collect();
    let xs: Vec<String> = (0..x.count).map(|i| exact(x.value(i))).collect();
    csv_in_groups(&header, y.count, |rows, j| {
        let value = exact(y.value(j));
        xs.iter().zip(&basins.cells[j * x.count..]).try_for_each(|(x, cell)| {
            let (number, class) = match cell {
                BasinCell::Attractor(n) => ((n + 1).to_string(), classes[usize::from(*n)].as_str()),
                BasinCell::Outside => (String::new(), "outside"),
                BasinCell::NotSettled => (String::new(), "not settled"),
                BasinCell::Ended => (String::new(), "ended"),
                BasinCell::Rest => (String::new(), "rest"),
            };
            rows.push([x, &value, &number, class])
        })
    })
}

/// Difference of coordinates of one place of rest, relative to their size.
const ONE_PLACE: f64 = 1e-6;

/// The share of the motions that came to rest, and where; `None` where none did.
fn rest_in_words(machine: &Machine, basins: &Basins) -> Option<String> {
    let d = &machine.description;
    let bodies = d.bodies.iter().zip(&basins.rest).filter(|(body, _)| !body.is_inner());
    let places: Vec<_> = bodies.filter(|(body, _)| !body.kind.is_prescribed()).collect();
    if places.is_empty() {
        return None;
    }
    let unit = |body: &Body| if body.dimension == Dimension::Rotation { "rad" } else { "m" };
    let is_one = |[least, largest]: &[f64; 2]| largest - least <= ONE_PLACE * least.abs().max(largest.abs());
    let place = |(body, [least, largest]): &(&Body, &[f64; 2])| match is_one(&[*least, *largest]) {
        true => format!("{}.s = {} {}", body.name, significant(*least), unit(body)),
        false => {
            let (from, to) = (significant(*least), significant(*largest));
            format!("{}.s from {from} to {to} {}", body.name, unit(body))
        }
    };
    let count = basins.cells.iter().filter(|cell| **cell == BasinCell::Rest).count();
    let which = match basins.cells.len() {
        all if all == count => format!("all {count} motions"),
        all => format!("{count} of {all} motions"),
    };
    let how = match places.iter().all(|(_, range)| is_one(range)) {
        true => "at one place",
        false if d.frictions.is_empty() => "not at one place",
        false => "not at one place: friction holds a range",
    };
    Some(format!("{which} came to rest ({how}): {}", places.iter().map(place).collect::<Vec<_>>().join(", ")))
}

fn remarks(machine: &Machine, basins: &Basins, listed: &[Listed]) -> Vec<String> {
    let told = |one: &Listed| {
        let events = if one.word.is_empty() { String::new() } else { format!(" [{}]", one.word) };
        format!("attractor {}: {}{events}, {:.1} % of the starts", one.number, one.class(), 100.0 * one.share)
    };
    let mut lines: Vec<String> = listed.iter().map(told).collect();
    if basins.attractors.len() > SHOWN {
        lines.push(format!("and {} more", basins.attractors.len() - SHOWN));
    }
    lines.extend(rest_in_words(machine, basins));
    let ended = basins.ended.as_deref().unwrap_or_default();
    for (cell, words) in [
        (BasinCell::Outside, "violate a rigid stop".to_owned()),
        (BasinCell::NotSettled, "were not decided".into()),
        (BasinCell::Ended, format!("lead to motions that end: {ended}")),
    ] {
        if basins.cells.contains(&cell) {
            lines.push(format!("{:.1} % of the starts {words}", 100.0 * basins.share(cell)));
        }
    }
    lines
}

/// The colour of an attractor with a colour of its own.
fn colour(number: usize) -> Colour {
    PAIRS[number % PAIRS.len()][number / PAIRS.len()]
}

/// Colour of starts of motions that come to rest.
const REST: Colour = Colour(190, 190, 190);

/// Code of a cell in the picture: 0 to 3 for [`OTHERS`], 4 for [`REST`], then one for each
/// attractor.
fn code(cell: BasinCell) -> u8 {
    match cell {
        BasinCell::Rest => 4,
        BasinCell::Outside => 0,
        BasinCell::NotSettled => 1,
        BasinCell::Ended => 2,
        BasinCell::Attractor(n) if usize::from(n) < COLOURED => 5 + n as u8,
        BasinCell::Attractor(_) => 3,
    }
}

fn cells(request: &BasinRequest, basins: &Basins) -> Shape {
    Shape::Cells {
        x: (request.x.from, request.x.to),
        y: (request.y.from, request.y.to),
        columns: request.x.count,
        cells: basins.cells.iter().map(|cell| code(*cell)).collect(),
        colours: OTHERS.into_iter().chain([REST]).chain((0..COLOURED).map(colour)).map(Some).collect(),
    }
}

/// Entries of the legend: each attractor with a colour, all others together, then cells without
/// one.
fn legend(basins: &Basins, listed: &[Listed]) -> Vec<Layer> {
    /// Longest list of events in an entry.
    const LONGEST: usize = 48;
    let entry = |name: &str, colour| Layer::band(name, colour, 1.0, Vec::new());
    let name = |one: &Listed| match one.word.len() {
        0 => format!("{}: {}", one.number, one.class()),
        length if length <= LONGEST => format!("{}: {} {}", one.number, one.class(), one.word),
        _ => format!("{}: {} {} events", one.number, one.class(), one.word.split(", ").count()),
    };
    let mut layers: Vec<Layer> =
        listed.iter().take(COLOURED).enumerate().map(|(k, one)| entry(&name(one), colour(k))).collect();
    let others = [
        (basins.attractors.len() > COLOURED, "further attractors", FURTHER),
        (basins.cells.contains(&BasinCell::NotSettled), "not settled", NOT_SETTLED),
        (basins.cells.contains(&BasinCell::Rest), "comes to rest", REST),
        (basins.cells.contains(&BasinCell::Ended), "motion ends", UNDECIDED),
        (basins.cells.contains(&BasinCell::Outside), "no start: a rigid stop is violated", OUTSIDE),
    ];
    layers.extend(others.into_iter().filter(|o| o.0).map(|(_, name, colour)| entry(name, colour)));
    layers
}

fn axis(machine: &Machine, axis: &StartAxis) -> Axis {
    let quantity = axis.name.parse::<QuantityName>().ok();
    let unit = quantity.and_then(|q| q.find(&machine.description).ok()).map_or("s", |found| found.unit);
    let shown = shown_axis(&format!("at the start: {}", axis.name), unit, axis.from.abs().max(axis.to.abs()));
    Axis { range: Some((axis.from, axis.to)), ..shown }
}
