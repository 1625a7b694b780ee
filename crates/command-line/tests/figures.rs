//! Pictures by their pixels and files: curves stay inside the frames of their panels, files are
//! small, bodies have their colours, and colours differ in lightness.

#[path = "figures/layout.rs"]
mod layout;
#[path = "figures/motion.rs"]
mod motion;

use std::collections::BTreeMap;
use vibro::studies::{self, Study};
use vibro_figures::canvas;
use vibro_figures::canvas::palette::{
    BLACK, BLOCK, BODIES, BOX, CENTRE, FAMILY, HERE, RELATIVE, SECONDARY, WHITE,
};
use vibro_figures::canvas::{Colour, Drawing};
use vibro_figures::chart::{Axis, Dash, Figure, Layer, Mark, Panel, Path, STYLES, Shape, lettered, style};
use vibro_studies::diagram::diagram;
use vibro_studies::paper::bifurcation::Sweep;
use vibro_studies::paper::lyapunov::SpectrumOptions;
use vibro_studies::paper::maxima::Displacement;
use vibro_studies::paper::plane::ParameterAxis;
use vibro_studies::paper::{Name, ParameterSet};
use vibro_studies::parts::Task;

/// Numbers of values: from few to many more than a panel has pixels.
const COUNTS: [usize; 3] = [50, 500, 5000];
/// Half the stroke of a curve and the smoothing of edges, in pixels of the PNG.
const EDGE: usize = 3;

/// A curve that reverses by nearly half a circle at each value, as exponents may.
fn jagged(count: usize) -> Path {
    let height = |i: usize| (i as f64 * 0.618_034).fract() * if i.is_multiple_of(2) { 0.9 } else { -0.9 };
    (0..count).map(|i| (i as f64 / (count - 1) as f64, height(i))).collect()
}

fn figure(layers: Vec<Layer>) -> Figure {
    let (x, y) = (Axis::over("x (–)", 0.0, 1.0), Axis::over("y (–)", -1.0, 1.0));
    let panel = Panel { title: "(a)".into(), x, y, layers };
    Figure { panels: vec![panel], columns: 1, panel: (1700, 1150), ..Figure::default() }
}

/// The pixels of a figure's PNG: width, height, RGB rows from the top.
fn drawn(figure: &Figure) -> (usize, usize, Vec<u8>) {
    decoded(canvas::png(figure).unwrap())
}

/// The pixels of a PNG file.
fn decoded(file: Vec<u8>) -> (usize, usize, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(info.color_type, png::ColorType::Rgb);
    (info.width as usize, info.height as usize, pixels)
}

#[test]
fn jagged_curves_stay_inside_their_panel() {
    let (width, height, empty) = drawn(&figure(Vec::new()));
    let dark = |x: usize, y: usize| empty[3 * (y * width + x)] < 128;
    // The frame is the only thing in an empty panel that is dark along most of a row or a column.
    let rows: Vec<_> =
        (0..height).filter(|&y| (0..width).filter(|&x| dark(x, y)).count() > width / 2).collect();
    let columns: Vec<_> =
        (0..width).filter(|&x| (0..height).filter(|&y| dark(x, y)).count() > height / 2).collect();
    let (top, bottom) = (rows[0] - EDGE, rows[rows.len() - 1] + EDGE);
    let (left, right) = (columns[0] - EDGE, columns[columns.len() - 1] + EDGE);
    for count in COUNTS {
        let curve = jagged(count);
        let layers = vec![
            Layer::line("", BLOCK, Dash::Solid, curve.clone()),
            Layer::marks("", BOX, Mark::Disc, curve.clone()),
            Layer::marks("", BLACK, Mark::Cross, vec![(0.0, -1.0), (1.0, 1.0), (2.0, 0.0)]),
            Layer::band("", SECONDARY, 0.5, curve.iter().map(|&(x, y)| (x, y, 3.0)).collect()),
        ];
        let (_, _, full) = drawn(&figure(layers));
        let changed = |x: usize, y: usize| {
            let at = 3 * (y * width + x);
            empty[at..at + 3] != full[at..at + 3]
        };
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let all: Vec<_> = places.filter(|&(x, y)| changed(x, y)).collect();
        assert!(all.len() > 1000, "{count} values: the curve is drawn");
        let outside = all.iter().find(|p| !(left..=right).contains(&p.0) || !(top..=bottom).contains(&p.1));
        assert_eq!(outside, None, "{count} values: the curve leaves its panel");
    }
}

