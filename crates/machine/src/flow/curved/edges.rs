//! Powers with an edge in a mode: the sides on which a power series begins, and where it ends
//! (docs/assembly-law.md, section 22).

use super::CurveInMode;
use crate::curved::{CurveSeries, NEAR, Operation, Piece, TERMS};
use crate::kernel::Sparse;
use crate::mode::WatchTable;
use std::sync::Arc;
use vibro_numerics::events::first_crossing;

/// Distance from its edge, relative to the sizes of the terms of the argument, that counts as
/// rounding.
const ROUNDING: f64 = 1e-14;
/// Multiple of the rounding up to which a power that is within it counts as 0.
const PASSED: f64 = 4.0;
/// Change of the state by a power that counts as 0, relative to the state: a hundredth of the
/// remainder of a series.
const STATE: f64 = 1e-18;
/// Value of a power that counts as 0 in a watched functional, relative to the sizes of its terms.
const WATCHED: f64 = 1e-17;
/// Largest effect of the slope of such a power of a rate on a derivative of the motion, relative
/// to it.
const OF_RATE: f64 = 1e-14;
/// The same for a power of a displacement, over the time of one series: the changed rate acts much
/// longer. A contact lasts 1e8 to 1e10 times as long.
const OF_PLACE: f64 = 1e-22;
/// Number of orders for the norm of a body that begins to move.
pub(crate) const FIRST: usize = 6;
/// Factor on an argument and a time within which a power at its edge has to be negligible.
const ROOM: f64 = 2.5;
/// Initial span of a series that cannot pass the edge, as a fraction of the time to the edge.
const TO_EDGE: f64 = 1.0;
/// Limit for a series without a proved remainder, as a fraction of the way to the edge.
const OF_WAY: f64 = 0.6;
/// Factor from one tried part of a span to the next.
const SHORTER: f64 = 0.8;
/// Largest number of tried parts.
const TRIALS: usize = 400;

/// A state with the scales to which effects are compared.
pub(crate) struct AtState<'a> {
    /// The state.
    pub z: &'a [f64],
    /// Its time derivative, except of curved forces.
    pub rates: &'a [f64],
    /// 1/w of each coordinate in the norm (A6).
    pub weights: &'a [f64],
    /// Number of states; the signals follow.
    pub one: usize,
    /// Rate of the mode, 1/s.
    pub rate: f64,
    /// The watched functionals of the mode.
    pub watched: &'a [Arc<WatchTable>],
}

impl AtState<'_> {
    /// Whether a force of this size counts as 0 in all watched functionals.
    fn is_unseen(&self, place: usize, force: f64) -> bool {
        let is_small = |row: &Sparse| {
            let own = row.terms().iter().filter(|term| term.0 == place).map(|term| term.1.abs()).sum::<f64>();
            let size = row.terms().iter().map(|&(j, x)| (x * self.z[j]).abs()).sum::<f64>();
            own * force <= WATCHED * size
        };
        self.watched.iter().all(|own| is_small(&own.row))
    }
}

impl CurveInMode {
    /// Whether a power of an argument up to `a` has no effect over a time `h`, on a state of this
    /// norm and on derivatives. The force's value and its slope have these effects. A force
    /// that moves no state, as between held or prescribed bodies, has an effect on contact forces
    /// and accounts all the same.
    fn is_negligible(&self, [effect, slope]: [f64; 2], p: f64, a: f64, (h, norm): (f64, f64)) -> bool {
        let [_, of_velocities, of_others] = self.plain;
        let slope = slope * p * a.powf(p - 1.0) * h;
        effect > 0.0
            && effect * a.powf(p) * h <= STATE * norm
            && slope * of_velocities <= OF_RATE
            && slope * h * of_others <= OF_PLACE
    }
}

/// Sum of the sizes of the terms of an argument.
fn terms(row: &crate::functional::Functional, z: &[f64]) -> f64 {
    row.terms().iter().map(|&(j, x)| (x * z[j]).abs()).sum()
}

/// Whether any force of a mode has an edge.
pub(crate) fn any(curves: &[CurveInMode]) -> bool {
    curves.iter().any(|own| own.curved.operation.edge().is_some())
}

/// The sides of all powers at a state, for the choice of a mode and for single derivatives.
pub(crate) fn sides(curves: &[CurveInMode], z: &[f64]) -> Vec<Piece> {
    let of = |CurveInMode { curved, acts, .. }: &CurveInMode| match acts {
        true => Piece::of(&curved.operation, curved.argument.at(z), NEAR * terms(&curved.argument, z)),
        false => Piece::Still,
    };
    curves.iter().map(of).collect()
}

