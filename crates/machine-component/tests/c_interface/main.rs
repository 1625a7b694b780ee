//! Described machines through the C interface of both versions: steps, events, saved states,
//! errors.
#![allow(unsafe_code)] // the C interface

mod box_cone;
#[path = "../../../doors/tests/common/calls.rs"]
mod calls;
mod derivatives;
mod exchange;
mod host;
mod intermediate;
#[path = "../common/machines.rs"]
mod machines;
mod parameters;
mod random_calls;
mod resources;
mod steps;

use crate as component;
use vibro_machine_component::Machine;

fmi_doors::export!(Machine);
