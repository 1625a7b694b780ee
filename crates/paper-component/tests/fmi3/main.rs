//! FMI 3.0 through its C interface, as hosts use it.
#![allow(unsafe_code)] // the C interface

mod arguments;
mod bits;
mod clock;
mod dependencies;
mod derivatives;
mod events;
mod exchange;
#[path = "../common/fmi2.rs"]
mod fmi2;
mod host;
mod intermediate;
mod output_derivatives;
