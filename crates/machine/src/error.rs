//! Errors of a machine and its motion. Every message names the quantity, its value and the
//! expected values.

use crate::refusal::Refusal;

/// An error of a machine or its motion.
///
///
/// ```
/// use vibro_machine::{Assembly, Error, Motion, file};
///
/// let text = "name = \"A\"\nbody.a = { mass = 1.0 }\n\
///     load.push = { on = \"a\", constant = 3.0 }\n";
/// let machine = file::parse(text, "a.toml", &file::no_records)?;
/// let mut motion = Motion::new(Assembly::new(machine)?.into())?;
/// motion.advance_to(2.0)?;
/// // A motion cannot go back; an error leaves it at its present time.
/// let error = motion.advance_to(1.0).unwrap_err();
/// assert_eq!(error, Error::Step { time: 2.0, end: 1.0 });
/// assert_eq!(motion.time(), 2.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A link that follows from the other links, or that moves no free body.
    #[error(
        "link.{link}: it follows from the other links, or moves no free body; each link must remove \
         one coordinate"
    )]
    Redundant {
        /// Name of the link.
        link: String,
    },
    /// An inertia matrix that is not positive in double precision.
    #[error(
        "the inertias: not positive in double precision after the links; their ratios must be at \
         most about 1e15"
    )]
    Inertia,
    /// A rate above 1e100 rad/s, whose powers would overflow.
    #[error(
        "{name} = {value:e}: gives a rate above 1e100 rad/s; check its unit and the units of the moving inertias"
    )]
    TooFast {
        /// Dotted name of the parameter.
        name: String,
        /// Its value in SI.
        value: f64,
    },
    /// Prescribed bodies drive stops together, and no body can yield.
    #[error(
        "jammed at t = {time} s: {stops} cannot yield between prescribed motions; put a free body between \
         them, or use a compliant stop (`stiffness`)"
    )]
    Jammed {
        /// Time, s.
        time: f64,
        /// The stops, such as `stop.NAME`, separated by commas.
        stops: String,
    },
    /// A rigid stop violated by a jump of a prescribed motion or an input, by a changed parameter
    /// or by a start.
    #[error(
        "{stop} at t = {time} s: e - gap = {excess}; it must be at most 0 in a rigid stop at a start, after a \
         jump of a prescribed motion and after a change of parameters: increase the gap, remove the jump, or \
         use a compliant stop (`stiffness`)"
    )]
    Violated {
        /// The stop, as `stop.NAME`.
        stop: String,
        /// Time, s.
        time: f64,
        /// e - gap, m or rad.
        excess: f64,
    },
    /// A machine that starts at rest without an equilibrium.
    #[error(
        "start = \"rest\": no equilibrium; body.{body} keeps the acceleration {acceleration:?} {unit} \
         at every position: hold it by a spring, a stop or friction, or give the bodies start values \
         instead of \"rest\""
    )]
    NoEquilibrium {
        /// Name of the body with the largest remaining acceleration.
        body: String,
        /// Acceleration, in `unit`.
        acceleration: f64,
        /// Unit of the acceleration.
        unit: &'static str,
    },
    /// A machine that starts at rest and gives way while its loads grow from zero.
    #[error(
        "start = \"rest\": spring.{spring} has a falling force and gives way {}; give start values instead",
        grown(*factor)
    )]
    GivesWay {
        /// Name of the spring.
        spring: String,
        /// Fraction of the loads, from 0 to 1.
        factor: f64,
    },
    /// Modes that change without end at one instant, or events that accumulate.
    #[error("the motion cannot continue at t = {time} s: {cause}")]
    Stuck {
        /// Time, s.
        time: f64,
        /// The reason, with the elements.
        cause: String,
    },
    /// A call that needs more sub-steps than allowed; another call continues from the time
    /// reached.
    #[error("the motion cannot continue at t = {time} s: {cause}")]
    TooStiff {
        /// Time, s.
        time: f64,
        /// The reason, with the fastest body.
        cause: String,
    },
    /// A coordinate or rate above 1e100, whose energy would overflow.
    #[error(
        "the motion cannot continue at t = {time} s: {name} = {value:e} (SI); its size must be at \
         most 1e100, so that energies are finite"
    )]
    Beyond {
        /// Time, s.
        time: f64,
        /// The body and its quantity.
        name: String,
        /// Its value, m, rad, m/s or rad/s.
        value: f64,
    },
    /// A call that was interrupted; another call continues from the time reached.
    #[error("interrupted at t = {time} s")]
    Interrupted {
        /// Time, s.
        time: f64,
    },
    /// An end of a step that is before the present time or not finite.
    #[error("step to t = {end} s from t = {time} s: the end must be finite and not before the present time")]
    Step {
        /// Present time, s.
        time: f64,
        /// End of the step, s.
        end: f64,
    },
    /// A name or a number that the machine refuses.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// A number outside its range.
    #[error("{name} = {value}: expected {allowed}")]
    OutOfRange {
        /// Name of the number.
        name: String,
        /// Its value.
        value: f64,
        /// The allowed values, in words.
        allowed: String,
    },
}

/// Where a machine gives way, for a fraction of its loads.
fn grown(factor: f64) -> String {
    match factor {
        0.0 => "without any load".into(),
        _ => format!("when the loads have grown from zero to {:.1} % of their full values", 100.0 * factor),
    }
}
