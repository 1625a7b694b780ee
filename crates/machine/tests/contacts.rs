//! Contacts with an exponent and a dissipation, and powers with two sides.

use std::sync::Arc;
use vibro_machine::Assembly;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::{Event, EventKind, Motion};

fn machine(text: &str) -> Arc<Assembly> {
    let description = parse(text, "m.toml", &no_records).expect("a machine");
    Arc::new(Assembly::new(description).expect("an assembly"))
}

/// Γ(7/5)/Γ(9/10) √π from 40 digits: the duration of a Hertz impact is 2 xₘ/v times this.
const HERTZ: f64 = 1.471_637_592_162_352_3;
/// Relative rounding of a duration and a depth after some hundred series.
const IMPACT: f64 = 1e-13;

/// A body meets a Hertz contact without other forces: the duration 2 xₘ/v √π Γ(7/5)/Γ(9/10), and
/// the depth xₘ = (5 m v²/(4 k))^(2/5), in machines of any scale.
#[test]
fn closed_form_duration_and_depth_of_a_hertz_impact() {
    for (mass, k, v) in [(0.3_f64, 2e6_f64, 1.7_f64), (1e-3, 1e9, 20.0), (2e3, 1e4, 0.01)] {
        let text = format!(
            "name = \"Hertz\"\nbody.b = {{ mass = {mass:e}, start = {{ v = {v} }} }}\n\
             stop.h = {{ between = [\"ground\", \"b\"], gap = 0.0, stiffness = {k:e}, exponent = 1.5 }}\n"
        );
        let depth = (1.25 * mass * v * v / k).powf(0.4);
        let duration = 2.0 * depth / v * HERTZ;
        let mut motion = Motion::new(machine(&text)).expect("a motion");
        motion.advance_to(0.5 * duration).expect("an end");
        let off = (motion.body(0)[0] / depth - 1.0).abs();
        assert!(off < IMPACT, "{off:e} of the depth in {text}");
        let mut times = Vec::new();
        let mut note = |event: &Event| {
            if let EventKind::Free { .. } = event.kind {
                times.push(event.time);
            }
        };
        motion.advance_observed(2.0 * duration, &mut note).expect("an end");
        let off = (times[0] / duration - 1.0).abs();
        assert!(times.len() == 1 && off < IMPACT, "{off:e} of the duration in {text}");
        let off = (motion.body(0)[1] / v + 1.0).abs();
        assert!(off < IMPACT, "{off:e} of the speed in {text}");
    }
}
