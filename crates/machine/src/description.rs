//! The description of a machine as plain data in SI units: bodies, springs, dampers, stops,
//! friction, freewheels, links, loads, signals and blocks.
//!
//! A [`Description`] is read from a file ([`crate::file`]) or built by a program;
//! [`crate::Assembly`] is a checked description. Elements refer to bodies by their index in
//! [`Description::bodies`].

mod block;
mod contact;
mod flexible;
mod matrix;
mod residual;
mod series;
mod starts;

use crate::formula::Formula;
use crate::named::NamedParameters;
pub use block::{Block, BlockInput, Feed, OutputPlace, Sampling, Source};
pub use contact::{Closing, Contact, Tangent};
pub(crate) use flexible::Inner;
pub use flexible::{Modal, Residual};
pub use matrix::{Given, GivenNode, Matrix, MatrixDamping};
pub(crate) use residual::{ResidualForces, ResidualMaker};
pub use series::{Series, SeriesLaw};
pub(crate) use starts::{elongation, start_of, starts};
use std::borrow::Cow;

/// A machine: bodies with one coordinate each, and elements between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Description {
    /// The machine's name.
    pub name: String,
    /// Acceleration of gravity g, m/s²; a body has the acceleration g times its [`Free::gravity`].
    pub gravity: f64,
    /// Whether the machine starts at rest in equilibrium instead of at the bodies' own start
    /// values.
    pub starts_at_rest: bool,
    /// The bodies, in the file's order.
    pub bodies: Vec<Body>,
    /// Springs with dashpots.
    pub springs: Vec<Spring>,
    /// Dashpots without a spring.
    pub dampers: Vec<Damper>,
    /// Bodies in modal coordinates.
    pub modals: Vec<Modal>,
    /// Bodies given by matrices, added by [`add_matrix`](Self::add_matrix).
    pub matrices: Vec<Matrix>,
    /// One-sided contacts, rigid and compliant.
    pub stops: Vec<Stop>,
    /// Coulomb friction.
    pub frictions: Vec<Friction>,
    /// Contacts with a normal stiffness, and friction in one tangent.
    pub contacts: Vec<Contact>,
    /// Freewheels.
    pub freewheels: Vec<Freewheel>,
    /// Rigid links.
    pub links: Vec<Link>,
    /// Forces or torques on bodies.
    pub loads: Vec<Load>,
    /// Signals that blocks read.
    pub sources: Vec<Source>,
    /// Linear blocks.
    pub blocks: Vec<Block>,
    /// Outputs of blocks that loads follow.
    pub feeds: Vec<Feed>,
    /// Named parameters, and the numbers that follow from them.
    pub named: NamedParameters,
}

/// The dimension of a coordinate or an elongation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Along a line: m, m/s, N.
    Translation,
    /// About an axis: rad, rad/s, N m.
    Rotation,
}

/// A body with one coordinate s and a chosen positive direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Its name, unique among the bodies and other than `ground`.
    pub name: String,
    /// Dimension of its coordinate.
    pub dimension: Dimension,
    /// Free or prescribed.
    pub kind: BodyKind,
}

/// How a body's motion is determined.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyKind {
    /// Free: moved by forces, with an inertia.
    Free(Free),
    /// Prescribed: a signal of time plus `rate` times the time.
    Prescribed {
        /// The coordinate without the uniform motion, m or rad.
        motion: Signal,
        /// Rate of the uniform motion that is added, m/s or rad/s.
        rate: f64,
    },
    /// Prescribed: a signal of time is the rate or the acceleration.
    Integrated(Integrated),
    /// Node on a body with many coordinates: s = Σ factor · coordinate, without an inertia of its
    /// own. Each term is the index of the body that has the coordinate, and a nonzero factor.
    Node(Vec<(usize, f64)>),
}

impl BodyKind {
    /// Whether the motion is prescribed, independently of forces.
    pub fn is_prescribed(&self) -> bool {
        matches!(self, Self::Prescribed { .. } | Self::Integrated(_))
    }
}

/// The motion of a body whose rate or acceleration is prescribed.
#[derive(Clone, Debug, PartialEq)]
pub struct Integrated {
    /// Whether the signal is the rate or the acceleration.
    pub level: Level,
    /// Rate or acceleration.
    pub signal: Signal,
    /// Coordinate at time 0, m or rad.
    pub s: f64,
    /// Rate at time 0, m/s or rad/s; 0 if the signal is the rate.
    pub v: f64,
}

