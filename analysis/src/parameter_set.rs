//! The parameters of an analysis as a user gives them: by name, in SI or as dimensionless groups.

use super::error::{Error, Result};
use serde::{Deserialize, Serialize};
use vibro_impact::parameters::{FIELDS, Field, GROUPS, Group, Groups, Parameters, check_together};

/// A parameter of either form.
#[derive(Clone, Copy, Debug)]
pub enum Name {
    /// A physical parameter.
    Si(&'static Field),
    /// A dimensionless group.
    Group(&'static Group),
}

/// Parameters in both forms, kept in step.
///
/// Setting a group leaves the other groups as they are, setting an SI parameter the other SI parameters. Three
/// groups are tied: β² = ε α̂23, of which the one set last is held when ε changes (α̂23 to begin with); and
/// μ13 = 1/ε (m3 = m2, as the paper has it) until `mu13` or `secondary.m` is set.
///
/// ```
/// use vibro_analysis::ParameterSet;
///
/// let mut set = ParameterSet::basic();
/// set.apply(&["alpha23=0.5", "epsilon=0.05"])?;
/// assert_eq!(set.groups().beta2, 0.05 * 0.5);
/// assert_eq!(set.parameters().coupling_stiffness, 0.05 * 0.5 * 0.05);
///
/// let error = set.apply(&["kapa=0.5"]).unwrap_err().to_string();
/// assert_eq!(error, "no parameter is named `kapa`; the nearest is `kappa`: restitution coefficient, 0 <= kappa <= 1");
/// # Ok::<(), vibro_analysis::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterSet {
    holds_beta2: bool,
    holds_mu13: bool,
    base: Base,
    changed: bool,
    parameters: Parameters,
    groups: Groups,
}

/// The set that values come from which are not set.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Base {
    Basic,
    Strong,
}

impl Base {
    fn name(self) -> &'static str {
        match self {
            Self::Basic => "BASIC, a reconstruction, not the paper's own data set",
            Self::Strong => "STRONG, a set of ours, not the paper's own data set",
        }
    }
}

impl Name {
    /// Finds a parameter by its name.
    ///
    /// # Errors
    /// [`Error::UnknownName`] with the nearest valid name.
    pub fn find(name: &str) -> Result<Self> {
        if let Some(group) = Group::named(name) {
            return Ok(Self::Group(group));
        }
        if let Some(field) = FIELDS.iter().find(|f| f.name == name) {
            return Ok(Self::Si(field));
        }
        Err(unknown(name, &all_names()))
    }

    /// The name itself.
    pub fn name(self) -> &'static str {
        match self {
            Self::Si(f) => f.name,
            Self::Group(g) => g.name,
        }
    }

    fn description(self) -> &'static str {
        match self {
            Self::Si(f) => f.description,
            Self::Group(g) => g.description,
        }
    }

    fn allowed(self) -> &'static str {
        match self {
            Self::Si(f) => f.range.allowed,
            Self::Group(g) => g.range.allowed,
        }
    }
}

/// The group of a name; an SI name is refused with the nearest group.
///
/// # Errors
/// [`Error::UnknownName`].
pub fn find_group(name: &str) -> Result<&'static Group> {
    let groups: Vec<Name> = GROUPS.iter().map(Name::Group).collect();
    Group::named(name).ok_or_else(|| unknown(name, &groups))
}

/// The physical parameter of a structured name; a group's name is refused with the nearest physical parameter.
///
/// # Errors
/// [`Error::UnknownName`].
pub fn find_field(name: &str) -> Result<&'static Field> {
    let fields: Vec<Name> = FIELDS.iter().map(Name::Si).collect();
    FIELDS.iter().find(|f| f.name == name).ok_or_else(|| unknown(name, &fields))
}

fn all_names() -> Vec<Name> {
    GROUPS.iter().map(Name::Group).chain(FIELDS.iter().map(Name::Si)).collect()
}

fn unknown(name: &str, valid: &[Name]) -> Error {
    let lower = name.to_lowercase();
    let distance = |n: &Name| strsim::damerau_levenshtein(&lower, n.name());
    // The lists are never empty.
    let nearest = valid.iter().copied().min_by_key(distance).unwrap_or(Name::Group(&GROUPS[0]));
    Error::UnknownName {
        name: name.into(),
        nearest: nearest.name(),
        description: nearest.description(),
        allowed: nearest.allowed(),
    }
}

/// A number, or an error that names the parameter and its range.
///
/// # Errors
/// [`Error::NotANumber`].
pub fn number(name: Name, text: &str) -> Result<f64> {
    let text = text.trim();
    text.parse().map_err(|_| Error::NotANumber {
        name: name.name(),
        text: text.into(),
        allowed: name.allowed(),
    })
}

