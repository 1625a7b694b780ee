//! A machine and its derivatives with respect to some parameters.

use super::by::By;
use super::lost::{Cause, Lost};
use super::mode::{Parts, VariedMode};
use super::rows::ElongationTangent;
use super::tangent::Tangent;
use super::values::Point;
use crate::assembly::Assembly;
use crate::error::Error;
use crate::functional::{Functional, StateRow};
use crate::law::ZERO;
use crate::mode::{Contact, Mode, StopState, Watch};
use crate::motion::Motion;
use crate::signals::Layout;
use crate::system::{Acting, Elongation, System};
use nalgebra::DVector;
use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Deref;
use std::sync::{Arc, Mutex, PoisonError};

/// A varied value counts as zero up to this fraction of the sum of its terms' sizes. It is far
/// above rounding, and far below the effect of a parameter that matters.
pub(super) const STILL: f64 = 1e-9;
/// A crossing slower than this fraction of the sizes of its rate's terms is a touch.
pub(super) const TOUCH: f64 = 1e-12;
/// Next to an event, a value counts as zero up to this multiple of the usual zero tolerance.
pub(super) const BESIDE: f64 = 4.0;

/// An event function counts as unmoved by a number if a change by the whole number moves the
/// function by at most this fraction of the sum of its terms' sizes: rounding.
const UNMOVED: f64 = 1e-12;

/// The matrices of a machine, with a coordinate for everything that may vary.
#[derive(Clone, Debug)]
pub(super) enum Matrices {
    /// The assembly's matrices already have these coordinates.
    Known(Arc<Assembly>),
    /// Matrices of another layout, and each coordinate's index in the assembly's augmented state.
    Own(Box<System>, Vec<Option<usize>>),
    /// The assembly's matrices in another configuration of residual flexibility.
    Configured(Box<System>),
}

impl Deref for Matrices {
    type Target = System;

    fn deref(&self) -> &System {
        match self {
            Self::Known(assembly) => &assembly.system,
            Self::Own(system, _) | Self::Configured(system) => system,
        }
    }
}

/// A machine, its matrices with a coordinate for everything that may vary, and their derivatives.
#[derive(Clone, Debug)]
pub(super) struct Machine {
    pub assembly: Arc<Assembly>,
    pub system: Matrices,
    /// The columns of derivatives.
    pub columns: Vec<By>,
    /// Derivatives of the matrices, by column.
    pub tangents: Vec<Tangent>,
    /// This machine in other configurations of residual flexibility, made when a motion enters
    /// them.
    configured: Arc<Mutex<HashMap<Vec<Acting>, Arc<Self>>>>,
}

/// A motion's derivatives keep up to this number of configurations.
const KEPT: usize = 64;

/// Whether a row's value counts as zero; `sizes` has the sizes of the state.
fn is_zero(row: &Functional, z: &DVector<f64>, sizes: &DVector<f64>) -> bool {
    row.at(z.as_slice()).abs() <= BESIDE * ZERO * row.size(sizes.as_slice())
}

/// The mode, state, time derivative of the state, and sizes at one instant.
pub(super) struct Instant<'m, 'a> {
    pub mode: &'m VariedMode,
    pub z: &'a DVector<f64>,
    pub rates: &'a DVector<f64>,
    pub sizes: &'a DVector<f64>,
    pub time: f64,
}

/// The derivative of a state with respect to parameter `p`.
#[derive(Clone, Copy)]
pub(super) struct Varied<'a> {
    pub p: usize,
    pub delta: &'a DVector<f64>,
    /// Past maxima of the sizes of `delta`, which distinguish rounding from a variation.
    pub scale: &'a DVector<f64>,
}

impl Machine {
    pub fn new(assembly: Arc<Assembly>, columns: Vec<By>) -> Result<Self, Error> {
        let columns = By::known(columns, &assembly)?;
        let d = &assembly.description;
        let follow = columns.iter().flat_map(|by| d.named.numbers_of(by.parameter()));
        let names: Vec<_> = columns.iter().map(By::parameter).chain(follow).collect();
        let any = |end: &str| names.iter().any(|name| name.ends_with(end));
        let layout = Layout { frequencies_apart: any(".frequency"), rates: any(".motion.rate") };
        let system = if layout == Layout::default() {
            Matrices::Known(assembly.clone())
        } else {
            let system = System::laid_out(d, layout)?;
            let places = system.signals.places_in(&assembly.system.signals);
            let is_own = places.len() == assembly.system.signals.size
                && places.iter().enumerate().all(|(j, place)| *place == Some(j));
            if is_own { Matrices::Known(assembly.clone()) } else { Matrices::Own(Box::new(system), places) }
        };
        let tangents = columns.iter().map(|by| Tangent::new(&system, d, by.parameter())).collect();
        Ok(Self { assembly, system, columns, tangents, configured: Arc::default() })
    }

