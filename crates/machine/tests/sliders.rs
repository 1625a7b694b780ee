//! Springs in series with a slider (Jenkins element, elastic-perfectly-plastic) compared with
//! closed forms and second methods.

use crate::common::*;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use vibro_machine::derivative::{By, Gradient};
use vibro_machine::description::{Series, SeriesLaw};
use vibro_machine::file::{no_records, parse};
use vibro_machine::mode::SliderState;
use vibro_machine::motion::{Event, EventKind, Reached};
use vibro_machine::system::BranchLaw;
use vibro_machine::{Assembly, Differentiated, Motion, Quantity, Start, What};

/// A hundred roundings of numbers of order one.
const ROUNDING: f64 = 1e-13;

fn words(events: &[Event]) -> Vec<&'static str> {
    let word = |event: &Event| match event.kind {
        EventKind::Yield { direction, .. } => {
            if direction > 0.0 {
                "up"
            } else {
                "down"
            }
        }
        EventKind::Hold { .. } => "stick",
        EventKind::Impact { .. } => "impact",
        EventKind::Knot => "knot",
        _ => "other",
    };
    events.iter().map(word).collect()
}

/// A prescribed elongation X sin ωt: the closed loop loses 4 slip (X - slip/k) per cycle;
/// slipping ends where e' reverses and begins again after the distance 2 slip/k.
#[test]
fn closed_form_the_loop_of_a_jenkins_element() {
    let mut m = motion(machine(
        r#"
        name = "Loop"
        body.foot = { motion = { amplitude = 0.3, frequency = 2.0 } }
        body.box = { mass = 1.0 }
        spring.joint = { between = ["ground", "foot"], stiffness = 200.0, slip = "20 N", damping = 0.7 }
        spring.k = { between = ["ground", "box"], stiffness = 1.0 }
    "#,
    ));
    let (k, slip, x, f): (f64, f64, f64, f64) = (200.0, 20.0, 0.3, 2.0);
    let found = events(&mut m, 0.7);
    assert_eq!(words(&found), ["up", "stick", "down", "stick", "up", "stick"]);
    let omega = TAU * f;
    let second = (PI - ((x - 2.0 * slip / k) / x).asin()) / omega;
    let times = [(slip / k / x).asin() / omega, 0.125, second, 0.375, second + 0.25, 0.625];
    assert!(found.iter().zip(times).all(|(event, exact)| (event.time - exact).abs() < ROUNDING));
    for event in &found {
        let (EventKind::Yield { force, .. } | EventKind::Hold { force, .. }) = event.kind else { panic!() };
        assert!((force.abs() - slip).abs() < 100.0 * ROUNDING, "{force}");
    }
    // f is the total force: b plus the damping times e'.
    assert!(
        (of(&m, 0, What::F) - (slip - k * (x - of(&m, 0, What::E)) + 0.7 * of(&m, 0, What::Rate))).abs()
            < 1e-11
    );
    let before = m.energy().branches[0].value();
    m.advance_to(1.2).unwrap();
    let lost = m.energy().branches[0].value() - before;
    assert!((lost - 4.0 * slip * (x - slip / k)).abs() < 1e-11, "{lost}");
}

