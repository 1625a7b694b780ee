//! Periodic orbits with any impact word, stable or not, followed along a parameter with their bifurcations
//! (docs/theory.md, section 13).
//!
//! For given impact phases the motion is linear, so that an orbit of n impacts has n unknowns, whatever it does in between.

mod cycle;
mod flights;
mod obstacle;
mod orbit;
mod system;
mod word;

#[cfg(test)]
mod tests;

pub use orbit::Orbit;
pub use system::{ConstantLoads, System};
pub use word::OrbitWord;