    /// The machine with the rows of a mode; `None` if it already has these rows. Only residual
    /// flexibility makes rows depend on the mode.
    pub fn at_mode(&self, mode: &Mode) -> Option<Arc<Self>> {
        let acting = self.system.acting_in(mode)?;
        let mut known = self.configured.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = known.get(&acting) {
            return Some(known.clone());
        }
        let system = Box::new(self.system.configured(acting.clone())?);
        let system = match &self.system {
            Matrices::Own(_, places) => Matrices::Own(system, places.clone()),
            _ => Matrices::Configured(system),
        };
        let d = &self.assembly.description;
        let moved = self.columns.iter().zip(&self.tangents).map(|(by, own)| {
            let mut tangent = Tangent::new(&system, d, by.parameter());
            // The signals of a motion under way continue from its state.
            tangent.signals = own.signals.clone();
            tangent
        });
        let (tangents, configured) = (moved.collect(), self.configured.clone());
        let (assembly, columns) = (self.assembly.clone(), self.columns.clone());
        let made = Arc::new(Self { assembly, system, columns, tangents, configured });
        if known.len() >= KEPT {
            known.clear();
        }
        known.insert(acting, made.clone());
        Some(made)
    }

    /// Returns the machine whose parameters vary after `time`. The integrals of prescribed motions
    /// continue from their present values.
    pub fn under_way(mut self, time: f64, z: &DVector<f64>) -> Self {
        let bodies = self.assembly.description.bodies.iter().enumerate();
        let prescribed = bodies.filter(|(_, body)| body.kind.is_prescribed()).map(|(i, _)| i).enumerate();
        let integrals =
            prescribed.filter_map(|(signal, body)| Some((self.system.signals.integral(signal)?, body)));
        for ((first, order), body) in integrals.collect::<Vec<_>>() {
            let rows = self.system.bodies[body].clone();
            for p in 0..self.tangents.len() {
                let mut delta = DVector::zeros(z.len());
                self.fill(p, time, z, &mut delta);
                let by = &self.tangents[p].bodies[body];
                let moved = [by.s.dot(z) + rows.s.dot(&delta), by.v.dot(z) + rows.v.dot(&delta)];
                let moved = [moved[0], if order == 2 { moved[1] } else { 0.0 }];
                self.tangents[p].signals.go_on(first, time, moved);
            }
        }
        self
    }