/// Time derivative of a coordinate that a signal prescribes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// The rate, m/s or rad/s.
    Rate,
    /// The acceleration, m/s² or rad/s².
    Acceleration,
}

impl Level {
    /// Key in a file.
    pub fn key(self) -> &'static str {
        match self {
            Self::Rate => "rate",
            Self::Acceleration => "acceleration",
        }
    }

    /// Order of the derivative.
    pub fn order(self) -> usize {
        match self {
            Self::Rate => 1,
            Self::Acceleration => 2,
        }
    }
}

/// Inertia and start of a free body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// Mass in kg, or moment of inertia in kg m²; positive.
    pub inertia: f64,
    /// Cosine of the angle between the coordinate's direction and gravity: 1 if s points
    /// downwards, -1 if it points upwards.
    pub gravity: f64,
    /// Coordinate at time 0, m or rad.
    pub s: f64,
    /// Its rate at time 0, m/s or rad/s.
    pub v: f64,
}

/// The arms of an elongation e = Σ arm · s over bodies. Each body occurs at most once, and no arm
/// is zero. Between ground and a body the arm is ±1; from body a to body b the arms are -1 for a
/// and +1 for b.
#[derive(Clone, Debug, PartialEq)]
pub struct Arms {
    /// Index of the body and its arm.
    pub terms: Vec<(usize, f64)>,
    /// Dimension of the elongation.
    pub dimension: Dimension,
    /// Whether the arms are levers, which are parameters, or the signs of `between`.
    pub levers: bool,
}

impl Arms {
    /// The elongation from body `a` to body `b`, s_b - s_a; `None` is ground.
    pub fn between(a: Option<usize>, b: Option<usize>, dimension: Dimension) -> Self {
        let terms = a.map(|a| (a, -1.0)).into_iter().chain(b.map(|b| (b, 1.0))).collect();
        Self { terms, dimension, levers: false }
    }
}

/// A spring and a dashpot in parallel. Its force f = preload + stiffness · e + damping · e'
/// resists e: the force on a body is -arm · f. [`curve`](Self::curve) adds higher powers of e. If
/// [`points`](Self::points) are given, straight lines through them replace preload + stiffness ·
/// e. If a dashpot or slider is in [`series`](Self::series), f = stiffness · (e - x) + damping ·
/// e', where x is the inner displacement.
#[derive(Clone, Debug, PartialEq)]
pub struct Spring {
    /// Its name, unique among the elements.
    pub name: String,
    /// Its elongation e.
    pub arms: Arms,
    /// Stiffness, N/m or N m/rad; not negative.
    pub stiffness: f64,
    /// Piecewise constant stiffness over time, given by a constant and steps or by a held record;
    /// `stiffness` is then 0.
    pub stepped: Option<Signal>,
    /// Damping, N s/m or N m s/rad; not negative.
    pub damping: f64,
    /// Force at e = 0, N or N m; 0 with `series`.
    pub preload: f64,
    /// Coefficients of e², e³, e⁴ and e⁵ in the force, N/m² to N/m⁵ or N m/rad² to N m/rad⁵;
    /// `None` for a power that the force does not have. If any of them is given, the stiffness may
    /// be negative.
    pub curve: Curve,
    /// A formula of e and e' that is added to the force.
    pub force: Option<Formula>,
    /// Distance and free length of a spring that lies across the motion.
    pub across: Option<Across>,
    /// A power of e with the sign of e; `None` if the force has none.
    pub power: Option<OddPower>,
    /// Points (e, f) of a piecewise linear force without the dashpot's part: none, or at least
    /// two, with increasing e. The end lines extend beyond the points. Stiffness and preload are 0
    /// if there are points.
    pub points: Vec<ForcePoint>,
    /// Dashpot or slider in series; `None` for an ordinary spring.
    pub series: Option<Series>,
}

impl Spring {
    /// Whether the force has higher powers of e, or a formula.
    pub fn is_curved(&self) -> bool {
        self.has_polynomial() || self.power.is_some() || self.force.is_some() || self.across.is_some()
    }

    /// Whether the force has a polynomial of e.
    pub fn has_polynomial(&self) -> bool {
        self.curve.iter().any(Option::is_some)
    }

