//! The native part of the Python package `vibro_impact`: the library's entry points on NumPy
//! arrays.
//!
//! The Python modules of the package check arguments, convert them to arrays, and make results from
//! the returned arrays. This crate does the computations. Each computation runs in a separate
//! thread, so that Python's other threads continue and Ctrl-C is handled (`background.rs`).
//!
//! | file | what it holds |
//! |---|---|
//! | `system.rs` | a machine's parameters, and loads, as Python objects |
//! | `motion.rs` | motions: sampled, many at once, sections |
//! | `studies.rs` | bifurcation diagrams, exponents, basins, measures |
//! | `steady.rs` | closed forms |
//! | `orbits.rs` | periodic orbits and branches of them |
//! | `described.rs` | a described machine, its starts and sections, as Python objects |
//! | `assembly.rs` | measures and diagrams of described machines |
//! | `assembly_motion.rs` | their motions |
//! | `assembly_fit.rs` | their fits to records |
//! | `assembly_orbits.rs` | their periodic orbits and branches of them |
//! | `assembly_locus.rs` | curves of their special points over two parameters |
//! | `assembly_settled.rs` | what their motions settle on: basins, sections, all exponents |
//! | `designs.rs` | machines of many motions, given one by one or as rows of numbers |
//! | `background.rs` | the thread that computes, and the one that waits for it |
//! | `failure.rs` | errors as Python's exceptions |
//! | `arrays.rs` | arrays from rows |

mod arrays;
mod assembly;
mod assembly_fit;
mod assembly_locus;
mod assembly_motion;
mod assembly_orbits;
mod assembly_settled;
mod background;
mod described;
mod designs;
mod failure;
mod motion;
mod orbits;
mod steady;
mod studies;
mod system;

/// The native part of `vibro_impact`; the package's Python modules are its interface.
#[pyo3::pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::assembly::{assembly_diagram, measure_assemblies};
    #[pymodule_export]
    use super::assembly_fit::{columns_of_table, fit_assembly};
    #[pymodule_export]
    use super::assembly_locus::assembly_locus;
    #[pymodule_export]
    use super::assembly_motion::{
        assembly_transition, follow_assemblies, simulate_assemblies, simulate_assembly,
    };
    #[pymodule_export]
    use super::assembly_orbits::{AssemblyOrbit, assembly_branches, assembly_orbit, follow_assembly_orbit};
    #[pymodule_export]
    use super::assembly_settled::{assembly_basins, assembly_section, assembly_spectrum};
    #[pymodule_export]
    use super::described::Described;
    #[pymodule_export]
    use super::motion::{poincare, simulate, simulate_many};
    #[pymodule_export]
    use super::orbits::{Orbit, branches, follow, orbit, settled_orbit};
    #[pymodule_export]
    use super::steady::{steady, steady_motion};
    #[pymodule_export]
    use super::studies::{basins, bifurcation, lyapunov, measure, measure_many, measures};
    #[pymodule_export]
    use super::system::{Load, System, find_name, in_si, parameters};

    /// The package's version is the workspace's.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
