//! How well colours of areas are told apart: in a grey print, and with any colour vision.

use vibro_figures::canvas::Colour;

/// Least distance of two colours in CIELAB, four times the smallest visible difference (2.3).
pub(super) const DISTANCE: f64 = 9.0;

/// A matrix of three rows.
type Matrix = [[f64; 3]; 3];

/// Linear colours as seen with full vision and without red, green or blue cones (Machado, Oliveira
/// and Fernandes 2009, severity 1).
const VISIONS: [Matrix; 4] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
    [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
];
/// Linear sRGB to CIE XYZ, each row over the white of D65.
const XYZ: Matrix = [
    [0.4124 / 0.9505, 0.3576 / 0.9505, 0.1805 / 0.9505],
    [0.2126, 0.7152, 0.0722],
    [0.0193 / 1.089, 0.1192 / 1.089, 0.9505 / 1.089],
];

fn times(matrix: &Matrix, [r, g, b]: [f64; 3]) -> [f64; 3] {
    matrix.map(|[x, y, z]| (x * r + y * g + z * b).clamp(0.0, 1.0))
}

/// CIELAB of a colour with a vision.
fn lab(Colour(r, g, b): Colour, vision: &Matrix) -> [f64; 3] {
    // The luminance of a grey is its linear part.
    let linear = [r, g, b].map(|part| Colour(part, part, part).luminance());
    let cube = |x: f64| if x > 0.008856 { x.cbrt() } else { 7.787 * x + 16.0 / 116.0 };
    let [x, y, z] = times(&XYZ, times(vision, linear)).map(cube);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Least ratio of two luminances with stray light (WCAG), and least distance of two colours in
/// CIELAB with any vision.
pub(super) fn apart(colours: &[Colour]) -> (f64, f64) {
    let mut light: Vec<f64> = colours.iter().map(|colour| colour.luminance() + 0.05).collect();
    light.sort_by(f64::total_cmp);
    let step = light.windows(2).map(|pair| pair[1] / pair[0]).fold(f64::INFINITY, f64::min);
    let mut distance = f64::INFINITY;
    for vision in &VISIONS {
        let seen: Vec<[f64; 3]> = colours.iter().map(|colour| lab(*colour, vision)).collect();
        for (i, one) in seen.iter().enumerate() {
            for other in &seen[..i] {
                let squares: f64 = one.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum();
                distance = distance.min(squares.sqrt());
            }
        }
    }
    (step, distance)
}
