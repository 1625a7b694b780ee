//! Numerical tools without mechanics: extended precision, polynomials, roots, vectors chosen at run time.

pub mod bernstein;
pub mod double_double;
pub mod drive_phase;
pub mod roots;
pub mod simd;
