//! Static equilibrium for the start at rest, by a proximal point method (docs/assembly-law.md
//! (A23), (A24)).

mod curves;
mod factor;
mod lines;
mod path;
mod weighted;

use crate::description::{Contact, Description, Dimension, Friction, StopLaw};
use crate::elements::Element;
use crate::error::Error;
use crate::functional::{Functional, StateRow};
use crate::law::Sizes;
use crate::law::box_qp::BoxProblem;
use crate::system::{BranchLaw, BranchRows, FrictionRows, RowMatrix, SpringRows, System};
use curves::Curves;
use lines::Lined;
use nalgebra::DVector;
use path::LoadPath;
use vibro_numerics::double_double::DoubleDouble;
use weighted::Weighted;

/// Factor of the proximal weight in each step. The weight falls from the largest stiffness per
/// inertia to [`SOFTER`] times the least stiffness per largest inertia.
const FALL: f64 = 1e-4;
/// Final proximal weight relative to the least stiffness per largest inertia.
const SOFTER: f64 = 1e-4;
/// Lower bound of the proximal weight, relative to the first weight: far enough above the 1e-32 of
/// double-doubles that loose coordinates keep six digits.
const LEAST_WEIGHT: f64 = 1e-26;
/// Largest number of proximal steps. At the final weight, a step multiplies the error by
/// [`SOFTER`] times the ratio of the least stiffness to the stiffness of springs in series.
const STEPS: usize = 100;
/// Tolerance of the force balance: largest residual force, relative to the forces on its
/// coordinate.
const BALANCED: f64 = 1e-13;
/// Cap on the iterations for friction levels that depend on the force of a stop. Each multiplies
/// the error of the levels by the coefficient times a ratio of stiffnesses.
const REPEATS: usize = 200;
/// Part of each step of the levels, in each quarter of the iterations. Full steps diverge if a
/// change of the levels changes them back by more than itself; a part p converges up to 2/p - 1
/// times the change.
const PARTS: [f64; 4] = [1.0, 1.0, 0.5, 0.125];
/// Tolerance below which a proximal step counts as zero, relative to the coordinate.
const STANDS: f64 = 1e-15;
/// Tolerance for a difference of coordinates known to 32 digits, relative to their sizes.
const FINE: f64 = 1e-28;

/// Forces on a machine at rest: contacts, springs and constant forces.
struct Holding {
    contacts: Vec<RestContact>,
    springs: Vec<RestSpring>,
    /// Forces on the coordinates at q = 0, without contacts.
    force: DVector<f64>,
    /// Sums of the absolute values of the terms of `force`.
    sizes: DVector<f64>,
}

/// Coordinates on which a force acts, with their arms.
type Direction = Vec<(usize, f64)>;

#[derive(Clone)]
struct RestSpring {
    w: Direction,
    /// Negative only where a piecewise linear force falls.
    stiffness: f64,
    /// Index among the system's springs; `usize::MAX` for a gapless stop.
    spring: usize,
}

#[derive(Clone)]
struct RestContact {
    w: Direction,
    /// Elongation at q = 0 minus the elongation at which the contact begins to act.
    excess: f64,
    /// Lower and upper bound of the contact force.
    force: (f64, f64),
    compliance: f64,
}

/// The friction level that may hold the machine.
#[derive(Clone, Copy, PartialEq)]
enum FrictionLevel {
    None,
    Slipping,
    Static,
}

impl FrictionLevel {
    const ALL: [Self; 3] = [Self::None, Self::Slipping, Self::Static];
}

/// Coordinates and contact forces, with 32 digits. A stiff spring's force is then known even if
/// its elongation is a tiny difference of coordinates, and a soft spring's force even if large
/// forces cancel.
struct RestState {
    q: Vec<DoubleDouble>,
    lambda: Vec<DoubleDouble>,
}

