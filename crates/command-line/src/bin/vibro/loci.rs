//! `vibro locus` with any machine: from special points of tables to curves.

use crate::orbits_arguments::Loci;
use crate::progress::Progress;
use crate::ranges::in_option;
use rayon::prelude::*;
use vibro::special_points::PointOfTable;
use vibro::studies::LocusCurve;
use vibro::{Error, Result};
use vibro_orbits::LocusPoint;

/// A machine's curves over two parameters.
pub trait Curves: Sync {
    /// A row of a table of special points.
    type Point: PointOfTable + Sync;
    /// The special point on its branch.
    type Start: Send + Sync;
    /// The special point as tables and pictures state it.
    type Shown: Send;

    /// The special point of a row, on its branch.
    fn start(&self, point: &Self::Point) -> Result<Self::Start>;

    /// Whether two rows are the same special point.
    fn is_same(&self, one: &Self::Start, other: &Self::Start) -> bool;

    /// The curve of a special point.
    fn follow(&self, point: &Self::Point, start: &Self::Start) -> Result<(Self::Shown, Vec<LocusPoint>)>;
}

/// The chosen special points, each with a description of its file and row. `number` reads a value
/// of the parameter.
pub fn chosen<P: PointOfTable>(
    a: &Loci,
    along: &str,
    number: &dyn Fn(&str) -> Result<f64>,
) -> Result<Vec<(String, P)>> {
    let mut points: Vec<(String, P)> = Vec::new();
    for selection in &a.from {
        let chosen = selection.points(along, number).map_err(in_option("--from"))?;
        let is_own = |p: &P| a.label.as_ref().is_none_or(|label| label == p.label().name());
        let told = |p: P| (format!("{}:{}", selection.path.display(), p.row()), p);
        points.extend(chosen.into_iter().filter(is_own).map(told));
    }
    if points.is_empty() {
        let what = format!("--label {}", a.label.as_deref().unwrap_or_default());
        return Err(Error::Refused { what, problem: "none of the points has this label".into() });
    }
    Ok(points)
}

/// Curves, and reasons for points without one.
pub type Followed<S> = (Vec<LocusCurve<S>>, Vec<String>);

/// The curves of special points, and a reason for each point without a curve. Rows of the same
/// special point have one curve; it starts at the first possible row.
pub fn followed<C: Curves>(curves: &C, points: &[(String, C::Point)]) -> Result<Followed<C::Shown>> {
    let told = |k: usize, error: Error| {
        let (from, point) = &points[k];
        format!("{from} ({} at {}): {error}", point.told(), point.value())
    };
    let starts: Vec<_> = points.par_iter().map(|(_, point)| curves.start(point)).collect();
    let (mut groups, mut problems) = (Vec::<Vec<(usize, C::Start)>>::new(), Vec::new());
    for (k, start) in starts.into_iter().enumerate() {
        match start {
            Err(error) => problems.push(told(k, error)),
            Ok(start) => match groups.iter_mut().find(|group| curves.is_same(&group[0].1, &start)) {
                Some(group) => group.push((k, start)),
                None => groups.push(vec![(k, start)]),
            },
        }
    }
    let progress = Progress::new(groups.len(), "curves");
    let of = |group: &Vec<(usize, C::Start)>| {
        let mut failures = Vec::new();
        let found = group.iter().enumerate().find_map(|(i, (k, start))| {
            let (from, point) = &points[*k];
            let found = curves.follow(point, start).map_err(|error| failures.push(told(*k, error)));
            let (start, along) = found.ok()?;
            let also = group[i + 1..].iter().map(|(k, _)| points[*k].1.row()).collect();
            Some(LocusCurve { from: from.clone(), row: point.row(), start, points: along, also })
        });
        progress.step();
        (found, failures)
    };
    let found: Vec<_> = groups.par_iter().map(of).collect();
    let (found, failures): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    problems.extend(failures.into_iter().flatten());
    let found: Vec<_> = found.into_iter().flatten().collect();
    if found.is_empty() {
        return Err(Error::Refused { what: "--from".into(), problem: problems.join("; ") });
    }
    Ok((found, problems))
}
