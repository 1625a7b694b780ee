//! Identity of a build of the component: a number computed from the contents of its table and its
//! version.

use super::structure;
use super::units::{ENUMERATION_TYPES, REAL_TYPES, UNITS};
use super::variables::{VARIABLES, Variable};
use fmi_doors::description::Experiment;
use fmi_doors::identifier::fnv1a;
pub use fmi_doors::identifier::identifier;
use std::fmt::Write;
use vibro_impact::parameters::Parameters;

/// Version of the component.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Name of the model, and of the library's file.
pub const MODEL_IDENTIFIER: &str = "VibroImpact3DOF";

/// Description of the model.
pub const MODEL_DESCRIPTION: &str = "Three-degree-of-freedom vibro-impact system: a driven box, a block free between two stops inside it, \
     and a secondary oscillator coupled to the block; exact event-driven simulation and closed-form steady states";

/// Description of the logged events.
pub const EVENTS: &str = "Each impact, rest and release";

/// Author of the model.
pub const AUTHOR: &str = "the vibro-impact contributors";

/// Copyright of the model.
pub const COPYRIGHT: &str = "Copyright (c) 2026 the vibro-impact contributors";

/// Licence of the component.
pub const LICENSE: &str = env!("CARGO_PKG_LICENSE");

/// Form of the names of the variables: dots between the levels.
pub const NAMING_CONVENTION: &str = "structured";

/// The default experiment of a host: 100 periods of the default drive, with 200 steps each. The
/// step is a reporting interval in Co-Simulation, but in Model Exchange hosts use it as the step
/// of their solver, and Euler's method needs a short step (docs/theory.md (115)). The quotient of
/// duration and step is a whole number, as some hosts require.
pub fn default_experiment() -> Experiment {
    let period = Parameters::default().period();
    Experiment { start_time: 0.0, stop_time: 100.0 * period, tolerance: 1e-8, step_size: period / 200.0 }
}

/// The number of this build. Computed again on each call, so that the library keeps nothing when a
/// host unloads it.
pub fn number() -> u128 {
    fnv1a(text().as_bytes())
}

/// The table as text, without its function pointers.
pub fn text() -> String {
    // Writing to a String cannot fail.
    let mut text = format!("{VERSION} {}\n", structure::EVENT_INDICATORS);
    let _ = writeln!(text, "{UNITS:?}\n{REAL_TYPES:?}\n{ENUMERATION_TYPES:?}");
    for v in &VARIABLES {
        let Variable {
            reference,
            name,
            description,
            causality,
            variability,
            initial,
            kind,
            dependencies,
            further,
            initially,
            body,
            edition,
            dimensions,
            symbol,
            section: _,
            access: _,
        } = v;
        let attributes = format!("{causality:?}|{variability:?}|{initial:?}|{kind:?}|{:?}", v.start());
        let known = format!("{dependencies:?}|{further:?}|{initially:?}");
        let columns = format!("{known}|{body:?}|{edition:?}|{dimensions:?}|{symbol:?}");
        let _ = writeln!(text, "{reference}|{name}|{description}|{attributes}|{columns}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_experiment_has_a_whole_number_of_intervals() {
        let Experiment { start_time, stop_time, step_size, .. } = default_experiment();
        assert_eq!((stop_time - start_time) / step_size, 20000.0);
    }
}