/// m s'' + f = F from rest, elastic up to the yield force R and perfectly plastic beyond: elastic
/// until cos ωt = 1 - R/F, then s'' = (F - R)/m until the rate is zero, then a sine about the
/// plastic offset.
#[test]
fn published_an_elastic_perfectly_plastic_oscillator_under_a_suddenly_applied_force() {
    let mut m = motion(machine(
        r#"
        name = "Frame"
        body.floor = { mass = 0.0259 }
        spring.frame = { between = ["ground", "floor"], stiffness = 83.4, slip = 45.286 }
        load.push = { on = "floor", constant = 30.0 }
    "#,
    ));
    let found = events(&mut m, 0.25);
    assert_eq!(words(&found)[..2], ["up", "stick"]);
    let (mass, k, yield_, force): (f64, f64, f64, f64) = (0.0259, 83.4, 45.286, 30.0);
    let omega = (k / mass).sqrt();
    let begin = (1.0 - yield_ / force).acos() / omega;
    let speed = force / k * omega * (omega * begin).sin();
    let slowing = (yield_ - force) / mass;
    let turn = begin + speed / slowing;
    let most = yield_ / k + 0.5 * speed * speed / slowing;
    assert!((found[0].time - begin).abs() < ROUNDING && (found[1].time - turn).abs() < ROUNDING);
    // The published case, to the given digits.
    assert!((turn - 0.0668622).abs() < 1e-7 && (most - 0.804337).abs() < 1e-6, "{turn} {most}");
    let least = most - 2.0 * (yield_ - force) / k;
    assert!((least - 0.437766).abs() < 1e-6, "{least}");
    let mut m = motion(m.assembly().description.clone());
    m.advance_to(turn + PI / omega).unwrap();
    assert!((m.coordinate(0) - least).abs() < 1e3 * ROUNDING && m.rate(0).abs() < 1e-10);
    assert!((of(&m, 0, What::Slider(None)) - (most - yield_ / k)).abs() < 1e3 * ROUNDING);
}

/// An Iwan joint: four parallel sliders on one body, with a wall and a spring.
const IWAN: &str = r#"
    name = "Iwan"
    body.box = { mass = 1.5, start = { v = 1.0 } }
    spring.a = { between = ["ground", "box"], stiffness = 100.0, slip = 2.0, damping = 0.3 }
    spring.b = { between = ["ground", "box"], stiffness = 90.0, slip = 4.0 }
    spring.c = { between = ["ground", "box"], stiffness = 80.0, slip = 6.0 }
    spring.d = { between = ["ground", "box"], stiffness = 70.0, slip = 8.0, slider = 0.01 }
    spring.k = { between = ["ground", "box"], stiffness = 40.0 }
    stop.wall = { between = ["ground", "box"], gap = 0.11, restitution = 0.8 }
    load.push = { on = "box", amplitude = 14.0, frequency = 1.1 }
"#;

/// By Masing's rule and return-point memory, the joint's force is a sum of clamped elements. The
/// test steps e and updates each b by k Δe, limited to ±slip.
#[test]
fn second_method_an_iwan_joint_is_its_sliders_stepped() {
    let mut m = motion(machine(IWAN));
    let begin = unaccounted(&m);
    let elements = [(100.0, 2.0), (90.0, 4.0), (80.0, 6.0), (70.0, 8.0)];
    let mut forces = [0.0, 0.0, 0.0, -0.7];
    let (mut e, steps) = (0.0, 40_000);
    let mut met = 0;
    for i in 1..=steps {
        m.advance_observed(4.0 * f64::from(i) / f64::from(steps), &mut |_| met += 1).unwrap();
        let change = m.coordinate(0) - e;
        e += change;
        for (b, (k, slip)) in forces.iter_mut().zip(elements) {
            *b = (*b + k * change).clamp(-slip, slip);
        }
    }
    for (i, b) in forces.iter().enumerate() {
        let damping = if i == 0 { 0.3 * m.rate(0) } else { 0.0 };
        // If e' reverses between two steps, the error is proportional to the square of the step.
        assert!((of(&m, i, What::F) - damping - b).abs() < 1e-4, "{i}: {b}");
    }
    assert!(met > 40, "{met}");
    assert!((unaccounted(&m) - begin).abs() < 1e-10);
}

