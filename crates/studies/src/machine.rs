//! Machine from a description, with the rule of its section and the units of its parameters.

use crate::Section;
use crate::SectionRule;
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use vibro_machine::description::{Body, Description};
use vibro_machine::start::BodyStart;
use vibro_machine::{Assembly, Motion, file};
use vibro_machine::{Refusal, Start};
use vibro_numerics::quantities::{Unit, quantity_in};

/// Described machine with its section and the units of its written parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct Machine {
    /// Bodies and elements.
    pub description: Description,
    /// Rule of the section.
    pub section: SectionRule,
    /// Display unit of each parameter that is not shown in SI.
    pub units: BTreeMap<String, String>,
    /// Text of each value that differs from the file, by parameter.
    pub changes: BTreeMap<String, String>,
}

/// Serialized form of a machine: the text of its file.
#[derive(Serialize, Deserialize)]
struct Written {
    file: String,
    section: SectionRule,
    units: BTreeMap<String, String>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    changes: BTreeMap<String, String>,
}

impl From<Machine> for Written {
    fn from(machine: Machine) -> Self {
        let Machine { description, section, units, changes } = machine;
        Self { file: description.to_toml(), section, units, changes }
    }
}

impl TryFrom<Written> for Machine {
    type Error = Error;

    fn try_from(written: Written) -> Result<Self> {
        let description = file::parse(&written.file, "machine", &file::no_records)?;
        let Written { section, units, changes, .. } = written;
        Ok(Self { description, section, units, changes })
    }
}

/// Tolerance for the rounding of a gap's violation, relative to the terms of e - gap.
const ROUNDING: f64 = 1e-12;

impl Machine {
    /// A machine with the default section and SI units.
    pub fn new(description: Description) -> Self {
        Self { description, section: SectionRule::Auto, units: BTreeMap::new(), changes: BTreeMap::new() }
    }

    /// Name of the machine, with the values that differ from its file.
    ///
    /// ```
    /// # use vibro_studies::Machine;
    /// # let text = "name = \"Pendulum\"\nbody.a = { mass = 1.0 }\n\
    /// #     spring.s = { between = [\"ground\", \"a\"], stiffness = 1.0 }";
    /// # let mut machine =
    /// #     Machine::parse(text, "pendulum.toml", &vibro_machine::file::no_records)?;
    /// machine.changes.insert("body.a.mass".into(), "2 kg".into());
    /// assert_eq!(machine.name_with_changes(), "Pendulum with body.a.mass = 2 kg");
    /// # Ok::<(), vibro_studies::Error>(())
    /// ```
    pub fn name_with_changes(&self) -> String {
        let changes: Vec<String> =
            self.changes.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        let with = if changes.is_empty() { "" } else { " with " };
        format!("{}{with}{}", self.description.name, changes.join(", "))
    }

