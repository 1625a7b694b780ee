//! The one error type of the crate.

/// What can go wrong; every message names the quantity, its value and what is allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A named quantity lies outside its range (also NaN and infinities).
    #[error("{name} = {value}: allowed is {allowed}")]
    OutOfRange {
        /// Structured name of the variable, e.g. `stop.restitution`.
        name: &'static str,
        /// The refused value.
        value: f64,
        /// The allowed range, in words.
        allowed: &'static str,
    },
    /// The block would start outside the box.
    #[error("block.s - box.s = {value} m: allowed is -stop.gap <= block.s - box.s <= stop.gap = {gap} m")]
    Penetration {
        /// Relative displacement `w = x2 - x1` in m.
        value: f64,
        /// Half the free path `L` in m.
        gap: f64,
    },
    /// Double precision cannot carry the requested motion.
    #[error("{what} = {value:e}: allowed is up to {limit:e}; beyond that double precision loses the motion")]
    PrecisionLost {
        /// The offending ratio, in words.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The largest allowed value.
        limit: f64,
    },
    /// One advance has done all the work it is allowed. The state stands at `time` and is as good
    /// as any: another advance goes on from there, with an allowance of its own.
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
        /// Events (impacts and releases) since then.
        events: u64,
        /// Restitution coefficient κ.
        restitution: f64,
        /// The block's present relative speed times a sub-step's length over the gap.
        path: f64,
    },
    /// The end of a step lies before its beginning or is not a finite number.
    #[error("step to t = {end} s from t = {time} s: allowed is a finite end not before the present")]
    Step {
        /// Present time in s.
        time: f64,
        /// Requested end in s.
        end: f64,
    },
    /// A quantity that the dimensionless form needs is zero or singular.
    #[error("{name} = {value}: the {needed_by} needs {allowed}")]
    Undefined {
        /// Structured name of the variable.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Which formula needs it.
        needed_by: &'static str,
        /// What it needs.
        allowed: &'static str,
    },
    /// An iteration did not end.
    #[error("{what}: no convergence; the matrix may hold values too large for double precision")]
    NoConvergence {
        /// What was sought.
        what: &'static str,
    },
    /// A sample of a record cannot be used.
    #[error("sample {index} (counted from 0), time = {time} s, force = {force} N: allowed is {allowed}")]
    Sample {
        /// Its index, counted from 0.
        index: usize,
        /// Its time, s.
        time: f64,
        /// Its force, N.
        force: f64,
        /// What is allowed, in words.
        allowed: &'static str,
    },
    /// A record has too few samples.
    #[error("a record of {count} samples: allowed is two or more, so that the force between them is known")]
    Samples {
        /// How many there are.
        count: usize,
    },
    /// An interval of a parameter is empty, unbounded or not a number.
    #[error("range of {name} from {from} to {to}: allowed is a finite range with from < to")]
    Range {
        /// What ranges.
        name: &'static str,
        /// Its lower end.
        from: f64,
        /// Its upper end.
        to: f64,
    },
}

/// Result with the crate's error.
pub type Result<T> = std::result::Result<T, Error>;
