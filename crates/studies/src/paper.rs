//! Studies of the paper's machine alone: its parameters and groups by name, its motions side by side,
//! its closed forms and the verdicts that rest on its mirror symmetry.

pub mod attractor;
pub mod basin;
pub mod bifurcation;
mod free_limit;
mod free_motion;
pub mod isoperiodic;
pub(crate) mod largest_exponent;
pub mod lyapunov;
pub mod maxima;
pub mod measures;
pub mod motion;
pub(crate) mod parameter_set;
pub mod plane;
pub mod response;
mod settling;
mod smooth_pieces;
pub mod start;
pub mod statistics;
pub mod stroboscopic;
pub mod trajectories;
mod variation;
pub mod verdict;

pub use parameter_set::{
    Name, ParameterSet, Quantity, Unit, find_field, find_group, number, numbers, physical_parameters,
    quantity_in, short, significant, typed_unit,
};
pub use vibro_impact::parameters::{GROUPS, Group, check_together};
