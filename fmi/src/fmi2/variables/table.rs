//! The table itself. Append only: a variable's place is its value reference.

use super::{Access, Causality, Initial, Kind, Variability, Variable};
use crate::fmi2::settings::{Derived, Mode, Motion, Settings};
use crate::fmi2::units::{self, EnumerationType, RealType};
use vibro_impact::parameters::{FIELDS, Groups};
use vibro_impact::simulator::Contact;

/// Number of variables.
pub const COUNT: usize = 72;

const FINITE: &str = "a finite number";

const fn real(declared: RealType) -> Kind {
    Kind::Real { declared, min: None, max: None, nominal: None, derivative_of: None, reinit: false }
}

fn get_field<const I: usize>(settings: &Settings) -> f64 {
    (FIELDS[I].get)(&settings.parameters)
}

const fn bound(value: f64) -> Option<f64> {
    if value.is_finite() { Some(value) } else { None }
}

/// A physical parameter; name, meaning and range are those of [`FIELDS`].
const fn parameter<const I: usize>(variability: Variability, declared: RealType) -> Variable {
    let field = FIELDS[I];
    Variable {
        name: field.name,
        description: field.description,
        causality: Causality::Parameter,
        variability,
        initial: Some(Initial::Exact),
        kind: Kind::Real {
            declared,
            min: bound(field.range.min),
            max: bound(field.range.max),
            nominal: None,
            derivative_of: None,
            reinit: false,
        },
        allowed: field.range.allowed,
        open_min: field.range.open_min,
        access: Access::Setting {
            get: get_field::<I>,
            set: |s, value| (FIELDS[I].set)(&mut s.parameters, value),
        },
    }
}

const fn option(
    name: &'static str,
    description: &'static str,
    kind: Kind,
    allowed: &'static str,
    get: fn(&Settings) -> f64,
    set: fn(&mut Settings, f64),
) -> Variable {
    Variable {
        name,
        description,
        causality: Causality::Parameter,
        variability: Variability::Fixed,
        initial: Some(Initial::Exact),
        kind,
        allowed,
        open_min: false,
        access: Access::Setting { get, set },
    }
}

const fn load<const BODY: usize>(name: &'static str, description: &'static str) -> Variable {
    Variable {
        name,
        description,
        causality: Causality::Input,
        variability: Variability::Continuous,
        initial: None,
        kind: real(units::FORCE),
        allowed: FINITE,
        open_min: false,
        access: Access::Setting {
            get: |s| s.loads.derivatives[BODY][0],
            // A new value without derivatives is held (FMI 2.0, 4.2.1).
            set: |s, value| s.loads.derivatives[BODY] = [value, 0.0, 0.0, 0.0],
        },
    }
}

const fn start(
    name: &'static str,
    description: &'static str,
    kind: Kind,
    get: fn(&Settings) -> f64,
    set: fn(&mut Settings, f64),
    now: fn(&Motion) -> f64,
) -> Variable {
    Variable {
        name,
        description,
        causality: Causality::Output,
        variability: Variability::Continuous,
        initial: Some(Initial::Exact),
        kind,
        allowed: FINITE,
        open_min: false,
        access: Access::Start { get, set, now },
    }
}

/// Displacement of a body; impacts may shift box and block by round-off to keep the gap exact.
const fn position<const BODY: usize>(
    name: &'static str,
    description: &'static str,
    reinit: bool,
) -> Variable {
    let declared = units::POSITION;
    start(
        name,
        description,
        Kind::Real { declared, min: None, max: None, nominal: Some(1.0), derivative_of: None, reinit },
        |s| s.start.x[BODY],
        |s, value| s.start.x[BODY] = value,
        |m| m.state.x[BODY],
    )
}

const fn velocity<const BODY: usize>(
    name: &'static str,
    of: &'static str,
    description: &'static str,
    reinit: bool,
) -> Variable {
    let declared = units::VELOCITY;
    start(
        name,
        description,
        Kind::Real { declared, min: None, max: None, nominal: Some(1.0), derivative_of: Some(of), reinit },
        |s| s.start.v[BODY],
        |s, value| s.start.v[BODY] = value,
        |m| m.state.v[BODY],
    )
}

const fn output(
    name: &'static str,
    description: &'static str,
    variability: Variability,
    kind: Kind,
    get: fn(&Motion) -> f64,
) -> Variable {
    Variable {
        name,
        description,
        causality: Causality::Output,
        variability,
        initial: Some(Initial::Calculated),
        kind,
        allowed: "",
        open_min: false,
        access: Access::Motion(get),
    }
}

const fn acceleration<const BODY: usize>(
    name: &'static str,
    of: &'static str,
    description: &'static str,
) -> Variable {
    let kind = Kind::Real {
        declared: units::ACCELERATION,
        min: None,
        max: None,
        nominal: None,
        derivative_of: Some(of),
        reinit: false,
    };
    output(name, description, Variability::Continuous, kind, |m| m.acceleration[BODY])
}

