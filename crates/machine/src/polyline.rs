//! The force of a spring with straight lines between points, as one line plus corners at which the
//! slope changes (docs/assembly-law.md (A15)).

use crate::description::ForcePoint;

/// Relative tolerance for equal slopes.
const EQUAL: f64 = 1e-12;

/// The first line of a spring's force, f = preload + stiffness e, and the corners at which the
/// other lines begin.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Polyline {
    pub stiffness: f64,
    pub preload: f64,
    /// For each corner: its e, and the increase of the slope.
    pub corners: Vec<(f64, f64)>,
}

/// The slope from a point to the next.
fn slope(pair: &[ForcePoint]) -> f64 {
    (pair[1].f - pair[0].f) / (pair[1].e - pair[0].e)
}

/// The slopes of the lines through points.
pub(crate) fn slopes(points: &[ForcePoint]) -> Vec<f64> {
    points.windows(2).map(slope).collect()
}

impl Polyline {
    /// The force through two or more points with increasing e. The end points are not corners.
    pub fn new(points: &[ForcePoint]) -> Self {
        let slopes = slopes(points);
        let corner = |(point, pair): (&ForcePoint, &[f64])| {
            let size = pair[0].abs() + pair[1].abs();
            let steeper = pair[1] - pair[0];
            (point.e, if steeper.abs() <= EQUAL * size { 0.0 } else { steeper })
        };
        let corners = points[1..].iter().zip(slopes.windows(2)).map(corner).collect();
        Self { stiffness: slopes[0], preload: points[0].f - slopes[0] * points[0].e, corners }
    }

    /// The derivative when the points move in the direction `by`.
    pub fn derivative(points: &[ForcePoint], by: &[ForcePoint]) -> Self {
        let slopes = slopes(points);
        let turned = |j: usize| {
            let (rise, run) = (by[j + 1].f - by[j].f, by[j + 1].e - by[j].e);
            (rise - slopes[j] * run) / (points[j + 1].e - points[j].e)
        };
        let turned: Vec<f64> = (0..slopes.len()).map(turned).collect();
        let corners = by[1..].iter().zip(turned.windows(2)).map(|(by, pair)| (by.e, pair[1] - pair[0]));
        let preload = by[0].f - turned[0] * points[0].e - slopes[0] * by[0].e;
        Self { stiffness: turned[0], preload, corners: corners.collect() }
    }

    /// Energy of the corners' forces at e = 0, ½ Δk max(0, e - e_c)² each, which the integral from
    /// e = 0 does not contain.
    pub fn energy_at_zero(&self) -> f64 {
        let of = |&(e, steeper): &(f64, f64)| 0.5 * steeper * (-e).max(0.0).powi(2);
        self.corners.iter().map(of).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [ForcePoint; 4] = [
        ForcePoint { e: -2.0, f: -3.0 },
        ForcePoint { e: -0.5, f: 1.0 },
        ForcePoint { e: 1.0, f: -1.0 },
        ForcePoint { e: 2.0, f: 4.0 },
    ];

    fn force(line: &Polyline, e: f64) -> f64 {
        let own = line.corners.iter().map(|&(at, steeper)| steeper * (e - at).max(0.0));
        line.preload + line.stiffness * e + own.sum::<f64>()
    }

    #[test]
    fn closed_form_a_line_and_corners_go_through_all_points() {
        let line = Polyline::new(&POINTS);
        assert_eq!(line.corners.len(), 2);
        for point in POINTS {
            assert!((force(&line, point.e) - point.f).abs() < 1e-14, "{point:?}");
        }
        assert!((force(&line, 3.0) - 9.0).abs() < 1e-14);
        let straight = [0.0, 0.1, 0.3].map(|e| ForcePoint { e, f: 7.0 * e });
        assert_eq!(Polyline::new(&straight).corners, [(0.1, 0.0)]);
    }

    #[test]
    fn second_method_the_derivative_is_that_of_differences() {
        for k in 0..8 {
            let mut by = [ForcePoint { e: 0.0, f: 0.0 }; 4];
            *(if k % 2 == 0 { &mut by[k / 2].e } else { &mut by[k / 2].f }) = 1.0;
            let along = Polyline::derivative(&POINTS, &by);
            let at = |step: f64| {
                let moved = std::array::from_fn::<_, 4, _>(|i| ForcePoint {
                    e: POINTS[i].e + step * by[i].e,
                    f: POINTS[i].f + step * by[i].f,
                });
                Polyline::new(&moved)
            };
            let (below, above) = (at(-1e-6), at(1e-6));
            let near = |a: f64, b: f64, x: f64| ((b - a) / 2e-6 - x).abs() < 1e-8;
            assert!(near(below.stiffness, above.stiffness, along.stiffness), "{k}");
            assert!(near(below.preload, above.preload, along.preload), "{k}");
            for (i, own) in along.corners.iter().enumerate() {
                assert!(near(below.corners[i].0, above.corners[i].0, own.0), "{k}");
                assert!(near(below.corners[i].1, above.corners[i].1, own.1), "{k}");
            }
        }
    }
}