    /// The formula in the force: the given one, or the formula of a spring across the motion.
    pub(crate) fn formula(&self) -> Option<Cow<'_, Formula>> {
        match &self.across {
            Some(across) => Some(Cow::Owned(across.formula(self.stiffness, self.damping))),
            None => self.force.as_ref().map(Cow::Borrowed),
        }
    }

    /// Stiffness and damping along e, including the coefficient of a power whose exponent is 1.
    /// For a spring across the motion both are 0: its [formula](Self::formula) contains them.
    pub(crate) fn along(&self) -> [f64; 2] {
        let stiffness = self.stiffness + OddPower::straight(self.power);
        if self.across.is_some() { [0.0; 2] } else { [stiffness, self.damping] }
    }
}

/// A spring across the motion: its length is L = √(offset² + e²), and the part of its force along
/// e is stiffness (L - free length) e/L + damping (e/L)² e'.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Across {
    /// Length at e = 0, m; positive.
    pub offset: f64,
    /// Length without force, m; not negative.
    pub free_length: f64,
}

/// The force of a spring across the motion, written with the sine e/L of its angle.
const ACROSS: &str = "k * e - k * l * (e / sqrt(a^2 + e^2)) + c * (e / sqrt(a^2 + e^2))^2 * rate";

impl Across {
    /// The force as a formula.
    fn formula(&self, stiffness: f64, damping: f64) -> Formula {
        let values = [("k", stiffness), ("l", self.free_length), ("a", self.offset), ("c", damping)];
        Formula::new(ACROSS, &values).expect("a sound formula")
    }
}

/// A force coefficient · sign(x) · |x|^exponent, where x is an elongation or its rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OddPower {
    /// Coefficient, N/m^exponent or N s^exponent/m^exponent; N m and rad for rotations.
    pub coefficient: f64,
    /// Exponent, at least 1. It is a parameter only if it follows from named parameters.
    pub exponent: f64,
}

impl OddPower {
    /// Whether the exponent is 1, so that the force is straight.
    pub fn is_straight(self) -> bool {
        self.exponent == 1.0
    }

    /// The coefficient of a power with the exponent 1, otherwise 0.
    fn straight(power: Option<Self>) -> f64 {
        power.filter(|own| own.is_straight()).map_or(0.0, |own| own.coefficient)
    }
}

/// Coefficients of the second to the fifth power in a force.
pub type Curve = [Option<f64>; 4];

/// A point of a spring's force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForcePoint {
    /// Elongation, m or rad.
    pub e: f64,
    /// Force, N or N m.
    pub f: f64,
}

/// A dashpot without a spring. Its force f = damping · e' + quadratic · e' |e'| + cubic · e'³
/// resists e'; [`power`](Self::power) adds another power, [`force`](Self::force) a formula. The
/// force does not depend on e, so that a motion may be periodic while e grows.
#[derive(Clone, Debug, PartialEq)]
pub struct Damper {
    /// Its name, unique among the elements.
    pub name: String,
    /// Its elongation e.
    pub arms: Arms,
    /// Damping, N s/m or N m s/rad; positive, or of any sign with higher powers.
    pub damping: f64,
    /// Coefficient of e' |e'| in the force, N s²/m² or N m s²/rad²; `None` without this power.
    pub quadratic: Option<f64>,
    /// Coefficient of e'³ in the force, N s³/m³ or N m s³/rad³; `None` for a linear dashpot.
    pub cubic: Option<f64>,
    /// A power of e' with the sign of e'; `None` if the force has none.
    pub power: Option<OddPower>,
    /// A formula of e' that is added to the force.
    pub force: Option<Formula>,
}

impl Damper {
    /// Whether the force has higher powers of e', or a formula.
    pub fn is_curved(&self) -> bool {
        self.quadratic.is_some() || self.cubic.is_some() || self.power.is_some() || self.force.is_some()
    }

    /// The linear damping, including the coefficient of a power whose exponent is 1.
    pub(crate) fn along(&self) -> f64 {
        self.damping + OddPower::straight(self.power)
    }

    /// The powers of e' with the sign of e'.
    pub fn odd_powers(&self) -> impl Iterator<Item = OddPower> {
        let square = self.quadratic.map(|coefficient| OddPower { coefficient, exponent: 2.0 });
        square.into_iter().chain(self.power)
    }
}

/// A one-sided contact that closes when e reaches the gap and then resists e.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// Its name, unique among the elements.
    pub name: String,
    /// Its elongation e.
    pub arms: Arms,
    /// Value of e at which the stop closes, m or rad, of either sign.
    pub gap: f64,
    /// Rigid or compliant.
    pub law: StopLaw,
    /// Stiffness that steps in time, as for a spring; the stiffness in `law` is then 0.
    pub stepped: Option<Signal>,
    /// Exponent and dissipation of a compliant stop; `None` if the force is straight.
    pub contact: Option<ContactLaw>,
}

