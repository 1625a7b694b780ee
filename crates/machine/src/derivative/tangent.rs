//! The derivative of a machine's rows and matrices by one parameter (docs/assembly-law.md (A32)).

use super::bodies::bodies;
use super::curved::CurveTangent;
use super::residual::ResidualTangent;
use super::rows::{
    BlockTangents, BodyTangent, BranchTangent, ElongationTangent, FrictionTangent, LevelTangent, StopTangent,
};
use crate::curved::Polynomial;
use crate::description::{
    Arms, BodyKind, Description, Follows, Free, Signal, StopLaw, Stribeck, StribeckExponent,
};
use crate::formula::{Formula, Line, Step};
use crate::functional::{Functional, StateRow};
use crate::mode::{Contact, FrictionState, Mode, StopState};
use crate::polyline::Polyline;
use crate::signals::{Course, SignalTangent};
use crate::slots::slots;
use crate::stepped;
use crate::system::{
    ContactRows, Elongation, FrictionRows, Part, SpringRows, StopMaker, System, excess, made_stops,
};
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;

/// The derivative of a [`System`] by one parameter.
#[derive(Clone, Debug)]
pub(super) struct Tangent {
    /// Whether the column varies no number of the machine.
    pub is_zero: bool,
    /// Whether the column varies the inertia matrix.
    pub varies_mass: bool,
    pub signals: SignalTangent,
    pub bodies: Vec<BodyTangent>,
    /// Derivative of the inertia, by body.
    pub inertias: Vec<f64>,
    pub mass: DMatrix<f64>,
    /// Derivatives of the forces that act in every mode.
    pub forces: DMatrix<f64>,
    /// Derivatives of each spring's elongation and force.
    pub springs: Vec<(ElongationTangent, StateRow)>,
    pub stops: Vec<StopTangent>,
    pub frictions: Vec<FrictionTangent>,
    pub branches: Vec<BranchTangent>,
    /// Derivative of each curved force.
    pub curves: Vec<CurveTangent>,
    /// Derivatives of the operations of each formula, until [`Self::put_curves`] moves them into
    /// `curves`.
    of_formulas: Vec<Vec<CurveTangent>>,
    /// Derivative of each load's force.
    pub loads: Vec<StateRow>,
    /// Derivatives of the start values of place and rate, by coordinate.
    pub starts: Vec<(f64, f64)>,
    /// Derivative of the start value of each state of first order.
    pub inner: Vec<f64>,
    pub blocks: BlockTangents,
    /// Derivatives of the forces on residual flexibility.
    pub residual: Option<ResidualTangent>,
}

/// A description whose numbers are the derivatives of `d`'s numbers by the parameter `name`.
fn direction(d: &Description, name: &str) -> Description {
    let mut along = d.clone();
    // Numbers that are not parameters, such as arms between two bodies, have the derivative 0.
    let springs = along.springs.iter_mut().map(|s| &mut s.arms);
    let dampers = along.dampers.iter_mut().map(|s| &mut s.arms);
    let stops = along.stops.iter_mut().map(|s| &mut s.arms);
    let frictions = along.frictions.iter_mut().map(|s| &mut s.arms);
    let normals = along.contacts.iter_mut().flat_map(|own| {
        let tangents = own.tangents.iter_mut().map(|tangent| &mut tangent.arms);
        std::iter::once(&mut own.normal).chain(tangents)
    });
    let links = along.links.iter_mut().map(|s| &mut s.arms);
    let wheels = along.freewheels.iter_mut().map(|s| &mut s.arms);
    let all = springs.chain(dampers).chain(wheels).chain(stops).chain(frictions).chain(normals).chain(links);
    all.for_each(|arms| arms.terms.iter_mut().for_each(|term| term.1 = 0.0));
    for body in &mut along.bodies {
        let is_inner = body.is_inner();
        match &mut body.kind {
            BodyKind::Free(free) if is_inner => {
                *free = Free { inertia: 0.0, gravity: 0.0, s: 0.0, v: 0.0 };
            }
            BodyKind::Free(free) => (free.s, free.v) = (0.0, 0.0),
            BodyKind::Node(row) => row.iter_mut().for_each(|term| term.1 = 0.0),
            BodyKind::Prescribed { .. } | BodyKind::Integrated(_) => {}
        }
    }
    let follow = d.named.derivatives(name);
    for slot in slots(&mut along) {
        let follows = follow.get(slot.name.as_str()).copied();
        *slot.value = follows.unwrap_or(if slot.name == name { 1.0 } else { 0.0 });
    }
    keep_exponents(d, &mut along);
    along
}

