//! The force of a held slider contains no rounding of coordinates: after a hold, the motion is the
//! same far from the origin as near it, for any rows, and after a saved state.

use crate::blocks::column;
use crate::common::*;
use vibro_machine::derivative::Gradient;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Differentiated, Motion, Quantity, What};

/// Roundings of a time of order one second, s: of an event and of the sub-steps before it.
const TIME: f64 = 1e-15;
/// Rounding of coordinate and rate after 64 events in 10 s.
const LATER: f64 = 1e-12;
/// Roundings of 1200 s in some thousand sub-steps, relative.
const LONG: f64 = 1e-14;
/// Roundings of a derivative over some events, relative.
const DERIVATIVE: f64 = 1e-10;

/// Times and forces of `slip` and `stick`.
fn slips(events: &[Event]) -> Vec<(f64, f64)> {
    let of = |event: &Event| match event.kind {
        EventKind::Yield { force, .. } | EventKind::Hold { force, .. } => Some((event.time, force)),
        _ => None,
    };
    events.iter().filter_map(of).collect()
}

/// The events of a motion in rows of equal length.
fn in_rows(m: &mut Motion, end: f64, rows: u32) -> Vec<Event> {
    let begin = m.time();
    let row = |i: u32| begin + (end - begin) * f64::from(i) / f64::from(rows);
    (1..=rows).flat_map(|i| events(m, row(i))).collect()
}

/// 1 kg on 100 N/m swings past a bristle. After a reversal at s, a held bristle of stiffness j and
/// level R lets the mass swing with ω² = 100 + j about its equilibrium, at a distance A = (100 s +
/// R)/ω²: the force falls by 2 R after ω τ = 2 asin √(R/(j A)). Coordinates at 10 s: the same law
/// in 60 digits.
#[test]
fn closed_form_a_stiff_bristle_slips_again_at_its_level() {
    let exact: [(f64, f64, f64, f64); 2] = [
        (1e12, 1e-9, -0.05063656378827868, 0.8623188668194797),
        (1e9, 1e-6, -0.05063624141375845, 0.8623134040835734),
    ];
    for (stiffness, slip, place, rate) in exact {
        let text = format!(
            r#"
            name = "Stiff"
            body.m = {{ mass = 1.0, start = {{ v = 1.0 }} }}
            spring.mount = {{ between = ["ground", "m"], stiffness = 100.0 }}
            spring.bristle = {{ between = ["ground", "m"], stiffness = {stiffness:e}, slip = {slip:e} }}
        "#
        );
        for rows in [1, 7, 1000] {
            let mut m = moving(&text);
            let found = slips(&in_rows(&mut m, 10.0, rows));
            assert_eq!(found.len(), 65, "{found:?}");
            let levels =
                found.iter().enumerate().map(|(i, own)| (own.1, slip * [1.0, 1.0, -1.0, -1.0][i % 4]));
            levels.for_each(|(force, level)| assert_eq!(force, level));
            // The first reversal: 100 s² + 2 R s = v².
            let turn = (0.01 + (slip / 100.0).powi(2)).sqrt() - slip / 100.0;
            let omega = f64::sqrt(100.0 + stiffness);
            let away = (100.0 * turn + slip) / (omega * omega);
            let held = 2.0 * (slip / (stiffness * away)).sqrt().asin() / omega;
            near(found[2].0 - found[1].0, held, TIME);
            near(column(&m, "m.s"), place, LATER);
            near(column(&m, "m.v"), rate, LATER);
        }
    }
}

/// A mass of 1 kg on a bristle under 3 N, and -6 N more from `knot` on, from a given position.
fn pushed(stiffness: f64, knot: f64, place: f64) -> String {
    format!(
        r#"
        name = "Pushed"
        body.m = {{ mass = 1.0, start = {{ s = {place:?} }} }}
        spring.bristle = {{ between = ["ground", "m"], stiffness = {stiffness:e}, slip = 2.0, slider = {place:?} }}
        load.push = {{ on = "m", constant = 3.0, steps = [[{knot:?}, -6.0]] }}
    "#
    )
}

/// Times of stick and slip after the step, and coordinate and rate at the end, of [`pushed`] from
/// 0 on: from rest the mass swings about 3 N until the bristle carries 2 N, accelerates with 1
/// m/s² until the step, decelerates with 5 m/s², and swings about -3 N until the bristle carries
/// -2 N.
fn exactly(stiffness: f64, knot: f64, end: f64) -> [f64; 4] {
    let omega = stiffness.sqrt();
    let begin = (1.0 / 3.0f64).acos() / omega;
    let fall = knot - begin;
    let speed = 3.0 / omega * (omega * begin).sin() + fall;
    let turn = 2.0 / stiffness + (speed - fall) * fall + 0.5 * fall * fall + 0.1 * speed * speed;
    let (stick, held) = (knot + speed / 5.0, 0.2f64.acos() / omega);
    let (left, from) = (end - stick - held, -5.0 / omega * (omega * held).sin());
    [stick, stick + held, turn - 4.0 / stiffness + from * left - 0.5 * left * left, from - left]
}