/// For many values, a file contains no more than the picture can show, and only finite numbers.
#[test]
fn invariant_files_of_many_values_are_small_and_finite() {
    // Largest file, bytes: a browser opens it at once.
    const LARGEST: usize = 4_000_000;
    for count in COUNTS {
        let cells = Shape::Cells {
            x: (0.0, 1.0),
            y: (-1.0, 1.0),
            columns: count,
            cells: (0..count * 380).map(|i| (i * 7919 % 1013 % 4) as u8).collect(),
            colours: vec![None, Some(BOX), Some(BLOCK), Some(SECONDARY)],
        };
        let curve = Layer::line("", BLOCK, Dash::Solid, jagged(count)).labelled("a name");
        let marks =
            Layer::marks("", BOX, Mark::Ring, vec![(0.5, f64::NAN), (f64::INFINITY, 0.0), (0.5, 0.5)]);
        let with_gaps =
            Layer::line("", BOX, Dash::Dotted, vec![(0.0, 0.0), (f64::NAN, 1.0), (0.5, 0.5), (0.6, 9e99)]);
        let drawing = figure(vec![Layer::new("", BLACK, cells), curve, marks, with_gaps]);
        let svg = canvas::svg(&drawing).unwrap();
        assert!(svg.len() < LARGEST, "{count} values: {} bytes", svg.len());
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{count} values");
        // Everything is clipped to a rectangle inside the picture.
        let (width, height) = drawing.size();
        let rectangle = svg.split("<clipPath").nth(1).unwrap().split("/>").next().unwrap();
        let number = |name: &str| -> f64 {
            rectangle
                .split(&format!(" {name}=\""))
                .nth(1)
                .unwrap()
                .split('"')
                .next()
                .unwrap()
                .parse()
                .unwrap()
        };
        assert!(number("x") + number("width") < f64::from(width), "{rectangle}");
        assert!(number("y") + number("height") < f64::from(height), "{rectangle}");
    }
}

/// A datum of a diagram keeps a border of one pixel at any size (counted in a browser by
/// fmu-build/tests/page.rs). Cells that cover a plane have no border, because it would hide
/// neighbours. A curve of one point is a dot.
#[test]
fn invariant_no_datum_of_a_picture_vanishes() {
    let cells = |first: Option<Colour>| Shape::Cells {
        x: (0.0, 1.0),
        y: (-1.0, 1.0),
        columns: 2,
        cells: vec![0, 1, 1, 0],
        colours: vec![first, Some(BLOCK)],
    };
    let file = |shape| canvas::svg(&figure(vec![Layer::new("", BLACK, shape)])).unwrap();
    let border = "shape-rendering=\"crispEdges\" stroke=\"";
    assert!(file(cells(None)).contains(border));
    assert!(!file(cells(Some(BOX))).contains(border));

    let dark = |pixels: &[u8]| pixels.chunks(3).filter(|pixel| pixel[0] < 128).count();
    let one = Layer::line("", BLACK, Dash::Solid, vec![(0.37, 0.21)]);
    let more = dark(&drawn(&figure(vec![one])).2) - dark(&drawn(&figure(Vec::new())).2);
    assert!((4..40).contains(&more), "{more} pixels of a dot");
}

/// The texts of a drawing.
fn texts(drawing: &Figure) -> Vec<String> {
    let svg = canvas::svg(drawing).unwrap();
    let texts = svg.split("<text").skip(1).filter_map(|t| t.split_once('>')?.1.split('<').next());
    texts.map(String::from).collect()
}