/// The coordinates of static equilibrium at time 0. Friction carries force only if there is no
/// equilibrium without it; it then resists the displacement from zero coordinates. Coordinates
/// that no force determines stay as close to zero as possible.
///
/// # Errors
/// [`Error::NoEquilibrium`], with the body of the largest acceleration; [`Error::GivesWay`];
/// [`Error::OutOfRange`] for a contact whose friction changes its own limit without end.
pub fn equilibrium(d: &Description, system: &System) -> Result<DVector<f64>, Error> {
    let (n, mut z) = (system.coordinates, system.at_rest(None));
    system.put_out_at_rest(d, &mut z);
    system.fill_curved(z.as_mut_slice());
    let curves = Curves::new(system, &z);
    let lined = Lined::all(d, system, &z);
    let held = |friction, levels: &Levels| {
        let mut holding = Holding::new(system, &z, friction, levels);
        lined.iter().for_each(|own| holding.put_lines(system, own));
        holding
    };
    let mut worst = None;
    let mut levels = levels(d, system, &z);
    let path = lined.iter().any(Lined::falls).then(|| Holding::new(system, &z, FrictionLevel::None, &levels));
    if let Some((path, holding)) = path.and_then(|own| Some((LoadPath::new(d, system, &z, &own)?, own))) {
        let (holding, q) = path.follow(d, holding)?;
        match holding.settle(&system.mass, &q) {
            Ok(q) => return Ok(q),
            Err(left) => worst = Some(left),
        }
    }
    let zero = DVector::zeros(n);
    let ways = if worst.is_some() { &[][..] } else { &FrictionLevel::ALL[..] };
    for &friction in ways {
        let mut turns = 0;
        for _ in 0..REPEATS {
            let holding = held(friction, &levels);
            let found = match curves.is_empty() {
                true => holding.settle(&system.mass, &zero),
                false => curves.follow(d, &holding)?,
            };
            match found {
                Ok(q) => {
                    let mut there = z.clone();
                    there.rows_mut(0, n).copy_from(&q);
                    let found = self::levels(d, system, &there);
                    if found.are_near(&levels) {
                        return Ok(q);
                    }
                    // Friction that overcorrects its own limit swings about the equilibrium.
                    levels = levels.towards(&found, PARTS[4 * turns / REPEATS]);
                    turns += 1;
                }
                Err(left) => {
                    worst = Some(left);
                    break;
                }
            }
        }
        if turns == REPEATS {
            rubbing(d)?;
        }
    }
    let left = system.inertia.solve(&worst.unwrap_or_else(|| DVector::zeros(n)));
    let body = (0..n).max_by(|&a, &b| left[a].abs().total_cmp(&left[b].abs()));
    if left.iter().any(|x| !x.is_finite()) {
        let curved = d.elements().find(|own| crate::system::compiled(*own).is_some());
        let curved = curved.map_or("the curved springs".into(), Element::dotted);
        let allowed = format!(
            "coordinates at which the force of {curved} is defined: the search for the equilibrium begins at 0"
        );
        return Err(Error::OutOfRange { name: "coordinates of the bodies".into(), value: 0.0, allowed });
    }
    let own = body.map(|k| &d.bodies[system.bodies_of[k]]);
    Err(Error::NoEquilibrium {
        body: own.map_or(String::new(), |own| own.name.clone()),
        acceleration: body.map_or(0.0, |k| left[k]),
        unit: if own.is_some_and(|own| own.dimension == Dimension::Rotation) { "rad/s2" } else { "m/s2" },
    })
}

/// Refuses the friction of a contact: its limit follows the normal force, which the friction itself
/// changes, and the two do not settle.
fn rubbing(d: &Description) -> Result<(), Error> {
    let rubs = |own: &Contact| (!own.tangents.is_empty()).then(|| (own.name.clone(), own.friction));
    let Some((name, value)) = d.contacts.iter().find_map(rubs) else { return Ok(()) };
    let allowed = "a smaller coefficient, or a start of each body instead of `start = \"rest\"`: friction and normal \
                   force at rest do not settle";
    Err(Error::OutOfRange { name: format!("contact.{name}.friction"), value, allowed: allowed.into() })
}