#[test]
fn second_method_series_of_actual_states_and_the_general_law_are_the_tables_and_lone_events() {
    let [mut one, mut other] = [IWAN.to_owned(), with_company(IWAN)].map(|text| motion(machine(&text)));
    let mut general = motion(machine(IWAN)).by_general_law();
    let exact = events(&mut one, 3.0);
    for m in [&mut other, &mut general] {
        let found = events(m, 3.0);
        assert_eq!(words(&found), words(&exact));
        for (a, b) in found.iter().zip(&exact) {
            assert!((a.time - b.time).abs() < 1e-9, "{a:?} {b:?}");
        }
        assert!((m.coordinate(0) - one.coordinate(0)).abs() < 1e-9);
        for i in 0..4 {
            assert!((of(m, i, What::Slider(None)) - of(&one, i, What::Slider(None))).abs() < 1e-9);
        }
    }
}

/// An impact that reverses e' ends the slip.
#[test]
fn closed_form_an_impact_ends_a_slip() {
    let mut m = motion(machine(
        r#"
        name = "Hit"
        body.box = { mass = 1.0, start = { v = 2.0 } }
        spring.joint = { between = ["ground", "box"], stiffness = 100.0, slip = 1.0 }
        stop.wall = { between = ["ground", "box"], gap = 0.1, restitution = 0.5 }
    "#,
    ));
    let found = events(&mut m, 0.1);
    assert_eq!(words(&found), ["up", "impact", "stick", "down"]);
    let EventKind::Hold { force, .. } = found[2].kind else { panic!() };
    assert!((force - 1.0).abs() < ROUNDING && found[2].time == found[1].time);
    // From the wall back over 2 slip/k, the force falls to -slip.
    let slips: Vec<f64> = found.iter().map(|event| event.time).collect();
    let u = (4.0f64 - 2.0 * (0.005 + 0.09)).sqrt() * 0.5;
    // m s'' = -k (s - 0.1) - 1 after the impact: amplitude about 0.09.
    let (omega, c) = (10.0, 0.01);
    let back = slips[3] - slips[1];
    let place = 0.1 - c + c * (omega * back).cos() - u / omega * (omega * back).sin();
    assert!((place - 0.08).abs() < 1e-12, "{place}");
}

/// A step of a prescribed position changes the force by k Δe, limited to ±slip; the slider's loss
/// is in its account.
#[test]
fn closed_form_a_step_of_a_prescribed_place_is_cut_off() {
    let text = r#"
        name = "Step"
        body.foot = { motion = { steps = [[0.1, 0.05], [0.2, 0.3], [0.3, -0.1], [0.4, -0.2]] } }
        body.box = { mass = 1.0 }
        spring.joint = { between = ["ground", "foot"], stiffness = 100.0, slip = 10.0 }
        spring.k = { between = ["ground", "box"], stiffness = 1.0 }
    "#;
    let mut m = motion(machine(text));
    let (mut lost, mut slider) = (0.0, 0.0);
    for (time, force, place) in [(0.15, 5.0, 0.0), (0.25, 10.0, 0.25), (0.35, 0.0, 0.25), (0.45, -10.0, 0.15)]
    {
        m.advance_to(time).unwrap();
        lost += 10.0 * f64::abs(place - slider);
        slider = place;
        assert!((of(&m, 0, What::F) - force).abs() < 1e-12, "{time}: {}", of(&m, 0, What::F));
        assert!((of(&m, 0, What::Slider(None)) - place).abs() < ROUNDING);
        assert!((m.energy().branches[0].value() - lost).abs() < 1e-12);
        assert!(unaccounted(&m).abs() < 1e-12);
    }
    // The unlimited part is k Δe, from an x that does not change.
    let names = ["body.foot.motion.steps[0].height", "spring.joint.stiffness", "spring.joint.slider"];
    let mut by = Differentiated::new(m.assembly().clone(), &names).unwrap();
    by.advance_to(0.15).unwrap();
    let [f, slider] = [What::F, What::Slider(None)].map(|what| Quantity::of_element(0, what));
    for (p, exact) in [[100.0, 0.0], [0.05, 0.0], [-100.0, 1.0]].into_iter().enumerate() {
        for (quantity, exact) in [f, slider].into_iter().zip(exact) {
            assert!((by.derivative(quantity, p).unwrap() - exact).abs() < 100.0 * ROUNDING, "{p} {exact}");
        }
    }
    // The heights change the limited part: b stays ±slip, and x follows the heights.
    let names = ["body.foot.motion.steps[1].height", "body.foot.motion.steps[3].height", "spring.joint.slip"];
    let mut by = Differentiated::new(m.assembly().clone(), &names).unwrap();
    by.advance_to(0.25).unwrap();
    let column = |by: &Differentiated, q| (0..3).map(|p| by.derivative(q, p).unwrap()).collect::<Vec<_>>();
    assert_eq!(column(&by, f), [0.0, 0.0, 1.0]);
    assert_eq!(column(&by, slider), [1.0, 0.0, -0.01]);
    by.advance_to(0.45).unwrap();
    assert_eq!(column(&by, f), [0.0, 0.0, -1.0]);
    for (found, exact) in column(&by, slider).iter().zip([1.0, 1.0, 0.01]) {
        assert!((found - exact).abs() < ROUNDING, "{found} {exact}");
    }
}

