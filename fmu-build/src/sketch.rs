//! The sketch of the model with its symbols, for the documentation page.

use crate::icon::spring;
use vibro_figures::canvas::palette::{BLACK, BLOCK, BOX, GREY, SECONDARY, WHITE};
use vibro_figures::canvas::{Across, Along, Canvas, CanvasPoint, Colour, Drawing, Pen, Writing};

const PEN: f64 = 7.0;
const LABEL: f64 = 52.0;

/// The sketch.
pub struct Sketch;

impl Drawing for Sketch {
    fn size(&self) -> (u32, u32) {
        (2400, 990)
    }

    fn draw(&self, canvas: &mut Canvas) {
        // Ground on both sides.
        fill(canvas, [(30.0, 180.0), (60.0, 800.0)], GREY);
        fill(canvas, [(2340.0, 180.0), (2370.0, 800.0)], GREY);
        // The box with its spring and damper; an opening to the right for the coupling spring.
        line(canvas, spring(60.0, 420.0, 330.0, 36.0));
        label(canvas, "k₁", (240.0, 245.0), BLACK);
        damper(canvas, 60.0, 420.0, 650.0);
        label(canvas, "c₁", (240.0, 745.0), BLACK);
        for wall in [
            [(420.0, 230.0), (1340.0, 270.0)],
            [(420.0, 710.0), (1340.0, 750.0)],
            [(420.0, 230.0), (460.0, 750.0)],
        ] {
            fill(canvas, wall, BOX);
        }
        fill(canvas, [(1300.0, 230.0), (1340.0, 440.0)], BOX);
        fill(canvas, [(1300.0, 540.0), (1340.0, 750.0)], BOX);
        label(canvas, "m₁", (530.0, 330.0), BOX);
        // The block with its gaps, the coupling, the secondary oscillator.
        fill(canvas, [(780.0, 380.0), (980.0, 600.0)], BLOCK);
        label(canvas, "m₂", (880.0, 490.0), WHITE);
        line(canvas, spring(980.0, 1560.0, 490.0, 36.0));
        label(canvas, "k₂₃", (1440.0, 405.0), BLACK);
        fill(canvas, [(1560.0, 380.0), (1760.0, 600.0)], SECONDARY);
        label(canvas, "m₃", (1660.0, 490.0), WHITE);
        line(canvas, spring(1760.0, 2340.0, 430.0, 36.0));
        label(canvas, "k₃", (2050.0, 345.0), BLACK);
        damper(canvas, 1760.0, 2340.0, 560.0);
        label(canvas, "c₃", (2050.0, 655.0), BLACK);
        for (from, to) in [((620.0, 660.0), (460.0, 660.0)), ((620.0, 660.0), (780.0, 660.0))] {
            arrow(canvas, from, to);
        }
        label(canvas, "L", (620.0, 615.0), BLACK);
        for (from, to) in [((1140.0, 660.0), (980.0, 660.0)), ((1140.0, 660.0), (1300.0, 660.0))] {
            arrow(canvas, from, to);
        }
        label(canvas, "L", (1140.0, 615.0), BLACK);
        // Coordinates and the drive.
        for (name, at, colour) in [("x₁", 440.0, BOX), ("x₂", 880.0, BLOCK), ("x₃", 1660.0, SECONDARY)]
        {
            line(canvas, vec![(at, 790.0), (at, 870.0)]);
            arrow(canvas, (at, 830.0), (at + 170.0, 830.0));
            label(canvas, name, (at + 90.0, 900.0), colour);
        }
        arrow(canvas, (460.0, 130.0), (720.0, 130.0));
        label(canvas, "F₁₀ sin(ω₁t + φ) + f₁", (1080.0, 130.0), BLACK);
        arrow(canvas, (1700.0, 130.0), (1860.0, 130.0));
        label(canvas, "f₂, f₃ likewise", (2110.0, 130.0), BLACK);
    }
}

fn line(canvas: &mut Canvas, points: Vec<CanvasPoint>) {
    canvas.lines(&[points], Pen::solid(BLACK, PEN));
}

fn fill(canvas: &mut Canvas, corners: [CanvasPoint; 2], colour: Colour) {
    canvas.rectangles(&[corners], colour);
}

fn label(canvas: &mut Canvas, words: &str, at: CanvasPoint, colour: Colour) {
    let (along, across) = (Along::Middle, Across::Centre);
    canvas.text(at, words, &Writing { size: LABEL, colour, along, across, upwards: false });
}

fn arrow(canvas: &mut Canvas, from: CanvasPoint, to: CanvasPoint) {
    let side = (to.0 - from.0).signum() * 34.0;
    line(canvas, vec![from, (to.0 - side, to.1)]);
    canvas.polygon(&[to, (to.0 - side, to.1 - 16.0), (to.0 - side, to.1 + 16.0)], BLACK, 1.0);
}

/// A dashpot between two abscissas.
fn damper(canvas: &mut Canvas, from: f64, to: f64, y: f64) {
    let (middle, half) = (0.5 * (from + to), (to - from) / 8.0);
    let cup = [(-half, -50.0), (half, -50.0), (half, 50.0), (-half, 50.0)];
    line(canvas, vec![(from, y), (middle, y)]);
    line(canvas, vec![(middle, y - 34.0), (middle, y + 34.0)]);
    line(canvas, cup.map(|(dx, dy)| (middle + dx, y + dy)).to_vec());
    line(canvas, vec![(middle + half, y), (to, y)]);
}
