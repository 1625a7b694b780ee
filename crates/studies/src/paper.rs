//! Studies of the paper's machine alone: its parameters and groups by name, its motions side by
//! side, its closed forms, and the verdicts that use its mirror symmetry.
//!
//! | module | content | tested against |
//! |---|---|---|
//! | [`ParameterSet`] | parameters and dimensionless groups by name | conversion there and back |
//! | [`stroboscopic`] | states at whole drive periods in units of L and L ω10 | – |
//! | [`motion`] | a motion as samples cut at impacts | amplitudes of the exact orbit |
//! | `smooth_pieces` | smooth pieces of a motion and their ends | `measures` and `lyapunov` |
//! | [`maxima`] | local maxima of X2, from the flow | exact orbit; samples; closed forms |
//! | `variation` | transition matrices of variations, jumps at impacts | `lyapunov` |
//! | `largest_exponent` | the largest exponent of many motions | the spectrum; exact orbit |
//! | `settling` | when a motion has settled on a period | made-up sequences; planes and basins |
//! | [`lyapunov`] | the seven Lyapunov exponents | linear system; exact orbit; divergence |
//! | [`attractor`] | period, impacts, symmetry and class | made-up sequences; exact orbit |
//! | [`verdict`] | the class of a motion, followed until decided | known motions; chaos |
//! | [`statistics`] | means and likeness of motions without a period | closed forms; chaos |
//! | [`trajectories`] | many independent motions side by side | the same motions one by one |
//! | [`bifurcation`] | diagrams over one parameter | exact orbit and its stability (`vibro`) |
//! | [`basin`] | attractors over two initial values | single simulations (`vibro`) |
//! | [`isoperiodic`] | simulated motion over two parameters | single simulations (`vibro`) |
//! | [`measures`] | measures of a settled motion | exact orbit; dense samples; balance of powers |
//! | [`plane`] | two-impact motion over two parameters | single solutions (`vibro`) |
//! | [`response`](mod@response) | steady states along one parameter | stability limits (`vibro`) |
//!
//! # Example
//!
//! ```
//! use vibro_studies::MotionClass;
//! use vibro_studies::paper::attractor::observe;
//! use vibro_studies::paper::motion::settled_simulator;
//! use vibro_studies::paper::stroboscopic::moving_block;
//! use vibro_studies::paper::trajectories::Start;
//! use vibro_studies::paper::verdict::verdict;
//! use vibro_studies::paper::{ParameterSet, find_group};
//!
//! // The default set settles on a motion with the drive's period and one impact at each stop; a
//! // stronger drive makes chaos.
//! let p = *ParameterSet::basic().parameters();
//! let attractor = observe(&mut settled_simulator(&p, &moving_block(&p), 400.0)?)?;
//! assert_eq!((attractor.period, attractor.impacts), (Some(1), [1.0, 1.0]));
//!
//! let p = *ParameterSet::basic().with(find_group("f10")?, 3.6)?.parameters();
//! let start = Start { parameters: p, state: moving_block(&p) };
//! assert_eq!(verdict(&start, 400)?.class, MotionClass::Chaotic);
//! # Ok::<(), vibro_studies::Error>(())
//! ```

pub mod attractor;
pub mod basin;
pub mod bifurcation;
pub mod design_sweep;
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
    quantity_in, short, typed_unit,
};
pub use vibro_impact::parameters::{GROUPS, Group, check_together};
