//! The choice of vector instructions at run time.
//!
//! Products are not fused, so that all instructions give the same bits. On x86 vectors of 256 bits
//! are the widest: with 512 bits the compiler gathers single numbers of short lists, which takes 5
//! to 15 % more time.

use pulp::WithSimd;

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
type Widest = Option<pulp::x86::V3>;
#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
type Widest = pulp::Arch;

/// The vector instructions of the computer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vectors(Widest);

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
impl Vectors {
    pub(crate) fn new() -> Self {
        Self(pulp::x86::V3::try_new())
    }

    /// Runs code compiled for these vectors.
    #[inline(always)]
    pub(crate) fn dispatch<Op: WithSimd>(self, op: Op) -> Op::Output {
        match self.0 {
            Some(widest) => pulp::Simd::vectorize(widest, op),
            None => op.with_simd(pulp::Scalar::new()),
        }
    }
}

#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
impl Vectors {
    pub(crate) fn new() -> Self {
        Self(pulp::Arch::new())
    }

    /// Runs code compiled for these vectors.
    #[inline(always)]
    pub(crate) fn dispatch<Op: WithSimd>(self, op: Op) -> Op::Output {
        self.0.dispatch(op)
    }
}
