//! Pictures and tables of basins of attraction.

mod described;

use super::Study;
use super::design_sweep::Labelled;
use crate::Result;
use crate::table::{TextTable, csv_in_groups, exact};
use rayon::prelude::*;
use vibro_figures::canvas::palette::GREY;
use vibro_figures::chart::{Axis, Colour, Figure, Layer, Panel, Shape};
use vibro_studies::basin::{BasinAttractor, BasinCell, BasinMachine, BasinRequest, Basins, StartAxis};
use vibro_studies::check_cells;

/// Colours of the first attractors and of their mirror images. All colours of a picture, with
/// [`OTHERS`], have even steps of lightness.
const PAIRS: [[Colour; 2]; 8] = [
    [Colour(5, 34, 117), Colour(1, 147, 246)],
    [Colour(165, 54, 8), Colour(223, 161, 111)],
    [Colour(28, 76, 42), Colour(8, 145, 59)],
    [Colour(194, 0, 116), Colour(229, 200, 255)],
    [Colour(88, 11, 245), Colour(173, 139, 210)],
    [Colour(168, 101, 2), Colour(245, 190, 71)],
    [Colour(154, 4, 15), Colour(238, 134, 135)],
    [Colour(26, 115, 162), Colour(3, 251, 219)],
];
/// Colours of other cells: starts outside the stops; motions that have not settled; motions whose
/// attractor was not decided, and motions that end; all attractors beyond [`PAIRS`]; motions that
/// come to rest.
const OTHERS: [Colour; 5] = [
    Colour(240, 240, 240),
    Colour(134, 134, 134),
    Colour(56, 56, 56),
    Colour(8, 8, 8),
    Colour(185, 185, 185),
];
const OUTSIDE: Colour = OTHERS[0];
const NOT_SETTLED: Colour = OTHERS[1];
const UNDECIDED: Colour = OTHERS[2];
const FURTHER: Colour = OTHERS[3];
const REST: Colour = OTHERS[4];

/// Cap on the listed attractors.
const SHOWN: usize = 101;

/// Largest size of a row of the table, bytes.
const ROW: usize = 64;

/// Machine whose basins have tables and pictures.
pub trait ShownBasins: BasinMachine + Labelled {
    /// Whether attractors have mirror images.
    const HAS_IMAGES: bool;
    /// Headings of the table of attractors after number and class.
    fn headings(basins: &Basins<Self::Attractor>) -> Vec<String>;
    /// An attractor with the cells of its row; `shares` belong to it and to its image.
    fn listed(&self, found: &Self::Attractor, shares: [f64; 2]) -> Listed;
    /// Title of the picture, second line of its caption, and start numbers without an axis.
    fn titles(&self) -> [String; 3];
    /// Axis of the picture.
    fn start_axis(&self, axis: &StartAxis) -> Axis;
    /// The share of the motions that came to rest, and where; `None` if none did.
    fn rest_in_words(&self, basins: &Basins<Self::Attractor>) -> Option<String>;
}

/// An attractor in tables and pictures.
pub struct Listed {
    /// Cells of its row after number and class.
    pub row: Vec<String>,
    /// Descriptions with the class for the legend and for the remark.
    pub words: [String; 2],
}

/// Checks that a plane of starts and its table fit into memory.
///
/// # Errors
/// [`TooMany`](vibro_studies::Error::TooMany), with the number that would fit.
pub fn check_basins<M: BasinMachine>(request: &BasinRequest<M>) -> Result<()> {
    let held = size_of::<BasinCell>() + ROW;
    Ok(check_cells("points of the plane", (request.x.count, request.y.count), held)?)
}

/// The study of a plane of starts.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn basins<M: ShownBasins>(
    machine: &M,
    request: &BasinRequest<M>,
    basins: &Basins<M::Attractor>,
    name: &str,
) -> Result<Study> {
    let shown = basins.attractors.par_iter().take(SHOWN).enumerate();
    let listed: Vec<Listed> =
        shown.map(|(number, found)| machine.listed(found, basins.shares(number as u16))).collect();
    let count = basins.attractors.len();
    let (x, y) = (&request.x, &request.y);
    let attractors = if count == 1 { "attractor" } else { "attractors" };
    let of = match (count, basins.rest.is_empty()) {
        (0, false) => "rest".to_owned(),
        (_, false) => format!("{count} {attractors} and of rest"),
        (_, true) => format!("{count} {attractors}"),
    };
    let images = if M::HAS_IMAGES { ", mirror images counted once" } else { "" };
    let what = format!("basins of {of} over {} and {}{images}", x.name, y.name);
    let [title, elsewhere, others] = machine.titles();
    let method = format!(
        "{} × {} starts{others}; up to {} periods discarded, and more where nothing is decided then.",
        x.count, y.count, request.discard
    );
    let mut layers = vec![Layer::new("", GREY, cells::<M>(request, basins))];
    layers.extend(legend::<M>(basins, &listed));
    let (x, y) = (machine.start_axis(x), machine.start_axis(y));
    let figure = Figure {
        title,
        caption: vec![method, elsewhere],
        panels: vec![Panel { title: String::new(), x, y, layers }],
        columns: 1,
        panel: (2300, 1700),
        shared_legend: true,
    };
    Ok(Study {
        tables: vec![
            (name.into(), cell_table(request, basins)?),
            (format!("{name}-attractors"), attractor_table::<M>(basins, &listed).csv()?),
        ],
        figure: Some(figure),
        ..Study::without_figure(name, what).with_remarks(remarks(machine, basins, &listed))
    })
}

