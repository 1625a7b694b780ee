//! Studies of described machines, which a file or a program composes of bodies and elements
//! (`vibro-machine`): settled motions and their classes, Lyapunov exponents, diagrams, sweeps,
//! basins, planes and fits. The studies of the paper's machine are in [`paper`].
//!
//! A motion is looked at where it returns to a [section](SectionRule): after each common period of
//! what drives the machine, or at each event of an element.
//!
//! A study is a function from a machine and a request to plain data. Nothing is printed or written
//! here. The result depends neither on the number of threads nor on how a study is divided into
//! parts: whoever changes a study keeps that, and shows it by a test that compares divided with
//! whole work.
//!
//! A new study has a request that serde can write, a function that takes it with a
//! [`parts::Task`], and a number of parts that depends on the request alone; the command line keeps
//! it as a kind of its long studies. A new measure is a variant of [`Measure`] with name, unit and
//! description, and its value over a window. Limits and thresholds by which a verdict is decided
//! are those of docs/theory.md, section 17: they change together with their reasons there.
//!
//! | module | what it computes | what its tests hold it against |
//! |---|---|---|
//! | [`parts`] | long studies in parts, shared and continued | interrupted and divided work against whole work |
//! | [`settled()`] | what a motion settles on, its class and largest exponents | motions with known ends; the paper's machine |
//! | [`spectrum()`] | all Lyapunov exponents | multipliers; divergence |
//! | [`diagram`] | maxima, classes and exponents over one parameter, both directions | closed forms; the paper's machine |
//! | [`basin`] | attractors over two initial values | single simulations |
//! | [`design_sweep`] | measures over any number of parameters: grids, listed designs, Sobol sequences | single motions; closed forms |
//! | [`fit`] | numbers of a machine from a record | records of known machines |
//! | [`flight`] | a motion's flights between events as series | dense samples |
//! | [`natural`] | natural frequencies | closed forms |
//! | [`sobol`] | the Sobol sequence | SciPy's |

mod axis;
pub mod basin;
mod class;
mod columns;
mod contacts;
pub mod design_sweep;
mod designs;
pub mod diagram;
mod eigenvalues;
mod error;
mod exponent;
mod extremes;
pub mod fit;
pub mod flight;
mod followed;
mod growth;
pub mod isoperiodic;
mod machine;
mod measured;
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
mod windows;
mod written;

pub use axis::{AxisName, ParameterAxis, check_cells, check_count};
pub use class::{LONGEST, MotionClass, OBSERVED, Relation};
pub use columns::{NamedEvent, columns, named, values};
pub use contacts::{ContactRecorder, StopContact};
pub use diagram::{Diagram, DiagramPoint};
pub use eigenvalues::eigenvalues;
pub use error::{Error, Result};
pub use exponent::{ExponentSign, LargestExponent, ZERO_EXPONENT};
pub use extremes::{Extreme, Extremes};
pub use followed::Followed;
pub use machine::{Machine, now};
pub use measured::Measured;
pub use measures::{Measure, measure};
pub use monodromy::carried;
pub use plane::PlanePoint;
pub use poincare::{PoincareRequest, SectionPoint, poincare, section_of};
pub use quantity::{QuantityName, unknown};
pub use section::{Section, SectionRule, common_period, is_steady};
pub use settled::{Settled, discard, require_free, settled};
pub use spectrum::{Spectrum, spectrum};
pub use text::significant;
pub use timescales::{runs_on, settle};
pub use vibro_machine::Start;
pub use watch::{Extent, Maxima, Watcher};
pub use written::places;

#[cfg(test)]
mod tests;
