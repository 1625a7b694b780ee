//! A 3-DOF vibro-impact system: exact event-driven simulation and closed-form steady states.
//!
//! A box on a spring is driven near resonance; a block flies in it between two stops; a third body
//! hangs on the block by a spring.
//!
//! ```
//! use vibro_impact::simulator::Loads;
//! use vibro_impact::{Parameters, Simulator, State, steady};
//!
//! let parameters = Parameters::default();
//! // Box, block and secondary oscillator, m and m/s.
//! let start = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
//! let mut simulator = Simulator::new(&parameters, &start, 0.0)?;
//! simulator.advance_to(400.0 * parameters.period())?; // exact for steps of any length
//! let orbits = steady::exact_orbit::solve(&parameters)?;
//! let orbit = orbits.upper.expect("a motion with two impacts a period");
//! let closed = orbit.state(simulator.drive_phase()); // the closed form at this instant
//! assert!((simulator.state().x[1] - closed.x[1]).abs() < 1e-9);
//!
//! let mut loads = Loads::default();
//! loads.derivatives[1] = [0.01, 0.0, 0.0, 0.0]; // N on the block, with its time derivatives
//! simulator.set_loads(&loads)?;
//! simulator.advance_to_impact(simulator.time() + parameters.period())?;
//! println!("{:?}", simulator.impacts());
//! # Ok::<(), vibro_impact::Error>(())
//! ```
//!
//! ```text
//! parameters → model → flow → events → simulator
//! parameters → steady (multiple scales, strong coupling, exact orbit)
//! ```
//!
//! The modules `model`, `flow` and `energy` are for the other packages of the
//! workspace and are not shown here. Their types that occur in the simulator's signatures are in
//! [`simulator`].
//!
//! `steady` never calls the simulator and the simulator never calls `steady`: each is the other's
//! oracle.
//!
//! The equations are in `docs/theory.md`, the numerical method and its error bounds in
//! `docs/numerics.md`; both are shown in this documentation as the modules `theory` and
//! `numerical_method`.
#![forbid(unsafe_code)]

// Internal modules that the other packages of the workspace use. These modules are not for users
// and may change from version to version.
#[doc(hidden)]
pub mod energy;
pub mod error;
#[doc(hidden)]
pub mod flow;
pub mod load;
#[doc(hidden)]
pub mod model;
pub mod parameters;
pub mod reference;
pub mod simulator;
mod state;
pub mod steady;

// The pages are text. Their brackets are not links, and the compiled library contains nothing of
// them.
#[cfg(doc)]
#[allow(rustdoc::all)]
#[doc = include_str!("../docs/theory.md")]
pub mod theory {}

#[cfg(doc)]
#[allow(rustdoc::all)]
#[doc = include_str!("../docs/numerics.md")]
pub mod numerical_method {}

// The Rust blocks of the README and of the recipes are run with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeBlocks;

#[cfg(doctest)]
#[doc = include_str!("../docs/paper-machine.md")]
struct RecipeBlocks;

pub use error::{Error, Result};
pub use parameters::{Groups, Parameters, Scales};
pub use simulator::Simulator;
pub use state::State;
pub use vibro_numerics::quantities;
