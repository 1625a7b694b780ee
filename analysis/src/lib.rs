//! What the command line shows: studies of the steady states, their tables and their pictures.
//!
//! ```text
//! set (SI or groups, by name) → response, plane, compare (numbers) → figures (data of a picture) → draw → files
//! simulator → walk (smooth pieces) → maxima, variation → bifurcation, lyapunov, basin, isoperiodic → studies → report
//! ```
//!
//! Every study is a function from [`ParameterSet`] to plain data; printing and writing is the caller's.

pub mod attractor;
pub mod basin;
pub mod bifurcation;
mod error;
pub mod isoperiodic;
pub mod lyapunov;
pub mod maxima;
pub mod motion;
mod parameter_set;
pub mod parts;
pub mod plane;
pub mod response;
pub mod section;
mod smooth_pieces;
pub mod trajectories;
mod variation;

pub use error::{Error, Result};
pub use parameter_set::{Name, ParameterSet, find_field, find_group, number, short};
pub use vibro_impact::parameters::{GROUPS, Group, check_together};
