//! Dashpots and sliders in series with springs.

/// A dashpot or slider in series with a spring. Both meet at an inner displacement x, in the unit
/// of e. The spring's force is stiffness · (e - x); the other element determines how x moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series {
    /// The dashpot or slider.
    pub law: SeriesLaw,
    /// x at time 0, m or rad; 0 in a machine that starts at rest.
    pub slider: f64,
}

/// The law of a dashpot or slider in series with a spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SeriesLaw {
    /// A dashpot (Maxwell's element): damping · x' = stiffness · (e - x).
    Dashpot {
        /// Damping, N s/m or N m s/rad; positive.
        damping: f64,
    },
    /// A slider (Jenkins element, elastic-perfectly-plastic): x is constant while |force| < `slip`
    /// and otherwise follows e, so that |force| does not exceed `slip`.
    Slider {
        /// Slip force, N or N m; positive.
        slip: f64,
    },
}
