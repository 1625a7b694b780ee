//! Pictures and tables of basins of attraction.

use super::lengths::Lengths;
use crate::Result;
use crate::studies::Study;
use crate::table::{TextTable, csv_in_groups, exact};
use vibro_figures::canvas::palette::GREY;
use vibro_figures::chart::{Axis, Colour, Figure, Layer, Panel, Shape};
use vibro_studies::check_cells;
use vibro_studies::paper::ParameterSet;
use vibro_studies::paper::attractor::Attractor;
use vibro_studies::paper::basin::{Basin, BasinRequest, Destination, InitialValueAxis};
use vibro_studies::paper::stroboscopic::COORDINATES;
use vibro_studies::paper::verdict::PROLONGED;

/// Colours of the first attractors and of their mirror images. Each differs in lightness from all
/// others and from [`OTHERS`].
pub const PAIRS: [[Colour; 2]; 8] = [
    [Colour(0, 65, 111), Colour(0, 145, 248)],
    [Colour(172, 57, 0), Colour(250, 167, 125)],
    [Colour(0, 83, 42), Colour(0, 176, 88)],
    [Colour(201, 0, 134), Colour(251, 176, 226)],
    [Colour(94, 0, 226), Colour(185, 145, 241)],
    [Colour(144, 108, 0), Colour(251, 207, 75)],
    [Colour(180, 0, 0), Colour(246, 148, 148)],
    [Colour(0, 137, 137), Colour(0, 251, 251)],
];
/// Colours of other cells: starts outside the stops; motions that have not settled; motions on one
/// of several chaotic attractors that could not be told apart; all attractors beyond [`PAIRS`].
pub const OTHERS: [Colour; 4] =
    [Colour(235, 235, 235), Colour(132, 132, 132), Colour(45, 45, 45), Colour(20, 20, 20)];
pub(in crate::studies) const OUTSIDE: Colour = OTHERS[0];
pub(in crate::studies) const NOT_SETTLED: Colour = OTHERS[1];
pub(in crate::studies) const UNDECIDED: Colour = OTHERS[2];
pub(in crate::studies) const FURTHER: Colour = OTHERS[3];

/// Largest number of attractors that are listed.
const SHOWN: usize = 101;

/// Largest size of a row of the table, bytes.
pub(in crate::studies) const ROW: usize = 64;

/// Checks that a plane of starts and its table fit into memory.
///
/// # Errors
/// [`TooMany`](vibro_studies::Error::TooMany), with the number that would fit.
pub fn check_basins(request: &BasinRequest) -> Result<()> {
    let held = size_of::<Destination>() + ROW;
    Ok(check_cells("points of the plane", (request.x.count, request.y.count), held)?)
}

/// The study of a plane of starts.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn basins(set: &ParameterSet, request: &BasinRequest, basin: &Basin, name: &str) -> Result<Study> {
    let count = basin.attractors.len();
    let attractors = if count == 1 { "attractor" } else { "attractors" };
    let what = format!("basins of {count} {attractors}, mirror images counted once");
    Ok(Study {
        tables: vec![
            (name.into(), cell_table(request, basin)?),
            (format!("{name}-attractors"), attractor_table(basin).csv()?),
        ],
        figure: Some(figure(set, request, basin)),
        ..Study::without_figure(name, what).with_remarks(remarks(basin)).with_set(set)
    })
}

/// The listed attractors with index and name of class.
fn shown(basin: &Basin) -> impl Iterator<Item = (usize, &Attractor, String)> {
    basin.attractors.iter().take(SHOWN).enumerate().map(|(i, a)| (i, &a.attractor, a.class.name()))
}

