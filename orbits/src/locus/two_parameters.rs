//! What the follower of a curve in two parameters asks of the curve's equations.

use super::LocusEnd;
use crate::curve::Equations;
use crate::obstacle::Obstacle;
use nalgebra::DVector;

/// Equations of a curve in two parameters, the last two unknowns, each in its curve unit.
pub(crate) trait TwoParameters: Equations + Clone {
    /// Least and largest value of parameter 0 or 1, in its curve unit.
    fn range(&self, k: usize) -> (f64, f64);

    /// Whether a point is an orbit of the machine, except for a touch that defines the curve.
    ///
    /// # Errors
    /// An obstacle if the equations are not defined at `u`.
    fn is_orbit(&self, u: &DVector<f64>) -> Result<bool, Obstacle>;

    /// Adapts the condition's borders to a point of the curve.
    fn adapt(&mut self, u: &DVector<f64>);

    /// The end of the curve that a point lies beyond.
    fn passed(&self, u: &DVector<f64>) -> Option<LocusEnd>;

    /// The end near a point beyond which the curve cannot be followed.
    fn near_end(&self, u: &DVector<f64>) -> Option<LocusEnd>;

    /// Products of the left null vector of a fold with the columns of both parameters, as a
    /// continuous function along the curve; `None` on other curves.
    fn products(&self, _: &DVector<f64>) -> Option<[f64; 2]> {
        None
    }

    /// Functions of a point that are zero at special points of two conditions.
    fn tests_on_curve(&self, _: &DVector<f64>) -> Vec<(LocusEnd, f64)> {
        Vec::new()
    }

    /// Whether the curve ends at a special point of two conditions.
    fn ends_at(&self, mark: LocusEnd) -> bool {
        mark == LocusEnd::FoldPitchfork
    }
}
