//! The equilibrium under curved forces, by Newton's method along a path. Along the path the forces
//! at zero displacement grow from zero (docs/assembly-law.md, section 23).
//!
//! Let R(q) be the force of springs, compliant contacts and loads on the coordinates. The path
//! solves R(q) = (1 - s) R(0) for s from 0 to 1. Each step of Newton's method replaces the curved
//! forces by their tangents, and solves the remaining piecewise linear problem. The length of the
//! steps in s follows P. Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 5.1: a
//! step is taken only if the second correction is at most a quarter of the first one. The point
//! then lies on the same path, not on another one beyond a fold.

use super::{Direction, Holding, RestContact, RestSpring, direction};
use crate::curved::{Operation, Polynomial};
use crate::description::{Description, StopLaw};
use crate::error::Error;
use crate::functional::{Functional, StateRow};
use crate::system::System;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Largest ratio of the second correction to the first one.
const CONTRACTION: f64 = 0.25;
/// Smallest step in s: where a smaller one is needed, the machine gives way.
const LEAST_STEP: f64 = 1e-9;
/// First s of machines that only curved forces without a slope at zero displacement hold.
const FIRST_LOAD: f64 = 1e-4;
/// Halvings of an elongation between two powers of two: down to rounding.
const HALVINGS: usize = 53;
/// Largest number of steps in s, of corrections at one s, and of corrections of stops alone.
const MOST: (usize, usize, usize) = (10_000, 200, 100);
/// Correction that counts as rounding, and one below which corrections need not decrease, relative
/// to the coordinates.
const ROUNDING: f64 = 1e-15;
const SMALL: f64 = 1e-9;
/// Stiffness that counts as zero, relative to the largest one.
const ZERO: f64 = 1e-9;
/// Stiffness of closed rigid stops, relative to the largest one, in the test of stability.
const RIGID: f64 = 1e6;

/// The curved force of a spring.
struct Curve {
    /// Index among the system's springs.
    spring: usize,
    w: Direction,
    /// The force's row on the values of the operations.
    row: Functional,
    /// Straight stiffness of the spring.
    stiffness: f64,
}

impl Curve {
    /// Square of the length of the direction.
    fn size(&self) -> f64 {
        self.w.iter().map(|(_, w)| w * w).sum()
    }
}

/// A stop with the force stiffness xᵖ, x > 0.
struct Press {
    w: Direction,
    stiffness: f64,
    exponent: f64,
    /// e - gap at q = 0.
    excess: f64,
}

impl Press {
    /// Force at an excess, and its slope.
    fn force(&self, x: f64) -> (f64, f64) {
        let slope = self.exponent * self.stiffness * x.max(0.0).powf(self.exponent - 1.0);
        (slope * x.max(0.0) / self.exponent, slope)
    }

    /// Excess at which the stop bears a force.
    fn place(&self, force: f64) -> f64 {
        (force / self.stiffness).powf(1.0 / self.exponent)
    }
}

/// A point of the path.
#[derive(Clone)]
struct Point {
    q: DVector<f64>,
    /// Excess of each curved stop at which its tangent is taken: its last positive excess.
    places: Vec<f64>,
}

/// The curved forces of a machine at rest.
pub(super) struct Curves<'a> {
    system: &'a System,
    /// The augmented state at q = 0.
    z: &'a StateRow,
    curves: Vec<Curve>,
    presses: Vec<Press>,
}

fn along(w: &Direction, q: &DVector<f64>) -> f64 {
    w.iter().map(|&(k, w)| w * q[k]).sum()
}

fn add(force: f64, w: &Direction, to: &mut DVector<f64>) {
    w.iter().for_each(|&(k, w)| to[k] += force * w);
}

impl<'a> Curves<'a> {
    /// The curved forces of a machine with the augmented state `z` at q = 0.
    pub fn new(system: &'a System, z: &'a StateRow) -> Self {
        let mut curves = Vec::new();
        for (spring, own) in system.springs.iter().enumerate() {
            let terms: Vec<_> =
                own.force.terms().iter().copied().filter(|(j, _)| *j >= system.signals.curved).collect();
            if !terms.is_empty() {
                let row = Functional::from_terms(own.force.len(), terms.into_iter());
                let w = direction(&own.elongation.w);
                curves.push(Curve { spring, w, row, stiffness: own.straight_stiffness() });
            }
        }
        let press = |own: &crate::system::StopRows| match (&own.contact, own.law) {
            (Some(contact), StopLaw::Compliant { stiffness, .. }) if own.has_power() => Some(Press {
                w: direction(&own.elongation.w),
                stiffness,
                exponent: contact.exponent,
                excess: own.excess.dot(z),
            }),
            _ => None,
        };
        let presses = system.stops.iter().filter_map(press).filter(|own| own.stiffness > 0.0).collect();
        Self { system, z, curves, presses }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.curves.is_empty() && self.presses.is_empty()
    }

