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

#[cfg(test)]
mod tests {
    use super::growth;
    use vibro_machine::Assembly;
    use vibro_machine::file::{no_records, parse};

    /// The stiffness in slip upwards, ((160, -40), (20, 170)) N/m on 1 kg, has the eigenvalues
    /// 165 ± √(5² - 800): the rate is the real part of √(-165 ± 27.84 i), 1.0798 1/s at 2.0516 Hz.
    /// Downwards the product of the couplings is positive, and nothing grows.
    #[test]
    fn closed_form_slip_grows_where_friction_turns_the_coupling() {
        let text = r#"
            name = "Squeal"
            body.n = { mass = 1.0 }
            body.t = { mass = 1.0 }
            spring.n = { between = ["ground", "n"], stiffness = 20.0 }
            spring.t = { between = ["ground", "t"], stiffness = 130.0 }
            spring.nt = { between = ["n", "t"], stiffness = 40.0 }
            contact.pad = { normal = ["ground", "n"], tangent = ["ground", "t"], gap = 0.0, stiffness = 100.0, tangential_stiffness = 80.0, friction = 0.6 }
        "#;
        let assembly = Assembly::new(parse(text, "squeal.toml", &no_records).unwrap()).unwrap();
        let lines = growth(&assembly);
        let exact = "contact.pad: slip up grows by 1.07982 1/s at 2.05159 Hz while the other contacts stick";
        assert_eq!(lines, [exact]);
    }
}
