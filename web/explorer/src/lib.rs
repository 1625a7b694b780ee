//! The library's functions for the live page. Arguments are numbers, results are arrays of
//! numbers.
//!
//! The library does all computations. This crate turns names, numbers and states into calls of
//! `vibro-impact` and `vibro-studies`, and results into rows of numbers. Arrays are copied into
//! JavaScript: at most a few hundred kilobytes per picture, in less than a tenth of a millisecond.
//!
//! | module | use in the page |
//! |---|---|
//! | `set` | the fields and sliders: parameters by name, their ranges and errors |
//! | `machine` | the moving machine, histories, phase portrait, Poincaré section |
//! | `diagram` | columns of the bifurcation diagram, Lyapunov exponents |
//! | `curves` | closed-form responses, slow invariant manifold, branches of exact orbits |
//!
//! If a value is refused, a JavaScript `Error` with the library's message is thrown, and nothing
//! has changed.
#![allow(unsafe_code)] // written by the macro `wasm_bindgen` around each function; none is written by hand

pub mod curves;
pub mod diagram;
pub mod machine;
pub mod set;
