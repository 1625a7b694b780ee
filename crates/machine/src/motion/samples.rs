//! Samples of blocks: when they are due, and their effect on the motion.

use super::event::EventKind;
use super::instant::end_of_instant;
use super::jump::Parted;
use super::report::report;
use super::{Motion, Observer};
use crate::error::Error;
use crate::system::{SampleAction, SampleKind, Sampler, System};
use serde::{Deserialize, Serialize};
use vibro_numerics::double_double::DoubleDouble;

/// Progress of a sampled block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Clock {
    /// Number of samples so far.
    pub reads: u64,
    /// Number of samples whose outputs act or have acted.
    pub acts: u64,
}

impl Sampler {
    /// Returns the time of a sample by its number, rounded once.
    pub fn time_of_sample(&self, number: i64) -> f64 {
        self.period * number as f64
    }

    /// Returns the time at which a sample's outputs act, rounded once.
    pub fn time_of_acting(&self, number: i64) -> f64 {
        DoubleDouble::new(self.period).times(DoubleDouble::new(number as f64)).plus(self.delay).value()
    }

    fn read_at(&self, count: u64) -> f64 {
        self.time_of_sample(count as i64)
    }

    fn act_at(&self, count: u64) -> f64 {
        self.time_of_acting(count as i64)
    }

    /// Returns the clock at a time at which samples are done or, with `fresh`, still due.
    fn clock(&self, time: f64, fresh: bool) -> Clock {
        let count = |at: &dyn Fn(u64) -> f64, first: f64, is_done: &dyn Fn(f64) -> bool| {
            let mut count = ((time - first) / self.period).floor().max(0.0) as u64;
            count = count.saturating_sub(1);
            while is_done(at(count)) {
                count += 1;
            }
            count
        };
        let done = |at: f64| if fresh { end_of_instant(at) < time } else { at <= end_of_instant(time) };
        let reads = count(&|k| self.read_at(k), 0.0, &done);
        let acts = if self.delay == 0.0 { reads } else { count(&|k| self.act_at(k), self.delay, &done) };
        Clock { reads, acts: acts.min(reads).max(reads.saturating_sub(self.under_way as u64)) }
    }

    /// Returns the next time at which the block reads inputs or its outputs act.
    fn next(&self, clock: &Clock) -> f64 {
        let reads = self.read_at(clock.reads);
        if clock.acts < clock.reads { reads.min(self.act_at(clock.acts)) } else { reads }
    }
}

impl System {
    /// Returns the clocks of all blocks at a time at which samples are done or, with `fresh`,
    /// still due. Continuous blocks do not use them.
    pub(crate) fn clocks(&self, time: f64, fresh: bool) -> Vec<Clock> {
        let clock = |sampler: &Sampler| sampler.clock(time, fresh);
        self.blocks.iter().map(|own| own.sampler.as_ref().map_or_else(Clock::default, clock)).collect()
    }

    /// Whether clocks may belong to this machine's blocks.
    pub(crate) fn fits_clocks(&self, clocks: &[Clock]) -> bool {
        let fits = |(own, clock): (&crate::system::BlockRows, &Clock)| match &own.sampler {
            Some(own) if own.delay == 0.0 => clock.acts == clock.reads,
            Some(own) => clock.acts <= clock.reads && clock.reads - clock.acts <= own.under_way as u64,
            None => *clock == Clock::default(),
        };
        clocks.len() == self.blocks.len() && self.blocks.iter().zip(clocks).all(fits)
    }
}

impl Motion {
    /// Returns the next time, possibly now, at which a block is sampled or its outputs act.
    pub(crate) fn next_sample(&self) -> Option<f64> {
        let (system, clocks) = (&self.assembly.system, &self.hybrid.clocks);
        let all = system.blocks.iter().zip(clocks);
        let next = all.filter_map(|(own, clock)| Some(own.sampler.as_ref()?.next(clock)));
        let next = next.reduce(f64::min)?;
        // A knot within rounding of the sample comes first.
        let knot = system.signals.next_knot(next);
        Some(knot.filter(|knot| *knot <= end_of_instant(next)).unwrap_or(next))
    }

