//! The lowest and highest value of a quantity over a motion, with their derivatives.

use super::adjoint::row_of;
use super::columns::Columns;
use super::crossing::Later;
use super::lost::{Cause, Lost};
use super::machine::{Machine, STILL};
use super::mode::VariedMode;
use super::passed::Passed;
use super::values::Point;
use crate::flow::{INTERVALS, LOCAL, taylor};
use crate::functional::StateRow;
use crate::quantity::Quantity;
use std::collections::HashMap;
use std::sync::Arc;
use vibro_numerics::events::turns;

/// Values count as equal up to this fraction of their terms' sizes, the rounding of a motion.
const EQUAL: f64 = 1e-11;

/// An extreme value of a quantity.
#[derive(Clone, Debug)]
pub struct Extreme {
    /// Time, s.
    pub time: f64,
    /// Value, in SI units.
    pub value: f64,
    /// Derivative of each column, or the reason why it does not exist.
    pub by: Vec<Result<f64, Lost>>,
}

/// A derivative and the sum of the sizes of its terms, or the reason why it does not exist.
type Sized = Result<(f64, f64), Lost>;

/// The lowest and highest value of a quantity over a motion, with their derivatives. Used by
/// [`Differentiated::advance_with_extremes`](super::Differentiated::advance_with_extremes).
///
/// At a turning point, the derivative is the quantity's derivative at this time. At an event,
/// where the quantity or its rate may jump, the variation of the event's time counts as well. The
/// times at which an advance begins and ends do not vary. An extreme value that is reached at
/// several times with different derivatives has no derivative.
///
///
/// The amplitude of an oscillator that starts with v is v/√k, for a mass of 1 kg:
///
/// ```
/// use vibro_machine::derivative::Extremes;
/// use vibro_machine::{Assembly, Differentiated, Quantity, What, file};
///
/// # let text = r#"
/// #     name = "Oscillator"
/// #     body.a = { mass = 1.0, start = { v = 6.0 } }
/// #     spring.k = { between = ["ground", "a"], stiffness = 4.0 }
/// # "#;
/// let machine = file::parse(text, "oscillator.toml", &file::no_records)?;
/// let columns = ["body.a.start.v", "spring.k.stiffness"];
/// let mut motion = Differentiated::new(Assembly::new(machine)?.into(), &columns)?;
/// let mut extremes = [Extremes::new(Quantity::of_body(0, What::S))];
/// motion.advance_with_extremes(2.0, &mut extremes, &mut |_, _| ())?;
/// let highest = extremes[0].highest().unwrap();
/// let [by_speed, by_stiffness] = [0, 1].map(|column| highest.by[column].clone().unwrap());
/// assert!((highest.value - 3.0).abs() < 1e-14 && (by_speed - 0.5).abs() < 1e-14);
/// assert!((by_stiffness + 0.375).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Extremes {
    quantity: Quantity,
    /// Lowest and highest value.
    found: [Option<Extreme>; 2],
    /// The largest sum of the sizes of a value's terms.
    size: f64,
    /// Largest sum of the sizes of a derivative's terms, by column.
    sizes: Vec<f64>,
    rows: HashMap<*const VariedMode, Arc<InMode>>,
}

/// The quantity and its rate in a mode.
struct InMode {
    /// Kept alive so that its address stays a unique key.
    mode: Arc<VariedMode>,
    row: StateRow,
    /// Taylor coefficients of the rate over an interval, by coordinate.
    rate: Vec<[f64; LOCAL]>,
}

/// A value that may be an extreme.
struct Candidate {
    time: f64,
    value: f64,
    size: f64,
}

impl Extremes {
    /// Creates the extremes of a quantity, before the motion begins.
    pub fn new(quantity: Quantity) -> Self {
        Self { quantity, found: [None, None], size: 0.0, sizes: Vec::new(), rows: HashMap::new() }
    }

    /// Returns the quantity.
    pub fn quantity(&self) -> Quantity {
        self.quantity
    }

    /// Returns the lowest value so far; `None` before the motion advances.
    pub fn lowest(&self) -> Option<&Extreme> {
        self.found[0].as_ref()
    }

    /// Returns the highest value so far; `None` before the motion advances.
    pub fn highest(&self) -> Option<&Extreme> {
        self.found[1].as_ref()
    }

