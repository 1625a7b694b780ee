//! Pictures: what they consist of and how they are drawn.

pub mod canvas;
pub mod chart;
mod draw;
mod labels;
mod panel;
mod scale;
mod symbols;
