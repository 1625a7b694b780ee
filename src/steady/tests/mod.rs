//! Tests that set the methods of `steady` against each other and against model.md.

mod multiple_scales;
