//! Captions of a parameter set.

use super::{Base, Given, Name, ParameterSet, Unit};
use crate::significant;
use vibro_impact::parameters::{FIELDS, GROUPS, Group, LOADS};

/// Relative tolerance for the rounding of a unit conversion and its inverse.
const ROUNDING: f64 = 1e-12;

impl Base {
    fn name(self) -> &'static str {
        match self {
            Self::Basic => "the default set, a reconstruction, not the paper's own data",
            Self::Strong => "the strongly coupled set, chosen for this program, not the paper's own data",
        }
    }
}

impl ParameterSet {
    /// Source of the numbers, for a caption. For a machine in SI it lists the parameters that were
    /// not given, with the values used.
    pub fn origin(&self) -> String {
        let base = self.base.name();
        let taken = self.not_given_values();
        match (self.given == Given::default(), self.is_si(), taken.is_empty()) {
            (true, ..) => base.into(),
            (false, false, _) => format!("what was not set is {base}"),
            (false, true, true) => "all set".into(),
            (false, true, false) => format!("not given, and taken from {base}: {taken}"),
        }
    }

    /// The physical parameters that were [not given](Self::not_given), with the values used, in
    /// one line.
    pub fn not_given_values(&self) -> String {
        let told = |name: Name| format!("{} = {}", name.name(), name.with_unit(name.value(self)));
        self.not_given().into_iter().map(told).collect::<Vec<_>>().join(", ")
    }

    /// The parameters in one line, with their source: in SI if the machine was given in SI,
    /// otherwise as groups.
    pub fn caption(&self) -> String {
        self.caption_but(&[])
    }

    /// The [caption](Self::caption) without the parameters that change when `varied` changes, so
    /// that it holds for every curve.
    pub fn caption_but(&self, varied: &[Name]) -> String {
        let others: Vec<Self> = varied.iter().filter_map(|name| self.other(*name)).collect();
        let same = |name: &Name| {
            let own = name.value(self);
            let close = |other: &Self| (name.value(other) - own).abs() <= ROUNDING * (1.0 + own.abs());
            !varied.contains(name) && others.iter().all(close)
        };
        let mut names: Vec<Name> = if self.is_si() {
            FIELDS.iter().map(Name::Si).collect()
        } else {
            GROUPS.iter().filter(|g| self.is_held(g)).map(Name::Group).collect()
        };
        // Loads are listed if they are not zero.
        names.extend(LOADS.iter().map(Name::Si).filter(|load| load.value(self) != 0.0));
        let told = |name: Name| self.told(name, name.value(self));
        let values: Vec<String> = names.into_iter().filter(same).map(told).collect();
        format!("{} ({})", values.join(", "), self.origin())
    }

    /// Written unit of a physical parameter, if it had one.
    pub fn unit(&self, name: Name) -> Option<&'static Unit> {
        match name {
            Name::Si(field) => self.units.get(field.name),
            Name::Group(_) => None,
        }
    }

    /// The symbol of a parameter for labels; a frequency in Hz is ω1/2π.
    pub fn symbol(&self, name: Name) -> String {
        let cyclic = self.unit(name).is_some_and(Unit::counts_revolutions);
        format!("{}{}", name.symbol(), if cyclic { "/2π" } else { "" })
    }

    /// Label of an axis: the symbol, and the parameter's written unit or its SI unit.
    pub fn label(&self, name: Name) -> String {
        let unit = self.unit(name).map(Unit::symbol).filter(|symbol| symbol != "1");
        unit.map_or_else(|| name.label(), |unit| format!("{} ({unit})", self.symbol(name)))
    }

    /// A value of a parameter, given in SI, shown in the parameter's written unit or in its SI
    /// unit.
    pub fn with_unit(&self, name: Name, value: f64) -> String {
        let in_unit = |u: &Unit| format!("{} {}", significant(u.number(value)), u.symbol());
        self.unit(name).filter(|u| u.plain() != "1").map_or_else(|| name.with_unit(value), in_unit)
    }

    /// Symbol and value of a parameter, given in SI: `k₁ = 48 kN/m`.
    ///
    /// ```
    /// use vibro_studies::paper::{Name, ParameterSet};
    ///
    /// let mut set = ParameterSet::basic();
    /// set.apply(&["box.k=48 kN/m", "omega1=10.4Hz"])?;
    /// assert_eq!(set.told(Name::find("k1")?, 48_000.0), "k₁ = 48 kN/m");
    /// assert_eq!(set.label(Name::find("omega1")?), "ω₁/2π (Hz)");
    /// # Ok::<(), vibro_studies::Error>(())
    /// ```
    pub fn told(&self, name: Name, value: f64) -> String {
        format!("{} = {}", self.symbol(name), self.with_unit(name, value))
    }

    /// Whether a caption lists a group. The caption lists the one name of the coupling that is
    /// held constant, and μ13 only if it is held.
    fn is_held(&self, group: &Group) -> bool {
        match group.name {
            "alpha23" => !self.holds_beta2,
            "beta2" => self.holds_beta2,
            "mu13" => self.holds_mu13,
            _ => true,
        }
    }

    /// The set with another value of one parameter, to find what changes with it.
    fn other(&self, name: Name) -> Option<Self> {
        let own = name.value(self);
        let near = [1.01 * own + 0.01, 0.99 * own - 0.01, 0.99 * own];
        near.into_iter().find_map(|value| self.with(name, value).ok())
    }
}
