//! The machine of a study for manifests, tables and captions: the 3-DOF machine by its parameter
//! set, a described machine by its file.

use std::collections::BTreeMap;
use vibro_impact::parameters::{FIELDS, LOADS};
use vibro_machine::description::Description;
use vibro_studies::paper::{GROUPS, Name, ParameterSet, Unit, physical_parameters};
use vibro_studies::significant;
use vibro_studies::{Section, SectionRule};

/// Properties of a machine that manifests, tables and captions state.
pub trait Subject: Sync {
    /// Parameters in SI by name, and dimensionless groups by name.
    fn numbers(&self) -> (BTreeMap<String, f64>, BTreeMap<String, f64>);

    /// Properties other than numbers that affect results, by option name: structure and section.
    fn structure(&self) -> BTreeMap<String, String>;

    /// Parameters in one line.
    fn caption(&self) -> String;

    /// Written unit of this column's parameter, if it is not SI. The table then has a second
    /// column in this unit.
    fn unit_of_column(&self, column: &str) -> Option<&'static Unit>;
}

impl Subject for ParameterSet {
    fn numbers(&self) -> (BTreeMap<String, f64>, BTreeMap<String, f64>) {
        let (parameters, groups) = (self.parameters(), self.groups());
        let loads = LOADS.iter().filter(|load| (load.get)(parameters) != 0.0);
        let si = FIELDS.iter().chain(loads).map(|f| (f.name.into(), (f.get)(parameters)));
        (si.collect(), GROUPS.iter().map(|g| (g.name.into(), (g.get)(groups))).collect())
    }

    fn structure(&self) -> BTreeMap<String, String> {
        BTreeMap::new()
    }

    fn caption(&self) -> String {
        self.caption()
    }

    /// Columns are named after the parameter: `drive.frequency`, `drive.frequency_from`,
    /// `drive.frequency_to`, `amplitude.x1.max.drive.frequency`.
    fn unit_of_column(&self, column: &str) -> Option<&'static Unit> {
        let plain = column.strip_suffix("_from").or_else(|| column.strip_suffix("_to")).unwrap_or(column);
        let plain = plain.split_once(".max.").map_or(plain, |(_, name)| name);
        let name = physical_parameters().find(|field| field.name == plain).map(Name::Si)?;
        self.unit(name).filter(|unit| !unit.is_si())
    }
}

/// Name of the parts of a machine that have the common period.
pub(crate) fn periodic_parts(d: &Description) -> &'static str {
    if d.signals().any(|s| s.signal.repeat.is_some()) { "signals" } else { "harmonics" }
}

impl Subject for vibro_studies::Machine {
    fn numbers(&self) -> (BTreeMap<String, f64>, BTreeMap<String, f64>) {
        let parameters = self.description.parameters();
        (parameters.into_iter().map(|p| (p.name, p.value)).collect(), BTreeMap::new())
    }

    fn structure(&self) -> BTreeMap<String, String> {
        BTreeMap::from([
            ("machine".into(), self.description.to_toml()),
            ("section".into(), in_words(&self.section)),
        ])
    }

    fn caption(&self) -> String {
        let d = &self.description;
        let section = vibro_studies::Section::of(d, &self.section);
        let section = section.map_or(String::new(), |s| match (s, &self.section) {
            // A study may vary the frequencies.
            (Section::Period(period), SectionRule::Auto) => {
                let (period, what) = (significant(period), periodic_parts(d));
                format!(", sampled once per common period of its {what} (at present {period} s)")
            }
            _ => format!(", sampled at {}", s.in_words(d)),
        });
        format!("{}{section}", self.name_with_changes())
    }

    fn unit_of_column(&self, column: &str) -> Option<&'static Unit> {
        let plain = column.strip_suffix("_from").or_else(|| column.strip_suffix("_to")).unwrap_or(column);
        self.written_unit(plain).filter(|unit| !unit.is_si())
    }
}

/// The rule of a section, written as the options that set it.
fn in_words(rule: &SectionRule) -> String {
    match rule {
        SectionRule::Auto => "by the drive or the first stop".into(),
        SectionRule::Period(period) => format!("--period {period:?} s"),
        SectionRule::Element(name) => name.clone(),
    }
}
