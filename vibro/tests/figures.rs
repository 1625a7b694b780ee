//! Pictures by what is measured on their pixels: curves stay inside the frames of their panels.

use vibro::figures::canvas;
use vibro::figures::canvas::palette::VERMILLION;
use vibro::figures::chart::{Axis, Dash, Figure, Layer, Panel, Path};

/// Numbers of values: few, as in a quick look, and many more than a panel has pixels.
const COUNTS: [usize; 3] = [50, 500, 5000];
/// Half the stroke of a curve and the smoothing of edges, in pixels of the PNG.
const EDGE: usize = 3;

/// A curve that turns by nearly half a circle at each value, as exponents of neighbouring values do.
fn jagged(count: usize) -> Path {
    let height = |i: usize| (i as f64 * 0.618_034).fract() * if i % 2 == 0 { 0.9 } else { -0.9 };
    (0..count).map(|i| (i as f64 / (count - 1) as f64, height(i))).collect()
}

fn figure(layers: Vec<Layer>) -> Figure {
    let (x, y) = (Axis::over("x (–)", 0.0, 1.0), Axis::over("y (–)", -1.0, 1.0));
    let panel = Panel { title: "(a)".into(), x, y, layers };
    Figure { panels: vec![panel], columns: 1, panel: (1700, 1150), ..Figure::default() }
}

/// The pixels of a figure's PNG: width, height, RGB rows from above.
fn drawn(figure: &Figure) -> (usize, usize, Vec<u8>) {
    let file = canvas::png(figure).unwrap();
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
        let layer = Layer::line("", VERMILLION, Dash::Solid, jagged(count));
        let (_, _, full) = drawn(&figure(vec![layer]));
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
