//! Bifurcation diagrams of described machines: local maxima of a quantity, or its values at the
//! section, over one parameter in both directions, with period, class and, on request, the largest
//! exponent.
//!
//! As for the 3-DOF machine, each value starts from the last state of the value before, and the
//! observation at each value is independent of the others. Time continues from value to value, so
//! that a prescribed body is where the others met it. If what drives the machine does not repeat,
//! each motion would depend on when its value is reached: such a machine is refused, unless each
//! value [starts anew](DiagramRequest::anew).

use super::flight::Flows;
use super::settled::{Settled, settled};
use super::timescales::{runs_on_beyond, settle};
use super::watch::{Maxima, Watcher};
use super::{Machine, QuantityName, Section, Start, now};
use crate::attractor::MotionClass;
use crate::bifurcation::{self, Diagram, DiagramPoint, chained, in_both_directions};
use crate::error::{Error, Result};
use crate::parts::{PartStore, Task};
use crate::plane::ParameterAxis;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Digits by which values are distinguished, relative to the largest of the motion.
const DIGITS: i32 = 6;
/// Most values of a diagram.
pub const MOST_VALUES: usize = 20_000;

/// Request of a bifurcation diagram.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DiagramRequest {
    /// The parameter and its values, SI.
    pub axis: ParameterAxis<String>,
    /// The quantity that is drawn.
    pub of: QuantityName,
    /// Whether its values at the section are drawn, and not its local maxima.
    pub at_section: bool,
    /// Returns discarded at each value; fewer where the motion has settled.
    pub discard: u32,
    /// Returns kept.
    pub keep: u32,
    /// Returns over which the largest exponent is counted, if it is.
    pub exponents: Option<u32>,
    /// Whether each value starts from `start`, which leaves one direction.
    pub anew: bool,
    /// Start at the first value of either direction.
    #[serde(default, skip_serializing_if = "Start::is_own")]
    pub start: Start,
}

/// Motion at one value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AssemblyPoint {
    /// The parameter's value.
    pub value: f64,
    /// Maxima, or values at the section, SI, to seven digits of the largest, ascending, each with
    /// its count.
    pub maxima: Vec<(f64, u32)>,
    /// Attractor of the motion.
    pub settled: Settled,
}

impl DiagramPoint for AssemblyPoint {
    fn value(&self) -> f64 {
        self.value
    }

    fn maxima(&self) -> &[(f64, u32)] {
        &self.maxima
    }

    fn class(&self) -> MotionClass {
        self.settled.class
    }

    fn contacts(&self) -> f64 {
        self.settled.contacts
    }

    fn differs(&self, other: &Self) -> Option<bool> {
        self.settled.differs(&other.settled)
    }
}

/// Settled state of the motion at one value; none where the motion cannot go on.
struct SettledStart {
    value: f64,
    start: Option<Start>,
}

impl DiagramRequest {
    /// The machine at a value.
    fn at(&self, machine: &Machine, value: f64) -> Result<Machine> {
        machine.with([(self.axis.name.as_str(), value)])
    }

    /// Checks the properties on which every value depends.
    ///
    /// # Errors
    /// Names that the machine does not have, ends that are not allowed, no section, or no motion
    /// from the start.
    pub fn check(&self, machine: &Machine) -> Result<()> {
        self.of.find(&machine.description)?;
        for end in [self.axis.from, self.axis.to] {
            self.at(machine, end)?;
        }
        if self.axis.count > MOST_VALUES || self.keep == 0 {
            let text = format!("{} values with {} returns kept", self.axis.count, self.keep);
            return Err(Error::Form { text, expected: "up to 20000 values and a return at least" });
        }
        for end in [self.axis.from, self.axis.to] {
            let own = self.at(machine, end)?;
            let section = Section::of(&own.description, &own.section)?;
            match runs_on_beyond(&own.description, &section, self.start.time, self.discard) {
                Some(why) if !self.anew => return Err(Error::Described { problem: runs_on_in_words(&why) }),
                _ => {}
            }
        }
        let others = (!self.anew && !self.start.is_own()).then_some(self.axis.to);
        let mut begun = std::iter::once(self.axis.from).chain(others);
        begun.try_for_each(|value| self.at(machine, value)?.motion(&self.start).map(drop))
    }

    /// Number of parts.
    pub fn count(&self) -> usize {
        bifurcation::parts(self.axis.count)
    }
}

