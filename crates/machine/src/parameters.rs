//! Parameters: the numbers of a machine by name, as FMU variables, command lines and Python read
//! and set them.
//!
//! Names are as in the file: `gravity`, `body.box.mass`, `body.box.start.s`,
//! `spring.mesh.arms.pinion`, `stop.upper.gap`, `friction.guide.force`, `load.shaker.amplitude`,
//! or `load.shaker.harmonics[1].amplitude` if there are several harmonics. `block.pid.a[0,1]` is a
//! matrix entry by row and column from 0, as in FMI's structured names. The set of names depends
//! on the machine's topology, never on its numbers. Knots of records have no names. Parameters of
//! `[parameters]` have names; numbers that follow ([`Description::following`]) cannot be set.

use crate::check::{check, check_under_way};
use crate::description::{Description, Dimension};
use crate::following::Following;
use crate::kinds::NumberKind;
use crate::named::usual_name;
use crate::refusal::{Problem, Refusal, advice};
use crate::slots::{Slot, slots};
use std::collections::HashMap;
use vibro_numerics::Range;
use vibro_numerics::quantities::quantity_in;

/// A parameter of a machine.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Dotted name, such as `stop.upper.gap`.
    pub name: String,
    /// Meaning in words; for a named parameter the comment after it in the file, if any.
    pub meaning: String,
    /// SI unit.
    pub unit: &'static str,
    /// Value in the SI unit.
    pub value: f64,
    /// Least and largest value; infinite without a bound. The bounds of a named parameter follow
    /// from the numbers that are straight lines in this parameter alone.
    pub bounds: [f64; 2],
    kind: NumberKind,
    dimension: Dimension,
}

impl Parameter {
    /// Range of allowed values. For a lever arm, zero is refused although the range contains it.
    pub fn range(&self) -> Range {
        self.kind.range
    }

    /// Reads a value, with or without a unit of the parameter's dimension.
    ///
    /// # Errors
    /// A [`Refusal`] with the parameter's name, the text and the allowed values.
    ///
    /// # Examples
    /// ```
    /// # use vibro_machine::file::{no_records, parse};
    /// # let text = "name = \"A\"\nbody.a = { mass = 1.0 }\n\
    /// #     stop.s = { between = [\"ground\", \"a\"], gap = \"4 mm\", restitution = 0.5 }\n";
    /// let machine = parse(text, "a.toml", &no_records)?;
    /// let gap = machine.parameter("stop.s.gap")?;
    /// assert_eq!((gap.unit, gap.value), ("m", 0.004));
    /// assert_eq!(gap.read("5 mm")?, 0.005);
    /// assert_eq!(gap.read("5 mm"), gap.read("0.005"));
    /// assert!(gap.read("5 N").is_err());
    /// # Ok::<(), vibro_machine::Refusal>(())
    /// ```
    pub fn read(&self, text: &str) -> Result<f64, Refusal> {
        read(self.kind, self.dimension, text).map_err(|fault| {
            Refusal::one(Problem::new(&self.name, Some(format!("{:?}", text.trim())), fault))
        })
    }
}

/// Longest text of a number with its unit, bytes; reading tries every start of the unit.
const LONGEST_NUMBER: usize = 100;

/// Reads an allowed number of a kind, with or without a unit. The error is its fault.
pub(crate) fn read(kind: NumberKind, dimension: Dimension, text: &str) -> Result<f64, String> {
    if text.trim().len() > LONGEST_NUMBER {
        return Err(kind.allowed(dimension));
    }
    let found = quantity_in(kind.unit(dimension), text.trim()).map(|q| q.value);
    found.filter(|&v| kind.contains(v)).ok_or_else(|| kind.fault_of(text, dimension))
}

