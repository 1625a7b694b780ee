//! Widths in print, bars of colours, and layers of pixels.

use super::{decoded, figure, texts};
use std::collections::BTreeSet;
use vibro_figures::canvas::palette::{BLACK, BOX};
use vibro_figures::canvas::{self, Colour, Drawing};
use vibro_figures::chart::{Axis, Dash, Figure, Layer, Mark, Panel, Path, Shape};

/// The number of an attribute in the first tag with it.
fn attribute(svg: &str, before: &str) -> f64 {
    let rest = svg.split_once(before).unwrap_or_else(|| panic!("{before} in {svg}")).1;
    rest.split(|c: char| !c.is_ascii_digit() && c != '.').next().unwrap().parse().unwrap()
}

/// At any width in print, the file has this width, small letters have 7 points and lines keep their
/// width, at 72 points of 1/72 inch. Panels that would be too narrow are in fewer columns.
#[test]
fn closed_form_a_width_in_print_keeps_letters_and_lines() {
    // The viewBox has a whole number of units of 0.08 mm.
    const UNIT: f64 = 1e-3;
    let curve = || Layer::line("", BOX, Dash::Solid, vec![(0.0, 0.0), (1.0, 0.5)]);
    let panels = vec![figure(vec![curve()]).panels.remove(0); 4];
    let drawing = Figure { panels, columns: 2, ..figure(Vec::new()) };
    for (millimetres, frames) in [(84.0, 1), (174.0, 2), (90.5, 1)] {
        let printed = drawing.printed(millimetres);
        let svg = canvas::svg(&printed).unwrap();
        assert!(svg.starts_with(&format!("<svg width=\"{millimetres}mm\" height=\"")), "{svg}");
        let (wide, high) = printed.size();
        let points = millimetres / 25.4 * 72.0 / f64::from(wide);
        let height = attribute(&svg, "height=\"");
        assert!((height / millimetres / (f64::from(high) / f64::from(wide)) - 1.0).abs() < UNIT, "{height}");
        assert!(svg.contains("font-size=\"31\""), "{svg}");
        assert!((31.0 * points / 7.0 - 1.0).abs() < UNIT, "{}", 31.0 * points);
        let stroke = attribute(&svg[svg.find("#004696").unwrap()..], "stroke-width=\"");
        assert!((stroke * points / (6.0 / 31.0 * 7.0) - 1.0).abs() < UNIT, "{stroke}");
        // The panels of the first row are beside each other.
        let places: BTreeSet<String> =
            svg.split("translate(").skip(1).map(|rest| rest.split(' ').next().unwrap().to_owned()).collect();
        assert_eq!(places.len(), frames, "{places:?}");
        // 600 dots per inch.
        let file = canvas::png(&printed).unwrap();
        let reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
        let dots = f64::from(reader.info().width);
        assert!((dots - millimetres / 25.4 * 600.0).abs() < 1.0, "{dots}");
    }
}

/// Long titles, labels and names are broken into lines, so that nothing is cut off at the edges.
#[test]
fn invariant_no_text_leaves_a_narrow_picture() {
    let long = "relative angular velocity of the left snubber and of the right snubber, rad/s";
    let curve = || Layer::line(long, BOX, Dash::Solid, vec![(0.0, 0.0), (1.0, 0.5)]);
    let axis = || Axis::over(long, 0.0, 1.0);
    let panel = || Panel { title: long.into(), x: axis(), y: axis(), layers: vec![curve(), curve()] };
    let drawing = Figure { title: long.repeat(2), panels: vec![panel(), panel()], ..figure(Vec::new()) };
    // Width of the white edge, in pixels.
    const EDGE: usize = 4;
    for shared_legend in [false, true] {
        let printed = Figure { shared_legend, ..drawing.clone() }.printed(84.0);
        let (width, height, pixels) = decoded(canvas::png(&printed).unwrap());
        let is_white = |x: usize, y: usize| pixels[3 * (y * width + x)..][..3] == [255, 255, 255];
        let edges = (0..height).flat_map(|y| (0..EDGE).flat_map(move |k| [(k, y), (width - 1 - k, y)]));
        let edges =
            edges.chain((0..width).flat_map(|x| (0..EDGE).flat_map(move |k| [(x, k), (x, height - 1 - k)])));
        let inked: Vec<_> = edges.filter(|&(x, y)| !is_white(x, y)).collect();
        assert!(inked.is_empty(), "{shared_legend}: {:?}", &inked[..inked.len().min(5)]);
    }
}

