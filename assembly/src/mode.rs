//! A mode: which stops are closed or pressed, which friction slips or sticks; and its linear system z' = A z with the
//! functionals that end it (docs/assembly-law.md (A5)).

use crate::law::ZERO;
use crate::law::box_qp::{independent, triangle};
use crate::system::{Elongation, Row, System};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// The state of a stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum StopState {
    /// A rigid stop with e < gap, or leaving it.
    Open,
    /// A rigid stop that is kept at e = gap.
    Closed,
    /// A compliant stop with e < gap.
    Below,
    /// A compliant stop with its linear force.
    Pressed,
    /// A compliant stop beyond its gap whose force would pull: it is 0.
    Free,
    /// An `ElastoGap` whose dashpot's share is as large as its spring's: the force is 2 stiffness (e - gap).
    Capped,
}

impl StopState {
    /// Whether e is beyond a compliant stop's gap.
    pub fn is_inside(self) -> bool {
        matches!(self, Self::Pressed | Self::Free | Self::Capped)
    }
}

/// The state of a friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum FrictionState {
    /// Its level is not positive.
    Off,
    /// e' > 0.
    Up,
    /// e' < 0.
    Down,
    /// e' = 0; its force follows from the motion, or is 0 where it depends on other contacts.
    Stuck,
    /// e' = 0; it depends on other contacts, and its share of their force is its level upwards.
    HeldUp,
    /// The same downwards.
    HeldDown,
}

impl FrictionState {
    /// The sign of e' while slipping, else 0.
    pub fn direction(self) -> f64 {
        match self {
            Self::Up => 1.0,
            Self::Down => -1.0,
            Self::Off | Self::Stuck | Self::HeldUp | Self::HeldDown => 0.0,
        }
    }

    /// Whether e' is kept at zero.
    pub fn sticks(self) -> bool {
        matches!(self, Self::Stuck | Self::HeldUp | Self::HeldDown)
    }
}

/// A contact that keeps e'' at zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Contact {
    /// A rigid stop, by its place.
    Stop(usize),
    /// A friction, by its place.
    Friction(usize),
}

/// The state of every element, and the independent contacts whose forces are found.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Mode {
    /// By stop.
    pub stops: Vec<StopState>,
    /// By friction.
    pub frictions: Vec<FrictionState>,
    /// Closed stops and sticking frictions that are independent of one another; the forces of the others are set to zero.
    pub basis: Vec<Contact>,
}

/// An element in a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Element {
    /// A stop, by its place.
    Stop(usize, StopState),
    /// A friction, by its place.
    Friction(usize, FrictionState),
}

impl Mode {
    /// The state of the same element.
    pub fn state_of(&self, element: Element) -> Element {
        match element {
            Element::Stop(i, _) => Element::Stop(i, self.stops[i]),
            Element::Friction(i, _) => Element::Friction(i, self.frictions[i]),
        }
    }

    /// Becomes another mode of the same machine, in its own memory.
    pub(crate) fn assign(&mut self, other: &Self) {
        self.stops.clone_from(&other.stops);
        self.frictions.clone_from(&other.frictions);
        self.basis.clone_from(&other.basis);
    }

    /// All closed stops and sticking frictions.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> {
        let closed = self.stops.iter().enumerate().filter(|(_, state)| **state == StopState::Closed);
        let sticking = self.frictions.iter().enumerate().filter(|(_, state)| state.sticks());
        closed.map(|(i, _)| Contact::Stop(i)).chain(sticking.map(|(i, _)| Contact::Friction(i)))
    }

    /// Whether its contacts are independent of one another.
    pub fn is_independent(&self) -> bool {
        self.contacts().eq(self.basis.iter().copied())
    }
}