impl Description {
    /// All parameters: gravity, then parameters of bodies and of elements in the order of
    /// [`SECTIONS`](crate::elements::SECTIONS), then named parameters. Numbers that follow from
    /// them by expressions are not included; see [`following`](Self::following).
    ///
    /// ```
    /// use vibro_machine::file::{no_records, parse};
    ///
    /// let text = r#"
    ///     name = "Bouncer"
    ///     gravity = 9.81
    ///     [body.ball]
    ///     mass = "20 g"
    ///     gravity = 1.0
    ///     [stop.floor]
    ///     between = ["ground", "ball"]
    ///     gap = "1 m"
    ///     restitution = 0.9
    /// "#;
    /// let mut ball = parse(text, "ball.toml", &no_records)?;
    /// let names: Vec<_> = ball.parameters().into_iter().map(|p| p.name).collect();
    /// assert_eq!(names[..3], ["gravity", "body.ball.mass", "body.ball.gravity"]);
    /// ball.replace("stop.floor.restitution", 0.8)?;
    /// assert_eq!(ball.get("stop.floor.restitution")?, 0.8);
    /// let refused = ball.replace("stop.floor.restitution", 1.2).unwrap_err();
    /// assert_eq!(
    ///     refused.to_string(),
    ///     "stop.floor.restitution = 1.2: expected a number from 0 to 1"
    /// );
    /// # Ok::<(), vibro_machine::Refusal>(())
    /// ```
    pub fn parameters(&self) -> Vec<Parameter> {
        let mut copy = self.clone();
        let parameter = |slot: Slot| Parameter {
            name: slot.name,
            meaning: slot.kind.meaning.to_owned(),
            unit: slot.kind.unit(slot.dimension),
            value: *slot.value,
            bounds: [slot.kind.range.min, slot.kind.range.max],
            kind: slot.kind,
            dimension: slot.dimension,
        };
        let all = slots(&mut copy);
        if self.named.all().is_empty() {
            return all.into_iter().map(parameter).collect();
        }
        let (follow, own): (Vec<_>, Vec<_>) =
            all.into_iter().partition(|slot| self.named.of_number(&slot.name).is_some());
        let ranges: HashMap<_, _> = follow.into_iter().map(|slot| (slot.name, slot.kind.range)).collect();
        let bounds = self.named.ranges(|name| ranges.get(name).copied());
        let mut parameters: Vec<Parameter> = own.into_iter().map(parameter).collect();
        // Named parameters without expressions come last.
        let named = self.named.all().iter().zip(bounds).rev().filter(|own| own.0.expression.is_none());
        for (parameter, (own, bounds)) in parameters.iter_mut().rev().zip(named) {
            (parameter.meaning, parameter.bounds) = (own.meaning(), bounds);
        }
        parameters
    }

    /// The parameter with a name. For a single harmonic, `harmonics[0].amplitude` is an alias of
    /// `amplitude`; `a[0][1]` is an alias of `a[0,1]`.
    ///
    /// # Errors
    /// A [`Refusal`] with the nearest name, or with the parameters that determine the number.
    pub fn parameter(&self, name: &str) -> Result<Parameter, Refusal> {
        let mut all = self.parameters();
        let place = self.place_in(&all, |p| &p.name, name).map_err(Refusal::one)?;
        Ok(all.swap_remove(place))
    }

    /// Names of parameters as [`parameters`](Self::parameters) lists them, without their aliases.
    ///
    /// # Errors
    /// As [`parameter`](Self::parameter).
    pub(crate) fn usual_names(&self, names: &[&str]) -> Result<Vec<String>, Refusal> {
        if names.is_empty() {
            return Ok(Vec::new());
        }
        let mut copy = self.clone();
        let all = slots(&mut copy);
        let one = |name: &&str| Ok(all[self.place_in(&all, |s| &s.name, name)?].name.clone());
        names.iter().map(one).collect::<Result<_, _>>().map_err(Refusal::one)
    }

    /// The value, in SI, of a parameter or of a number that follows from parameters.
    ///
    /// # Errors
    /// A [`Refusal`] with the nearest name.
    pub fn get(&self, name: &str) -> Result<f64, Refusal> {
        let plain = usual_name(name);
        let is_own = |own: &Following| own.name == name || own.name == plain;
        match self.following().into_iter().find(is_own) {
            Some(found) => Ok(found.value),
            None => Ok(self.parameter(name)?.value),
        }
    }

    /// Replaces the value of a parameter, in SI.
    ///
    /// # Errors
    /// As [`with`](Self::with); the machine is then unchanged.
    pub fn replace(&mut self, name: &str, value: f64) -> Result<(), Refusal> {
        *self = self.with([(name, value)])?;
        Ok(())
    }

