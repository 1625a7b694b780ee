//! Reports of events to the observer and to the accounts.

use super::event::{Event, EventKind};
use super::{Motion, Observer};
use crate::law::impact::Impacts;
use crate::mode::{ElementState, FrictionState, Mode, SliderState, StopState};
use crate::system::OutputLimit;

impl Motion {
    /// Reports impacts and adds them to the records and the energy accounts.
    pub(super) fn report_impacts(&mut self, impacts: &Impacts, observer: &mut Observer) {
        let time = self.time();
        for impact in &impacts.sequence {
            self.hybrid.energy.impact(impact.lost, impact.work);
            for &(stop, speed, impulse) in &impact.stops {
                self.hybrid.impacts[stop].add(impulse);
                report(observer, time, EventKind::Impact { stop, speed, impulse, stops: impact.stops.len() });
            }
        }
        self.hybrid.energy.impact(impacts.projected_loss, 0.0);
    }

    /// Reports every element whose state differs from its state in `before`. `closing` lists
    /// closing stops with the times until their bounces would have accumulated, s.
    pub(super) fn report_changes(&self, before: &Mode, closing: &[(usize, f64)], observer: &mut Observer) {
        for (i, &was) in before.stops.iter().enumerate() {
            let left = closing.iter().find(|c| c.0 == i).map_or(0.0, |c| c.1);
            match (was, self.hybrid.mode.stops[i]) {
                // When a stiffness steps, only the part that begins to act reports the change.
                (_, StopState::Off) => {}
                (StopState::Off, now) => {
                    let stop = self.assembly.system.stop_of(i);
                    let was = before.stops[self.assembly.system.present(stop, &before.stops)];
                    self.report_stop(i, was, now, left, observer);
                }
                _ => self.report_change(ElementState::Stop(i, was), left, observer),
            }
        }
        for (i, &was) in before.frictions.iter().enumerate() {
            self.report_change(ElementState::Friction(i, was), 0.0, observer);
        }
        for (i, &was) in before.sliders.iter().enumerate() {
            self.report_change(ElementState::Slider(i, was), 0.0, observer);
        }
    }

    /// Reports the change of an element from its state `was`. A stop that closes would have
    /// bounced for the time `left`.
    pub(super) fn report_change(&self, was: ElementState, left: f64, observer: &mut Observer) {
        match (was, self.hybrid.mode.state_of(was)) {
            (ElementState::Stop(i, was), ElementState::Stop(_, now)) => {
                self.report_stop(i, was, now, left, observer)
            }
            (ElementState::Friction(i, was), ElementState::Friction(_, now)) => {
                self.report_friction(i, was, now, observer);
            }
            // A contact that closes or opens has an event of its stop.
            (ElementState::Slider(_, SliderState::Off), _) => {}
            (ElementState::Slider(slider, was), ElementState::Slider(_, now)) if was != now => {
                // Report the level, since stiffness times stretch has rounding.
                let slips = if now == SliderState::Held { was } else { now };
                let z = self.hybrid.z.as_slice();
                let force = self.assembly.system.branch_force_at(slider, slips, z);
                let kind = match now {
                    SliderState::Off => return,
                    SliderState::Held => EventKind::Hold { slider, force },
                    _ => EventKind::Yield { slider, direction: now.direction(), force },
                };
                report(observer, self.time(), kind);
            }
            _ => {}
        }
    }

    fn report_stop(&self, i: usize, was: StopState, now: StopState, left: f64, observer: &mut Observer) {
        let stop = self.assembly.system.stop_of(i);
        let rate = self.assembly.system.rate_apart(i, self.hybrid.z.as_slice());
        let kind = match (was, now) {
            (a, b) if a == b || self.assembly.system.stops[i].is_gapless() => return,
            _ if self.assembly.system.stops[i].limit.is_some() => {
                let Some(OutputLimit { block, output, is_upper }) = self.assembly.system.stops[i].limit
                else {
                    return;
                };
                let out = if is_upper { 1.0 } else { -1.0 };
                let side = if now == StopState::Pressed { out } else { 0.0 };
                let system = &self.assembly.system;
                let value = system.blocks[block].outputs[output].at(&system.stops, &self.hybrid.z);
                EventKind::Limit { block, output, side, value, stop: Some(i) }
            }
            _ if self.assembly.system.is_corner(i) => {
                // Lines with equal slopes have no corner.
                if self.assembly.system.stops[i].stiffness() == 0.0 {
                    return;
                }
                EventKind::Corner { corner: i, rate }
            }
            (_, StopState::Closed) => {
                return report(observer, self.time() + left, EventKind::Close { stop: i });
            }
            (StopState::Closed, StopState::Open) => EventKind::Open { stop: i },
            (was, now) if !was.has_force() && now.has_force() => EventKind::Press { stop, speed: rate },
            (was, now) if was.has_force() && !now.has_force() => EventKind::Free { stop, rate },
            (StopState::Pressed, StopState::Capped) => EventKind::Cap { stop, acts: true },
            (StopState::Capped, StopState::Pressed) => EventKind::Cap { stop, acts: false },
            _ => return,
        };
        report(observer, self.time(), kind);
    }

    fn report_friction(&self, i: usize, was: FrictionState, now: FrictionState, observer: &mut Observer) {
        if was == now || (was.sticks() && now.sticks()) {
            return;
        }
        let time = self.time();
        let level = |acts| EventKind::Level { friction: i, acts };
        match (was, now) {
            // A level that follows a stop begins and ends with the stop's force, which has an
            // event.
            _ if !self.assembly.system.frictions[i].passes => {}
            (_, FrictionState::Off) => report(observer, time, level(false)),
            (FrictionState::Off, _) => report(observer, time, level(true)),
            _ => {}
        }
        match now {
            _ if now.sticks() => report(observer, time, EventKind::Stick { friction: i }),
            FrictionState::Up | FrictionState::Down if was != FrictionState::Off => {
                let (direction, force) = (now.direction(), self.friction(i)[2]);
                report(observer, time, EventKind::Slip { friction: i, direction, force });
            }
            _ => {}
        }
    }
}

pub(super) fn report(observer: &mut Observer, time: f64, kind: EventKind) {
    if let Some(observer) = observer {
        observer(&Event { time, kind });
    }
}
