//! Progress of a fit, which its observer can end.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Progress of a fit, as its observer sees it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Progress {
    /// Present stage, in words; with several starts in parallel, the stage that began last.
    pub stage: String,
    /// Cost of the last step, over the part of the record that the stage uses.
    pub cost: Option<f64>,
    /// Least cost so far of one motion over the whole record.
    pub best: Option<f64>,
    /// Number of simulations so far.
    pub simulations: u32,
    /// Finished share of the longest course that the fit can take, from 0 to 1. A fit whose first
    /// stage reaches the noise ends long before 1.
    pub part: f64,
}

/// Observer of a fit. It is called at each step and ends the fit by returning false.
pub type Observer<'o> = &'o (dyn Fn(&Progress) -> bool + Sync);

/// Progress that the stages of a fit report, from several threads.
#[derive(Default)]
pub(super) struct Watch {
    state: Mutex<State>,
    is_ended: AtomicBool,
}

#[derive(Default)]
struct State {
    stage: String,
    cost: Option<f64>,
    best: Option<f64>,
    /// Stages that are over or left out, and stages that were announced.
    over: usize,
    announced: usize,
    /// Finished share of the present stage.
    share: f64,
}

impl Watch {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Announces a number of stages.
    pub fn announce(&self, stages: usize) {
        self.state().announced += stages;
    }

    /// Begins a stage.
    pub fn begin(&self, stage: impl Into<String>) {
        let mut own = self.state();
        (own.stage, own.cost, own.share) = (stage.into(), None, 0.0);
    }

    /// Sets the finished share of the present stage.
    pub fn share(&self, share: f64) {
        self.state().share = share.clamp(0.0, 1.0);
    }

    /// Counts stages that are over or left out.
    pub fn over(&self, stages: usize) {
        let mut own = self.state();
        (own.over, own.share) = (own.over + stages, 0.0);
    }

    /// Notes the cost of a step; `is_whole` if one motion covers the whole record.
    pub fn cost(&self, cost: f64, is_whole: bool) {
        let mut own = self.state();
        own.cost = Some(cost).filter(|cost| cost.is_finite());
        if is_whole && own.best.is_none_or(|best| cost < best) {
            own.best = own.cost;
        }
    }

    /// Resets the least cost, since the weights of residuals change.
    pub fn reweigh(&self) {
        self.state().best = None;
    }

    /// Reports the progress to an observer; returns whether the fit continues. An observer that
    /// has ended the fit is not called again.
    pub fn go_on(&self, observer: Observer, simulations: u32) -> bool {
        if self.is_ended() {
            return false;
        }
        let goes_on = observer(&self.progress(simulations));
        if !goes_on {
            self.is_ended.store(true, Ordering::Relaxed);
        }
        goes_on
    }

    /// Whether the observer has ended the fit.
    pub fn is_ended(&self) -> bool {
        self.is_ended.load(Ordering::Relaxed)
    }

    fn progress(&self, simulations: u32) -> Progress {
        let own = self.state();
        let part = (own.over as f64 + own.share) / own.announced.max(1) as f64;
        let (stage, cost, best) = (own.stage.clone(), own.cost, own.best);
        Progress { stage, cost, best, simulations, part: part.min(1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_the_finished_share_counts_stages_and_the_present_one() {
        let watch = Watch::default();
        watch.announce(4);
        watch.over(1);
        watch.share(0.5);
        assert_eq!(watch.progress(0).part, 0.375);
        watch.over(3);
        assert_eq!(watch.progress(0).part, 1.0);
        // Stages that were left out may have been counted already.
        watch.over(1);
        assert_eq!(watch.progress(0).part, 1.0);
    }
}
