//! What can go wrong with a machine and its motion; every message names the quantity, its value and
//! what is allowed.

/// An error of a machine or its motion.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A link adds nothing to the others.
    #[error(
        "link.{link}: it follows from the other links, or moves no free body; allowed are links of which each takes one coordinate away"
    )]
    Redundant {
        /// Name of the link.
        link: String,
    },
    /// The inertia's numbers are too far apart.
    #[error(
        "the inertias: not positive in double precision after the links; allowed are ratios up to about 1e15"
    )]
    Inertia,
    /// Rates that are no numbers, or soon would make none.
    #[error("{name} = {value:e}: allowed are rates, with the inertias that move, of at most 1e100 rad/s")]
    TooFast {
        /// What makes them.
        name: String,
        /// Its value in SI.
        value: f64,
    },
    /// Stops close and nothing can give way.
    #[error(
        "jammed at t = {time} s: {stops} cannot give way; allowed are motions in which a body between them can"
    )]
    Jammed {
        /// s.
        time: f64,
        /// The stops, as `stop.NAME`, with commas.
        stops: String,
    },
    /// A rigid stop is violated by a jump of a prescribed motion or an input.
    #[error(
        "{stop} at t = {time} s: e - gap = {excess} after a jump of a prescribed motion or a change of numbers; allowed is at most 0"
    )]
    Violated {
        /// The stop, as `stop.NAME`.
        stop: String,
        /// s.
        time: f64,
        /// e - gap.
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
        /// What happens, with the elements.
        cause: String,
    },
    /// A call that would take more sub-steps than it may; a further one goes on from the time
    /// reached.
    #[error("the motion cannot go on at t = {time} s: {cause}")]
    TooStiff {
        /// s.
        time: f64,
        /// What takes long, with the body.
        cause: String,
    },
    /// Coordinates or rates whose energies would be beyond what a double holds.
    #[error(
        "the motion cannot go on at t = {time} s: {name} = {value:e} (SI); allowed are sizes up to 1e100, whose energies are numbers"
    )]
    Beyond {
        /// s.
        time: f64,
        /// The body, and whether it is its place or its rate.
        name: String,
        /// m, rad, m/s or rad/s.
        value: f64,
    },
    /// Somebody asked for the end of the call; a further one goes on from the time reached.
    #[error("interrupted at t = {time} s")]
    Interrupted {
        /// s.
        time: f64,
    },
    /// An end before the present or not a number.
    #[error("step to t = {end} s from t = {time} s: allowed is a finite end not before the present")]
    Step {
        /// s.
        time: f64,
        /// s.
        end: f64,
    },
    /// A number that is none.
    #[error("{name} = {value}: allowed is {allowed}")]
    OutOfRange {
        /// What it is.
        name: String,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: String,
    },
}
