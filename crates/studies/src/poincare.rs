//! Points of a settled motion at its section: after whole periods, at a phase of each period, or
//! at each event of an element.

use super::{Machine, Section, columns, common_period, settle, values};
use crate::error::{Error, Result};
use std::f64::consts::TAU;
use vibro_machine::Start;
use vibro_machine::motion::EventKind;

/// Request of a section.
#[derive(Clone, Debug, PartialEq)]
pub struct PoincareRequest {
    /// Start of the motion.
    pub start: Start,
    /// Phase at a section of whole periods, rad.
    pub phase: f64,
    /// Number of returns discarded; fewer if the motion has settled.
    pub discard: u32,
    /// Number of returns kept.
    pub keep: u32,
}

/// A point of a section.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionPoint {
    /// Time, s.
    pub time: f64,
    /// Phase of the common period of the machine's drive, rad; `None` without a drive.
    pub phase: Option<f64>,
    /// Closing speed of an impact or first touch, m/s or rad/s.
    pub speed: Option<f64>,
    /// The machine's [columns], just after an event.
    pub values: Vec<f64>,
}

/// The section of a request.
///
/// # Errors
/// As [`Section::of`]; [`Error::Described`] for a phase that is not finite, and for a phase at a
/// section of events.
pub fn section_of(machine: &Machine, phase: f64) -> Result<Section> {
    let section = Section::of(&machine.description, &machine.section)?;
    let refused = |allowed: &str| Err(Error::Described { problem: format!("phase {phase}: {allowed}") });
    match section {
        _ if !phase.is_finite() => refused("expected a finite angle"),
        _ if phase == 0.0 => Ok(section),
        Section::Period(period) => Ok(Section::Shifted(period, (phase / TAU).rem_euclid(1.0) * period)),
        _ => refused("cannot be combined with a section of an element's events, only with a period"),
    }
}

/// The points of a settled motion at its section. `go_on` is called at each return, and ends the
/// record by returning false.
///
/// # Errors
/// As [`section_of`]; as [`Machine::motion`] and [`Section::advance`].
///
/// # Examples
/// A force 26 sin ωt with k - mω² = -12 N/m and cω = 5 N/m gives s = 2 sin(ωt - φ), with
/// tan φ = -5/12 in the second quadrant:
///
/// ```
/// use vibro_studies::{Machine, PoincareRequest, Start, poincare};
///
/// # let text = r#"
/// #     name = "Shaken"
/// #     body.a = { mass = 1.0 }
/// #     spring.k = { between = ["ground", "a"], stiffness = 4.0, damping = 1.25 }
/// #     load.f = { on = "a", amplitude = 26.0, frequency = "4 rad/s" }
/// # "#;
/// let machine = Machine::parse(text, "shaken.toml", &vibro_machine::file::no_records)?;
/// let request = PoincareRequest { start: Start::default(), phase: 0.0, discard: 100, keep: 3 };
/// let points = poincare(&machine, &request, &mut || true)?;
/// assert_eq!(points.len(), 3);
/// for point in points {
///     // The motion counts as settled when its returns differ by less than 1e-9.
///     assert!((point.values[0] + 2.0 * 5.0 / 13.0).abs() < 1e-8); // a.s
///     assert!((point.values[1] + 8.0 * 12.0 / 13.0).abs() < 1e-8); // a.v
/// }
/// # Ok::<(), vibro_studies::Error>(())
/// ```
pub fn poincare(
    machine: &Machine,
    request: &PoincareRequest,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<Vec<SectionPoint>> {
    let section = section_of(machine, request.phase)?;
    let (motion, _) = machine.motion(&request.start)?;
    let mut motion = motion.without_energy_accounts();
    settle(&mut motion, &section, request.discard)?;
    let period = common_period(&machine.description);
    let mut found = Vec::new();
    while found.len() < request.keep as usize && go_on() {
        let mut speed = None;
        section.advance(&mut motion, &mut |event| match (event.kind, section) {
            (EventKind::Impact { stop, speed: own, .. }, Section::Stop(i)) if stop == i => speed = Some(own),
            (EventKind::Press { stop, speed: own }, Section::Stop(i)) if stop == i => speed = Some(own),
            _ => {}
        })?;
        let time = motion.time();
        let phase = period.map(|period| TAU * (time / period).fract());
        found.push(SectionPoint { time, phase, speed, values: values(&motion) });
    }
    debug_assert!(found.iter().all(|point| point.values.len() == columns(&machine.description).len()));
    Ok(found)
}