/// The curved force of a compliant stop: f = max(0, stiffness xᵖ (1 + 3/2 dissipation x') +
/// damping x') with x = e - gap > 0 and the exponent p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    /// Exponent, at least 1. It is a parameter only if it follows from named parameters.
    pub exponent: f64,
    /// Dissipation of Hunt and Crossley, s/m or s/rad, not negative; `None` if the file does not
    /// give it. The damping is 0 if it is given.
    pub dissipation: Option<f64>,
}

/// The law of a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopLaw {
    /// Unilateral constraint e ≤ gap; an impact reverses e' with a restitution coefficient.
    Rigid {
        /// Restitution coefficient, from 0 to 1: separation speed over closing speed.
        restitution: f64,
    },
    /// A spring and a dashpot act while e is beyond the gap.
    Compliant {
        /// Stiffness, N/m or N m/rad; not negative. It is infinite for a rigid stop on nodes with
        /// residual flexibility.
        stiffness: f64,
        /// Damping, N s/m or N m s/rad; not negative.
        damping: f64,
        /// Limit of the dashpot's force.
        limit: DampingLimit,
    },
}

/// The limit of a compliant stop's dashpot (docs/assembly-law.md (A14)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DampingLimit {
    /// f = max(0, stiffness (e - gap) + damping e'): the force never pulls.
    NoPull,
    /// The dashpot's force is at most the spring's in size, so that f lies between 0 and 2
    /// stiffness (e - gap): the law of the Modelica Standard Library's `ElastoGap`.
    Elastogap,
    /// No limit: f = stiffness (e - gap) + damping e', of either sign. The force jumps when e
    /// reaches the gap and when e leaves it.
    Pull,
    /// The dashpot acts only while e grows: f = stiffness (e - gap) + damping max(0, e').
    UndampedRebound,
}

impl DampingLimit {
    /// All limits, with their words in a file.
    pub const ALL: [(Self, &str); 4] = [
        (Self::NoPull, "no-pull"),
        (Self::Elastogap, "elastogap"),
        (Self::Pull, "pull"),
        (Self::UndampedRebound, "undamped-rebound"),
    ];

    /// Word in a file.
    pub fn word(self) -> &'static str {
        Self::ALL.iter().find(|own| own.0 == self).map_or("", |own| own.1)
    }
}

/// A freewheel: e' <= 0. The force on its ends is never negative and acts only while e' = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Freewheel {
    /// Name, unique among the elements.
    pub name: String,
    /// Its elongation e.
    pub arms: Arms,
}

/// Coulomb friction that resists e'. Its force has the magnitude `force` while it slips, and at
/// most `static_force` (or `force`) while it sticks.
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    /// Its name, unique among the elements.
    pub name: String,
    /// Its elongation e.
    pub arms: Arms,
    /// Sliding level, N or N m; while it is zero or negative, friction does not act.
    pub force: Signal,
    /// Static level, if it differs from `force`; at least `force`.
    pub static_force: Option<Signal>,
    /// Stop whose force the levels follow; `force` is then zero and `static_force` is `None`.
    pub follows: Option<Follows>,
    /// How the level falls from `static_force` to `force` while it slips. Requires `static_force`.
    pub stribeck: Option<Stribeck>,
    /// Viscous damping, N s/m or N m s/rad, whose force is added; `None` if the file does not give
    /// it.
    pub viscous: Option<f64>,
}

/// Stribeck's curve: the level of a friction while it slips is `force` + (`static_force` -
/// `force`) exp(-(|e'|/speed)ᵖ) with the exponent p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stribeck {
    /// Speed, m/s or rad/s; positive.
    pub speed: f64,
    /// Exponent p. It is not a parameter.
    pub exponent: StribeckExponent,
}

/// Exponent of Stribeck's curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StribeckExponent {
    /// 1: exp(-|e'|/v).
    One,
    /// 2: exp(-(e'/v)²).
    #[default]
    Two,
}

/// Friction levels that follow the force N of a compliant stop: coefficient · max(0, N).
#[derive(Clone, Debug, PartialEq)]
pub struct Follows {
    /// Index of the stop.
    pub stop: usize,
    /// Coefficient of the sliding level, not negative.
    pub coefficient: f64,
    /// Coefficient of the static level, if it differs from `coefficient`; at least `coefficient`.
    pub static_coefficient: Option<f64>,
}

