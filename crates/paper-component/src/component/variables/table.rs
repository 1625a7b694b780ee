//! The table itself, in the order of the descriptions. The number before a row is its value
//! reference: a new row, at any position, takes the next one of `tests/data/value_references.txt`.

use super::columns::DependencyKind::{
    Constant, Dependent, Discrete as AtEvents, Fixed as OfFixed, Tunable as OfTunable,
};
use super::columns::Variability::{Continuous, Discrete};
use super::columns::Variability::{Fixed, Tunable};
use super::columns::{Initially, Kind, Knowns, Variable};
use super::later::*;
use super::rows::*;
use super::sections::Section;
use crate::component::settings::{Derived, SolutionMode};
use crate::component::units;
use vibro_impact::parameters::Groups;
use vibro_impact::simulator::Contact;

/// Knowns of the accelerations of box and block, in flight or as one body in rest. The factors
/// change with the contact.
const PAIR: Knowns = &[
    ("time", Dependent),
    ("box.f", AtEvents),
    ("block.f", AtEvents),
    ("box.s", AtEvents),
    ("box.v", AtEvents),
    ("block.s", AtEvents),
    ("secondary.s", AtEvents),
];

/// Knowns that decide the contact in flight.
const GAP: Knowns = &[("box.s", AtEvents), ("block.s", AtEvents)];

/// Knowns of the accelerations of the three bodies.
const ACCELERATIONS: Knowns = &[
    ("time", Dependent),
    ("box.f", AtEvents),
    ("block.f", AtEvents),
    ("secondary.f", OfFixed),
    ("box.s", AtEvents),
    ("box.v", AtEvents),
    ("block.s", AtEvents),
    ("secondary.s", AtEvents),
    ("secondary.v", OfTunable),
];

/// Knowns of the acceleration of the secondary oscillator.
const SECONDARY: Knowns = &[
    ("secondary.f", OfFixed),
    ("block.s", OfTunable),
    ("secondary.s", OfTunable),
    ("secondary.v", OfTunable),
];

/// Parameters of the box's acceleration: in rest the parameters of both bodies, in multiple scales
/// the parameters of the amplitude.
const BOX: [&str; 11] = join(&[&OF_PAIR, &OF_COUPLING, &OF_STOPS, &OF_DRIVE, &["mode"]]);

/// Parameters of the block's acceleration: in rest the parameters of both bodies. In multiple
/// scales this acceleration is zero.
const BLOCK: [&str; 9] = join(&[&OF_PAIR, &OF_COUPLING, &OF_DRIVE, &["mode"]]);

/// The parameters in the contact force.
const PRESSING: [&str; 8] = join(&[&OF_PAIR, &OF_COUPLING, &OF_DRIVE]);

/// Parameters of the pressing acceleration: the parameters of the contact force, and the gap as
/// the unit of length.
const PRESSED: [&str; 9] = join(&[&OF_PAIR, &OF_COUPLING, &["stop.gap"], &OF_DRIVE]);

/// The parameters in the accelerations of all three bodies.
const BODIES: [&str; 14] = join(&[&OF_PAIR, &OF_SECONDARY, &OF_COUPLING, &OF_STOPS, &OF_DRIVE, &["mode"]]);

/// Knowns that decide the contact at an event.
const CONTACT: [&str; 18] = join(&[
    &["time"],
    &OF_PAIR,
    &OF_COUPLING,
    &OF_STOPS,
    &OF_DRIVE,
    &["box.f", "block.f", "box.s", "box.v", "block.s", "block.v", "secondary.s"],
]);

/// The parameters of an impact.
const OF_IMPACT: &[&str] = &["box.m", "block.m", "stop.restitution"];

/// Parameters of the dampers' work since the last accepted step of a host's solver, and thus of
/// the work of the inputs.
const DAMPED: [&str; 11] = join(&[&OF_PAIR, &OF_SECONDARY, &OF_COUPLING, &OF_DRIVE]);

/// At the start accelerations and contact force also depend on the block's velocity: it decides
/// whether the block rests at a stop or leaves it.
const MOTION_AT_START: Initially = Initially::OnStartAnd(&["block.v"]);

/// If the block is at a stop with zero relative velocity and zero pressing force, the first
/// derivative of the pressing force that is not zero decides the contact. The higher derivatives
/// depend on all states and loads.
const CONTACT_AT_START: Initially = Initially::OnStartAnd(&[
    "box.f",
    "block.f",
    "secondary.f",
    "box.s",
    "box.v",
    "block.s",
    "block.v",
    "secondary.s",
    "secondary.v",
]);

/// A group's value.
fn value(derived: &Derived, get: fn(&Groups) -> f64) -> f64 {
    get(&derived.groups)
}

