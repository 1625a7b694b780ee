//! The derivative of a mode by each parameter: of A in z' = A z, of contact forces and of event
//! functions (docs/assembly-law.md (A34)).

use super::curved::CurvesInMode;
use super::series::{Rung, Sources, Varied, orders};
use super::tangent::Tangent;
use crate::flow::{FlowTable, Ladder, RADIUS};
use crate::functional::{Functional, StateRow};
use crate::kernel::{Sparse, SparseMatrix};
use crate::law::groups::Triangle;
use crate::linear::Linear;
use crate::mode::{Contact, Mode, StopState, Watch};
use crate::norm::{LEAST_RATE, rate_bound};
use crate::quantity::{Owner, Quantity, What};
use crate::system::{Part, System};
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// Largest time between simultaneous events, as a fraction of the sum of the present time and the
/// longest time of one power series.
const INSTANT: f64 = 1e-13;

/// The derivative of a mode by one parameter.
pub(super) struct InMode {
    /// Rows of the derivative of A that are not zero, with their index.
    pub a: Vec<(usize, Sparse)>,
    /// Derivatives of the forces of the mode's basis.
    pub lambda: Vec<StateRow>,
}

/// A mode with its derivatives by all parameters.
pub(super) struct VariedMode {
    pub mode: Mode,
    /// A of z' = A z.
    pub a: SparseMatrix,
    /// The longest time of one power series, s.
    pub length: f64,
    /// Forces of the basis's contacts.
    pub lambda: Vec<StateRow>,
    pub watched: Vec<(Watch, Functional)>,
    /// The upper triangle R with RᵀR = WᵀM⁻¹W of the basis.
    pub triangle: Triangle,
    /// Contacts whose forces depend on one another, so that the law does not determine each force.
    pub shared: Vec<Contact>,
    /// Derivative of the mode, by column.
    pub by: Vec<InMode>,
    /// Entries of A that vary, with their derivatives by all columns.
    pub sources: Sources,
    /// Curved forces.
    pub curves: CurvesInMode,
    /// Flights over 2^k times an eighth of `length`, made on first use.
    pub flights: Ladder<Rung>,
    /// Work that the flights in `flights` would have saved so far. Missing flights are made once
    /// this exceeds the work of making them.
    pub saved: AtomicU64,
}

/// The parts of a mode's linear system that derivatives need.
pub(super) struct Parts {
    a: SparseMatrix,
    lambda: Vec<Sparse>,
    watched: Vec<(Watch, Arc<Sparse>)>,
    triangle: Triangle,
}

impl From<Linear> for Parts {
    fn from(linear: Linear) -> Self {
        let Linear { a, lambda, watched, triangle, .. } = linear;
        Self { a, lambda, watched, triangle }
    }
}

impl From<&FlowTable> for Parts {
    fn from(table: &FlowTable) -> Self {
        Self {
            a: table.a.clone(),
            lambda: table.lambda.clone(),
            watched: table.watched.iter().map(|own| (own.watch, own.row.clone())).collect(),
            triangle: table.triangle.clone(),
        }
    }
}

/// Tolerance for an independent contact: the fraction of its direction that another contact can
/// contribute.
const SHARE: f64 = 1e-9;

/// Returns the contacts of a mode that depend on others, and these others.
fn shared(system: &System, mode: &Mode, triangle: &Triangle) -> Vec<Contact> {
    let mut all = Vec::new();
    for contact in mode.contacts().filter(|contact| !mode.basis.contains(contact)) {
        let own = system.elongation_of(contact);
        let mut shares: Vec<f64> =
            mode.basis.iter().map(|&other| system.elongation_of(other).w.dot(&own.mobility)).collect();
        triangle.solve(&mut shares);
        let size = |contact: Contact| system.elongation_of(contact).w.amax();
        let takes = |&(&other, share): &(&Contact, &f64)| share.abs() * size(other) > SHARE * size(contact);
        all.push(contact);
        all.extend(mode.basis.iter().zip(&shares).filter(takes).map(|(&other, _)| other));
    }
    all
}

