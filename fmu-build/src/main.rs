//! Placeholder entry until the packager lands.
fn main() {}
