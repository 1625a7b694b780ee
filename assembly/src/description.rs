//! The description of a machine as plain data in SI units: bodies, springs, dampers, stops,
//! friction, links and loads.
//!
//! A [`Description`] is read from a file ([`crate::file`]) or put together by a program;
//! [`crate::Assembly`] is a checked description. Elements refer to bodies by their index in
//! [`Description::bodies`].

/// A machine: bodies with one coordinate each, and elements between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Description {
    /// The machine's name.
    pub name: String,
    /// Acceleration of gravity g, m/s²; a body's share is g times its [`Free::gravity`].
    pub gravity: f64,
    /// Whether the machine starts at rest in equilibrium instead of at the bodies' own start
    /// values.
    pub starts_at_rest: bool,
    /// The bodies, in the file's order.
    pub bodies: Vec<Body>,
    /// Springs with their dashpots.
    pub springs: Vec<Spring>,
    /// Dashpots alone.
    pub dampers: Vec<Damper>,
    /// One-sided contacts, rigid and compliant.
    pub stops: Vec<Stop>,
    /// Coulomb friction.
    pub frictions: Vec<Friction>,
    /// Rigid links.
    pub links: Vec<Link>,
    /// Forces or torques on bodies.
    pub loads: Vec<Load>,
}

/// How a coordinate or an elongation is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Along a line: m, m/s, N.
    Translation,
    /// About an axis: rad, rad/s, N m.
    Rotation,
}

/// A body with one coordinate s, positive in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Its name, unique among the bodies; `ground` is reserved.
    pub name: String,
    /// Dimension of its coordinate.
    pub dimension: Dimension,
    /// Whether forces move it or its motion is prescribed.
    pub kind: BodyKind,
}

/// Whether a body's motion follows from the forces on it or is given.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyKind {
    /// It has inertia, and forces move it.
    Free(Free),
    /// Its coordinate is the signal `motion`, in m or rad, plus `rate` times the time in s.
    Prescribed {
        /// The coordinate without its linear part.
        motion: Signal,
        /// The rate of the linear part, m/s or rad/s.
        rate: f64,
    },
}

/// A body that forces move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// Mass in kg, or moment of inertia in kg m²; positive.
    pub inertia: f64,
    /// Cosine of the angle between the coordinate's direction and gravity: 1 where s points
    /// downwards, -1 where upwards.
    pub gravity: f64,
    /// Coordinate at time 0, m or rad.
    pub s: f64,
    /// Its rate at time 0, m/s or rad/s.
    pub v: f64,
}

/// The weights of the bodies' coordinates in an elongation e = Σ arm · s; no body occurs twice, no
/// arm is zero. Between ground and a body the arm is ±1; from body a to body b it is -1 for a and
/// +1 for b.
#[derive(Clone, Debug, PartialEq)]
pub struct Arms {
    /// Index of the body and its arm.
    pub terms: Vec<(usize, f64)>,
    /// Dimension of the elongation.
    pub dimension: Dimension,
    /// Whether the arms are levers, which may be varied, instead of the signs that follow from
    /// `between`.
    pub levers: bool,
}

impl Arms {
    /// The elongation from body `a` to body `b`, where `None` is ground: s_b - s_a.
    pub fn between(a: Option<usize>, b: Option<usize>, dimension: Dimension) -> Self {
        let terms = a.map(|a| (a, -1.0)).into_iter().chain(b.map(|b| (b, 1.0))).collect();
        Self { terms, dimension, levers: false }
    }
}

/// A spring and a dashpot in parallel. Its force f = preload + stiffness · e + damping · e' resists
/// e: it acts on a body by -arm · f.
#[derive(Clone, Debug, PartialEq)]
pub struct Spring {
    /// Its name, unique among the springs.
    pub name: String,
    /// Its elongation e.
    pub arms: Arms,
    /// N/m or N m/rad, not negative.
    pub stiffness: f64,
    /// N s/m or N m s/rad, not negative.
    pub damping: f64,
    /// The force at e = 0, N or N m.
    pub preload: f64,
}