/// If |k e(0)| > slip, x moves to the nearest admissible value, for starts of all kinds.
#[test]
fn closed_form_starts_are_moved_to_the_nearest_place() {
    let text = IWAN.replace("start = { v = 1.0 }", "start = { s = 0.1, v = -1.0 }");
    let m = motion(machine(&text));
    for (i, (k, slip, x)) in
        [(100.0, 2.0, 0.0), (90.0, 4.0, 0.0), (80.0, 6.0, 0.0), (70.0, 8.0, 0.01)].into_iter().enumerate()
    {
        let x: f64 = if k * (0.1 - x) > slip { 0.1 - slip / k } else { x };
        assert!((of(&m, i, What::Slider(None)) - x).abs() < ROUNDING, "{i}");
    }
    assert_eq!(m.mode().sliders[0], SliderState::Held);
    let mut start = Start::default();
    start.set(&m.assembly().description, "a.slider", -5.0).unwrap();
    let m = start.motion(m.assembly().clone()).unwrap();
    assert!((of(&m, 0, What::F) - 2.0 + 0.3).abs() < ROUNDING);
}

/// At rest, springs from 0 limited to ±slip: a, 10 N/m, and b, 20 N/m up to 3 N; 12 N at 0.9 m.
#[test]
fn closed_form_a_start_at_rest_is_elastic_and_plastic() {
    let text = r#"
        name = "Rest"
        start = "rest"
        body.box = { mass = 1.0 }
        spring.a = { between = ["ground", "box"], stiffness = 10.0 }
        spring.b = { between = ["ground", "box"], stiffness = 20.0, slip = 3.0 }
        load.push = { on = "box", constant = 12.0 }
    "#;
    for (load, s, slider, [by_load, by_slip, by_k]) in
        [(12.0, 0.9, 0.75, [0.1, -0.1, 0.0]), (3.0, 0.1, 0.0, [1.0 / 30.0, 0.0, -0.1 / 30.0])]
    {
        let d = machine(&text.replace("12.0", &format!("{load:?}")));
        let names = ["load.push.constant", "spring.b.slip", "spring.b.stiffness"];
        let mut m = Differentiated::new(Arc::new(Assembly::new(d).unwrap()), &names).unwrap();
        for time in [0.0, 0.4] {
            m.advance_to(time).unwrap();
            assert!((m.motion().coordinate(0) - s).abs() < ROUNDING, "{}", m.motion().coordinate(0));
            assert!((of(m.motion(), 1, What::Slider(None)) - slider).abs() < ROUNDING);
        }
        let m = Differentiated::new(m.motion().assembly().clone(), &names).unwrap();
        for (p, exact) in [by_load, by_slip, by_k].into_iter().enumerate() {
            let found = m.derivative(Quantity::of_body(0, What::S), p).unwrap();
            assert!((found - exact).abs() < ROUNDING, "{p}: {found} {exact}");
        }
    }
    // b alone carries 3 N, less than 14 N.
    let loose = text.replace("stiffness = 10.0", "stiffness = 0.0");
    assert!(Assembly::new(machine(&loose)).unwrap_err().to_string().contains("box"));
}