/// Table of attractors, with the shares of the plane that lead to each and to its mirror image.
fn attractor_table(basin: &Basin) -> TextTable {
    let mut table = TextTable::new(&[
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

/// Table of starts, each with the number of its attractor.
fn cell_table(request: &BasinRequest, basin: &Basin) -> Result<Vec<u8>> {
    let (x, y) = (&request.x, &request.y);
    let header = [COORDINATES[x.coordinate], COORDINATES[y.coordinate], "attractor", "mirror_image", "class"];
    let classes: Vec<String> = basin.attractors.iter().map(|a| a.class.name()).collect();
    let xs: Vec<String> = (0..x.count).map(|i| exact(x.value(i))).collect();
    csv_in_groups(&header, y.count, |rows, j| {
        let value = exact(y.value(j));
        xs.iter().zip(&basin.cells[j * x.count..]).try_for_each(|(x, destination)| {
            let (number, mirror) = match destination {
                Destination::Attractor(n) => ((n + 1).to_string(), "false"),
                Destination::Mirror(n) => ((n + 1).to_string(), "true"),
                _ => (String::new(), ""),
            };
            let class = match destination {
                Destination::Attractor(n) | Destination::Mirror(n) => &classes[usize::from(*n)],
                Destination::Outside => "outside",
                Destination::NotSettled => "not settled",
                Destination::Undecided => "attractor undecided",
            };
            rows.push([x, &value, &number, mirror, class])
        })
    })
}

fn remarks(basin: &Basin) -> Vec<String> {
    let remark = |(index, attractor, class): (usize, &Attractor, String)| {
        let [own, mirror] = basin.shares(index as u16);
        // For a motion without a period this is a mean, known to two or three digits.
        let impacts = attractor.impacts.map(|x| match attractor.period {
            Some(_) => exact(x),
            None => format!("{x:.2}"),
        });
        let mut words = format!(
            "attractor {}: {class}, {} + {} impacts a period, {:.1} % of the starts, its mirror image {:.1} %",
            index + 1,
            impacts[0],
            impacts[1],
            100.0 * own,
            100.0 * mirror
        );
        if let Some(statistics) = attractor.statistics {
            words.push_str(&format!("; means over {} drive periods", statistics.periods));
        }
        words
    };
    let mut lines: Vec<String> = shown(basin).map(remark).collect();
    if basin.attractors.len() > SHOWN {
        lines.push(format!("and {} more", basin.attractors.len() - SHOWN));
    }
    let rest = [
        (Destination::NotSettled, format!("not settled: followed for {PROLONGED} drive periods or more")),
        (
            Destination::Undecided,
            "of undecided attractor: chaotic or quasi-periodic, but on which attractor was not decided"
                .into(),
        ),
    ];
    for (destination, what) in rest {
        if basin.cells.contains(&destination) {
            lines.push(format!("{:.1} % of the starts {what}", 100.0 * basin.share(destination)));
        }
    }
    lines
}

/// Code of a cell in the picture: 0 to 3 for [`OTHERS`], then two for each attractor and its mirror
/// image.
fn code(destination: &Destination) -> u8 {
    match *destination {
        Destination::Outside => 0,
        Destination::NotSettled => 1,
        Destination::Undecided => 2,
        Destination::Attractor(n) if usize::from(n) < PAIRS.len() => 4 + 2 * n as u8,
        Destination::Mirror(n) if usize::from(n) < PAIRS.len() => 5 + 2 * n as u8,
        Destination::Attractor(_) | Destination::Mirror(_) => 3,
    }
}

/// The cells of the plane.
fn cells(request: &BasinRequest, basin: &Basin) -> Shape {
    Shape::Cells {
        x: (request.x.from, request.x.to),
        y: (request.y.from, request.y.to),
        columns: request.x.count,
        cells: basin.cells.iter().map(code).collect(),
        colours: OTHERS.into_iter().chain(PAIRS.into_iter().flatten()).map(Some).collect(),
    }
}

/// Entries of the legend: each attractor of [`PAIRS`], its mirror image where there is one, all
/// further attractors together, then cells without a known attractor.
fn legend(basin: &Basin) -> Vec<Layer> {
    let entry = |name: &str, colour| Layer::band(name, colour, 1.0, Vec::new());
    let mut layers = Vec::new();
    for (index, (attractor, [own, image])) in basin.attractors.iter().zip(PAIRS).enumerate() {
        let title = format!("{}: {}", index + 1, attractor.class.name());
        let [share, share_of_image] = basin.shares(index as u16);
        if share > 0.0 {
            layers.push(entry(&title, own));
        }
        if share_of_image > 0.0 {
            layers.push(entry(&format!("{title}, mirror image"), image));
        }
    }
    if let Some(further) = basin.attractors.get(PAIRS.len()..).filter(|further| !further.is_empty()) {
        let mut classes: Vec<String> = Vec::new();
        for name in further.iter().map(|a| a.class.name()) {
            if !classes.contains(&name) {
                classes.push(name);
            }
        }
        let title = format!("{} to {}: {}", PAIRS.len() + 1, basin.attractors.len(), classes.join(", "));
        layers.push(entry(&title, FURTHER));
    }
    for (destination, name, colour) in [
        (Destination::NotSettled, "not settled", NOT_SETTLED),
        (Destination::Undecided, "attractor undecided", UNDECIDED),
        (Destination::Outside, "no start: outside the stops", OUTSIDE),
    ] {
        if basin.cells.contains(&destination) {
            layers.push(entry(name, colour));
        }
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

fn figure(set: &ParameterSet, request: &BasinRequest, basin: &Basin) -> Figure {
    let mut layers = vec![Layer::new("", GREY, cells(request, basin))];
    layers.extend(legend(basin));
    let method = format!(
        "{} × {} starts, the other initial values zero; {} periods discarded, and more where nothing is decided then.",
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

#[cfg(test)]
mod tests {
    use super::*;
    use vibro_studies::MotionClass;
    use vibro_studies::paper::basin::BasinAttractor;

    #[test]
    fn invariant_each_class_has_an_entry_and_a_colour_of_its_own_lightness() {
        /// Ratio of two luminances with stray light (WCAG) that the eye tells apart.
        const APART: f64 = 1.02;
        let mut light: Vec<f64> =
            PAIRS.iter().flatten().chain(&OTHERS).map(|colour| colour.luminance() + 0.05).collect();
        light.sort_by(f64::total_cmp);
        assert!(light.windows(2).all(|pair| pair[1] / pair[0] > APART), "{light:?}");
        // Eleven attractors: the last three share one entry.
        let attractor = |period: u32| BasinAttractor {
            attractor: Attractor {
                period: Some(period),
                approaching: false,
                impacts: [1.0; 2],
                rests: false,
                states: Vec::new(),
                mirror_states: Vec::new(),
                sizes: [1.0; 3],
                statistics: None,
            },
            class: MotionClass::Periodic(period),
        };
        let mut cells: Vec<Destination> =
            (0..11).flat_map(|n| [Destination::Attractor(n), Destination::Mirror(n)]).collect();
        cells.extend([Destination::NotSettled, Destination::Undecided, Destination::Outside]);
        let basin = Basin { attractors: (1..=11).map(attractor).collect(), cells };
        let legend = legend(&basin);
        let mut codes: Vec<u8> = basin.cells.iter().map(code).collect();
        codes.sort_unstable();
        codes.dedup();
        assert_eq!(legend.len(), codes.len());
        for (i, layer) in legend.iter().enumerate() {
            assert!(legend[..i].iter().all(|other| other.colour != layer.colour), "{:?}", layer.name);
        }
        let names: Vec<&str> = legend.iter().filter_map(|layer| layer.name.as_deref()).collect();
        assert!(names.contains(&"9 to 11: 9T, 10T, 11T") && names.contains(&"not settled"), "{names:?}");
        assert!(remarks(&basin).iter().any(|line| line.contains("% of the starts not settled")));
    }
}
