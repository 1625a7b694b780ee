//! Classification of each element from its values, before any order is solved.

use super::{EventVerdict, Friction, Selection, Slider, SliderFlag, Stop, slid, slipping};
use crate::description::StopLaw;
use crate::functional::StateRow;
use crate::mode::{FrictionState, SliderState, StopState};

impl Selection<'_> {
    /// Returns the sign -1, 0 or 1 of a row's derivative of an order; 0 if it is only rounding.
    pub(super) fn sign(&self, row: &StateRow, order: usize) -> f64 {
        let value = row.dot(&self.derivatives[order]);
        if value.abs() <= self.sizes[order].zero(row) { 0.0 } else { value.signum() }
    }

    pub(super) fn classify_stop(&self, i: usize, verdict: &EventVerdict) -> Stop {
        let stop = &self.system.stops[i];
        if let Some(state) = self.system.configured_stop(i) {
            return Stop::Is(state);
        }
        if stop.is_off(&self.derivatives[0]) {
            return Stop::Is(StopState::Off);
        }
        if stop.is_gapless() {
            return Stop::Is(StopState::Pressed);
        }
        let excess = self.sign(&stop.excess, 0);
        if stop.limit.is_some() && (verdict.edges[i] || excess == 0.0) {
            return Stop::AtEdge;
        }
        let rate = self.sign(&stop.elongation.rate, 0);
        if stop.is_freewheel {
            return if verdict.stops[i] || rate >= 0.0 { Stop::Touching } else { Stop::Is(StopState::Open) };
        }
        if let StopLaw::Rigid { .. } = stop.law {
            return match (verdict.stops[i] || excess >= 0.0, rate) {
                (false, _) => Stop::Is(StopState::Open),
                _ if verdict.open.contains(&i) => Stop::Is(StopState::Open),
                (true, rate) if rate < 0.0 => Stop::Is(StopState::Open),
                (true, _) => Stop::Touching,
            };
        }
        if verdict.edges[i] || (excess == 0.0 && !verdict.limits[i]) {
            if rate > 0.0 {
                return Stop::Is(stop.entered());
            }
            if rate < 0.0 {
                return Stop::Is(StopState::Below);
            }
            // A stop that has drifted by more than rounding is no longer at its edge.
            if excess == 0.0 {
                return Stop::AtEdge;
            }
        }
        if excess < 0.0 {
            return Stop::Is(StopState::Below);
        }
        // Without stiffness the force does not show where it ends.
        if stop.level.is_some() && !stop.is_damped() {
            return Stop::Is(StopState::Pressed);
        }
        let Some(limited) = stop.limited() else {
            return match rate {
                _ if !stop.turns() => Stop::Is(StopState::Pressed),
                _ if verdict.limits[i] || rate == 0.0 => Stop::Turning,
                rate if rate > 0.0 => Stop::Is(StopState::Pressed),
                _ => Stop::Is(StopState::Rebounding),
            };
        };
        let pull = self.sign(limited, 0);
        if pull < 0.0 && !verdict.limits[i] {
            return Stop::Is(StopState::Free);
        }
        if stop.is_elastogap() {
            let cap = self.sign(&(&*stop.force - 2.0 * &*stop.spring), 0);
            if cap > 0.0 && !verdict.limits[i] {
                return Stop::Is(StopState::Capped);
            }
            if cap == 0.0 && pull == 0.0 {
                return Stop::AtLimits;
            }
            if cap == 0.0
                || (verdict.limits[i]
                    && stop.force.dot(&self.derivatives[0]) > stop.spring.dot(&self.derivatives[0]))
            {
                return Stop::AtLimit(StopState::Capped, StopState::Pressed);
            }
        }
        if pull == 0.0 || verdict.limits[i] {
            return Stop::AtLimit(StopState::Pressed, StopState::Free);
        }
        Stop::Is(StopState::Pressed)
    }

    /// Classifies a branch by its force, e' and the event. A branch with a dashpot has no slider.
    pub(super) fn classify_slider(&self, i: usize, flag: SliderFlag, verdict: &EventVerdict) -> Slider {
        let branch = &self.system.branches[i];
        if let Some(state) = self.system.configured_slider(i) {
            return Slider::Is(state);
        }
        let Some(level) = self.system.slip_level(i) else { return Slider::Is(SliderState::Held) };
        if let Some(stop) = branch.stop() {
            return self.classify_contact(i, flag, (stop, verdict.edges[stop]));
        }
        let is_at = |direction: f64| self.sign(&(&(direction * &branch.force) - level), 0) >= 0.0;
        let by_value = [1.0, -1.0].into_iter().find(|direction| is_at(*direction));
        let direction = if flag.level == 0.0 { by_value.unwrap_or(0.0) } else { flag.level };
        if direction == 0.0 {
            return Slider::Is(SliderState::Held);
        }
        let rate = if flag.turns { 0.0 } else { self.sign(&branch.elongation.rate, 0) };
        if rate == 0.0 { Slider::AtLevel(direction) } else { slid(direction, rate) }
    }

    /// Classifies a friction by its level, e' and the event.
    pub(super) fn classify_friction(&self, i: usize, resting: bool) -> Friction {
        let friction = &self.system.frictions[i];
        let rate = self.sign(&friction.elongation.rate, 0);
        let rests = rate == 0.0 || resting;
        if friction.follows.is_some() {
            // The level is found with the stop's state.
            return if rests { Friction::Resting(usize::MAX) } else { Friction::Is(slipping(rate)) };
        }
        let mut level = (*friction.levels[0].level).clone();
        let mut order = 0;
        // The level is a signal: all its derivatives are known.
        let sign = loop {
            let sign = self.sign(&level, 0);
            if sign != 0.0 || order >= self.system.signals.size {
                break sign;
            }
            level = self.system.signals.derivative(&level);
            order += 1;
        };
        if sign <= 0.0 {
            return Friction::Is(FrictionState::Off);
        }
        if rests { Friction::Resting(order) } else { Friction::Is(slipping(rate)) }
    }
}
