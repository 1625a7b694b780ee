//! Derivatives of quantities: y = ℓ z has the derivative ℓ δ + dℓ z (docs/assembly-law.md (A31)).

use super::mode::VariedMode;
use super::rows::ElongationTangent;
use super::tangent::Tangent;
use crate::functional::{Functional, StateRow};
use crate::mode::{Contact, FrictionState, SliderState, StopState};
use crate::quantity::{Owner, Quantity, What};
use crate::system::{Part, System};
use nalgebra::DVector;

/// A state in a mode with its derivative by parameter `p`.
pub(super) struct Point<'a> {
    pub system: &'a System,
    pub tangent: &'a Tangent,
    pub mode: &'a VariedMode,
    pub p: usize,
    pub z: &'a DVector<f64>,
    pub delta: &'a DVector<f64>,
    /// Largest sizes of `delta` so far.
    pub scale: &'a DVector<f64>,
}

impl Point<'_> {
    /// The derivative of a row's value.
    pub fn of(&self, row: &StateRow, by: &StateRow) -> f64 {
        row.dot(self.delta) + by.dot(self.z)
    }

    /// The sum of the sizes of the terms of [`of`](Self::of).
    pub fn size(&self, row: &StateRow, by: &StateRow) -> f64 {
        let terms =
            |a: &StateRow, b: &StateRow| -> f64 { a.iter().zip(b.iter()).map(|(a, b)| (a * b).abs()).sum() };
        terms(row, self.scale) + terms(by, self.z)
    }

    /// The derivative of a quantity.
    pub fn quantity(&self, quantity: Quantity) -> f64 {
        let i = match quantity.owner {
            Owner::Body(i) => return self.body(i, quantity.what),
            Owner::Element(i) => i,
        };
        let parts = self.system.parts_of(i, quantity.what);
        match quantity.what {
            What::F | What::TangentF(_) => parts.iter().map(|&part| self.force(part)).sum(),
            What::Slider(k) | What::SliderRate(k) => self.system.branch_of(i, k).map_or(0.0, |i| {
                let (own, by) = (&self.system.branches[i], &self.tangent.branches[i].elongation);
                match quantity.what {
                    What::Slider(_) => self.of(&own.inner, &by.e),
                    _ if own.is_slider() && self.mode.mode.sliders[i] == SliderState::Held => 0.0,
                    _ => {
                        let stretch = self.mode.rates_by(self.p, self.z, self.delta)[own.place];
                        self.of(own.rate_of_whole(), &by.rate) - stretch
                    }
                }
            }),
            What::Value | What::Output(_) => {
                let stops = &self.mode.mode.stops;
                let output = if let What::Output(j) = quantity.what { Some(j) } else { None };
                let by = self.tangent.block_row(self.system, i, output, stops);
                self.of(&self.system.block_row(i, quantity.what, stops), &by)
            }
            What::State(_) => self.delta[self.system.block_place(i, quantity.what)],
            What::StateRate(_) => {
                let place = self.system.block_place(i, quantity.what);
                self.mode.rates_by(self.p, self.z, self.delta)[place]
            }
            what => parts.first().map_or(0.0, |&part| self.elongation(part, what)),
        }
    }

    fn body(&self, i: usize, what: What) -> f64 {
        if let Some(value) = self.residual_body(i, what) {
            return value;
        }
        let (rows, by) = (&self.system.bodies[i], &self.tangent.bodies[i]);
        match what {
            What::S => self.of(&rows.s, &by.s),
            What::V => self.of(&rows.v, &by.v),
            _ => {
                let n = self.system.coordinates;
                let own = self.mode.rates(self.z).rows(n, n).into_owned();
                let change = self.mode.rates_by(self.p, self.z, self.delta);
                let accelerations = rows.weights.dot(&change.rows(n, n)) + by.weights.dot(&own);
                accelerations + self.of(&rows.drift, &by.drift)
            }
        }
    }

    fn elongation(&self, part: Part, what: What) -> f64 {
        let by: &ElongationTangent = match part {
            Part::Spring(i) => &self.tangent.springs[i].0,
            Part::Stop(i) => &self.tangent.stops[i].elongation,
            Part::Friction(i) => &self.tangent.frictions[i].elongation,
            Part::Branch(i) => &self.tangent.branches[i].elongation,
            Part::Load(_) => return 0.0,
        };
        if let Some(value) = self.residual_elongation(part, what) {
            return value;
        }
        let Some(own) = self.system.elongation_of_part(part) else { return 0.0 };
        if matches!(what, What::E | What::TangentE(_)) {
            self.of(&own.e, &by.e)
        } else {
            self.of(&own.rate, &by.rate)
        }
    }

    /// The derivative of a contact's force; 0 for a contact that depends on others.
    fn held(&self, contact: Contact) -> f64 {
        let place = self.mode.mode.basis.iter().position(|&c| c == contact);
        place.map_or(0.0, |k| self.of(&self.mode.lambda[k], &self.mode.by[self.p].lambda[k]))
    }

    fn force(&self, part: Part) -> f64 {
        let both = |row: Option<StateRow>, by: Option<StateRow>| {
            row.zip(by).map_or(0.0, |(row, by)| self.of(&row, &by))
        };
        let (system, tangent, mode) = (self.system, self.tangent, &self.mode.mode);
        match part {
            Part::Spring(i) => self.of(&system.springs[i].force, &tangent.springs[i].1),
            Part::Branch(i) => {
                let state = mode.sliders[i];
                self.of(&system.branch_force(i, state), &tangent.branch_force(i, state))
            }
            Part::Load(i) => {
                self.of(&system.load_row(i, &mode.stops), &tangent.load_row(system, i, &mode.stops))
            }
            Part::Stop(i) => match mode.stops[i] {
                StopState::Closed => self.held(Contact::Stop(i)),
                state => {
                    both(system.stop_force(i, state).map(Functional::into_row), tangent.stop_force(i, state))
                }
            },
            Part::Friction(i) => match mode.frictions[i] {
                FrictionState::Stuck => self.held(Contact::Friction(i)),
                state => both(
                    system.friction_force(i, state, &mode.stops).map(Functional::into_row),
                    tangent.friction_force(system, i, state, &mode.stops),
                ),
            },
        }
    }
}
