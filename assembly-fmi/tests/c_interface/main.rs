//! Described machines through the C interface, as a host would run them: both versions, events, saved states, refusals.
#![allow(unsafe_code)] // the C interface

mod derivatives;
mod exchange;
mod host;
mod intermediate;
mod parameters;
mod resources;
mod steps;

use vibro_assembly_fmi::Machine;

fmi_doors::export!(Machine);
