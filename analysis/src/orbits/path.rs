//! One branch of orbits followed along a parameter, with the special points on it.

use super::branch::{Label, Point, Special};
use super::curve::{CurvePoint, correct};
use super::cycle::Cycle;
use super::family::{Contacts, Family, Span};
use super::grazing::{self, Touch};
use super::obstacle::Obstacle;
use super::orbit::{Orbit, eigenvalues, newton};
use super::special;
use super::switching::{Contact, Departure};
use super::test_functions::{DOUBLING, PAIR, Sample, SignedLog, TESTS, UNIT, test};
use super::word::OrbitWord;
use nalgebra::{Complex, DVector};
use std::f64::consts::TAU;

/// Least step: a branch that needs a smaller one ends without convergence.
const LEAST_STEP: f64 = 1e-7;
/// A step's correction is at most this part of it.
const CORRECTION: f64 = 0.3;
/// The least cosine of the angle by which the tangent turns in a step.
const COSINE: f64 = 0.95;
/// How far ahead, in steps, a branch that cannot be followed is looked for its birth.
const BEYOND: f64 = 2.0;
/// Growth of the step after few Newton steps, and its reduction after many.
const GROWTH: f64 = 1.4;
const REDUCTION: f64 = 1.5;
/// Points after which a branch can have closed.
const SHORTEST_LOOP: usize = 10;
/// Distance from the first point, in steps, at which a branch counts as closed.
const CLOSED: f64 = 0.05;
/// Accuracy of a special point in the arc: rounding of the points themselves is of this size.
const LOCATION: f64 = 1e-14;
/// Accuracy, in parts of a step, with which a change of sign is located that may be none of interest, and the distance from the unit
/// circle of a pair of multipliers that may cross it so near.
const ROUGHLY: f64 = 1e-4;
const NEAR_CIRCLE: f64 = 0.1;
/// Difference of two values of the parameter, in its unit of the curve, that is rounding.
const MARK: f64 = 1e-12;

/// How branches are followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathOptions {
    /// The longest step along a branch: phases in rad, the parameter in fifths of its range.
    pub longest_step: f64,
    /// Most points of a branch in one direction.
    pub most_points: usize,
}

impl Default for PathOptions {
    fn default() -> Self {
        Self { longest_step: 0.05, most_points: 3000 }
    }
}

/// How a path ends.
#[derive(Clone, Debug)]
pub(super) enum PathEnd {
    /// Its last point's label says how.
    Plain,
    /// At its first point.
    Closed,
    /// At a touch.
    Touch(Box<Touch>),
    /// At the branch from which it is born by doubling: that branch's word, phases and parameter.
    Primary(OrbitWord, DVector<f64>),
}

/// A path with its end.
#[derive(Clone, Debug)]
pub(super) struct Path {
    pub points: Vec<Point>,
    pub end: PathEnd,
}

/// A point with all that is known of it.
struct Position {
    u: DVector<f64>,
    tangent: DVector<f64>,
    steps: usize,
    multipliers: [Complex<f64>; 6],
    stable: bool,
    tests: [Option<SignedLog>; TESTS],
}

/// A step that was taken.
struct Advance {
    between: Vec<Point>,
    next: Position,
    label: Option<Special>,
    end: Option<PathEnd>,
}

/// A special point within a step.
struct Found {
    arc: f64,
    at: CurvePoint,
    label: Label,
}

pub(super) struct Follower<'a> {
    pub family: &'a Family,
    pub word: &'a OrbitWord,
    pub options: &'a PathOptions,
    /// Values of the parameter at which points are wanted.
    pub marks: &'a [f64],
}