    fn in_mode(&mut self, machine: &Machine, mode: &Arc<VariedMode>) -> Arc<InMode> {
        let made = || {
            let row = row_of(machine, mode, self.quantity);
            let (mut rate, step) = (vec![0.0; row.len()], mode.length / INTERVALS as f64);
            mode.a.after_row(row.as_slice(), step, &mut rate);
            let rate = taylor(&mode.a.transpose(), &[rate], step).remove(0);
            Arc::new(InMode { mode: mode.clone(), row, rate })
        };
        self.rows.entry(Arc::as_ptr(mode)).or_insert_with(made).clone()
    }

    /// Updates the extremes with a value; `by` computes its derivatives if they are needed.
    fn consider(&mut self, name: &dyn Fn() -> String, candidate: &Candidate, by: &dyn Fn() -> Vec<Sized>) {
        let Candidate { time, value, size } = *candidate;
        self.size = self.size.max(size);
        let equal = EQUAL * self.size;
        for (sign, place) in [-1.0, 1.0].into_iter().zip(&mut self.found) {
            let more = place.as_ref().map_or(f64::INFINITY, |own| sign * (value - own.value));
            if more < -equal {
                continue;
            }
            let all = by();
            self.sizes.resize(all.len(), 0.0);
            let sizes = self.sizes.iter_mut().zip(&all);
            sizes.for_each(|(most, by)| *most = by.as_ref().map_or(*most, |by| most.max(by.1)));
            let by = all.into_iter().map(|by| by.map(|by| by.0));
            match place {
                Some(own) if more <= equal && own.time != time => own.meet(time, by, (&self.sizes, name)),
                _ => *place = Some(Extreme { time, value, by: by.collect() }),
            }
        }
    }

    /// Whether a value may be the lowest or highest so far.
    fn may_be(&self, candidate: &Candidate) -> bool {
        let equal = EQUAL * self.size.max(candidate.size);
        let off = |own: &Extreme, sign: f64| sign * (candidate.value - own.value) < -equal;
        let [lowest, highest] = &self.found;
        !lowest.as_ref().is_some_and(|own| off(own, -1.0))
            || !highest.as_ref().is_some_and(|own| off(own, 1.0))
    }

    /// Considers the value and its derivatives at a state in a mode, at a fixed time.
    pub(super) fn at(&mut self, machine: &Machine, mode: &Arc<VariedMode>, (time, deltas, lost): Moment) {
        let own = self.in_mode(machine, mode);
        let (quantity, z) = (self.quantity, deltas.state());
        let by = |p: usize| match &lost[p] {
            Some(lost) => Err(lost.clone()),
            None if mode.is_shared(&machine.system, quantity) => Err(shared(machine, quantity, time)),
            None => Ok(own.derivative(machine, (p, quantity), (&z, deltas), 0.0)),
        };
        let candidate = own.candidate(time, &z);
        self.consider(&|| name_of(machine, quantity), &candidate, &|| (0..lost.len()).map(by).collect());
    }

    /// Considers the turning points of a flight of length `span` from a moment.
    pub(super) fn fly(
        &mut self,
        machine: &Machine,
        mode: &Arc<VariedMode>,
        (from, deltas, lost): Moment,
        span: f64,
        carry: &mut dyn FnMut(&mut Columns, f64),
    ) {
        let own = self.in_mode(machine, mode);
        if mode.is_curved() {
            return self.fly_curved((machine, mode, &own), (from, deltas, lost), span);
        }
        let (step, mut z) = (mode.length / INTERVALS as f64, deltas.state());
        let (mut begin, mut rising) = (0.0, own.row.dot(&mode.rates(&z)) > 0.0);
        while begin < span {
            let mut rate = [0.0; LOCAL];
            for (column, x) in own.rate.iter().zip(z.iter()) {
                rate.iter_mut().zip(column).for_each(|(sum, c)| *sum += c * x);
            }
            let end = ((span - begin) / step).min(1.0);
            turns(&rate, (0.0, end), &mut rising, |u, _| {
                let after = begin + u * step;
                let there = mode.after(&z, u * step);
                let candidate = own.candidate(from + after, &there);
                if !self.may_be(&candidate) {
                    return;
                }
                let mut varied = deltas.clone();
                carry(&mut varied, after);
                self.at(machine, mode, (from + after, &varied, lost));
            });
            z = mode.after(&z, step);
            begin += step;
        }
    }

