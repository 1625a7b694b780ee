//! The one table of variables. It is the source of the model description, start values, range
//! checks, getters, setters, derivatives, reset and the documentation.
//!
//! A variable's index is its row, in the order of the descriptions. Its value reference is a
//! column of the row and does not change when rows are inserted or removed. A description leaves
//! out the variables of later [`Edition`]s; its [`Numbering`] determines its references.
//! `crates/paper-component/README.md` explains how a variable is added.

mod bases;
mod columns;
mod later;
mod numbering;
mod packed;
mod rows;
mod sections;
mod table;

pub use bases::{Base, Bases, Edition};
pub use columns::*;
pub use numbering::Numbering;
pub(crate) use packed::{Get, READERS, Reader, Set, WRITERS, Writer};
pub use rows::START;
pub use sections::{SECTIONS, Section};
pub use table::{COUNT, VARIABLES};

/// The variables of a description, each with its index.
pub fn of_edition(edition: Edition) -> impl Iterator<Item = (usize, &'static Variable)> {
    VARIABLES.iter().enumerate().filter(move |(_, variable)| variable.edition <= edition)
}

/// The variable with a name.
pub fn find(name: &str) -> Option<&'static Variable> {
    VARIABLES.iter().find(|variable| variable.name == name)
}

/// Index of the variable with a name, at compile time.
///
/// # Panics
/// If no variable has the name, so a misspelt constant does not compile.
pub const fn place(name: &str) -> usize {
    let mut i = 0;
    while i < COUNT {
        if same(VARIABLES[i].name, name) {
            return i;
        }
        i += 1;
    }
    panic!("no variable of that name")
}

/// The table's own value reference of the variable with a name, at compile time.
///
/// # Panics
/// As [`place`].
pub const fn reference(name: &str) -> u32 {
    VARIABLES[place(name)].reference
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