/// Largest forces of friction in an augmented state.
struct Levels {
    /// Sliding and static level of each friction.
    frictions: Vec<[f64; 2]>,
    /// Limit of the slider of each spring in series and each contact; 0 for a dashpot.
    sliders: Vec<f64>,
}

/// The levels in an augmented state. A level that follows a stop uses the spring force of the stop.
fn levels(d: &Description, system: &System, z: &StateRow) -> Levels {
    let sliders = system.branches.iter().map(|own| match own.law {
        BranchLaw::Dashpot(_) => 0.0,
        BranchLaw::Slider(slip) => slip,
        BranchLaw::Contact { .. } => own.level.as_ref().map_or(0.0, |level| level.dot(z).max(0.0)),
    });
    let sliders = sliders.collect();
    let of = |(rows, own): (&FrictionRows, &Friction)| match &own.follows {
        None => [rows.levels[0].level.dot(z), rows.levels[0].static_level.dot(z)],
        Some(follows) => {
            let normal = system.stops[system.present_at(follows.stop, z)].spring.dot(z).max(0.0);
            let largest = follows.static_coefficient.unwrap_or(follows.coefficient);
            [follows.coefficient * normal, largest * normal]
        }
    };
    Levels { frictions: system.frictions.iter().zip(&d.frictions).map(of).collect(), sliders }
}

impl Levels {
    fn all(&self) -> impl Iterator<Item = &f64> {
        self.frictions.as_flattened().iter().chain(&self.sliders)
    }

    /// The levels at a part of the way to others.
    fn towards(&self, others: &Self, part: f64) -> Self {
        let between = |(a, b): (&f64, &f64)| b - (1.0 - part) * (b - a);
        let frictions = self.frictions.iter().zip(&others.frictions);
        let frictions = frictions.map(|(own, other)| [0, 1].map(|i| between((&own[i], &other[i]))));
        let sliders = self.sliders.iter().zip(&others.sliders).map(between);
        Self { frictions: frictions.collect(), sliders: sliders.collect() }
    }

    /// Whether two sets of levels agree up to rounding.
    fn are_near(&self, others: &Self) -> bool {
        self.all().zip(others.all()).all(|(a, b)| (a - b).abs() <= BALANCED * a.abs())
    }
}

impl System {
    /// The augmented state at rest at time 0, with coordinates q (zeros if `None`). Springs in
    /// series carry no force.
    pub(crate) fn at_rest(&self, q: Option<&DVector<f64>>) -> StateRow {
        let mut z = StateRow::zeros(self.signals.size);
        let inputs = self.signals.no_inputs();
        self.signals.fill(DoubleDouble::default(), &inputs, z.as_mut_slice());
        q.iter().for_each(|q| z.rows_mut(0, self.coordinates).copy_from(q));
        z
    }

    /// Inner displacements of springs in series at rest with coordinates q, reached from zero.
    pub(crate) fn inner_at_rest(&self, q: &DVector<f64>) -> Vec<f64> {
        let z = self.at_rest(Some(q));
        let inner = |branch: &BranchRows| {
            let e = branch.elongation.e.dot(&z);
            match branch.law {
                BranchLaw::Dashpot(_) => e,
                // Starts at x = 0 and slips until its force is at most the slip level.
                _ => match branch.most(z.as_slice()) {
                    Some(most) if e.abs() > most => e - most.copysign(e),
                    _ => 0.0,
                },
            }
        };
        self.branches.iter().map(inner).collect()
    }
}

fn direction(w: &Functional) -> Direction {
    w.terms().to_vec()
}

/// The elongation along a direction.
fn along(w: &Direction, q: &[DoubleDouble]) -> DoubleDouble {
    let zero = DoubleDouble::default();
    w.iter().fold(zero, |sum, &(k, w)| sum + q[k].times(DoubleDouble::new(w)))
}

