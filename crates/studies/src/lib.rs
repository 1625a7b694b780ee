//! Studies of motions of vibro-impact machines: settled motions and their classes, Lyapunov
//! exponents, sweeps, basins, planes, and steady states along a parameter.
//!
//! A study is a function from a machine and a request to plain data. Nothing is printed or written
//! here. The result depends neither on the number of threads nor on how a study is divided into
//! parts: whoever changes a study keeps that, and shows it by a test that compares divided with
//! whole work.
//!
//! A new study has a request that serde can write, a function that takes it with a
//! [`parts::Task`], and a number of parts that depends on the request alone; the command line keeps
//! it as a kind of its long studies. A new measure is a variant of [`measures::Measure`] with name,
//! unit and description, and its value over a window; that of a described machine likewise in
//! [`assembly::Measure`]. Limits and thresholds by which a verdict is decided are those of
//! docs/studies.md: they change together with their reasons there.
//!
//! | module | what it computes | what its tests hold it against |
//! |---|---|---|
//! | [`assembly`] | these studies of described machines | the 3-DOF core on the paper's machine; closed forms |
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
//! | [`parts`] | long studies in parts, shared and continued | interrupted and divided work against whole work |
//! | [`bifurcation`] | maxima, classes and exponents over one parameter, both directions | exact orbit and its limits of stability (tests of `vibro`) |
//! | [`basin`] | attractors over two initial values | single simulations (tests of `vibro`) |
//! | [`isoperiodic`] | simulated motion over two parameters, beside the exact orbit | single simulations, the plane of the exact orbit (tests of `vibro`) |
//! | [`measures`] | amplitudes, mean squares, impacts, powers, class of a settled motion | the exact orbit; dense samples; the balance of powers |
//! | [`design_sweep`] | measures over any number of parameters: grids, listed designs, Sobol sequences | single motions; closed forms |
//! | [`sobol`] | the Sobol sequence | SciPy's |
//! | [`plane`] | existence and stability of the two-impact motion over two parameters | single solutions (tests of `vibro`) |
//! | [`response`](mod@response) | steady states along one parameter | located limits of stability (tests of `vibro`) |
//!
//! # Example
//!
//! ```
//! use vibro_studies::paper::attractor::{MotionClass, observe};
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

pub mod basin;
mod columns;
mod contacts;
pub mod design_sweep;
mod designs;
pub mod diagram;
mod eigenvalues;
mod error;
mod extremes;
pub mod fit;
pub mod flight;
mod followed;
mod growth;
mod machine;
mod measures;
mod monodromy;
pub mod natural;
mod oscillations;
pub mod paper;
pub mod parts;
mod plane;
mod poincare;
mod quantity;
mod returns;
mod rows;
mod section;
mod settled;
pub mod sobol;
mod spectrum;
mod text;
mod timescales;
mod variation;
mod watch;
mod written;

pub use columns::{NamedEvent, columns, named, values};
pub use contacts::{ContactRecorder, StopContact};
pub use eigenvalues::eigenvalues;
pub use error::{Error, Result};
pub use extremes::{Extreme, Extremes};
pub use followed::Followed;
pub use machine::{Machine, now};
pub use measures::{Measure, measure};
pub use monodromy::carried;
pub use plane::PlanePoint;
pub use poincare::{PoincareRequest, SectionPoint, poincare, section_of};
pub use quantity::{QuantityName, unknown};
pub use section::{Section, SectionRule, common_period, is_steady};
pub use settled::{Settled, discard, require_free, settled};
pub use spectrum::{Spectrum, spectrum};
pub use timescales::{runs_on, settle};
pub use vibro_machine::Start;
pub use watch::{Extent, Maxima, Watcher};
pub use written::places;

pub use paper::significant;

#[cfg(test)]
mod tests;
