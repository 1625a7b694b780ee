//! Exact propagation of a smooth mode.
