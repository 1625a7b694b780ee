//! Base types of the variables, and the descriptions that contain them.

pub use fmi_doors::{Base, Bases};

/// The descriptions that contain a variable. Each edition contains the variables of the editions
/// before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Edition {
    /// Every description.
    Every,
    /// Descriptions with event indicators and derivatives as variables.
    Extended,
    /// Extended descriptions with arrays.
    Arrays,
    /// Descriptions with arrays and a clock.
    Clocked,
}

impl Edition {
    /// All editions, in the order of inclusion.
    pub const ALL: [Self; 4] = [Self::Every, Self::Extended, Self::Arrays, Self::Clocked];
}