/// More than 20,000 marks are one image in the SVG, with the pixels of the same marks drawn one by
/// one: ink at their places and nowhere else.
#[test]
fn second_method_many_marks_are_an_image_of_the_same_marks() {
    let points = |count: usize| -> Path {
        (0..count).map(|i| (i as f64 / 23_000.0, 0.3 * (i as f64 * 0.001).sin())).collect()
    };
    let layer = |count| vec![Layer::marks("", BOX, Mark::Disc, points(count)).stroke(4)];
    let file = |count| canvas::svg(&figure(layer(count))).unwrap();
    let (few, many) = (file(19_000), file(21_000));
    assert!(!few.contains("<image ") && few.len() > 500_000, "{}", few.len());
    assert!(many.matches("<image ").count() == 1 && many.len() < 100_000, "{}", many.len());
    let data = many.split("base64,").nth(1).unwrap().split('"').next().unwrap();
    let bytes = base64::Engine::decode(&base64::engine::general_purpose::STANDARD, data).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let (x, y) = (attribute(&many, "<image x=\""), attribute(many.split("<image ").nth(1).unwrap(), "y=\""));
    let centres: Vec<(f64, f64)> = few
        .split('M')
        .skip(1)
        .filter(|piece| piece.contains("a4 4 0 1 0"))
        .map(|piece| {
            let (x, rest) = piece.split_once(' ').unwrap();
            (x.parse::<f64>().unwrap() + 4.0, rest.split('a').next().unwrap().parse().unwrap())
        })
        .collect();
    assert_eq!(centres.len(), 19_000);
    let alpha = |px: f64, py: f64| {
        let (column, row) = ((px - x) as usize, (py - y) as usize);
        pixels[4 * (row * info.width as usize + column) + 3]
    };
    // The curve of the marks is the same for both counts, except at its end.
    let covered = centres.iter().filter(|&&(px, py)| alpha(px, py) == 255).count();
    assert!(covered > 18_900, "{covered}");
    let inked = pixels.chunks(4).filter(|pixel| pixel[3] > 0).count();
    assert!(inked < pixels.len() / 4 / 4, "{inked} of {}", pixels.len() / 4);
}

/// A scale of colours is a bar whose labels do not touch, also in a narrow picture.
#[test]
fn golden_a_map_has_a_bar_of_its_colours() {
    let colours: Vec<Colour> = (0..8).map(|k| Colour(30 * k, 0, 0)).collect();
    let limits: Vec<String> = (0..9).map(|k| format!("{:.3}", 0.01 + 0.005 * f64::from(k))).collect();
    let layers =
        vec![Layer::new("mm", BLACK, Shape::Bar { colours: colours.clone(), limits: limits.clone() })];
    let wide = figure(layers);
    let told = texts(&wide);
    assert!(limits.iter().chain([&"mm".to_owned()]).all(|label| told.contains(label)), "{told:?}");
    let svg = canvas::svg(&wide).unwrap();
    let places =
        colours.iter().map(|Colour(r, ..)| svg.find(&format!("fill=\"#{r:02x}0000\" shape-rend")).unwrap());
    assert!(places.collect::<Vec<_>>().is_sorted(), "{svg}");
    let svg = canvas::svg(&wide.printed(60.0)).unwrap();
    let kept = limits.iter().filter(|label| svg.contains(&format!(">{label}<"))).count();
    assert!((3..9).contains(&kept), "{kept}");
}
