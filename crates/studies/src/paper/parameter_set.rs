//! Parameters of a study as a user gives them: by name, in SI or as dimensionless groups.

mod caption;
mod name;
mod units;

pub use name::{Name, find_field, find_group, physical_parameters, short};
pub use units::{Quantity, Unit, number, numbers, quantity_in, typed_unit};

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use vibro_impact::parameters::{FIELDS, Field, GROUPS, Groups, Parameters, check_together};

/// Parameters of the 3-DOF machine in both forms, kept consistent.
///
/// Setting a group leaves the other groups unchanged; likewise for SI parameters. β² and α̂23 are
/// tied by β² = ε α̂23: when ε changes, the one set last (initially α̂23) keeps its value. μ13 =
/// 1/ε (m3 = m2, as in the paper) holds until `mu13` or `secondary.m` is set.
///
/// ```
/// use vibro_studies::paper::ParameterSet;
///
/// let mut set = ParameterSet::basic();
/// set.apply(&["alpha23=0.5", "epsilon=0.05"])?;
/// assert_eq!(set.groups().beta2, 0.05 * 0.5);
/// assert_eq!(set.parameters().coupling_stiffness, 0.05 * 0.5 * 0.05);
///
/// let error = set.apply(&["kapa=0.5"]).unwrap_err().to_string();
/// let problem = "no parameter is named `kapa`; did you mean `kappa`? `kappa`: restitution coefficient";
/// assert_eq!(error, format!("{problem}, 0 <= kappa <= 1"));
/// # Ok::<(), vibro_studies::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterSet {
    holds_beta2: bool,
    holds_mu13: bool,
    base: Base,
    given: Given,
    parameters: Parameters,
    groups: Groups,
    /// Display units of the parameters in labels.
    #[serde(default, skip_serializing_if = "units::Units::is_empty")]
    units: units::Units,
}

/// Source of the values that were not set.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Base {
    Basic,
    Strong,
}

/// Parameters that were set: one bit each, in the order of the lists.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Given {
    fields: u16,
    groups: u16,
}

impl Given {
    fn add(&mut self, name: Name) {
        match name {
            Name::Si(field) => self.fields |= bit(physical_parameters().map(|f| f.name), field.name),
            Name::Group(group) => self.groups |= bit(GROUPS.iter().map(|g| g.name), group.name),
        }
    }

    fn has(&self, name: &str) -> bool {
        let field = self.fields & bit(physical_parameters().map(|f| f.name), name);
        (field | self.groups & bit(GROUPS.iter().map(|g| g.name), name)) != 0
    }
}

/// Bit for a name's index in a list; 0 if the name is not in the list.
fn bit(mut names: impl Iterator<Item = &'static str>, name: &str) -> u16 {
    names.position(|n| n == name).map_or(0, |i| 1 << i)
}

/// Each group with the physical parameter that sets it and the other parameters that scale it:
/// docs/theory.md (21), (22).
const DEFINITIONS: [(&str, &str, &[&str]); 10] = [
    ("epsilon", "block.m", &["box.m"]),
    ("kappa", "stop.restitution", &[]),
    ("f10", "drive.amplitude", &["box.k", "stop.gap", "box.m", "block.m"]),
    ("sigma1", "drive.frequency", &["box.k", "box.m", "block.m"]),
    ("gamma1", "box.c", &["box.k", "box.m", "block.m"]),
    ("alpha23", "coupling.k", &["box.k", "box.m", "block.m"]),
    ("beta2", "coupling.k", &["box.k", "box.m", "block.m"]),
    ("sigma30", "secondary.k", &["secondary.m", "box.k", "box.m", "block.m"]),
    ("gamma3", "secondary.c", &["secondary.m", "box.k", "box.m", "block.m"]),
    ("mu13", "secondary.m", &["box.m"]),
];

impl ParameterSet {
    /// The set BASIC, docs/theory.md, end of section 4: ε, κ and f̂10 come from the paper, the
    /// other groups are a reconstruction.
    pub fn basic() -> Self {
        Self {
            parameters: Parameters::default(),
            groups: Groups::basic(),
            holds_beta2: false,
            holds_mu13: false,
            base: Base::Basic,
            given: Given::default(),
            units: units::Units::default(),
        }
    }

