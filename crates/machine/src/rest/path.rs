//! The equilibrium reached when all loads grow together from zero, in a machine with a spring
//! whose characteristic has a falling line (docs/assembly-law.md, section 10).

use super::lines::Lined;
use super::{Holding, RestSpring, direction};
use crate::description::{Description, StopLaw};
use crate::error::Error;
use crate::functional::StateRow;
use crate::system::System;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Tolerance for zero: of a stiffness relative to the largest one, and of a length or a force
/// relative to its terms.
const ZERO: f64 = 1e-12;
/// Largest number of pieces of the load path.
const PIECES: usize = 10_000;
/// Limit for the elements at their limits, up to which all combinations of sides are tried. Any
/// further elements keep their sides.
const AT_ONCE: usize = 12;

/// A stop at rest.
struct RestStop {
    column: DVector<f64>,
    /// e - gap at q = 0.
    excess: f64,
    /// `None` for a rigid stop.
    stiffness: Option<f64>,
}

/// The load path, from no load to all loads.
pub(super) struct LoadPath<'a> {
    system: &'a System,
    lined: Vec<Lined<'a>>,
    springs: Vec<(DVector<f64>, f64)>,
    stops: Vec<RestStop>,
    /// The forces at q = 0, in the metric of the inertia.
    force: DVector<f64>,
}

/// A point of the load path. Its coordinates are y = Lᵀ q, where the inertia is L Lᵀ.
#[derive(Clone)]
struct Point {
    load: f64,
    y: DVector<f64>,
    /// For each stop: the force, if the stop is rigid and closed.
    lambda: Vec<f64>,
    /// For each lined spring: index of the line that acts.
    lines: Vec<usize>,
    /// For each stop: whether it presses (if compliant) or is closed (if rigid).
    bears: Vec<bool>,
}

/// An element at its limit.
#[derive(Clone, Copy)]
enum Limit {
    /// A lined spring at a corner: index of the spring, and index of the line below the corner.
    Corner(usize, usize),
    Stop(usize),
}

/// Derivative of a point by the load.
struct Direction {
    y: DVector<f64>,
    lambda: Vec<f64>,
}

impl<'a> LoadPath<'a> {
    /// The path of a machine with augmented state `z` at q = 0; `None` without coordinates.
    pub fn new(d: &'a Description, system: &'a System, z: &StateRow, holding: &Holding) -> Option<Self> {
        let lined = Lined::all(d, system, z);
        if system.coordinates == 0 {
            return None;
        }
        let is_lined = |i: usize| lined.iter().any(|own| own.spring == i);
        let springs =
            system.springs.iter().enumerate().filter(|(i, own)| !is_lined(*i) && own.stiffness != 0.0);
        let springs = springs.map(|(_, own)| ((*own.elongation.column).clone(), own.stiffness)).collect();
        let stop = |own: &crate::system::StopRows| RestStop {
            column: (*own.elongation.column).clone(),
            excess: own.excess.dot(z),
            stiffness: match own.law {
                StopLaw::Rigid { .. } => None,
                StopLaw::Compliant { stiffness, .. } => Some(stiffness),
            },
        };
        let stops: Vec<RestStop> = system.stops[..system.first_corner].iter().map(stop).collect();
        let mut force = holding.force.clone();
        for own in &lined {
            let w = &system.springs[own.spring].elongation.w;
            force.axpy(own.line(0, own.e) - own.line(own.of(own.e), own.e), w, 1.0);
        }
        for (rows, own) in system.stops.iter().zip(&stops) {
            force.axpy(-own.stiffness.unwrap_or(0.0) * own.excess.max(0.0), &rows.elongation.w, 1.0);
        }
        let force = system.inertia.l().solve_lower_triangular(&force)?;
        Some(Self { system, lined, springs, stops, force })
    }

    fn column(&self, lined: &Lined) -> &DVector<f64> {
        &self.system.springs[lined.spring].elongation.column
    }

    /// Follows the path to its end. Returns the forces and the coordinates there; the forces
    /// include the active lines.
    pub fn follow(&self, d: &Description, mut holding: Holding) -> Result<(Holding, DVector<f64>), Error> {
        let mut at = Point {
            load: 0.0,
            y: DVector::zeros(self.system.coordinates),
            lambda: vec![0.0; self.stops.len()],
            lines: self.lined.iter().map(|own| own.of(own.e)).collect(),
            bears: self.stops.iter().map(|own| own.excess > 0.0).collect(),
        };
        for _ in 0..PIECES {
            let limits = self.limits(&at);
            let Some(direction) = self.choose(&mut at, &limits) else { break };
            self.advance(&mut at, &direction);
            if at.load < 1.0 {
                continue;
            }
            for (own, &j) in self.lined.iter().zip(&at.lines) {
                holding.put_line(self.system, own, (own.slopes[j], own.line(j, own.e)));
            }
            self.press(&mut holding, &at);
            let q = self.system.inertia.l().tr_solve_lower_triangular(&at.y);
            return Ok((holding, q.unwrap_or(at.y)));
        }
        let spring = d.springs[self.gave_way(&at)].name.clone();
        Err(Error::GivesWay { spring, factor: at.load })
    }

