//! Types of variables for getters and setters, and dependencies between variables.

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

/// The types that one kind of getter and setter accesses. An interface standard determines them.
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

    /// Whether the set contains a type.
    #[inline]
    pub const fn contains(self, base: Base) -> bool {
        self.bits & (1 << base as u8) != 0
    }
}

/// Kind of dependency of an unknown on a known (FMI 2.0, 2.2.8; FMI 3.0.2, 2.4.8).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DependencyKind {
    /// No particular structure.
    Dependent,
    /// A constant factor.
    Constant,
    /// A factor that depends on fixed parameters only.
    Fixed,
    /// A factor that depends on parameters, also on tunable ones.
    Tunable,
    /// A factor that changes at events.
    Discrete,
}

impl DependencyKind {
    /// Name in the standard.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Dependent => "dependent",
            Self::Constant => "constant",
            Self::Fixed => "fixed",
            Self::Tunable => "tunable",
            Self::Discrete => "discrete",
        }
    }
}

/// An entry of the dependencies of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dependency {
    /// The element that depends, counted from 1; 0 means the whole variable.
    pub element: usize,
    /// Value reference of the known on which it depends.
    pub reference: u32,
    /// Kind of dependency.
    pub kind: DependencyKind,
}
