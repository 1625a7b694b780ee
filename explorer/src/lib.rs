//! The library's functions for the live page: numbers in, arrays of numbers out.
//!
//! Nothing is computed here that the library does not compute; this crate turns names, numbers and
//! states into calls of `vibro-impact` and `vibro-analysis`, and results into rows of numbers.
//! Arrays are copied into JavaScript: at most some hundred kilobytes a picture, which takes less
//! than a tenth of a millisecond.
//!
//! | module | what the page does with it |
//! |---|---|
//! | `set` | the fields and sliders: parameters by name, their ranges and errors |
//! | `machine` | the moving machine, histories, phase portrait, Poincaré section |
//! | `diagram` | columns of the bifurcation diagram, Lyapunov exponents |
//! | `curves` | response curves of the closed forms, the slow invariant manifold, branches of exact orbits |
//!
//! A refused value is thrown as a JavaScript `Error` with the library's own message, and nothing
//! has changed then.
#![allow(unsafe_code)] // written by the macro `wasm_bindgen` around each function; none is written by hand

pub mod curves;
pub mod diagram;
pub mod machine;
pub mod set;
