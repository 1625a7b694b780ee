//! Errors of the component.

/// Outcome of a call.
pub type Outcome<T = ()> = Result<T, ComponentProblem>;

/// Reason why a call was refused; the component is then unchanged. Each text states the variable,
/// its value and the valid values. Errors that any component may have are in [`Door`](Self::Door).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ComponentProblem {
    /// The variable does not have the requested or given derivative.
    #[error("{name} has no such derivative: expected {allowed}")]
    NoDerivative {
        /// The variable.
        name: &'static str,
        /// The variables with derivatives.
        allowed: &'static str,
    },
    /// A step after one that stopped early at an impact begins neither at that impact nor, after a
    /// restore, where that step began.
    #[error(
        "currentCommunicationPoint = {given} s, but the last step ended at the impact at t = {own} s: restore the state saved \
         before the impact, or continue from lastSuccessfulTime"
    )]
    Stopped {
        /// The host's time.
        given: f64,
        /// The time of the impact.
        own: f64,
    },
    /// A number of the motion is not a finite double.
    #[error(
        "{name} = {value} at t = {time} s: expected a finite number; parameters, start values, \
         states or loads are too \
         large together"
    )]
    Overflow {
        /// The quantity.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Time, s.
        time: f64,
    },
    /// A derivative that is not a finite double.
    #[error(
        "derivative of {name} = {value}: expected a finite number; seed, parameters, start values, \
         states or loads are too \
         large together"
    )]
    Derivative {
        /// The variable.
        name: &'static str,
        /// Its derivative along the seed.
        value: f64,
    },
    /// A step that exceeds the work limit of one step; it has been undone.
    #[error(
        "step from t = {own} s: it reached the limit of work in one step at t = {time} s, after {events} events, and has been taken \
         back. Cause: stop.restitution = {restitution} lets a pressed block bounce too long, or the block is too fast (its path in \
         a sub-step is {path:e} times stop.gap). Remedy: take smaller steps from t = {own} s, or set stop.restitution below \
         0.999, so that bouncing ends sooner"
    )]
    WorkLimit {
        /// Beginning of the step, where the component still is, s.
        own: f64,
        /// Time when the limit was reached, s.
        time: f64,
        /// Number of events (impacts and releases) up to that time.
        events: u64,
        /// Restitution coefficient.
        restitution: f64,
        /// The block's relative speed at that time, times a sub-step's length, over the gap.
        path: f64,
    },
    /// The model refuses.
    #[error(transparent)]
    Model(#[from] vibro_impact::error::Error),
    /// A closed-form mode cannot be played.
    #[error("{what}")]
    ClosedForm {
        /// The reason.
        what: String,
    },
    /// An error that any component may have.
    #[error(transparent)]
    Door(#[from] fmi_doors::Problem),
}

impl ComponentProblem {
    /// A value outside its range.
    pub(crate) fn value(name: &'static str, value: f64, allowed: &'static str) -> Self {
        fmi_doors::Problem::value(name, value, allowed).into()
    }

    /// Error for an action that must be preceded by another one.
    pub(crate) fn sequence(what: &'static str) -> Self {
        fmi_doors::Problem::Sequence { what: what.into() }.into()
    }
}