    /// The machine with other values of some parameters, in SI. It is checked once after all
    /// changes, so that a gap and a start value may change together.
    ///
    /// # Errors
    /// A [`Refusal`] for unknown names, with the nearest valid names; for values out of range; and
    /// for any other reason to refuse a file with these values.
    ///
    /// # Examples
    /// ```
    /// # use vibro_machine::file::{no_records, parse};
    /// # let text = "name = \"A\"\nbody.a = { mass = 1.0, start.s = \"3 mm\" }\n\
    /// #     stop.s = { between = [\"ground\", \"a\"], gap = \"4 mm\", restitution = 0.5 }\n";
    /// let machine = parse(text, "a.toml", &no_records)?;
    /// // With this gap alone, the body would start behind the stop.
    /// assert!(machine.with([("stop.s.gap", 0.002)]).is_err());
    /// let smaller = machine.with([("stop.s.gap", 0.002), ("body.a.start.s", 0.001)])?;
    /// assert_eq!(smaller.get("stop.s.gap")?, 0.002);
    /// assert_eq!(machine.get("stop.s.gap")?, 0.004);
    /// # Ok::<(), vibro_machine::Refusal>(())
    /// ```
    pub fn with<'n>(&self, changes: impl IntoIterator<Item = (&'n str, f64)>) -> Result<Self, Refusal> {
        self.changed(changes, check)
    }

    /// The machine with other values of some parameters, in SI, during a motion: start values are
    /// not checked, and a start at rest is not computed again.
    ///
    /// # Errors
    /// As [`with`](Self::with), without the conditions on start values.
    pub fn under_way<'n>(&self, changes: impl IntoIterator<Item = (&'n str, f64)>) -> Result<Self, Refusal> {
        let changed = self.changed(changes, check_under_way)?;
        Ok(Self { starts_at_rest: false, ..changed })
    }

    /// Index of the parameter with a name, or the reason why there is none.
    fn place_in<T>(&self, all: &[T], name_of: fn(&T) -> &String, name: &str) -> Result<usize, Problem> {
        match self.named.refusal(name) {
            Some(follows) => Err(follows),
            None => position(all, name_of, name).map_err(|unknown| self.at_rest(unknown)),
        }
    }

    /// The problem of an unknown name, or its reason if the name is a start of a machine at rest.
    fn at_rest(&self, unknown: Problem) -> Problem {
        let body = unknown.name.strip_prefix("body.").and_then(|own| own.split_once(".start."));
        match body.filter(|own| self.starts_at_rest && self.bodies.iter().any(|body| body.name == own.0)) {
            Some((body, own)) => {
                let text = format!(
                    "the machine starts at rest (start = \"rest\") and has no such number; \
                     a fit can use start.{body}.{own}"
                );
                Problem { text, ..unknown }
            }
            None => unknown,
        }
    }

    fn changed<'n>(
        &self,
        changes: impl IntoIterator<Item = (&'n str, f64)>,
        check: fn(&Self) -> Vec<Problem>,
    ) -> Result<Self, Refusal> {
        let mut changed = self.clone();
        let mut all = slots(&mut changed);
        let (mut problems, mut set) = (Vec::new(), Vec::new());
        for (name, value) in changes {
            match self.place_in(&all, |s| &s.name, name) {
                Ok(place) => {
                    *all[place].value = value;
                    set.push((all[place].name.clone(), value));
                }
                Err(problem) => problems.push(problem),
            }
        }
        if problems.is_empty() {
            problems = changed.follow();
            if problems.is_empty() {
                problems = check(&changed);
            }
            problems = problems.into_iter().map(|own| self.named.blame(own, &set)).collect();
        }
        if problems.is_empty() { Ok(changed) } else { Err(Refusal { file: String::new(), problems }) }
    }
}

fn position<T>(all: &[T], name_of: fn(&T) -> &String, name: &str) -> Result<usize, Problem> {
    let find = |name: &str| all.iter().position(|t| name_of(t) == name);
    let unknown = || {
        let text =
            format!("no parameter has this name; {}", advice(name, all.iter().map(|t| name_of(t).as_str())));
        Problem::new(name, None, text)
    };
    find(name).or_else(|| find(&usual_name(name))).ok_or_else(unknown)
}

/// Whether a text is a number with a unit that converts to `si`.
pub(crate) fn has_unit(si: &str, text: &str) -> bool {
    text.len() <= LONGEST_NUMBER && quantity_in(si, text).is_some_and(|q| q.unit.is_some())
}
