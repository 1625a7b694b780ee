//! Reduction of a long record to what a panel can show: envelopes, thinned curves, constant
//! quantities.

use vibro_figures::chart::Path;

/// Largest number of windows of an envelope; a panel has about as many pixels.
const WINDOWS: f64 = 400.0;
/// Cap on the columns of a thinned curve; a panel has fewer pixels.
pub(super) const COLUMNS: usize = 1500;
/// Relative tolerance of a constant quantity: a panel has fewer pixels.
const CHANGE: f64 = 1e-3;

/// A point of an envelope: time, and the smallest and largest value of its window.
pub(super) type Extremes = (f64, f64, f64);

/// Whole drive periods in a window of a run that ends at `end`.
fn periods_of_a_window(period: f64, end: f64) -> f64 {
    (end / period / WINDOWS - 1e-9).ceil().max(1.0)
}

/// The length of a window, in words.
pub(super) fn in_words(period: f64, end: f64) -> String {
    match periods_of_a_window(period, end) {
        1.0 => "in each drive period".into(),
        many => format!("in every {many} drive periods"),
    }
}

/// The smallest and largest value in each window of whole drive periods, as steps: each window has
/// a point at its beginning and one at its end. A window without a value ends a piece. The points
/// are in order of time, and the first window begins at 0.
pub(super) fn envelope(
    points: impl Iterator<Item = (f64, f64)>,
    period: f64,
    end: f64,
) -> Vec<Vec<Extremes>> {
    let width = period * periods_of_a_window(period, end);
    let mut windows: Vec<Option<(f64, f64)>> = vec![None; (end / width - 1e-9).ceil().max(1.0) as usize];
    let last = windows.len() - 1;
    for (time, value) in points {
        // An instant that equals a window's beginning apart from rounding belongs to that window.
        let window = &mut windows[((time / width + 1e-9) as usize).min(last)];
        let (low, high) = window.unwrap_or((value, value));
        *window = Some((low.min(value), high.max(value)));
    }
    let at = |i: usize| (i as f64 * width).min(end);
    let indices: Vec<usize> = (0..windows.len()).collect();
    let runs = indices.chunk_by(|a, b| windows[*a].is_some() == windows[*b].is_some());
    let steps = |i: &usize| {
        let found = windows[*i].map(|(low, high)| [(at(*i), low, high), (at(i + 1), low, high)]);
        found.into_iter().flatten()
    };
    runs.map(|run| run.iter().flat_map(steps).collect::<Vec<_>>()).filter(|p| !p.is_empty()).collect()
}

/// A curve reduced to its first, lowest, highest and last point in each of [`COLUMNS`] columns: no
/// pixel changes.
pub(super) fn thinned(path: Path) -> Path {
    let (Some(first), Some(last)) = (path.first(), path.last()) else { return path };
    if path.len() <= 4 * COLUMNS {
        return path;
    }
    let (from, width) = (first.0, (last.0 - first.0) / COLUMNS as f64);
    let column = |p: &(f64, f64)| ((p.0 - from) / width) as usize;
    let mut found = Path::new();
    for points in path.chunk_by(|a, b| column(a) == column(b)) {
        let by = |extreme: fn(f64, f64) -> bool| {
            (1..points.len()).fold(0, |best, i| if extreme(points[i].1, points[best].1) { i } else { best })
        };
        let mut kept = [0, by(|a, b| a < b), by(|a, b| a > b), points.len() - 1];
        kept.sort_unstable();
        found.extend(kept.map(|i| points[i]));
    }
    found.dedup();
    found
}

/// The value of a quantity whose change is too small for a picture of that scale. `None` if it
/// changes more or has no value.
pub(super) fn constant(values: impl Iterator<Item = f64>, scale: f64) -> Option<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    (low <= high && high - low <= CHANGE * scale.abs()).then_some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_a_thinned_curve_keeps_its_ends_and_extremes() {
        let path: Path = (0..100_000).map(|i| (f64::from(i), (f64::from(i) * 0.37).sin())).collect();
        let thin = thinned(path.clone());
        assert!(thin.len() <= 4 * COLUMNS + 4 && thin.is_sorted_by(|a, b| a.0 < b.0));
        let extremes = |p: &Path| p.iter().fold((1.0f64, -1.0f64), |(a, b), x| (a.min(x.1), b.max(x.1)));
        assert_eq!((extremes(&thin), thin[0]), (extremes(&path), path[0]));
        assert_eq!(thin.last(), path.last());
        assert_eq!(thinned(path[..50].to_vec()), path[..50]);
    }

    #[test]
    fn closed_form_an_envelope_has_the_extremes_of_each_period() {
        // Two values per period of 0.5: k and -k in period k, and none in the periods 3 and 4.
        let times = (0..8).filter(|k| ![3, 4].contains(k)).flat_map(|k| {
            let (at, k) = (0.5 * f64::from(k), f64::from(k));
            [(at, k), (at + 0.2, -k)]
        });
        let found = envelope(times, 0.5, 4.0);
        assert_eq!(found.len(), 2);
        assert_eq!(
            found[0],
            [
                (0.0, 0.0, 0.0),
                (0.5, 0.0, 0.0),
                (0.5, -1.0, 1.0),
                (1.0, -1.0, 1.0),
                (1.0, -2.0, 2.0),
                (1.5, -2.0, 2.0)
            ]
        );
        assert_eq!((found[1][0], found[1][5]), ((2.5, -5.0, 5.0), (4.0, -7.0, 7.0)));
    }

    #[test]
    fn invariant_an_envelope_of_any_length_has_a_bounded_number_of_points() {
        for periods in [41.0, 400.0, 401.5, 1e5] {
            let points = (0..400_000).map(|i| (periods * f64::from(i) / 4e5, f64::from(i % 7)));
            let found = envelope(points, 1.0, periods);
            assert_eq!(found.len(), 1);
            assert!(found[0].len() as f64 <= 2.0 * WINDOWS && found[0].last() == Some(&(periods, 0.0, 6.0)));
        }
    }

    #[test]
    fn closed_form_of_constants() {
        assert_eq!(constant([2.0, 2.0].into_iter(), 1.0), Some(2.0));
        assert_eq!(constant([2.0, 2.01].into_iter(), 1.0), None);
        assert_eq!(constant([].into_iter(), 1.0), None);
        assert_eq!(constant([0.0].into_iter(), 0.0), Some(0.0));
    }
}