/// Refusal of a chain of values, and its reason.
fn runs_on_in_words(why: &str) -> String {
    format!(
        "{why}: time goes on from value to value, so that each would be seen at another time of it; allowed are changes within what is \
         discarded at the first value (--discard), or --anew (anew=True in Python), with which each value has the same start and nothing is said of \
         hysteresis"
    )
}

fn chain(
    machine: &Machine,
    request: &DiagramRequest,
    store: &dyn PartStore,
    upward: bool,
) -> Result<Vec<SettledStart>> {
    let mut state = None;
    if request.anew {
        let start = |i| SettledStart {
            value: request.axis.value(i),
            start: upward.then(|| settled_at(machine, request, request.axis.value(i), None).ok()).flatten(),
        };
        return Ok((0..request.axis.count).into_par_iter().map(start).collect());
    }
    chained(request.axis.count, upward, store, &mut |i| {
        let value = request.axis.value(i);
        let start = settled_at(machine, request, value, state.as_ref()).ok();
        state = start.clone();
        Ok(SettledStart { value, start })
    })
}

/// State of the motion at a value after it has settled; it begins at the state of the value before
/// or, without one, at the start.
fn settled_at(
    machine: &Machine,
    request: &DiagramRequest,
    value: f64,
    before: Option<&Start>,
) -> Result<Start> {
    let own = request.at(machine, value)?;
    let (motion, section) = match before {
        Some(end) => own.motion_on(end)?,
        None => own.motion(&request.start)?,
    };
    let mut motion = motion.without_energy_accounts();
    settle(&mut motion, &section, request.discard)?;
    Ok(now(&motion))
}

/// The numbers of a state that are free at a value, of which a start's file may consist.
fn own_start(machine: &Machine, request: &DiagramRequest, value: f64, state: &Start) -> Result<Start> {
    let (motion, _) = request.at(machine, value)?.motion_on(state)?;
    Ok(Start::of(&motion))
}

/// Observes the motion at one value.
///
/// # Errors
/// Where the motion cannot go on.
fn observe(machine: &Machine, request: &DiagramRequest, value: f64, end: &Start) -> Result<AssemblyPoint> {
    let (motion, section) = request.at(machine, value)?.motion_on(end)?;
    let mut motion = motion.without_energy_accounts();
    let mut scout = motion.clone();
    let settled = settled(&mut scout, &section, request.exponents)?;
    // A motion with a period is observed over one period after it has settled.
    let (length, times) = match settled.period {
        Some(n) => {
            motion = scout;
            (n, (request.keep / n).max(1))
        }
        None => (request.keep, 1),
    };
    let mut flows = Flows::default();
    let quantity = request.of.find(&motion.assembly().description)?.quantity;
    let stops = motion.mode().stops.len();
    let mut values = Vec::new();
    let mut watcher = Watcher::of(&[], stops);
    if request.at_section {
        for _ in 0..length {
            section.follow(&mut motion, &mut flows, &mut [])?;
            values.push(flows.value(&motion, quantity));
        }
    } else {
        watcher.maxima = Some(Maxima::new(quantity));
        // The first period shows whether the quantity rises where the second begins.
        section.follow(&mut motion, &mut flows, &mut [&mut watcher])?;
        watcher.maxima.iter_mut().for_each(|m| m.found.clear());
        for _ in 0..length {
            section.follow(&mut motion, &mut flows, &mut [&mut watcher])?;
        }
        values = watcher.maxima.map_or(Vec::new(), |m| m.found);
    }
    Ok(AssemblyPoint { value, maxima: counted(values, times), settled })
}

/// Values to some digits of the largest, ascending, each with its count.
fn counted(values: Vec<f64>, times: u32) -> Vec<(f64, u32)> {
    let largest = values.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    if largest == 0.0 {
        return if values.is_empty() { Vec::new() } else { vec![(0.0, times * values.len() as u32)] };
    }
    let unit = 10f64.powi(largest.log10().floor() as i32 - DIGITS);
    let mut whole: Vec<i64> = values.iter().map(|x| (x / unit).round() as i64).collect();
    whole.sort_unstable();
    whole.chunk_by(|a, b| a == b).map(|same| (same[0] as f64 * unit, times * same.len() as u32)).collect()
}

/// One direction of a diagram, value by value, for one who shows each as soon as it is found. A
/// value is its place in the axis, the state that the motion has settled in, and what is found
/// there; both are missing where the motion cannot go on.
#[derive(Debug)]
pub struct Direction {
    machine: Machine,
    request: DiagramRequest,
    upward: bool,
    next: usize,
    before: Option<Start>,
}

