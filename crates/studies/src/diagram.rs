//! Bifurcation diagrams: local maxima of a quantity over one parameter in both directions, with
//! period, class and, on request, exponents.
//!
//! As in the paper, section 4, some periods are discarded and some kept at each value, and the
//! last state is the start of the next value. The chain of motions from value to value cannot be
//! divided. The observation at each value does not depend on other values, so threads and
//! computers share this part of the work.

mod described;
mod windows;

pub use described::{DescribedPoint, Direction, MOST_VALUES};
pub use windows::Window;

use crate::axis::ParameterAxis;
use crate::class::MotionClass;
use crate::design_sweep::{DesignMachine, Plain};
use crate::error::Result;
use crate::parts::Task;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use vibro_impact::simulator::TOGETHER;

/// Number of values in a part.
const BLOCK: usize = 2 * TOGETHER;

/// Request of a bifurcation diagram.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct DiagramRequest<M: DiagramMachine> {
    /// The parameter and its values, SI.
    pub axis: ParameterAxis<M::Name>,
    /// The quantity to draw.
    pub of: M::Of,
    /// Whether to draw its values at the section instead of its local maxima.
    pub at_section: bool,
    /// Returns or drive periods discarded at each value; fewer if the motion of a described
    /// machine has settled.
    pub discard: u32,
    /// Returns or drive periods kept.
    pub keep: u32,
    /// Options for the exponents, if they are computed.
    pub exponents: Option<M::Exponents>,
    /// Whether each value starts from `start`. The diagram then has one direction.
    pub anew: bool,
    /// Start at the first value of each direction, and at a value after a refused one.
    pub start: M::Start,
}

impl<M: DiagramMachine> DiagramRequest<M> {
    /// A request for local maxima without exponents from the machine's default start.
    pub fn new(axis: ParameterAxis<M::Name>, of: M::Of, (discard, keep): (u32, u32)) -> Self {
        let (exponents, start) = (None, M::Start::default());
        Self { axis, of, at_section: false, discard, keep, exponents, anew: false, start }
    }

    /// Checks the properties on which every value depends.
    ///
    /// # Errors
    /// As [`DiagramMachine::check_diagram`].
    pub fn check(&self, machine: &M) -> Result<()> {
        machine.check_diagram(self)
    }

    /// Number of parts.
    pub fn count(&self) -> usize {
        2 * self.axis.count.div_ceil(BLOCK)
    }
}

/// Machine that can be studied with diagrams.
pub trait DiagramMachine: DesignMachine {
    /// Quantity to draw.
    type Of: Plain;
    /// Options for exponents.
    type Exponents: Plain;
    /// Motion at one value.
    type Point: DiagramPoint + Plain;
    /// Settled state of the motion at one value. Its observation and the next value begin here.
    type Settled: Send + Sync;
    /// Workspace reused for all parts; it does not change results.
    type DiagramWorkspace: Default;

    /// Checks the properties on which every value depends.
    ///
    /// # Errors
    /// Error if the machine refuses a name, a start or an end.
    fn check_diagram(&self, request: &DiagramRequest<Self>) -> Result<()>;

    /// The settled motion at a value. It begins at the state of the previous value or, without
    /// one, at the start. `None` if the motion cannot continue.
    ///
    /// # Errors
    /// Errors that end the diagram.
    fn settled_at(
        &self,
        request: &DiagramRequest<Self>,
        value: f64,
        before: Option<&Self::Settled>,
    ) -> Result<Option<Self::Settled>>;

    /// Observes the motions at some values. `None` if a motion cannot continue.
    ///
    /// # Errors
    /// Errors that end the diagram.
    fn observe(
        &self,
        request: &DiagramRequest<Self>,
        starts: &[(f64, Option<Self::Settled>)],
        workspace: &mut Self::DiagramWorkspace,
    ) -> Result<Vec<Option<Self::Point>>>;
}

/// A diagram in both directions. `None` if the simulator refused a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagram<P> {
    /// Motions at rising values.
    pub up: Vec<Option<P>>,
    /// Motions at falling values, in the order of rising values.
    pub down: Vec<Option<P>>,
}

