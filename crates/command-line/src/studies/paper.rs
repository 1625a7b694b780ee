//! The studies of the paper's machine alone.

mod basin;
mod compare;
mod diagram_orbits;
mod isoperiodic;
mod labels;
pub(super) mod lengths;
mod locus;
mod manifold;
mod maxima_panel;
mod motions;
mod orbit;
mod orbits;
mod plane;
mod response;
mod run;
mod stability;
mod steady;
mod steady_motion;
mod strong;
mod sweep;

pub use compare::{accuracy, force_overlay, histories};
pub use diagram_orbits::{CoveredRow, Covering, DiagramOrbits, sweep_family};
pub(crate) use diagram_orbits::{doublings_in_words, end_in_words};
pub use locus::loci;
pub use manifold::{branches, families, shapes};
pub use motions::{Modulation, histories_of, portraits, running};
pub use orbit::orbit;
pub use orbits::orbits;
pub use plane::planes;
pub use response::{along, force, frequency};
pub use run::{RunLength, RunRequest, run};
pub use stability::{masri, regions};
pub use steady::steady;
pub use strong::strong_case;
pub use sweep::{overlay, periodic_ranges, spectra};
