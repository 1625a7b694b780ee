//! Motions that determine the worst value of a design, as points of its band.

use crate::candidate::Candidate;
use vibro_studies::design_sweep::{SearchedRow, SweepRequest};

/// Largest number of points of one measure; more than a few peaks of a band are seldom equal.
const MOST: usize = 6;
/// Largest difference between the value of a followed motion and the worst value, as a fraction of
/// the worst: the motion may become the worst within a local search.
const NEAR: f64 = 0.3;

/// A motion whose measure is at least as large as at the adjacent points of the band.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPoint {
    /// Index of the measure.
    pub measure: usize,
    /// Values of the parameters of the band.
    pub place: Vec<f64>,
    /// Index of the start.
    pub start: usize,
    /// The interval of the band that contains the peak, from valley to valley: axis and ends.
    pub bracket: Option<(usize, f64, f64)>,
}

/// The nearest points below and above a peak beyond which the values rise again; the ends of the
/// line if they do not. The line is sorted by the parameter.
fn valleys(line: &[(f64, f64)], peak: f64) -> (f64, f64) {
    let at = line.partition_point(|own| own.0 < peak).min(line.len().saturating_sub(1));
    let rises = |pair: &&[(f64, f64)]| pair[0].1 < pair[1].1;
    let above = line[at..].windows(2).find(rises).map(|pair| pair[0].0);
    let falls = |pair: &&[(f64, f64)]| pair[0].1 > pair[1].1;
    let below = line[..=at].windows(2).rev().find(falls).map(|pair| pair[1].0);
    let end = |own: Option<&(f64, f64)>| own.map_or(peak, |own| own.0);
    (below.unwrap_or(end(line.first())), above.unwrap_or(end(line.last())))
}

/// The points with the largest values of a measure.
pub(crate) fn contact_points(
    sweep: &SweepRequest<Candidate>,
    found: &SearchedRow,
    measure: usize,
) -> Vec<ContactPoint> {
    let starts = sweep.starts.len().max(1);
    let value = |place: usize, start: usize| {
        found.motions.get(place * starts + start)?.0.numbers.get(measure).copied().flatten()
    };
    let axes: Vec<usize> =
        (0..sweep.over.len()).filter(|&k| sweep.between.contains(&sweep.over[k].name)).collect();
    let is_on_line = |a: &[f64], b: &[f64], axis: usize| (0..a.len()).all(|j| j == axis || a[j] == b[j]);
    // The adjacent points along an axis, below and above.
    let beside = |place: &[f64], axis: usize| {
        let others = || {
            let all = found.places.iter().enumerate();
            all.filter(move |(_, other)| is_on_line(place, other, axis) && other[axis] != place[axis])
        };
        let below = others().filter(|(_, other)| other[axis] < place[axis]);
        let above = others().filter(|(_, other)| other[axis] > place[axis]);
        [
            below.max_by(|a, b| a.1[axis].total_cmp(&b.1[axis])),
            above.min_by(|a, b| a.1[axis].total_cmp(&b.1[axis])),
        ]
    };
    let mut points: Vec<(f64, ContactPoint)> = Vec::new();
    for (index, place) in found.places.iter().enumerate() {
        for start in 0..starts {
            let Some(own) = value(index, start) else { continue };
            let is_peak = axes.iter().all(|&axis| {
                let mut others = beside(place, axis).into_iter().flatten();
                // The first of equal neighbours is the peak.
                others.all(|(other, _)| {
                    value(other, start).is_none_or(|beside| beside < own || beside == own && other > index)
                })
            });
            if is_peak {
                let bracket = axes.first().map(|&axis| {
                    let line = found.places.iter().enumerate();
                    let line = line.filter(|(_, other)| is_on_line(place, other, axis));
                    let mut line: Vec<(f64, f64)> =
                        line.filter_map(|(other, at)| Some((at[axis], value(other, start)?))).collect();
                    line.sort_by(|a, b| a.0.total_cmp(&b.0));
                    let (low, high) = valleys(&line, place[axis]);
                    (axis, low, high)
                });
                points.push((own, ContactPoint { measure, place: place.clone(), start, bracket }));
            }
        }
    }
    points.sort_by(|a, b| b.0.total_cmp(&a.0));
    let top = points.first().map_or(0.0, |own| own.0);
    points.retain(|own| own.0 >= top - NEAR * top.abs());
    points.truncate(MOST);
    points.into_iter().map(|(_, point)| point).collect()
}
