//! Stops of the law: their elements, their order and their rows. The derivative of a machine by
//! its numbers builds the rows of its stops by the same functions.

use super::{ContactRows, Elongation, Part, StopLevel, StopRows, System};
use crate::curved::{HUNT_CROSSLEY, Operation};
use crate::description::{Arms, ContactLaw, DampingLimit, Description, ForcePoint, Signal, StopLaw};
use crate::elements::Element;
use crate::functional::Functional;
use crate::polyline::Polyline;
use crate::stepped;
use std::ops::{Add, Mul, Sub};

/// The element that makes a stop of the law, by its index among its kind.
#[derive(Clone, Copy, Debug)]
pub(crate) enum StopMaker {
    /// A stop of the description: its contact, or a level of its stiffness.
    Stop(usize),
    /// A contact.
    Contact(usize),
    /// A spring: a corner of its force, or a level of its stiffness.
    Spring(usize),
}

impl StopMaker {
    /// The arms of the element.
    pub fn arms(self, d: &Description) -> &Arms {
        match self {
            Self::Stop(i) => &d.stops[i].arms,
            Self::Contact(i) => &d.contacts[i].normal,
            Self::Spring(i) => &d.springs[i].arms,
        }
    }
}

/// A stop of the law that a stop, a contact or a spring makes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MadeStop {
    /// The element.
    pub by: StopMaker,
    /// For a stiffness that steps: index of the stiffness in [`stepped::all`], and the level.
    pub level: Option<(usize, usize)>,
    /// Gap, or the derivative of the gap.
    pub gap: f64,
    /// Law with its numbers, or with their derivatives.
    pub law: StopLaw,
}

/// Returns the stops of elements, in the order of [`System::stops`]: stops, contacts, further
/// levels of their stiffnesses, levels of springs, corners of springs. If `along` is given, whose
/// numbers are derivatives of the numbers of `d`, the stops have the derivatives of their numbers.
pub(crate) fn made_stops(d: &Description, along: Option<&Description>) -> Vec<MadeStop> {
    let numbers = along.unwrap_or(d);
    let (mut all, mut levels, mut stiffnesses) = (Vec::new(), Vec::new(), 0..);
    let mut next_stiffness = || stiffnesses.next().unwrap_or_default();
    for (i, (stop, own)) in d.stops.iter().zip(&numbers.stops).enumerate() {
        let made = |level, law| MadeStop { by: StopMaker::Stop(i), level, gap: own.gap, law };
        let (Some(signal), StopLaw::Compliant { damping, limit, .. }) = (&stop.stepped, own.law) else {
            all.push(made(None, own.law));
            continue;
        };
        let (index, by) = (next_stiffness(), along.and_then(|along| along.stops[i].stepped.as_ref()));
        let mut by_level = levels_of(signal, by).into_iter().enumerate().map(|(level, stiffness)| {
            made(Some((index, level)), StopLaw::Compliant { stiffness, damping, limit })
        });
        all.extend(by_level.next());
        levels.extend(by_level);
    }
    for (i, contact) in d.contacts.iter().enumerate() {
        let (gap, law) = match along.map(|along| &along.contacts[i]) {
            None => (contact.gap(), contact.law()),
            Some(by) => (contact.gap_along(by), by.law()),
        };
        all.push(MadeStop { by: StopMaker::Contact(i), level: None, gap, law });
    }
    let pull = |by, level, gap, stiffness| {
        let law = StopLaw::Compliant { stiffness, damping: 0.0, limit: DampingLimit::Pull };
        MadeStop { by: StopMaker::Spring(by), level, gap, law }
    };
    let mut corners = Vec::new();
    for (i, spring) in d.springs.iter().enumerate() {
        let by = along.map(|along| &along.springs[i]);
        if let Some(signal) = &spring.stepped {
            let (index, by) = (next_stiffness(), by.and_then(|by| by.stepped.as_ref()));
            let own = levels_of(signal, by).into_iter().enumerate();
            levels.extend(own.map(|(level, stiffness)| pull(i, Some((index, level)), 0.0, stiffness)));
        }
        let own = corners_of(&spring.points, by.map(|by| &by.points[..]));
        corners.extend(own.into_iter().map(|(e, steeper)| pull(i, None, e, steeper)));
    }
    all.extend(levels.into_iter().chain(corners));
    all
}

/// The stiffness of each level, or its derivative.
fn levels_of(signal: &Signal, along: Option<&Signal>) -> Vec<f64> {
    along.map_or_else(|| stepped::levels(signal), |along| stepped::along(signal, along))
}

/// The elongation of each corner and the increase of stiffness beyond it, or their derivatives.
fn corners_of(points: &[ForcePoint], along: Option<&[ForcePoint]>) -> Vec<(f64, f64)> {
    match along {
        _ if points.is_empty() => Vec::new(),
        None => Polyline::new(points).corners,
        Some(along) => Polyline::derivative(points, along).corners,
    }
}

/// The elongation of a stop beyond its gap. `one` is the row of the constant 1.
pub(crate) fn excess<R>(e: &R, gap: f64, one: &R) -> R
where
    f64: for<'r> Mul<&'r R, Output = R>,
    for<'r> &'r R: Sub<&'r R, Output = R>,
{
    e - &(gap * one)
}