    /// [`fly`](Self::fly) under curved forces, along their series.
    fn fly_curved(
        &mut self,
        (machine, mode, own): (&Machine, &Arc<VariedMode>, &InMode),
        (from, deltas, lost): Moment,
        span: f64,
    ) {
        let mut rising = own.row.dot(&mode.rates(&deltas.state())) > 0.0;
        let mut there = deltas.clone();
        mode.along_curves(&mut deltas.clone(), span, &mut |series, begin| {
            let slope = series.slope(own.row.as_slice(), deltas.width);
            turns(&slope, (0.0, series.part), &mut rising, |u, _| {
                let time = from + begin + series.at(u, &mut there);
                if self.may_be(&own.candidate(time, &there.state())) {
                    self.at(machine, mode, (time, &there, lost));
                }
            });
        });
    }

    /// Considers the values before and after an event.
    pub(super) fn cross(
        &mut self,
        machine: &Machine,
        passed: &Passed,
        [before, after]: [&Columns; 2],
        (later, lost): (&[Option<Later>], &[Option<Lost>]),
    ) {
        for (k, deltas) in [before, after].into_iter().enumerate() {
            let machine = passed.next.as_deref().filter(|_| k == 1).unwrap_or(machine);
            let own = self.in_mode(machine, &passed.modes[k]);
            let (quantity, z, rate) = (self.quantity, &passed.states[k], own.row.dot(&passed.rates[k]));
            let by = |p: usize| match (&later[p], &lost[p]) {
                (Some(_), None) if passed.modes[k].is_shared(&machine.system, quantity) => {
                    Err(shared(machine, quantity, passed.time))
                }
                (Some(later), None) => {
                    let time = later.only().ok_or_else(|| Lost {
                        time: passed.time,
                        element: name_of(machine, quantity),
                        cause: Cause::Together,
                    })?;
                    Ok(own.derivative(machine, (p, quantity), (z, deltas), rate * time))
                }
                (_, found) => Err(found.clone().unwrap_or_else(|| Lost::unknown(passed.time))),
            };
            let candidate = own.candidate(passed.time, z);
            self.consider(&|| name_of(machine, quantity), &candidate, &|| (0..lost.len()).map(by).collect());
        }
    }
}

/// A time, the state then with its derivatives, and for each lost column the reason.
pub(super) type Moment<'a> = (f64, &'a Columns, &'a [Option<Lost>]);

impl Extreme {
    /// Compares the derivatives with the derivatives at another time with the same value.
    fn meet(
        &mut self,
        time: f64,
        others: impl Iterator<Item = Result<f64, Lost>>,
        (sizes, name): (&[f64], &dyn Fn() -> String),
    ) {
        for ((own, size), other) in self.by.iter_mut().zip(sizes).zip(others) {
            let Ok(by) = own else { continue };
            match other {
                Ok(other) if (*by - other).abs() <= STILL * size => {}
                Ok(_) => *own = Err(Lost { time, element: name(), cause: Cause::Equal }),
                Err(found) => *own = Err(found),
            }
        }
    }
}

impl InMode {
    /// Returns the quantity's derivative by column `p` at a state, plus `by_time`, and its size.
    fn derivative(
        &self,
        machine: &Machine,
        (p, quantity): (usize, Quantity),
        (z, deltas): (&StateRow, &Columns),
        by_time: f64,
    ) -> (f64, f64) {
        let delta = &deltas.column(p);
        let (system, tangent, mode) = (&*machine.system, &machine.tangents[p], &*self.mode);
        let value = Point { system, tangent, mode, p, z, delta, scale: delta }.quantity(quantity);
        let terms: f64 = self.row.iter().zip(delta.iter()).map(|(a, b)| (a * b).abs()).sum();
        // No value is -0.
        (value + by_time + 0.0, terms + value.abs() + by_time.abs())
    }

    fn candidate(&self, time: f64, z: &StateRow) -> Candidate {
        let size = self.row.iter().zip(z.iter()).map(|(a, b)| (a * b).abs()).sum();
        Candidate { time, value: self.row.dot(z), size }
    }
}

/// Returns the reason why a force that the law does not determine has no derivative.
pub(super) fn shared(machine: &Machine, quantity: Quantity, time: f64) -> Lost {
    Lost { time, element: name_of(machine, quantity), cause: Cause::Shared }
}

fn name_of(machine: &Machine, quantity: Quantity) -> String {
    let all = machine.assembly.description.named_quantities();
    all.into_iter().find(|own| own.quantity == quantity).map_or_else(String::new, |own| own.name)
}