/// Sets the exponents of `along` to the ones of `d`: motions have no derivatives by exponents.
fn keep_exponents(d: &Description, along: &mut Description) {
    let powers = along.springs.iter_mut().map(|own| &mut own.power);
    let powers = powers.chain(along.dampers.iter_mut().map(|own| &mut own.power));
    let own = d.springs.iter().map(|own| own.power).chain(d.dampers.iter().map(|own| own.power));
    for (power, own) in powers.zip(own) {
        power.iter_mut().zip(own).for_each(|(by, own)| by.exponent = own.exponent);
    }
}

/// Returns all signals in the system's order: motions, loads, levels, counters of levels, sources.
fn signals<'a>(d: &'a Description, counters: &'a [Signal]) -> Vec<Course<'a>> {
    let motions = d.bodies.iter().filter_map(|body| body.kind.course());
    let loads = d.loads.iter().map(|load| Course::from(&load.force));
    let levels = d.frictions.iter().flat_map(|f| std::iter::once(&f.force).chain(&f.static_force));
    let sources = d.sources.iter().map(|own| &own.signal);
    motions.chain(loads).chain(levels.chain(counters).chain(sources).map(Course::from)).collect()
}

impl Tangent {
    /// The derivative of `system`, the matrices of `d`, by the parameter `name`.
    pub fn new(system: &System, d: &Description, name: &str) -> Self {
        let along = direction(d, name);
        let counters: Vec<Signal> = stepped::all(d).map(stepped::counter).collect();
        let both = stepped::all(d).zip(stepped::all(&along));
        let moved: Vec<Signal> = both.map(|(own, by)| stepped::counter_along(own, by)).collect();
        let signals = system.signals.tangent(&signals(d, &counters), &signals(&along, &moved));
        let start = |&body: &usize| match &along.bodies[body].kind {
            BodyKind::Free(free) => (free.s, free.v),
            _ => (0.0, 0.0),
        };
        let mut tangent = Self {
            is_zero: name.is_empty(),
            varies_mass: false,
            bodies: bodies(system, d, &along, &signals),
            inertias: Vec::new(),
            mass: DMatrix::zeros(system.coordinates, system.coordinates),
            forces: DMatrix::zeros(system.coordinates, system.signals.size),
            springs: Vec::new(),
            stops: Vec::new(),
            frictions: Vec::new(),
            branches: Vec::new(),
            curves: Vec::new(),
            of_formulas: Vec::new(),
            loads: Vec::new(),
            starts: system.bodies_of.iter().map(start).collect(),
            inner: Vec::new(),
            blocks: BlockTangents::default(),
            residual: None,
            signals,
        };
        tangent.put_inertia(system, d, &along);
        tangent.varies_mass = tangent.mass.amax() > 0.0;
        tangent.take_loads(d);
        tangent.residual = tangent.on_residual(system, d, &along);
        tangent.put_springs(system, d, &along);
        tangent.put_gyroscopic(system);
        tangent.put_branches(system, d, &along);
        tangent.put_blocks(system, d, &along);
        tangent.put_loads(system);
        tangent.put_stops(system, d, &along);
        tangent.put_contacts(system, d, &along);
        tangent.put_frictions(system, d, &along);
        tangent
    }

