//! Value references of a description, and the variable of each.
//!
//! The reference of a variable in the table is the column [`Variable::reference`]. It is never
//! used for another variable, even after the variable has been removed. A description either uses
//! these references, or counts its variables in their order, for importers that take a reference
//! for an index. Counted references may change with every build.

use super::bases::Edition;
use super::columns::Variable;
use super::table::{COUNT, VARIABLES};

/// The largest reference of the table.
const LARGEST: u32 = {
    let (mut largest, mut i) = (0, 0);
    while i < COUNT {
        if VARIABLES[i].reference > largest {
            largest = VARIABLES[i].reference;
        }
        i += 1;
    }
    largest
};

/// Largest reference of any numbering, plus one.
const LENGTH: usize = if LARGEST as usize > COUNT { LARGEST as usize + 1 } else { COUNT + 1 };

/// Entry of a reference without a variable.
const NONE: u16 = u16::MAX;

/// The value references of one description.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numbering {
    /// Indices in the table by reference.
    places: &'static [u16; LENGTH],
}

impl Numbering {
    /// Every variable with the table's own reference.
    pub const ALL: Self = Self { places: &const { own(&VARIABLES, Edition::Clocked) } };
    /// The variables of an edition with the table's own references.
    pub const EVERY: Self = Self { places: &const { own(&VARIABLES, Edition::Every) } };

    /// The variables of an edition, counted from 1 in the order of the table without gaps.
    pub const fn counted(edition: Edition) -> Self {
        Self {
            places: match edition {
                Edition::Every => &const { counted(&VARIABLES, Edition::Every) },
                Edition::Extended => &const { counted(&VARIABLES, Edition::Extended) },
                Edition::Arrays => &const { counted(&VARIABLES, Edition::Arrays) },
                Edition::Clocked => &const { counted(&VARIABLES, Edition::Clocked) },
            },
        }
    }

    /// Index of the variable with a reference; [`COUNT`] or more if no variable has the reference.
    #[inline]
    pub(crate) fn place(self, reference: u32) -> usize {
        match self.places.get(reference as usize) {
            Some(place) => usize::from(*place),
            None => usize::from(NONE),
        }
    }

    /// The variable with a reference.
    pub fn variable(self, reference: u32) -> Option<&'static Variable> {
        VARIABLES.get(self.place(reference))
    }

    /// The reference of the variable with an index; `None` if the description leaves the variable
    /// out.
    pub fn reference(self, place: usize) -> Option<u32> {
        (0..).zip(self.places).find(|(_, p)| usize::from(**p) == place).map(|(reference, _)| reference)
    }

    /// All variables of the numbering with their references, in the order of the table.
    pub fn variables(self) -> impl Iterator<Item = (u32, &'static Variable)> {
        let with = move |(place, variable)| Some((self.reference(place)?, variable));
        VARIABLES.iter().enumerate().filter_map(with)
    }

    /// The smallest and the largest reference.
    pub(crate) fn range(self) -> (u32, u32) {
        let used = || (0..).zip(self.places).filter(|(_, place)| **place != NONE).map(|(r, _)| r);
        (used().next().unwrap_or_default(), used().last().unwrap_or_default())
    }
}

/// Indices by the rows' own references; N is larger than any of them.
pub(super) const fn own<const N: usize>(table: &[Variable], edition: Edition) -> [u16; N] {
    let (mut places, mut i) = ([NONE; N], 0);
    while i < table.len() {
        let Variable { reference, edition: of, .. } = table[i];
        if of as u8 <= edition as u8 {
            assert!(places[reference as usize] == NONE, "two variables have one reference");
            places[reference as usize] = i as u16;
        }
        i += 1;
    }
    places
}

/// Indices by the row's number within the edition; N is larger than the number of rows.
pub(super) const fn counted<const N: usize>(table: &[Variable], edition: Edition) -> [u16; N] {
    let (mut places, mut i, mut next) = ([NONE; N], 0, 1);
    while i < table.len() {
        if table[i].edition as u8 <= edition as u8 {
            places[next] = i as u16;
            next += 1;
        }
        i += 1;
    }
    places
}