/// What a watched functional tells when it passes from below zero to above.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Watch {
    /// A rigid stop meets its gap.
    Meets(usize),
    /// A closed stop's force falls to zero.
    Opens(usize),
    /// A compliant stop comes to its gap from below.
    Presses(usize),
    /// A compliant stop's force falls to zero or rises from it, or meets its cap.
    Changes(usize),
    /// A compliant stop without its linear force is left: e falls to the gap.
    Leaves(usize),
    /// A slipping friction's rate comes to zero.
    Stops(usize),
    /// A sticking friction's force reaches its level, upwards (true) or downwards.
    Slips(usize, bool),
    /// A friction's level passes zero.
    Level(usize),
}

impl Watch {
    /// Whether it is a functional of an element.
    pub fn is_of(self, element: Element) -> bool {
        match self {
            Self::Meets(i) | Self::Opens(i) | Self::Presses(i) | Self::Changes(i) | Self::Leaves(i) => {
                matches!(element, Element::Stop(own, _) if own == i)
            }
            Self::Stops(i) | Self::Slips(i, _) | Self::Level(i) => {
                matches!(element, Element::Friction(own, _) if own == i)
            }
        }
    }
}

/// The linear system of a mode.
#[derive(Clone, Debug)]
pub struct Linear {
    /// z' = A z.
    pub a: DMatrix<f64>,
    /// By entry of A the sizes of the terms that it is the sum of: what a closed stop cancels leaves rounding of these.
    pub terms: DMatrix<f64>,
    /// The forces of the basis, by its order.
    pub lambda: Vec<Row>,
    /// The upper triangle R with RᵀR = WᵀM⁻¹W of the basis.
    pub triangle: DMatrix<f64>,
    /// What ends the mode, each negative inside it.
    pub watched: Vec<(Watch, Row)>,
}

impl System {
    /// The elongation of a contact.
    pub fn elongation_of(&self, contact: Contact) -> &Elongation {
        match contact {
            Contact::Stop(i) => &self.stops[i].elongation,
            Contact::Friction(i) => &self.frictions[i].elongation,
        }
    }

    /// The force of a stop in a state in which the state determines it: compliant ones.
    pub fn stop_force(&self, i: usize, state: StopState) -> Option<Row> {
        match state {
            StopState::Pressed => Some(self.stops[i].force.clone()),
            StopState::Capped => Some(2.0 * &self.stops[i].spring),
            _ => None,
        }
    }

    /// The force of a friction in a state in which the state determines it: slipping, or at its level while it sticks.
    pub fn friction_force(&self, i: usize, state: FrictionState) -> Option<Row> {
        let friction = &self.frictions[i];
        match state {
            FrictionState::Up => Some(friction.level.clone()),
            FrictionState::Down => Some(-&friction.level),
            FrictionState::HeldUp => Some(friction.static_level.clone()),
            FrictionState::HeldDown => Some(-&friction.static_level),
            FrictionState::Off | FrictionState::Stuck => None,
        }
    }

    /// The value of [`stop_force`](Self::stop_force).
    pub fn stop_force_at(&self, i: usize, state: StopState, z: &DVector<f64>) -> Option<f64> {
        let z = z.as_slice();
        match state {
            StopState::Pressed => Some(self.stops[i].force_terms.dot(z)),
            StopState::Capped => Some(2.0 * self.stops[i].spring_terms.dot(z)),
            _ => None,
        }
    }

    /// The value of [`friction_force`](Self::friction_force).
    pub fn friction_force_at(&self, i: usize, state: FrictionState, z: &DVector<f64>) -> Option<f64> {
        let friction = &self.frictions[i];
        match state {
            FrictionState::Up => Some(friction.level.dot(z)),
            FrictionState::Down => Some(-friction.level.dot(z)),
            FrictionState::HeldUp => Some(friction.static_level.dot(z)),
            FrictionState::HeldDown => Some(-friction.static_level.dot(z)),
            FrictionState::Off | FrictionState::Stuck => None,
        }
    }