impl VariedMode {
    pub fn new(system: &System, tangents: &[Tangent], mode: &Mode, parts: Parts) -> Self {
        let Parts { a, lambda, watched, triangle } = parts;
        let length = RADIUS / rate_bound(&a, system.signals.one).max(LEAST_RATE);
        let size = system.signals.size;
        let dense = |row: &Sparse| StateRow::from_vec(row.dense(size));
        let lambda: Vec<StateRow> = lambda.iter().map(dense).collect();
        let watched = watched.into_iter().map(|(watch, row)| (watch, Functional::of(dense(&row)))).collect();
        let (by, sources) = (Vec::new(), Sources::default());
        let (flights, saved) = (Ladder::default(), AtomicU64::new(0));
        let shared = shared(system, mode, &triangle);
        let curves = tangents.iter().map(|tangent| tangent.curves.clone()).collect();
        let curves = CurvesInMode::of(system, mode, curves, &a);
        let mode = mode.clone();
        let mut made =
            Self { mode, a, length, lambda, watched, triangle, shared, by, sources, curves, flights, saved };
        let mut acceleration = DMatrix::zeros(system.coordinates, size);
        for k in 0..system.coordinates {
            made.a.row(system.coordinates + k).iter().for_each(|&(j, x)| acceleration[(k, j)] = x);
        }
        made.by = tangents.iter().map(|tangent| made.vary(system, tangent, &acceleration)).collect();
        let mut terms = Vec::new();
        for (p, InMode { a, .. }) in made.by.iter().enumerate() {
            a.iter().for_each(|(i, row)| terms.extend(row.terms().iter().map(|&(j, x)| (*i, j, p, x))));
        }
        made.sources = Sources::of(size, tangents.len(), terms);
        made
    }

    /// Approximate number of stored numbers; a sparse entry counts as two.
    pub fn numbers(&self) -> usize {
        let rows = |rows: &[StateRow]| rows.iter().map(|row| row.len()).sum::<usize>();
        let in_column =
            |own: &InMode| rows(&own.lambda) + own.a.iter().map(|row| 2 * row.1.terms().len()).sum::<usize>();
        let watched: usize = self.watched.iter().map(|own| own.1.len() + 2 * own.1.terms().len()).sum();
        let rungs = self.flights.made().map(Varied::numbers).sum::<usize>();
        let columns = self.by.iter().map(in_column).sum::<usize>();
        2 * self.a.entries() + rows(&self.lambda) + watched + columns + self.sources.0.numbers() + rungs
    }

    /// Whether a flight of length `span` up to `time` separates the events at its ends into two
    /// instants.
    pub fn parts_instants(&self, time: f64, span: f64) -> bool {
        span > INSTANT * (time.abs() + self.length)
    }

    /// Whether a quantity is a force that the law determines only in sum with others.
    pub fn is_shared(&self, system: &System, quantity: Quantity) -> bool {
        let Quantity { owner: Owner::Element(i), what: What::F } = quantity else { return false };
        system.parts_of(i, What::F).iter().any(|part| match *part {
            Part::Stop(i) => self.shared.contains(&Contact::Stop(i)),
            Part::Friction(i) => self.shared.contains(&Contact::Friction(i)),
            Part::Spring(_) | Part::Branch(_) | Part::Load(_) => false,
        })
    }

    /// Returns the state after a time of at most `length`.
    pub fn after(&self, z: &DVector<f64>, time: f64) -> DVector<f64> {
        let (mut sum, mut term, mut next) = (z.clone(), z.clone(), z.clone());
        for k in 1..=orders(RADIUS * time / self.length) {
            self.a.rows_times_to(0, term.as_slice(), time / k as f64, next.as_mut_slice());
            std::mem::swap(&mut term, &mut next);
            sum += &term;
        }
        sum
    }

    /// Returns z' at a state.
    pub fn rates(&self, z: &DVector<f64>) -> DVector<f64> {
        let mut rates = self.a.rows_times(0..z.len(), z.as_slice());
        self.curves.add_rates(z, &mut rates);
        rates
    }

    /// Returns the derivative of z' by parameter `p`. `delta` is the derivative of the state `z`
    /// by this parameter.
    pub fn rates_by(&self, p: usize, z: &DVector<f64>, delta: &DVector<f64>) -> DVector<f64> {
        let mut rates = self.a.rows_times(0..z.len(), delta.as_slice());
        self.by[p].a.iter().for_each(|(i, row)| rates[*i] += row.dot(z.as_slice()));
        if !self.curves.is_empty() {
            self.curves.add_rates_by(p, [z, &self.rates(z), delta], &mut rates);
        }
        rates
    }