/// A count as a C int, saturating; 2^31 impacts would take years to compute.
fn count(value: u64) -> f64 {
    f64::from(i32::try_from(value).unwrap_or(i32::MAX))
}

/// Every variable with its value reference, in the order of the descriptions.
#[rustfmt::skip]
const TABLE: &[(u32, Variable)] = &[
    (0, TIME),

    // Physical parameters
    (1, parameter::<0>(Fixed, units::MASS)),
    (2, parameter::<1>(Tunable, units::STIFFNESS)),
    (3, parameter::<2>(Tunable, units::DAMPING)),
    (4, parameter::<3>(Fixed, units::MASS)),
    (5, parameter::<4>(Fixed, units::MASS)),
    (6, parameter::<5>(Tunable, units::STIFFNESS)),
    (7, parameter::<6>(Tunable, units::DAMPING)),
    (8, parameter::<7>(Tunable, units::STIFFNESS)),
    (9, parameter::<8>(Fixed, units::POSITION)),
    (10, parameter::<9>(Tunable, units::NUMBER)),
    (11, parameter::<10>(Tunable, units::FORCE)),
    (12, parameter::<11>(Tunable, units::ANGULAR_FREQUENCY)),
    (13, parameter::<12>(Tunable, units::ANGLE)),

    // How the motion is obtained
    (14, option("mode", "How the motion is obtained: simulation or one of two closed forms of the steady state",
        Kind::Enumeration(units::MODE),
        |s| s.mode.number() as f64, |s, v| if let Some(mode) = SolutionMode::from_number(v as i32) { s.mode = mode })),
    (15, option("startOnOrbit", "Start on the exact two-impact orbit at the drive's initial phase instead of at the start values",
        Kind::Boolean, |s| f64::from(s.start_on_orbit), |s, v| s.start_on_orbit = v != 0.0)),
    (16, option("stopAtImpact", "End a communication step early, at its first impact. It starts true where an importer says beforehand whether it takes such steps, and \
        false where it cannot: there few handle one",
        Kind::Boolean, |s| f64::from(s.stop_at_impact), |s, v| s.stop_at_impact = v != 0.0)),

    // Loads
    (17, load::<0>("box.f", "External force on the box, beside the drive")),
    (18, load::<1>("block.f", "External force on the block")),
    (19, load::<2>("secondary.f", "External force on the secondary oscillator")),

    // Motion
    (20, position::<0>("box.s", "Displacement of the box (x1)", true, &[("box.s", Constant)])),
    (21, velocity::<0>("box.v", "box.s", "Velocity of the box", true, &[("box.v", Constant)])),
    (22, by(&BOX, at_start(MOTION_AT_START, acceleration::<0>("box.a", "box.v", "Acceleration of the box", PAIR)))),
    (23, position::<1>("block.s", "Displacement of the block (x2)", true, &[("block.s", Constant)])),
    (24, velocity::<1>("block.v", "block.s", "Velocity of the block", true, &[("block.v", Constant)])),
    (25, by(&BLOCK, at_start(MOTION_AT_START, acceleration::<1>("block.a", "block.v", "Acceleration of the block", PAIR)))),
    (26, position::<2>("secondary.s", "Displacement of the secondary oscillator (x3)", false, &[("secondary.s", Constant)])),
    (27, velocity::<2>("secondary.v", "secondary.s", "Velocity of the secondary oscillator", false, &[("secondary.v", Constant)])),
    (28, by(&["secondary.m", "secondary.k", "secondary.c", "coupling.k", "drive.frequency", "mode"],
        acceleration::<2>("secondary.a", "secondary.v", "Acceleration of the secondary oscillator", SECONDARY))),

    // Contact
    (29, by(&["stop.gap"], output(Section::Contact, "stop.s", "Displacement of the block relative to the box (w = x2 - x1); contact at -stop.gap and +stop.gap",
        real(units::POSITION), reading!(|m| m.relative.0), GAP))),
    (30, output(Section::Contact, "stop.v", "Velocity of the block relative to the box", real(units::VELOCITY), reading!(|m| m.relative.1),
        &[("box.v", AtEvents), ("block.v", AtEvents)])),
    (31, by(&PRESSING, at_start(MOTION_AT_START, output(Section::Contact, "stop.force", "Magnitude of the contact force while the block rests against a stop, never negative: it presses \
        the block away from the stop and the box towards it. Forces on the bodies and powers need the sign of the stop, which stop.state tells: the force on the box is \
        +stop.force at the upper stop and -stop.force at the lower one; exactly 0 in flight",
        real(units::FORCE), reading!(|m| m.contact_force), PAIR)))),
    (32, by(&CONTACT, at_start(CONTACT_AT_START, event_output(Section::Contact, "stop.state", "Whether the block flies or rests against a stop", Kind::Enumeration(units::CONTACT),
        |m| match m.contact { Contact::Flight => 1.0, Contact::RestUpper => 2.0, Contact::RestLower => 3.0 })))),
    (33, event_output(Section::Contact, "impacts.upper", "Number of impacts on the upper stop since the start", Kind::Integer { min: 0 },
        |m| count(m.impacts.upper))),
    (34, event_output(Section::Contact, "impacts.lower", "Number of impacts on the lower stop since the start", Kind::Integer { min: 0 },
        |m| count(m.impacts.lower))),
    (35, event_output(Section::Contact, "impacts.lastTime", "Time of the last impact; 0 before the first", real(units::TIME),
        |m| m.impacts.last_time)),
    (36, by(OF_IMPACT, event_output(Section::Contact, "impacts.lastImpulse", "Impulse of the last impact; 0 before the first", real(units::IMPULSE),
        |m| m.impacts.last_impulse))),
    (37, event_output(Section::Contact, "impacts.lastSpeed", "Relative speed of approach at the last impact; 0 before the first",
        real(units::VELOCITY), |m| m.impacts.last_speed)),
    (38, by(OF_IMPACT, event_output(Section::Contact, "impacts.impulse", "Sum of the impulses of all impacts since the start", real(units::IMPULSE),
        |m| m.impacts.total_impulse))),
    (90, by(OF_IMPACT, event_output(Section::Contact, "box.impulse", "Impulse of the stops on the box since the start, with sign: what changes the velocity of the box at impacts and \
        at the end of a chatter run. It is not in box.a, which has the contact force in rest; the difference of two readings is the impulse between them",
        real(units::IMPULSE), |m| m.impacts.box_impulse))),
    (91, by(OF_IMPACT, event_output(Section::Contact, "block.impulse", "Impulse of the stops on the block since the start, with sign: the opposite of box.impulse",
        real(units::IMPULSE), |m| 0.0 - m.impacts.box_impulse))),
    (39, by(&["coupling.k"], output(Section::Contact, "coupling.f", "Force in the coupling spring, k23 (x2 - x3): on the secondary oscillator as is, on the block reversed",
        real(units::FORCE), reading!(|m| m.coupling_force), &[("block.s", OfTunable), ("secondary.s", OfTunable)]))),

    // Energy
    (40, by(&["box.m", "box.k", "block.m", "secondary.m", "secondary.k", "coupling.k"],
        output(Section::Energy, "energy.mechanical", "Kinetic and elastic energy", real(units::ENERGY), reading!(|m| m.mechanical), STATES))),
    (41, by(&DAMPED, at_start(Initially::On(&[]),
        output(Section::Energy, "energy.input", "Work of drive and loads since the start; in Model Exchange what the balance of the energies leaves, the errors of the solver included", real(units::ENERGY), reading!(|m| m.input), ALL)))),
    (42, by(&DAMPED, at_start(Initially::On(&[]),
        output(Section::Energy, "energy.damped", "Energy dissipated in the dampers since the start", real(units::ENERGY), reading!(|m| m.damped), ALL)))),
    (43, by(OF_IMPACT, event_output(Section::Energy, "energy.impact", "Energy lost at impacts since the start", real(units::ENERGY), |m| m.impact_loss))),

    // Dimensionless groups
    (44, fixed_group("groups.epsilon", "Mass ratio m2/m1", |d| value(d, |g| g.epsilon),
        of!("box.m", "block.m"))),
    (46, group("groups.f10", "Drive amplitude F10/(k1 L epsilon); 0 without box.k", |d| value(d, |g| g.f10),
        of!("box.m", "box.k", "block.m", "stop.gap", "drive.amplitude"))),
    (47, group("groups.sigma1", "Detuning of the drive, (omega1/omega10 - 1)/epsilon; 0 without box.k", |d| value(d, |g| g.sigma1),
        of!("box.m", "box.k", "block.m", "drive.frequency"))),

    // Steady state
    (54, flag("steady.exists", "A two-impact steady state exists, by multiple scales; without one its numbers are 0",
        |d| f64::from(d.steady.exists))),
    (58, flag("steady.stable", "It is seen in the real system, as far as multiple scales tell: the block stays between the stops, and motion and slow flow are stable", |d| f64::from(d.steady.stable))),
    (61, steady("steady.A3", "Amplitude of the secondary oscillator in gaps; 0 without a steady state", units::NUMBER,
        |d| d.steady.a3)),
    (67, steady("steady.phase", "Phase of the drive when the block meets the upper stop; 0 without a steady state", units::ANGLE,
        |d| d.steady.phase)),
    (68, steady("steady.A1", "Amplitude of the box in gaps; 0 without a steady state", units::NUMBER,
        |d| d.steady.a1)),
    (69, steady("steady.A2", "Amplitude of the block in gaps; 0 without a steady state", units::NUMBER,
        |d| d.steady.a2)),
    (70, steady("steady.impulse", "Impulse of each impact on the exact orbit; 0 where there is none", units::IMPULSE,
        |d| d.steady.impulse)),
    (71, steady("steady.spectralRadius", "Spectral radius of the half-cycle map of the exact orbit, stable below 1; 0 where there is none, and steady.impulse with it", units::NUMBER,
        |d| d.steady.spectral_radius)),

    // The event to come
    (72, prediction("impacts.nextTime", "Time of the next impact, rest or release after the present, with the inputs and parameters as they are, in \
        Co-Simulation; where none comes within two drive periods (or 1e4 of the fastest time constant, if that is shorter), the \
        end of that span. Model Exchange predicts nothing",
        real(units::TIME), Continuous, |p| p.time)),
    (73, prediction("impacts.nextKnown", "Whether impacts.nextTime is the time of an event", Kind::Boolean, Discrete, |p| f64::from(p.known))),

    // Elements of the model's structure that need a variable of their own in some descriptions
    (74, rate::<0>("der(box.s)", "box.s", "Derivative of box.s, which is box.v", &[("box.v", Constant)])),
    (75, rate::<1>("der(block.s)", "block.s", "Derivative of block.s, which is block.v", &[("block.v", Constant)])),
    (76, rate::<2>("der(secondary.s)", "secondary.s", "Derivative of secondary.s, which is secondary.v", &[("secondary.v", Constant)])),
    (77, by(&["stop.gap"], indicator::<0>("stop.indicator.upper", "Distance of the block from the upper stop in gaps; 1 in rest", GAP))),
    (78, by(&["stop.gap"], indicator::<1>("stop.indicator.lower", "Distance of the block from the lower stop in gaps; 1 in rest", GAP))),
    (79, by(&PRESSED, indicator::<2>("stop.indicator.rest", "In rest, the relative acceleration that presses the block on, in units of the largest that \
        springs and drive make at one gap's displacement; 1 in flight", PAIR))),

    // Arrays
    (80, bodies("motion.s", "Displacements of box, block and secondary oscillator", units::POSITION, |m, i| m.x[i],
        &[("box.s", Constant), ("block.s", Constant), ("secondary.s", Constant)])),
    (81, bodies("motion.v", "Velocities of box, block and secondary oscillator", units::VELOCITY, |m, i| m.v[i],
        &[("box.v", Constant), ("block.v", Constant), ("secondary.v", Constant)])),
    (82, by(&BODIES, at_start(MOTION_AT_START, bodies("motion.a", "Accelerations of box, block and secondary oscillator", units::ACCELERATION, |m, i| m.acceleration[i], ACCELERATIONS)))),
    (83, step_matrix("step.transition", "Derivatives of the states at the end of the last step (rows: box.s, block.s, secondary.s, box.v, \
        block.v, secondary.v) with respect to those at its begin (columns, in the same order), through all its events, in SI units", &[6, 6],
        |m, i| m.transition[i / 6][i % 6])),
    (84, step_matrix("step.response", "Derivatives of the states at the end of the last step (rows as in step.transition) with respect to value \
        and derivatives 1 to 3, at its begin, of box.f, block.f and secondary.f (columns: four for each input in turn), through all its \
        events, in SI units", &[6, 12],
        |m, i| m.response[i / 12][i % 12])),

    // Only in descriptions with a clock
    (85, by(&["box.s", "box.v", "block.s", "block.v"], tick("impacts.clock", "Ticks at each impact", Kind::Clock, |t| f64::from(t.active)))),
    (86, by(&["impacts.clock"], tick("impacts.clocked.time", "Time of the impact at the tick", real(units::TIME), |t| t.time))),
    (87, by(&["impacts.clock"], tick("impacts.clocked.impulse", "Impulse of the impact at the tick", real(units::IMPULSE), |t| t.impulse))),
    (88, by(&["impacts.clock"], tick("impacts.clocked.speed", "Relative speed of approach at the tick", real(units::VELOCITY), |t| t.speed))),
    (89, by(&["impacts.clock"], tick("impacts.clocked.side", "Stop of the impact at the tick", Kind::Enumeration(units::SIDE), |t| f64::from(2 + i32::from(t.side.signum()))))),
];

/// Number of variables.
pub const COUNT: usize = TABLE.len();

/// Every variable, in the order of the descriptions.
pub static VARIABLES: [Variable; COUNT] = {
    let mut variables = [TIME; COUNT];
    let mut i = 0;
    while i < COUNT {
        variables[i] = Variable { reference: TABLE[i].0, ..TABLE[i].1 };
        i += 1;
    }
    variables
};
