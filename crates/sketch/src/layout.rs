//! Positions of all symbols. Bodies are boxes in a row. Elements between neighbours, and loads,
//! are in lanes of the gap between two boxes. Elements to ground are in the end gaps or in lanes
//! under the row. Other elements are in lanes above the row; blocks are at the bottom.

use crate::blocks::{BlockBox, blocks};
use crate::connections::{Connection, Ends, Symbol, connections};
use crate::flexible::drawn;
use crate::order::{Side, ground_side, order};
use crate::sizes::{ARM_FONT, BODY_FONT, FONT, MARGIN, NAME};
use vibro_figures::canvas::text_width;
use vibro_machine::Description;
use vibro_machine::description::{BodyKind, Dimension};
use vibro_numerics::sorting::sort_by_key;

/// Smallest length of a symbol.
const SYMBOL: f64 = 230.0;
/// Length of the symbol itself between the texts of its lever arms.
const BARE: f64 = 240.0;
/// Space between a text and its neighbour.
const ROOM: f64 = 24.0;
/// Distance from a box to the lanes above and below it.
const OFF: f64 = 30.0;
/// Smallest width and height of a box.
const BOX: (f64, f64) = (170.0, 190.0);
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
    /// Whether a stop is drawn as two facing plates; otherwise as a clasp.
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
    pub width: f64,
    pub height: f64,
    pub top: f64,
    pub bottom: f64,
    pub bodies: Vec<BodyBox>,
    pub placed: Vec<Placed>,
    /// Legs and bars, each from a point to a point.
    pub lines: Vec<([(f64, f64); 2], With)>,
    /// Walls: x, top, bottom, and whether the hatching is on the right.
    pub walls: Vec<(f64, f64, f64, bool)>,
    /// Texts of lever arms at legs, with their positions and columns.
    pub texts: Vec<((f64, f64), String, usize)>,
    pub blocks: Vec<BlockBox>,
}

/// Height of a symbol without the name above it.
pub(crate) fn height_of(symbol: Option<Symbol>) -> f64 {
    match symbol {
        Some(Symbol::Spring { zigzag: true, dashpot: true, .. } | Symbol::Series { dashpot: true, .. }) => {
            132.0
        }
        Some(Symbol::Link) => 36.0,
        None => 44.0,
        Some(Symbol::Stop { .. }) => 84.0,
        Some(_) => 64.0,
    }
}

fn lane(item: &Item) -> f64 {
    let arms = if item.arms.iter().any(Option::is_some) { 0.8 * ARM_FONT } else { 0.0 };
    NAME + height_of(item.symbol).max(2.0 * arms) + ROOM
}

/// Width that the text of a lever arm takes at an end of a symbol.
pub(crate) fn room_of(arm: Option<&str>) -> f64 {
    arm.map_or(0.0, |arm| text_width(arm, ARM_FONT) + 20.0)
}

/// Width of a symbol with its name and lever arms.
fn need(item: &Item) -> f64 {
    // The symbol is centred, so both ends get the space for the longer text.
    let arm = item.arms.iter().map(|arm| room_of(arm.as_deref())).fold(0.0, f64::max);
    (text_width(&item.name, FONT) + ROOM).max(SYMBOL).max(if arm > 0.0 { BARE + 2.0 * arm } else { 0.0 })
}

/// An element or a load without a position.
#[derive(Clone, Debug)]
struct Item {
    name: String,
    symbol: Option<Symbol>,
    faces: bool,
    arms: [Option<String>; 2],
}

/// An element above the row.
struct Long {
    item: Item,
    columns: Vec<usize>,
    /// Whether its left end is a wall.
    walled: bool,
    arms: Vec<(usize, String)>,
}

/// Items by their region: in gaps, under boxes and above the row.
#[derive(Default)]
struct Sorted {
    gaps: Vec<Vec<Item>>,
    /// Items by column: first with the wall on the left, then on the right.
    under: Vec<[Vec<Item>; 2]>,
    over: Vec<Long>,
}

