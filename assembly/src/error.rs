//! Errors of a machine and its motion. Every message names the quantity, its value and what is
//! allowed.

/// An error of a machine or its motion.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A link follows from the other links or moves no free body.
    #[error(
        "link.{link}: it follows from the other links, or moves no free body; allowed are links of which each takes one coordinate away"
    )]
    Redundant {
        /// Name of the link.
        link: String,
    },
    /// The ratio of the inertias is too large: the inertia matrix is not positive definite in
    /// double precision.
    #[error(
        "the inertias: not positive in double precision after the links; allowed are ratios up to about 1e15"
    )]
    Inertia,
    /// A rate is not a number or would overflow soon.
    #[error("{name} = {value:e}: allowed are rates, with the inertias that move, of at most 1e100 rad/s")]
    TooFast {
        /// The number that causes it.
        name: String,
        /// Its value in SI.
        value: f64,
    },
    /// Stops close and no body between them can give way.
    #[error(
        "jammed at t = {time} s: {stops} cannot give way; allowed are motions in which a body between them can"
    )]
    Jammed {
        /// s.
        time: f64,
        /// The stops as `stop.NAME`, separated by commas.
        stops: String,
    },
    /// A jump of a prescribed motion, or a change of an input or a parameter, puts a rigid stop
    /// beyond its gap.
    #[error(
        "{stop} at t = {time} s: e - gap = {excess} after a jump of a prescribed motion or a change of numbers; allowed is at most 0"
    )]
    Violated {
        /// The stop, as `stop.NAME`.
        stop: String,
        /// s.
        time: f64,
        /// e - gap, m or rad.
        excess: f64,
    },
    /// A machine that starts at rest has no equilibrium.
    #[error(
        "start = \"rest\": no equilibrium; body.{body} is accelerated with {acceleration:?} (SI) wherever it stands; allowed are \
         machines whose springs, stops and friction can bear weight and loads at time 0"
    )]
    NoEquilibrium {
        /// Name of the body that is accelerated most.
        body: String,
        /// m/s² or rad/s².
        acceleration: f64,
    },
    /// The modes change without end at one instant, or the events of one call have no end.
    #[error("the motion cannot go on at t = {time} s: {cause}")]
    Stuck {
        /// s.
        time: f64,
        /// The events, with their elements.
        cause: String,
    },
    /// A call needs more sub-steps than allowed; the next call goes on from the time reached.
    #[error("the motion cannot go on at t = {time} s: {cause}")]
    TooStiff {
        /// s.
        time: f64,
        /// The reason, with the body.
        cause: String,
    },
    /// A coordinate or rate whose energy would overflow a double.
    #[error(
        "the motion cannot go on at t = {time} s: {name} = {value:e} (SI); allowed are sizes up to 1e100, whose energies are numbers"
    )]
    Beyond {
        /// s.
        time: f64,
        /// The body's coordinate or rate.
        name: String,
        /// m, rad, m/s or rad/s.
        value: f64,
    },
    /// The call was interrupted; the next call goes on from the time reached.
    #[error("interrupted at t = {time} s")]
    Interrupted {
        /// s.
        time: f64,
    },
    /// The end of a step is before the present or not finite.
    #[error("step to t = {end} s from t = {time} s: allowed is a finite end not before the present")]
    Step {
        /// Present, s.
        time: f64,
        /// s.
        end: f64,
    },
    /// A number outside its range.
    #[error("{name} = {value}: allowed is {allowed}")]
    OutOfRange {
        /// Its name.
        name: String,
        /// Its value.
        value: f64,
        /// The range in words.
        allowed: String,
    },
}
