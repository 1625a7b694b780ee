//! Numerical tools without mechanics: extended precision, polynomials, roots, digests, vectors
//! chosen at run time.
//!
//! A polynomial is evaluated in several ways, each where its arithmetic pays; their last digits
//! differ, and the state bits with them, so they are not exchanged for one another:
//!
//! | function | of | why it is apart |
//! |---|---|---|
//! | [`simd::value`] | one polynomial, scalar | two chains of half the length; the same on every instruction set |
//! | `events::value_and_slope` | one polynomial and its slope, scalar | the same two chains for both, for Newton's method |
//! | `events::pairwise` | one polynomial of up to 16 orders, fused products | nothing waits long: the first step of a root in flight |
//! | `events::by_fours` | one polynomial of any number of orders, scalar | the same for the roots of described machines, on every instruction set alike |
//! | [`simd::polynomial`] | eight coordinates in vectors | the state at a point of a flight |
//! | [`flow::polynomial`](crate::flow::polynomial) | any number of coordinates, scalar | the same on every instruction set: rest and loads |
//! | [`bernstein::evaluate`] | one polynomial and its slope on \[0, 1\], Horner | the closed forms, which share no code with the simulator |
//! | `polynomial` of the lanes | one polynomial in each lane | many motions side by side |

pub mod bernstein;
pub mod digest;
pub mod double_double;
pub mod drive_phase;
pub mod roots;
pub mod simd;