    /// M⁻¹ times the forces that the state determines in given states: accelerations without contact forces.
    pub fn free_acceleration(&self, stops: &[StopState], frictions: &[FrictionState]) -> DMatrix<f64> {
        let mut forces = self.forces.clone();
        for (i, &state) in stops.iter().enumerate() {
            if let Some(force) = self.stop_force(i, state) {
                add_outer(&mut forces, &self.stops[i].elongation.w, &force);
            }
        }
        for (i, &state) in frictions.iter().enumerate() {
            if let Some(force) = self.friction_force(i, state) {
                add_outer(&mut forces, &self.frictions[i].elongation.w, &force);
            }
        }
        // Forces are summed up before they are divided, so that what cancels leaves zeros.
        if self.is_diagonal {
            for (mut row, inertia) in forces.row_iter_mut().zip(self.mass.diagonal().iter()) {
                row /= *inertia;
            }
            return forces;
        }
        self.inertia.solve(&forces)
    }

    /// L⁻¹ w of several contacts as columns.
    pub fn columns(&self, contacts: &[Contact]) -> DMatrix<f64> {
        let mut columns = DMatrix::zeros(self.coordinates, contacts.len());
        for (k, &contact) in contacts.iter().enumerate() {
            columns.set_column(k, &self.elongation_of(contact).column);
        }
        columns
    }

    /// An independent part of contacts, in their order of preference.
    pub fn independent(&self, contacts: &[Contact]) -> Vec<Contact> {
        let places: Vec<usize> = (0..contacts.len()).collect();
        let mut basis: Vec<Contact> =
            independent(&self.columns(contacts), &places).into_iter().map(|k| contacts[k]).collect();
        basis.sort();
        basis
    }

    /// The mode in which an element has another state.
    pub fn with_element(&self, mode: &Mode, element: Element) -> Mode {
        let mut mode = mode.clone();
        match element {
            Element::Stop(i, state) => mode.stops[i] = state,
            Element::Friction(i, state) => mode.frictions[i] = state,
        }
        mode.basis = self.independent(&mode.contacts().collect::<Vec<_>>());
        mode
    }

    /// The linear system of a mode.
    pub fn linear(&self, mode: &Mode) -> Linear {
        let (n, size) = (self.coordinates, self.signals.size);
        let mut acceleration = self.free_acceleration(&mode.stops, &mode.frictions);
        let mut acceleration_terms = acceleration.abs();
        let m = mode.basis.len();
        let mut lambda = Vec::new();
        let columns = self.columns(&mode.basis);
        let r = triangle(&columns);
        if m > 0 {
            let mut demand = DMatrix::zeros(m, size); // e'' without contact forces
            for (k, &contact) in mode.basis.iter().enumerate() {
                let e = self.elongation_of(contact);
                let row = acceleration.tr_mul(&e.w) + &e.drift;
                demand.set_row(k, &row.transpose());
            }
            let sizes = demand.abs();
            r.tr_solve_upper_triangular_mut(&mut demand);
            r.solve_upper_triangular_mut(&mut demand);
            clean(&mut demand, &columns, &sizes);
            let mut directions = DMatrix::zeros(n, m);
            for (k, &contact) in mode.basis.iter().enumerate() {
                directions.set_column(k, &self.elongation_of(contact).w);
                lambda.push(demand.row(k).transpose());
            }
            let mobility = self.inertia.solve(&directions);
            acceleration_terms += mobility.abs() * demand.abs();
            acceleration -= mobility * &demand;
        }
        let mut a = DMatrix::zeros(size, size);
        for k in 0..n {
            a[(k, n + k)] = 1.0;
        }
        a.view_mut((n, 0), (n, size)).copy_from(&acceleration);
        for j in self.signals.one..size {
            let mut unit = Row::zeros(size);
            unit[j] = 1.0;
            a.row_mut(j).copy_from(&self.signals.derivative(&unit).transpose());
        }
        let mut terms = a.abs();
        terms.view_mut((n, 0), (n, size)).copy_from(&acceleration_terms);
        let watched = self.watched(mode, &lambda);
        Linear { a, terms, lambda, triangle: r, watched }
    }

