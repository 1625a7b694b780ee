//! Many independent motions at a time on one thread: while one waits for its arithmetic the next computes.

use super::flight::Outlook;
use super::step::{Course, RENEW};
use super::{Contact, Simulator, StopReason};
use crate::error::{Error, Result};
use crate::extended::Extended;
use crate::vector;
use pulp::Simd;
use std::ops::ControlFlow;

/// Motions under way at a time: with more, their tables no longer fit the nearest cache.
const LANES: usize = 4;

/// Advances each simulator to its `end` (s), as [`Simulator::advance_to`] does and with the same bits; several motions are
/// under way at a time, so that all together take less time than one after another. Those that keep their energy accounts
/// or are under loads go one by one. Results in the simulators' order.
pub fn advance_together(simulators: &mut [Simulator], end: impl Fn(&Simulator) -> f64) -> Vec<Result<()>> {
    let mut results: Vec<Result<()>> = simulators.iter().map(|s| s.check_end(end(s))).collect();
    let mut waiting = Vec::new();
    for (simulator, result) in simulators.iter_mut().zip(&mut results).rev() {
        if result.is_err() {
            continue;
        }
        if simulator.keeps_ledger || simulator.loaded() {
            *result = simulator.advance_to(end(simulator));
        } else {
            let (course, end) = (simulator.depart(), Extended::new(end(simulator)));
            waiting.push(Motion { simulator, course, end, result });
        }
    }
    pulp::Arch::new().dispatch(Batch { waiting });
    results
}

/// A motion under way.
struct Motion<'a> {
    simulator: &'a mut Simulator,
    course: Course,
    end: Extended,
    result: &'a mut Result<()>,
}

/// The work of one thread, to be compiled once for each instruction set.
struct Batch<'a> {
    /// Taken from the back.
    waiting: Vec<Motion<'a>>,
}

impl pulp::WithSimd for Batch<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let mut lanes: [Option<Motion<'_>>; LANES] = [(); LANES].map(|()| self.waiting.pop());
        while lanes.iter().any(Option::is_some) {
            // All lanes look, then all aim, then all go: what one lane waits for another fills.
            let mut outlooks = [const { None }; LANES];
            for (outlook, lane) in outlooks.iter_mut().zip(&mut lanes) {
                if let Some(Motion { simulator, course, end, .. }) = lane {
                    *outlook = simulator.survey(simd, course, *end);
                }
            }
            let mut aims = [const { None }; LANES];
            for ((aim, outlook), lane) in aims.iter_mut().zip(&outlooks).zip(&mut lanes) {
                if let (Some(Motion { simulator, course, .. }), Some(outlook)) = (lane, outlook) {
                    let index = outlook.search.trailing_zeros() as usize;
                    *aim = simulator.aim(simd, &course.z, outlook, index, f64::INFINITY);
                }
            }
            for (aim, lane) in aims.iter().zip(&mut lanes) {
                let Some(Motion { simulator, course, end, result }) = lane else { continue };
                let going = match aim {
                    Some(aim) => {
                        simulator.renew(course);
                        simulator.work.substeps += 1;
                        course.z = simulator.reach::<S, false>(simd, &course.z, aim);
                        simulator.conclude::<0>(course, Some(aim.side), false, &mut None)
                    }
                    None => simulator.go_on::<S, 0, false>(simd, course, *end, false, &mut None),
                };
                if let ControlFlow::Break(reason) = going {
                    **result = reason.map(|_: StopReason| ());
                    *lane = self.waiting.pop();
                }
            }
        }
    }
}

impl Simulator {
    /// The samples of a next sub-step that lies whole before `end`, has its first impact after its first interval and asks
    /// for nothing else; all others are left to [`go_on`](Self::go_on).
    #[inline(always)]
    fn survey<S: Simd>(&mut self, simd: S, course: &mut Course, end: Extended) -> Option<Outlook> {
        let plain =
            self.motion.contact == Contact::Flight && end.hi - self.motion.time.hi > 2.0 * self.substep;
        if !plain || course.since_renewal == RENEW {
            return None;
        }
        let bound = vector::weigh::<S>(&course.z, &self.flight.core.bound);
        if self.wild(&course.z, bound) {
            return None;
        }
        let outlook = self.look(simd, &course.z, bound);
        if outlook.first || outlook.search == 0 {
            return None;
        }
        Some(outlook)
    }

    /// As an advance to `end` checks it.
    fn check_end(&self, end: f64) -> Result<()> {
        if end.is_finite() && end >= self.time() {
            return Ok(());
        }
        Err(Error::Step { time: self.time(), end })
    }
}