/// Table of attractors, with the shares of the plane that lead to each.
fn attractor_table<M: ShownBasins>(basins: &Basins<M::Attractor>, listed: &[Listed]) -> TextTable {
    let mut header = vec!["attractor".to_owned(), "class".to_owned()];
    header.extend(M::headings(basins));
    let row = |(number, (one, found)): (usize, (&Listed, &M::Attractor))| {
        [&[(number + 1).to_string(), found.class().name()][..], &one.row].concat()
    };
    let rows = listed.iter().zip(&basins.attractors).enumerate().map(row).collect();
    TextTable { header, rows }
}

/// Table of starts, each with the number of its attractor.
fn cell_table<M: ShownBasins>(request: &BasinRequest<M>, basins: &Basins<M::Attractor>) -> Result<Vec<u8>> {
    let (x, y) = (&request.x, &request.y);
    let image: &[&str] = if M::HAS_IMAGES { &["mirror_image"] } else { &[] };
    let header = [&[x.name.as_str(), y.name.as_str(), "attractor"], image, &["class"]].concat();
    let classes: Vec<String> = basins.attractors.iter().map(|a| a.class().name()).collect();
    let xs: Vec<String> = (0..x.count).map(|i| exact(x.value(i))).collect();
    csv_in_groups(&header, y.count, |rows, j| {
        let value = exact(y.value(j));
        xs.iter().zip(&basins.cells[j * x.count..]).try_for_each(|(x, cell)| {
            let (number, image, class) = match cell {
                BasinCell::Attractor(n) => ((n + 1).to_string(), "false", classes[usize::from(*n)].as_str()),
                BasinCell::Mirror(n) => ((n + 1).to_string(), "true", classes[usize::from(*n)].as_str()),
                BasinCell::Outside => (String::new(), "", "outside"),
                BasinCell::NotSettled => (String::new(), "", "not settled"),
                BasinCell::Undecided => (String::new(), "", "attractor undecided"),
                BasinCell::Ended => (String::new(), "", "ended"),
                BasinCell::Rest => (String::new(), "", "rest"),
            };
            let image: &[&str] = if M::HAS_IMAGES { &[image] } else { &[] };
            rows.push([&[x.as_str(), &value, &number], image, &[class]].concat())
        })
    })
}

fn remarks<M: ShownBasins>(machine: &M, basins: &Basins<M::Attractor>, listed: &[Listed]) -> Vec<String> {
    let told = |(number, one): (usize, &Listed)| format!("attractor {}: {}", number + 1, one.words[1]);
    let mut lines: Vec<String> = listed.iter().enumerate().map(told).collect();
    if basins.attractors.len() > SHOWN {
        lines.push(format!("and {} more", basins.attractors.len() - SHOWN));
    }
    lines.extend(machine.rest_in_words(basins));
    let ended = format!("lead to motions that end: {}", basins.ended.as_deref().unwrap_or_default());
    let mut others = vec![
        (BasinCell::NotSettled, "not settled after 8192 periods or more"),
        (BasinCell::Undecided, "chaotic or quasi-periodic, but their attractor is undecided"),
        (BasinCell::Ended, &ended),
    ];
    if M::Attractor::SHARES_OF_ALL {
        others.insert(0, (BasinCell::Outside, "violate a rigid stop"));
    }
    let there = others.into_iter().filter(|(cell, _)| basins.cells.contains(cell));
    lines.extend(
        there.map(|(cell, words)| format!("{:.1} % of the starts {words}", 100.0 * basins.share(cell))),
    );
    lines
}

/// Code of a cell in the picture: first the indices of [`OTHERS`], then two codes for each
/// attractor of [`PAIRS`] and its image. If attractors have no images, the second colours of the
/// pairs belong to further attractors.
fn code<M: ShownBasins>(cell: BasinCell) -> u8 {
    let pairs = PAIRS.len();
    let of_pair = |pair: usize, second: usize| {
        if pair < pairs && second < 2 { OTHERS.len() + 2 * pair + second } else { 3 }
    };
    let place = match cell {
        BasinCell::Outside => 0,
        BasinCell::NotSettled => 1,
        BasinCell::Undecided | BasinCell::Ended => 2,
        BasinCell::Rest => 4,
        BasinCell::Attractor(n) if M::HAS_IMAGES => of_pair(n.into(), 0),
        BasinCell::Attractor(n) => of_pair(usize::from(n) % pairs, usize::from(n) / pairs),
        BasinCell::Mirror(n) => of_pair(n.into(), 1),
    };
    place as u8
}

