//! Search for the parameters of a described machine with the best settled motion.
//!
//! ```text
//! request → candidates (a sweep's rows) → global search → local search → best, with its error
//! ```
//!
//! The value of a design is its worst value over a band such as the drive's frequency, over
//! several starts, and over tolerances of the varied parameters. It is measured as in
//! [`vibro_studies::design_sweep`], with the same error bars.
//!
//! The global search takes the first points of the Sobol sequence, then differential evolution. If
//! the motion settles on a periodic orbit, the local search uses its exact derivatives
//! (`vibro-orbits`); otherwise differential evolution in a smaller box.
//!
//! | module | content |
//! |---|---|
//! | `request` | goal, limits, ranges; checks |
//! | `candidate` | the machine for a sweep, with signs and tolerances |
//! | `evaluation` | the value of a design with its error |
//! | `evolution` | global search |
//! | `descent` | local search by gradients |
//! | `quadratic` | the model of a step of the local search |
//! | `contact_points` | motions that determine the worst value, and their peaks over a band |
//! | `orbits` | orbits followed while the parameters change, with derivatives |
//! | `comparison` | longer measurements of the best designs, and the verdict |
//! | `attractors` | other motions of a design |
//! | `search` | the order of these phases |

// The Rust block of the package's page is run with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeBlocks;

mod attractors;
mod candidate;
mod comparison;
mod contact_points;
mod descent;
mod evaluation;
mod evolution;
mod orbits;
mod outcome;
mod quadratic;
mod request;
mod search;

pub use attractors::Attractor;
pub use candidate::{Candidate, Signed};
pub use evaluation::{Control, Evaluation, Now, Stage, Value};
pub use outcome::{Best, Check, Designed, Rival, Verdict};
pub use request::{DesignRequest, Goal, Limit, Side};
pub use search::design;
