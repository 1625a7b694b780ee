//! Directions along which an orbit's state is free: each shift of the state along one leads to
//! another orbit.
//!
//! - A neutral direction of the machine: no force depends on it, and the state may drift along it.
//! - A slider or friction that sticks for the whole period: the place where it sticks never
//!   changes, so that the equations of return are dependent.
//!
//! In both cases an orbit's equations have one more unknown, a drift along the direction, and one
//! more equation, which holds the position along it. The drift of a contact that sticks is zero.

use super::place::{Place, with_signals};
use super::word::Word;
use nalgebra::{DMatrix, DVector};
use vibro_machine::functional::Functional;
use vibro_machine::mode::{Contact, FrictionState, Mode, SliderState};
use vibro_machine::neutral::Neutral;
use vibro_machine::system::System;

/// Size of a unit row's component that counts as zero. Rows have some digits of rounding.
const ZERO: f64 = 1e-9;

/// A direction along which the state is free.
#[derive(Clone, Debug)]
pub(super) struct Direction {
    /// Change of the state, SI.
    pub change: Vec<f64>,
    /// The position along it.
    position: Position,
}

/// The position of a state along a direction.
#[derive(Clone, Debug)]
enum Position {
    /// Product of the direction's change and the state.
    Along,
    /// Sum of the places where contacts stick, each with a factor.
    Held(Vec<(f64, Contact)>),
}

impl Direction {
    /// All directions of a word: first the machine's neutral directions.
    pub(super) fn all(place: &Place, word: &Word, units: &[f64]) -> Vec<Self> {
        let system = place.assembly.system();
        let neutral = Neutral::of(system).states().into_iter().map(|mut change| {
            // States of blocks do not change along neutral directions.
            change.resize(system.states(), 0.0);
            Self { change, position: Position::Along }
        });
        let mut all: Vec<Self> = neutral.collect();
        let held = held(system, word);
        all.extend(independent(system, &held, &all, units));
        all
    }

    /// Whether it is a neutral direction of the machine.
    pub(super) fn is_neutral(&self) -> bool {
        matches!(self.position, Position::Along)
    }

    /// The contacts whose places it moves.
    pub(super) fn contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        let held: &[(f64, Contact)] = if let Position::Held(all) = &self.position { all } else { &[] };
        held.iter().map(|own| own.1)
    }

    /// The derivative of the position with respect to the state.
    pub(super) fn row(&self, system: &System) -> Vec<f64> {
        let Position::Held(all) = &self.position else { return self.change.clone() };
        let mut row = vec![0.0; system.states()];
        for (factor, contact) in all {
            add(&mut row, *factor, place_of(system, *contact));
        }
        row
    }

    /// The position of a state at a time.
    pub(super) fn position(&self, system: &System, state: &[f64], time: f64) -> f64 {
        let Position::Held(all) = &self.position else { return product(&self.change, state) };
        let mut z = vec![0.0; system.signals.size];
        with_signals(system, time, &mut z);
        z[..state.len()].copy_from_slice(state);
        all.iter().map(|(factor, contact)| factor * place_of(system, *contact).at(&z)).sum()
    }

    /// The rate of the position of a fixed state with time, from prescribed bodies.
    pub(super) fn rate(&self, system: &System, time: f64) -> f64 {
        let Position::Held(all) = &self.position else { return 0.0 };
        let mut z = vec![0.0; system.signals.size];
        with_signals(system, time, &mut z);
        let rate = |contact: &Contact| match *contact {
            Contact::Slider(i) => system.branches[i].elongation.rate.at(&z),
            Contact::Friction(i) => system.frictions[i].elongation.rate.at(&z),
            Contact::Stop(_) => 0.0,
        };
        all.iter().map(|(factor, contact)| factor * rate(contact)).sum()
    }
}

/// The place where a contact sticks, as a functional of the augmented state.
fn place_of(system: &System, contact: Contact) -> &Functional {
    match contact {
        Contact::Slider(i) => &system.branches[i].inner,
        Contact::Friction(i) => &system.frictions[i].elongation.e,
        Contact::Stop(i) => &system.stops[i].elongation.e,
    }
}

