//! Progress of a fit, and its end by the caller.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

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

/// A cost that is not known yet.
const NONE: u64 = f64::NAN.to_bits();

/// What the stages of a fit report, from several threads.
pub(super) struct Watch {
    stage: Mutex<String>,
    /// Bits of the costs.
    cost: AtomicU64,
    best: AtomicU64,
    /// Stages that are over or left out, and stages that were announced.
    over: AtomicU32,
    announced: AtomicU32,
    /// Bits of the finished share of the present stage.
    share: AtomicU64,
    is_ended: AtomicBool,
}

impl Default for Watch {
    fn default() -> Self {
        Self {
            stage: Mutex::default(),
            cost: NONE.into(),
            best: NONE.into(),
            over: 0.into(),
            announced: 0.into(),
            share: 0f64.to_bits().into(),
            is_ended: false.into(),
        }
    }
}

impl Watch {
    /// Announces a number of stages.
    pub fn announce(&self, stages: usize) {
        self.announced.fetch_add(stages as u32, Ordering::Relaxed);
    }

    /// Begins a stage.
    pub fn begin(&self, stage: impl Into<String>) {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = stage.into();
        self.cost.store(NONE, Ordering::Relaxed);
        self.share(0.0);
    }

    /// Sets the finished share of the present stage.
    pub fn share(&self, share: f64) {
        self.share.store(share.to_bits(), Ordering::Relaxed);
    }

    /// Counts stages that are over or left out.
    pub fn over(&self, stages: usize) {
        self.over.fetch_add(stages as u32, Ordering::Relaxed);
        self.share(0.0);
    }

    /// Notes the cost of a step; `is_whole` if one motion covers the whole record.
    pub fn cost(&self, cost: f64, is_whole: bool) {
        self.cost.store(cost.to_bits(), Ordering::Relaxed);
        if is_whole {
            // The least of the two; NaN, which no cost is, yields the other.
            let least = |best: u64| Some(f64::from_bits(best).min(cost).to_bits());
            let _ = self.best.fetch_update(Ordering::Relaxed, Ordering::Relaxed, least);
        }
    }

    /// Forgets the least cost, since residuals are weighed differently from now on.
    pub fn reweigh(&self) {
        self.best.store(NONE, Ordering::Relaxed);
    }

    /// Reports the progress to an observer; returns whether the fit continues. An observer that has
    /// ended the fit is not asked again.
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
        let number = |bits: &AtomicU64| f64::from_bits(bits.load(Ordering::Relaxed));
        let known = |bits: &AtomicU64| Some(number(bits)).filter(|x| x.is_finite());
        let [over, announced] = [&self.over, &self.announced].map(|x| f64::from(x.load(Ordering::Relaxed)));
        let part = (over + number(&self.share).clamp(0.0, 1.0)) / announced.max(1.0);
        Progress {
            stage: self.stage.lock().unwrap_or_else(PoisonError::into_inner).clone(),
            cost: known(&self.cost),
            best: known(&self.best),
            simulations,
            part: part.min(1.0),
        }
    }
}