/// A rigid link: e = 0 at all times, which determines one coordinate from the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Its name, unique among the elements.
    pub name: String,
    /// The elongation that is kept at zero.
    pub arms: Arms,
}

/// A force or torque on a body in the direction of the body's coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Its name, unique among the elements.
    pub name: String,
    /// Index of the body.
    pub body: usize,
    /// Force, N or N m; 0 for a load that follows an output of a block ([`Feed`]).
    pub force: Signal,
}

/// A function of time, the sum of its parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signal {
    /// A constant.
    pub constant: f64,
    /// Harmonics.
    pub harmonics: Vec<Harmonic>,
    /// Sine sweeps.
    pub sweeps: Vec<Sweep>,
    /// Jumps at increasing times.
    pub steps: Vec<Step>,
    /// A tabulated function.
    pub table: Option<Record>,
    /// Period of steps and table, s.
    pub repeat: Option<f64>,
    /// Whether an input is added; it is 0 until it is set.
    pub input: bool,
}

impl Signal {
    /// A constant signal.
    pub fn constant(value: f64) -> Self {
        Self { constant: value, ..Self::default() }
    }

    /// Whether the signal has no part except the constant.
    pub fn is_constant(&self) -> bool {
        let waves = self.harmonics.len() + self.sweeps.len();
        waves == 0 && self.steps.is_empty() && self.table.is_none() && !self.input
    }
}

/// amplitude · sin(2π · frequency · t + phase).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic {
    /// Amplitude, in the signal's unit.
    pub amplitude: f64,
    /// Frequency, Hz; positive.
    pub frequency: f64,
    /// Phase, rad.
    pub phase: f64,
}

/// A sine whose frequency changes during the sweep and is constant before and after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// Amplitude, in the signal's unit.
    pub amplitude: f64,
    /// Frequency up to time 0, Hz; not negative.
    pub from: f64,
    /// Frequency after the sweep, Hz; not negative.
    pub to: f64,
    /// Duration, s; positive.
    pub duration: f64,
    /// Phase at time 0, rad.
    pub phase: f64,
    /// Law of the frequency in between.
    pub law: SweepLaw,
}

/// The frequency of a sweep over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SweepLaw {
    /// The frequency changes linearly.
    Linear,
    /// The logarithm of the frequency changes linearly; both frequencies are above 0.
    Logarithmic,
}

impl SweepLaw {
    /// Both laws, with their words in a file.
    pub const ALL: [(Self, &str); 2] = [(Self::Linear, "linear"), (Self::Logarithmic, "logarithmic")];

    /// Word in a file.
    pub fn word(self) -> &'static str {
        Self::ALL.iter().find(|own| own.0 == self).map_or("", |own| own.1)
    }
}

impl Sweep {
    /// Number of cycles of the sine from time 0 to the end of the sweep.
    pub fn turns(&self) -> f64 {
        match self.law {
            SweepLaw::Logarithmic if self.from != self.to => {
                self.duration * (self.to - self.from) / (self.to / self.from).ln()
            }
            _ => 0.5 * self.duration * (self.from + self.to),
        }
    }
}

/// A jump of a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Time, s.
    pub time: f64,
    /// Increase at that time, in the signal's unit.
    pub height: f64,
}

/// A tabulated function of time, constant before its first and after its last knot.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Time (s) and value of each knot: two or more, at increasing times.
    pub knots: Vec<(f64, f64)>,
    /// Factor of the values, in the signal's unit; the values are then dimensionless.
    pub scale: Option<f64>,
    /// Interpolation between knots.
    pub interpolation: Interpolation,
}

impl Record {
    /// A record whose values are in the signal's unit.
    pub fn new(knots: Vec<(f64, f64)>, interpolation: Interpolation) -> Self {
        Self { knots, scale: None, interpolation }
    }

    /// Factor of the values; 1 without a `scale`.
    pub fn factor(&self) -> f64 {
        self.scale.unwrap_or(1.0)
    }
}

/// The values of a record between its knots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// A straight line.
    Straight,
    /// A monotone cubic.
    Cubic,
    /// The value of the previous knot, until the next knot's time.
    Hold,
}

impl Interpolation {
    /// All kinds, with their words in a file.
    pub const ALL: [(Self, &str); 3] =
        [(Self::Straight, "straight"), (Self::Cubic, "cubic"), (Self::Hold, "hold")];

    /// Word in a file.
    pub fn word(self) -> &'static str {
        Self::ALL.iter().find(|own| own.0 == self).map_or("", |own| own.1)
    }
}
