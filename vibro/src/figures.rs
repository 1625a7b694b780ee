//! Pictures: what they consist of, how they are drawn, and the figures of the paper.

pub mod canvas;
pub mod chart;
mod draw;
mod labels;
mod panel;
mod scale;
mod symbols;
