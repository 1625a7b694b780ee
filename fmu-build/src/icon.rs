//! The icon `model.png`: the box on its spring, the block between the stops, the secondary oscillator.

use plotters::coord::Shift;
use plotters::prelude::*;
use vibro::figures::canvas::Drawing;
use vibro::figures::canvas::palette::{BLACK, BLUE, GREEN, GREY, VERMILLION};

const PEN: u32 = 22;

/// The icon.
pub struct Icon;

type Point = (i32, i32);

impl Drawing for Icon {
    fn size(&self) -> (u32, u32) {
        (1024, 1024)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), String> {
        let text = |e: DrawingAreaErrorKind<DB::ErrorType>| e.to_string();
        area.fill(&WHITE).map_err(text)?;
        let line =
            |points: Vec<Point>, style: ShapeStyle| area.draw(&PathElement::new(points, style)).map_err(text);
        let fill = |corners: [Point; 2], colour: RGBColor| {
            area.draw(&Rectangle::new(corners, colour.filled())).map_err(text)
        };
        // Ground on both sides.
        fill([(24, 150), (64, 874)], GREY)?;
        fill([(960, 150), (1000, 874)], GREY)?;
        // Box: a frame open to the right, where the coupling spring passes.
        line(spring(64, 230, 512, 50), BLACK.stroke_width(PEN))?;
        for wall in [[(230, 250), (640, 290)], [(230, 734), (640, 774)], [(230, 250), (275, 774)]] {
            fill(wall, BLUE)?;
        }
        fill([(600, 250), (640, 430)], BLUE)?;
        fill([(600, 594), (640, 774)], BLUE)?;
        // Block, the coupling spring, the secondary oscillator and its spring.
        fill([(370, 400), (520, 624)], VERMILLION)?;
        line(spring(520, 730, 512, 50), BLACK.stroke_width(PEN - 6))?;
        fill([(730, 400), (830, 624)], GREEN)?;
        line(spring(830, 960, 512, 50), BLACK.stroke_width(PEN - 6))?;
        // The drive.
        line(vec![(290, 160), (520, 160)], BLACK.stroke_width(PEN))?;
        area.draw(&Polygon::new(vec![(510, 110), (600, 160), (510, 210)], BLACK.filled())).map_err(text)
    }
}

/// A zigzag between two abscissas.
pub(crate) fn spring(from: i32, to: i32, y: i32, height: i32) -> Vec<Point> {
    const TEETH: i32 = 6;
    let end = (to - from) / 8;
    let (first, last) = (from + end, to - end);
    let tooth = |i: i32| {
        let side = if i % 2 == 0 { height } else { -height };
        (first + (last - first) * (2 * i + 1) / (2 * TEETH), y + side)
    };
    let mut points = vec![(from, y), (first, y)];
    points.extend((0..TEETH).map(tooth));
    points.extend([(last, y), (to, y)]);
    points
}
