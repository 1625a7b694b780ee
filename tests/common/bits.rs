//! Digests of state bits and their golden files, one for each instruction set on which the
//! arithmetic differs.

use std::fmt::Write;
use std::{env, fs};
use vibro_numerics::digest;

/// Folder of the golden files of the package under test.
const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data");

/// FNV-1a digest of recorded bits: any bit that differs changes the digest, except for one chance
/// in 2⁶⁴.
#[derive(Clone, Copy, Debug)]
pub struct Digest(u64);

impl Digest {
    pub fn new() -> Self {
        Self(digest::EMPTY)
    }

    pub fn number(&mut self, number: u64) {
        self.0 = digest::extended(self.0, &number.to_le_bytes());
    }

    pub fn reals(&mut self, values: &[f64]) {
        for value in values {
            self.number(value.to_bits());
        }
    }

    pub fn text(&mut self, text: &str) {
        for byte in text.bytes() {
            self.number(u64::from(byte));
        }
    }

    pub fn finish(self) -> String {
        format!("{:016x}", self.0)
    }
}

/// Instruction set that the library chooses on this machine; the order of the arithmetic depends
/// on it.
fn instruction_set() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
            return "x86-64-v4";
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            return "x86-64-v3";
        }
        "x86-64"
    }
    #[cfg(not(target_arch = "x86_64"))]
    env::consts::ARCH
}

/// Compares with the golden file of this machine's instruction set. `UPDATE=1` in the environment
/// writes the file instead. Without a file for an instruction set nothing is compared, and a line
/// says so.
pub fn compare(name: &str, found: &[(String, String)]) {
    let folder = DATA;
    let path = format!("{folder}/{name}.{}.txt", instruction_set());
    let mut text = String::new();
    for (motion, digest) in found {
        writeln!(text, "{digest}  {motion}").expect("a String takes all");
    }
    if env::var_os("UPDATE").is_some() {
        fs::write(&path, &text).unwrap_or_else(|e| panic!("{path}: {e}"));
        return;
    }
    let Ok(golden) = fs::read_to_string(&path) else {
        println!("not compared: there is no {path}; UPDATE=1 writes it from code that is known to be right");
        return;
    };
    let differing: Vec<_> = golden.lines().zip(text.lines()).filter(|(a, b)| a != b).collect();
    assert!(differing.is_empty(), "{} motions differ: {differing:#?}", differing.len());
    assert_eq!(golden.lines().count(), found.len(), "another number of motions");
}
