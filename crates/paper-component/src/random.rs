//! Random numbers for the tests of both C interfaces.

use std::ffi::c_int;

/// Number of calls of a run; a fuzzer makes more.
pub const CALLS: usize = if cfg!(miri) { 60 } else { 4000 };

/// SplitMix64.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, limit: u64) -> u64 {
        self.next() % limit
    }

    pub fn one_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }

    pub fn number(&mut self) -> f64 {
        match self.below(12) {
            0 => f64::from_bits(self.next()),
            1 => f64::NAN,
            2 => f64::INFINITY,
            3 => 0.0,
            4 => -1.0,
            5 => 1e300,
            6 => 1e-300,
            7 => self.below(4) as f64,
            _ => self.below(1000) as f64 / 500.0 - 0.5,
        }
    }

    pub fn integer(&mut self) -> c_int {
        if self.one_in(4) { self.next() as c_int } else { self.below(5) as c_int }
    }

    /// Step sizes stay small, so that valid steps do not take for ever.
    pub fn size(&mut self) -> f64 {
        let size = self.number();
        if size.is_finite() { size.clamp(-1.0, 5.0) } else { size }
    }
}
