//! The digest FNV-1a. Unlike the standard library's hashes, it does not depend on machine and
//! version. It distinguishes texts and saved bytes and detects accidental changes, but does not
//! protect against deliberate ones.

/// Digest of an empty sequence.
pub const EMPTY: u64 = 0xcbf2_9ce4_8422_2325;

/// Digest of a text followed by `bytes`, where `of` is the digest of the text.
pub fn extended(of: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(of, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// 64-bit digest of `bytes`.
///
/// ```
/// assert_eq!(vibro_numerics::digest::fnv1a(b"a"), 0xaf63_dc4c_8601_ec8c);
/// ```
pub fn fnv1a(bytes: &[u8]) -> u64 {
    extended(EMPTY, bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Test vectors of the digest's authors.
    #[test]
    fn golden_values_of_fnv1a() {
        assert_eq!(fnv1a(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a(b"a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv1a(b"foobar"), 0x8594_4171_f739_67e8);
        assert_eq!(extended(fnv1a(b"foo"), b"bar"), fnv1a(b"foobar"));
    }
}