/// If a curve has no room for its name in a crowded panel and is named in another panel with its
/// colour, it needs no entry in the legend.
#[test]
fn a_name_beside_a_curve_of_one_panel_is_in_no_shared_legend() {
    let curve = || Layer::line("", BOX, Dash::Solid, jagged(50)).labelled("box x₁");
    let crowd = (0..10_000).map(|i| (f64::from(i % 100) / 99.0, f64::from(i / 100) / 49.5 - 1.0)).collect();
    let crowded = figure(vec![curve(), Layer::marks("", BLACK, Mark::Disc, crowd)]).panels.remove(0);
    let straight = Layer::line("", BOX, Dash::Solid, vec![(0.0, 0.0), (1.0, 0.5)]).labelled("box x₁");
    let free = figure(vec![straight]).panels.remove(0);
    let count = |panels: Vec<Panel>| {
        let drawing =
            Figure { panels, columns: 2, panel: (1700, 1150), shared_legend: true, ..Figure::default() };
        texts(&drawing).iter().filter(|t| *t == "box x₁").count()
    };
    assert_eq!(count(vec![crowded.clone(), free]), 1);
    // Without the other panel the name is in the legend.
    assert_eq!(count(vec![crowded]), 1);
}

/// Both files of a picture contain its caption, and the picture shows no word of it.
#[test]
fn golden_the_caption_is_in_the_metadata_of_both_files() {
    let caption = vec!["x < 1 & y".to_owned(), "Elsewhere k₁ = 48 kN/m".to_owned()];
    let drawing = Figure { title: "Gear mesh".into(), caption, ..figure(Vec::new()) };
    let told = "(a): y (–), over x (–).\nx < 1 & y\nElsewhere k₁ = 48 kN/m";
    assert_eq!(drawing.about().text, told);
    let svg = canvas::svg(&drawing).unwrap();
    let escaped = told.replace('&', "&amp;").replace('<', "&lt;");
    assert!(svg.contains(&format!("<title>Gear mesh</title>\n<desc>{escaped}</desc>\n")), "{svg}");
    assert_eq!(texts(&drawing).iter().filter(|text| text.contains("kN/m")).count(), 0);
    let file = canvas::png(&drawing).unwrap();
    let reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
    let words = reader.info().utf8_text.iter().map(|text| (text.keyword.as_str(), text.get_text().unwrap()));
    let words: Vec<_> = words.collect();
    assert_eq!(words, [("Title", "Gear mesh".to_owned()), ("Description", told.to_owned())]);
}

/// WCAG 2.2: the lighter of two luminances over the darker, with some stray light.
fn contrast(a: Colour, b: Colour) -> f64 {
    let (a, b) = (a.luminance() + 0.05, b.luminance() + 0.05);
    a.max(b) / a.min(b)
}

/// Grey shows only lightness, so colours of different lightness are distinguishable for all eyes
/// and in any print.
#[test]
fn invariant_colours_are_told_apart_by_their_lightness() {
    // WCAG 2.2, 1.4.11: minimum contrast of graphics with their background.
    const ON_PAPER: f64 = 3.0;
    // Contrast between neighbouring lines: about a fifth of the perceptual range from grey to
    // black.
    const APART: f64 = 1.35;
    for colours in [BODIES, FAMILY] {
        let mut sorted = colours;
        sorted.sort_by(|a, b| a.luminance().total_cmp(&b.luminance()));
        assert_eq!(sorted, colours, "from dark to light");
        for pair in colours.windows(2) {
            assert!(contrast(pair[0], pair[1]) > APART, "{pair:?}: {}", contrast(pair[0], pair[1]));
        }
        for colour in colours {
            assert!(contrast(colour, WHITE) > ON_PAPER, "{colour:?}: {}", contrast(colour, WHITE));
        }
    }
    assert!(contrast(HERE, WHITE) > ON_PAPER);
    assert!(FAMILY.iter().chain([&HERE, &BLACK]).all(|colour| !BODIES.contains(colour)));
}

/// Any two curves of a panel differ in lightness or in dashes.
#[test]
fn invariant_styles_of_curves_are_told_apart_in_grey() {
    // As for neighbours in the families of colours.
    const APART: f64 = 1.35;
    for one in 0..STYLES {
        for other in 0..one {
            let [(a, dash), (b, other_dash)] = [style(one), style(other)];
            assert!(contrast(a, b) > APART || dash != other_dash, "{one} {other}: {}", contrast(a, b));
        }
    }
}

