#![allow(missing_docs)]
#[path = "../tests/contacts.rs"]
mod contacts;
fn main() {}
