//! The error type of the crate.

/// Error of this crate; every message names the quantity, its value and the valid values.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A named quantity lies outside its range (also NaN and infinities).
    #[error("{name} = {value}: expected {allowed}")]
    OutOfRange {
        /// Structured name of the variable, e.g. `stop.restitution`.
        name: &'static str,
        /// The refused value.
        value: f64,
        /// The allowed range, in words.
        allowed: &'static str,
    },
    /// The block is outside the box at the start of a motion.
    #[error("block.s - box.s = {value} m: expected -stop.gap <= block.s - box.s <= stop.gap = {gap} m")]
    Penetration {
        /// Relative displacement `w = x2 - x1` in m.
        value: f64,
        /// Half the free path `L` in m.
        gap: f64,
    },
    /// Double precision cannot resolve the requested motion.
    #[error("{what} = {value:e}: must be at most {limit:e}; beyond that, double precision loses the motion")]
    PrecisionLost {
        /// Ratio that is too large, in words.
        what: &'static str,
        /// Value of the ratio.
        value: f64,
        /// Largest allowed value.
        limit: f64,
    },
    /// An advance has reached its limit of work. The state is valid and belongs to `time`. Another
    /// advance continues from there and has a new limit.
    #[error(
        "the advance ended at t = {time} s, where it reached the limit of work in one call: the last {span} s took {events} events. \
         Cause: stop.restitution = {restitution} lets a pressed block bounce too long, or the block is too fast (its path in \
         a sub-step is {path:e} times stop.gap). Remedy: advance again from there, take smaller steps, or set \
         stop.restitution below 0.999, so that bouncing ends sooner"
    )]
    WorkLimit {
        /// Time reached, s.
        time: f64,
        /// Time since the advance began, s.
        span: f64,
        /// Events (impacts and releases) since the advance began.
        events: u64,
        /// Restitution coefficient κ.
        restitution: f64,
        /// Present relative speed of the block times the length of a sub-step, divided by the gap.
        path: f64,
    },
    /// The end of a step lies before its beginning or is not a finite number.
    #[error("step to t = {end} s from t = {time} s: the end must be finite and not before the present time")]
    Step {
        /// Present time in s.
        time: f64,
        /// Requested end in s.
        end: f64,
    },
    /// A quantity that the dimensionless form needs is zero or singular.
    #[error("{name} = {value}: the {needed_by} requires {allowed}")]
    Undefined {
        /// Structured name of the variable.
        name: &'static str,
        /// Value of the variable.
        value: f64,
        /// Formula that needs it, in words.
        needed_by: &'static str,
        /// Allowed values, in words.
        allowed: &'static str,
    },
    /// An iteration did not converge.
    #[error("{what}: no convergence; the matrix may hold values too large for double precision")]
    NoConvergence {
        /// Unknown of the iteration, in words.
        what: &'static str,
    },
    /// A sample of a record cannot be used.
    #[error("sample {index} (counted from 0), time = {time} s, force = {force} N: expected {allowed}")]
    Sample {
        /// Index of the sample, counted from 0.
        index: usize,
        /// Time of the sample, s.
        time: f64,
        /// Force of the sample, N.
        force: f64,
        /// Allowed samples, in words.
        allowed: &'static str,
    },
    /// A record has too few samples.
    #[error("a record of {count} samples: expected at least two, so that the force between them is known")]
    Samples {
        /// Number of samples.
        count: usize,
    },
    /// An interval of a parameter is empty, unbounded or not a number.
    #[error("range of {name} from {from} to {to}: expected a finite range with from < to")]
    Range {
        /// Name of the parameter.
        name: &'static str,
        /// Lower end.
        from: f64,
        /// Upper end.
        to: f64,
    },
}

/// Result with the error of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl From<vibro_numerics::OutOfRange> for Error {
    fn from(vibro_numerics::OutOfRange { name, value, allowed }: vibro_numerics::OutOfRange) -> Self {
        Self::OutOfRange { name, value, allowed }
    }
}
