//! Search for the numbers of a described machine with which its settled motion is best.
//!
//! ```text
//! request → candidates (a sweep's rows) → global search → local search → best, with its error
//! ```
//!
//! The value of a design is the worst of its motions: over a band such as the drive's frequency,
//! from several starts, and over tolerances of the numbers that vary. It is measured as
//! [`vibro_studies::design_sweep`] measures it, with the same error bars.
//!
//! The global search takes the first points of the Sobol sequence, then differential evolution. The
//! local search takes the exact derivatives of periodic orbits (`vibro-orbits`) where the motion
//! settles on one, and differential evolution in a smaller box where it does not.
//!
//! | module | what it does |
//! |---|---|
//! | `request` | goal, limits, ranges; checks |
//! | `candidate` | the machine as a sweep takes it, with signs and tolerances |
//! | `evaluation` | the value of a design with its error |
//! | `evolution` | global search |
//! | `descent` | local search by gradients |
//! | `quadratic` | the model of a step of the local search |
//! | `contact_points` | motions that decide the worst value, and their peaks over a band |
//! | `orbits` | orbits that are followed while the numbers change, with derivatives |
//! | `comparison` | longer measurements of the best designs, and the verdict |
//! | `attractors` | other motions of a design |
//! | `search` | the order of all this |

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