/// Panels have letters only if there are several.
#[test]
fn golden_letters_of_panels() {
    let panels = |titles: &[&str]| -> Vec<String> {
        let mut panels: Vec<Panel> =
            titles.iter().map(|title| Panel { title: (*title).into(), ..Panel::default() }).collect();
        lettered(&mut panels);
        panels.into_iter().map(|panel| panel.title).collect()
    };
    assert_eq!(panels(&["history"]), ["history"]);
    assert_eq!(panels(&["history", ""]), ["(a) history", "(b)"]);
}

/// The bodies, by the symbols and words that name them.
const NAMES: [(Colour, &[&str]); 5] = [
    (CENTRE, &["U", "u", "B", "B·L", "centre"]),
    (BOX, &["X₁", "x₁", "A₁", "A₁·L", "box"]),
    (RELATIVE, &["W", "w"]),
    (BLOCK, &["X₂", "x₂", "A₂", "A₂·L", "block"]),
    (SECONDARY, &["X₃", "x₃", "A₃", "A₃·L", "secondary"]),
];

/// The body that a name begins with.
fn body(name: &str) -> Option<Colour> {
    let first = name.split([' ', ',']).next().unwrap_or_default();
    NAMES.iter().find(|n| n.1.contains(&first)).map(|n| n.0)
}

/// Checks every line and mark of a study; returns how many of each body there were.
fn check_bodies(study: &Study, count: &mut BTreeMap<Colour, usize>) {
    let Some(figure) = &study.figure else { panic!("{} has a picture", study.name) };
    for panel in &figure.panels {
        let areas = |l: &&Layer| {
            matches!(
                l.shape,
                Shape::Band { .. } | Shape::Bar { .. } | Shape::Cells { .. } | Shape::Text { .. }
            )
        };
        for layer in panel.layers.iter().filter(|l| !areas(l)) {
            let told = layer.label.as_deref().or(layer.name.as_deref());
            let place = format!("{}, {}, {told:?}", study.name, panel.title);
            match told.map(|name| (name, body(name))) {
                Some((_, Some(colour))) => {
                    assert_eq!(layer.colour, colour, "{place}");
                    *count.entry(colour).or_default() += 1;
                }
                Some((_, None)) => assert!(!BODIES.contains(&layer.colour), "{place}"),
                None => {}
            }
        }
        // A curve without a name has the colour of a named curve in the same panel.
        let named: Vec<_> = panel.layers.iter().filter(|l| l.label.is_some() || l.name.is_some()).collect();
        for layer in panel.layers.iter().filter(|l| BODIES.contains(&l.colour)) {
            assert!(named.iter().any(|n| n.colour == layer.colour), "{}, {}", study.name, panel.title);
        }
    }
    // No internal names of the program.
    for words in ["BASIC", "STRONG", "Past the paper", "ours"] {
        let found = figure.caption.iter().find(|line| line.contains(words));
        assert!(found.is_none(), "{}: {found:?}", study.name);
    }
    // The picture can be drawn.
    let svg = canvas::svg(figure).unwrap();
    assert!(!svg.contains("NaN") && svg.len() < 4_000_000, "{}: {} bytes", study.name, svg.len());
}

/// A machine in SI that settles on the motion with two impacts.
fn machine() -> ParameterSet {
    let mut set = ParameterSet::basic();
    set.apply(&["box.m=12kg", "box.k=48kN/m", "box.c=75", "block.m=1.2kg", "stop.gap=5mm", "coupling.k=288"])
        .unwrap();
    set.apply(&["secondary.m=1.2kg", "secondary.k=4.8kN/m", "secondary.c=4.5"]).unwrap();
    set.apply(&["stop.restitution=0.75", "drive.amplitude=36N", "drive.frequency=10.4Hz"]).unwrap();
    set
}

