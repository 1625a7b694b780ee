//! Pictures and tables of basins of attraction.

use super::Study;
use super::lengths::Lengths;
use crate::Result;
use crate::figures::canvas::palette::{BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION};
use crate::figures::chart::{Axis, Colour, Figure, Layer, Panel, Shape};
use crate::table::{Table, csv_in_groups, exact};
use vibro_analysis::ParameterSet;
use vibro_analysis::attractor::{Attractor, MotionClass};
use vibro_analysis::basin::{Basin, Destination, InitialValueAxis, Request};
use vibro_analysis::plane::check_cells;
use vibro_analysis::stroboscopic::COORDINATES;

/// Colours of attractors and of their mirror images; more share the last.
const PAIRS: [[Colour; 2]; 4] =
    [[BLUE, SKY], [VERMILLION, ORANGE], [GREEN, Colour(150, 220, 190)], [PURPLE, Colour(240, 200, 225)]];

/// Starts outside the stops.
const OUTSIDE: Colour = Colour(235, 235, 235);
/// Most attractors that are shown and listed: their numbers fit into the codes of a picture's cells.
const SHOWN: usize = 101;

/// The most that a row of the table takes, bytes.
const ROW: usize = 64;

/// Checks that a plane of starts fits into memory with its table, before it is computed.
///
/// # Errors
/// [`TooMany`](vibro_analysis::Error::TooMany), with the number that would fit.
pub fn check_basins(request: &Request) -> Result<()> {
    let held = size_of::<Destination>() + ROW;
    Ok(check_cells("points of the plane", (request.x.count, request.y.count), held)?)
}

/// The study of a plane of starts.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn basins(set: &ParameterSet, request: &Request, basin: &Basin, name: &str) -> Result<Study> {
    let what = format!("basins of {} attractors, mirror images counted once", basin.attractors.len());
    Ok(Study {
        tables: vec![
            (name.into(), cell_table(request, basin)?),
            (format!("{name}-attractors"), attractor_table(basin).csv()?),
        ],
        figure: Some(figure(set, request, basin)),
        ..Study::without_figure(name, what).with_remarks(remarks(basin)).with_set(set)
    })
}

/// The attractors that are shown, with their indices and the names of their classes.
fn shown(basin: &Basin) -> impl Iterator<Item = (usize, &Attractor, String)> {
    let named = |(i, a)| (i, a, MotionClass::of(a, None).name());
    basin.attractors.iter().take(SHOWN).enumerate().map(named)
}

/// Each attractor with the shares of its basin and of its mirror image's.
fn attractor_table(basin: &Basin) -> Table {
    let mut table = Table::new(&[
        "attractor",
        "class",
        "impacts_upper",
        "impacts_lower",
        "rms_X1",
        "rms_X2",
        "rms_X3",
        "share",
        "share_of_mirror_image",
    ]);
    for (index, attractor, class) in shown(basin) {
        let mut row = vec![(index + 1).to_string(), class];
        row.extend(attractor.impacts.iter().chain(&attractor.sizes).map(|x| exact(*x)));
        row.extend(basin.shares(index as u16).map(exact));
        table.rows.push(row);
    }
    table
}

/// Each start with the number of its attractor.
fn cell_table(request: &Request, basin: &Basin) -> Result<Vec<u8>> {
    let (x, y) = (&request.x, &request.y);
    let header = [COORDINATES[x.coordinate], COORDINATES[y.coordinate], "attractor", "mirror_image"];
    let xs: Vec<String> = (0..x.count).map(|i| exact(x.value(i))).collect();
    csv_in_groups(&header, y.count, |rows, j| {
        let value = exact(y.value(j));
        xs.iter().zip(&basin.cells[j * x.count..]).try_for_each(|(x, destination)| {
            let (number, mirror) = match destination {
                Destination::Outside => (String::new(), ""),
                Destination::Attractor(n) => ((n + 1).to_string(), "false"),
                Destination::Mirror(n) => ((n + 1).to_string(), "true"),
            };
            rows.push([x, &value, &number, mirror])
        })
    })
}

fn remarks(basin: &Basin) -> Vec<String> {
    let remark = |(index, attractor, class): (usize, &Attractor, String)| {
        let [own, mirror] = basin.shares(index as u16);
        format!(
            "attractor {}: {class}, {} + {} impacts a period, {:.1} % of the starts, its mirror image {:.1} %",
            index + 1,
            exact(attractor.impacts[0]),
            exact(attractor.impacts[1]),
            100.0 * own,
            100.0 * mirror
        )
    };
    shown(basin).map(remark).collect()
}

fn colour(index: usize, mirror: bool) -> Colour {
    PAIRS[index.min(PAIRS.len() - 1)][usize::from(mirror)]
}

/// The cells of the plane: code 0 for starts outside the stops, then two codes for each attractor and its mirror image.
fn cells(request: &Request, basin: &Basin) -> Shape {
    const LAST: u16 = SHOWN as u16 - 1;
    let code = |destination: &Destination| match destination {
        Destination::Outside => 0,
        Destination::Attractor(n) => 1 + 2 * (*n).min(LAST) as u8,
        Destination::Mirror(n) => 2 + 2 * (*n).min(LAST) as u8,
    };
    let mut colours = vec![Some(OUTSIDE)];
    colours.extend(shown(basin).flat_map(|(i, ..)| [Some(colour(i, false)), Some(colour(i, true))]));
    Shape::Cells {
        x: (request.x.from, request.x.to),
        y: (request.y.from, request.y.to),
        columns: request.x.count,
        cells: basin.cells.iter().map(code).collect(),
        colours,
    }
}

/// Entries of the legend: each attractor with a colour of its own, and its mirror image where there is one.
fn legend(basin: &Basin) -> Vec<Layer> {
    let entry = |name: &str, colour| Layer::band(name, colour, 1.0, Vec::new());
    let mut layers = Vec::new();
    for (index, _, class) in shown(basin).take(PAIRS.len()) {
        let title = format!("{}: {class}", index + 1);
        layers.push(entry(&title, colour(index, false)));
        if basin.shares(index as u16)[1] > 0.0 {
            layers.push(entry(&format!("{title}, mirror image"), colour(index, true)));
        }
    }
    if basin.cells.contains(&Destination::Outside) {
        layers.push(entry("no start: outside the stops", OUTSIDE));
    }
    layers
}

fn axis(lengths: &Lengths, axis: &InitialValueAxis) -> Axis {
    const SYMBOLS: [&str; 3] = ["X₁", "X₂", "X₃"];
    let shown = match axis.coordinate {
        i @ 0..3 => lengths.axis(&lengths.displacement(SYMBOLS[i])),
        i => lengths.rates(&[SYMBOLS[i - 3]]),
    };
    Axis { label: format!("at the start: {}", shown.label), range: Some((axis.from, axis.to)), ..shown }
}

fn figure(set: &ParameterSet, request: &Request, basin: &Basin) -> Figure {
    let mut layers = vec![Layer::new("", GREY, cells(request, basin))];
    layers.extend(legend(basin));
    let method = format!(
        "{} × {} starts, the other initial values zero; {} periods discarded.",
        request.x.count, request.y.count, request.discard
    );
    let lengths = Lengths::of(set);
    let (x, y) = (axis(&lengths, &request.x), axis(&lengths, &request.y));
    Figure {
        title: "Basins of attraction".into(),
        caption: vec![method, set.caption()],
        panels: vec![Panel { title: String::new(), x, y, layers }],
        columns: 1,
        panel: (2300, 1700),
        shared_legend: true,
    }
}