    /// The set STRONG, for the paper's section 5 (m3 = m1, strong coupling). Its numbers were
    /// chosen for this program, since the available copy of the paper lacks the published ones.
    ///
    /// # Errors
    /// None for these numbers.
    pub fn strong() -> Result<Self> {
        let groups = Groups { beta2: 0.3, alpha23: 3.0, mu13: 1.0, sigma30: 0.5, ..Groups::basic() };
        let base = Base::Strong;
        let parameters = groups.to_parameters(vibro_impact::Scales::default())?;
        Ok(Self { parameters, groups, holds_beta2: true, holds_mu13: true, base, ..Self::basic() })
    }

    /// The dimensionless groups.
    pub fn groups(&self) -> &Groups {
        &self.groups
    }

    /// The physical parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Whether a parameter was set, directly or through the other form: a group through any
    /// physical parameter in its definition, a physical parameter through its group.
    pub fn is_set(&self, name: Name) -> bool {
        let given = |name: &&str| self.given.has(name);
        let definitions = || DEFINITIONS.iter();
        match name {
            Name::Si(field) => {
                let own = || definitions().any(|d| d.1 == field.name && given(&d.0));
                given(&field.name) || own()
            }
            Name::Group(group) => {
                definitions()
                .filter(|d| d.0 == group.name)
                .any(|d| given(&d.0) || given(&d.1) || d.2.iter().any(given))
                // Two names of the coupling.
                || (group.name == "alpha23" && given(&"beta2"))
                || (group.name == "beta2" && given(&"alpha23"))
            }
        }
    }

    /// Name under which the first of these groups was set: the group's own name, or the name of
    /// the physical parameter that sets it.
    pub fn first_set(&self, groups: &[&str]) -> Option<Name> {
        let names = groups.iter().filter_map(|group| DEFINITIONS.iter().find(|d| d.0 == *group));
        let mut names = names.flat_map(|d| [d.0, d.1]);
        Name::find(names.find(|name| self.given.has(name))?).ok()
    }

    /// Whether a physical parameter was set, so that the machine is given in SI. Constant loads do
    /// not count, since their default is zero.
    pub fn is_si(&self) -> bool {
        self.given.fields & ((1 << FIELDS.len()) - 1) != 0
    }

    /// Refuses constant loads, and a load among the parameters that vary: closed forms and
    /// theories hold for the symmetric machine.
    ///
    /// # Errors
    /// [`vibro_impact::Error::OutOfRange`] with the load's value, or [`Error::Form`] with the name
    /// of a load that varies.
    pub fn check_symmetric(&self, varied: impl IntoIterator<Item = Name>) -> Result<()> {
        self.parameters.check_symmetric()?;
        match varied.into_iter().find(|name| name.is_load()) {
            None => Ok(()),
            Some(load) => Err(Error::Form {
                text: load.name().into(),
                expected: "another parameter: closed forms and theories describe the machine \
                           without constant loads",
            }),
        }
    }

    /// Physical parameters left at default values although others were set, so that the machine is
    /// a mixture. Parameters that a group determines, and the drive's phase, are excluded.
    pub fn not_given(&self) -> Vec<Name> {
        let fixed = |f: &&'static Field| self.is_set(Name::Si(f)) || f.name == "drive.phase";
        let missing = FIELDS.iter().filter(|f| self.is_si() && !fixed(f));
        missing.map(Name::Si).collect()
    }

    fn tie(&self, mut g: Groups, changed: &str) -> Groups {
        if changed == "epsilon" && !self.holds_mu13 {
            g.mu13 = 1.0 / g.epsilon;
        }
        if changed == "beta2" || (self.holds_beta2 && changed == "epsilon") {
            g.alpha23 = g.beta2 / g.epsilon;
        } else if changed == "alpha23" || changed == "epsilon" {
            g.beta2 = g.epsilon * g.alpha23;
        }
        g
    }

    /// The parameter set with one parameter of either form changed. All variation of parameters
    /// uses this function.
    ///
    /// # Errors
    /// The range that the value violates.
    pub fn with(&self, name: impl Into<Name>, value: f64) -> vibro_impact::Result<Self> {
        self.changed(&[(name.into(), value)])
    }

    /// The groups with one parameter of either form changed. If it is a group, the physical
    /// parameters are not computed: theories in groups alone do not need them, and the conversion
    /// would take a fifth of the time of a plane.
    ///
    /// # Errors
    /// The range that the value violates.
    pub fn groups_with(&self, name: impl Into<Name>, value: f64) -> vibro_impact::Result<Groups> {
        match name.into() {
            Name::Group(group) => {
                group.check(value)?;
                let mut groups = self.groups;
                (group.set)(&mut groups, value);
                let groups = self.tie(groups, group.name);
                check_together(&groups)?;
                Ok(groups)
            }
            name => Ok(self.with(name, value)?.groups),
        }
    }

