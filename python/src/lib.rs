//! The native part of the Python package `vibro_impact`: the library's entry points on NumPy
//! arrays.
//!
//! The Python modules of the package check arguments, convert them to arrays, and make the results
//! from the returned arrays. This crate does the computations. Long computations run in a separate
//! thread, so that Python's other threads continue and Ctrl-C is handled (`background.rs`).
//!
//! | file | contents |
//! |---|---|
//! | `machine.rs` | a described machine, its starts and sections, as Python objects |
//! | `machine_studies.rs` | measures and diagrams of described machines |
//! | `machine_motion.rs` | motions of described machines |
//! | `machine_fit.rs` | fits of described machines to records |
//! | `machine_orbits.rs` | periodic orbits of described machines and their branches |
//! | `machine_locus.rs` | curves of special points over two parameters |
//! | `machine_settled.rs` | basins, sections and all exponents of described machines |
//! | `paper_system.rs` | parameters of the paper's machine, and loads, as Python objects |
//! | `paper_motion.rs` | motions of the paper's machine: sampled, many at once, sections |
//! | `paper_studies.rs` | diagrams, exponents, basins and measures of the paper's machine |
//! | `paper_steady.rs` | closed forms |
//! | `paper_orbits.rs` | periodic orbits of the paper's machine and their branches |
//! | `designs.rs` | machines of many motions, given one by one or as rows of numbers |
//! | `background.rs` | the thread that computes, and the one that waits for it |
//! | `failure.rs` | errors as Python's exceptions |
//! | `arrays.rs` | arrays from rows |

mod arrays;
mod background;
mod designs;
mod failure;
mod machine;
mod machine_design;
mod machine_fit;
mod machine_locus;
mod machine_motion;
mod machine_orbits;
mod machine_settled;
mod machine_studies;
mod paper_motion;
mod paper_orbits;
mod paper_steady;
mod paper_studies;
mod paper_system;

/// The native part of `vibro_impact`; the package's Python modules are its interface.
#[pyo3::pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::machine::Described;
    #[pymodule_export]
    use super::machine_design::design;
    #[pymodule_export]
    use super::machine_fit::{columns_of_table, fit};
    #[pymodule_export]
    use super::machine_locus::locus;
    #[pymodule_export]
    use super::machine_motion::{follow_many, simulate, simulate_many, transition};
    #[pymodule_export]
    use super::machine_orbits::{Orbit, branches, follow, orbit};
    #[pymodule_export]
    use super::machine_settled::{basins, section, spectrum};
    #[pymodule_export]
    use super::machine_studies::{diagram, measure_many};
    #[pymodule_export]
    use super::paper_motion::{paper_poincare, paper_simulate, paper_simulate_many};
    #[pymodule_export]
    use super::paper_orbits::{PaperOrbit, paper_branches, paper_follow, paper_orbit, paper_settled_orbit};
    #[pymodule_export]
    use super::paper_steady::{paper_steady, paper_steady_motion};
    #[pymodule_export]
    use super::paper_studies::{
        paper_basins, paper_bifurcation, paper_lyapunov, paper_measure, paper_measure_many, paper_measures,
    };
    #[pymodule_export]
    use super::paper_system::{Load, System, find_name, in_si, parameters};

    /// The package's version is the workspace's.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
