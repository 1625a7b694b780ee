//! The C interfaces of described machines: the first byte chooses the machine and how it is used,
//! the others calls and arguments.
#![no_main]
#![allow(missing_docs)]

#[path = "../../../crates/doors/tests/common/calls.rs"]
mod calls;
#[path = "../../../crates/machine-component/tests/common/machines.rs"]
mod machines;

/// The functions that the library of described machines exports.
mod component {
    use vibro_machine_component::Machine;

    fmi_doors::export!(Machine);
}

use calls::Target;
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;

static MACHINES: LazyLock<Vec<Target>> = LazyLock::new(|| {
    machines::machines(&std::env::temp_dir().join(format!("vibro-fuzz-{}", std::process::id())))
});

fuzz_target!(|bytes: &[u8]| machines::run(&MACHINES, bytes));
