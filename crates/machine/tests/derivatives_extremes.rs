//! Extreme values of quantities and their derivatives, compared with closed forms.

use std::sync::Arc;
use vibro_machine::derivative::{Cause, Extreme, Extremes, Lost};
use vibro_machine::{Assembly, Differentiated, Quantity, What, file};

/// Relative rounding of some hundred operations.
const ROUNDING: f64 = 1e-11;

fn extremes(text: &str, columns: &[&str], end: f64) -> [Extremes; 2] {
    let machine = file::parse(text, "machine.toml", &file::no_records).unwrap();
    let mut motion = Differentiated::new(Arc::new(Assembly::new(machine).unwrap()), columns).unwrap();
    let mut found = [What::S, What::V].map(|what| Extremes::new(Quantity::of_body(0, what)));
    // In two parts; the first one ends at an arbitrary time.
    motion.advance_with_extremes(0.37 * end, &mut found, &mut |_, _| ()).unwrap();
    motion.advance_with_extremes(end, &mut found, &mut |_, _| ()).unwrap();
    found
}

#[track_caller]
fn close(found: Option<&Extreme>, value: f64, by: &[f64]) {
    let found = found.unwrap();
    assert!((found.value - value).abs() < ROUNDING, "{found:?} instead of {value}");
    for (found, exact) in found.by.iter().zip(by) {
        assert!((found.as_ref().unwrap() - exact).abs() < ROUNDING, "{found:?} instead of {exact}");
    }
}

fn ball(restitution: f64) -> String {
    format!(
        "name = \"Ball\"\ngravity = 9.0\n[body.ball]\nmass = 0.5\ngravity = 1.0\n\
         [stop.floor]\nbetween = [\"ground\", \"ball\"]\ngap = 2.0\nrestitution = {restitution:?}\n"
    )
}

#[test]
fn closed_form_a_ball_is_fastest_at_its_impact_and_deepest_there() {
    let columns = ["stop.floor.gap", "gravity", "stop.floor.restitution"];
    let [place, rate] = extremes(&ball(0.75), &columns, 2.5);
    let (h, g, e) = (2.0f64, 9.0, 0.75);
    let speed = (2.0 * g * h).sqrt();
    // The extreme is attained at every impact, with the same derivatives: at the gap.
    close(place.highest(), h, &[1.0, 0.0, 0.0]);
    close(place.lowest(), 0.0, &[0.0, 0.0, 0.0]);
    close(rate.highest(), speed, &[g / speed, h / speed, 0.0]);
    close(rate.lowest(), -e * speed, &[-e * g / speed, -e * h / speed, -speed]);
}

#[test]
fn closed_form_a_turn_within_a_flight() {
    // s = v/ω sin ωt has its maximum at ωt = π/2, where the rate is 0.
    let text = "name = \"V\"\n[body.a]\nmass = 0.5\nstart = { v = 0.3 }\n\
                [spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 8.0\n";
    let columns = ["spring.k.stiffness", "body.a.mass", "body.a.start.v"];
    let [place, rate] = extremes(text, &columns, 1.0);
    let (m, k, v) = (0.5f64, 8.0f64, 0.3);
    let top = v * (m / k).sqrt();
    close(place.highest(), top, &[-0.5 * top / k, 0.5 * top / m, top / v]);
    assert!((place.highest().unwrap().time - 0.125 * std::f64::consts::PI).abs() < 1e-7);
    close(rate.highest(), v, &[0.0, 0.0, 1.0]);
    close(rate.lowest(), -v, &[0.0, 0.0, -1.0]);
}

#[test]
fn an_extreme_value_at_several_times_has_a_derivative_where_they_move_alike() {
    // Without losses the ball comes back to its start.
    let [place, _] = extremes(&ball(1.0), &["stop.floor.restitution", "stop.floor.gap"], 2.5);
    let lowest = place.lowest().unwrap();
    let Err(Lost { element, cause, .. }) = &lowest.by[0] else { panic!("{lowest:?}") };
    assert_eq!((element.as_str(), *cause), ("ball.s", Cause::Equal));
    assert!(lowest.by[1].as_ref().unwrap().abs() < ROUNDING);
}
