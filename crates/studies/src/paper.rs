//! Studies of the paper's machine alone: its parameters and groups by name, its motions side by
//! side, its closed forms and the verdicts that rest on its mirror symmetry.
//!
//! | module | what it computes | what its tests hold it against |
//! |---|---|---|
//! | [`ParameterSet`] | physical parameters and dimensionless groups by name, kept in step | conversion there and back |
//! | [`stroboscopic`] | states at whole drive periods in units of L and L ω10 | – |
//! | [`motion`] | a motion as samples cut at impacts, its amplitudes and maxima | amplitudes of the exact orbit |
//! | `smooth_pieces` | the smooth pieces of a motion with the events that end them | through `measures` and `lyapunov` |
//! | [`maxima`] | local maxima of X2, from the flow | amplitude of the exact orbit; interpolated samples; closed forms of a free block and of one mode |
//! | `variation` | transition matrices of variations, jumps at impacts | through `lyapunov` |
//! | `largest_exponent` | the largest exponent of many motions, from their events | the seven exponents; multipliers of the exact orbit |
//! | `settling` | when a motion has settled on a period | made-up sequences; planes and basins without it |
//! | [`lyapunov`] | the seven Lyapunov exponents | a linear system; multipliers of the exact orbit; divergence and determinants |
//! | [`attractor`] | period, impacts, symmetry and class of a settled motion | constructed sequences; the stable exact orbit; the limit without impacts |
//! | [`verdict`] | the class of a motion, which is followed until it is decided | motions with known ends; chaos from many starts |
//! | [`statistics`] | means of motion without a period, and whether two such motions are one attractor | closed forms; chaos from many starts, mirror images |
//! | [`trajectories`] | many independent motions side by side: transient, maxima, attractors | the same motions one by one; statistics in chaos |
//! | [`bifurcation`] | maxima, classes and exponents over one parameter, both directions | exact orbit and its limits of stability (tests of `vibro`) |
//! | [`basin`] | attractors over two initial values | single simulations (tests of `vibro`) |
//! | [`isoperiodic`] | simulated motion over two parameters, beside the exact orbit | single simulations, the plane of the exact orbit (tests of `vibro`) |
//! | [`measures`] | amplitudes, mean squares, impacts, powers, class of a settled motion | the exact orbit; dense samples; the balance of powers |
//! | [`plane`] | existence and stability of the two-impact motion over two parameters | single solutions (tests of `vibro`) |
//! | [`response`](mod@response) | steady states along one parameter | located limits of stability (tests of `vibro`) |
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
