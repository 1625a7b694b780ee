//! The sketch of the model with its symbols, for the documentation page.

use crate::icon::spring;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use vibro::figures::canvas::palette::{BLACK, BLUE, GREEN, GREY, VERMILLION};
use vibro::figures::canvas::{Drawing, FONT};

const PEN: u32 = 7;
const LABEL: u32 = 60;

/// The sketch.
pub struct Sketch;

type Point = (i32, i32);

impl Drawing for Sketch {
    fn size(&self) -> (u32, u32) {
        (2400, 990)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), String> {
        let text = |e: DrawingAreaErrorKind<DB::ErrorType>| e.to_string();
        area.fill(&WHITE).map_err(text)?;
        let thin = BLACK.stroke_width(PEN);
        let line = |points: Vec<Point>| area.draw(&PathElement::new(points, thin)).map_err(text);
        let fill = |corners: [Point; 2], colour: RGBColor| {
            area.draw(&Rectangle::new(corners, colour.filled())).map_err(text)
        };
        let label = |words: &str, at: Point, colour: RGBColor| {
            let style = (FONT, LABEL).into_font().color(&colour).pos(Pos::new(HPos::Center, VPos::Center));
            area.draw(&Text::new(words.to_owned(), at, style)).map_err(text)
        };
        let arrow = |from: Point, to: Point| {
            line(vec![from, to])?;
            let side = (to.0 - from.0).signum() * 34;
            let head = vec![to, (to.0 - side, to.1 - 16), (to.0 - side, to.1 + 16)];
            area.draw(&Polygon::new(head, BLACK.filled())).map_err(text)
        };

        // Ground on both sides.
        fill([(30, 180), (60, 800)], GREY)?;
        fill([(2340, 180), (2370, 800)], GREY)?;
        // The box with its spring and damper; an opening to the right for the coupling spring.
        line(spring(60, 420, 330, 36))?;
        label("k₁", (240, 245), BLACK)?;
        damper(&line, 60, 420, 650)?;
        label("c₁", (240, 745), BLACK)?;
        for wall in [[(420, 230), (1340, 270)], [(420, 710), (1340, 750)], [(420, 230), (460, 750)]] {
            fill(wall, BLUE)?;
        }
        fill([(1300, 230), (1340, 440)], BLUE)?;
        fill([(1300, 540), (1340, 750)], BLUE)?;
        label("m₁", (530, 330), BLUE)?;
        // The block with its gaps, the coupling, the secondary oscillator.
        fill([(780, 380), (980, 600)], VERMILLION)?;
        label("m₂", (880, 490), WHITE)?;
        line(spring(980, 1560, 490, 36))?;
        label("k₂₃", (1440, 405), BLACK)?;
        fill([(1560, 380), (1760, 600)], GREEN)?;
        label("m₃", (1660, 490), WHITE)?;
        line(spring(1760, 2340, 430, 36))?;
        label("k₃", (2050, 345), BLACK)?;
        damper(&line, 1760, 2340, 560)?;
        label("c₃", (2050, 655), BLACK)?;
        for (from, to) in [((620, 660), (460, 660)), ((620, 660), (780, 660))] {
            arrow(from, to)?;
        }
        label("L", (620, 615), BLACK)?;
        for (from, to) in [((1140, 660), (980, 660)), ((1140, 660), (1300, 660))] {
            arrow(from, to)?;
        }
        label("L", (1140, 615), BLACK)?;
        // Coordinates and the drive.
        for (name, at, colour) in [("x₁", 440, BLUE), ("x₂", 880, VERMILLION), ("x₃", 1660, GREEN)] {
            line(vec![(at, 790), (at, 870)])?;
            arrow((at, 830), (at + 170, 830))?;
            label(name, (at + 90, 900), colour)?;
        }
        arrow((460, 130), (720, 130))?;
        label("F₁₀ sin(ω₁t + φ) + f₁", (1080, 130), BLACK)?;
        arrow((1700, 130), (1860, 130))?;
        label("f₂, f₃ likewise", (2110, 130), BLACK)
    }
}

/// A dashpot between two abscissas.
fn damper(
    line: &impl Fn(Vec<Point>) -> Result<(), String>,
    from: i32,
    to: i32,
    y: i32,
) -> Result<(), String> {
    let (middle, half) = ((from + to) / 2, (to - from) / 8);
    line(vec![(from, y), (middle, y)])?;
    line(vec![(middle, y - 34), (middle, y + 34)])?;
    line(vec![
        (middle - half, y - 50),
        (middle + half, y - 50),
        (middle + half, y + 50),
        (middle - half, y + 50),
    ])?;
    line(vec![(middle + half, y), (to, y)])
}
