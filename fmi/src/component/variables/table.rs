//! The table itself. Append only: a variable's place is its value reference.

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

/// What box and block feel, in flight or as one body in rest: the factors change with the contact.
const PAIR: Knowns = &[
    ("time", Dependent),
    ("box.f", AtEvents),
    ("block.f", AtEvents),
    ("box.s", AtEvents),
    ("box.v", AtEvents),
    ("block.s", AtEvents),
    ("secondary.s", AtEvents),
];

/// What decides on contact in flight.
const GAP: Knowns = &[("box.s", AtEvents), ("block.s", AtEvents)];

/// What the accelerations of the three bodies depend on.
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

/// What the secondary oscillator feels.
const SECONDARY: Knowns = &[
    ("secondary.f", OfFixed),
    ("block.s", OfTunable),
    ("secondary.s", OfTunable),
    ("secondary.v", OfTunable),
];

/// The parameters in the box's acceleration: in rest those of both bodies, by multiple scales those of its amplitude.
const OF_BOX: &[&str] = &[
    "box.m",
    "box.k",
    "box.c",
    "block.m",
    "coupling.k",
    "stop.gap",
    "stop.restitution",
    "drive.amplitude",
    "drive.frequency",
    "drive.phase",
    "mode",
];

/// The parameters in the block's acceleration: in rest those of both bodies; by multiple scales it is zero.
const OF_BLOCK: &[&str] = &[
    "box.m",
    "box.k",
    "box.c",
    "block.m",
    "coupling.k",
    "drive.amplitude",
    "drive.frequency",
    "drive.phase",
    "mode",
];

/// The parameters in the contact force.
const PRESSING: &[&str] = &[
    "box.m",
    "box.k",
    "box.c",
    "block.m",
    "coupling.k",
    "drive.amplitude",
    "drive.frequency",
    "drive.phase",
];

/// The same with the unit in which the pressing acceleration is told.
const PRESSED: &[&str] = &[
    "box.m",
    "box.k",
    "box.c",
    "block.m",
    "coupling.k",
    "stop.gap",
    "drive.amplitude",
    "drive.frequency",
    "drive.phase",
];

/// The parameters in the accelerations of all three bodies.
const OF_BODIES: &[&str] = &[
    "box.m",
    "box.k",
    "box.c",
    "block.m",
    "secondary.m",
    "secondary.k",
    "secondary.c",
    "coupling.k",
    "stop.gap",
    "stop.restitution",
    "drive.amplitude",
    "drive.frequency",
    "drive.phase",
    "mode",
];

/// What decides on contact at an event.
const OF_CONTACT: &[&str] = &[
    "time",
    "box.m",
    "box.k",
    "box.c",
    "block.m",
    "coupling.k",
    "stop.gap",
    "stop.restitution",
    "drive.amplitude",
    "drive.frequency",
    "drive.phase",
    "box.f",
    "block.f",
    "box.s",
    "box.v",
    "block.s",
    "block.v",
    "secondary.s",
];

/// The parameters of an impact.
const OF_IMPACT: &[&str] = &["box.m", "block.m", "stop.restitution"];

/// The parameters in the dampers' work since the last accepted step of a host's solver; with them, in the work of the inputs.
const DAMPED: &[&str] = &[
    "box.m",
    "box.k",
    "box.c",
    "block.m",
    "secondary.m",
    "secondary.k",
    "secondary.c",
    "coupling.k",
    "drive.amplitude",
    "drive.frequency",
    "drive.phase",
];

/// At the start the block's velocity too decides on accelerations and contact force: with it the block rests, or leaves.
const MOTION_AT_START: Initially = Initially::OnStartAnd(&["block.v"]);

/// Where box and block stand still beside each other at a stop without a pressing force, the first derivative that is not
/// zero decides whether they stay so, and in the higher ones stands everything that moves.
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

/// A count as a C int, saturating: 2^31 impacts take years of computing.
fn count(value: u64) -> f64 {
    f64::from(i32::try_from(value).unwrap_or(i32::MAX))
}