    /// The equilibrium at the end of the path of a machine with these forces. `Ok(Err(left))` has
    /// the force that remains if no equilibrium is found.
    ///
    /// # Errors
    /// [`Error::GivesWay`] if the path ends before.
    pub fn follow(
        &self,
        d: &Description,
        holding: &Holding,
    ) -> Result<Result<DVector<f64>, DVector<f64>>, Error> {
        let origin = self.origin(holding);
        let push = holding.force.amax().max(origin.amax());
        let places = self.presses.iter().map(|own| own.excess.max(own.place(push)).max(f64::MIN_POSITIVE));
        let mut at = Point { q: DVector::zeros(holding.force.len()), places: places.collect() };
        let begin = at.clone();
        let tangent = self.tangent(holding, &origin, &begin, 1.0);
        // A load that nothing bears has no path at all.
        let whole = tangent.settle(&self.system.mass, &begin.q);
        let (mut load, mut step) = (0.0, 1.0);
        if self.is_monotone() {
            at.q = self.by_secants(holding, &origin, &at, (push, 1.0));
        } else if whole.is_err() && self.is_soft(&begin.q, FIRST_LOAD * push) {
            // Curves alone bear the load.
            let mut near = at.clone();
            near.q = self.by_secants(holding, &origin, &at, (push, FIRST_LOAD));
            if let Some(found) = self.solved(holding, &origin, &near, (FIRST_LOAD, true)) {
                (at, load, step) = (found, FIRST_LOAD, FIRST_LOAD);
            }
        }
        for _ in 0..MOST.0 {
            if load >= 1.0 {
                return Ok(Ok(at.q));
            }
            let next = f64::min(load + step, 1.0);
            match self.solved(holding, &origin, &at, (next, self.is_monotone())) {
                Some(found) => (at, load, step) = (found, next, 2.0 * step),
                None => step *= 0.5,
            }
            if step < LEAST_STEP {
                break;
            }
        }
        let there = self.state(&at.q);
        let of = |own: &Curve| (own.stiffness + self.slope(own, &there)) * own.size();
        let softest = self.curves.iter().min_by(|a, b| of(a).total_cmp(&of(b)));
        match (softest, whole) {
            (Some(own), _) if load > 0.0 || of(own) < 0.0 => {
                let spring = d.springs.get(own.spring).map_or(String::new(), |own| own.name.clone());
                Err(Error::GivesWay { spring, factor: load })
            }
            (_, left) => Ok(left),
        }
    }

    /// Whether no spring falls at a point: with a falling spring no equilibrium is near. A slope
    /// counts as 0 if it is rounding of the stiffness at which the spring bears a force.
    fn is_soft(&self, q: &DVector<f64>, force: f64) -> bool {
        let there = self.state(q);
        self.curves.iter().all(|own| {
            let slope = own.stiffness + self.slope(own, &there);
            slope >= -ZERO * (self.secant(own, force) + own.stiffness).abs()
        })
    }

    /// An estimate of the equilibrium at a load, by lines from q = 0 to the point at which each
    /// spring bears this share of `push`. The tangent of a spring may be zero at q = 0.
    fn by_secants(
        &self,
        holding: &Holding,
        origin: &DVector<f64>,
        at: &Point,
        (push, load): (f64, f64),
    ) -> DVector<f64> {
        let secants = self.curves.iter().map(|own| self.secant(own, load * push)).collect::<Vec<_>>();
        let own = self.put(holding, origin, (at, &secants), load);
        own.settle(&self.system.mass, &at.q).unwrap_or_else(|_| at.q.clone())
    }