/// Motion at one value of a diagram, of any machine.
pub trait DiagramPoint {
    /// The parameter's value.
    fn value(&self) -> f64;
    /// Drawn values, ascending, each with its count.
    fn maxima(&self) -> &[(f64, u32)];
    /// Class of the motion.
    fn class(&self) -> MotionClass;
    /// Impacts per period.
    fn contacts(&self) -> f64;
    /// Whether another motion ended on another attractor; `None` if it is undecided.
    fn differs(&self, other: &Self) -> Option<bool>;
}

/// Settled state at each value, in the order of rising values. `None` if the motion cannot
/// continue.
type Chain<M> = Vec<(f64, Option<<M as DiagramMachine>::Settled>)>;

/// The chain of states from value to value. The store may end it at any value.
fn chain<M: DiagramMachine>(
    machine: &M,
    request: &DiagramRequest<M>,
    task: &Task,
    upward: bool,
) -> Result<Chain<M>> {
    let (axis, count) = (&request.axis, request.axis.count);
    if request.anew {
        let settled = |value| if upward { machine.settled_at(request, value, None) } else { Ok(None) };
        let values = (0..count).into_par_iter().map(|i| axis.value(i));
        return values.map(|value| Ok((value, settled(value)?))).collect();
    }
    let mut chain: Chain<M> = Vec::with_capacity(count);
    for i in 0..count {
        task.store.go_on()?;
        let value = axis.value(if upward { i } else { count - 1 - i });
        let before = chain.last().and_then(|(_, settled)| settled.as_ref());
        let settled = machine.settled_at(request, value, before)?;
        chain.push((value, settled));
    }
    if !upward {
        chain.reverse();
    }
    Ok(chain)
}

/// Computes the diagram on all threads, in parts. `None` if parts belong to other shards. The
/// result depends neither on threads nor on shards.
///
/// # Errors
/// As [`DiagramRequest::check`], and errors of the parts' folder.
///
/// # Examples
/// The amplitude of a linear oscillator grows with its force:
///
/// ```
/// use vibro_studies::diagram::{DiagramRequest, diagram};
/// use vibro_studies::parts::Task;
/// use vibro_studies::{Machine, ParameterAxis};
///
/// # let text = r#"
/// #     name = "Shaken"
/// #     body.a = { mass = 1.0 }
/// #     spring.k = { between = ["ground", "a"], stiffness = 4.0, damping = 1.25 }
/// #     load.f = { on = "a", amplitude = 26.0, frequency = "4 rad/s" }
/// # "#;
/// let machine = Machine::parse(text, "shaken.toml", &vibro_machine::file::no_records)?;
/// let axis = ParameterAxis::of("load.f.amplitude".to_owned(), (13.0, 39.0), 3)?;
/// let request = DiagramRequest::new(axis, "a.s".parse()?, (100, 10));
/// let found = diagram(&machine, &request, &Task::ALL)?.unwrap();
/// for (point, exact) in found.up.iter().zip([1.0, 2.0, 3.0]) {
///     let (maximum, _) = point.as_ref().unwrap().maxima[0];
///     assert!((maximum - exact).abs() < 1e-6 * exact); // maxima have seven digits
/// }
/// # Ok::<(), vibro_studies::Error>(())
/// ```
pub fn diagram<M: DiagramMachine>(
    machine: &M,
    request: &DiagramRequest<M>,
    task: &Task,
) -> Result<Option<Diagram<M::Point>>> {
    request.check(machine)?;
    let chains = || -> Result<[Chain<M>; 2]> {
        let directed = |upward| chain(machine, request, task, upward);
        let (up, down) = rayon::join(|| directed(true), || directed(false));
        Ok([up?, down?])
    };
    // The chain is not needed if all parts of the diagram are in the store.
    let starts = (task.store.missing(request.count()) > 0).then(chains).transpose()?;
    let blocks = request.count() / 2;
    let make = |workspace: &mut M::DiagramWorkspace, index: usize| {
        let fresh;
        let both = match &starts {
            Some(both) => both,
            // Reached only if a stored part cannot be read.
            None => {
                fresh = chains()?;
                &fresh
            }
        };
        let starts = &both[index / blocks];
        let from = index % blocks * BLOCK;
        machine.observe(request, &starts[from..(from + BLOCK).min(starts.len())], workspace)
    };
    let Some(mut all) = task.complete_with(request.count(), make)? else { return Ok(None) };
    let down = all.split_off(blocks).concat();
    Ok(Some(Diagram { up: all.concat(), down }))
}