    /// Adds inertia, weight, and the inertia forces of prescribed bodies that act through links.
    fn put_inertia(&mut self, system: &System, d: &Description, along: &Description) {
        let one = system.signals.one;
        for (i, (rows, by)) in system.bodies.iter().zip(&self.bodies).enumerate() {
            let (BodyKind::Free(free), BodyKind::Free(change)) = (&d.bodies[i].kind, &along.bodies[i].kind)
            else {
                self.inertias.push(0.0);
                continue;
            };
            let (m, dm) = (free.inertia, change.inertia);
            self.mass.ger(dm, &rows.weights, &rows.weights, 1.0);
            self.mass.ger(m, &by.weights, &rows.weights, 1.0);
            self.mass.ger(m, &rows.weights, &by.weights, 1.0);
            let mut force = -m * &*rows.drift;
            force[one] += system.weights[i];
            let mut dforce = -m * &by.drift - dm * &*rows.drift;
            dforce[one] += dm * free.gravity * d.gravity
                + m * (change.gravity * d.gravity + free.gravity * along.gravity);
            self.forces.ger(1.0, &by.weights, &force, 1.0);
            self.forces.ger(1.0, &rows.weights, &dforce, 1.0);
            self.inertias.push(dm);
        }
    }

    fn take_loads(&mut self, d: &Description) {
        let first = d.bodies.iter().filter(|b| b.kind.is_prescribed()).count();
        self.loads = self.signals.rows[first..first + d.loads.len()].to_vec();
    }

    fn put_loads(&mut self, system: &System) {
        for ((&body, row), by) in system.load_bodies.iter().zip(&system.loads).zip(&self.loads) {
            self.forces.ger(1.0, &self.bodies[body].weights, row, 1.0);
            self.forces.ger(1.0, &system.bodies[body].weights, by, 1.0);
        }
    }

    fn put_springs(&mut self, system: &System, d: &Description, along: &Description) {
        let springs = d.springs.iter().zip(&along.springs);
        let springs = springs.map(|(s, by)| {
            let (dk, preload) = match (&s.series, s.points.is_empty()) {
                // The stiffness of a spring in series belongs to its branch.
                (Some(_), _) => (0.0, by.preload),
                (None, true) => (by.along()[0], by.preload),
                (None, false) => {
                    let line = Polyline::derivative(&s.points, &by.points);
                    (line.stiffness, line.preload)
                }
            };
            let damping = if by.across.is_some() { 0.0 } else { by.damping };
            (s.arms.clone(), by.arms.clone(), dk, damping, preload)
        });
        let powers = along.springs.iter().map(|own| own.power.into_iter().collect::<Vec<_>>());
        let powers: Vec<_> =
            powers.chain(along.dampers.iter().map(|own| own.odd_powers().collect())).collect();
        let dampers = d.dampers.iter().zip(&along.dampers);
        let dampers = dampers.map(|(s, by)| (s.arms.clone(), by.arms.clone(), 0.0, by.along(), 0.0));
        let matrices = d.matrices.iter().flat_map(|own| own.springs()).map(|spring| {
            let mut by = spring.arms.clone();
            by.terms.iter_mut().for_each(|term| term.1 = 0.0);
            (spring.arms, by, 0.0, 0.0, 0.0)
        });
        let modals = d.modals.iter().zip(&along.modals).flat_map(|(own, by)| {
            let springs = own.springs(d).into_iter().zip(own.springs_by(d, by, along));
            springs.map(|(spring, [dk, dc])| {
                let mut by = spring.arms.clone();
                by.terms.iter_mut().for_each(|term| term.1 = 0.0);
                (spring.arms, by, dk, dc, 0.0)
            })
        });
        let viscous = d.frictions.iter().zip(&along.frictions).filter_map(|(own, by)| {
            own.viscous.and(by.viscous).map(|dc| (own.arms.clone(), by.arms.clone(), 0.0, dc, 0.0))
        });
        let springs_along = along.springs.iter().map(|spring| spring.formula());
        let dampers_along = along.dampers.iter().map(|damper| damper.force.as_ref().map(Cow::Borrowed));
        let formulas: Vec<_> = springs_along.chain(dampers_along).collect();
        for (rows, (arms, by, dk, dc, preload)) in
            system.springs.iter().zip(springs.chain(dampers).chain(modals).chain(matrices).chain(viscous))
        {
            let own = self.elongation(system, &arms, &by);
            let e = &rows.elongation;
            let mut force = dk * &*e.e + rows.stiffness * &own.e + dc * &*e.rate + rows.damping * &own.rate;
            force[system.signals.one] += preload;
            if let Some(by) = self.residual_force(system, Part::Spring(self.springs.len())) {
                force = by;
            }
            if let Some(by) = self.put_formula((rows, &own), formulas.get(self.springs.len())) {
                force += &*by;
            }
            let odd = rows
                .curves
                .iter()
                .map(|own| &system.curved[own.0])
                .filter(|own| own.operation.edge().is_some());
            for (curved, by) in odd.zip(powers.get(self.springs.len()).into_iter().flatten()) {
                force[curved.place] += by.coefficient;
            }
            self.forces.ger(-1.0, &own.w, &rows.force, 1.0);
            self.forces.ger(-1.0, &e.w, &force, 1.0);
            self.springs.push((own, force));
        }
        self.put_curves(system, along);
    }