#[test]
fn second_method_derivatives_are_differences_of_motions_and_gradients_are_columns() {
    const DIFFERENCE: f64 = 1e-6;
    // Sliders with the same elongation reverse at the same instant, which requires columns.
    let one: String = IWAN
        .lines()
        .filter(|l| !["spring.a", "spring.b", "spring.c"].iter().any(|s| l.contains(s)))
        .map(|l| format!("{l}\n"))
        .collect();
    for (text, by_columns) in [(IWAN, true), (&one, false)] {
        let (d, end) = (machine(text), 1.7);
        let assembly = Arc::new(Assembly::new(d.clone()).unwrap());
        let states = assembly.system().states();
        let mut columns: Vec<By> = d.parameters().into_iter().map(|p| p.name.into()).collect();
        let given = columns.len();
        columns.extend((0..states).map(By::Start));
        let quantities: Vec<_> = d.quantities().collect();
        let mut exact = Differentiated::new(assembly.clone(), &columns).unwrap();
        exact.advance_to(end).unwrap();
        let mut sum = Gradient::new(assembly.clone(), &columns).unwrap();
        sum.advance_to(end).unwrap();
        quantities.iter().enumerate().for_each(|(i, &q)| sum.add(q, 1.0 - 0.3 * i as f64));
        assert_eq!(sum.is_by_columns(), by_columns);
        for (p, found) in sum.gradient().unwrap().iter().enumerate() {
            let terms = quantities.iter().enumerate();
            let terms = terms.map(|(i, &q)| (1.0 - 0.3 * i as f64) * exact.derivative(q, p).unwrap());
            let [sum, size] = terms.fold([0.0, 0.0], |[sum, size], x| [sum + x, size + x.abs()]);
            let found = found.as_ref().unwrap();
            assert!((found - sum).abs() <= 1e-12 * size, "{}: {found} {sum}", columns[p]);
        }
        for (p, by) in columns[..given].iter().enumerate() {
            let name = by.to_string();
            let value = d.get(&name).unwrap();
            let step = 1e-5 * value.abs().max(1e-2);
            let values = |k: f64| {
                let Ok(changed) = d.with([(name.as_str(), value + k * step)]) else {
                    return vec![f64::NAN; 99];
                };
                let mut m = motion(changed);
                m.advance_to(end).unwrap();
                quantities.iter().map(|&q| m.value(q)).collect::<Vec<f64>>()
            };
            let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(values);
            for (i, &quantity) in quantities.iter().enumerate() {
                let difference = (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * step);
                let found = exact.derivative(quantity, p).unwrap();
                let of_kind = quantities.iter().filter(|q| q.what == quantity.what);
                let size = of_kind.map(|&q| exact.derivative(q, p).unwrap().abs()).fold(1.0, f64::max);
                let is_near = difference.is_nan() || (found - difference).abs() < DIFFERENCE * size;
                assert!(is_near, "{name} {quantity:?}: {found} {difference}");
            }
        }
        // Variations are the derivatives with respect to the start.
        let mut m = Motion::new(assembly).unwrap();
        let mut variations = m.unit_variations();
        while m.advance_with(end, &mut variations).unwrap() == Reached::Event {}
        for (j, variation) in variations.iter().enumerate() {
            let exact = exact.state_derivative(given + j).unwrap();
            let variation = m.assembly().system().given(variation);
            let off = variation.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-9, "{j}: {off}");
        }
    }
}