fn sort(machine: &Description, connections: &[Connection], column: &[usize]) -> Sorted {
    let count = column.len();
    let mut sorted = Sorted { gaps: vec![Vec::new(); count + 1], ..Sorted::default() };
    sorted.under = vec![Default::default(); count];
    for connection in connections {
        let Connection { name, symbol, ends, arms } = connection;
        let arm = |body: usize| arms.iter().find(|arm| arm.0 == body).map(|arm| arm.1.clone());
        let item = |faces: bool, ends: [Option<usize>; 2]| Item {
            name: name.clone(),
            symbol: Some(*symbol),
            faces,
            arms: ends.map(|body| body.and_then(arm)),
        };
        if let Some((body, side)) = ground_side(connection) {
            let place = column[body];
            let right = side == Side::Right || (side == Side::Either && place + 1 == count && place > 0);
            let ends = if right { [Some(body), None] } else { [None, Some(body)] };
            let item = item(true, ends);
            match (right, place) {
                (false, 0) => sorted.gaps[0].push(item),
                (true, _) if place + 1 == count => sorted.gaps[count].push(item),
                _ => sorted.under[place][usize::from(right)].push(item),
            }
            continue;
        }
        match ends {
            Ends::Two([Some(a), Some(b)]) => {
                let (first, second) = (column[*a], column[*b]);
                let faces = second < first;
                let ends = if faces { [Some(*b), Some(*a)] } else { [Some(*a), Some(*b)] };
                if first.abs_diff(second) == 1 {
                    sorted.gaps[first.max(second)].push(item(faces, ends));
                } else {
                    let columns = vec![first.min(second), first.max(second)];
                    sorted.over.push(Long {
                        item: item(faces, ends),
                        columns,
                        walled: false,
                        arms: Vec::new(),
                    });
                }
            }
            Ends::Many(bodies) => {
                let mut columns: Vec<usize> = bodies.iter().map(|&body| column[body]).collect();
                columns.sort_unstable();
                let arms = arms.iter().map(|(body, text)| (column[*body], text.clone())).collect();
                sorted.over.push(Long { item: item(true, [None, None]), columns, walled: true, arms });
            }
            Ends::Two(_) => {}
        }
    }
    for load in &machine.loads {
        let item = Item { name: load.name.clone(), symbol: None, faces: true, arms: [None, None] };
        sorted.gaps[column[load.body]].push(item);
    }
    sorted
}