    /// The derivative of the row of a formula's force. `own` has the derivative of the elongation,
    /// and `along` the derivatives of the formula's numbers. Stores the derivatives of the
    /// formula's operations.
    fn put_formula(
        &mut self,
        (rows, own): (&SpringRows, &ElongationTangent),
        along: Option<&Option<Cow<Formula>>>,
    ) -> Option<Functional> {
        let (formula, along) = (rows.formula.as_ref()?, along?.as_ref()?);
        let elongation = [&rows.elongation.e, &rows.elongation.rate];
        let [de, drate] = [&own.e, &own.rate].map(|row| Functional::of(row.clone()));
        let row_by = |line: &Line| formula.operations.row_by(line, elongation, [&de, &drate], &along.values);
        let tangent = |step: &Step| CurveTangent {
            arguments: step.arguments.each_ref().map(row_by),
            force: Polynomial { coefficients: [0.0; 4] },
        };
        self.of_formulas.push(formula.compiled.steps.iter().map(tangent).collect());
        Some(row_by(&formula.compiled.force))
    }

    /// Adds the curved forces of springs and dashpots.
    fn put_curves(&mut self, system: &System, along: &Description) {
        let springs = along.springs.iter().map(|spring| spring.curve.map(Option::unwrap_or_default));
        let dampers = along.dampers.iter().map(|own| [0.0, own.cubic.unwrap_or_default(), 0.0, 0.0]);
        let moved: Vec<[f64; 4]> = springs.chain(dampers).collect();
        let mut formulas = std::mem::take(&mut self.of_formulas).into_iter();
        for (k, spring) in system.springs.iter().enumerate() {
            self.put_spring_curves(system, (k, spring), &moved);
            if spring.formula.is_some() {
                self.curves.extend(formulas.next().into_iter().flatten());
            }
        }
    }

    /// Adds the polynomial and the powers of a spring or dashpot.
    fn put_spring_curves(&mut self, system: &System, (k, spring): (usize, &SpringRows), moved: &[[f64; 4]]) {
        for &(curve, _) in &spring.curves {
            let (curved, own) = (&system.curved[curve], &self.springs[k].0);
            let argument = if curved.is_of_rate { own.rate.clone() } else { own.e.clone() };
            let coefficients = if curved.polynomial().is_some() { moved[k] } else { [0.0; 4] };
            let arguments = [Functional::of(argument), Functional::zeros(system.signals.size)];
            self.curves.push(CurveTangent { arguments, force: Polynomial { coefficients } });
        }
    }

    /// Writes the derivatives of the curved forces into the derivative of a state.
    pub fn vary_curved(&self, system: &System, z: &DVector<f64>, delta: &mut DVector<f64>) {
        for (own, by) in system.curved.iter().zip(&self.curves) {
            delta[own.place] = by.derivative(own, z, delta);
        }
    }

    /// Adds gyroscopic forces, which vary if links vary the bodies' rows.
    fn put_gyroscopic(&mut self, system: &System) {
        for own in &system.gyroscopic {
            let size = system.signals.size;
            let varied: Vec<_> = own.forces(size, |body| &self.bodies[body].v);
            for ((body, dforce), (_, force)) in
                varied.iter().zip(own.forces(size, |body| &system.bodies[body].v))
            {
                self.forces.ger(-1.0, &self.bodies[*body].weights, &force, 1.0);
                self.forces.ger(-1.0, &system.bodies[*body].weights, dforce, 1.0);
            }
        }
    }