impl ParameterSet {
    /// The set BASIC, docs/theory.md, end of section 4: ε, κ and f̂10 are the paper's, the other groups a reconstruction.
    pub fn basic() -> Self {
        Self {
            parameters: Parameters::default(),
            groups: Groups::basic(),
            holds_beta2: false,
            holds_mu13: false,
            base: Base::Basic,
            changed: false,
        }
    }

    /// The set STRONG, for the paper's section 5 (m3 = m1, strong coupling). Its numbers are chosen for this program, since
    /// the copy of the paper this work was built from lacks the displayed ones.
    ///
    /// # Errors
    /// None for these numbers.
    pub fn strong() -> Result<Self> {
        let groups = Groups { beta2: 0.3, alpha23: 3.0, mu13: 1.0, sigma30: 0.5, ..Groups::basic() };
        let base = Base::Strong;
        let parameters = groups.to_parameters(vibro_impact::Scales::default())?;
        Ok(Self { parameters, groups, holds_beta2: true, holds_mu13: true, base, changed: false })
    }

    /// The dimensionless groups.
    pub fn groups(&self) -> &Groups {
        &self.groups
    }

    /// The physical parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Where these numbers come from, in the words of a caption.
    pub fn origin(&self) -> String {
        if self.changed {
            format!("what was not set is {}", self.base.name())
        } else {
            self.base.name().into()
        }
    }

    /// The groups in one line, with the origin.
    pub fn caption(&self) -> String {
        let g = &self.groups;
        let shown = |group: &&Group| match group.name {
            // Of the two names for the coupling, the one that is held.
            "alpha23" => !self.holds_beta2,
            "beta2" => self.holds_beta2,
            "mu13" => self.holds_mu13,
            _ => true,
        };
        let values = GROUPS.iter().filter(shown).map(|x| format!("{} = {}", x.symbol, short((x.get)(g))));
        format!("{} ({})", values.collect::<Vec<_>>().join(", "), self.origin())
    }

    /// The groups with one of them changed, the tied ones following.
    pub fn vary(&self, group: &Group, value: f64) -> Groups {
        let mut g = self.groups;
        (group.set)(&mut g, value);
        self.tie(g, group.name)
    }

    /// The set with one group changed, for [`Self::vary`] over a second group. Its physical parameters do not follow.
    pub(super) fn with_groups_only(&self, group: &Group, value: f64) -> Self {
        Self { groups: self.vary(group, value), ..self.clone() }
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

    /// The parameter set with one group changed.
    ///
    /// # Errors
    /// As [`Self::apply`].
    pub fn with(&self, group: &'static Group, value: f64) -> Result<Self> {
        let mut set = self.clone();
        set.assign(&[(Name::Group(group), value)])?;
        Ok(set)
    }

    /// The physical parameters with these groups, in the scales and with the drive phase of this parameter set.
    ///
    /// # Errors
    /// As [`Groups::to_parameters`].
    pub fn parameters_of(&self, groups: &Groups) -> vibro_impact::Result<Parameters> {
        let drive_phase = self.parameters.drive_phase;
        Ok(Parameters { drive_phase, ..groups.to_parameters(self.parameters.scales())? })
    }

    /// Applies texts of the form `name=value`, in order.
    ///
    /// # Errors
    /// [`Error::Form`], [`Error::UnknownName`], [`Error::NotANumber`] or the range that a value violates.
    pub fn apply<T: AsRef<str>>(&mut self, assignments: &[T]) -> Result<()> {
        let parse = |text: &T| {
            let text = text.as_ref();
            let form = || Error::Form { text: text.into(), expected: "name=value, e.g. kappa=0.75" };
            let (name, value) = text.split_once('=').ok_or_else(form)?;
            let name = Name::find(name.trim())?;
            Ok((name, number(name, value)?))
        };
        self.assign(&assignments.iter().map(parse).collect::<Result<Vec<_>>>()?)
    }

    /// Applies values in order. The groups are turned into SI only where SI follows and at the end, so that the order of
    /// two groups does not matter.
    ///
    /// # Errors
    /// The range that a value violates; nothing is changed then.
    pub fn assign(&mut self, assignments: &[(Name, f64)]) -> Result<()> {
        let mut next = self.clone();
        let mut pending = false;
        for &(name, value) in assignments {
            next.changed = true;
            match name {
                Name::Group(group) => {
                    group.check(value)?;
                    match group.name {
                        "beta2" => next.holds_beta2 = true,
                        "alpha23" => next.holds_beta2 = false,
                        "mu13" => next.holds_mu13 = true,
                        _ => {}
                    }
                    next.groups = next.vary(group, value);
                    pending = true;
                }
                Name::Si(field) => {
                    field.check(value)?;
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
        *self = next;
        Ok(())
    }

    fn refresh(&mut self) -> Result<()> {
        check_together(&self.groups)?;
        self.parameters = self.parameters_of(&self.groups)?;
        Ok(())
    }
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

#[cfg(test)]
mod tests;
