//! Places of the symbols in gaps, in lanes under the row and in lanes above it.

use crate::items::{Item, height_of};
use crate::layout::{BodyBox, Layout, OFF, Placed, WALL, With};
use crate::sizes::{MARGIN, ROOM};
use crate::sorted::{Long, Sorted};
use vibro_numerics::sorting::sort_by_key;

impl Layout {
    /// Fills the gaps. Returns the lowest edge of boxes and texts.
    pub(crate) fn fill_gaps(&mut self, sorted: &Sorted) -> f64 {
        let (way, count, mut lowest) = (self.way, self.bodies.len(), self.bottom);
        for (g, gap) in sorted.gaps.iter().enumerate() {
            let walled = gap.iter().any(|item| item.symbol.is_some());
            let from = match g {
                0 => self.bodies[0].left - gap.iter().map(|item| way.need(item)).fold(0.0, f64::max),
                _ => self.bodies[g - 1].right,
            };
            let to = if g == count { self.length - MARGIN - WALL } else { self.bodies[g].left };
            if walled && g == 0 {
                self.walls.push((from, self.top, self.bottom, false));
            }
            if walled && g == count {
                self.walls.push((to, self.top, self.bottom, true));
            }
            let height: f64 = gap.iter().map(|item| way.lane(item)).sum();
            let tail = gap.last().map_or(0.0, |item| way.tail(item));
            let mut y = 0.5 * (self.top + self.bottom - (height - tail));
            let with = [g.checked_sub(1), Some(g).filter(|g| *g < count)];
            for item in gap {
                self.put(item, from, to, y, with);
                y += way.lane(item);
            }
            if tail > 0.0 {
                lowest = lowest.max(y - ROOM);
            }
        }
        lowest
    }

    /// Places an item in the lane whose upper edge is at `y`.
    fn put(&mut self, item: &Item, from: f64, to: f64, y: f64, with: With) {
        let Item { name, symbol, faces, arms } = item.clone();
        let y = y + self.way.middle(item);
        let (stretch, opening) = (0.0, None);
        self.placed.push(Placed { name, symbol, from, to, y, faces, arms, with, stretch, opening });
    }

    /// Fills the lanes under the row, whose first begins at `top`. Returns the lowest edge of all.
    pub(crate) fn fill_under(&mut self, sorted: &Sorted, top: f64) -> f64 {
        let (way, mut lowest) = (self.way, if self.way.is_upright() { top - OFF } else { self.bottom });
        for (place, sides) in sorted.under.iter().enumerate() {
            let BodyBox { left, right, .. } = self.bodies[place];
            let middle = 0.5 * (left + right);
            let mut y = top;
            let mut end = self.bottom;
            for row in 0..sides[0].len().max(sides[1].len()) {
                let row = [sides[0].get(row), sides[1].get(row)];
                let height = row.iter().flatten().map(|item| way.lane(item)).fold(0.0, f64::max);
                for (right, item) in row.into_iter().enumerate() {
                    let Some(item) = item else { continue };
                    let length = way.need(item);
                    let wall = if right == 1 { middle + length } else { middle - length };
                    let with = if right == 1 { [Some(place), None] } else { [None, Some(place)] };
                    self.put(item, middle.min(wall), middle.max(wall), y, with);
                    end = self.placed.last().map_or(end, |placed| placed.y);
                    let half = 0.5 * height_of(item.symbol) + 8.0;
                    self.walls.push((wall, end - half, end + half, right == 1));
                    // In an upright row the name is below the symbol.
                    let edge = if way.is_upright() { y + way.lane(item) - ROOM } else { end + half - 8.0 };
                    lowest = lowest.max(edge);
                }
                y += height;
            }
            if end > self.bottom {
                self.lines.push(([(middle, self.bottom), (middle, end)], [Some(place); 2]));
            }
        }
        lowest
    }

    /// Fills the lanes above the row, from `floor` upwards.
    pub(crate) fn fill_over(&mut self, long: &[Long], legs: &[Vec<usize>], mut floor: f64) {
        let way = self.way;
        let mut by_length: Vec<usize> = (0..long.len()).collect();
        sort_by_key(&mut by_length, |&i| long[i].span());
        let ports_of = |layout: &Self, i: usize| -> Vec<(usize, f64)> {
            long[i].columns.iter().map(|&place| (place, layout.port(place, i, legs))).collect()
        };
        for (rank, &i) in by_length.iter().enumerate() {
            let Long { item, walled, arms, .. } = &long[i];
            let ports = ports_of(self, i);
            let height = way.lane(item);
            let (first, last) = (ports[0].1, ports[ports.len() - 1].1);
            let wall = self.bodies[long[i].first()].left - way.need(item);
            let (from, to) = if *walled { (wall, first) } else { (first, last) };
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
                    self.texts.push(((x, self.top), text.clone(), place));
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
