//! Names of parameters: structured names, names of groups, and the paper's symbols.

use super::{DEFINITIONS, ParameterSet};
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use vibro_impact::parameters::{FIELDS, Field, GROUPS, Group, LOADS};

/// A parameter of either form. Serialized as its name.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Name {
    /// A physical parameter.
    Si(&'static Field),
    /// A dimensionless group.
    Group(&'static Group),
}

impl PartialEq for Name {
    /// Names are unique.
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl From<&'static Group> for Name {
    fn from(group: &'static Group) -> Self {
        Self::Group(group)
    }
}

impl From<&'static Field> for Name {
    fn from(field: &'static Field) -> Self {
        Self::Si(field)
    }
}

impl TryFrom<String> for Name {
    type Error = Error;

    fn try_from(name: String) -> Result<Self> {
        Self::find(&name)
    }
}

impl From<Name> for String {
    fn from(name: Name) -> Self {
        name.name().into()
    }
}

/// Other spellings of parameters: pairs of symbol and name. Case matters: `F10` is the force in N,
/// `f10` its group.
#[rustfmt::skip]
const ALIASES: [(&str, &str); 41] = [
    ("m1", "box.m"), ("k1", "box.k"), ("c1", "box.c"), ("m2", "block.m"), ("m3", "secondary.m"),
    ("k3", "secondary.k"), ("c3", "secondary.c"), ("k23", "coupling.k"), ("L", "stop.gap"), ("F10", "drive.amplitude"),
    ("omega1", "drive.frequency"), ("ω1", "drive.frequency"), ("ω₁", "drive.frequency"), ("phase", "drive.phase"),
    ("m₁", "box.m"), ("k₁", "box.k"), ("c₁", "box.c"), ("m₂", "block.m"), ("m₃", "secondary.m"),
    ("k₃", "secondary.k"), ("c₃", "secondary.c"), ("k₂₃", "coupling.k"), ("F₁₀", "drive.amplitude"),
    ("eps", "epsilon"), ("ε", "epsilon"), ("κ", "kappa"), ("σ1", "sigma1"), ("σ₁", "sigma1"), ("γ1", "gamma1"),
    ("γ₁", "gamma1"), ("α23", "alpha23"), ("α₂₃", "alpha23"), ("β2", "beta2"), ("β²", "beta2"), ("σ30", "sigma30"),
    ("σ₃₀", "sigma30"), ("γ3", "gamma3"), ("γ₃", "gamma3"), ("μ13", "mu13"), ("μ₁₃", "mu13"), ("f₁₀", "f10"),
];

/// Symbols of the physical parameters, in the order of [`physical_parameters`].
const SYMBOLS: [&str; FIELDS.len() + LOADS.len()] = [
    "m₁",
    "k₁",
    "c₁",
    "m₂",
    "m₃",
    "k₃",
    "c₃",
    "k₂₃",
    "L",
    "κ",
    "F₁₀",
    "ω₁",
    "drive phase",
    "load on box",
    "load on block",
    "load on secondary",
];

/// All physical parameters: first the machine's, then the constant loads.
pub fn physical_parameters() -> impl Iterator<Item = &'static Field> + Clone {
    FIELDS.iter().chain(&LOADS)
}

impl Name {
    /// Finds a parameter by its name or its symbol in the paper, e.g. `box.m` or `m1`, `kappa` or
    /// `κ`.
    ///
    /// # Errors
    /// [`Error::UnknownName`] with the nearest valid name, if one is near.
    pub fn find(name: &str) -> Result<Self> {
        exact(name).ok_or_else(|| unknown(name, &all_names()))
    }