impl Direction {
    /// The direction of rising or of falling values.
    ///
    /// # Errors
    /// As [`DiagramRequest::check`].
    pub fn new(machine: Machine, request: DiagramRequest, upward: bool) -> Result<Self> {
        request.check(&machine)?;
        Ok(Self { machine, request, upward, next: 0, before: None })
    }
}

impl Iterator for Direction {
    type Item = (usize, Option<Start>, Option<AssemblyPoint>);

    fn next(&mut self) -> Option<Self::Item> {
        let Self { machine, request, upward, .. } = &*self;
        let count = request.axis.count;
        let i = Some(self.next).filter(|i| *i < count)?;
        let i = if *upward { i } else { count - 1 - i };
        let value = request.axis.value(i);
        let before = self.before.as_ref().filter(|_| !request.anew);
        let start = settled_at(machine, request, value, before).ok();
        let point = start.as_ref().and_then(|start| observe(machine, request, value, start).ok());
        let own = start.as_ref().and_then(|start| own_start(machine, request, value, start).ok());
        (self.next, self.before) = (self.next + 1, start);
        Some((i, own, point))
    }
}

/// The diagram, on all threads, in parts; `None` where parts belong to other shards. The result
/// depends neither on threads nor on shards.
///
/// # Errors
/// As [`DiagramRequest::check`]; what the parts' folder refuses.
pub fn diagram(
    machine: &Machine,
    request: &DiagramRequest,
    task: &Task,
) -> Result<Option<Diagram<AssemblyPoint>>> {
    request.check(machine)?;
    let points = |_: &mut (), starts: &[SettledStart]| {
        let point = |s: &SettledStart| observe(machine, request, s.value, s.start.as_ref()?).ok();
        Ok(starts.iter().map(point).collect())
    };
    in_both_directions(
        request.axis.count,
        task,
        &|upward| chain(machine, request, task.store, upward),
        &points,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::tests::{OSCILLATOR, text};

    #[test]
    fn closed_form_values_are_counted_to_seven_digits_of_the_largest() {
        let near = |found: Vec<(f64, u32)>, expected: &[(f64, u32)]| {
            assert_eq!(found.len(), expected.len(), "{found:?}");
            for (found, expected) in found.iter().zip(expected) {
                assert!(
                    (found.0 - expected.0).abs() < 1e-9 && found.1 == expected.1,
                    "{found:?} {expected:?}"
                );
            }
        };
        near(counted(vec![2.0, 1.0, -3.0, 1.0 + 1e-7, 2.0], 3), &[(-3.0, 3), (1.0, 6), (2.0, 6)]);
        near(counted(vec![2.0, 2.000002], 1), &[(2.0, 1), (2.000002, 1)]);
        near(counted(vec![-20.0, -20.000002], 1), &[(-20.0, 2)]);
        near(counted(vec![0.0, 0.0, -0.0], 2), &[(0.0, 6)]);
        near(counted(Vec::new(), 2), &[]);
    }

    /// A block that flies between impacts: its coordinate has a maximum where its velocity changes
    /// sign, once a period, and none where an impact makes it faster. What the diagram says at
    /// 20,000 periods, where times are rounded to 2e-13 s, is what it says at the first.
    #[test]
    fn invariant_maxima_do_not_depend_on_the_clock() {
        let text = "name = \"Rattle\"\n[body.frame]\nmotion = { amplitude = \"5 mm\", frequency = \"10 Hz\" }\n\
            [body.block]\nmass = 1.0\n[stop.upper]\nbetween = [\"block\", \"frame\"]\ngap = \"2 mm\"\nrestitution = 0.7\n\
            [stop.lower]\nbetween = [\"frame\", \"block\"]\ngap = \"2 mm\"\nrestitution = 0.7\n";
        let machine = Machine::parse(text, "rattle.toml", &vibro_assembly::file::no_records).unwrap();
        let axis = ParameterAxis::of("body.frame.motion.amplitude".to_owned(), (4.9e-3, 5.1e-3), 9).unwrap();
        for time in [0.0, 2000.0] {
            let start = Start { time, ..Start::default() };
            let request = DiagramRequest {
                axis: axis.clone(),
                of: "block.s".parse().unwrap(),
                at_section: false,
                keep: 60,
                start,
                ..request(9)
            };
            for (_, own, point) in Direction::new(machine.clone(), request, true).unwrap() {
                let (own, point) = (own.unwrap(), point.unwrap());
                // The state reads back as a start, without the prescribed frame.
                assert_eq!(Start::parse(&own.to_toml(), "start", &machine.description), Ok(own));
                assert_eq!((point.settled.period, point.maxima.len()), (Some(1), 1), "{time}: {point:?}");
            }
        }
    }

    fn request(count: usize) -> DiagramRequest {
        let axis = ParameterAxis::of("spring.k.damping".to_owned(), (8.0, 9.0), count).unwrap();
        let of = "a.s".parse().unwrap();
        let start = Start::default();
        DiagramRequest {
            axis,
            of,
            at_section: true,
            discard: 400,
            keep: 4,
            exponents: None,
            anew: false,
            start,
        }
    }

    /// An oscillator at whole periods of its drive.
    #[test]
    fn closed_form_values_at_the_section_are_the_steady_motions() {
        let machine = text(OSCILLATOR);
        let found = diagram(&machine, &request(5), &Task::ALL).unwrap().unwrap();
        for point in found.up.iter().chain(&found.down).map(|p| p.as_ref().unwrap()) {
            // (800 - 2 ω² + i c ω) s = 10 with the drive's 10 sin(ω t): -10 c ω/|…|² at its zeros.
            let w = 10.0 * std::f64::consts::PI;
            let (k, c) = (800.0 - 2.0 * w * w, point.value * w);
            let expected = -10.0 * c / (k * k + c * c);
            let [(value, count)] = point.maxima[..] else { panic!("{point:?}") };
            assert!(
                (value - expected).abs() < 1e-6 * expected.abs() && count == 4,
                "{value} {expected} {count}"
            );
        }
        assert_eq!(found.up.len(), 5);
        // Value by value it is the diagram.
        for (upward, points) in [(true, &found.up), (false, &found.down)] {
            for (i, start, point) in Direction::new(machine.clone(), request(5), upward).unwrap() {
                assert!(start.is_some() && point == points[i]);
            }
        }
        // Looked at twice a period, the motion is 2T with half as many times of each.
        let twice = Machine { section: crate::assembly::SectionRule::Period(0.1), ..machine };
        let found = diagram(&twice, &request(2), &Task::ALL).unwrap().unwrap();
        let point = found.up[0].as_ref().unwrap();
        let counts: Vec<u32> = point.maxima.iter().map(|m| m.1).collect();
        assert_eq!((counts, point.settled.period), (vec![2, 2], Some(2)));
    }

    #[test]
    fn what_no_value_could_do_without_is_refused_first() {
        let machine = text(OSCILLATOR);
        request(5).check(&machine).unwrap();
        assert!(DiagramRequest { keep: 0, ..request(5) }.check(&machine).is_err());
        request(MOST_VALUES).check(&machine).unwrap();
        assert!(request(MOST_VALUES + 1).check(&machine).is_err());
        let axis = ParameterAxis::of("spring.k.damping".to_owned(), (-1.0, 8.0), 3).unwrap();
        assert!(DiagramRequest { axis, ..request(3) }.check(&machine).is_err());
    }

    /// Between soft stops resonance bends to higher frequencies: from below the motion stays in
    /// contact where from above it has none.
    #[test]
    fn invariant_each_direction_goes_on_from_the_value_before() {
        let stop = |name: &str, a: &str, b: &str| {
            format!("[stop.{name}]\nbetween = [\"{a}\", \"{b}\"]\ngap = 0.02\nstiffness = 3e3\n")
        };
        let file = OSCILLATOR
            .replace("damping = 8.0", "damping = 1.0")
            .replace("amplitude = 10.0", "amplitude = 2.0");
        let machine = text(&format!("{file}{}{}", stop("r", "ground", "a"), stop("l", "a", "ground")));
        let axis = ParameterAxis::of("load.f.frequency".to_owned(), (3.0, 5.0), 9).unwrap();
        let request = DiagramRequest { axis, at_section: false, ..request(9) };
        let found = diagram(&machine, &request, &Task::ALL).unwrap().unwrap();
        let contacts = |points: &[Option<AssemblyPoint>]| -> Vec<f64> {
            points.iter().map(|point| point.as_ref().unwrap().settled.contacts).collect()
        };
        let (up, down) = (contacts(&found.up), contacts(&found.down));
        let apart = (0..9).filter(|&i| up[i] > 0.0 && down[i] == 0.0).count();
        assert!(apart > 0 && found.hysteresis().iter().any(|h| *h), "{up:?} {down:?}");
        assert!(up[8] == down[8] && up[0] == down[0], "{up:?} {down:?}");
    }
}