    /// The functionals that end a mode.
    fn watched(&self, mode: &Mode, lambda: &[Row]) -> Vec<(Watch, Row)> {
        let mut watched = Vec::new();
        for (i, &state) in mode.stops.iter().enumerate() {
            let stop = &self.stops[i];
            let damped = stop.force != stop.spring;
            match state {
                StopState::Open => watched.push((Watch::Meets(i), stop.excess.clone())),
                StopState::Closed => {}
                StopState::Below => watched.push((Watch::Presses(i), stop.excess.clone())),
                StopState::Pressed => {
                    watched.push((Watch::Changes(i), -&stop.force));
                    if stop.is_elastogap() && damped {
                        watched.push((Watch::Changes(i), &stop.force - 2.0 * &stop.spring));
                    }
                }
                StopState::Free => {
                    watched.push((Watch::Changes(i), stop.force.clone()));
                    watched.push((Watch::Leaves(i), -&stop.excess));
                }
                StopState::Capped => {
                    watched.push((Watch::Changes(i), 2.0 * &stop.spring - &stop.force));
                    watched.push((Watch::Leaves(i), -&stop.excess));
                }
            }
        }
        for (i, (&state, friction)) in mode.frictions.iter().zip(&self.frictions).enumerate() {
            match state {
                FrictionState::Off => watched.push((Watch::Level(i), friction.level.clone())),
                FrictionState::Up | FrictionState::Down => {
                    watched.push((Watch::Stops(i), -state.direction() * &friction.elongation.rate));
                    watched.push((Watch::Level(i), -&friction.level));
                }
                FrictionState::Stuck | FrictionState::HeldUp | FrictionState::HeldDown => {
                    watched.push((Watch::Level(i), -&friction.level));
                }
            }
        }
        for (&contact, force) in mode.basis.iter().zip(lambda) {
            match contact {
                Contact::Stop(i) => watched.push((Watch::Opens(i), -force)),
                Contact::Friction(i) => {
                    let level = &self.frictions[i].static_level;
                    watched.push((Watch::Slips(i, true), force - level));
                    watched.push((Watch::Slips(i, false), -force - level));
                }
            }
        }
        // What never changes needs no watch: a level that is a positive constant, say.
        watched.retain(|(_, row)| !self.is_constant_and_negative(row));
        watched
    }

    fn is_constant_and_negative(&self, row: &DVector<f64>) -> bool {
        let one = self.signals.one;
        row[one] < 0.0 && row.iter().enumerate().all(|(j, &x)| j == one || x == 0.0)
    }
}

/// Takes a force in a direction from the forces on the coordinates.
fn add_outer(forces: &mut DMatrix<f64>, w: &DVector<f64>, force: &Row) {
    for (i, &w) in w.iter().enumerate().filter(|(_, w)| **w != 0.0) {
        forces.row_mut(i).iter_mut().zip(force.iter()).for_each(|(sum, f)| *sum -= w * f);
    }
}

/// Takes the rounding out of the forces' rows, so that a force that is zero throughout is known to be: `demands` are the sizes of
/// what each contact has to hold against. A contact's force is at most of the size of what contacts that share coordinates with
/// it, directly or through others, hold against.
fn clean(forces: &mut DMatrix<f64>, columns: &DMatrix<f64>, demands: &DMatrix<f64>) {
    let (m, size) = forces.shape();
    let norms: Vec<f64> = columns.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let shares = |i: usize, j: usize| columns.column(i).abs().dot(&columns.column(j).abs()) > 0.0;
    let mut group: Vec<usize> = (0..m).collect();
    for i in 0..m {
        for j in 0..i {
            if group[i] != group[j] && shares(i, j) {
                let (from, to) = (group[i], group[j]);
                group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
            }
        }
    }
    for column in 0..size {
        for k in 0..m {
            let others = (0..m).filter(|&i| group[i] == group[k]);
            let largest = others.map(|i| demands[(i, column)] / norms[i]).fold(0.0, f64::max);
            if forces[(k, column)].abs() <= ZERO * largest / norms[k] {
                forces[(k, column)] = 0.0;
            }
        }
    }
}
