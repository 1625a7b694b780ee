//! Diagrams over one parameter in both directions: a chain of motions from value to value, and an
//! observation at each value, which does not depend on the others.

use crate::class::MotionClass;
use crate::error::Result;
use crate::parts::{PartStore, Task};
use serde::Serialize;
use vibro_impact::simulator::TOGETHER;

/// Values in a part.
const BLOCK: usize = 2 * TOGETHER;

/// A diagram in both directions; `None` where the simulator refused a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagram<P> {
    /// Motions with the value rising.
    pub up: Vec<Option<P>>,
    /// Motions with the value falling, in the order of rising values.
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
    /// Impacts a period.
    fn contacts(&self) -> f64;
    /// Whether another motion ended on another attractor; `None` where that is undecided.
    fn differs(&self, other: &Self) -> Option<bool>;
}

/// One pass through the values of a diagram: the results of `step`, in the order of rising values.
/// The store may end it before any.
pub(crate) fn chained<S>(
    count: usize,
    upward: bool,
    store: &dyn PartStore,
    step: &mut dyn FnMut(usize) -> Result<S>,
) -> Result<Vec<S>> {
    let mut starts = Vec::with_capacity(count);
    for i in 0..count {
        store.go_on()?;
        starts.push(step(if upward { i } else { count - 1 - i })?);
    }
    if !upward {
        starts.reverse();
    }
    Ok(starts)
}

/// Number of parts of a diagram over `values` values.
pub(crate) fn parts(values: usize) -> usize {
    2 * values.div_ceil(BLOCK)
}

/// Observes the motions from some starts in a workspace.
type Observe<'a, S, W, P> = dyn Fn(&mut W, &[S]) -> Result<Vec<Option<P>>> + Sync + 'a;

/// A diagram from its chains, one for each direction, and from observations of some of their starts
/// at a time in a workspace that serves one part after another.
pub(crate) fn in_both_directions<S: Send + Sync, W: Default, P>(
    values: usize,
    task: &Task,
    chain: &(dyn Fn(bool) -> Result<Vec<S>> + Sync),
    observe: &Observe<'_, S, W, P>,
) -> Result<Option<Diagram<P>>>
where
    P: Clone + Serialize + serde::de::DeserializeOwned + Send,
{
    // A sweep whose parts are all in the store needs no chain.
    let starts = std::sync::OnceLock::new();
    let chains = || -> Result<[Vec<S>; 2]> {
        let (up, down) = rayon::join(|| chain(true), || chain(false));
        Ok([up?, down?])
    };
    if task.store.missing(parts(values)) > 0 {
        // Nothing else sets the cell, so that this cannot fail.
        let _ = starts.set(chains()?);
    }
    let blocks = values.div_ceil(BLOCK);
    let make = |workspace: &mut W, index: usize| -> Result<Vec<Option<P>>> {
        let fresh;
        let both = match starts.get() {
            Some(both) => both,
            // Reached only for a stored part that cannot be read.
            None => {
                fresh = chains()?;
                &fresh
            }
        };
        let starts = &both[index / blocks];
        let from = index % blocks * BLOCK;
        let until = (from + BLOCK).min(starts.len());
        observe(workspace, &starts[from..until])
    };
    let Some(mut all) = task.complete_with(parts(values), make)? else { return Ok(None) };
    let down = all.split_off(blocks).concat();
    Ok(Some(Diagram { up: all.concat(), down }))
}
