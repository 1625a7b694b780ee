//! Sizes of texts, and the margin.

/// Font size of the names of bodies.
pub(crate) const BODY_FONT: f64 = 46.0;
/// Font size of elements' names.
pub(crate) const FONT: f64 = 40.0;
/// Font size of lever arms.
pub(crate) const ARM_FONT: f64 = 34.0;
/// Height of an element's name above its symbol.
pub(crate) const NAME: f64 = 52.0;
/// Margin around the picture.
pub(crate) const MARGIN: f64 = 40.0;