/// Follows a branch until it ends.
pub(super) fn follow(follower: &Follower, departure: Departure) -> Result<Path, Obstacle> {
    let first = follower.first(&departure)?;
    let mut points = vec![follower.point(&first, departure.special.clone())];
    let (start_u, start_tangent) = (first.u.clone(), first.tangent.clone());
    let mut last = first;
    let mut step = departure.step.min(follower.options.longest_step);
    loop {
        if points.len() >= follower.options.most_points {
            label_last(&mut points, Label::NoConvergence);
            return Ok(Path { points, end: PathEnd::Plain });
        }
        let advance = match follower.advance(&last, step) {
            Ok(advance) => advance,
            Err(_) if step > LEAST_STEP => {
                step *= 0.5;
                continue;
            }
            Err(_) => {
                label_last(&mut points, Label::NoConvergence);
                return Ok(Path { points, end: PathEnd::Plain });
            }
        };
        let Advance { between, next, label, end } = advance;
        let closes = points.len() > SHORTEST_LOOP && follower.closes(&start_u, &start_tangent, &last, &next);
        if points.len() == 1 && departure.special.is_some() {
            // The first point is special, so that its piece has the stability of what follows.
            points[0].stable = next.stable && between.is_empty();
        }
        points.extend(between);
        if closes {
            points.push(points[0].clone());
            return Ok(Path { points, end: PathEnd::Closed });
        }
        let mut point = follower.point(&next, label);
        if end.is_some() {
            // The last point has the stability of the piece before it.
            point.stable = points.last().is_some_and(|p| p.stable);
        }
        points.push(point);
        if let Some(end) = end {
            return Ok(Path { points, end });
        }
        if next.steps <= 3 {
            step *= GROWTH;
        } else if next.steps >= 5 {
            step /= REDUCTION;
        }
        step = step.clamp(LEAST_STEP, follower.options.longest_step);
        last = next;
    }
}

/// The number of multipliers outside the unit circle.
fn outside(multipliers: &[Complex<f64>; 6]) -> usize {
    multipliers.iter().filter(|m| m.norm() > 1.0).count()
}

fn label_last(points: &mut [Point], label: Label) {
    if let Some(last) = points.last_mut().filter(|p| p.special.is_none()) {
        last.special = Some(Special::of(label));
    }
}

