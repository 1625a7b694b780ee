//! Quantities of a described machine, by the names of the columns of its motion: `box.s`,
//! `upper.f`, `shaker.f`.

use super::flight::Flow;
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;
use vibro_assembly::description::{Description, Dimension};
use vibro_assembly::mode::{Contact, StopState};
use vibro_assembly::system::System;

/// Quantity of a body or an element by its name, such as `box.s`; [`NamedQuantity::place`] tells
/// whether a machine has it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct NamedQuantity {
    /// Body or element.
    pub of: String,
    /// `s`, `v`, `a` of a body; `e`, `rate`, `f` of an element; `f` of a load.
    pub what: What,
}

/// Quantity of a body or an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// A body's coordinate.
    S,
    /// A body's rate.
    V,
    /// A body's acceleration.
    A,
    /// An element's elongation.
    E,
    /// An element's rate.
    Rate,
    /// An element's or a load's force.
    F,
}

const WORDS: [(What, &str); 6] =
    [(What::S, "s"), (What::V, "v"), (What::A, "a"), (What::E, "e"), (What::Rate, "rate"), (What::F, "f")];

impl FromStr for NamedQuantity {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let form = || Error::Described {
            problem: format!(
                "`{text}`: expected BODY.s, BODY.v, BODY.a, ELEMENT.e, ELEMENT.rate, ELEMENT.f or LOAD.f, e.g. box.s"
            ),
        };
        let (of, what) = text.trim().rsplit_once('.').ok_or_else(form)?;
        // The section may be named, as in parameters.
        let of = of.split_once('.').map_or(of, |(_, name)| name);
        let what = WORDS.iter().find(|w| w.1 == what).ok_or_else(form)?.0;
        Ok(Self { of: of.into(), what })
    }
}

impl fmt::Display for NamedQuantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = WORDS.iter().find(|w| w.0 == self.what).map_or("", |w| w.1);
        write!(f, "{}.{word}", self.of)
    }
}

crate::text::written_as_text!(NamedQuantity);

/// Owner of a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owner {
    /// A body.
    Body(usize),
    /// A spring.
    Spring(usize),
    /// A stop.
    Stop(usize),
    /// A friction.
    Friction(usize),
    /// A load.
    Load(usize),
}

/// Bodies and elements of a machine by their names.
pub fn owners(d: &Description) -> Vec<(&str, Owner, Dimension)> {
    let mut all = Vec::new();
    all.extend(d.bodies.iter().enumerate().map(|(i, b)| (b.name.as_str(), Owner::Body(i), b.dimension)));
    all.extend(
        d.springs.iter().enumerate().map(|(i, s)| (s.name.as_str(), Owner::Spring(i), s.arms.dimension)),
    );
    all.extend(d.stops.iter().enumerate().map(|(i, s)| (s.name.as_str(), Owner::Stop(i), s.arms.dimension)));
    all.extend(
        d.frictions.iter().enumerate().map(|(i, f)| (f.name.as_str(), Owner::Friction(i), f.arms.dimension)),
    );
    all.extend(
        d.loads
            .iter()
            .enumerate()
            .map(|(i, l)| (l.name.as_str(), Owner::Load(i), d.bodies[l.body].dimension)),
    );
    all
}

/// Refusal of a name that a machine does not have, with the nearest one.
pub fn unknown(text: &str, known: &[String]) -> Error {
    let nearest = known.iter().max_by(|a, b| strsim::jaro(a, text).total_cmp(&strsim::jaro(b, text)));
    let advice = nearest.map_or("the machine has none".into(), |near| {
        format!("the nearest is `{near}`; allowed are {}", known.join(", "))
    });
    Error::Described { problem: format!("the machine has no `{text}`; {advice}") }
}

/// Quantity of a given machine by its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QuantityPlace {
    owner: Owner,
    what: What,
    dimension: Dimension,
}

impl NamedQuantity {
    /// All quantities of a machine.
    pub fn all(d: &Description) -> Vec<Self> {
        let of = |(name, owner, _): (&str, Owner, Dimension)| {
            let all: &[What] = match owner {
                Owner::Body(_) => &[What::S, What::V, What::A],
                Owner::Load(_) => &[What::F],
                _ => &[What::E, What::Rate, What::F],
            };
            all.iter().map(|&what| Self { of: name.into(), what }).collect::<Vec<_>>()
        };
        owners(d).into_iter().flat_map(of).collect()
    }

    /// The quantity of a machine with this name.
    ///
    /// # Errors
    /// [`Error::Described`] with the nearest name.
    pub fn place(&self, d: &Description) -> Result<QuantityPlace> {
        let all = Self::all(d);
        if !all.contains(self) {
            let known: Vec<String> = all.iter().map(ToString::to_string).collect();
            return Err(unknown(&self.to_string(), &known));
        }
        let is_body = matches!(self.what, What::S | What::V | What::A);
        let found = owners(d)
            .into_iter()
            .find(|(name, owner, _)| *name == self.of && matches!(owner, Owner::Body(_)) == is_body);
        let (_, owner, dimension) = found.ok_or_else(|| unknown(&self.to_string(), &[]))?;
        Ok(QuantityPlace { owner, what: self.what, dimension })
    }
}

impl QuantityPlace {
    /// SI unit.
    pub fn unit(&self) -> &'static str {
        let rotates = self.dimension == Dimension::Rotation;
        let units = match self.what {
            What::S | What::E => ["m", "rad"],
            What::V | What::Rate => ["m/s", "rad/s"],
            What::A => ["m/s2", "rad/s2"],
            What::F => ["N", "N.m"],
        };
        units[usize::from(rotates)]
    }

    /// Row of the quantity in a mode: the quantity is the row times the augmented state.
    pub fn row(&self, system: &System, flow: &Flow) -> Vec<f64> {
        let n = system.coordinates;
        let contact = |contact: Contact| {
            let place = flow.mode.basis.iter().position(|&c| c == contact);
            place.map(|k| flow.lambda[k].clone())
        };
        let zero = || nalgebra::DVector::zeros(system.signals.size);
        let row = match (self.owner, self.what) {
            (Owner::Body(i), What::S) => system.bodies[i].s.clone(),
            (Owner::Body(i), What::A) => {
                let body = &system.bodies[i];
                let mut rates = vec![0.0; system.signals.size];
                rates[n..2 * n].copy_from_slice(body.weights.as_slice());
                return flow.rate_of(&rates).iter().zip(body.drift.iter()).map(|(a, b)| a + b).collect();
            }
            (Owner::Body(i), _) => system.bodies[i].v.clone(),
            (Owner::Spring(i), What::F) => system.springs[i].force.clone(),
            (Owner::Stop(i), What::F) => match flow.mode.stops[i] {
                StopState::Closed => contact(Contact::Stop(i)).unwrap_or_else(zero),
                state => system.stop_force(i, state).unwrap_or_else(zero),
            },
            (Owner::Friction(i), What::F) => {
                let state = flow.mode.frictions[i];
                system.friction_force(i, state).or_else(|| contact(Contact::Friction(i))).unwrap_or_else(zero)
            }
            (Owner::Load(i), _) => system.loads[i].clone(),
            (owner, what) => {
                let e = match owner {
                    Owner::Spring(i) => &system.springs[i].elongation,
                    Owner::Stop(i) => &system.stops[i].elongation,
                    Owner::Friction(i) => &system.frictions[i].elongation,
                    Owner::Body(_) | Owner::Load(_) => return zero().as_slice().to_vec(),
                };
                if what == What::Rate { (*e.rate).clone() } else { e.e.clone() }
            }
        };
        row.as_slice().to_vec()
    }
}
