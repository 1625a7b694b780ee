//! The one table of variables: the model description, start values, range checks, getters, setters, derivatives, reset and
//! the documentation all come from it.
//!
//! A reference is a variable's place in [`VARIABLES`], for all types alike; new variables are appended, so references stay. A
//! description leaves out the variables of later [`Edition`]s, and a door makes its value references from the places. How a
//! variable is added: `fmi/README.md`.

mod bases;
mod columns;
mod later;
mod packed;
mod rows;
mod sections;
mod table;

pub(crate) use bases::Class;
pub use bases::{Base, Bases, Edition};
pub use columns::*;
pub(crate) use packed::{Get, READERS, Reader, Set, WRITERS, Writer};
pub use rows::START;
pub use sections::{SECTIONS, Section};
pub use table::{COUNT, VARIABLES};

/// The variables of a description, each with its place.
pub fn of_edition(edition: Edition) -> impl Iterator<Item = (u32, &'static Variable)> {
    (0..).zip(VARIABLES.iter()).filter(move |(_, variable)| variable.edition <= edition)
}

/// The variable of that name and its place.
pub fn find(name: &str) -> Option<(u32, &'static Variable)> {
    (0..).zip(VARIABLES.iter()).find(|(_, variable)| variable.name == name)
}

/// Place of the variable of that name, at compile time.
///
/// # Panics
/// When there is none: a misspelt constant does not compile.
pub const fn reference(name: &str) -> u32 {
    let mut i = 0;
    while i < COUNT {
        if same(VARIABLES[i].name, name) {
            return i as u32;
        }
        i += 1;
    }
    panic!("no variable of that name")
}

const fn same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}

#[cfg(test)]
mod tests;
