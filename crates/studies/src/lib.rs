//! Studies of described machines, which a file or a program composes of bodies and elements
//! (`vibro-machine`): settled motions and their classes, Lyapunov exponents, diagrams, sweeps,
//! basins, planes and fits. The studies of the paper's machine are in [`paper`].
//!
//! A motion is observed where it returns to a [section](SectionRule): after each common period of
//! the machine's drive, or at each event of an element.
//!
//! A study is a function from a machine and a request to plain data. It does not print or write
//! anything. The result depends neither on the number of threads nor on the division into parts:
//! every change of a study preserves this, with a test that compares divided and whole work.
//!
//! A new study has a request that serde can write, a function of the request and a
//! [`parts::Task`], and a number of parts that depends on the request alone. The command line
//! lists it as a kind of long study. A new measure is a variant of [`Measure`] with name, unit and
//! description, and its value over a window. The limits and thresholds of verdicts come from
//! docs/theory.md, section 17; change them together with their reasons there.
//!
//! | module | content | tested against |
//! |---|---|---|
//! | [`parts`] | long studies, divided and continued | divided work against whole work |
//! | [`settled()`] | attractors, classes, largest exponents | known motions; the paper's machine |
//! | [`spectrum()`] | all Lyapunov exponents | multipliers; divergence |
//! | [`diagram`] | diagrams over one parameter | closed forms; the paper's machine |
//! | [`basin`] | attractors over two initial values | single simulations |
//! | [`design_sweep`] | measures over many parameters | single motions; closed forms |
//! | [`fit`] | parameters of a machine from a record | records of known machines |
//! | [`flight`] | a motion's flights between events as series | dense samples |
//! | [`natural`] | natural frequencies | closed forms |
//! | [`sobol`] | the Sobol sequence | SciPy's |

// The Rust block of the package's page is run with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeBlocks;

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
pub use error::{Error, OR_NEW_SECTION, Result};
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
