//! Sizes of texts, and distances.

/// Font size of the names of bodies.
pub(crate) const BODY_FONT: f64 = 46.0;
/// Font size of elements' names.
pub(crate) const FONT: f64 = 40.0;
/// Font size of lever arms.
pub(crate) const ARM_FONT: f64 = 34.0;
/// Height of an element's name above its symbol.
pub(crate) const NAME: f64 = 52.0;
/// Distance between a symbol and the text next to it.
pub(crate) const BESIDE: f64 = 14.0;
/// Space between a text and its neighbour.
pub(crate) const ROOM: f64 = 24.0;
/// Margin around the picture.
pub(crate) const MARGIN: f64 = 40.0;
/// Largest displacement of a body in a sketch in motion.
pub(crate) const REACH: f64 = 85.0;