/// Sum of the absolute values of an elongation's terms.
fn size_along(w: &Direction, q: &[DoubleDouble]) -> f64 {
    w.iter().map(|&(k, w)| (w * q[k].value()).abs()).sum()
}

/// Subtracts a force along a direction from the forces on the coordinates.
fn subtract_force(force: DoubleDouble, w: &Direction, from: &mut [DoubleDouble]) {
    w.iter().for_each(|&(k, w)| from[k] = from[k].minus(force.times(DoubleDouble::new(w))));
}

fn amax(q: &[DoubleDouble]) -> f64 {
    q.iter().fold(0.0, |most, x| most.max(x.value().abs()))
}

impl SpringRows {
    /// Stiffness without curved forces: of a spring with a formula, with the formula's straight
    /// part.
    fn straight_stiffness(&self) -> f64 {
        let w = self.elongation.w.terms();
        if self.formula.is_none() || w.is_empty() {
            return self.stiffness;
        }
        // The coordinates come first in the row of the force.
        let along = |&(k, w): &(usize, f64)| w * self.force[k];
        w.iter().map(along).sum::<f64>() / w.iter().map(|(_, w)| w * w).sum::<f64>()
    }
}

impl Holding {
    /// The forces on a machine whose augmented state is `z` at q = 0.
    fn new(system: &System, z: &StateRow, friction: FrictionLevel, levels: &Levels) -> Self {
        let mut force = system.forces.times(z);
        let mut sizes = system.forces.sizes(z);
        let mut contacts = Vec::new();
        let is_stop = |i: &usize| {
            let own = &system.stops[*i];
            !system.is_corner(*i) && !own.is_off(z) && !own.has_power()
        };
        for stop in (0..system.stops.len()).filter(is_stop).map(|i| &system.stops[i]) {
            let compliance = match stop.law {
                StopLaw::Rigid { .. } => 0.0,
                StopLaw::Compliant { stiffness, .. } if stiffness > 0.0 => 1.0 / stiffness,
                StopLaw::Compliant { .. } => continue,
            };
            let (w, excess) = (direction(&stop.elongation.w), stop.excess.dot(z));
            contacts.push(RestContact { w, excess, force: (0.0, f64::INFINITY), compliance });
        }
        let known = signal_sizes(system, z);
        for (branch, &slip) in system.branches.iter().zip(&levels.sliders).filter(|own| own.0.is_slider()) {
            let (w, excess) = (direction(&branch.elongation.w), branch.elongation.e.dot(z));
            let compliance = 1.0 / branch.stiffness;
            contacts.push(RestContact { w, excess, force: (-slip, slip), compliance });
        }
        for (rows, &[slides, holds]) in system.frictions.iter().zip(&levels.frictions) {
            let rate = rows.elongation.rate.dot(z);
            let level = if friction == FrictionLevel::Static { holds } else { slides };
            let level = level.max(0.0);
            let w = &rows.elongation.w;
            if rate.abs() > known.zero_of(&rows.elongation.rate) {
                // A moving prescribed body slips against the bodies at rest.
                force.axpy(-rate.signum() * slides.max(0.0), w, 1.0);
                sizes += w.abs() * level;
            } else if friction != FrictionLevel::None && level > 0.0 {
                let force = (-level, level);
                contacts.push(RestContact { w: direction(w), excess: 0.0, force, compliance: 0.0 });
            }
        }
        for rows in &system.stops[system.freewheels()] {
            let e = &rows.elongation;
            let rate = e.rate.dot(z);
            // The freewheel carries no force if moving prescribed bodies give e' < 0.
            if friction != FrictionLevel::None && rate >= -known.zero_of(&e.rate) {
                let force = (0.0, f64::INFINITY);
                contacts.push(RestContact { w: direction(&e.w), excess: 0.0, force, compliance: 0.0 });
            }
        }
        let spring = |(spring, s): (usize, &SpringRows)| RestSpring {
            w: direction(&s.elongation.w),
            stiffness: s.straight_stiffness(),
            spring,
        };
        let mut springs: Vec<_> =
            system.springs.iter().enumerate().map(spring).filter(|s| s.stiffness != 0.0).collect();
        for level in system.stops.iter().filter(|own| own.is_gapless() && !own.is_off(z)) {
            let (w, stiffness, own) = (&level.elongation.w, level.stiffness(), level.spring.dot(z));
            force.axpy(-own, w, 1.0);
            sizes += w.abs() * own.abs();
            springs.push(RestSpring { w: direction(w), stiffness, spring: usize::MAX });
        }
        springs.retain(|s| s.stiffness != 0.0);
        for limit in system.limits() {
            let beyond = limit.excess.dot(z).max(0.0);
            force.axpy(-beyond, &limit.elongation.w, 1.0);
            sizes += limit.elongation.w.abs() * beyond;
        }
        Self { contacts, springs, force, sizes }
    }

