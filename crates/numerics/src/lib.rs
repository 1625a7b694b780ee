//! Numerical tools without mechanics: extended precision, polynomials and their first zero, roots,
//! monotone cubics, units and ranges of numbers, digests, vectors chosen at run time.
//!
//! Polynomials are evaluated in several ways, each where it is fastest. Their last digits differ.
//! One must not replace another, because the bits of states would change:
//!
//! | function | of | why it is apart |
//! |---|---|---|
//! | [`simd::value`] | one polynomial, scalar | two chains of half the length; equal bits on all instruction sets |
//! | `events::value_and_slope` | one polynomial and its slope, scalar | two chains for each, for Newton's method |
//! | `events::pairwise` | one polynomial of up to 16 orders, fused products | shortest chain, for roots in flight |
//! | `events::by_fours` | one polynomial of any number of orders, scalar | four chains, for roots of described machines; equal bits on all instruction sets |
//! | [`simd::polynomial`] | eight coordinates in vectors | the state at a point of a flight |
//! | `vibro_impact::flow::polynomial` | any number of coordinates, scalar | rest and loads; equal bits on all instruction sets |
//! | [`bernstein::evaluate`] | one polynomial and its slope on \[0, 1\], Horner | the closed forms, which share no code with the simulator |
//! | `polynomial` of the lanes | one polynomial in each lane | many motions side by side |
#![forbid(unsafe_code)]

// The Rust block of the package's page is run with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeBlocks;

pub mod bernstein;
pub mod digest;
pub mod double_double;
pub mod drive_phase;
pub mod events;
pub mod monotone;
pub mod quantities;
mod range;
pub mod roots;
pub mod simd;
pub mod sorting;

pub use range::{OutOfRange, Range};