const fn derived(
    name: &'static str,
    description: &'static str,
    variability: Variability,
    kind: Kind,
    get: fn(&Derived) -> f64,
) -> Variable {
    Variable {
        name,
        description,
        causality: Causality::CalculatedParameter,
        variability,
        initial: Some(Initial::Calculated),
        kind,
        allowed: "",
        open_min: false,
        access: Access::Derived(get),
    }
}

const fn number(name: &'static str, description: &'static str, get: fn(&Derived) -> f64) -> Variable {
    derived(name, description, Tunable, real(units::NUMBER), get)
}

const fn flag(name: &'static str, description: &'static str, get: fn(&Derived) -> f64) -> Variable {
    derived(name, description, Tunable, Kind::Boolean, get)
}

/// A dimensionless group; NaN when `box.k` = 0, where the dimensionless form is undefined.
fn group(derived: &Derived, get: fn(&Groups) -> f64) -> f64 {
    derived.groups.as_ref().map_or(f64::NAN, get)
}

/// A count as a C int, saturating: 2^31 impacts take years of computing.
fn count(value: u64) -> f64 {
    f64::from(i32::try_from(value).unwrap_or(i32::MAX))
}

const fn enumeration(declared: EnumerationType) -> Kind {
    Kind::Enumeration(declared)
}

use Variability::{Continuous, Discrete, Fixed, Tunable};