    /// Finds the equilibrium by proximal steps, starting at `from`. Each step minimizes the energy
    /// plus a weight times the squared distance from the last point in the inertia's metric. `Err`
    /// is the residual force.
    fn settle(&self, mass: &RowMatrix, from: &DVector<f64>) -> Result<DVector<f64>, DVector<f64>> {
        let pattern = self.pattern(mass);
        let (mut weight, mut least) = self.weights(mass);
        let zero = DoubleDouble::default();
        let mut place = RestState {
            q: from.iter().map(|&q| DoubleDouble::new(q)).collect(),
            lambda: vec![zero; self.contacts.len()],
        };
        let (mut left, mut rounding) = self.left(&place);
        let is_balanced = |left: &[DoubleDouble], rounding: &DVector<f64>| {
            left.iter().zip(rounding.iter()).all(|(left, rounding)| left.value().abs() <= *rounding)
        };
        let mut weighted = self.weighted(weight, mass, &pattern);
        for _ in 0..STEPS {
            let Some(by_q) = weighted.as_ref().and_then(|w| self.step(w, &left, &mut place)) else { break };
            let size = amax(&place.q);
            let moves = place
                .q
                .iter()
                .zip(&by_q)
                .any(|(q, by)| by.value().abs() > (STANDS * q.value().abs()).max(FINE * size));
            (left, rounding) = self.left(&place);
            if weight <= least && is_balanced(&left, &rounding) && !moves {
                break;
            }
            if weight > least {
                let next = (FALL * weight).max(least);
                match self.weighted(next, mass, &pattern) {
                    Some(of_next) => (weight, weighted) = (next, Some(of_next)),
                    None => least = weight,
                }
            }
        }
        let rounded = |all: &[DoubleDouble]| DVector::from_iterator(all.len(), all.iter().map(|x| x.value()));
        if is_balanced(&left, &rounding) { Ok(rounded(&place.q)) } else { Err(rounded(&left)) }
    }

    /// First and last proximal weight: the largest stiffness per inertia, and a weight far below
    /// the least stiffness per largest inertia, so that heavy coordinates converge as fast as
    /// light ones.
    fn weights(&self, mass: &RowMatrix) -> (f64, f64) {
        let springs = self.springs.iter().map(|s| (&s.w, s.stiffness));
        let yielding = self.contacts.iter().filter(|c| c.compliance > 0.0);
        let all = springs.chain(yielding.map(|c| (&c.w, 1.0 / c.compliance)));
        let (mut least, mut largest) = (f64::INFINITY, 0.0f64);
        for (i, stiffness) in all.flat_map(|(w, k)| w.iter().map(move |&(i, w)| (i, k.abs() * w * w))) {
            least = least.min(stiffness);
            largest = largest.max(stiffness / mass[(i, i)]);
        }
        let heaviest = mass.diagonal().max();
        if largest == 0.0 {
            return (1.0, 1.0);
        }
        (largest, (SOFTER * least / heaviest).max(LEAST_WEIGHT * largest))
    }