#[test]
fn invariant_files_are_written_back_and_refused_by_name() {
    let d = machine(IWAN);
    assert_eq!(parse(&d.to_toml(), "again.toml", &no_records).unwrap(), d);
    for (from, to, name) in [
        ("slip = 2.0", "slip = 0.0", "spring.a.slip = 0.0"),
        ("slip = 2.0", "slip = \"2 m\"", "spring.a.slip"),
        ("slip = 2.0", "slip = 2.0, series_damping = 1.0", "spring.a.slip"),
        ("slip = 2.0", "slip = 2.0, preload = 1.0", "spring.a.preload"),
        ("stiffness = 100.0", "stiffness = 0.0", "spring.a.stiffness = 0.0"),
    ] {
        let refused = parse(&IWAN.replace(from, to), "m.toml", &no_records).unwrap_err().to_string();
        assert!(refused.contains(name), "{to}: {refused}");
    }
}

/// A saved state continues like the motion; a state that contradicts the law is refused.
#[test]
fn invariant_saved_states_have_the_sliders() {
    let mut m = motion(machine(IWAN));
    m.advance_to(0.9).unwrap();
    let bytes = postcard::to_stdvec(&m.save()).unwrap();
    let saved = postcard::from_bytes(&bytes).unwrap();
    let mut on = Motion::resumed(m.assembly().clone(), &saved).unwrap();
    m.advance_to(2.0).unwrap();
    on.advance_to(2.0).unwrap();
    assert_eq!(on.save(), m.save());
    // After a change of numbers, it continues with forces within the new limits.
    let d = m.assembly().description.under_way([("spring.d.slip", 1.0)]).unwrap();
    let changed = m.changed(Arc::new(Assembly::new(d).unwrap())).unwrap();
    assert!(of(&changed, 3, What::F).abs() <= 1.0 + ROUNDING);
}

/// The random machines of tests/second_method.rs with sliders behind their springs: energy is
/// balanced, no force exceeds its level, and lone events agree with the general law.
#[test]
fn invariant_random_machines_with_partners() {
    const MACHINES: &str = include_str!("data/motions.txt");
    let (mut slips, mut count) = (0, 0);
    for block in MACHINES.split("## machine ").skip(1) {
        let (name, text) = block.split_once('\n').unwrap();
        let toml: String = text.lines().filter(|l| !l.starts_with("##")).flat_map(|l| [l, "\n"]).collect();
        let mut d = machine(&toml);
        for (i, spring) in d.springs.iter_mut().enumerate().filter(|(_, spring)| spring.stiffness > 0.0) {
            let law = match i % 2 {
                0 => SeriesLaw::Slider { slip: 0.05 * spring.stiffness },
                _ => SeriesLaw::Dashpot { damping: 0.1 * spring.stiffness },
            };
            (spring.preload, spring.series) = (0.0, Some(Series { law, slider: 0.0 }));
        }
        let Ok(assembly) = Assembly::new(d) else { continue };
        let assembly = Arc::new(assembly);
        let Ok(mut m) = Motion::new(assembly.clone()) else { continue };
        let mut general = m.clone().by_general_law();
        let begin = unaccounted(&m);
        let found = events(&mut m, 0.6);
        slips += found.iter().filter(|event| matches!(event.kind, EventKind::Yield { .. })).count();
        count += 1;
        let size = m.state().iter().fold(1.0, |most: f64, x| most.max(x.abs()));
        for (i, branch) in assembly.system().branches.iter().enumerate() {
            if let BranchLaw::Slider(slip) = branch.law {
                let force = branch.force.at(m.state().as_slice());
                assert!(force.abs() <= slip * (1.0 + 1e-9), "{name} {i}: {force} {slip}");
            }
        }
        let stored = m.kinetic_and_stored().1.abs().max(size * size);
        assert!((unaccounted(&m) - begin).abs() < 1e-8 * stored, "{name}: {} {begin}", unaccounted(&m));
        general.advance_to(0.6).unwrap();
        let apart = m.states().iter().zip(general.states()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-6 * size, "{name}: {apart}");
    }
    assert!(count > 80 && slips > 50, "{count} {slips}");
}