    /// Adds the stops in the system's order: first the stops of the sections `stop`, `contact` and
    /// `spring`, then limits of outputs, then freewheels.
    fn put_stops(&mut self, system: &System, d: &Description, along: &Description) {
        let one = system.constant(1.0).into_row();
        for (rows, made) in system.stops.iter().zip(made_stops(d, Some(along))) {
            let own = self.elongation(system, made.by.arms(d), made.by.arms(along));
            let excess = excess(&own.e, made.gap, &one);
            let by = StopTangent::new(rows, own, excess, made.law);
            let by = match (&rows.contact, made.by) {
                (Some(contact), StopMaker::Stop(i)) => {
                    self.put_contact(contact, &by);
                    let dissipation = along.stops[i].contact.and_then(|own| own.dissipation);
                    StopTangent::contact(rows, contact, by, (made.law, dissipation.unwrap_or_default()))
                }
                _ => by,
            };
            let by = self.residual_stop(system, self.stops.len(), by);
            self.stops.push(by);
        }
        self.put_limits();
        for (wheel, by) in d.freewheels.iter().zip(&along.freewheels) {
            let own = self.elongation(system, &wheel.arms, &by.arms);
            let (rows, excess) = (&system.stops[self.stops.len()], own.rate.clone());
            self.stops.push(StopTangent::new(rows, own, excess, StopLaw::Rigid { restitution: 0.0 }));
        }
    }

    /// Adds the operations of a curved contact.
    fn put_contact(&mut self, contact: &ContactRows, by: &StopTangent) {
        let zero = Functional::zeros(by.excess.len());
        let mut put = |first: Functional, second: Functional| {
            self.curves.push(CurveTangent { arguments: [first, second], force: Polynomial::default() });
        };
        let excess = Functional::of(by.excess.clone());
        let is_straight = contact.exponent == 1.0;
        if !is_straight {
            put(excess.clone(), zero.clone());
        }
        if contact.release.is_some() {
            let rate = Functional::of(by.elongation.rate.clone());
            put(if is_straight { excess } else { zero }, rate);
        }
    }

    fn put_frictions(&mut self, system: &System, d: &Description, along: &Description) {
        let given: usize = d.frictions.iter().map(|f| 1 + usize::from(f.static_force.is_some())).sum();
        let first = self.signals.rows.len() - given - stepped::all(d).count() - d.sources.len();
        let mut place = first;
        for (i, (friction, by)) in d.frictions.iter().zip(&along.frictions).enumerate() {
            let level = self.signals.rows[place].clone();
            place += usize::from(friction.static_force.is_some());
            let static_level = self.signals.rows[place].clone();
            place += 1;
            let elongation = self.elongation(system, &friction.arms, &by.arms);
            let levels = match (&friction.follows, &by.follows) {
                (Some(own), Some(by)) => self.following(system, i, (own, by)),
                _ if friction.stribeck.is_some() => {
                    let moved = Functional::of(&static_level - &level);
                    let curves = [friction.stribeck, by.stribeck];
                    self.put_stribeck((&system.frictions[i], &elongation), curves, moved);
                    vec![LevelTangent { static_level: level.clone(), level }]
                }
                _ => vec![LevelTangent { level, static_level }],
            };
            self.frictions.push(FrictionTangent { elongation, levels });
        }
    }

    /// Adds the derivatives of the operations of Stribeck's curve, given the derivative of the
    /// difference of the levels.
    fn put_stribeck(
        &mut self,
        (rows, own): (&FrictionRows, &ElongationTangent),
        curves: [Option<Stribeck>; 2],
        levels: Functional,
    ) {
        let [Some(Stribeck { speed, exponent }), Some(Stribeck { speed: by, .. })] = curves else { return };
        let (zeros, rate) = (Functional::zeros(levels.len()), Functional::of(own.rate.clone()));
        let argument = &((1.0 / speed) * &rate) - &((by / (speed * speed)) * &rows.elongation.rate);
        let exponential = (exponent == StribeckExponent::Two).then(|| zeros.clone());
        for argument in std::iter::once(argument).chain(exponential).chain([levels]) {
            let force = Polynomial { coefficients: [0.0; 4] };
            self.curves.push(CurveTangent { arguments: [argument, zeros.clone()], force });
        }
    }

