//! Quantities of described machines, by the names of the columns of their motion: `box.s`,
//! `upper.f`, `shaker.f`.

use super::flight::Flow;
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;
use vibro_machine::description::Description;
use vibro_machine::elements::SECTIONS;
use vibro_machine::quantity::NamedQuantity;
use vibro_machine::refusal::advice;
use vibro_machine::system::System;
use vibro_machine::{Owner, Quantity, What};

/// A quantity by its name, such as `box.s`; whether a machine has it is known by
/// [`QuantityName::find`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct QuantityName {
    /// The body or element.
    pub of: String,
    /// `s`, `v`, `a` of a body; `e`, `rate`, `f` of an element; `slider` of a spring in series;
    /// `et`, `ft`, `slider` of a contact with friction, `et[0]`, … with two tangents; `f` of a
    /// load; `Value` of a signal that blocks read, and of an output of a block, whose whole name
    /// is `of`.
    pub what: What,
}

impl FromStr for QuantityName {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let form = || Error::Described {
            problem: format!(
                "`{text}`: expected BODY.s, BODY.v, BODY.a, ELEMENT.e, ELEMENT.rate, ELEMENT.f, SPRING.slider or LOAD.f, e.g. box.s"
            ),
        };
        let word = |what: &str| What::ALL.into_iter().find(|w| w.word() == what);
        let (of, what) = text.trim().rsplit_once('.').ok_or_else(form)?;
        // `signal.NAME` and `block.NAME.OUTPUT`; a body, too, may be called `signal` or `block`.
        let value = match of.split_once('.') {
            None if of == "signal" && word(what).is_none() => Some(what),
            Some(("block", _)) if word(what).is_none() => text.trim().strip_prefix("block."),
            _ => None,
        };
        if let Some(name) = value {
            return Ok(Self { of: name.into(), what: What::Value });
        }
        // The section may be named, as in parameters; a node's name has a point, too.
        let is_section =
            |word: &str| word == "body" || SECTIONS.iter().any(|own| own.0 == word && own.0 != "block");
        let of = of.split_once('.').filter(|(word, _)| is_section(word)).map_or(of, |(_, name)| name);
        match word(what) {
            Some(what) => Ok(Self { of: of.into(), what }),
            None if is_name(of) && is_name(what) => Ok(Self { of: text.trim().into(), what: What::Value }),
            None => Err(form()),
        }
    }
}

/// Whether a text has the letters of a name.
fn is_name(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

impl fmt::Display for QuantityName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.what {
            What::Value => f.write_str(&self.of),
            what => write!(f, "{}.{}", self.of, what.word()),
        }
    }
}

crate::text::written_as_text!(QuantityName);

/// Refusal of a name that a machine does not have, with the nearest one.
pub fn unknown(text: &str, known: &[String]) -> Error {
    let advice = advice(text, known.iter().map(String::as_str));
    Error::Described { problem: format!("the machine has no `{text}`; {advice}") }
}

impl QuantityName {
    /// The quantity of a machine that has this name.
    ///
    /// # Errors
    /// [`Error::Described`] with the nearest name.
    ///
    /// # Examples
    ///
    /// ```
    /// use vibro_studies::{Machine, QuantityName};
    ///
    /// # let text = r#"
    /// #     name = "Lid"
    /// #     body.block = { mass = "350 g" }
    /// #     stop.lid = { between = ["ground", "block"], gap = "4 mm", restitution = 0.7 }
    /// # "#;
    /// let machine = Machine::parse(text, "lid.toml", &vibro_machine::file::no_records)?;
    /// let speed: QuantityName = "block.v".parse()?;
    /// assert_eq!(speed.find(&machine.description)?.unit, "m/s");
    /// let misspelt: QuantityName = "blokc.v".parse()?;
    /// let problem = misspelt.find(&machine.description).unwrap_err().to_string();
    /// assert!(problem.contains("did you mean `block.v`?"));
    /// # Ok::<(), vibro_studies::Error>(())
    /// ```
    pub fn find(&self, d: &Description) -> Result<NamedQuantity> {
        let (name, mut all) = (self.to_string(), d.named_quantities());
        if let Some(place) = all.iter().position(|quantity| quantity.name == name) {
            return Ok(all.swap_remove(place));
        }
        // An output of a sweep, such as amplitude.box.s, has the quantity's name in it.
        match name.split_once('.').map(|own| own.1).filter(|of| all.iter().any(|q| q.name == *of)) {
            Some(of) => {
                let problem = format!("`{name}` is not a quantity; expected a quantity, such as {of}");
                Err(Error::Described { problem })
            }
            None => Err(unknown(&name, &all.into_iter().map(|q| q.name).collect::<Vec<_>>())),
        }
    }
}

impl Flow {
    /// The row of a quantity in the mode of this flow: its product with the augmented state is the
    /// quantity.
    pub(super) fn row_of(&self, system: &System, quantity: Quantity) -> Vec<f64> {
        let system = &*system.at_mode(&self.mode);
        let n = system.coordinates;
        let i = match (quantity.owner, quantity.what) {
            (Owner::Body(i), What::S) => return system.seen(i)[0].as_slice().to_vec(),
            (Owner::Body(i), What::A) if system.is_residual_node(i) => {
                return self.rate_of(system.seen(i)[1].as_slice());
            }
            (Owner::Body(i), What::A) => {
                let body = &system.bodies[i];
                let mut rates = vec![0.0; system.signals.size];
                rates[n..2 * n].copy_from_slice(body.weights.as_slice());
                return self.rate_of(&rates).iter().zip(body.drift.iter()).map(|(a, b)| a + b).collect();
            }
            (Owner::Body(i), _) => return system.seen(i)[1].as_slice().to_vec(),
            (Owner::Element(i), _) => i,
        };
        let parts = system.parts_of(i, quantity.what);
        let elongation = || parts.first().and_then(|part| system.seen_elongation(*part));
        let mut sum = vec![0.0; system.signals.size];
        let mut add = |row: &[f64]| sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += x);
        match quantity.what {
            What::F | What::TangentF(_) => parts
                .iter()
                .for_each(|part| add(system.force_row(*part, &self.mode, &self.lambda).as_slice())),
            What::Slider(k) | What::SliderRate(k) => {
                let Some(branch) = system.branch_of(i, k) else { return sum };
                let inner = system.branches[branch].inner.as_slice();
                let is_place = matches!(quantity.what, What::Slider(_));
                return if is_place { inner.to_vec() } else { self.rate_of(inner) };
            }
            What::Value | What::Output(_) => {
                add(system.block_row(i, quantity.what, &self.mode.stops).as_slice());
            }
            What::State(_) | What::StateRate(_) => {
                let mut unit = vec![0.0; system.signals.size];
                unit[system.block_place(i, quantity.what)] = 1.0;
                return if matches!(quantity.what, What::State(_)) { unit } else { self.rate_of(&unit) };
            }
            What::E | What::TangentE(_) => elongation().into_iter().for_each(|own| add(own[0].as_slice())),
            _ => elongation().into_iter().for_each(|own| add(own[1].as_slice())),
        }
        sum
    }
}