    /// Returns the derivative of an event function by parameter `p`.
    pub fn row_by<'t>(
        &self,
        system: &System,
        tangent: &'t Tangent,
        p: usize,
        watch: Watch,
        row: &StateRow,
    ) -> Cow<'t, StateRow> {
        if let Watch::Meets(i) | Watch::Presses(i) = watch {
            return Cow::Borrowed(&tangent.stops[i].excess);
        }
        Cow::Owned(self.other_row_by(system, tangent, p, watch, row))
    }

    fn other_row_by(
        &self,
        system: &System,
        tangent: &Tangent,
        p: usize,
        watch: Watch,
        row: &StateRow,
    ) -> StateRow {
        let force = |contact: Contact| {
            let place = self.mode.basis.iter().position(|&c| c == contact);
            place.map_or_else(|| StateRow::zeros(row.len()), |k| self.by[p].lambda[k].clone())
        };
        match watch {
            Watch::Meets(i) | Watch::Presses(i) => tangent.stops[i].excess.clone(),
            Watch::Leaves(i) => -&tangent.stops[i].excess,
            Watch::Opens(i) => -force(Contact::Stop(i)),
            Watch::Changes(i) => {
                let (stop, by) = (&system.stops[i], &tangent.stops[i]);
                let cap = &by.force - 2.0 * &by.spring;
                let limited = by.release.as_ref().unwrap_or(&by.force);
                match self.mode.stops[i] {
                    StopState::Free => limited.clone(),
                    StopState::Capped => -cap,
                    _ if stop.limited().is_some_and(|own| *row == -&**own) => -limited,
                    _ => cap,
                }
            }
            Watch::Turns(i) => {
                let sign = if self.mode.stops[i] == StopState::Rebounding { 1.0 } else { -1.0 };
                sign * &tangent.stops[i].elongation.rate
            }
            Watch::Stops(i) => -self.mode.frictions[i].direction() * &tangent.frictions[i].elongation.rate,
            Watch::Slips(i, up) => {
                let sign = if up { 1.0 } else { -1.0 };
                let force = sign * force(Contact::Friction(i));
                match system.frictions[i].place(&self.mode.stops) {
                    Some(place) => force - &tangent.frictions[i].levels[place].static_level,
                    None => force,
                }
            }
            Watch::Yields(i, up) => {
                let by = &tangent.branches[i];
                if up { &by.force - &by.level } else { -&by.force - &by.level }
            }
            Watch::Reverses(i) => {
                let by = &tangent.branches[i];
                -self.mode.sliders[i].direction() * &by.elongation.rate + &by.sliding
            }
            Watch::Level(i) => {
                let off = self.mode.frictions[i] == crate::mode::FrictionState::Off;
                let place = system.frictions[i].place(&self.mode.stops).unwrap_or_default();
                let level = &tangent.frictions[i].levels[place].level;
                if off { level.clone() } else { -level }
            }
        }
    }

    /// Returns the derivatives of the accelerations a and contact forces λ, by differentiating M a
    /// + W λ = F z and Wᵀ a + drift z = 0.
    fn vary(&self, system: &System, tangent: &Tangent, acceleration: &DMatrix<f64>) -> InMode {
        let (n, basis) = (system.coordinates, &self.mode.basis);
        if tangent.is_zero {
            return InMode { a: Vec::new(), lambda: vec![StateRow::zeros(system.signals.size); basis.len()] };
        }
        let mut forces = tangent.forces_in(system, &self.mode);
        if tangent.varies_mass {
            forces -= &tangent.mass * acceleration;
        }
        for (&contact, force) in basis.iter().zip(&self.lambda) {
            forces.ger(-1.0, &tangent.elongation_of(contact).w, force, 1.0);
        }
        let mut change = system.inertia.solve(&forces);
        let mut lambda = Vec::new();
        if !basis.is_empty() {
            let mut demand = DMatrix::zeros(basis.len(), system.signals.size);
            for (k, &contact) in basis.iter().enumerate() {
                let own = tangent.elongation_of(contact);
                let row = change.tr_mul(&system.elongation_of(contact).w)
                    + acceleration.tr_mul(&own.w)
                    + &own.drift;
                demand.row_mut(k).copy_from(&row.transpose());
            }
            demand
                .as_mut_slice()
                .chunks_exact_mut(basis.len())
                .for_each(|column| self.triangle.solve(column));
            for (k, &contact) in basis.iter().enumerate() {
                let force = demand.row(k).transpose();
                change.ger(-1.0, &system.elongation_of(contact).mobility, &force, 1.0);
                lambda.push(force);
            }
        }
        let rows = change.row_iter().enumerate();
        let rows = rows.map(|(k, row)| (n + k, Sparse::of(row.transpose().as_slice())));
        let signals = tangent.signals.rates().map(|(i, term)| (i, Sparse::from_terms(std::iter::once(term))));
        let inner = tangent
            .first_order(system, &self.mode)
            .into_iter()
            .map(|(i, row)| (i, Sparse::of(row.as_slice())));
        let a = rows.chain(inner).filter(|(_, row)| !row.terms().is_empty()).chain(signals).collect();
        InMode { a, lambda }
    }
}