    /// The derivatives of levels that follow a stop: (μ N)' = μ' N + μ N'.
    fn following(&self, system: &System, i: usize, (own, by): (&Follows, &Follows)) -> Vec<LevelTangent> {
        let largest = own.static_coefficient.unwrap_or(own.coefficient);
        let by_largest = by.static_coefficient.unwrap_or(by.coefficient);
        let of_state = |&(stop, state): &(usize, StopState)| {
            let (force, varied) = (system.stop_force(stop, state)?.into_row(), self.stop_force(stop, state)?);
            Some(LevelTangent {
                level: by.coefficient * &force + own.coefficient * &varied,
                static_level: by_largest * &force + largest * &varied,
            })
        };
        system.frictions[i].follows.iter().flatten().filter_map(of_state).collect()
    }

    pub(super) fn elongation(&self, system: &System, arms: &Arms, along: &Arms) -> ElongationTangent {
        let size = system.signals.size;
        let (mut e, mut rate, mut drift) =
            (StateRow::zeros(size), StateRow::zeros(size), StateRow::zeros(size));
        let mut w = DVector::zeros(system.coordinates);
        for (&(body, arm), &(_, by)) in arms.terms.iter().zip(&along.terms) {
            let (rows, own) = (&system.bodies[body], &self.bodies[body]);
            e += arm * &own.s + by * &*rows.s;
            rate += arm * &own.v + by * &*rows.v;
            drift += arm * &own.drift + by * &*rows.drift;
            w += arm * &own.weights + by * &*rows.weights;
        }
        ElongationTangent { e, rate, w, drift }
    }

    /// The derivative of a contact's elongation.
    pub fn elongation_of(&self, contact: Contact) -> &ElongationTangent {
        match contact {
            Contact::Stop(i) => &self.stops[i].elongation,
            Contact::Friction(i) => &self.frictions[i].elongation,
            Contact::Slider(i) => &self.branches[i].elongation,
        }
    }

    /// The derivative of a compliant stop's force; `None` in a state without a force.
    pub fn stop_force(&self, i: usize, state: StopState) -> Option<StateRow> {
        state.force(&self.stops[i].force, &self.stops[i].spring)
    }

    /// The derivative of a friction's force in a state that determines it.
    pub fn friction_force(
        &self,
        system: &System,
        i: usize,
        state: FrictionState,
        stops: &[StopState],
    ) -> Option<StateRow> {
        let own = &self.frictions[i].levels[system.frictions[i].place(stops)?];
        state.force(&own.level, &own.static_level)
    }

    /// The derivative of the forces on the coordinates in a mode, without the forces of held
    /// contacts.
    pub fn forces_in(&self, system: &System, mode: &Mode) -> DMatrix<f64> {
        let mut forces = self.forces.clone();
        let mut put = |e: &Elongation, by: &ElongationTangent, force: Functional, dforce: StateRow| {
            forces.ger(-1.0, &by.w, &force, 1.0);
            forces.ger(-1.0, &e.w, &dforce, 1.0);
        };
        for (i, &state) in mode.stops.iter().enumerate() {
            if let (Some(force), Some(by)) = (system.stop_force(i, state), self.stop_force(i, state)) {
                put(&system.stops[i].elongation, &self.stops[i].elongation, force, by);
            }
        }
        for (i, &state) in mode.frictions.iter().enumerate() {
            let stops = &mode.stops;
            if let (Some(force), Some(by)) =
                (system.friction_force(i, state, stops), self.friction_force(system, i, state, stops))
            {
                put(&system.frictions[i].elongation, &self.frictions[i].elongation, force, by);
            }
        }
        for i in system.sliders() {
            let (state, e) = (mode.sliders[i], &system.branches[i].elongation);
            let (force, by) = (system.branch_force(i, state), self.branch_force(i, state));
            put(e, &self.branches[i].elongation, force, by);
        }
        forces
    }
}
