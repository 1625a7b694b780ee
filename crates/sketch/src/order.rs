//! Order of the bodies in the row: elements act between neighbours if possible, with ground at the
//! ends.

use crate::connections::{Connection, Ends, Symbol};

/// Largest number of bodies for trying all orders; with more, pairs are exchanged.
const ALL_ORDERS: usize = 7;
/// Largest number of passes over all pairs in the search by exchanges.
const TURNS: usize = 20;

/// The body of an element to ground, and the side on which ground is drawn: the side on which a
/// stop's plates face each other.
pub(crate) fn ground_side(connection: &Connection) -> Option<(usize, Side)> {
    match (&connection.ends, connection.symbol) {
        (Ends::Two([None, Some(body)]), Symbol::Stop { .. }) => Some((*body, Side::Right)),
        (Ends::Two([Some(body), None]), Symbol::Stop { .. }) => Some((*body, Side::Left)),
        (Ends::Two([None, Some(body)] | [Some(body), None]), _) => Some((*body, Side::Either)),
        _ => None,
    }
}

/// A side of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Left,
    Right,
    Either,
}

/// The bodies from left to right. Ground is preferred on the side of the floor, if there is one.
pub(crate) fn order(count: usize, connections: &[Connection], floor: Option<Side>) -> Vec<usize> {
    let files: Vec<usize> = (0..count).collect();
    let cost = |order: &[usize]| cost(order, connections, floor);
    if count <= ALL_ORDERS {
        let (mut best, mut least) = (files.clone(), cost(&files));
        permute(&mut files.clone(), 0, &mut |order| {
            let cost = cost(order);
            if cost < least {
                least = cost;
                best = order.to_vec();
            }
        });
        return best;
    }
    // The search from one order may miss the reverse of the best one.
    let reverse = files.iter().rev().copied().collect();
    let found = [files, reverse].map(|start| exchanged(start, &cost));
    let [(cost, best), (other, reverse)] = found;
    if other < cost { reverse } else { best }
}

/// An order that no exchange of two bodies improves, from a first one, with its cost.
fn exchanged(mut best: Vec<usize>, cost: &dyn Fn(&[usize]) -> usize) -> (usize, Vec<usize>) {
    let count = best.len();
    let mut least = cost(&best);
    for _ in 0..TURNS {
        let before = least;
        for i in 0..count {
            // For a large number of bodies only nearby ones are exchanged, which bounds the time.
            for j in i + 1..count.min(i + 1 + 2000 / count) {
                best.swap(i, j);
                let changed = cost(&best);
                if changed < least {
                    least = changed;
                } else {
                    best.swap(i, j);
                }
            }
        }
        if least == before {
            break;
        }
    }
    (least, best)
}

fn permute(order: &mut Vec<usize>, from: usize, try_one: &mut dyn FnMut(&[usize])) {
    if from == order.len() {
        return try_one(order);
    }
    for i in from..order.len() {
        order.swap(from, i);
        permute(order, from + 1, try_one);
        order.swap(from, i);
    }
}

/// Cost of an order: elements that cross bodies, stops whose plates do not face each other, ground
/// at inner bodies or at the ceiling and, with the smallest weight, inversions of the file's
/// order.
fn cost(order: &[usize], connections: &[Connection], floor: Option<Side>) -> usize {
    let mut column = vec![0; order.len()];
    order.iter().enumerate().for_each(|(place, &body)| column[body] = place);
    let last = order.len() - 1;
    let of = |connection: &Connection| match &connection.ends {
        Ends::Two([Some(a), Some(b)]) => {
            let (a, b) = (column[*a], column[*b]);
            let faces = b < a || !matches!(connection.symbol, Symbol::Stop { .. });
            1000 * (a.abs_diff(b) - 1) + if faces { 0 } else { 300 }
        }
        Ends::Two(_) => match ground_side(connection) {
            Some((body, Side::Left)) if column[body] != 0 => 400,
            Some((body, Side::Right)) if column[body] != last => 400,
            Some((body, Side::Either)) if column[body] != 0 && column[body] != last => 400,
            Some((body, Side::Either)) if floor == Some(Side::Left) && column[body] != 0 => 200,
            Some((body, Side::Either)) if floor == Some(Side::Right) && column[body] != last => 200,
            _ => 0,
        },
        Ends::Many(bodies) => {
            let columns = bodies.iter().map(|&body| column[body]);
            500 * (columns.clone().max().unwrap_or(0) - columns.min().unwrap_or(0))
        }
    };
    let inversions: usize = order.windows(2).filter(|pair| pair[0] > pair[1]).count();
    connections.iter().map(of).sum::<usize>() + 10 * inversions
}