    /// The physical parameters with these groups, and with the scales, the drive phase and the
    /// constant loads of this parameter set.
    ///
    /// # Errors
    /// As [`Groups::to_parameters`].
    pub fn parameters_of(&self, groups: &Groups) -> vibro_impact::Result<Parameters> {
        let Parameters { drive_phase, constant_loads, .. } = self.parameters;
        Ok(Parameters { drive_phase, constant_loads, ..groups.to_parameters(self.parameters.scales())? })
    }

    /// Applies texts of the form `name=value`, in order. A number without a unit is in the unit
    /// last [written](Self::unit) for its parameter, otherwise in SI. Axes follow the same rule.
    ///
    /// ```
    /// use vibro_studies::paper::ParameterSet;
    ///
    /// let mut set = ParameterSet::basic();
    /// set.apply(&["drive.frequency=10 Hz", "box.m=12"])?;
    /// set.apply(&["drive.frequency=11"])?;
    /// assert_eq!(set.parameters().drive_frequency, 22.0 * std::f64::consts::PI);
    /// # Ok::<(), vibro_studies::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Form`], [`Error::UnknownName`], [`Error::NotANumber`], [`Error::Unit`] or the
    /// range that a value violates.
    pub fn apply<T: AsRef<str>>(&mut self, assignments: &[T]) -> Result<()> {
        let mut next = self.clone();
        let mut parsed = Vec::with_capacity(assignments.len());
        for text in assignments {
            let text = text.as_ref();
            let form = || Error::Form { text: text.into(), expected: "name=value, e.g. kappa=0.75" };
            let (name, value) = text.split_once('=').ok_or_else(form)?;
            let name = Name::find(name.trim())?;
            let quantity = next.quantity(name, value)?;
            next.show_in(name, quantity.unit);
            parsed.push((name, quantity.value));
        }
        next.assign(&parsed)?;
        *self = next;
        Ok(())
    }

    /// Quantity from a text. A number without a unit is in the unit last [written](Self::unit) for
    /// the parameter, otherwise in SI.
    ///
    /// # Errors
    /// As [`number`].
    pub fn quantity(&self, name: Name, text: &str) -> Result<Quantity> {
        let unit = typed_unit(name, text);
        let value = number(name, text)?;
        Ok(match (unit, self.unit(name)) {
            (None, Some(own)) => Quantity { value: own.si(value), unit: Some(own) },
            _ => Quantity { value, unit },
        })
    }

    /// Sets the display unit of a physical parameter in labels and captions. `None` or a unit of
    /// another dimension changes nothing.
    pub fn show_in(&mut self, name: Name, unit: Option<&'static Unit>) {
        if let (Name::Si(field), Some(unit)) = (name, unit) {
            self.units.set(field.name, unit.plain());
        }
    }

    /// Applies values in order. Pending groups are converted to SI only before an SI parameter and
    /// at the end, so that the order of two groups does not matter.
    ///
    /// # Errors
    /// The range that a value violates; then nothing is changed.
    pub fn assign(&mut self, assignments: &[(Name, f64)]) -> Result<()> {
        *self = self.changed(assignments)?;
        Ok(())
    }

    fn changed(&self, assignments: &[(Name, f64)]) -> vibro_impact::Result<Self> {
        let mut next = self.clone();
        let mut pending = false;
        for &(name, value) in assignments {
            name.check(value)?;
            next.given.add(name);
            match name {
                Name::Group(group) => {
                    match group.name {
                        "beta2" => next.holds_beta2 = true,
                        "alpha23" => next.holds_beta2 = false,
                        "mu13" => next.holds_mu13 = true,
                        _ => {}
                    }
                    (group.set)(&mut next.groups, value);
                    next.groups = next.tie(next.groups, group.name);
                    pending = true;
                }
                Name::Si(field) => {
                    if pending {
                        next.refresh()?;
                        pending = false;
                    }
                    next.holds_mu13 |= field.name == "secondary.m";
                    (field.set)(&mut next.parameters, value);
                    next.groups = next.parameters.groups()?;
                }
            }
        }
        if pending {
            next.refresh()?;
        }
        Ok(next)
    }

    fn refresh(&mut self) -> vibro_impact::Result<()> {
        check_together(&self.groups)?;
        self.parameters = self.parameters_of(&self.groups)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests;