/// Checked in units of L and in SI, in every study whose curves are motions or amplitudes of
/// bodies.
#[test]
fn invariant_a_body_has_its_colour_and_no_other_line_has_it() {
    for set in [ParameterSet::basic(), machine()] {
        let f10 = Name::find("f10").unwrap();
        let options = SpectrumOptions { periods: 210, ..SpectrumOptions::default() };
        let axis = ParameterAxis::new(f10, (1.0, 2.4), 8).unwrap();
        let sweep = Sweep { exponents: Some(options), ..Sweep::new(axis, Displacement::X1, (50, 20)) };
        let found = diagram(&set, &sweep, &Task::ALL).unwrap().unwrap();
        let all = [
            studies::paper::steady(&set).unwrap(),
            studies::paper::histories(&set).unwrap(),
            studies::paper::accuracy(&set, &[0.1, 0.05]).unwrap(),
            studies::paper::accuracy(&set, &[0.1]).unwrap(),
            studies::paper::strong_case(&ParameterSet::strong().unwrap()).unwrap(),
            studies::paper::histories_of(&set, f10, 0.6).unwrap().0,
            studies::paper::frequency(&set, (-1.0, 1.0), (&[1.0, 1.5], &[0.5, 1.0]), None).unwrap(),
            studies::paper::force(&set, (0.5, 2.0), (&[0.4], &[-0.4]), Some(Displacement::X1)).unwrap(),
            studies::diagram(&set, &sweep, &found, "sweep").unwrap(),
            studies::paper::overlay(&set, &sweep, &found, "overlay").unwrap(),
            studies::paper::portraits(&set, f10, &found, &[1.2, 2.2]).unwrap(),
            studies::paper::running(&set, f10, &[1.5], 20, &options, "running").unwrap(),
            studies::paper::shapes(&set).unwrap(),
            studies::paper::branches(&set).unwrap(),
            studies::paper::families(&set, f10, &[1.2, 1.5]).unwrap(),
            studies::paper::regions(&set).unwrap(),
        ];
        let mut count = BTreeMap::new();
        all.iter().for_each(|study| check_bodies(study, &mut count));
        for colour in BODIES {
            assert!(count.get(&colour).is_some_and(|n| *n > 2), "{colour:?}: {count:?}");
        }
    }
}

/// In SI no axis is in units of L, and the numbers at the ticks are the data in the stated unit.
#[test]
fn closed_form_amplitudes_in_si_are_those_in_units_of_the_gap() {
    let set = machine();
    let study = studies::paper::force(&set, (0.5, 2.0), (&[0.4], &[]), Some(Displacement::X1)).unwrap();
    let panel = &study.figure.unwrap().panels[0];
    assert_eq!(panel.y.label, "amplitude of x₁ (mm)");
    // Factor of L = 5 mm.
    assert!((panel.y.factor.unwrap() / 5.0 - 1.0).abs() < 1e-12);
    // For a varying gap, the data are in units of the machine's own gap, not of each point's gap.
    let gap = Name::find("stop.gap").unwrap();
    let kappa = Name::find("kappa").unwrap();
    let along =
        studies::paper::along(&set, gap, (0.004, 0.008), (kappa, &[0.75]), Some(Displacement::W)).unwrap();
    let panel = &along.figure.unwrap().panels[0];
    let curves = panel.layers.iter().flat_map(Layer::extent).filter(|p| p.1 > 0.1 && p.1 < 1.6);
    let mut compared = 0;
    for (value, amplitude) in curves {
        // From stop to stop: w is as large as the gap there, by multiple scales and by the exact
        // orbit.
        assert!((amplitude - value / 0.005).abs() < 1e-9, "{value}: {amplitude}");
        compared += 1;
    }
    assert!(compared > 20, "{compared}");
}

/// The picture in the FMU's page equals the program's picture. Words are compared, because curves
/// may differ in last digits.
#[test]
fn golden_the_response_in_the_page_of_the_fmu() {
    let study = studies::paper::force(&ParameterSet::basic(), (0.0, 4.0), (&[0.4], &[-0.4]), None).unwrap();
    let drawing = study.figure.unwrap();
    let committed = concat!(env!("CARGO_MANIFEST_DIR"), "/../../modelDescription/documentation/response.svg");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(committed, canvas::svg(&drawing).unwrap()).expect("modelDescription can be written");
    }
    let told = std::fs::read_to_string(committed).expect("the picture is committed");
    let told = told.split("<text").skip(1).filter_map(|t| t.split_once('>')?.1.split('<').next());
    assert_eq!(texts(&drawing), told.collect::<Vec<_>>(), "UPDATE=1 draws it anew; look at it");
}
