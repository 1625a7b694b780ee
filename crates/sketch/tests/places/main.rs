//! Places of the things in a sketch.

mod marks;
mod overlaps;
mod random;
mod stops;
mod upright;