    /// Turns every compliant stop that presses into a spring, so that the stiffness is correct at
    /// the end of the path.
    fn press(&self, holding: &mut Holding, at: &Point) {
        let compliant = |own: &&super::RestContact| own.compliance > 0.0;
        holding.contacts.retain(|own| !compliant(&own));
        for (i, own) in self.stops.iter().enumerate().filter(|(i, _)| at.bears[*i]) {
            if let Some(stiffness) = own.stiffness.filter(|k| *k > 0.0) {
                let w = &self.system.stops[i].elongation.w;
                holding.force.axpy(-stiffness * own.excess, w, 1.0);
                holding.sizes += w.abs() * (stiffness * own.excess).abs();
                let spring = usize::MAX;
                holding.springs.push(RestSpring { w: direction(w), stiffness, spring });
            }
        }
    }

    /// Elongation of a lined spring, and the size of its terms.
    fn elongation(&self, own: &Lined, at: &Point) -> (f64, f64) {
        let column = self.column(own);
        (own.e + column.dot(&at.y), own.e.abs() + column.abs().dot(&at.y.abs()))
    }

    /// Excess of a stop beyond its limit, and the size of its terms. The initial excess of a rigid
    /// stop vanishes as the loads grow.
    fn excess(&self, own: &RestStop, at: &Point) -> (f64, f64) {
        let begin = if own.stiffness.is_none() { (1.0 - at.load) * own.excess.max(0.0) } else { 0.0 };
        let size = own.excess.abs() + own.column.abs().dot(&at.y.abs());
        (own.excess + own.column.dot(&at.y) - begin, size)
    }

    /// The elements at their limits.
    fn limits(&self, at: &Point) -> Vec<Limit> {
        let mut limits = Vec::new();
        for (i, own) in self.lined.iter().enumerate() {
            let (e, size) = self.elongation(own, at);
            let corners = own.points[1..own.points.len() - 1].iter().enumerate();
            let near = corners.filter(|(_, point)| (e - point.e).abs() <= ZERO * (size + point.e.abs()));
            limits.extend(near.map(|(corner, _)| Limit::Corner(i, corner)));
        }
        let force = self.force.amax();
        for (i, own) in self.stops.iter().enumerate() {
            let (excess, size) = self.excess(own, at);
            if excess.abs() <= ZERO * size && at.lambda[i] <= ZERO * force {
                limits.push(Limit::Stop(i));
            }
        }
        limits
    }

    /// Direction of the path after a consistent choice of sides for the elements at their limits;
    /// `None` if no consistent choice has a positive stiffness.
    fn choose(&self, at: &mut Point, limits: &[Limit]) -> Option<Direction> {
        let limits = &limits[..limits.len().min(AT_ONCE)];
        (0..1usize << limits.len()).find_map(|sides| {
            let mut tried = at.clone();
            for (k, limit) in limits.iter().enumerate() {
                let flips = sides & (1 << k) != 0;
                match *limit {
                    Limit::Corner(i, corner) => {
                        let above = (at.lines[i] > corner) != flips;
                        tried.lines[i] = corner + usize::from(above);
                    }
                    Limit::Stop(i) => tried.bears[i] = at.bears[i] != flips,
                }
            }
            let direction = self.direction(&tried)?;
            let leads = limits.iter().all(|limit| self.leads(&tried, &direction, *limit));
            leads.then(|| {
                *at = tried;
                direction
            })
        })
    }

    /// Whether an element at its limit moves to its assumed side.
    fn leads(&self, at: &Point, direction: &Direction, limit: Limit) -> bool {
        let moved =
            |column: &DVector<f64>| (column.dot(&direction.y), ZERO * column.abs().dot(&direction.y.abs()));
        let (rate, zero, up) = match limit {
            Limit::Corner(i, corner) => {
                let (rate, zero) = moved(self.column(&self.lined[i]));
                (rate, zero, at.lines[i] > corner)
            }
            Limit::Stop(i) if self.stops[i].stiffness.is_none() && at.bears[i] => {
                (direction.lambda[i], ZERO * self.force.amax(), true)
            }
            Limit::Stop(i) => {
                let (rate, zero) = moved(&self.stops[i].column);
                let own = &self.stops[i];
                let begin = if own.stiffness.is_none() { own.excess.max(0.0) } else { 0.0 };
                (rate + begin, zero + ZERO * begin, at.bears[i])
            }
        };
        if up { rate >= -zero } else { rate <= zero }
    }

