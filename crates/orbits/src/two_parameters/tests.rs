//! Curves over two parameters of normal forms with known special points.

use super::LocusEnd;
use super::TwoParameters;
use super::following::{Located, both_ways};
use crate::curve::{Equations, Linearization};
use crate::obstacle::Obstacle;
use nalgebra::{DMatrix, DVector};

/// Tolerance for Newton's method at a regular point. `LOCATED`, for singular points, is the
/// tolerance for a fourth-order extrapolation from a twentieth of the unknowns' unit.
const ROUNDING: f64 = 1e-12;
const LOCATED: f64 = 1e-9;

/// Equations of a fold curve over p and q, preceded by the unknown x.
#[derive(Clone, Copy)]
enum Normal {
    /// The parabola q = p², without x, up to a bound of q.
    Parabola(f64),
    /// p + q x - x³ = 0 and its derivative with respect to x: a cusp at p = q = 0.
    Cusp,
    /// x (p + q x² + x⁴) = 0 and its x derivative: mirror images meet at p = q = 0.
    Mirrored,
}

impl Equations for Normal {
    fn linearize(&self, u: &DVector<f64>, _: Option<&DMatrix<f64>>) -> Result<Linearization, Obstacle> {
        let n = u.len();
        let (x, p, q) = (u[0], u[n - 2], u[n - 1]);
        let (value, matrix) = match self {
            Self::Parabola(_) => (vec![q - p * p], vec![-2.0 * p, 1.0]),
            Self::Cusp => (
                vec![p + q * x - x.powi(3), q - 3.0 * x * x],
                vec![q - 3.0 * x * x, 1.0, x, -6.0 * x, 0.0, 1.0],
            ),
            Self::Mirrored => {
                let slope = p + 3.0 * q * x * x + 5.0 * x.powi(4);
                let bend = 6.0 * q * x + 20.0 * x.powi(3);
                let value = vec![p * x + q * x.powi(3) + x.powi(5), slope];
                (value, vec![slope, x, x.powi(3), bend, 1.0, 3.0 * x * x])
            }
        };
        let matrix = DMatrix::from_row_slice(value.len(), n, &matrix);
        Ok(Linearization { value: DVector::from_vec(value), matrix })
    }
}

impl TwoParameters for Normal {
    fn range(&self, k: usize) -> (f64, f64) {
        match self {
            Self::Parabola(highest) if k == 1 => (-0.8, *highest),
            _ => (-0.8, 0.8),
        }
    }

    fn is_orbit(&self, _: &DVector<f64>) -> Result<bool, Obstacle> {
        Ok(true)
    }

    fn adapt(&mut self, _: &DVector<f64>) {}

    fn passed(&self, _: &DVector<f64>) -> Option<LocusEnd> {
        None
    }

    fn near_end(&self, _: &DVector<f64>) -> Option<LocusEnd> {
        None
    }

    fn products(&self, u: &DVector<f64>) -> Option<[f64; 2]> {
        match self {
            Self::Parabola(_) => None,
            Self::Cusp => Some([1.0, u[0]]),
            Self::Mirrored => Some([u[0], u[0].powi(3)]),
        }
    }
}

fn followed(normal: Normal, start: &[f64]) -> Vec<Located> {
    both_ways(&normal, &DVector::from_column_slice(start)).unwrap()
}

/// The points of a curve with a mark, each with both parameters.
fn marked(points: &[Located], mark: LocusEnd) -> Vec<[f64; 2]> {
    let own = points.iter().filter(|(_, own)| *own == Some(mark));
    own.map(|(u, _)| [u[u.len() - 2], u[u.len() - 1]]).collect()
}

#[test]
fn closed_form_no_point_of_a_parabola_is_outside_the_ranges() {
    // The tangent lies under the parabola: a step along it ends inside the range, but the point of
    // the parabola next to it may be outside.
    for k in 0..100 {
        let highest = 0.25 + 1e-3 * f64::from(k);
        let points = followed(Normal::Parabola(highest), &[0.2, 0.04]);
        assert!(points.iter().all(|(u, _)| u[1] <= highest), "{highest}: {points:?}");
        let ends = marked(&points, LocusEnd::Range);
        assert_eq!(ends.len(), 2);
        for [p, q] in ends {
            assert!(q == highest && (p * p - q).abs() < ROUNDING, "{p} {q}");
        }
    }
}

#[test]
fn closed_form_a_cusp_is_named_once_where_it_is() {
    let x: f64 = 0.3;
    let points = followed(Normal::Cusp, &[x, -2.0 * x.powi(3), 3.0 * x * x]);
    let [[p, q]] = marked(&points, LocusEnd::Cusp)[..] else { panic!("{points:?}") };
    assert!(p.abs() < LOCATED && q.abs() < LOCATED, "{p} {q}");
    assert_eq!(marked(&points, LocusEnd::Range).len(), 2);
}

#[test]
fn closed_form_a_fold_curve_ends_where_its_orbits_are_symmetric() {
    let x: f64 = 0.4;
    let points = followed(Normal::Mirrored, &[x, x.powi(4), -2.0 * x * x]);
    let [[p, q]] = marked(&points, LocusEnd::FoldPitchfork)[..] else { panic!("{points:?}") };
    assert!(p.abs() < LOCATED && q.abs() < LOCATED, "{p} {q}");
    assert!(marked(&points, LocusEnd::Cusp).is_empty());
    assert_eq!(marked(&points, LocusEnd::Range).len(), 1);
}