/// The sliders and frictions that stick for the whole period of a word.
fn held(system: &System, word: &Word) -> Vec<Contact> {
    let modes: Vec<&Mode> =
        word.letters.iter().flat_map(|letter| &letter.modes).chain([&word.mode]).collect();
    let runs = word.letters.iter().filter_map(|letter| letter.chatter.as_ref());
    let modes: Vec<&Mode> = modes.into_iter().chain(runs.map(|run| &run.mode)).collect();
    // A step of a prescribed body may move a slider that sticks before and after it.
    let has_event = |contact| {
        word.letters.iter().flat_map(|letter| &letter.events).any(|event| event.contact() == Some(contact))
    };
    let sliders = (0..system.branches.len()).filter(|&i| {
        system.branches[i].level.is_some()
            && modes.iter().all(|mode| mode.sliders[i] == SliderState::Held)
            && !has_event(Contact::Slider(i))
    });
    let frictions = (0..system.frictions.len())
        .filter(|i| modes.iter().all(|mode| mode.frictions[*i] == FrictionState::Stuck));
    sliders.map(Contact::Slider).chain(frictions.map(Contact::Friction)).collect()
}

/// The directions of held contacts that the neutral directions leave: combinations of the places
/// that no neutral direction changes.
fn independent(system: &System, held: &[Contact], neutral: &[Direction], units: &[f64]) -> Vec<Direction> {
    // Orthonormal rows in the units of the state, each with its combination of the contacts.
    let mut rows: Vec<(DVector<f64>, DVector<f64>)> = Vec::new();
    for (k, contact) in held.iter().enumerate() {
        let mut row = vec![0.0; system.states()];
        add(&mut row, 1.0, place_of(system, *contact));
        let mut row = DVector::from_iterator(row.len(), row.iter().zip(units).map(|(x, unit)| x * unit));
        let mut combined = DVector::zeros(held.len());
        let size = row.norm();
        if size == 0.0 {
            continue;
        }
        row /= size;
        combined[k] = 1.0 / size;
        for (other, of_other) in &rows {
            let share = other.dot(&row);
            row.axpy(-share, other, 1.0);
            combined.axpy(-share, of_other, 1.0);
        }
        let left = row.norm();
        if left > ZERO {
            rows.push((row / left, combined / left));
        }
    }
    if rows.is_empty() {
        return Vec::new();
    }
    let changed = DMatrix::from_fn(rows.len(), neutral.len(), |i, k| {
        let change =
            DVector::from_iterator(units.len(), neutral[k].change.iter().zip(units).map(|(x, u)| x / u));
        let size = change.norm();
        if size > 0.0 { rows[i].0.dot(&change) / size } else { 0.0 }
    });
    let own = (&changed * changed.transpose()).symmetric_eigen();
    let unchanged = own.eigenvalues.iter().zip(own.eigenvectors.column_iter());
    let unchanged = unchanged.filter(|(value, _)| value.abs() < ZERO);
    unchanged
        .map(|(_, share)| {
            let (mut row, mut combined) = (DVector::zeros(units.len()), DVector::zeros(held.len()));
            for (x, (own, of_own)) in share.iter().zip(&rows) {
                row.axpy(*x, own, 1.0);
                combined.axpy(*x, of_own, 1.0);
            }
            let all = combined.iter().zip(held).filter(|(x, _)| **x != 0.0);
            Direction {
                change: row.iter().zip(units).map(|(x, unit)| x * unit).collect(),
                position: Position::Held(all.map(|(x, contact)| (*x, *contact)).collect()),
            }
        })
        .collect()
}

/// Adds the entries of a functional that belong to the state.
fn add(row: &mut [f64], factor: f64, functional: &Functional) {
    for &(i, x) in functional.terms() {
        if let Some(entry) = row.get_mut(i) {
            *entry += factor * x;
        }
    }
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
