//! What a spring may be in series with.

/// A spring's partner in series. Spring and partner meet at an inner place x, in the unit of e, so
/// that the spring's force is stiffness · (e - x); the partner decides how x moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series {
    /// The partner.
    pub law: SeriesLaw,
    /// x at time 0, m or rad; 0 in a machine that starts at rest.
    pub slider: f64,
}

/// The law of a spring's partner in series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SeriesLaw {
    /// A dashpot (Maxwell's element): damping · x' = stiffness · (e - x).
    Dashpot {
        /// N s/m or N m s/rad, positive.
        damping: f64,
    },
    /// A slider (Jenkins' element, elastic-perfectly-plastic): x stands while the force is under
    /// `slip` in size, and follows e so that it is no more.
    Slider {
        /// N or N m, positive.
        slip: f64,
    },
}
