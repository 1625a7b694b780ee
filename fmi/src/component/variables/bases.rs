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
    const COUNT: u16 = Self::Clock as u16 + 1;

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
    /// Descriptions that know arrays, and event indicators and derivatives as variables.
    Extended,
    /// The same with a clock.
    Clocked,
}

impl Edition {
    /// All, in the order of inclusion.
    pub const ALL: [Self; 3] = [Self::Every, Self::Extended, Self::Clocked];
}

/// The types that one kind of getter and setter serves, and the edition whose variables it reaches; which these are is the
/// matter of an interface standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bases {
    /// Their name in messages.
    pub name: &'static str,
    /// The edition reached.
    pub edition: Edition,
    bits: u16,
}

/// A base type in an edition as one bit, so that both are checked at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Class(u16);

impl Class {
    /// The bit of a type in an edition.
    pub(crate) const fn new(base: Base, edition: Edition) -> Self {
        Self(1 << (base as u16 + Base::COUNT * edition as u16))
    }
}

impl Bases {
    /// The Reals that every description has.
    pub const REAL: Self = Self::new("Real", &[Base::Real]);
    /// All types.
    pub const ANY: Self =
        Self::new("", &[Base::Real, Base::Integer, Base::Boolean, Base::Enumeration, Base::Clock]);

    /// These types under one name, of the variables that every description has.
    pub const fn new(name: &'static str, bases: &[Base]) -> Self {
        let (mut bits, mut i) = (0, 0);
        while i < bases.len() {
            bits |= Class::new(bases[i], Edition::Every).0;
            i += 1;
        }
        Self { name, edition: Edition::Every, bits }
    }

    /// The same types with the variables of an edition.
    pub const fn of(self, edition: Edition) -> Self {
        let every = self.bits & ((1 << Base::COUNT) - 1);
        let (mut bits, mut i) = (every, 1);
        while i <= edition as u16 {
            bits |= every << (Base::COUNT * i);
            i += 1;
        }
        Self { name: self.name, edition, bits }
    }

    /// Whether a type in an edition is one of them.
    #[inline]
    pub(crate) const fn contains(self, class: Class) -> bool {
        self.bits & class.0 != 0
    }
}