/// Every variable, in the order of its value reference.
#[rustfmt::skip]
const TABLE: &[Variable] = &[
    TIME,

    // Physical parameters
    parameter::<0>(Fixed, units::MASS),
    parameter::<1>(Tunable, units::STIFFNESS),
    parameter::<2>(Tunable, units::DAMPING),
    parameter::<3>(Fixed, units::MASS),
    parameter::<4>(Fixed, units::MASS),
    parameter::<5>(Tunable, units::STIFFNESS),
    parameter::<6>(Tunable, units::DAMPING),
    parameter::<7>(Tunable, units::STIFFNESS),
    parameter::<8>(Fixed, units::POSITION),
    parameter::<9>(Tunable, units::NUMBER),
    parameter::<10>(Tunable, units::FORCE),
    parameter::<11>(Tunable, units::ANGULAR_FREQUENCY),
    parameter::<12>(Tunable, units::ANGLE),

    // How the motion is obtained
    option("mode", "How the motion is obtained: simulation or one of two closed forms of the steady state",
        Kind::Enumeration(units::MODE),
        |s| s.mode.number() as f64, |s, v| if let Some(mode) = SolutionMode::from_number(v as i32) { s.mode = mode }),
    option("startOnOrbit", "Start on the exact two-impact orbit at the drive's initial phase instead of at the start values",
        Kind::Boolean, |s| f64::from(s.start_on_orbit), |s, v| s.start_on_orbit = v != 0.0),
    option("stopAtImpact", "End a communication step early, at its first impact; few importers handle that",
        Kind::Boolean, |s| f64::from(s.stop_at_impact), |s, v| s.stop_at_impact = v != 0.0),

    // Loads
    load::<0>("box.f", "External force on the box, beside the drive"),
    load::<1>("block.f", "External force on the block"),
    load::<2>("secondary.f", "External force on the secondary oscillator"),

    // Motion
    position::<0>("box.s", "Displacement of the box (x1)", true, &[("box.s", Constant)]),
    velocity::<0>("box.v", "box.s", "Velocity of the box", true, &[("box.v", Constant)]),
    by(OF_BOX, at_start(MOTION_AT_START, acceleration::<0>("box.a", "box.v", "Acceleration of the box", PAIR))),
    position::<1>("block.s", "Displacement of the block (x2)", true, &[("block.s", Constant)]),
    velocity::<1>("block.v", "block.s", "Velocity of the block", true, &[("block.v", Constant)]),
    by(OF_BLOCK, at_start(MOTION_AT_START, acceleration::<1>("block.a", "block.v", "Acceleration of the block", PAIR))),
    position::<2>("secondary.s", "Displacement of the secondary oscillator (x3)", false, &[("secondary.s", Constant)]),
    velocity::<2>("secondary.v", "secondary.s", "Velocity of the secondary oscillator", false, &[("secondary.v", Constant)]),
    by(&["secondary.m", "secondary.k", "secondary.c", "coupling.k", "drive.frequency", "mode"],
        acceleration::<2>("secondary.a", "secondary.v", "Acceleration of the secondary oscillator", SECONDARY)),

    // Contact
    by(&["stop.gap"], output(Section::Contact, "stop.s", "Displacement of the block relative to the box (w = x2 - x1); contact at -stop.gap and +stop.gap",
        real(units::POSITION), reading!(|m| m.gap.0), GAP)),
    output(Section::Contact, "stop.v", "Velocity of the block relative to the box", real(units::VELOCITY), reading!(|m| m.gap.1),
        &[("box.v", AtEvents), ("block.v", AtEvents)]),
    by(PRESSING, at_start(MOTION_AT_START, output(Section::Contact, "stop.force", "Magnitude of the contact force while the block rests against a stop, never negative: it presses \
        the block away from the stop and the box towards it (stop.state says which stop); exactly 0 in flight",
        real(units::FORCE), reading!(|m| m.contact_force), PAIR))),
    by(OF_CONTACT, at_start(CONTACT_AT_START, event_output(Section::Contact, "stop.state", "Whether the block flies or rests against a stop", Kind::Enumeration(units::CONTACT),
        |m| match m.contact { Contact::Flight => 1.0, Contact::RestUpper => 2.0, Contact::RestLower => 3.0 }))),
    event_output(Section::Contact, "impacts.upper", "Number of impacts on the upper stop since the start", Kind::Integer { min: 0 },
        |m| count(m.impacts.upper)),
    event_output(Section::Contact, "impacts.lower", "Number of impacts on the lower stop since the start", Kind::Integer { min: 0 },
        |m| count(m.impacts.lower)),
    event_output(Section::Contact, "impacts.lastTime", "Time of the last impact; 0 before the first", real(units::TIME),
        |m| m.impacts.last_time),
    by(OF_IMPACT, event_output(Section::Contact, "impacts.lastImpulse", "Impulse of the last impact; 0 before the first", real(units::IMPULSE),
        |m| m.impacts.last_impulse)),
    event_output(Section::Contact, "impacts.lastSpeed", "Relative speed of approach at the last impact; 0 before the first",
        real(units::VELOCITY), |m| m.impacts.last_speed),
    by(OF_IMPACT, event_output(Section::Contact, "impacts.impulse", "Sum of the impulses of all impacts since the start", real(units::IMPULSE),
        |m| m.impacts.total_impulse)),
    by(&["coupling.k"], output(Section::Contact, "coupling.f", "Force in the coupling spring, k23 (x2 - x3): on the secondary oscillator as is, on the block reversed",
        real(units::FORCE), reading!(|m| m.coupling_force), &[("block.s", OfTunable), ("secondary.s", OfTunable)])),

    // Energy
    by(&["box.m", "box.k", "block.m", "secondary.m", "secondary.k", "coupling.k"],
        output(Section::Energy, "energy.mechanical", "Kinetic and elastic energy", real(units::ENERGY), reading!(|m| m.mechanical), STATES)),
    by(DAMPED, at_start(Initially::On(&[]),
        output(Section::Energy, "energy.input", "Work of drive and loads since the start", real(units::ENERGY), reading!(|m| m.input), ALL))),
    by(DAMPED, at_start(Initially::On(&[]),
        output(Section::Energy, "energy.damped", "Energy dissipated in the dampers since the start", real(units::ENERGY), reading!(|m| m.damped), ALL))),
    by(OF_IMPACT, event_output(Section::Energy, "energy.impact", "Energy lost at impacts since the start", real(units::ENERGY), |m| m.impact_loss)),

    // Dimensionless groups
    fixed_group("groups.epsilon", "Mass ratio m2/m1", |d| value(d, |g| g.epsilon),
        of!("box.m", "block.m")),
    group("groups.kappa", "Restitution coefficient", |d| value(d, |g| g.kappa),
        &[("stop.restitution", Constant)]),
    group("groups.f10", "Drive amplitude F10/(k1 L epsilon); 0 without box.k", |d| value(d, |g| g.f10),
        of!("box.m", "box.k", "block.m", "stop.gap", "drive.amplitude")),
    group("groups.sigma1", "Detuning of the drive, (omega1/omega10 - 1)/epsilon; 0 without box.k", |d| value(d, |g| g.sigma1),
        of!("box.m", "box.k", "block.m", "drive.frequency")),
    group("groups.gamma1", "Damping of the box, c1/(m1 omega10 epsilon); 0 without box.k", |d| value(d, |g| g.gamma1),
        of!("box.m", "box.k", "box.c", "block.m")),
    group("groups.alpha23", "Weak coupling, beta2/epsilon; 0 without box.k", |d| value(d, |g| g.alpha23),
        of!("box.m", "box.k", "block.m", "coupling.k")),
    group("groups.beta2", "Coupling, k23/(m2 omega10^2); 0 without box.k", |d| value(d, |g| g.beta2),
        of!("box.m", "box.k", "block.m", "coupling.k")),
    group("groups.sigma30", "Detuning of the secondary oscillator, (omega30^2/omega10^2 - 1)/epsilon; 0 without box.k", |d| value(d, |g| g.sigma30),
        of!("box.m", "box.k", "block.m", "secondary.m", "secondary.k")),
    group("groups.gamma3", "Damping of the secondary oscillator, c3/(m3 omega10 epsilon); 0 without box.k", |d| value(d, |g| g.gamma3),
        of!("box.m", "box.k", "block.m", "secondary.m", "secondary.c")),
    fixed_group("groups.mu13", "Mass ratio m1/m3", |d| value(d, |g| g.mu13),
        of!("box.m", "secondary.m")),

    // Steady state
    flag("steady.exists", "A two-impact steady state exists, by multiple scales; without one its numbers are 0",
        |d| f64::from(d.steady.exists)),
    flag("steady.geometric", "It keeps the block between the stops", |d| f64::from(d.steady.geometric)),
    flag("steady.fixedPointStable", "The slow flow's fixed point is stable", |d| f64::from(d.steady.fixed_point_stable)),
    flag("steady.motionStable", "The periodic two-impact motion is stable", |d| f64::from(d.steady.motion_stable)),
    flag("steady.stable", "All three tests hold: the steady state is seen in the real system, as far as multiple scales tell", |d| f64::from(d.steady.stable)),
    steady("steady.B", "Amplitude of the centre-of-mass coordinate in gaps, by multiple scales; 0 without a steady state", units::NUMBER,
        |d| d.steady.b),
    steady("steady.C", "Amplitude of the sawtooth in gaps; 0 without a steady state", units::NUMBER,
        |d| d.steady.c),
    steady("steady.A3", "Amplitude of the secondary oscillator in gaps; 0 without a steady state", units::NUMBER,
        |d| d.steady.a3),
    manifold("steady.rho", "Loss parameter (2/pi)(1 - kappa)/(1 + kappa)",
        |d| d.steady.rho, of!("stop.restitution")),
    manifold("steady.Cmin", "Smallest C of the slow invariant manifold's upper branch",
        |d| d.steady.c_min, of!("stop.restitution")),
    manifold("steady.CSmin", "Smallest C of stable periodic motion",
        |d| d.steady.cs_min, of!("stop.restitution")),
    manifold("steady.CSmax", "Largest C of stable periodic motion",
        |d| d.steady.cs_max, &[]),
    manifold("steady.CGmax", "Largest geometrically admissible C",
        |d| d.steady.cg_max, of!("stop.restitution")),
    steady("steady.phase", "Phase of the drive when the block meets the upper stop; 0 without a steady state", units::ANGLE,
        |d| d.steady.phase),
    steady("steady.A1", "Amplitude of the box in gaps; 0 without a steady state", units::NUMBER,
        |d| d.steady.a1),
    steady("steady.A2", "Amplitude of the block in gaps; 0 without a steady state", units::NUMBER,
        |d| d.steady.a2),
    steady("steady.impulse", "Impulse of each impact on the exact orbit; 0 where there is none", units::IMPULSE,
        |d| d.steady.impulse),
    steady("steady.spectralRadius", "Spectral radius of the half-cycle map of the exact orbit, stable below 1; 0 where there is none, and steady.impulse with it", units::NUMBER,
        |d| d.steady.spectral_radius),

    // The event to come
    prediction("impacts.nextTime", "Time of the next impact, rest or release with the inputs and parameters as they are, in \
        Co-Simulation; where none comes within two drive periods (or 1e4 of the fastest time constant, if that is shorter), the \
        end of that span. Model Exchange predicts nothing",
        real(units::TIME), Continuous, |p| p.time),
    prediction("impacts.nextKnown", "Whether impacts.nextTime is the time of an event", Kind::Boolean, Discrete, |p| f64::from(p.known)),

    // Elements of the model's structure that need a variable of their own in some descriptions
    rate::<0>("der(box.s)", "box.s", "Derivative of box.s, which is box.v", &[("box.v", Constant)]),
    rate::<1>("der(block.s)", "block.s", "Derivative of block.s, which is block.v", &[("block.v", Constant)]),
    rate::<2>("der(secondary.s)", "secondary.s", "Derivative of secondary.s, which is secondary.v", &[("secondary.v", Constant)]),
    by(&["stop.gap"], indicator::<0>("stop.indicator.upper", "Distance of the block from the upper stop in gaps; 1 in rest", GAP)),
    by(&["stop.gap"], indicator::<1>("stop.indicator.lower", "Distance of the block from the lower stop in gaps; 1 in rest", GAP)),
    by(PRESSED, indicator::<2>("stop.indicator.rest", "In rest, the relative acceleration that presses the block on, in units of the largest that \
        springs and drive make at one gap's displacement; 1 in flight", PAIR)),

    // Arrays
    bodies("motion.s", "Displacements of box, block and secondary oscillator", units::POSITION, |m, i| m.x[i],
        &[("box.s", Constant), ("block.s", Constant), ("secondary.s", Constant)]),
    bodies("motion.v", "Velocities of box, block and secondary oscillator", units::VELOCITY, |m, i| m.v[i],
        &[("box.v", Constant), ("block.v", Constant), ("secondary.v", Constant)]),
    by(OF_BODIES, at_start(MOTION_AT_START, bodies("motion.a", "Accelerations of box, block and secondary oscillator", units::ACCELERATION, |m, i| m.acceleration[i], ACCELERATIONS))),
    step_matrix("step.transition", "Derivatives of the states at the end of the last step (rows: box.s, block.s, secondary.s, box.v, \
        block.v, secondary.v) with respect to those at its begin (columns, in the same order), through all its events, in SI units", &[6, 6],
        |m, i| m.transition[i / 6][i % 6]),
    step_matrix("step.response", "Derivatives of the states at the end of the last step (rows as in step.transition) with respect to value \
        and derivatives 1 to 3, at its begin, of box.f, block.f and secondary.f (columns: four for each input in turn), through all its \
        events, in SI units", &[6, 12],
        |m, i| m.response[i / 12][i % 12]),

    // Of descriptions with a clock
    by(&["box.s", "box.v", "block.s", "block.v"], tick("impacts.clock", "Ticks at each impact", Kind::Clock, |t| f64::from(t.active))),
    by(&["impacts.clock"], tick("impacts.clocked.time", "Time of the impact at the tick", real(units::TIME), |t| t.time)),
    by(&["impacts.clock"], tick("impacts.clocked.impulse", "Impulse of the impact at the tick", real(units::IMPULSE), |t| t.impulse)),
    by(&["impacts.clock"], tick("impacts.clocked.speed", "Relative speed of approach at the tick", real(units::VELOCITY), |t| t.speed)),
    by(&["impacts.clock"], tick("impacts.clocked.side", "Stop of the impact at the tick", Kind::Enumeration(units::SIDE), |t| f64::from(2 + i32::from(t.side.signum())))),
];

/// Number of variables.
pub const COUNT: usize = TABLE.len();

/// Every variable, in the order of its value reference.
pub static VARIABLES: [Variable; COUNT] = {
    let mut variables = [TIME; COUNT];
    let mut i = 0;
    while i < COUNT {
        variables[i] = TABLE[i];
        i += 1;
    }
    variables
};
