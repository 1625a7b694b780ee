//! Helpers of several tests.
#![allow(dead_code, missing_docs)] // every test binary uses its own part

pub mod bits;
pub mod golden;