/// A dashpot alone. Its force f = damping · e' does not depend on e, so that a motion may be
/// periodic while e grows.
#[derive(Clone, Debug, PartialEq)]
pub struct Damper {
    /// Its name, unique among the elements.
    pub name: String,
    /// Its elongation e.
    pub arms: Arms,
    /// N s/m or N m s/rad, positive.
    pub damping: f64,
}

/// A contact that closes where e reaches the gap and pushes e back.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// Its name, unique among the stops.
    pub name: String,
    /// Its elongation e.
    pub arms: Arms,
    /// The value of e at which it closes, m or rad; of any sign.
    pub gap: f64,
    /// Rigid or compliant.
    pub law: StopLaw,
}

/// The contact law of a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StopLaw {
    /// e stays at most the gap; an impact reverses e' with the restitution coefficient, from 0 to
    /// 1.
    Rigid {
        /// Speed after over speed before a single impact.
        restitution: f64,
    },
    /// While e is beyond the gap a spring and a dashpot push back, and never pull.
    Compliant {
        /// N/m or N m/rad, not negative.
        stiffness: f64,
        /// N s/m or N m s/rad, not negative.
        damping: f64,
        /// Limit of the dashpot's share.
        limit: DampingLimit,
    },
}

/// The limits of a compliant stop's force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DampingLimit {
    /// f = max(0, stiffness (e - gap) + damping e'): it never pulls.
    NoPull,
    /// The dashpot's share is at most the spring's in size, so that f lies between 0 and 2
    /// stiffness (e - gap): the law of the Modelica Standard Library's `ElastoGap`.
    Elastogap,
}

/// Coulomb friction that resists e': `force` in size while slipping, up to `static_force` (or
/// `force`) while sticking.
#[derive(Clone, Debug, PartialEq)]
pub struct Friction {
    /// Its name, unique among the frictions.
    pub name: String,
    /// Its elongation e.
    pub arms: Arms,
    /// The level while slipping, N or N m; no friction acts while it is not positive.
    pub force: Signal,
    /// The level up to which it sticks, at least `force`; `None` where it equals `force`.
    pub static_force: Option<Signal>,
}

/// A rigid link: e = 0 at all times, which eliminates one coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Its name, unique among the links.
    pub name: String,
    /// Its elongation e, which stays 0.
    pub arms: Arms,
}

/// A force or torque on a body in its coordinate's direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Its name, unique among the loads.
    pub name: String,
    /// Index of the body.
    pub body: usize,
    /// N or N m.
    pub force: Signal,
}

/// A function of time: the sum of all its parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signal {
    /// A constant.
    pub constant: f64,
    /// Sines of time.
    pub harmonics: Vec<Harmonic>,
    /// Jumps, at increasing times.
    pub steps: Vec<Step>,
    /// A record.
    pub table: Option<Record>,
    /// Whether an input from outside is added; it is 0 until set.
    pub input: bool,
}

impl Signal {
    /// A constant signal.
    pub fn constant(value: f64) -> Self {
        Self { constant: value, ..Self::default() }
    }

    /// Whether the constant is the only part.
    pub fn is_constant(&self) -> bool {
        self.harmonics.is_empty() && self.steps.is_empty() && self.table.is_none() && !self.input
    }
}

/// amplitude · sin(2π · frequency · t + phase).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic {
    /// In the signal's unit.
    pub amplitude: f64,
    /// Hz, positive.
    pub frequency: f64,
    /// rad.
    pub phase: f64,
}

/// A jump of a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// s.
    pub time: f64,
    /// Added from that time on, in the signal's unit.
    pub height: f64,
}

/// A record: values at increasing times; constant before the first knot and after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Time (s) and value of each knot; two or more, at increasing times.
    pub knots: Vec<(f64, f64)>,
    /// Whether knots are joined by a monotone cubic instead of straight lines.
    pub cubic: bool,
}
