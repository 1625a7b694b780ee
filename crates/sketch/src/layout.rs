//! Positions of all symbols. Bodies are boxes in a row. Elements between neighbours, and loads,
//! are in lanes of the gap between two boxes. Elements to ground are in the end gaps or in lanes
//! under the row. Other elements are in lanes above the row; blocks are at the bottom.
//!
//! Places are (along the row, across it); [`Way::point`] turns them into points of the picture.
//! Left and right, above and below are meant for a row to the right.

use crate::blocks::{BlockBox, blocks};
use crate::connections::{Symbol, connections};
use crate::flexible::drawn;
use crate::items::{Item, SYMBOL};
use crate::order::order;
use crate::sizes::{ARM_FONT, BODY_FONT, MARGIN, ROOM};
use crate::sorted::{Long, Sorted, sort};
use crate::ways::Way;
use vibro_figures::canvas::text_width;
use vibro_machine::Description;
use vibro_machine::description::{BodyKind, Dimension};
use vibro_numerics::sorting::sort_by_key;

/// Distance from a box to the lanes above and below it.
pub(crate) const OFF: f64 = 30.0;
/// Smallest width and height of a box.
const BOX: (f64, f64) = (170.0, 190.0);
/// Height of the box of a free body in an upright row, and of a prescribed one with its hatching.
const UPRIGHT: (f64, f64) = (120.0, 150.0);
/// Width of the mark of gravity or of a prescribed motion next to a name, in an upright row.
pub(crate) const MARK: f64 = 70.0;
/// Smallest distance between legs on a box.
const LEGS: f64 = 46.0;
/// Width of a hatched wall.
pub(crate) const WALL: f64 = 34.0;

/// The box of a body.
#[derive(Clone, Debug)]
pub(crate) struct BodyBox {
    pub name: String,
    pub left: f64,
    pub right: f64,
    pub prescribed: bool,
    pub rotates: bool,
    /// Cosine of the angle to gravity.
    pub gravity: f64,
}

/// A symbol with its position in a lane.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    pub name: String,
    /// `None` for a load's arrow.
    pub symbol: Option<Symbol>,
    pub from: f64,
    pub to: f64,
    /// Height of the symbol's middle.
    pub y: f64,
    /// Whether a stop is drawn as a nose before a plate; otherwise as two hooks.
    pub faces: bool,
    /// Texts of the lever arms at both ends.
    pub arms: [Option<String>; 2],
    /// The boxes attached to its ends; `None` for ground.
    pub with: With,
    /// Extension compared with its length in the layout.
    pub stretch: f64,
    /// Distance between the plates of a stop, if it differs from the layout.
    pub opening: Option<f64>,
}

/// Columns of the boxes attached to two points.
pub(crate) type With = [Option<usize>; 2];

/// Positions of all symbols.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layout {
    pub way: Way,
    /// Size of the picture.
    pub width: f64,
    pub height: f64,
    /// Length of the row with its margins.
    pub length: f64,
    /// Edges of the boxes across the row.
    pub top: f64,
    pub bottom: f64,
    pub bodies: Vec<BodyBox>,
    pub placed: Vec<Placed>,
    /// Legs and bars, each from a point to a point.
    pub lines: Vec<([(f64, f64); 2], With)>,
    /// Walls: x, top, bottom, and whether the hatching is on the right.
    pub walls: Vec<(f64, f64, f64, bool)>,
    /// Texts of lever arms at legs, with the places where the legs meet boxes, and columns.
    pub texts: Vec<((f64, f64), String, usize)>,
    pub blocks: Vec<BlockBox>,
}