impl Follower<'_> {
    fn contacts(&self) -> Contacts<'_> {
        Contacts { family: self.family, word: self.word }
    }

    fn span(&self) -> &Span {
        self.family.span()
    }

    fn value(&self, u: &DVector<f64>) -> f64 {
        u[self.word.len()] * self.span().unit()
    }

    /// Whether a value of the parameter is a mark but for rounding.
    fn is_at(&self, value: f64, mark: f64) -> bool {
        (value - mark).abs() <= MARK * self.span().unit()
    }

    fn point(&self, position: &Position, special: Option<Special>) -> Point {
        let value = self.value(&position.u);
        let mark =
            self.marks.iter().copied().find(|mark| self.is_at(value, *mark)).filter(|_| special.is_none());
        Point {
            value: mark.unwrap_or(value),
            phases: position.u.as_slice()[..self.word.len()].to_vec(),
            multipliers: position.multipliers,
            stable: position.stable,
            special: special.or(mark.map(|_| Special::of(Label::UserValue))),
        }
    }

    /// What is known of the first point: a birth or a touch has no tests but those that remain regular there.
    fn first(&self, departure: &Departure) -> Result<Position, Obstacle> {
        let Departure { u, tangent, .. } = departure;
        let system = self.family.system_at(u)?;
        let cycle = Cycle::new(&system, self.word, &u.as_slice()[..self.word.len()])?;
        let label = departure.special.as_ref().map(|s| s.label);
        if label.is_none() {
            let sample = Sample::of(&cycle).ok_or(Obstacle::NoConvergence)?;
            let (stable, Sample { multipliers, tests, .. }) = (sample.is_stable(), sample);
            return Ok(Position {
                u: u.clone(),
                tangent: tangent.clone(),
                steps: 3,
                multipliers,
                stable,
                tests,
            });
        }
        let smooth = label == Some(Label::Grazing);
        let tests = [UNIT, DOUBLING].map(|index| if smooth { test(&cycle, index) } else { None });
        let own = || eigenvalues(cycle.monodromy());
        let multipliers = departure.multipliers.or_else(own).ok_or(Obstacle::NoConvergence)?;
        let tests = [tests[0], tests[1], None];
        Ok(Position { u: u.clone(), tangent: tangent.clone(), steps: 3, multipliers, stable: false, tests })
    }

    /// Looks at a point; `Err` with the touches that it announces is left to the caller, who finds it not certified.
    fn look(&self, curve: CurvePoint) -> Result<(Position, Option<Vec<Touch>>), Obstacle> {
        let system = self.family.system_at(&curve.u)?;
        let cycle = Cycle::new(&system, self.word, &curve.u.as_slice()[..self.word.len()])?;
        let sample = Sample::of(&cycle).ok_or(Obstacle::NoConvergence)?;
        let touches = (!sample.is_certified()).then(|| grazing::announced(&cycle, &curve.u));
        let (stable, Sample { multipliers, tests, .. }) = (sample.is_stable(), sample);
        let CurvePoint { u, tangent, steps } = curve;
        Ok((Position { u, tangent, steps, multipliers, stable, tests }, touches))
    }

    /// One step, to the next point or to the path's end before it.
    fn advance(&self, last: &Position, step: f64) -> Result<Advance, Obstacle> {
        let predicted = &last.u + &last.tangent * step;
        if !self.span().contains(self.value(&predicted)) {
            return self.advance_to_end(last, self.value(&predicted));
        }
        let follows = |curve: &CurvePoint| {
            let turned = curve.tangent.dot(&last.tangent) < COSINE;
            !turned && (&curve.u - &predicted).norm() <= CORRECTION * step
        };
        let Some(curve) = correct(&self.contacts(), &predicted, &last.tangent).ok().filter(follows) else {
            // Next to the branch from which this one is born, the corrector may end on that one.
            let beyond = &last.u + &last.tangent * (BEYOND * step);
            let primary = special::primary(self.family, self.word, &last.u, &beyond)?;
            return self.end_at_primary(last, primary.ok_or(Obstacle::NoConvergence)?);
        };
        if !self.span().contains(self.value(&curve.u)) {
            return self.advance_to_end(last, self.value(&curve.u));
        }
        self.arrive(last, curve, None)
    }

    /// The step to the end of the parameter's range that lies before `beyond`.
    fn advance_to_end(&self, last: &Position, beyond: f64) -> Result<Advance, Obstacle> {
        let n = self.word.len();
        let end = if beyond < self.span().from { self.span().from } else { self.span().to };
        let arc = (end / self.span().unit() - last.u[n]) / last.tangent[n];
        if !(arc.is_finite() && arc >= 0.0) {
            return Err(Obstacle::NoConvergence);
        }
        let predicted = &last.u + &last.tangent * arc;
        let phases = newton(&self.family.system(&[end])?, self.word, &predicted.as_slice()[..n])?;
        let u = self.family.point(&phases, &[end]);
        if (&u - &predicted).norm() > CORRECTION * arc + LEAST_STEP {
            return Err(Obstacle::NoConvergence);
        }
        let tangent = super::curve::tangent(&self.contacts(), &u, &last.tangent)?;
        let curve = CurvePoint { u, tangent, steps: 3 };
        self.arrive(last, curve, Some(Label::EndPoint))
    }

    /// Takes a point as the next one, unless the path ends before it.
    fn arrive(&self, last: &Position, curve: CurvePoint, label: Option<Label>) -> Result<Advance, Obstacle> {
        let (next, touches) = self.look(curve)?;
        if let Some(touches) = touches {
            return self.end_at_touch(last, &next, touches);
        }
        if let Some(primary) = special::primary(self.family, self.word, &last.u, &next.u)? {
            return self.end_at_primary(last, primary);
        }
        let between = self.between(last, &next)?;
        let end = label.map(|_| PathEnd::Plain);
        Ok(Advance { between, next, label: label.map(Special::of), end })
    }

    /// Ends the path at the first of the touches that are met on the way to `next`.
    fn end_at_touch(
        &self,
        last: &Position,
        next: &Position,
        touches: Vec<Touch>,
    ) -> Result<Advance, Obstacle> {
        let length = last.tangent.dot(&(&next.u - &last.u));
        let arc = |touch: &Touch| {
            let way = touch.on_branch() - &last.u;
            let arc = last.tangent.dot(&way);
            let aside = (way - &last.tangent * arc).norm();
            let near = aside <= CORRECTION * length + LEAST_STEP;
            (near && arc >= -LEAST_STEP && arc <= length + LEAST_STEP).then_some(arc)
        };
        let located = touches.iter().filter_map(|touch| grazing::locate(self.family, touch).ok());
        let placed = located.filter_map(|touch| Some((arc(&touch)?, touch)));
        // Of two at one point, as where a repeated orbit touches in each round, the impact that the word lists is taken out.
        let order = |a: &(f64, Touch), b: &(f64, Touch)| {
            if (a.0 - b.0).abs() < LEAST_STEP {
                b.1.from_longer.cmp(&a.1.from_longer)
            } else {
                a.0.total_cmp(&b.0)
            }
        };
        let (_, touch) = placed.min_by(order).ok_or(Obstacle::NoConvergence)?;
        let (touch, is_orbit, pressed) = grazing::examine(self.family, touch)?;
        if !is_orbit {
            return Err(Obstacle::NoConvergence);
        }
        let u = touch.on_branch();
        let system = self.family.system_at(&u)?;
        let cycle = Cycle::new(&system, self.word, &u.as_slice()[..self.word.len()])?;
        let tests = [test(&cycle, UNIT), test(&cycle, DOUBLING), None];
        let without = Contact::of(self.family, &touch);
        let phases = &without.u.as_slice()[..without.shorter.len()];
        let multipliers = Orbit::at(&system, &without.shorter, phases)?.multipliers();
        let tangent = last.tangent.clone();
        let at = Position { u, tangent, steps: 3, multipliers, stable: false, tests };
        let between = self.between(last, &at)?;
        let label = if pressed { Label::Chatter } else { Label::Grazing };
        let special = Special { longer: Some(touch.longer.clone()), ..Special::of(label) };
        let end = if pressed { PathEnd::Plain } else { PathEnd::Touch(Box::new(touch)) };
        Ok(Advance { between, next: at, label: Some(special), end: Some(end) })
    }

    /// Ends the path at the branch from which it is born by doubling.
    fn end_at_primary(
        &self,
        last: &Position,
        (word, u): (OrbitWord, DVector<f64>),
    ) -> Result<Advance, Obstacle> {
        let n = word.len();
        let phases = super::orbit::unfolded_phases(&word, &u.as_slice()[..n]);
        let values = self.family.values(&u);
        let doubled = self.family.point(&phases, &values);
        let system = self.family.system(&values)?;
        let cycle = Cycle::new(&system, self.word, &phases)?;
        let multipliers = eigenvalues(cycle.monodromy()).ok_or(Obstacle::NoConvergence)?;
        // The test for doubling changes its sign on the way if it does; that for a multiplier 1 touches zero at the end.
        let tests = [None, test(&cycle, DOUBLING), None];
        let tangent = last.tangent.clone();
        let next = Position { u: doubled, tangent, steps: 3, multipliers, stable: false, tests };
        let between = self.between(last, &next)?;
        let label = if word.closing() < 0 { Label::BranchPoint } else { Label::PeriodDoubling };
        Ok(Advance { between, next, label: Some(Special::of(label)), end: Some(PathEnd::Primary(word, u)) })
    }

    /// Whether a step passes the first point again.
    fn closes(&self, u: &DVector<f64>, tangent: &DVector<f64>, last: &Position, next: &Position) -> bool {
        let n = self.word.len();
        let way = &next.u - &last.u;
        let length = way.norm();
        let phases = &u.as_slice()[..n];
        self.word.symmetries(self.family.is_symmetric()).into_iter().any(|turn| {
            let turned = self.word.turned_phases(phases, turn);
            let rates =
                DVector::from_fn(n + 1, |i, _| if i < n { tangent[(i + turn.by) % n] } else { tangent[n] });
            let whole = ((last.u[0] - turned[0]) / TAU).round() * TAU;
            let there = DVector::from_fn(n + 1, |i, _| if i < n { turned[i] + whole } else { u[n] });
            let from = there - &last.u;
            let part = from.dot(&way) / (length * length);
            let aside = (from - &way * part).norm();
            let same_way = rates.dot(&next.tangent) > COSINE;
            (0.0..=1.0).contains(&part) && aside < CLOSED * length && same_way
        })
    }

    /// The special points between two points, in order, with the stability of the pieces that follow them.
    fn between(&self, last: &Position, next: &Position) -> Result<Vec<Point>, Obstacle> {
        let changes = |index: usize| {
            let pair = last.tests[index].zip(next.tests[index]);
            pair.filter(|(a, b)| a.sign * b.sign < 0.0).map(|(a, _)| a)
        };
        let mut found = Vec::new();
        for index in 0..TESTS {
            if let Some(unit) = changes(index) {
                found.extend(self.zero(last, next, index, unit)?);
            }
        }
        found.extend(self.marks.iter().filter_map(|mark| self.mark(last, next, *mark)));
        found.sort_by(|a, b| a.arc.total_cmp(&b.arc));
        let length = last.tangent.dot(&(&next.u - &last.u));
        let ends: Vec<f64> = found.iter().skip(1).map(|f| f.arc).chain([length]).collect();
        let mut points = Vec::new();
        for (Found { arc, at, label }, end) in found.into_iter().zip(ends) {
            let middle = self.at_arc(last, next, 0.5 * (arc + end))?;
            let stable = self.look(middle)?.0.stable;
            let position = self.look(at)?.0;
            points.push(Point { stable, ..self.point(&position, Some(Special::of(label))) });
        }
        Ok(points)
    }

    /// The branch's point in the plane across the last tangent at a distance from the last point.
    fn at_arc(&self, last: &Position, next: &Position, arc: f64) -> Result<CurvePoint, Obstacle> {
        let way = &next.u - &last.u;
        let length = last.tangent.dot(&way);
        let part = arc / length;
        // The parabola through both points that leaves along the tangent.
        let predicted = &last.u + &last.tangent * arc + (way - &last.tangent * length) * (part * part);
        correct(&self.contacts(), &predicted, &last.tangent)
    }

    /// The bifurcation at the zero of a test function between two points, if it is one.
    fn zero(
        &self,
        last: &Position,
        next: &Position,
        index: usize,
        unit: SignedLog,
    ) -> Result<Option<Found>, Obstacle> {
        let length = last.tangent.dot(&(&next.u - &last.u));
        let value = |arc: f64| -> Result<f64, Obstacle> {
            let at = self.at_arc(last, next, arc)?;
            let system = self.family.system_at(&at.u)?;
            let cycle = Cycle::new(&system, self.word, &at.u.as_slice()[..self.word.len()])?;
            let found = test(&cycle, index).ok_or(Obstacle::NoConvergence)?;
            Ok(found.relative_to(unit))
        };
        let ends = (unit.sign, next.tests[index].map_or(f64::NAN, |b| b.relative_to(unit)));
        if index == PAIR
            && !self.may_be_torus(last, next, |tolerance| special::zero(&value, length, ends, tolerance))?
        {
            return Ok(None);
        }
        let arc = special::zero(&value, length, ends, LOCATION).ok_or(Obstacle::NoConvergence)?;
        let at = self.at_arc(last, next, arc)?;
        let turns = last.tangent[self.word.len()] * next.tangent[self.word.len()] < 0.0;
        let label = match index {
            UNIT if turns => Label::Fold,
            UNIT => Label::BranchPoint,
            DOUBLING if self.word.closing() > 0 => Label::PeriodDoubling,
            DOUBLING => Label::BranchPoint,
            _ => Label::NeimarkSacker,
        };
        if index == PAIR && !special::is_torus(self.family, self.word, &at.u)? {
            return Ok(None);
        }
        Ok(Some(Found { arc, at, label }))
    }

    /// Whether a pair of multipliers may cross the unit circle in a step in which the pair's test changes its sign; `zero` gives the
    /// place of the change to a tolerance. The test changes at neutral saddles too, and by the rounding of multipliers next to very
    /// large ones, which would be located with much work for nothing.
    fn may_be_torus(
        &self,
        last: &Position,
        next: &Position,
        zero: impl Fn(f64) -> Option<f64>,
    ) -> Result<bool, Obstacle> {
        let changes = |index: usize| {
            let signs = [last, next].map(|p| p.tests[index].map_or(0.0, |t| t.sign));
            signs[0] * signs[1] < 0.0
        };
        // A pair changes the number of multipliers outside the circle by two; a real multiplier may do so in the same step.
        let [before, after] = [last, next].map(|p| outside(&p.multipliers));
        if !changes(UNIT) && !changes(DOUBLING) && before.abs_diff(after) < 2 {
            return Ok(false);
        }
        let length = last.tangent.dot(&(&next.u - &last.u));
        let arc = zero(ROUGHLY * length).ok_or(Obstacle::NoConvergence)?;
        let there = self.look(self.at_arc(last, next, arc)?)?.0;
        let near = |m: &Complex<f64>| m.im != 0.0 && (m.norm() - 1.0).abs() < NEAR_CIRCLE;
        Ok(there.multipliers.iter().any(near))
    }

    /// The point at a value of the parameter, where the step passes it.
    fn mark(&self, last: &Position, next: &Position, mark: f64) -> Option<Found> {
        let n = self.word.len();
        let [from, to] = [&last.u, &next.u].map(|u| self.value(u));
        // A point that has the value is labelled itself.
        if (from - mark) * (to - mark) >= 0.0 || self.is_at(from, mark) || self.is_at(to, mark) {
            return None;
        }
        let part = (mark - from) / (to - from);
        let guess = &last.u + (&next.u - &last.u) * part;
        let system = self.family.system(&[mark]).ok()?;
        let phases = newton(&system, self.word, &guess.as_slice()[..n]).ok()?;
        let u = self.family.point(&phases, &[mark]);
        let arc = last.tangent.dot(&(&u - &last.u));
        let at = CurvePoint { u, tangent: last.tangent.clone(), steps: 3 };
        Some(Found { arc, at, label: Label::UserValue })
    }
}
