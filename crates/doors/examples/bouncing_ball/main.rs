//! The library of the bouncing ball that hosts load.
//!
//! `cargo build --example bouncing_ball` makes it; `cargo run --example describe` writes its
//! descriptions.

mod ball;

pub use ball::Ball;
use fmi_doors::tabular::FromTable;

fmi_doors::export!(FromTable<Ball>);
