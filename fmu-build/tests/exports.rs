//! The packaged binary exports the functions of FMI 2.0 and 3.0 and nothing else.

mod common;

use fmu_build::compile::{self, Product};
use fmu_build::inspect;

#[test]
fn exports_are_the_functions_of_both_versions() {
    for library in [Product::Vibro, Product::Machine] {
        let bytes = std::fs::read(compile::at_hand(library).unwrap()).unwrap();
        assert_eq!(inspect::exports(&bytes).unwrap(), common::functions(), "{library:?}");
    }
}
