//! Base types of the variables, and the descriptions that have them.

/// Type of a variable's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// A floating-point number.
    Real,
    /// A whole number.
    Integer,
    /// True or false.
    Boolean,
    /// One of named items.
    Enumeration,
    /// Active or not.
    Clock,
}

impl Base {
    /// Its name in messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Real => "Real",
            Self::Integer => "Integer",
            Self::Boolean => "Boolean",
            Self::Enumeration => "Enumeration",
            Self::Clock => "Clock",
        }
    }
}

/// The descriptions that have a variable. Each has those of the ones before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Edition {
    /// Every description.
    Every,
    /// Descriptions that know event indicators and derivatives as variables.
    Extended,
    /// The same with arrays.
    Arrays,
    /// The same with a clock.
    Clocked,
}

impl Edition {
    /// All, in the order of inclusion.
    pub const ALL: [Self; 4] = [Self::Every, Self::Extended, Self::Arrays, Self::Clocked];
}

/// The types that one kind of getter and setter serves; which these are is the matter of an interface standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bases {
    /// Their name in messages.
    pub name: &'static str,
    bits: u8,
}

impl Bases {
    /// The Reals.
    pub const REAL: Self = Self::new("Real", &[Base::Real]);
    /// All types.
    pub const ANY: Self =
        Self::new("", &[Base::Real, Base::Integer, Base::Boolean, Base::Enumeration, Base::Clock]);

    /// These types under one name.
    pub const fn new(name: &'static str, bases: &[Base]) -> Self {
        let (mut bits, mut i) = (0, 0);
        while i < bases.len() {
            bits |= 1 << bases[i] as u8;
            i += 1;
        }
        Self { name, bits }
    }

    /// Whether a type is one of them.
    #[inline]
    pub const fn contains(self, base: Base) -> bool {
        self.bits & (1 << base as u8) != 0
    }
}