impl Layout {
    /// The layout of a machine.
    pub(crate) fn new(whole: &Description) -> Self {
        let machine = &drawn(whole);
        let connections = connections(machine);
        let order = order(machine.bodies.len(), &connections);
        let mut column = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, &body)| column[body] = place);
        let sorted = sort(machine, &connections, &column);
        let mut layout = Self::default();
        let over = layout.boxes(machine, &order, &sorted);
        layout.fill_gaps(&sorted);
        layout.fill_under(&sorted);
        layout.fill_over(&sorted.over, &over);
        let lowest =
            layout.placed.iter().map(|p| p.y + 0.5 * height_of(p.symbol)).fold(layout.bottom, f64::max);
        (layout.blocks, layout.width) = blocks(whole, lowest + 2.0 * MARGIN, layout.width);
        let lowest = layout.blocks.last().map_or(lowest, |block| block.bottom);
        layout.height = lowest + 2.0 * MARGIN;
        layout
    }

    /// Places the boxes. Returns, for each column, the long elements that have a leg on the box,
    /// from left to right.
    fn boxes(&mut self, machine: &Description, order: &[usize], sorted: &Sorted) -> Vec<Vec<usize>> {
        let count = order.len();
        let span = |long: &Long| long.columns[long.columns.len() - 1] - long.columns[0];
        let legs: Vec<Vec<usize>> = (0..count)
            .map(|place| {
                let ends = |(_, long): &(usize, &Long)| long.columns.contains(&place);
                let mut own: Vec<_> = sorted.over.iter().enumerate().filter(ends).collect();
                // Leftward elements first, short before long, then rightward ones, long before
                // short: legs do not cross the lanes of other elements of their box.
                sort_by_key(&mut own, |(_, long)| {
                    let leftwards = long.columns[0] != place;
                    if leftwards { (0, span(long)) } else { (1, usize::MAX - span(long)) }
                });
                own.into_iter().map(|(i, _)| i).collect()
            })
            .collect();
        let gap_width = |gap: &[Item], edge: bool| {
            let widest = gap.iter().map(need).fold(0.0, f64::max);
            if edge && gap.is_empty() { 0.0 } else { widest.max(if edge { 0.0 } else { SYMBOL }) }
        };
        let widths: Vec<f64> =
            sorted.gaps.iter().enumerate().map(|(g, gap)| gap_width(gap, g == 0 || g == count)).collect();
        let walled = |gap: &[Item]| gap.iter().any(|item| item.symbol.is_some());
        let stack = |gap: &Vec<Item>| gap.iter().map(lane).sum::<f64>();
        let tallest = sorted.gaps.iter().map(stack).fold(BOX.1, f64::max) + ROOM;
        let mut x = MARGIN + if walled(&sorted.gaps[0]) { WALL } else { 0.0 };
        // An element above the row with a wall starts left of its first box.
        let walls = sorted.over.iter().filter(|long| long.walled && long.columns[0] == 0);
        let first = walls.map(|long| need(&long.item) + WALL).fold(0.0, f64::max);
        x += (first - widths[0]).max(0.0);
        for (place, &body) in order.iter().enumerate() {
            x += widths[place];
            let described = &machine.bodies[body];
            let under = sorted.under[place].iter().flatten().map(need).fold(0.0, f64::max);
            let beside = widths[place].min(widths[place + 1]);
            let under = if under > 0.0 { 2.0 * (under + WALL + ROOM) - beside } else { 0.0 };
            let name = text_width(&described.name, BODY_FONT) + 2.0 * ROOM;
            let width = name.max(BOX.0).max(under).max(LEGS * (legs[place].len() + 1) as f64);
            let (prescribed, gravity) = match &described.kind {
                BodyKind::Prescribed { .. } | BodyKind::Integrated(_) => (true, 0.0),
                BodyKind::Node(_) => (false, 0.0),
                BodyKind::Free(free) => (false, if machine.gravity > 0.0 { free.gravity } else { 0.0 }),
            };
            self.bodies.push(BodyBox {
                name: described.name.clone(),
                left: x,
                right: x + width,
                prescribed,
                rotates: described.dimension == Dimension::Rotation,
                gravity,
            });
            x += width;
        }
        x += widths[count] + if walled(&sorted.gaps[count]) { WALL } else { 0.0 };
        self.width = x + MARGIN;
        let mut over: Vec<&Long> = sorted.over.iter().collect();
        sort_by_key(&mut over, |long| span(long));
        let heights: f64 = over.iter().map(|long| lane(&long.item)).sum();
        self.top = MARGIN + if over.is_empty() { 0.0 } else { heights + OFF };
        self.bottom = self.top + tallest;
        legs
    }

    fn fill_gaps(&mut self, sorted: &Sorted) {
        let count = self.bodies.len();
        for (g, gap) in sorted.gaps.iter().enumerate() {
            let walled = gap.iter().any(|item| item.symbol.is_some());
            let from = match g {
                0 => self.bodies[0].left - gap.iter().map(need).fold(0.0, f64::max),
                _ => self.bodies[g - 1].right,
            };
            let to = if g == count { self.width - MARGIN - WALL } else { self.bodies[g].left };
            if walled && g == 0 {
                self.walls.push((from, self.top, self.bottom, false));
            }
            if walled && g == count {
                self.walls.push((to, self.top, self.bottom, true));
            }
            let height: f64 = gap.iter().map(lane).sum();
            let mut y = 0.5 * (self.top + self.bottom - height);
            let with = [g.checked_sub(1), Some(g).filter(|g| *g < count)];
            for item in gap {
                self.put(item, from, to, y, with);
                y += lane(item);
            }
        }
    }

    /// Places an item in the lane whose upper edge is at `y`.
    fn put(&mut self, item: &Item, from: f64, to: f64, y: f64, with: With) {
        let Item { name, symbol, faces, arms } = item.clone();
        let y = y + NAME + 0.5 * (lane(item) - NAME - ROOM);
        let (stretch, opening) = (0.0, None);
        self.placed.push(Placed { name, symbol, from, to, y, faces, arms, with, stretch, opening });
    }

    fn fill_under(&mut self, sorted: &Sorted) {
        for (place, sides) in sorted.under.iter().enumerate() {
            let BodyBox { left, right, .. } = self.bodies[place];
            let middle = 0.5 * (left + right);
            let mut y = self.bottom + OFF;
            let mut end = self.bottom;
            for row in 0..sides[0].len().max(sides[1].len()) {
                let row = [sides[0].get(row), sides[1].get(row)];
                let height = row.iter().flatten().map(|item| lane(item)).fold(0.0, f64::max);
                for (right, item) in row.into_iter().enumerate() {
                    let Some(item) = item else { continue };
                    let length = need(item);
                    let wall = if right == 1 { middle + length } else { middle - length };
                    let with = if right == 1 { [Some(place), None] } else { [None, Some(place)] };
                    self.put(item, middle.min(wall), middle.max(wall), y, with);
                    end = self.placed.last().map_or(end, |placed| placed.y);
                    let half = 0.5 * height_of(item.symbol) + 8.0;
                    self.walls.push((wall, end - half, end + half, right == 1));
                }
                y += height;
            }
            if end > self.bottom {
                self.lines.push(([(middle, self.bottom), (middle, end)], [Some(place); 2]));
            }
        }
    }

    fn fill_over(&mut self, long: &[Long], legs: &[Vec<usize>]) {
        let span = |long: &Long| long.columns[long.columns.len() - 1] - long.columns[0];
        let mut by_length: Vec<usize> = (0..long.len()).collect();
        sort_by_key(&mut by_length, |&i| span(&long[i]));
        let mut floor = self.top - OFF;
        let ports_of = |layout: &Self, i: usize| -> Vec<(usize, f64)> {
            long[i].columns.iter().map(|&place| (place, layout.port(place, i, legs))).collect()
        };
        for (rank, &i) in by_length.iter().enumerate() {
            let Long { item, walled, arms, .. } = &long[i];
            let ports = ports_of(self, i);
            let height = lane(item);
            let (first, last) = (ports[0].1, ports[ports.len() - 1].1);
            let (from, to) = if *walled { (first - need(item), first) } else { (first, last) };
            // Legs of elements in the lanes above cross this lane: the symbol is in the widest
            // free interval.
            let above = by_length[rank + 1..].iter().flat_map(|&above| ports_of(self, above));
            let mut cuts: Vec<f64> = above.map(|port| port.1).filter(|x| from < *x && *x < to).collect();
            cuts.extend([from, to]);
            cuts.sort_by(f64::total_cmp);
            let parts = cuts.windows(2).map(|part| (part[0], part[1]));
            let widest = parts.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)));
            let (left, right) = widest.unwrap_or((from, to));
            let [first_of, last_of] = [ports[0].0, ports[ports.len() - 1].0].map(Some);
            let with = if *walled { [None, first_of] } else { [first_of, last_of] };
            self.put(item, left, right, floor - height, with);
            let y = self.placed.last().map_or(floor, |placed| placed.y);
            for (k, (end, part)) in [(from, left), (right, to)].into_iter().enumerate() {
                if end < part {
                    self.lines.push(([(end, y), (part, y)], [with[k]; 2]));
                }
            }
            if *walled {
                let half = 0.5 * height_of(item.symbol) + 8.0;
                self.walls.push((from, y - half, y + half, false));
                self.lines.push(([(first, y), (last, y)], [first_of, last_of]));
            }
            for (place, x) in ports {
                self.lines.push(([(x, y), (x, self.top)], [Some(place); 2]));
                if let Some((_, text)) = arms.iter().find(|arm| arm.0 == place) {
                    self.texts.push(((x + 10.0, self.top - 0.7 * ARM_FONT), text.clone(), place));
                }
            }
            floor -= height;
        }
    }

    /// The x coordinate of a long element's leg on a box.
    fn port(&self, place: usize, long: usize, legs: &[Vec<usize>]) -> f64 {
        let BodyBox { left, right, .. } = self.bodies[place];
        let rank = legs[place].iter().position(|&i| i == long).unwrap_or(0);
        left + (right - left) * (rank + 1) as f64 / (legs[place].len() + 1) as f64
    }
}
