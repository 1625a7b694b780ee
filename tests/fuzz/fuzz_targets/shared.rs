//! Inputs and checks of the targets of both C interfaces.

use arbitrary::Arbitrary;
use std::ffi::{CStr, c_char, c_int};
use std::ptr::null_mut;
use vibro_numerics::digest::fnv1a;

pub const FATAL: c_int = 4;
/// Number of elements of every buffer: the largest accepted count.
pub const ROOM: usize = 4096;
/// Value of the guard behind every buffer.
pub const GUARD: u64 = 0x5afe_5afe_5afe_5afe;
/// Largest number of sub-steps of a step; longer steps are cut to keep iterations fast.
const WORK: f64 = 2000.0;

/// A number: plain, over many decades, or raw bits.
#[derive(Arbitrary, Clone, Copy, Debug)]
pub enum Number {
    Small(i8),
    Decade(i8, u8),
    Raw(f64),
}

impl Number {
    pub fn value(self) -> f64 {
        match self {
            Self::Small(n) => f64::from(n) / 16.0,
            Self::Decade(mantissa, exponent) => f64::from(mantissa) * 10f64.powi(i32::from(exponent % 24) - 12),
            Self::Raw(x) => x,
        }
    }
}

/// Number of elements passed to a call.
#[derive(Arbitrary, Clone, Copy, Debug)]
pub enum Count {
    Few(u8),
    Six,
    Any(usize),
}

impl Count {
    pub fn value(self) -> usize {
        match self {
            Self::Few(n) => usize::from(n % 5),
            Self::Six => 6,
            Self::Any(n) => n,
        }
    }
}

/// A buffer with a guard behind it.
pub struct Buffer<T>(pub Vec<T>);

impl<T: Copy + PartialEq + std::fmt::Debug> Buffer<T> {
    pub fn new(values: &[T], guard: T) -> Self {
        let mut all: Vec<T> = values.iter().copied().cycle().take(ROOM).collect();
        all.push(guard);
        Self(all)
    }

    pub fn pointer(&mut self, null: bool) -> *mut T {
        if null { null_mut() } else { self.0.as_mut_ptr() }
    }
}

/// Longest step of an iteration, s, for a machine with these values.
pub fn longest(v: impl Fn(&str) -> f64) -> f64 {
    let k = v("box.k") / v("box.m")
        + v("coupling.k") * (1.0 / v("block.m") + 4.0 / v("secondary.m"))
        + v("secondary.k") / v("secondary.m");
    let damping = v("box.c") / v("box.m") + v("secondary.c") / v("secondary.m");
    let longest = WORK / ((2.0 * k).sqrt() + damping + v("drive.frequency"));
    if longest.is_finite() { longest } else { 0.0 }
}

/// The text of a log message, whose status and category are checked.
///
/// # Safety
/// Category and text are C strings.
pub unsafe fn message<'a>(status: c_int, category: *const c_char, text: *const c_char) -> &'a str {
    assert!((0..=FATAL).contains(&status));
    // SAFETY: as the caller says.
    let (category, text) = unsafe { (CStr::from_ptr(category), CStr::from_ptr(text)) };
    let (category, text) = (category.to_str().expect("UTF-8"), text.to_str().expect("UTF-8"));
    assert!(category.starts_with("log") && !text.is_empty());
    text
}

/// Writes the right checksum (FNV-1a) into altered bytes, so that the code after its check is
/// reached.
pub fn mend(bytes: &mut [u8]) {
    if let Some((content, checksum)) = bytes.split_last_chunk_mut::<8>() {
        *checksum = fnv1a(content).to_le_bytes();
    }
}
