//! Pictures and tables of basins of attraction.

use super::Study;
use crate::figures::canvas::palette::{BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION};
use crate::figures::chart::{Axis, Colour, Figure, Layer, Panel, Shape};
use crate::table::{Table, exact};
use crate::{Error, Result};
use vibro_analysis::ParameterSet;
use vibro_analysis::attractor::MotionClass;
use vibro_analysis::basin::{Basin, Destination, InitialValueAxis, Request};
use vibro_analysis::stroboscopic::COORDINATES;

/// Colours of attractors and of their mirror images; more share the last.
const PAIRS: [[Colour; 2]; 4] =
    [[BLUE, SKY], [VERMILLION, ORANGE], [GREEN, Colour(150, 220, 190)], [PURPLE, Colour(240, 200, 225)]];

/// The study of a plane of starts.
///
/// # Errors
/// [`Error::Output`].
pub fn basins(set: &ParameterSet, request: &Request, basin: &Basin, name: &str) -> Result<Study> {
    let label = |axis: &InitialValueAxis| {
        let (symbol, unit) = match axis.coordinate {
            i @ 0..3 => (format!("X{}", ["₁", "₂", "₃"][i]), "units of L"),
            i => (format!("dX{}/dτ", ["₁", "₂", "₃"][i - 3]), "units of L"),
        };
        Axis::over(format!("{symbol} at τ = 0 ({unit})"), axis.from, axis.to)
    };
    let colour = |number: usize, mirror: bool| PAIRS[number.min(PAIRS.len() - 1)][usize::from(mirror)];
    let code = |destination: &Destination| match destination {
        Destination::Outside => 0,
        Destination::Attractor(n) => 1 + 2 * (*n).min(100) as u8,
        Destination::Mirror(n) => 2 + 2 * (*n).min(100) as u8,
    };
    let mut colours = vec![Some(Colour(235, 235, 235))];
    let mut layers = Vec::new();
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
    let mut remarks = Vec::new();
    let shown: Vec<_> = basin.attractors.iter().take(101).enumerate().collect();
    for (number, attractor) in shown {
        colours.extend([Some(colour(number, false)), Some(colour(number, true))]);
        let [own, mirror] = basin.shares(number as u16);
        let class = MotionClass::of(attractor, None).name();
        let title = format!("{}: {class}", number + 1);
        if number < PAIRS.len() {
            layers.push(Layer::band(&title, colour(number, false), 1.0, Vec::new()));
            if mirror > 0.0 {
                let image = format!("{title}, mirror image");
                layers.push(Layer::band(&image, colour(number, true), 1.0, Vec::new()));
            }
        }
        remarks.push(format!(
            "attractor {}: {class}, {} + {} impacts a period, {:.1} % of the starts, its mirror image {:.1} %",
            number + 1, exact(attractor.impacts[0]), exact(attractor.impacts[1]), 100.0 * own, 100.0 * mirror
        ));
        let mut row = vec![(number + 1).to_string(), class];
        row.extend(attractor.impacts.iter().chain(&attractor.sizes).map(|x| exact(*x)));
        row.extend([own, mirror].map(exact));
        table.rows.push(row);
    }
    if basin.cells.contains(&Destination::Outside) {
        layers.push(Layer::band("no start: outside the stops", Colour(235, 235, 235), 1.0, Vec::new()));
    }
    let cells = Shape::Cells {
        x: (request.x.from, request.x.to),
        y: (request.y.from, request.y.to),
        columns: request.x.count,
        cells: basin.cells.iter().map(code).collect(),
        colours,
    };
    layers.insert(0, Layer::new("", GREY, cells));
    let panel = Panel { title: String::new(), x: label(&request.x), y: label(&request.y), layers };
    let figure = Figure {
        title: "Basins of attraction".into(),
        caption: vec![
            format!(
                "{} × {} starts, the other initial values zero; {} periods discarded. Past the paper.",
                request.x.count, request.y.count, request.discard
            ),
            set.caption(),
        ],
        panels: vec![panel],
        columns: 1,
        panel: (2300, 1700),
        shared_legend: true,
    };
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut put = |row: [&str; 4]| writer.write_record(row).map_err(Error::output("a table"));
    put([COORDINATES[request.x.coordinate], COORDINATES[request.y.coordinate], "attractor", "mirror_image"])?;
    for (j, row) in basin.cells.chunks(request.x.count).enumerate() {
        for (i, destination) in row.iter().enumerate() {
            let (number, mirror) = match destination {
                Destination::Outside => (String::new(), String::new()),
                Destination::Attractor(n) => ((n + 1).to_string(), "false".into()),
                Destination::Mirror(n) => ((n + 1).to_string(), "true".into()),
            };
            put([&exact(request.x.value(i)), &exact(request.y.value(j)), &number, &mirror])?;
        }
    }
    let cells = writer.into_inner().map_err(Error::output("a table"))?;
    Ok(Study {
        name: name.into(),
        what: format!("basins of {} attractors, mirror images counted once", basin.attractors.len()),
        tables: vec![(name.into(), cells), (format!("{name}-attractors"), table.csv()?)],
        shown: None,
        figure: Some(figure),
        remarks,
    })
}