    /// The stiffness between no elongation and the one at which a spring bears a force.
    fn secant(&self, own: &Curve, force: f64) -> f64 {
        let mut q = DVector::zeros(self.system.coordinates);
        let begin = own.row.dot(self.z);
        let of = |e: f64, q: &mut DVector<f64>| {
            own.w.iter().for_each(|&(k, w)| q[k] = e * w / own.size());
            (own.row.dot(&self.state(q)) - begin) / e
        };
        let mut bears = |e: f64| {
            let k = of(e, &mut q);
            k.is_finite().then_some((k, (k + own.stiffness) * e >= force))
        };
        let all = (-100..100).map(|k| 2f64.powi(k));
        let Some(most) = all.into_iter().find(|e| bears(*e).is_some_and(|own| own.1)) else { return 0.0 };
        let (mut low, mut high) = (0.5 * most, most);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            *if bears(middle).is_some_and(|own| own.1) { &mut high } else { &mut low } = middle;
        }
        bears(high).map_or(0.0, |own| own.0)
    }

    /// The augmented state at coordinates q.
    fn state(&self, q: &DVector<f64>) -> StateRow {
        let mut z = self.z.clone();
        z.rows_mut(0, q.len()).copy_from(q);
        self.system.fill_curved(z.as_mut_slice());
        z
    }

    /// Slope of a curved force by its elongation at a state, without the straight stiffness.
    fn slope(&self, own: &Curve, z: &StateRow) -> f64 {
        let size = own.size();
        if size == 0.0 {
            return 0.0;
        }
        let mut variation = StateRow::zeros(self.z.len());
        own.w.iter().for_each(|&(k, w)| variation[k] = w / size);
        self.system.vary_curved(z.as_slice(), variation.as_mut_slice());
        own.row.dot(&variation)
    }

    /// The force on each coordinate at q = 0, with compliant contacts.
    fn origin(&self, holding: &Holding) -> DVector<f64> {
        let mut force = holding.force.clone();
        for RestContact { w, excess, force: (low, high), compliance } in &holding.contacts {
            if *compliance > 0.0 {
                add(-(excess / compliance).clamp(*low, *high), w, &mut force);
            }
        }
        self.presses.iter().for_each(|own| add(-own.force(own.excess).0, &own.w, &mut force));
        force
    }

    /// The piecewise linear problem of the tangents at a point.
    fn tangent(&self, holding: &Holding, origin: &DVector<f64>, at: &Point, load: f64) -> Holding {
        let z = self.state(&at.q);
        let slopes = self.curves.iter().map(|own| self.slope(own, &z)).collect::<Vec<_>>();
        self.put(holding, origin, (at, &slopes), load)
    }

    /// The piecewise linear problem of lines through a point of each curve with these slopes.
    fn put(
        &self,
        holding: &Holding,
        origin: &DVector<f64>,
        (at, slopes): (&Point, &[f64]),
        load: f64,
    ) -> Holding {
        let mut own = Holding {
            contacts: holding.contacts.to_vec(),
            springs: holding.springs.to_vec(),
            force: &holding.force - (1.0 - load) * origin,
            sizes: holding.sizes.clone() + origin.abs(),
        };
        for contact in own.contacts.iter_mut().filter(|own| own.compliance == 0.0 && own.excess > 0.0) {
            contact.excess *= load;
        }
        let z = self.state(&at.q);
        for (curve, &stiffness) in self.curves.iter().zip(slopes) {
            let (begin, force) = (curve.row.dot(self.z), curve.row.dot(&z));
            let e = along(&curve.w, &at.q);
            add(begin - force + stiffness * e, &curve.w, &mut own.force);
            let size = begin.abs() + force.abs() + (stiffness * e).abs();
            curve.w.iter().for_each(|&(k, w)| own.sizes[k] += w.abs() * size);
            own.springs.push(RestSpring { w: curve.w.clone(), stiffness, spring: usize::MAX });
        }
        own.springs.retain(|spring| spring.stiffness != 0.0);
        for (press, &place) in self.presses.iter().zip(&at.places) {
            let (force, slope) = press.force(place);
            own.contacts.push(RestContact {
                w: press.w.clone(),
                excess: press.excess - (place - force / slope),
                force: (0.0, f64::INFINITY),
                compliance: 1.0 / slope,
            });
        }
        own
    }

    /// A correction: the equilibrium of the springs' tangents at a point, with stops as they are.
    fn corrected(&self, holding: &Holding, origin: &DVector<f64>, from: &Point, load: f64) -> Option<Point> {
        let mut at = from.clone();
        let tangents = |at: &Point| {
            // The springs keep the tangents of the first point.
            let of = Point { q: from.q.clone(), places: at.places.clone() };
            self.tangent(holding, origin, &of, load)
        };
        for _ in 0..MOST.2 {
            at.q = tangents(&at).settle(&self.system.mass, &at.q).ok()?;
            let mut is_done = true;
            for (press, place) in self.presses.iter().zip(&mut at.places) {
                let excess = press.excess + along(&press.w, &at.q);
                let size = press.excess.abs() + excess.abs() + at.q.amax();
                is_done &= excess <= 0.0 || (excess - *place).abs() <= ROUNDING * size;
                *place = if excess > 0.0 { excess } else { *place };
            }
            if is_done {
                break;
            }
        }
        // The last corrections of stops are rounding.
        Some(at)
    }

    /// The point of the path at a load, from a point before it; from `any` point if only one
    /// equilibrium is near.
    fn solved(
        &self,
        holding: &Holding,
        origin: &DVector<f64>,
        from: &Point,
        (load, any): (f64, bool),
    ) -> Option<Point> {
        let off = |a: &Point, b: &Point| {
            let change = &a.q - &b.q;
            change.dot(&self.system.mass.times(&change)).sqrt()
        };
        let mut at = self.corrected(holding, origin, from, load)?;
        let mut last = off(&at, from);
        for count in 0..MOST.1 {
            let next = self.corrected(holding, origin, &at, load)?;
            let (change, size) = (off(&next, &at), next.q.dot(&self.system.mass.times(&next.q)).sqrt());
            let contracts = any || change <= CONTRACTION * last || change <= SMALL * size;
            if count == 0 && !contracts || !change.is_finite() {
                return None;
            }
            at = next;
            if change <= ROUNDING * size || change >= last && change <= SMALL * size {
                return self.is_stable(holding, origin, &at, load).then_some(at);
            }
            last = change;
        }
        None
    }

    /// Whether no curved force falls at any displacement: the equilibrium is then unique.
    fn is_monotone(&self) -> bool {
        let rises = |(j, factor): &(usize, f64)| match &self.system.curved[j - self.system.signals.curved]
            .operation
        {
            Operation::Polynomial(Polynomial { coefficients: [c2, c3, c4, c5] }) => {
                *c2 == 0.0 && *c4 == 0.0 && factor * c3 >= 0.0 && factor * c5 >= 0.0
            }
            Operation::TwoSided(_) => *factor >= 0.0,
            _ => false,
        };
        self.curves.iter().all(|own| own.stiffness >= 0.0 && own.row.terms().iter().all(rises))
    }

    /// Whether the stiffness at a point is positive in all directions that closed stops leave
    /// free.
    fn is_stable(&self, holding: &Holding, origin: &DVector<f64>, at: &Point, load: f64) -> bool {
        if self.is_monotone() {
            return true;
        }
        let own = self.tangent(holding, origin, at, load);
        let n = at.q.len();
        let mut stiffness = DMatrix::zeros(n, n);
        let mut put = |w: &Direction, k: f64| {
            w.iter().for_each(|&(i, a)| w.iter().for_each(|&(j, b)| stiffness[(i, j)] += k * a * b));
        };
        own.springs.iter().for_each(|spring| put(&spring.w, spring.stiffness));
        let largest = own.springs.iter().map(|spring| spring.stiffness.abs()).fold(0.0, f64::max);
        for contact in &own.contacts {
            let excess = contact.excess + along(&contact.w, &at.q);
            let is_closed = excess >= -ROUNDING * (contact.excess.abs() + at.q.amax());
            match contact.compliance > 0.0 {
                true => {
                    let force = excess / contact.compliance;
                    if contact.force.0 < force && force < contact.force.1 {
                        put(&contact.w, 1.0 / contact.compliance);
                    }
                }
                false if is_closed => put(&contact.w, RIGID * largest),
                false => {}
            }
        }
        let root = self.system.inertia.l();
        let half = root.solve_lower_triangular(&stiffness);
        let whole = half.and_then(|half| root.solve_lower_triangular(&half.transpose()));
        let Some(whole) = whole else { return false };
        let values = SymmetricEigen::new(0.5 * (&whole + whole.transpose())).eigenvalues;
        // Directions without force have the stiffness 0.
        values.min() >= -ZERO * largest / self.system.mass.diagonal().min()
    }
}