    /// Residual force on each coordinate and its rounding error: a fraction of the forces of
    /// springs and contacts, plus the stiffness times the rounding error of elongations.
    fn left(&self, place: &RestState) -> (Vec<DoubleDouble>, DVector<f64>) {
        let mut left: Vec<_> = self.force.iter().map(|&f| DoubleDouble::new(f)).collect();
        let mut rounding = BALANCED * &self.sizes;
        let mut bear = |w: &Direction, force: DoubleDouble, stiffness: f64| {
            subtract_force(force, w, &mut left);
            let own = BALANCED * force.value().abs() + FINE * stiffness.abs() * size_along(w, &place.q);
            w.iter().for_each(|&(k, w)| rounding[k] += w.abs() * own);
        };
        for RestSpring { w, stiffness, .. } in &self.springs {
            bear(w, along(w, &place.q).times(DoubleDouble::new(*stiffness)), *stiffness);
        }
        for (contact, &force) in self.contacts.iter().zip(&place.lambda) {
            let stiffness = if contact.compliance > 0.0 { 1.0 / contact.compliance } else { 0.0 };
            bear(&contact.w, force, stiffness);
        }
        (left, rounding)
    }

    /// Moves `place` by the δ that minimizes ½ δᵀHδ - leftᵀδ plus the contacts' energies, with H
    /// the weighted stiffness; returns δ, or `None` if the stops cannot be satisfied together.
    fn step(
        &self,
        weighted: &Weighted,
        left: &[DoubleDouble],
        place: &mut RestState,
    ) -> Option<Vec<DoubleDouble>> {
        let m = self.contacts.len();
        let mut free = left.to_vec();
        weighted.factor.solve(&mut free);
        let (mut b, mut zero) = (DVector::zeros(m), DVector::zeros(m));
        for (k, contact) in self.contacts.iter().enumerate() {
            let yielded = DoubleDouble::new(contact.compliance).times(place.lambda[k]);
            let gap = (along(&contact.w, &place.q) + along(&contact.w, &free)).plus(contact.excess);
            b[k] = gap.minus(yielded).value();
            // A compliant contact's force follows from its elongation to all digits; a rigid
            // contact's force does not depend on its elongation.
            let fine = if contact.compliance > 0.0 { FINE } else { STANDS };
            let sizes = size_along(&contact.w, &place.q) + contact.excess.abs() + yielded.value().abs();
            zero[k] = STANDS * size_along(&contact.w, &free) + fine * sizes;
        }
        let bound = |of: fn(&(f64, f64)) -> f64| {
            DVector::from_fn(m, |k, _| of(&self.contacts[k].force) - place.lambda[k].value())
        };
        let (lo, hi) = (bound(|f| f.0), bound(|f| f.1));
        let change = BoxProblem { columns: weighted.columns.clone(), b, lo, hi, zero }.solve().ok()?.lambda;
        let mut by_q = left.to_vec();
        for (contact, &change) in self.contacts.iter().zip(change.iter()) {
            subtract_force(DoubleDouble::new(change), &contact.w, &mut by_q);
        }
        weighted.factor.solve(&mut by_q);
        place.lambda.iter_mut().zip(change.iter()).for_each(|(force, &by)| *force = force.plus(by));
        place.q.iter_mut().zip(&by_q).for_each(|(q, by)| *q = *q + *by);
        Some(by_q)
    }
}

/// Magnitudes of the signals at rest. A harmonic counts with its amplitude, so that its rounding
/// error near zero counts as zero.
fn signal_sizes(system: &System, z: &StateRow) -> Sizes {
    let mut sizes = Sizes(z.abs());
    (system.signals.one..system.signals.constant_size_until()).for_each(|j| sizes.0[j] = 1.0);
    sizes
}