/// All colours, by the code of a cell.
fn colours() -> Vec<Colour> {
    OTHERS.into_iter().chain(PAIRS.into_iter().flatten()).collect()
}

fn cells<M: ShownBasins>(request: &BasinRequest<M>, basins: &Basins<M::Attractor>) -> Shape {
    Shape::Cells {
        x: (request.x.from, request.x.to),
        y: (request.y.from, request.y.to),
        columns: request.x.count,
        cells: basins.cells.iter().map(|cell| code::<M>(*cell)).collect(),
        colours: colours().into_iter().map(Some).collect(),
    }
}

/// Entries of the legend: each attractor with a colour, its mirror image if it has one, all
/// further attractors together, then cells without an attractor.
fn legend<M: ShownBasins>(basins: &Basins<M::Attractor>, listed: &[Listed]) -> Vec<Layer> {
    let entry = |name: &str, colour| Layer::band(name, colour, 1.0, Vec::new());
    let coloured = if M::HAS_IMAGES { PAIRS.len() } else { 2 * PAIRS.len() };
    let mut layers = Vec::new();
    for (number, one) in listed.iter().take(coloured).enumerate() {
        let title = format!("{}: {}", number + 1, one.words[0]);
        let number = number as u16;
        for (cell, image) in
            [(BasinCell::Attractor(number), ""), (BasinCell::Mirror(number), ", mirror image")]
        {
            if basins.cells.contains(&cell) {
                layers.push(entry(&format!("{title}{image}"), colours()[usize::from(code::<M>(cell))]));
            }
        }
    }
    if let Some(further) = basins.attractors.get(coloured..).filter(|further| !further.is_empty()) {
        let mut classes: Vec<String> = Vec::new();
        for name in further.iter().map(|a| a.class().name()) {
            if !classes.contains(&name) {
                classes.push(name);
            }
        }
        let title = format!("{} to {}: {}", coloured + 1, basins.attractors.len(), classes.join(", "));
        layers.push(entry(&title, FURTHER));
    }
    let others = [
        (BasinCell::NotSettled, "not settled", NOT_SETTLED),
        (BasinCell::Undecided, "attractor undecided", UNDECIDED),
        (BasinCell::Rest, "comes to rest", REST),
        (BasinCell::Ended, "motion ends", UNDECIDED),
        (BasinCell::Outside, "no start: outside the stops", OUTSIDE),
    ];
    let there = others.into_iter().filter(|(cell, ..)| basins.cells.contains(cell));
    layers.extend(there.map(|(_, name, colour)| entry(name, colour)));
    layers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studies::apart::{DISTANCE, apart};
    use vibro_studies::MotionClass;
    use vibro_studies::paper::ParameterSet;
    use vibro_studies::paper::attractor::Attractor;
    use vibro_studies::paper::basin::ClassedAttractor;

    #[test]
    fn invariant_each_class_has_an_entry_and_a_colour_of_its_own_lightness() {
        /// Ratio of two luminances that grey prints show: 21 equal steps from black to white have
        /// 1.16.
        const STEP: f64 = 1.12;
        let (step, distance) = apart(&colours());
        assert!(step > STEP && distance > DISTANCE, "{step} {distance}");
        // Eleven attractors: the last three share one entry.
        let attractor = |period: u32| ClassedAttractor {
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
        let mut cells: Vec<BasinCell> =
            (0..11).flat_map(|n| [BasinCell::Attractor(n), BasinCell::Mirror(n)]).collect();
        cells.extend([BasinCell::NotSettled, BasinCell::Undecided, BasinCell::Outside]);
        let basins = Basins { attractors: (1..=11).map(attractor).collect(), cells, ..Basins::default() };
        let set = ParameterSet::basic();
        let numbered = basins.attractors.iter().zip(0..);
        let listed: Vec<Listed> = numbered.map(|(a, n)| set.listed(a, basins.shares(n))).collect();
        let legend = legend::<ParameterSet>(&basins, &listed);
        let mut codes: Vec<u8> = basins.cells.iter().map(|cell| code::<ParameterSet>(*cell)).collect();
        codes.sort_unstable();
        codes.dedup();
        assert_eq!(legend.len(), codes.len());
        for (i, layer) in legend.iter().enumerate() {
            assert!(legend[..i].iter().all(|other| other.colour != layer.colour), "{:?}", layer.name);
        }
        let names: Vec<&str> = legend.iter().filter_map(|layer| layer.name.as_deref()).collect();
        assert!(names.contains(&"9 to 11: 9T, 10T, 11T") && names.contains(&"not settled"), "{names:?}");
        assert!(
            remarks(&set, &basins, &listed).iter().any(|line| line.contains("% of the starts not settled"))
        );
    }
}