    /// Converts a vector from the assembly's augmented state to the coordinates of `system`.
    pub fn widened<'a>(&self, z: &'a DVector<f64>) -> Cow<'a, DVector<f64>> {
        match &self.system {
            Matrices::Known(_) | Matrices::Configured(_) => Cow::Borrowed(z),
            Matrices::Own(_, places) => {
                let all = places.iter().map(|place| place.map_or(0.0, |j| z[j]));
                let mut all = DVector::from_iterator(places.len(), all);
                self.system.fill_curved(all.as_mut_slice());
                Cow::Owned(all)
            }
        }
    }

    /// Returns the present mode of a motion; if `varied`, with its derivatives by all columns.
    pub fn mode_of(&self, motion: &Motion, varied: bool) -> VariedMode {
        let parts = match &self.system {
            Matrices::Known(_) | Matrices::Configured(_) => Parts::from(motion.flow_of_mode()),
            Matrices::Own(system, _) => Parts::from(system.linear(motion.mode())),
        };
        let tangents = if varied { &self.tangents[..] } else { &[] };
        VariedMode::new(&self.system, tangents, motion.mode(), parts)
    }

    /// Returns the elongation of a watched element, with its derivative by parameter `p`.
    pub fn elongation(&self, watch: Watch, p: usize) -> (&Elongation, &ElongationTangent) {
        self.contact(watch.contact(), p)
    }

    /// Returns a contact's elongation with its derivative by parameter `p`.
    pub fn contact(&self, contact: Contact, p: usize) -> (&Elongation, &ElongationTangent) {
        (self.system.elongation_of(contact), self.tangents[p].elongation_of(contact))
    }

    /// Writes the signals' derivatives just after a time.
    pub fn fill(&self, p: usize, time: f64, z: &DVector<f64>, delta: &mut DVector<f64>) {
        let one = self.system.signals.one;
        self.tangents[p].signals.fill(one, time, z.as_slice(), delta.as_mut_slice());
    }

    /// Writes the derivatives of the curved forces into the derivative of a state.
    pub fn vary_curved(&self, p: usize, z: &DVector<f64>, delta: &mut DVector<f64>) {
        self.tangents[p].vary_curved(&self.system, z, delta);
    }

    /// Whether knots of signals leave all columns unchanged while no contact is held and no event
    /// function is zero.
    pub fn is_fixed_at_knots(&self) -> bool {
        !self.varies_signals() && !self.system.has_motions && self.system.branches.is_empty()
    }

    /// Whether the value of each event function differs from zero by more than rounding.
    pub fn is_clear(&self, mode: &VariedMode, z: &DVector<f64>, sizes: &DVector<f64>) -> bool {
        !mode.watched.iter().any(|(_, row)| is_zero(row, z, sizes))
    }

    /// Whether a column varies the coordinates of signals.
    pub fn varies_signals(&self) -> bool {
        self.tangents.iter().any(|tangent| tangent.signals.varies())
    }

    pub fn name_of(&self, contact: Contact) -> String {
        self.assembly.name_of_contact(contact)
    }

    /// Returns the change of the velocities after a unit impulse of an element, with the reaction
    /// of the held contacts.
    fn response(&self, mode: &VariedMode, e: &Elongation) -> DVector<f64> {
        let basis = &mode.mode.basis;
        let mut response = (*e.mobility).clone();
        if !basis.is_empty() {
            let off = basis.iter().map(|&contact| self.system.elongation_of(contact).w.dot(&response));
            let mut off: Vec<f64> = off.collect();
            mode.triangle.solve(&mut off);
            for (&contact, off) in basis.iter().zip(off.iter()) {
                response.axpy(-off, &self.system.elongation_of(contact).mobility, 1.0);
            }
        }
        response
    }

    /// Whether an event of one of two elements changes how the other comes to its limit: an
    /// impulse of one moves the other, or the rate of one exerts a force on the other.
    pub fn are_coupled(&self, mode: &VariedMode, a: &Elongation, b: &Elongation) -> bool {
        let n = self.system.coordinates;
        let couples = |a: &Elongation, b: &Elongation| {
            let response = self.response(mode, b);
            let size = a.w.abs().dot(&b.mobility.abs());
            let mut kicked = DVector::zeros(self.system.signals.size);
            kicked.rows_mut(n, n).copy_from(&response);
            let rates = mode.rates(&kicked).rows(n, n).into_owned();
            let force: f64 = a.w.dot(&rates).abs();
            a.w.dot(&response).abs() > STILL * size || force > STILL * a.w.abs().dot(&rates.abs())
        };
        couples(a, b) || couples(b, a)
    }

    /// Returns the delay with which an event function passes zero in the changed motion: δt =
    /// -(h·δ + dh·z) / (h·z'). `Err` if the function only touches zero and its value varies.
    pub fn later(&self, column: Varied, at: &Instant, (row, by): (&StateRow, &StateRow)) -> Result<f64, ()> {
        let point = self.point(column, at);
        let (varied, speed) = (point.of(row, by), row.dot(at.rates));
        let terms: f64 = row.iter().zip(at.rates.iter()).map(|(a, b)| (a * b).abs()).sum();
        if speed.abs() > TOUCH * terms {
            return Ok(-varied / speed);
        }
        if varied.abs() <= STILL * point.size(row, by) { Ok(0.0) } else { Err(()) }
    }

    /// Combines the instant with the derivative of its state.
    pub fn point<'a>(&'a self, column: Varied<'a>, at: &Instant<'a, 'a>) -> Point<'a> {
        let Varied { p, delta, scale } = column;
        Point { system: &self.system, tangent: &self.tangents[p], mode: at.mode, p, z: at.z, delta, scale }
    }

    /// Whether a row's value counts as zero at an instant.
    pub fn is_zero(&self, row: &Functional, at: &Instant) -> bool {
        is_zero(row, at.z, at.sizes)
    }

    /// Returns the event functions that reach zero at this instant.
    pub fn approaching<'m>(&self, at: &Instant<'m, '_>) -> Vec<&'m (Watch, Functional)> {
        let comes = |row: &StateRow| row.dot(at.rates) > TOUCH * self.speed_size(row, at);
        at.mode.watched.iter().filter(|(_, row)| self.is_zero(row, at) && comes(row)).collect()
    }

    /// Returns the event functions that are zero and stay zero to first order, or whose crossing
    /// changes forces at once. If `begins` is true, returns all that are zero, unless forces are
    /// continuous there.
    pub fn still<'m>(&self, at: &Instant<'m, '_>, begins: bool) -> Vec<&'m (Watch, Functional)> {
        let stays = |row: &StateRow| row.dot(at.rates).abs() <= TOUCH * self.speed_size(row, at);
        let counts = |watch: Watch, row: &StateRow| match begins {
            true => !self.is_smooth(watch),
            false => stays(row) || self.is_sharp(watch),
        };
        let all = at.mode.watched.iter();
        all.filter(|(watch, row)| self.is_zero(row, at) && counts(*watch, row)).collect()
    }

    /// The sum of the sizes of the terms of an event function's time derivative.
    pub fn speed_size(&self, row: &StateRow, at: &Instant) -> f64 {
        self.terms_of(row, at.rates)
    }

    /// The sum of the sizes of the terms of a row's value.
    pub(super) fn terms_of(&self, row: &StateRow, z: &DVector<f64>) -> f64 {
        row.iter().zip(z.iter()).map(|(a, b)| (a * b).abs()).sum()
    }

    /// Projects a derivative onto the contacts' constraints, h·δ = -dh·z for gaps and rates. Fails
    /// if a dependent contact does not follow: its derivatives exist on one side only.
    pub fn keep(
        &self,
        p: usize,
        delta: &mut DVector<f64>,
        scale: &DVector<f64>,
        at: &Instant,
    ) -> Result<(), Lost> {
        let basis = &at.mode.mode.basis;
        let stops = basis.iter().take_while(|contact| self.system.keeps_place(**contact)).count();
        self.project(p, &basis[..stops], false, delta, at);
        self.project(p, basis, true, delta, at);
        self.vary_curved(p, at.z, delta);
        self.keep_levels(p, delta, at, |_| None);
        self.check_frictionless(p, at)?;
        for contact in at.mode.mode.contacts().filter(|contact| !basis.contains(contact)) {
            if self.turns_away(p, at.mode, contact) {
                return Err(Lost { time: at.time, element: self.name_of(contact), cause: Cause::Limit });
            }
            let places = if self.system.keeps_place(contact) { &[false, true][..] } else { &[true][..] };
            for &rates in places {
                let (row, by) = self.held_row(contact, rates, p);
                let point = self.point(Varied { p, delta, scale }, at);
                if point.of(row, by).abs() > STILL * point.size(row, by) {
                    return Err(Lost { time: at.time, element: self.name_of(contact), cause: Cause::Limit });
                }
            }
        }
        Ok(())
    }

    /// Checks that no coefficient of friction grows from zero at a pressed contact. Its force would
    /// oppose the slip, and a negative coefficient does not exist.
    fn check_frictionless(&self, p: usize, at: &Instant) -> Result<(), Lost> {
        let branches = self.system.branches.iter().zip(&self.tangents[p].branches);
        for (i, (branch, by)) in branches.enumerate() {
            let Some(stop) = branch.stop().filter(|_| branch.is_frictionless()) else { continue };
            if by.level.amax() > 0.0 && at.mode.mode.stops[stop] == StopState::Pressed {
                let element = self.name_of(Contact::Slider(i));
                return Err(Lost { time: at.time, element, cause: Cause::Limit });
            }
        }
        Ok(())
    }

    /// Whether a contact that depends on a basis varies its direction differently from the basis.
    /// It is then independent in the changed machine.
    fn turns_away(&self, p: usize, mode: &VariedMode, contact: Contact) -> bool {
        let (own, by) = self.contact(contact, p);
        let shares = mode.mode.basis.iter().map(|&c| self.contact(c, p).0.w.dot(&own.mobility));
        let mut shares: Vec<f64> = shares.collect();
        mode.triangle.solve(&mut shares);
        let (mut left, mut size) = (by.w.clone(), by.w.amax());
        for (&other, &share) in mode.mode.basis.iter().zip(&shares) {
            left.axpy(-share, &self.contact(other, p).1.w, 1.0);
            size += share.abs() * self.contact(other, p).1.w.amax();
        }
        left.amax() > STILL * size
    }

    /// Returns the row that a contact keeps at zero, e - gap of a stop or e', with its derivative.
    pub(super) fn held_row(&self, contact: Contact, rates: bool, p: usize) -> (&StateRow, &StateRow) {
        match contact {
            Contact::Stop(i) if !rates => (&self.system.stops[i].excess, &self.tangents[p].stops[i].excess),
            _ => {
                let (own, by) = self.contact(contact, p);
                (&own.rate, &by.rate)
            }
        }
    }

    fn project(&self, p: usize, contacts: &[Contact], rates: bool, delta: &mut DVector<f64>, at: &Instant) {
        if contacts.is_empty() {
            return;
        }
        let off = contacts.iter().map(|&contact| {
            let (row, by) = self.held_row(contact, rates, p);
            self.point(Varied { p, delta, scale: delta }, at).of(row, by)
        });
        // The basis is sorted: stops come first.
        let mut off: Vec<f64> = off.collect();
        at.mode.triangle.solve(&mut off);
        let n = self.system.coordinates;
        for (&contact, &off) in contacts.iter().zip(&off) {
            let mobility = &self.system.elongation_of(contact).mobility;
            delta.rows_mut(if rates { n } else { 0 }, n).axpy(-off, mobility, 1.0);
        }
    }

    /// Checks that none of the event functions `still`, which are zero throughout the mode,
    /// varies: otherwise the changed motion has another mode on one side.
    pub fn check(&self, column: Varied, at: &Instant, still: &[&(Watch, Functional)]) -> Result<(), Lost> {
        for (watch, row) in still {
            let by = at.mode.row_by(&self.system, &self.tangents[column.p], column.p, *watch, row);
            let point = self.point(column, at);
            let moved = point.of(row, &by).abs();
            if moved > STILL * point.size(row, &by)
                && moved * self.value_of(column.p) > UNMOVED * row.size(at.sizes.as_slice())
            {
                let element = self.assembly.name_of(*watch);
                return Err(Lost { time: at.time, element, cause: Cause::Limit });
            }
        }
        Ok(())
    }

    /// The absolute value of a column's number; infinite for a start and for a number that is zero.
    /// The number is looked up by its name among all numbers of the machine, which takes time.
    fn value_of(&self, p: usize) -> f64 {
        let value = match &self.columns[p] {
            By::Parameter(name) => self.assembly.description.get(name).map_or(0.0, f64::abs),
            By::Start(_) | By::Time => 0.0,
        };
        if value == 0.0 { f64::INFINITY } else { value }
    }

    /// Whether the force of an unmoved contact jumps where this event function passes zero.
    fn is_sharp(&self, watch: Watch) -> bool {
        match watch {
            Watch::Stops(_) => true,
            Watch::Slips(i, _) => self.system.frictions[i].has_static,
            _ => false,
        }
    }

    /// Whether a touch of this event function matters. The changed motion passes zero for a time
    /// of the order √δ. An impact or a force that jumps there changes rates by the order √δ or δ;
    /// a continuous force changes rates by δ√δ.
    pub fn is_touchy(&self, watch: Watch) -> bool {
        match watch {
            Watch::Meets(_) => true,
            Watch::Presses(_) => !self.is_smooth(watch),
            Watch::Leaves(i) => !self.system.stops[i].is_limited() && !self.is_smooth(watch),
            _ => self.is_sharp(watch),
        }
    }

    /// Refuses a column that varies the value or the rate of an event function that touches zero
    /// now. If only the time of the touch varies, the next order decides whether zero is passed.
    pub fn check_touch(&self, column: Varied, at: &Instant, place: usize) -> Result<(), Lost> {
        let (watch, row) = &at.mode.watched[place];
        let by = at.mode.row_by(&self.system, &self.tangents[column.p], column.p, *watch, row);
        let point = self.point(column, at);
        let n = self.system.coordinates;
        let (changes, mut sizes) = (at.mode.rates_by(column.p, at.z, column.delta), column.scale.clone());
        (0..sizes.len()).for_each(|j| sizes[j] = if j < n { sizes[n + j] } else { 0.0 });
        let rate = row.dot(&changes) + by.dot(at.rates);
        let size = self.terms_of(row, &sizes.sup(&changes.abs())) + self.terms_of(&by, at.rates);
        if point.of(row, &by).abs() <= STILL * point.size(row, &by) && rate.abs() <= STILL * size {
            return Ok(());
        }
        Err(Lost { time: at.time, element: self.assembly.name_of(*watch), cause: Cause::Touch })
    }

    /// Whether the force is continuous where this event function passes zero: for a branch with a
    /// slider and for a stop that has no damping, or none there; dissipation ends at the edge.
    pub fn is_smooth(&self, watch: Watch) -> bool {
        match watch {
            Watch::Turns(_) | Watch::Yields(..) | Watch::Reverses(_) => true,
            Watch::Leaves(i) if self.system.stops[i].may_rebound() => true,
            Watch::Presses(i) | Watch::Changes(i) | Watch::Leaves(i) => {
                let stop = &self.system.stops[i];
                !stop.is_damped() || stop.releases()
            }
            _ => false,
        }
    }
}
