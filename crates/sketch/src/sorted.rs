//! Elements and loads by their region of the sketch.

use crate::connections::{Connection, Ends};
use crate::items::Item;
use crate::order::{Side, ground_side};
use vibro_machine::Description;

/// An element in a lane above the row.
pub(crate) struct Long {
    pub item: Item,
    pub columns: Vec<usize>,
    /// Whether its left end is a wall.
    pub walled: bool,
    pub arms: Vec<(usize, String)>,
}

/// Items by their region: in gaps, under boxes and above the row.
#[derive(Default)]
pub(crate) struct Sorted {
    pub gaps: Vec<Vec<Item>>,
    /// Items by column: first with the wall on the left, then on the right.
    pub under: Vec<[Vec<Item>; 2]>,
    pub over: Vec<Long>,
}

/// The elements and loads of a machine by their region. Ground at an inner body is on the side of
/// the floor; without a floor, it is on the left.
pub(crate) fn sort(
    machine: &Description,
    connections: &[Connection],
    column: &[usize],
    floor: Option<Side>,
) -> Sorted {
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
            let either = match place {
                0 if count > 1 => Side::Left,
                last if last > 0 && last + 1 == count => Side::Right,
                _ => floor.unwrap_or(Side::Left),
            };
            let right = side == Side::Right || (side == Side::Either && either == Side::Right);
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

impl Long {
    pub(crate) fn first(&self) -> usize {
        self.columns[0]
    }

    pub(crate) fn last(&self) -> usize {
        self.columns[self.columns.len() - 1]
    }

    pub(crate) fn span(&self) -> usize {
        self.last() - self.first()
    }
}