/// At a distance of 600 km and 6 km: the force k (e - x) would have a rounding of 1e-5 N there.
#[test]
fn closed_form_far_away_a_slider_sticks_and_slips_at_its_level() {
    for (stiffness, knot) in [(1e5, 1000.0), (1e7, 100.0)] {
        let end = 2.5 * knot;
        let [stick, slip, place, rate] = exactly(stiffness, knot, end);
        let check = |found: &[Event], m: &Motion| {
            let found = slips(found);
            assert_eq!(found.iter().map(|own| own.1).collect::<Vec<_>>(), [2.0, 2.0, -2.0]);
            near(found[1].0, stick, LONG * stick);
            near(found[2].0 - found[1].0, slip - stick, LONG * stick);
            near(column(m, "m.v"), rate, LONG * knot);
            near(column(m, "m.s"), place, LONG * knot * knot);
        };
        for rows in [1, 7, 1000] {
            let mut m = moving(&pushed(stiffness, knot, 0.0));
            check(&in_rows(&mut m, end, rows), &m);
        }
        // Saved while the slider is held, and continued.
        let mut m = moving(&pushed(stiffness, knot, 0.0));
        let mut found = events(&mut m, 0.5 * (stick + slip));
        let mut on = Motion::resumed(m.assembly().clone(), &m.save()).unwrap();
        assert_eq!(column(&on, "bristle.f"), column(&m, "bristle.f"));
        found.extend(events(&mut on, end));
        check(&found, &on);
    }
}

/// Three masses in a row at a given position: on a slider, a series dashpot and a slider.
fn row(place: f64) -> String {
    let between = |name: &str, ends: &str, partner: &str| {
        format!("spring.{name} = {{ between = {ends}, stiffness = 1e4, {partner}, slider = ")
    };
    let [first, soft, last] = [
        between("first", r#"["ground", "a"]"#, "slip = 0.5") + &format!("{place:?} }}"),
        between("soft", r#"["a", "b"]"#, "series_damping = 20.0") + "0.0 }",
        between("last", r#"["b", "c"]"#, "slip = 2.0") + "0.0 }",
    ];
    let body = |name: &str| format!("body.{name} = {{ mass = 1.0, start = {{ s = {place:?} }} }}");
    let bodies = ["a", "b", "c"].map(body).join("\n");
    let load = r#"load.push = { on = "c", amplitude = 9.0, frequency = 0.7 }"#;
    format!("name = \"Row\"\n{bodies}\n{first}\n{soft}\n{last}\n{load}\n")
}

/// The position of a machine does not matter: events, forces, losses, derivatives and the gradient
/// are the same at 2⁴³ m, where 1e4 N/m times a rounding of the coordinate is 10 N.
#[test]
fn metamorphic_a_place_far_away_changes_no_event_and_no_derivative() {
    let names = ["spring.first.stiffness", "spring.first.slip", "spring.soft.series_damping", "body.b.mass"];
    let rate = Quantity::of_body(2, What::V);
    let found = [0.0, 2f64.powi(43)].map(|place| {
        let assembly = assembled(&row(place));
        let mut m = Differentiated::new(assembly.clone(), &names).unwrap();
        let mut all = Vec::new();
        m.advance_observed(2.5, &mut |event, by| {
            all.push(event.time);
            all.extend(by.iter().map(|by| by.unwrap()));
        })
        .unwrap();
        let mut gradient = Gradient::new(assembly, &names).unwrap();
        gradient.advance_to(2.5).unwrap();
        gradient.add(rate, 1.0);
        all.extend((0..names.len()).map(|p| m.derivative(rate, p).unwrap()));
        all.extend(gradient.gradient().unwrap().into_iter().map(Result::unwrap));
        all.extend(["first.f", "soft.f", "last.f", "c.v"].map(|name| column(m.motion(), name)));
        all.extend(m.motion().energy().branches.iter().map(|lost| lost.value()));
        all
    });
    assert!(found[0].len() > 60, "{found:?}");
    assert_eq!(found[0].len(), found[1].len());
    found[0].iter().zip(&found[1]).for_each(|(a, b)| near(*a, *b, DERIVATIVE * (1.0 + a.abs())));
}

/// A changed machine keeps its inner coordinates: with another stiffness the force is k (e - x).
#[test]
fn closed_form_a_changed_stiffness_acts_from_the_inner_place() {
    let text = pushed(100.0, 5.0, 1.0).replace("slip = 2.0", "slip = 20.0");
    let mut m = moving(&text);
    m.advance_to(0.1).unwrap();
    let stretch = 0.03 * (1.0 - 1.0f64.cos());
    near(column(&m, "bristle.f"), 100.0 * stretch, TIME);
    let d = m.assembly().description.with([("spring.bristle.stiffness", 400.0)]).unwrap();
    let m = m.changed(assembled(&d.to_toml())).unwrap();
    assert_eq!(column(&m, "bristle.slider"), 1.0);
    near(column(&m, "bristle.f"), 400.0 * stretch, TIME);
}