    /// The machine with other values of some parameters, SI.
    ///
    /// # Errors
    /// [`Error::Refusal`] for unknown names and values out of range.
    pub fn with<'n>(&self, values: impl IntoIterator<Item = (&'n str, f64)>) -> Result<Self> {
        let changed = self.description.with(values).map_err(|refusal| self.in_written_units(refusal));
        Ok(Self { description: changed?, ..self.clone() })
    }

    /// The refusal with each parameter's value in its written unit.
    fn in_written_units(&self, mut refusal: Refusal) -> Refusal {
        for problem in &mut refusal.problems {
            let value = problem.value.as_deref().and_then(|value| value.parse().ok());
            if let (Some(value), Ok(parameter)) = (value, self.description.parameter(&problem.name)) {
                problem.value = Some(self.told(&parameter.name, value));
            }
        }
        refusal
    }

    /// SI unit of a parameter; `1` if it has none, and for an unknown name.
    pub fn si_unit(&self, name: &str) -> &'static str {
        self.description.parameter(name).map_or("1", |p| p.unit)
    }

    /// Unit of a parameter in the machine's file, if the file gives one.
    pub fn written_unit(&self, name: &str) -> Option<&'static Unit> {
        let symbol = self.units.get(name)?;
        quantity_in(self.si_unit(name), &format!("1 {symbol}"))?.unit
    }

    /// Display unit of a parameter: its factor (units per SI unit) and its symbol.
    pub fn unit(&self, name: &str) -> (f64, String) {
        match (self.written_unit(name), self.si_unit(name)) {
            (Some(unit), _) => (unit.number(1.0), unit.symbol()),
            (None, "1") => (1.0, String::new()),
            (None, si) => (1.0, si.replace('.', "·")),
        }
    }

    /// Value of a parameter with its unit: `4 mm`.
    pub fn told(&self, name: &str, value: f64) -> String {
        let (factor, symbol) = self.unit(name);
        let number = crate::significant(factor * value);
        if symbol.is_empty() { number } else { format!("{number} {symbol}") }
    }

    /// The motion from a start, with its section.
    ///
    /// # Errors
    /// Error if the machine's matrices or section are refused; as [`Start::motion`].
    ///
    /// # Examples
    /// A ball that falls from 1.8 m instead of 5 m meets the floor after 0.6 s:
    ///
    /// ```
    /// use vibro_studies::{Machine, Start};
    ///
    /// # let text = r#"
    /// #     name = "Ball"
    /// #     gravity = 10.0
    /// #     body.ball = { mass = "20 g", gravity = 1.0 }
    /// #     stop.floor = { between = ["ground", "ball"], gap = "5 m", restitution = 0.5 }
    /// # "#;
    /// let machine = Machine::parse(text, "ball.toml", &vibro_machine::file::no_records)?;
    /// let mut start = Start::default();
    /// start.set_text(&machine.description, "ball.s", "320 cm")?;
    /// let (mut motion, section) = machine.motion(&start)?;
    /// section.advance(&mut motion, &mut |_| ())?;
    /// assert!((motion.time() - 0.6).abs() < 1e-15);
    /// # Ok::<(), vibro_studies::Error>(())
    /// ```
    pub fn motion(&self, start: &Start) -> Result<(Motion, Section)> {
        let section = Section::of(&self.description, &self.section)?;
        Ok((start.motion(Arc::new(Assembly::new(self.description.clone())?))?, section))
    }

    /// The motion of this machine from the [end](now) of a motion with other parameter values. If
    /// the state violates rigid stops, the engine moves bodies by the smallest amount in the
    /// inertia's metric. If that fails, or no motion begins there, the machine's own start is
    /// used.
    ///
    /// # Errors
    /// Error if the machine's matrices, its own start or its section are refused.
    pub fn motion_on(&self, end: &Start) -> Result<(Motion, Section)> {
        let section = Section::of(&self.description, &self.section)?;
        let assembly = Assembly::new(self.description.clone())?;
        let body = |body: &Body| {
            let given = end.bodies.get(&body.name).copied().unwrap_or_default();
            (given.s.unwrap_or(0.0), given.v.unwrap_or(0.0))
        };
        let bodies = self.description.bodies.iter().map(body).collect();
        let placed = Motion::starting_at(Arc::new(assembly.clone().starting_from(bodies)), end.time).ok();
        let motion = match placed.filter(is_between_stops) {
            Some(motion) => motion,
            None => Motion::new(Arc::new(assembly))?,
        };
        Ok((motion, section))
    }
}

/// Whether no rigid stop is violated.
pub(crate) fn is_between_stops(motion: &Motion) -> bool {
    let (system, z) = (motion.assembly().system(), motion.state());
    system.stops.iter().filter(|stop| stop.keeps_gap()).all(|stop| {
        let size: f64 = stop.excess.iter().zip(z.iter()).map(|(r, x)| (r * x).abs()).sum();
        stop.excess.dot(z) <= ROUNDING * size
    })
}

/// The present state of a motion, as the start of [`Machine::motion_on`] with other parameter
/// values. It contains all bodies, since other arms may change which coordinates are free.
pub fn now(motion: &Motion) -> Start {
    let body = |(i, body): (usize, &Body)| {
        let [s, v, _] = motion.body(i);
        (body.name.clone(), BodyStart { s: Some(s), v: Some(v) })
    };
    let bodies = motion.assembly().description.bodies.iter().enumerate();
    Start { bodies: bodies.map(body).collect(), ..Start::of(motion) }
}
