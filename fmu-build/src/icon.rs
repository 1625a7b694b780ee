//! The icon `model.png`: the box on its spring, the block between the stops, the secondary
//! oscillator.

use vibro_figures::canvas::palette::{BLACK, BLOCK, BOX, GREY, SECONDARY};
use vibro_figures::canvas::{Canvas, CanvasPoint, Drawing, Pen};

const PEN: f64 = 22.0;

/// The icon.
pub struct Icon;

impl Drawing for Icon {
    fn size(&self) -> (u32, u32) {
        (1024, 1024)
    }

    fn draw(&self, canvas: &mut Canvas) {
        // Ground on both sides.
        canvas.rectangles(&[[(24.0, 150.0), (64.0, 874.0)], [(960.0, 150.0), (1000.0, 874.0)]], GREY);
        // Box: a frame open to the right, where the coupling spring passes.
        canvas.lines(&[spring(64.0, 230.0, 512.0, 50.0)], Pen::solid(BLACK, PEN));
        let walls = [
            [(230.0, 250.0), (640.0, 290.0)],
            [(230.0, 734.0), (640.0, 774.0)],
            [(230.0, 250.0), (275.0, 774.0)],
            [(600.0, 250.0), (640.0, 430.0)],
            [(600.0, 594.0), (640.0, 774.0)],
        ];
        canvas.rectangles(&walls, BOX);
        // Block, the coupling spring, the secondary oscillator and its spring.
        canvas.rectangles(&[[(370.0, 400.0), (520.0, 624.0)]], BLOCK);
        canvas.rectangles(&[[(730.0, 400.0), (830.0, 624.0)]], SECONDARY);
        let springs = [spring(520.0, 730.0, 512.0, 50.0), spring(830.0, 960.0, 512.0, 50.0)];
        canvas.lines(&springs, Pen::solid(BLACK, PEN - 6.0));
        // The drive.
        canvas.lines(&[vec![(290.0, 160.0), (520.0, 160.0)]], Pen::solid(BLACK, PEN));
        canvas.polygon(&[(510.0, 110.0), (600.0, 160.0), (510.0, 210.0)], BLACK, 1.0);
    }
}

/// A zigzag between two abscissas.
pub(crate) fn spring(from: f64, to: f64, y: f64, height: f64) -> Vec<CanvasPoint> {
    const TEETH: u32 = 6;
    let end = (to - from) / 8.0;
    let (first, last) = (from + end, to - end);
    let tooth = |i: u32| {
        let side = if i.is_multiple_of(2) { height } else { -height };
        (first + (last - first) * f64::from(2 * i + 1) / f64::from(2 * TEETH), y + side)
    };
    let mut points = vec![(from, y), (first, y)];
    points.extend((0..TEETH).map(tooth));
    points.extend([(last, y), (to, y)]);
    points
}