    /// Time of the next knot of a signal, sample of a block or action of its outputs, s.
    ///
    ///
    /// ```
    /// use vibro_machine::{Assembly, Motion, file};
    ///
    /// let text = r#"
    ///     name = "Pushed"
    ///     body.a = { mass = 1.0 }
    ///     load.push = { on = "a", steps = [["0.5 s", "2 N"], ["1.5 s", "-2 N"]] }
    /// "#;
    /// let machine = file::parse(text, "pushed.toml", &file::no_records)?;
    /// let mut motion = Motion::new(Assembly::new(machine)?.into())?;
    /// assert_eq!(motion.next_time_event(), Some(0.5));
    /// motion.advance_to(1.0)?;
    /// assert_eq!(motion.next_time_event(), Some(1.5));
    /// motion.advance_to(2.0)?;
    /// assert_eq!((motion.next_time_event(), motion.rate(0)), (None, 2.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn next_time_event(&self) -> Option<f64> {
        let knot = self.assembly.system.signals.next_knot(self.time());
        [knot, self.next_sample()].into_iter().flatten().reduce(f64::min)
    }

    /// Returns the actions of sampled blocks at the present instant, and the clocks after them.
    fn due_actions(&self) -> (Vec<SampleAction>, Vec<Clock>) {
        let (mut clocks, mut actions) = (self.hybrid.clocks.clone(), Vec::new());
        let end = end_of_instant(self.time());
        for (block, (own, clock)) in self.assembly.system.blocks.iter().zip(&mut clocks).enumerate() {
            let Some(own) = &own.sampler else { continue };
            while own.delay > 0.0 && clock.acts < clock.reads && own.act_at(clock.acts) <= end {
                clock.acts += 1;
                actions.push(SampleAction { block, kind: SampleKind::Acts });
            }
            if own.read_at(clock.reads) <= end {
                let turn = (own.delay > 0.0).then_some((clock.reads - clock.acts) as usize);
                actions.push(SampleAction { block, kind: SampleKind::Reads(turn) });
                clock.reads += 1;
                clock.acts += u64::from(turn.is_none());
            }
        }
        (actions, clocks)
    }

    /// Applies the actions of sampled blocks at the present instant; forces may jump.
    pub(super) fn apply_samples(&mut self, observer: &mut Observer) -> Result<(), Error> {
        let (actions, clocks) = self.due_actions();
        if actions.is_empty() {
            return Ok(());
        }
        self.hybrid.clocks = clocks;
        let before = self.outputs();
        let assembly = self.assembly.clone();
        assembly.system.sample(&actions, &mut self.hybrid.z, &mut []);
        self.hybrid.sizes.include(self.hybrid.z.as_slice());
        if observer.is_some() {
            let time = self.time();
            actions.iter().for_each(|&action| report(observer, time, EventKind::Sample { action }));
            self.report_limits(&before, observer);
        }
        if before == self.outputs() { Ok(()) } else { self.settle(&[], &Parted::default(), observer) }
    }

    /// Returns the states of sampled blocks, outputs that act and outputs under way, block by
    /// block. Only samples change these numbers.
    pub fn kept_by_samples(&self) -> Vec<f64> {
        let sampled = self.assembly.system.blocks.iter().filter(|own| own.sampler.is_some());
        let of = |own: &crate::system::BlockRows| own.first..own.first + own.kept();
        sampled.flat_map(of).map(|place| self.hybrid.z[place]).collect()
    }

    /// Returns the outputs of sampled blocks that act.
    fn outputs(&self) -> Vec<f64> {
        let sampled = self.assembly.system.blocks.iter().filter(|own| own.sampler.is_some());
        let z = &self.hybrid.z;
        let of = |own: &crate::system::BlockRows| {
            let first = own.place_of_output(None, 0);
            first..first + own.outputs.len()
        };
        sampled.flat_map(of).map(|place| z[place]).collect()
    }

    /// Reports the outputs that come to a limit or leave it.
    fn report_limits(&self, before: &[f64], observer: &mut Observer) {
        let (blocks, now) = (&self.assembly.system.blocks, self.outputs());
        let of = |(block, own): (usize, &crate::system::BlockRows)| {
            let limits = own.sampler.as_ref().map(|own| own.limits.clone()).unwrap_or_default();
            limits.into_iter().enumerate().map(move |(output, limits)| (block, output, limits))
        };
        let all = blocks.iter().enumerate().flat_map(of);
        for ((block, output, [low, high]), (was, is)) in all.zip(before.iter().zip(&now)) {
            let side = |y: f64| f64::from(i8::from(y >= high) - i8::from(y <= low));
            if side(*was) != side(*is) {
                let kind = EventKind::Limit { block, output, side: side(*is), value: *is, stop: None };
                report(observer, self.time(), kind);
            }
        }
    }
}
