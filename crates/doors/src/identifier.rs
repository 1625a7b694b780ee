//! Identifiers computed from contents.

/// A hash in the form of a globally unique identifier. A library recognizes its model description
/// by this token, made from everything that determines the description.
pub fn identifier(text: &str) -> String {
    let hash = fnv1a(text.as_bytes());
    format!(
        "{{{:08x}-{:04x}-{:04x}-{:04x}-{:012x}}}",
        (hash >> 96) as u32,
        (hash >> 80) as u16,
        (hash >> 64) as u16,
        (hash >> 48) as u16,
        hash & 0xffff_ffff_ffff
    )
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
