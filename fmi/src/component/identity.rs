//! What tells one build of the component from another: a number made from everything its table says and its version.

use super::structure;
use super::units::{ENUMERATION_TYPES, REAL_TYPES, UNITS};
use super::variables::{VARIABLES, Variable};
use std::fmt::Write;

/// Version of the component.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The number of this build. Computed anew on each call, so that the library keeps nothing between loads.
pub fn number() -> u128 {
    fnv1a(text().as_bytes())
}

/// The table as text, without its function pointers.
pub fn text() -> String {
    // Writing to a String cannot fail.
    let mut text = format!("{VERSION} {}\n", structure::EVENT_INDICATORS);
    let _ = writeln!(text, "{UNITS:?}\n{REAL_TYPES:?}\n{ENUMERATION_TYPES:?}");
    for v in &VARIABLES {
        let Variable {
            name,
            description,
            causality,
            variability,
            initial,
            kind,
            dependencies,
            path,
            body,
            edition,
            dimensions,
            symbol,
            section: _,
            access: _,
        } = v;
        let attributes = format!("{causality:?}|{variability:?}|{initial:?}|{kind:?}|{:?}", v.start());
        let columns = format!("{dependencies:?}|{path:?}|{body:?}|{edition:?}|{dimensions:?}|{symbol:?}");
        let _ = writeln!(text, "{name}|{description}|{attributes}|{columns}");
    }
    text
}

/// FNV-1a, 128 bit.
pub fn fnv1a(bytes: &[u8]) -> u128 {
    const OFFSET: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    bytes.iter().fold(OFFSET, |hash, byte| (hash ^ u128::from(*byte)).wrapping_mul(PRIME))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Test vectors of the hash's authors.
    #[test]
    fn golden_values_of_fnv1a() {
        assert_eq!(fnv1a(b""), 0x6c62272e07bb014262b821756295c58d);
        assert_eq!(fnv1a(b"a"), 0xd228cb696f1a8caf78912b704e4a8964);
    }
}