/// The sides of all powers for a series ahead of a state, and the longest time over which its
/// coefficients are computed, s.
pub(crate) fn sides_ahead(curves: &[CurveInMode], at: &AtState) -> (Vec<Piece>, f64) {
    let norm = at.z[..at.one].iter().zip(at.weights).fold(0.0f64, |most, (z, w)| most.max((z * w).abs()));
    let mut longest = f64::INFINITY;
    let mut of = |(i, own): (usize, &CurveInMode)| {
        let CurveInMode { curved, acts, .. } = own;
        let (Operation::OneSided(p) | Operation::TwoSided(p), true) = (&curved.operation, *acts) else {
            return if curved.operation.edge().is_some() { Piece::Still } else { Piece::Whole };
        };
        let a = curved.argument.at(at.z);
        let side = Piece::of(&curved.operation, a, ROUNDING * terms(&curved.argument, at.z));
        let is_two_sided = matches!(curved.operation, Operation::TwoSided(_));
        if side == Piece::Still || !(is_two_sided || curved.operation.ends_at_edge()) {
            return side;
        }
        let time = a.abs() / curved.argument.at(at.rates).abs();
        // Within this time the argument doubles, or reaches the edge.
        let span = time.min(1.0 / at.rate);
        let farthest = ROOM * a.abs();
        if own.is_negligible(effects(curves, i, at.z), *p, farthest, (ROOM * span, norm))
            && at.is_unseen(curved.place, farthest.powf(*p))
        {
            return Piece::Still;
        }
        if curved.operation.ends_at_edge() {
            longest = longest.min(TO_EDGE * time);
        }
        side
    };
    let sides = curves.iter().enumerate().map(&mut of).collect();
    (sides, longest)
}

/// Norm of the column of a force and its largest entry, with its effect through products.
fn effects(curves: &[CurveInMode], i: usize, z: &[f64]) -> [f64; 2] {
    let mut effects = [curves[i].effect(1.0), curves[i].plain[0]];
    for own in &curves[i + 1..] {
        let Some(&(_, factor)) = own.rows[0].nested.iter().find(|nested| nested.0 == i) else { continue };
        let factor = factor * own.curved.second.at(z).abs();
        effects[0] += factor * own.effect(1.0);
        effects[1] += factor * own.plain[0];
    }
    effects
}

/// The part of a span, at most `part`, before a power first comes to its edge. Only forces whose
/// series continue beyond the edge count. If `backwards` is true, the series goes back in time.
pub(crate) fn part_to_edge(
    curves: &[CurveInMode],
    series: &[CurveSeries],
    part: f64,
    backwards: bool,
) -> f64 {
    let mut first = part;
    for (own, series) in curves.iter().zip(series) {
        let operation = &own.curved.operation;
        if !matches!(operation, Operation::TwoSided(_)) || operation.ends_at_edge() {
            continue;
        }
        if series.piece == Piece::Still || series.sum_of_sizes_beyond(first) < series.first().abs() {
            continue;
        }
        let mut c = series.argument();
        let mut power = -1.0;
        for x in c.iter_mut().take(super::LAST_CURVE_ORDER + 1) {
            *x *= power;
            power *= if backwards { -first } else { first };
        }
        c[super::LAST_CURVE_ORDER + 1..TERMS].fill(0.0);
        if let Some(u) = first_crossing(&c, 0.0, 1.0, &mut 0) {
            first *= u;
        }
    }
    first
}

/// The longest part of a span over which powers at their edges have no effect on a state and its
/// derivatives.
pub(crate) fn part_at_edges(
    curves: &[CurveInMode],
    series: &[CurveSeries],
    (part, span): (f64, f64),
    (z, norms): (&[f64], [f64; FIRST]),
) -> f64 {
    let mut allowed = part;
    for (i, (own, series)) in curves.iter().zip(series).enumerate() {
        let (Some(p), true, Piece::Still) = (own.curved.operation.edge(), own.acts, series.piece) else {
            continue;
        };
        let effects = effects(curves, i, z);
        // Within the rounding of the argument a shorter span would not move it.
        let rounding = PASSED * ROUNDING * terms(&own.curved.argument, z);
        let is_allowed = |part: f64| {
            let a = series.highest(&own.curved.operation, part).max(0.0);
            // A body at rest has a norm only as it begins to move.
            let step = |(most, power): (f64, f64), norm: &f64| (most.max(norm * power), power * part);
            let norm = norms.iter().fold((0.0, 1.0), step).0;
            a <= rounding
                || own.is_negligible(effects, p, a, (series.inside(&own.curved.operation, part) * span, norm))
        };
        allowed = longest(allowed, is_allowed);
    }
    allowed
}

/// The longest part of a span, without a proved remainder, over which powers stay away from edges
/// at which their series end.
pub(crate) fn part_from_edges(curves: &[CurveInMode], series: &[CurveSeries], part: f64) -> f64 {
    let mut allowed = part;
    for (own, series) in curves.iter().zip(series) {
        if own.acts && series.piece != Piece::Still && own.curved.operation.ends_at_edge() {
            let first = series.first().abs();
            allowed = longest(allowed, |part| series.sum_of_sizes_beyond(part) <= OF_WAY * first);
        }
    }
    allowed
}

/// The first of `part` and shorter parts that is allowed.
fn longest(mut part: f64, is_allowed: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..TRIALS {
        if is_allowed(part) {
            break;
        }
        part *= SHORTER;
    }
    part
}