impl Layout {
    /// The layout of a machine.
    pub(crate) fn new(whole: &Description) -> Self {
        let machine = &drawn(whole);
        let way = Way::of(machine);
        let connections = connections(machine);
        let order = order(machine.bodies.len(), &connections, way.floor());
        let mut column = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, &body)| column[body] = place);
        let sorted = sort(machine, &connections, &column, way.floor());
        let mut layout = Self { way, ..Self::default() };
        let legs = legs(order.len(), &sorted.over);
        layout.boxes(machine, &order, &sorted, &legs);
        let beside = layout.fill_gaps(&sorted);
        let lowest = layout.fill_under(&sorted, beside + OFF);
        layout.fill_over(&sorted.over, &legs, layout.top - off(way, &sorted.over));
        layout.frame(whole, lowest);
        layout
    }

    /// Places the blocks below the row, whose lowest mark is at `lowest`, and sets the size.
    fn frame(&mut self, whole: &Description, lowest: f64) {
        let (width, height) = match self.way {
            Way::Right => (self.length, lowest + MARGIN),
            Way::Down | Way::Up => (lowest + MARGIN, self.length),
        };
        (self.blocks, self.width) = blocks(whole, height + MARGIN, width);
        self.height = self.blocks.last().map_or(height, |block| block.bottom + MARGIN);
        if !self.way.is_upright() {
            self.height += MARGIN;
        }
    }

    /// Places the boxes.
    fn boxes(&mut self, machine: &Description, order: &[usize], sorted: &Sorted, legs: &[Vec<usize>]) {
        let (way, count) = (self.way, order.len());
        let widths = gaps(way, sorted);
        let walled = |gap: &[Item]| gap.iter().any(|item| item.symbol.is_some());
        // The last text of an upright gap may extend beyond the boxes.
        let stack = |gap: &Vec<Item>| {
            gap.iter().map(|item| way.lane(item)).sum::<f64>() - gap.last().map_or(0.0, |item| way.tail(item))
        };
        let mut tallest = sorted.gaps.iter().map(stack).fold(BOX.1, f64::max) + ROOM;
        let mut x = MARGIN + if walled(&sorted.gaps[0]) { WALL } else { 0.0 };
        // An element above the row with a wall starts left of its first box.
        let walls = sorted.over.iter().filter(|long| long.walled && long.first() == 0);
        let first = walls.map(|long| way.need(&long.item) + WALL).fold(0.0, f64::max);
        x += (first - widths[0]).max(0.0);
        for (place, &body) in order.iter().enumerate() {
            x += widths[place];
            let described = &machine.bodies[body];
            let under = sorted.under[place].iter().flatten().map(|item| way.need(item)).fold(0.0, f64::max);
            let beside = widths[place].min(widths[place + 1]);
            let under = if under > 0.0 { 2.0 * (under + WALL + ROOM) - beside } else { 0.0 };
            let (prescribed, gravity) = match &described.kind {
                BodyKind::Prescribed { .. } | BodyKind::Integrated(_) => (true, 0.0),
                BodyKind::Node(_) => (false, 0.0),
                BodyKind::Free(free) => (false, if machine.gravity > 0.0 { free.gravity } else { 0.0 }),
            };
            let rotates = described.dimension == Dimension::Rotation;
            let name = text_width(&described.name, BODY_FONT) + 2.0 * ROOM;
            let own = match way {
                Way::Right => name.max(BOX.0),
                Way::Down | Way::Up if prescribed => UPRIGHT.1,
                Way::Down | Way::Up => UPRIGHT.0,
            };
            tallest = tallest.max(if way.is_upright() { name + 2.0 * MARK } else { 0.0 });
            let spaces = (legs[place].len() + 1) as f64;
            let width = own.max(under).max(spaces * spacing(way, &sorted.over, place));
            let name = described.name.clone();
            self.bodies.push(BodyBox { name, left: x, right: x + width, prescribed, rotates, gravity });
            x += width;
        }
        x += widths[count] + if walled(&sorted.gaps[count]) { WALL } else { 0.0 };
        self.length = x + MARGIN;
        let over = &sorted.over;
        let heights: f64 = over.iter().map(|long| way.lane(&long.item)).sum();
        self.top = MARGIN + if over.is_empty() { 0.0 } else { heights + off(way, over) };
        self.bottom = self.top + tallest;
    }
}

/// Widths of the gaps. The symbols of long elements have room over a gap, which no leg crosses.
fn gaps(way: Way, sorted: &Sorted) -> Vec<f64> {
    let last = sorted.gaps.len() - 1;
    let width = |(g, gap): (usize, &Vec<Item>)| {
        let widest = gap.iter().map(|item| way.need(item)).fold(0.0, f64::max);
        let edge = g == 0 || g == last;
        if edge { widest } else { widest.max(SYMBOL) }
    };
    let mut widths: Vec<f64> = sorted.gaps.iter().enumerate().map(width).collect();
    for long in &sorted.over {
        let need = way.need(&long.item);
        let (first, last) = (long.first(), long.last());
        if long.walled && first > 0 {
            widths[first] = widths[first].max(need + WALL + ROOM);
        } else if !long.walled {
            let widest = (first + 1..=last).max_by(|a, b| widths[*a].total_cmp(&widths[*b]));
            widest.into_iter().for_each(|g| widths[g] = widths[g].max(need));
        }
    }
    widths
}

/// The long elements with a leg on each box, from left to right.
fn legs(count: usize, over: &[Long]) -> Vec<Vec<usize>> {
    let of = |place| {
        let ends = |(_, long): &(usize, &Long)| long.columns.contains(&place);
        let mut own: Vec<_> = over.iter().enumerate().filter(ends).collect();
        // Leftward elements first, short before long, then rightward ones, long before
        // short: legs do not cross the lanes of other elements of their box.
        sort_by_key(&mut own, |(_, long)| {
            let leftwards = long.first() != place;
            if leftwards { (0, long.span()) } else { (1, usize::MAX - long.span()) }
        });
        own.into_iter().map(|(i, _)| i).collect()
    };
    (0..count).map(of).collect()
}

/// Width of the widest lever arm at the legs on a box, or on all boxes.
fn widest_arm(over: &[Long], place: Option<usize>) -> f64 {
    let arms = over.iter().flat_map(|long| &long.arms);
    let arms = arms.filter(|arm| place.is_none_or(|place| arm.0 == place));
    arms.map(|arm| text_width(&arm.1, ARM_FONT) + ROOM).fold(0.0, f64::max)
}

/// Smallest distance between the legs on a box: in a row to the right, lever arms are next to
/// legs.
fn spacing(way: Way, over: &[Long], place: usize) -> f64 {
    let arm = if way.is_upright() { 0.0 } else { widest_arm(over, Some(place)) };
    LEGS.max(arm)
}

/// Distance from the boxes to the lanes above them: in an upright row, lever arms are between.
fn off(way: Way, over: &[Long]) -> f64 {
    OFF.max(if way.is_upright() { widest_arm(over, None) } else { 0.0 })
}
