//! The points of a branch from the paths in both directions from its start.

use super::branch::OrbitPoint;
use super::path::{Departure, Path, PathEnd};
use crate::obstacle::Obstacle;
use serde::{Deserialize, Serialize};

/// The points of a branch, and its ends.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Traced<E> {
    pub points: Vec<OrbitPoint>,
    /// Whether the branch ends where it begins.
    pub closed: bool,
    /// Index of the starting point of both directions.
    pub began_at: usize,
    /// The ends at the first and at the last point.
    pub ends: [PathEnd<E>; 2],
}

/// Traversal of the branches of a machine from two departures, and the points that take the
/// stability of a piece.
pub(super) struct Order {
    /// Whether the reversed path of the first departure comes first, instead of the second's.
    pub is_back_first: bool,
    /// Whether all points, instead of only special points, take the stability of the piece after
    /// them.
    pub are_pieces: bool,
}

/// Follows the one or two departures of a start.
pub(super) fn trace<O, E>(
    departures: &[Departure<O>],
    order: &Order,
    follow: impl Fn(&Departure<O>) -> Result<Path<E>, Obstacle>,
) -> Result<Traced<E>, Obstacle> {
    let mut departures = departures.iter();
    let first = follow(departures.next().ok_or(Obstacle::NoConvergence)?)?;
    let closed = matches!(first.end, PathEnd::Closed);
    let second = departures.next().filter(|_| !closed).map(follow).transpose()?;
    let (back, on) = match second {
        Some(second) if order.is_back_first => (Some(first), second),
        second => (second, first),
    };
    let (mut points, begin) = back.map_or((Vec::new(), PathEnd::Plain), |path| (path.points, path.end));
    // Each point takes the stability of the next piece, the previous one before reversal.
    for k in (1..points.len()).rev() {
        if order.are_pieces || points[k].special.is_some() {
            points[k].stability = points[k - 1].stability;
        }
    }
    points.reverse();
    points.pop();
    let began_at = points.len();
    points.extend(on.points);
    Ok(Traced { points, closed, began_at, ends: [begin, on.end] })
}