    /// The name as text.
    pub fn name(self) -> &'static str {
        match self {
            Self::Si(f) => f.name,
            Self::Group(g) => g.name,
        }
    }

    /// The paper's symbol, for labels.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Si(field) => {
                // Every field is in the list.
                let found = physical_parameters().zip(SYMBOLS).find(|(f, _)| f.name == field.name);
                found.map_or(field.name, |f| f.1)
            }
            Self::Group(g) => g.symbol,
        }
    }

    /// Whether the parameter is a constant load, under which the machine has no symmetry.
    pub fn is_load(self) -> bool {
        LOADS.iter().any(|load| load.name == self.name())
    }

    /// The SI unit; `1` for groups.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Si(f) => f.unit,
            Self::Group(_) => "1",
        }
    }

    /// Label of an axis: symbol and unit.
    pub fn label(self) -> String {
        match self {
            Self::Group(g) => g.label(),
            Self::Si(f) if f.unit == "1" => format!("{} (–)", self.symbol()),
            Self::Si(f) => format!("{} ({})", self.symbol(), f.unit.replace('.', "·")),
        }
    }

    /// A value with the unit, for captions and messages.
    pub fn with_unit(self, value: f64) -> String {
        match self.unit() {
            "1" => short(value),
            unit => format!("{} {}", crate::significant(value), unit.replace('.', "·")),
        }
    }

    /// The value in a parameter set.
    pub fn value(self, set: &ParameterSet) -> f64 {
        match self {
            Self::Si(f) => (f.get)(set.parameters()),
            Self::Group(g) => (g.get)(set.groups()),
        }
    }

    /// The default range of pictures: a group's own, and all phases or restitution coefficients.
    /// For other physical parameters 50 % to 150 % of the value or, if it is zero, 0 to 1.
    pub fn shown(self, set: &ParameterSet) -> (f64, f64) {
        match self {
            Self::Group(g) => g.shown,
            Self::Si(f) if f.name == "drive.phase" => (0.0, std::f64::consts::TAU),
            Self::Si(f) if f.name == "stop.restitution" => (0.0, 1.0),
            Self::Si(_) => match self.value(set) {
                0.0 => (0.0, 1.0),
                value if value < 0.0 => (1.5 * value, 0.5 * value),
                value => (0.5 * value, 1.5 * value),
            },
        }
    }

    /// Whether another name is the same quantity in another form, so that the two cannot vary
    /// independently.
    pub fn is_same_quantity(self, other: Self) -> bool {
        let field = |name: Self| match name {
            Self::Si(field) => field.name,
            // Every group is in the list.
            Self::Group(group) => DEFINITIONS.iter().find(|d| d.0 == group.name).map_or(group.name, |d| d.1),
        };
        field(self) == field(other)
    }

    /// Checks a value against the parameter's range.
    ///
    /// # Errors
    /// [`vibro_impact::Error::OutOfRange`] naming this parameter.
    pub fn check(self, value: f64) -> vibro_impact::Result<()> {
        match self {
            Self::Si(f) => f.check(value),
            Self::Group(g) => g.check(value),
        }
    }

    /// Description in a few words.
    pub fn description(self) -> &'static str {
        match self {
            Self::Si(f) => f.description,
            Self::Group(g) => g.description,
        }
    }

    /// Description of the range.
    pub fn allowed(self) -> &'static str {
        match self {
            Self::Si(f) => f.range.allowed,
            Self::Group(g) => g.range.allowed,
        }
    }
}

/// The group with a name; an SI name is refused with the nearest group.
///
/// # Errors
/// [`Error::UnknownName`].
pub fn find_group(name: &str) -> Result<&'static Group> {
    let groups: Vec<Name> = GROUPS.iter().map(Name::Group).collect();
    match exact(name) {
        Some(Name::Group(group)) => Ok(group),
        _ => Err(unknown(name, &groups)),
    }
}

/// The physical parameter with a structured name; a group's name is refused with the nearest
/// physical parameter.
///
/// # Errors
/// [`Error::UnknownName`].
pub fn find_field(name: &str) -> Result<&'static Field> {
    let fields: Vec<Name> = physical_parameters().map(Name::Si).collect();
    match exact(name) {
        Some(Name::Si(field)) => Ok(field),
        _ => Err(unknown(name, &fields)),
    }
}

fn exact(name: &str) -> Option<Name> {
    // The paper's hats are dropped: σ̂1 is σ1.
    let plain = name.replace('\u{302}', "");
    let name = ALIASES.iter().find(|a| a.0 == plain).map_or(name, |a| a.1);
    let field = || physical_parameters().find(|f| f.name == name).map(Name::Si);
    Group::named(name).map(Name::Group).or_else(field)
}

fn all_names() -> Vec<Name> {
    GROUPS.iter().map(Name::Group).chain(physical_parameters().map(Name::Si)).collect()
}

fn unknown(name: &str, valid: &[Name]) -> Error {
    let lower = name.to_lowercase();
    let distance = |n: &Name| strsim::damerau_levenshtein(&lower, n.name());
    // A name that differs in more than half of its letters is another word.
    let far = (name.chars().count() / 2).max(1);
    let nearest = valid.iter().copied().min_by_key(distance).filter(|n| distance(n) <= far);
    let advice = match nearest {
        Some(n) => format!("did you mean `{0}`? `{0}`: {1}, {2}", n.name(), n.description(), n.allowed()),
        None => {
            let names: Vec<_> = valid.iter().map(|n| n.name()).collect();
            format!("expected one of {}", names.join(", "))
        }
    };
    Error::UnknownName { name: name.into(), advice }
}

/// A number for captions: four decimals at most, a true minus sign.
pub fn short(value: f64) -> String {
    let rounded = (value * 1e4).round() / 1e4;
    if rounded == 0.0 && value != 0.0 || value.abs() >= 1e6 {
        format!("{value:.3e}").replace('-', "−")
    } else {
        // Adding zero turns -0 into 0.
        format!("{}", rounded + 0.0).replace('-', "−")
    }
}