/// Every variable of the FMU, in the order of its value reference.
#[rustfmt::skip]
pub static VARIABLES: [Variable; COUNT] = [
    Variable {
        name: "time", description: "Time", causality: Causality::Independent, variability: Continuous, initial: None,
        kind: real(units::TIME), allowed: "", open_min: false, access: Access::Motion(|m| m.time),
    },

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
        enumeration(units::MODE), units::MODE.allowed,
        |s| s.mode.number() as f64, |s, v| if let Some(mode) = Mode::from_number(v as i32) { s.mode = mode }),
    option("startOnOrbit", "Start on the exact two-impact orbit at the drive's initial phase instead of at the start values",
        Kind::Boolean, "0 (false) or 1 (true)", |s| f64::from(s.start_on_orbit), |s, v| s.start_on_orbit = v != 0.0),
    option("stopAtImpact", "End a communication step at its first impact with fmi2Discard; few masters handle it",
        Kind::Boolean, "0 (false) or 1 (true)", |s| f64::from(s.stop_at_impact), |s, v| s.stop_at_impact = v != 0.0),

    // Loads
    load::<0>("box.f", "External force on the box, beside the drive"),
    load::<1>("block.f", "External force on the block"),
    load::<2>("secondary.f", "External force on the secondary oscillator"),

    // Motion
    position::<0>("box.s", "Displacement of the box (x1)", true),
    velocity::<0>("box.v", "box.s", "Velocity of the box", true),
    acceleration::<0>("box.a", "box.v", "Acceleration of the box"),
    position::<1>("block.s", "Displacement of the block (x2)", true),
    velocity::<1>("block.v", "block.s", "Velocity of the block", true),
    acceleration::<1>("block.a", "block.v", "Acceleration of the block"),
    position::<2>("secondary.s", "Displacement of the secondary oscillator (x3)", false),
    velocity::<2>("secondary.v", "secondary.s", "Velocity of the secondary oscillator", false),
    acceleration::<2>("secondary.a", "secondary.v", "Acceleration of the secondary oscillator"),

    // Contact
    output("stop.s", "Displacement of the block relative to the box (w = x2 - x1); contact at -stop.gap and +stop.gap",
        Continuous, real(units::POSITION), |m| m.gap.0),
    output("stop.v", "Velocity of the block relative to the box", Continuous, real(units::VELOCITY), |m| m.gap.1),
    output("stop.force", "Contact force while the block rests against a stop; 0 in flight", Continuous, real(units::FORCE),
        |m| m.contact_force),
    output("stop.state", "Whether the block flies or rests against a stop", Discrete, enumeration(units::CONTACT),
        |m| match m.contact { Contact::Flight => 1.0, Contact::RestUpper => 2.0, Contact::RestLower => 3.0 }),
    output("impacts.upper", "Number of impacts on the upper stop since the start", Discrete, Kind::Integer { min: 0 },
        |m| count(m.impacts.upper)),
    output("impacts.lower", "Number of impacts on the lower stop since the start", Discrete, Kind::Integer { min: 0 },
        |m| count(m.impacts.lower)),
    output("impacts.lastTime", "Time of the last impact; 0 before the first", Discrete, real(units::TIME),
        |m| m.impacts.last_time),
    output("impacts.lastImpulse", "Impulse of the last impact; 0 before the first", Discrete, real(units::IMPULSE),
        |m| m.impacts.last_impulse),
    output("impacts.lastSpeed", "Relative speed of approach at the last impact; 0 before the first", Discrete,
        real(units::VELOCITY), |m| m.impacts.last_speed),
    output("impacts.impulse", "Sum of the impulses of all impacts since the start", Discrete, real(units::IMPULSE),
        |m| m.impacts.total_impulse),
    output("coupling.f", "Force in the coupling spring, k23 (x2 - x3): on the secondary oscillator as is, on the block reversed",
        Continuous, real(units::FORCE), |m| m.coupling_force),

    // Energy
    output("energy.mechanical", "Kinetic and elastic energy", Continuous, real(units::ENERGY), |m| m.energy.mechanical),
    output("energy.input", "Work of drive and loads since the start", Continuous, real(units::ENERGY), |m| m.energy.input),
    output("energy.damped", "Energy dissipated in the dampers since the start", Continuous, real(units::ENERGY),
        |m| m.energy.damped),
    output("energy.impact", "Energy lost at impacts since the start", Discrete, real(units::ENERGY), |m| m.energy.impact),

    // Dimensionless groups
    derived("groups.epsilon", "Mass ratio m2/m1", Fixed, real(units::NUMBER), |d| group(d, |g| g.epsilon)),
    number("groups.kappa", "Restitution coefficient", |d| group(d, |g| g.kappa)),
    number("groups.f10", "Drive amplitude F10/(k1 L epsilon)", |d| group(d, |g| g.f10)),
    number("groups.sigma1", "Detuning of the drive, (omega1/omega10 - 1)/epsilon", |d| group(d, |g| g.sigma1)),
    number("groups.gamma1", "Damping of the box, c1/(m1 omega10 epsilon)", |d| group(d, |g| g.gamma1)),
    number("groups.alpha23", "Weak coupling, beta2/epsilon", |d| group(d, |g| g.alpha23)),
    number("groups.beta2", "Coupling, k23/(m2 omega10^2)", |d| group(d, |g| g.beta2)),
    number("groups.sigma30", "Detuning of the secondary oscillator, (omega30^2/omega10^2 - 1)/epsilon",
        |d| group(d, |g| g.sigma30)),
    number("groups.gamma3", "Damping of the secondary oscillator, c3/(m3 omega10 epsilon)", |d| group(d, |g| g.gamma3)),
    derived("groups.mu13", "Mass ratio m1/m3", Fixed, real(units::NUMBER), |d| group(d, |g| g.mu13)),

    // Steady state
    flag("steady.exists", "A two-impact steady state exists, by multiple scales",
        |d| f64::from(d.steady.exists)),
    flag("steady.geometric", "It keeps the block between the stops", |d| f64::from(d.steady.geometric)),
    flag("steady.fixedPointStable", "The slow flow's fixed point is stable", |d| f64::from(d.steady.fixed_point_stable)),
    flag("steady.motionStable", "The periodic two-impact motion is stable", |d| f64::from(d.steady.motion_stable)),
    flag("steady.stable", "All three tests hold: the steady state is seen in the real system, as far as multiple scales tell", |d| f64::from(d.steady.stable)),
    number("steady.B", "Amplitude of the centre-of-mass coordinate in gaps, by multiple scales; NaN without a steady state", |d| d.steady.b),
    number("steady.C", "Amplitude of the sawtooth in gaps; NaN without a steady state", |d| d.steady.c),
    number("steady.A3", "Amplitude of the secondary oscillator in gaps; NaN without a steady state", |d| d.steady.a3),
    number("steady.rho", "Loss parameter (2/pi)(1 - kappa)/(1 + kappa)", |d| d.steady.rho),
    number("steady.Cmin", "Smallest C of the slow invariant manifold's upper branch", |d| d.steady.c_min),
    number("steady.CSmin", "Smallest C of stable periodic motion", |d| d.steady.cs_min),
    number("steady.CSmax", "Largest C of stable periodic motion", |d| d.steady.cs_max),
    number("steady.CGmax", "Largest geometrically admissible C", |d| d.steady.cg_max),
    derived("steady.phase", "Phase of the drive when the block meets the upper stop; NaN without a steady state", Tunable, real(units::ANGLE),
        |d| d.steady.phase),
    number("steady.A1", "Amplitude of the box in gaps; NaN without a steady state", |d| d.steady.a1),
    number("steady.A2", "Amplitude of the block in gaps; NaN without a steady state", |d| d.steady.a2),
    derived("steady.impulse", "Impulse of each impact on the exact orbit; NaN where there is none", Tunable, real(units::IMPULSE), |d| d.steady.impulse),
    number("steady.spectralRadius", "Spectral radius of the half-cycle map of the exact orbit, stable below 1; NaN where there is none",
        |d| d.steady.spectral_radius),
];
