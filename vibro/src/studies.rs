//! The studies of the command line: each makes tables and figures from [`ParameterSet`](super::ParameterSet).

mod basin;
mod compare;
mod isoperiodic;
mod manifold;
mod motions;
mod plane;
mod response;
mod stability;
mod steady;
mod steady_motion;
mod strong;
mod sweep;

pub use basin::basins;
pub use compare::{accuracy, force_overlay, histories};
pub use isoperiodic::isoperiodic;
pub use manifold::{branches, families, shapes};
pub use motions::{Modulation, histories_of, portraits, running};
pub use plane::planes;
pub use response::{force, frequency};
pub use stability::{masri, regions};
pub use steady::steady;
pub use strong::strong_case;
pub use sweep::{overlay, periodic_ranges, spectra, sweep};

use super::figures::chart::Figure;
use super::table::Table;

/// The outcome of a study.
#[derive(Clone, Debug)]
pub struct Study {
    /// Stem of the files.
    pub name: String,
    /// What the picture shows, in a phrase.
    pub what: String,
    /// The numbers: stems of files and their CSV text.
    pub tables: Vec<(String, Vec<u8>)>,
    /// The table that is worth reading on a screen.
    pub shown: Option<Table>,
    /// The picture; `None` where there is nothing to draw, which `what` explains.
    pub figure: Option<Figure>,
    /// What to say about it, line by line.
    pub remarks: Vec<String>,
}

/// Size of a panel in units of the drawing, unless a figure needs another.
const PANEL: (u32, u32) = (1700, 1150);
