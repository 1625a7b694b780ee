//! Contacts with friction whose slip grows on its own, as in squeal.

use super::{ZERO, short};
use std::f64::consts::TAU;
use vibro_machine::Assembly;
use vibro_machine::mode::{FrictionState, Mode, SliderState, StopState};
use vibro_machine::system::StopRows;
use vibro_studies::natural::natural;

/// A line for each contact whose slip in a direction has a growing oscillation, while all other
/// contacts with friction are closed and stick.
pub(super) fn growth(assembly: &Assembly) -> Vec<String> {
    let system = assembly.system();
    let mut stops: Vec<StopState> = system.stops.iter().map(StopRows::state_apart).collect();
    system.branches.iter().filter_map(|own| own.stop()).for_each(|stop| stops[stop] = StopState::Pressed);
    let places: Vec<usize> = (0..system.states()).collect();
    let mut lines = Vec::new();
    for (i, _) in system.branches.iter().enumerate().filter(|(_, own)| own.stop().is_some()) {
        for (state, word) in [(SliderState::Up, "up"), (SliderState::Down, "down")] {
            let mut sliders = vec![SliderState::Held; system.branches.len()];
            sliders[i] = state;
            let frictions = vec![FrictionState::Off; system.frictions.len()];
            let mode = Mode { stops: stops.clone(), frictions, sliders, basis: Vec::new() };
            let values = natural(system, &system.linear(&mode), &places).values;
            let largest = values.iter().map(|value| value.norm()).fold(0.0, f64::max);
            let most = values.iter().max_by(|a, b| a.re.total_cmp(&b.re));
            if let Some(most) = most.filter(|most| most.re > ZERO * largest) {
                lines.push(format!(
                    "{}: slip {word} grows by {} 1/s at {} Hz while the other contacts stick",
                    assembly.name_of_branch(i),
                    short(most.re),
                    short(most.im.abs() / TAU)
                ));
            }
        }
    }
    lines
}