/// The spring's share of a stop's force without its limit, and the force. Both are linear in the
/// numbers of the law and in the rows.
pub(crate) fn forces<R>(law: StopLaw, excess: &R, rate: &R) -> [R; 2]
where
    f64: for<'r> Mul<&'r R, Output = R>,
    for<'r> &'r R: Add<&'r R, Output = R>,
{
    let (stiffness, damping) = match law {
        StopLaw::Compliant { stiffness, damping, .. } => (stiffness, damping),
        StopLaw::Rigid { .. } => (0.0, 0.0),
    };
    let spring = stiffness * excess;
    let force = &spring + &(damping * rate);
    [spring, force]
}

/// The spring's share of a curved contact's force, and the force without its limit, from the
/// numbers of the law and the dissipation. Both are linear in the rows of xᵖ, of xᵖ x' and of x'.
pub(crate) fn contact_forces<R>(law: StopLaw, dissipation: f64, [power, product, rate]: [&R; 3]) -> [R; 2]
where
    f64: for<'r> Mul<&'r R, Output = R>,
    for<'r> &'r R: Add<&'r R, Output = R>,
{
    let [stiffness, damping] = match law {
        StopLaw::Compliant { stiffness, damping, .. } => [stiffness, damping],
        StopLaw::Rigid { .. } => [0.0; 2],
    };
    let spring = stiffness * power;
    let factor: f64 = [HUNT_CROSSLEY, dissipation, stiffness].into_iter().product();
    let dissipated = factor * product;
    let resting = &spring + &(damping * rate);
    [spring, &resting + &dissipated]
}

impl StopRows {
    /// Whether the force is a power of the excess.
    pub(crate) fn has_power(&self) -> bool {
        self.contact.as_ref().is_some_and(|own| own.exponent != 1.0)
    }

    /// The rows of a stop from its elongation, its excess beyond the gap, and its law.
    pub(super) fn new(elongation: Elongation, excess: Functional, law: StopLaw) -> Self {
        let [spring, force] = forces(law, &excess, &elongation.rate);
        Self {
            elongation,
            excess,
            law,
            force,
            spring,
            is_followed: false,
            level: None,
            is_freewheel: false,
            limit: None,
            contact: None,
            further: Vec::new(),
        }
    }
}

impl System {
    /// The rows of a stop with a curved force, whose curved forces are added to the machine's.
    fn curved_stop(&mut self, rows: StopRows, contact: ContactLaw) -> StopRows {
        let size = self.signals.size;
        let (rate, owner) = (&rows.elongation.rate, Part::Stop(self.stops.len()));
        let power = match contact.exponent {
            1.0 => rows.excess.clone(),
            exponent => {
                let operation = Operation::OneSided(exponent);
                self.add_operation(operation, [&rows.excess, &Functional::zeros(size)], owner)
            }
        };
        let dissipation = contact.dissipation.unwrap_or_default();
        let (product, release) = match contact.dissipation {
            None => (Functional::zeros(size), None),
            Some(_) => {
                let product = self.add_operation(Operation::Product, [&power, rate], owner);
                let slope = HUNT_CROSSLEY * dissipation * rate;
                (product, Some(&self.constant(1.0) + &slope))
            }
        };
        let [spring, force] = contact_forces(rows.law, dissipation, [&power, &product, rate]);
        let contact = ContactRows { exponent: contact.exponent, dissipation, power, product, release };
        StopRows { spring, force, contact: Some(contact), ..rows }
    }

    /// Adds the stops that elements make, with the rows of the counters of levels.
    pub(super) fn add_stops(&mut self, d: &Description, counters: &[Functional]) {
        let first = |is_own: fn(&Element) -> bool| d.elements().take_while(|own| !is_own(own)).count();
        let first_contact = first(|own| matches!(own, Element::Contact(_)));
        let first = first(|own| matches!(own, Element::Stop(_)));
        let one = self.constant(1.0);
        for MadeStop { by, level, gap, law } in made_stops(d, None) {
            let elongation = self.elongation(by.arms(d));
            let excess = excess(&elongation.e, gap, &one);
            let (element, stop) = match by {
                StopMaker::Stop(i) => (first + i, Some(i)),
                StopMaker::Contact(i) => (first_contact + i, None),
                StopMaker::Spring(i) => (i, None),
            };
            let level = level.map(|(counter, level)| StopLevel {
                counter: counters[counter].imax(),
                level: level as f64,
                stop,
            });
            self.parts[element].push(Part::Stop(self.stops.len()));
            let contact = stop.and_then(|i| d.stops[i].contact);
            let rows = StopRows { level, ..StopRows::new(elongation, excess, law) };
            let rows = match contact {
                Some(contact) => self.curved_stop(rows, contact),
                None => rows,
            };
            self.stops.push(rows);
        }
        for spring in d.springs.iter().filter(|spring| !spring.points.is_empty()) {
            self.stored_at_zero += Polyline::new(&spring.points).energy_at_zero();
        }
    }
}