    /// Derivative of a point by the load while every element keeps its side; `None` if the
    /// stiffness of the free directions is not positive definite.
    fn direction(&self, at: &Point) -> Option<Direction> {
        let n = self.system.coordinates;
        let mut stiffness = DMatrix::zeros(n, n);
        let mut add = |column: &DVector<f64>, k: f64| stiffness.ger(k, column, column, 1.0);
        self.springs.iter().for_each(|(column, k)| add(column, *k));
        self.lined.iter().zip(&at.lines).for_each(|(own, &j)| add(self.column(own), own.slopes[j]));
        let mut closed = Vec::new();
        for (i, own) in self.stops.iter().enumerate().filter(|(i, _)| at.bears[*i]) {
            match own.stiffness {
                Some(k) => add(&own.column, k),
                None => closed.push(i),
            }
        }
        let held = DMatrix::from_fn(n, closed.len(), |k, c| self.stops[closed[c]].column[k]);
        let begin = DVector::from_fn(closed.len(), |c, _| -self.stops[closed[c]].excess.max(0.0));
        // In the held directions y = held⁺ᵀ begin. The stiffness determines the other directions.
        let largest = stiffness.amax().max(f64::MIN_POSITIVE);
        let inverse = match closed.len() {
            0 => held.transpose(),
            _ => held.clone().pseudo_inverse(ZERO * held.amax()).ok()?,
        };
        let kept = DMatrix::identity(n, n) - &held * &inverse;
        let mut y = inverse.tr_mul(&begin);
        let left = &kept * (&self.force - &stiffness * &y);
        let free = &kept * &stiffness * &kept + largest * (&held * &inverse);
        let SymmetricEigen { eigenvectors, eigenvalues } =
            SymmetricEigen::new(0.5 * (&free + free.transpose()));
        let highest = eigenvalues.amax();
        for (along, &value) in eigenvectors.column_iter().zip(eigenvalues.iter()) {
            let push = along.dot(&left);
            if value > ZERO * highest {
                y.axpy(push / value, &along, 1.0);
            } else if push.abs() > ZERO * self.force.norm() || !self.is_loose(&along.into_owned()) {
                return None;
            }
        }
        let bear = &inverse * (&self.force - &stiffness * &y);
        let mut lambda = vec![0.0; self.stops.len()];
        closed.iter().zip(bear.iter()).for_each(|(&i, &force)| lambda[i] = force);
        Some(Direction { y, lambda })
    }

    /// Whether no element acts along a direction.
    fn is_loose(&self, along: &DVector<f64>) -> bool {
        let lined = self.lined.iter().map(|own| self.column(own));
        let springs = self.springs.iter().map(|(column, _)| column);
        let mut all = lined.chain(springs).chain(self.stops.iter().map(|own| &own.column));
        all.all(|column| column.dot(along).abs() <= ZERO.sqrt() * column.norm())
    }

    /// Moves a point to the next limit, or to the end of the path.
    fn advance(&self, at: &mut Point, direction: &Direction) {
        let mut length = 1.0 - at.load;
        let mut limit = |left: f64, rate: f64| {
            if rate > 0.0 {
                length = length.min((left / rate).max(0.0));
            }
        };
        for (own, &j) in self.lined.iter().zip(&at.lines) {
            let ((e, _), (below, above)) = (self.elongation(own, at), own.span(j));
            let rate = self.column(own).dot(&direction.y);
            limit(above - e, rate);
            limit(e - below, -rate);
        }
        for (i, own) in self.stops.iter().enumerate() {
            let begin = if own.stiffness.is_none() { own.excess.max(0.0) } else { 0.0 };
            let rate = own.column.dot(&direction.y) + begin;
            let (excess, _) = self.excess(own, at);
            match (at.bears[i], own.stiffness) {
                (false, _) => limit(-excess, rate),
                (true, Some(_)) => limit(excess, -rate),
                (true, None) => limit(at.lambda[i], -direction.lambda[i]),
            }
        }
        at.load = if length >= 1.0 - at.load { 1.0 } else { at.load + length };
        at.y.axpy(length, &direction.y, 1.0);
        at.lambda.iter_mut().zip(&direction.lambda).for_each(|(force, by)| *force += length * by);
    }

    /// Spring with the most steeply falling line among the active lines and the lines that meet at
    /// this point. If none of these lines falls: the first spring with a falling line.
    fn gave_way(&self, at: &Point) -> usize {
        let limits = self.limits(at);
        let falls = |(i, own): (usize, &Lined)| {
            let met = limits.iter().filter_map(|limit| match limit {
                Limit::Corner(other, corner) if *other == i => Some([*corner, corner + 1]),
                _ => None,
            });
            let lines = met.flatten().chain([at.lines[i]]);
            let steepest = lines.map(|j| own.slopes[j]).fold(0.0, f64::min);
            (steepest * self.column(own).norm_squared(), own.spring)
        };
        let steepest = self.lined.iter().enumerate().map(falls).min_by(|a, b| a.0.total_cmp(&b.0));
        let first = || self.lined.iter().find(|own| own.falls()).map_or(0, |own| own.spring);
        steepest.filter(|own| own.0 < 0.0).map_or_else(first, |own| own.1)
    }
}
