//! Contacts with a normal stiffness and friction along a tangent.

use crate::common::contacts::*;
use crate::common::*;
use std::f64::consts::{PI, TAU};
use vibro_machine::derivative::Gradient;
use vibro_machine::mode::SliderState;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Assembly, Differentiated, Motion, Quantity, What};

/// A hundred roundings of numbers of order one.
const ROUNDING: f64 = 1e-13;

/// Compares events with exact ones.
fn agree(found: &[(&str, f64)], exact: &[(&str, f64)], allowed: f64) {
    let words = |all: &[(&str, f64)]| all.iter().map(|own| own.0.to_owned()).collect::<Vec<_>>();
    assert_eq!(words(found), words(exact), "{found:?} {exact:?}");
    for (own, exact) in found.iter().zip(exact) {
        assert!((own.1 - exact.1).abs() < allowed, "{own:?} {exact:?}");
    }
}

/// A rig of Yang and Menq: both elongations of a contact are prescribed.
#[derive(Clone, Copy)]
struct Rig {
    /// Tangential amplitude and frequency.
    x: f64,
    f: f64,
    /// Normal elongation: mean, amplitude and phase.
    n: [f64; 3],
    stiffness: [f64; 2],
    friction: f64,
}

impl Rig {
    fn text(self) -> String {
        let Self { x, f, n: [mean, amplitude, phase], stiffness: [kn, kt], friction } = self;
        format!(
            "name = \"Rig\"\nbody.n = {{ motion = {{ constant = {mean}, amplitude = {amplitude}, frequency = {f}, \
             phase = {phase} }} }}\nbody.t = {{ motion = {{ amplitude = {x}, frequency = {f} }} }}\n\
             body.box = {{ mass = 1.0 }}\nspring.k = {{ between = [\"ground\", \"box\"], stiffness = 1.0 }}\n\
             contact.c = {{ normal = [\"ground\", \"n\"], tangent = [\"ground\", \"t\"], gap = 0.0, stiffness = {kn}, \
             tangential_stiffness = {kt}, friction = {friction} }}\n"
        )
    }

    /// The first rising passage of a cos ωt + b sin ωt through c after a time.
    fn passage(self, [a, b]: [f64; 2], c: f64, after: f64) -> Option<f64> {
        let (size, omega) = (a.hypot(b), TAU * self.f);
        // After a shakedown the force touches its limit once a cycle, within rounding.
        if size * (1.0 - 1e-12) <= c.abs() {
            return None;
        }
        let first = (b.atan2(a) - (c / size).acos()) / omega;
        // A passage at the last event is this event.
        let turns = ((after - first) * self.f + 1e-9).ceil();
        Some(first + turns / self.f)
    }

    /// The events in closed form, until a time.
    fn events(self, end: f64) -> Vec<(&'static str, f64)> {
        let Self { x, f, n: [mean, amplitude, phase], stiffness: [kn, kt], friction: mu } = self;
        let (omega, level) = (TAU * f, mu * kn);
        // N/kn = mean + normal · (cos, sin); e_t = x sin.
        let normal = [amplitude * phase.sin(), amplitude * phase.cos()];
        let wave = |t: f64| [(omega * t).cos(), (omega * t).sin()];
        let at = |[a, b]: [f64; 2], t: f64| a * wave(t)[0] + b * wave(t)[1];
        let rate = |[a, b]: [f64; 2]| [omega * b, -omega * a];
        let (mut t, mut all, mut place) = (0.0, Vec::new(), 0.0);
        let mut state = if mean + at(normal, 0.0) > 0.0 { "stick" } else { "open" };
        loop {
            let free = self.passage(normal.map(|x| -x), mean, t).map(|t| (t, "free"));
            let slip = |sign: f64, word| {
                let row = [-level * normal[0], sign * kt * x - level * normal[1]];
                self.passage(row, sign * kt * place + level * mean, t).map(|t| (t, word))
            };
            let next = match state {
                "open" => vec![self.passage(normal, -mean, t).map(|t| (t, "press"))],
                "stick" => vec![slip(1.0, "slip+"), slip(-1.0, "slip-"), free],
                slips => {
                    let sign = if slips == "slip+" { 1.0 } else { -1.0 };
                    let row = rate([level / kt * normal[0], level / kt * normal[1] - sign * x]);
                    vec![self.passage(row, 0.0, t).map(|t| (t, "stick")), free]
                }
            };
            // In phase, T = 0 where the contact opens: it does not slip before.
            let opens = |own: &(f64, &str)| own.0 - if own.1 == "free" { 1e-12 } else { 0.0 };
            let next = next.into_iter().flatten().min_by(|a, b| opens(a).total_cmp(&opens(b)));
            let Some((time, word)) = next.filter(|own| own.0 < end) else { return all };
            all.push((word, time));
            let force = kn * (mean + at(normal, time));
            let et = x * (omega * time).sin();
            state = match (word, state) {
                ("press", _) => {
                    let (rt, rn) = (at(rate([0.0, x]), time), at(rate(normal), time));
                    place = et;
                    match kt * rt.abs() < level * rn {
                        true => "stick",
                        false if rt > 0.0 => "slip+",
                        false => "slip-",
                    }
                }
                ("stick", before) => {
                    let sign = if before == "slip+" { 1.0 } else { -1.0 };
                    place = et - sign * mu * force / kt;
                    "stick"
                }
                ("free", _) => "open",
                (word, _) => word,
            };
            t = time;
        }
    }
}

/// Yang and Menq's hysteresis: normal elongation in phase, out of phase and in between, with and
/// without lift-off. All times are roots of A cos ωt + B sin ωt = C.
#[test]
fn closed_form_yang_and_menq_with_a_normal_load_of_any_phase_and_lift_off() {
    let mut lifts = 0;
    for phase in [0.0, 0.7, 0.5 * PI, 2.1, PI, 4.0] {
        for (mean, amplitude) in [(0.1, 0.0), (0.1, 0.06), (0.1, 0.09), (0.05, 0.2), (-0.05, 0.2)] {
            for (friction, kt) in [(0.4, 50.0), (0.8, 90.0), (0.15, 300.0), (3.0, 100.0)] {
                let rig =
                    Rig { x: 0.3, f: 1.3, n: [mean, amplitude, phase], stiffness: [100.0, kt], friction };
                let mut m = motion(machine(&rig.text()));
                let begin = unaccounted(&m);
                let found = words(&events(&mut m, 4.0));
                agree(&found, &rig.events(4.0), ROUNDING);
                lifts += usize::from(found.iter().any(|own| own.0 == "free"));
                assert!((unaccounted(&m) - begin).abs() < 1e-12, "{phase} {mean}");
            }
        }
    }
    assert!(lifts > 40, "{lifts}");
}

/// Griffin's element: with a constant normal force the contact is a spring with a slider at μ N,
/// and loses 4 μ N (X - μ N/k) a cycle.
#[test]
fn closed_form_griffin_and_second_method_a_constant_normal_force_is_a_slider() {
    let contact = r#"
        name = "Griffin"
        body.seat = { motion = { constant = 0.25 } }
        body.foot = { motion = { amplitude = 0.3, frequency = 2.0 } }
        body.box = { mass = 1.5 }
        spring.k = { between = ["ground", "box"], stiffness = 300.0, damping = 0.5 }
        load.f = { on = "box", amplitude = 40.0, frequency = 2.3 }
        contact.a = { normal = ["ground", "seat"], tangent = ["ground", "foot"], gap = 0.0, stiffness = 128.0, tangential_stiffness = 256.0, friction = 0.5 }
        contact.b = { normal = ["ground", "seat"], tangent = ["ground", "box"], preload = 0.0, stiffness = 64.0, tangential_stiffness = 512.0, friction = 0.5 }
    "#;
    // μ N = 0.5 · 32 N and 0.5 · 16 N, without rounding.
    let slider = r#"
        name = "Jenkins"
        body.seat = { motion = { constant = 0.25 } }
        body.foot = { motion = { amplitude = 0.3, frequency = 2.0 } }
        body.box = { mass = 1.5 }
        spring.k = { between = ["ground", "box"], stiffness = 300.0, damping = 0.5 }
        spring.a = { between = ["ground", "foot"], stiffness = 256.0, slip = 16.0 }
        spring.b = { between = ["ground", "box"], stiffness = 512.0, slip = 8.0 }
        load.f = { on = "box", amplitude = 40.0, frequency = 2.3 }
    "#;
    let [mut one, mut other] = [contact, slider].map(|text| motion(machine(text)));
    let [found, exact] = [&mut one, &mut other].map(|m| words(&events(m, 6.0)));
    assert!(exact.len() > 40, "{}", exact.len());
    agree(&found, &exact, ROUNDING);
    assert!((one.coordinate(2) - other.coordinate(2)).abs() < ROUNDING);
    let before = one.energy().branches[0].value();
    one.advance_to(6.5).unwrap();
    let lost = one.energy().branches[0].value() - before;
    assert!((lost - 4.0 * 16.0 * (0.3 - 16.0 / 256.0)).abs() < 1e-11, "{lost}");
}

/// code_aster SDND101: a body of 100 kg on 10 kN/m meets a contact of 1 MN/m with 1 m/s. The contact
/// lasts π/√((k + K)/m), and without friction it is a compliant stop, bit for bit.
#[test]
fn published_sdnd101_contact_of_a_body_on_a_spring() {
    let text = |element: &str| {
        format!(
            "name = \"SDND101\"\nbody.m = {{ mass = 100.0, start = {{ v = 1.0 }} }}\n\
             spring.k = {{ between = [\"ground\", \"m\"], stiffness = 1e4 }}\n{element}\n"
        )
    };
    let contact = "contact.c = { normal = [\"ground\", \"m\"], gap = 0.0, stiffness = 1e6 }";
    let stop = "stop.c = { between = [\"ground\", \"m\"], gap = 0.0, stiffness = 1e6, law = \"no-pull\" }";
    let mut m = motion(machine(&text(contact)));
    let omega = (1.01e6_f64 / 100.0).sqrt();
    m.advance_to(0.5 * PI / omega).unwrap();
    assert!((of(&m, 1, What::E) - 1.0 / omega).abs() < 1e-15);
    assert!((of(&m, 1, What::E) - 9.950e-3).abs() < 5e-7 && (of(&m, 1, What::F) - 9950.0).abs() < 0.5);
    let found = events(&mut m, 1.0);
    assert!((found[0].time - PI / omega).abs() < 1e-15 && (found[0].time - 31.26e-3).abs() < 5e-6);
    let mut other = motion(machine(&text(stop)));
    other.advance_to(0.5 * PI / omega).unwrap();
    assert_eq!(words(&events(&mut other, 1.0)), words(&found));
    assert_eq!(m.state(), other.state());
}

/// code_aster SDND100: a pad under its normal force slides out with extrema (-1)ⁿ (r - 2 n μ N/k); a
/// finite tangential stiffness shifts them by up to μ N/k_t each.
#[test]
fn published_sdnd100_friction_pad() {
    let text = r#"
        name = "Pad"
        body.seat = { motion = { constant = 0.01 } }
        body.pad = { mass = 1.0, start = { s = 0.00085 } }
        spring.k = { between = ["ground", "pad"], stiffness = 10000.0 }
        contact.c = { normal = ["ground", "seat"], tangent = ["ground", "pad"], gap = 0.0, stiffness = 1000.0, tangential_stiffness = 1e9, friction = 0.1, slider = 0.00085 }
    "#;
    let mut m = motion(machine(text));
    for n in 1..=4 {
        m.advance_to(f64::from(n) * PI / 100.0).unwrap();
        let exact = (-1.0_f64).powi(n) * (0.00085 - 2.0 * f64::from(n) * 1.0 / 10000.0);
        let allowed = 4.0 * f64::from(n) / 1e9;
        assert!((m.coordinate(1) - exact).abs() < allowed, "{n}: {} {exact}", m.coordinate(1));
    }
}

/// Roundings of numbers of order one over some ten events, before they are magnified.
const DIGITS: f64 = 2e-13;

/// Random machines in 40 digits: every event, the end, and the sliders' places. Work is stored or
/// lost, and friction never gives energy.
#[test]
fn second_method_random_machines_in_40_digits() {
    let mut met = 0;
    for row in include_str!("data/frictional.txt").lines() {
        let fields: Vec<&str> = row.split(';').collect();
        let mut m = motion(machine(&fields[0].replace('|', "\n")));
        let (end, exact, factor) = (numbers(fields[1])[0], numbers(fields[3]), numbers(fields[4])[0]);
        let begin = unaccounted(&m);
        let names: Vec<&str> = fields[2].split_whitespace().collect();
        let mut all = Vec::new();
        let mut lost = vec![0.0; m.energy().branches.len()];
        for k in 1..=50 {
            m.advance_observed(end * f64::from(k) / 50.0, &mut |event| all.push(event.clone())).unwrap();
            for (lost, now) in lost.iter_mut().zip(&m.energy().branches) {
                assert!(now.value() >= *lost - 1e-14, "{row}");
                *lost = now.value();
            }
        }
        let found: Vec<String> = all
            .iter()
            .zip(words(&all))
            .map(|(event, own)| {
                let name = m.assembly().name_of_contact(event.contact().unwrap());
                format!("{} {}", name.trim_start_matches("contact."), own.0)
            })
            .collect();
        let exact_words: Vec<String> = names.chunks(3).map(|own| own[..2].join(" ")).collect();
        assert_eq!(found, exact_words, "{row}");
        for (event, own) in all.iter().zip(names.chunks(3)) {
            let time: f64 = own[2].parse().unwrap();
            assert!((event.time - time).abs() < DIGITS * factor, "{own:?} {} in {row}", event.time);
        }
        met += all.len();
        let bodies = m.assembly().description.bodies.len();
        for (k, x) in exact[..2 * bodies].iter().enumerate() {
            let off = (m.body(k % bodies)[k / bodies] - x).abs() / factor;
            assert!(off < 10.0 * DIGITS, "{off:e} of {x} in {row}");
        }
        for (contact, x) in exact[2 * bodies..].iter().enumerate() {
            let element = m.assembly().description.springs.len() + contact;
            let off = (of(&m, element, What::Slider(None)) - x).abs() / factor;
            assert!(off < 10.0 * DIGITS, "{off:e} of the slider {x} in {row}");
        }
        let off = (unaccounted(&m) - begin).abs();
        assert!(off < 1e-12 * (1.0 + m.energy().branches[0].value()), "{off:e} J in {row}");
        // Long series of states without tables, and the general law at every event.
        let text = fields[0].replace('|', "\n");
        for mut other in [motion(machine(&with_company(&text))), motion(machine(&text)).by_general_law()] {
            agree(&words(&events(&mut other, end)), &words(&all), 1e3 * DIGITS * factor);
        }
    }
    assert!(met > 500, "{met}");
}

/// Derivatives by stiffnesses, friction, gap and preload in 40 digits, through stick, slip and
/// lift-off; the gradient has the same.
#[test]
fn second_method_derivatives_in_40_digits() {
    let count = compare_derivatives(include_str!("data/frictional_by.txt"), |d, k| {
        Quantity::of_body(k % d.bodies.len(), [What::S, What::V][k / d.bodies.len()])
    });
    assert!(count > 20, "{count}");
}

/// A body of two coordinates on an oblique contact, with a second contact between bodies.
const OBLIQUE: &str = r#"
    name = "Oblique"
    body.n = { mass = 1.0, start = { v = 1.0 } }
    body.t = { mass = 1.3, start = { v = -0.5 } }
    body.far = { mass = 0.7 }
    spring.n = { between = ["ground", "n"], stiffness = 30.0, damping = 0.1 }
    spring.t = { between = ["ground", "t"], stiffness = 20.0, damping = 0.1 }
    spring.nt = { between = ["n", "t"], stiffness = 9.0 }
    spring.far = { between = ["t", "far"], stiffness = 15.0 }
    contact.a = { normal = ["ground", "n"], tangent = { arms = { t = 1.0, n = 0.3 } }, gap = 0.02, stiffness = 200.0, tangential_stiffness = 150.0, friction = 0.35 }
    contact.b = { normal = ["n", "far"], tangent = ["far", "t"], preload = 1.5, stiffness = 90.0, tangential_stiffness = 70.0, friction = 0.6 }
    load.fn = { on = "n", constant = 4.0, amplitude = 9.0, frequency = 0.9 }
    load.ft = { on = "t", amplitude = 6.0, frequency = 0.7, phase = 1.0 }
"#;

#[test]
fn second_method_series_of_actual_states_and_the_general_law_are_the_tables_and_lone_events() {
    let [mut one, mut other] = [OBLIQUE.to_owned(), with_company(OBLIQUE)].map(|text| motion(machine(&text)));
    let mut general = motion(machine(OBLIQUE)).by_general_law();
    let exact = words(&events(&mut one, 6.0));
    assert!(exact.len() > 30, "{}", exact.len());
    for m in [&mut other, &mut general] {
        agree(&words(&events(m, 6.0)), &exact, 1e-11);
        for k in 0..3 {
            assert!((m.coordinate(k) - one.coordinate(k)).abs() < 1e-11);
        }
    }
}

/// [`OBLIQUE`] at rest under constant loads.
fn pressed(weight: f64, pull: f64) -> String {
    let start = OBLIQUE.find("    load.").unwrap();
    let machine = OBLIQUE[..start].replace(", start = { v = 1.0 }", "").replace(", start = { v = -0.5 }", "");
    let machine = machine.replace("name = ", "start = \"rest\"\n    name = ");
    format!(
        "{machine}load.fn = {{ on = \"n\", constant = {weight:?} }}\nload.ft = {{ on = \"t\", constant = {pull:?} }}\n"
    )
}

/// Relative error of a difference of states at rest over 1e-6.
const AT_REST: f64 = 1e-6;

/// At rest no body accelerates; a contact is open, or its slider has stayed at 0 within its limit, or
/// has slipped from 0 until the force is at the limit, which the friction itself changes. Derivatives
/// by all numbers are differences.
#[test]
fn invariant_contacts_at_rest_hold_or_have_slipped_from_zero() {
    let mut met = [0; 3];
    for (weight, pull) in
        [(-3.0, -20.0), (0.3, -4.0), (2.0, -0.5), (2.0, 0.5), (2.0, 3.0), (9.0, -4.0), (9.0, 25.0)]
    {
        let assembly = assembled(&pressed(weight, pull));
        let d = &assembly.description;
        let mut m = motion(d.clone());
        for i in 0..3 {
            let [_, v, a] = m.body(i);
            assert!(v == 0.0 && a.abs() < 100.0 * ROUNDING, "{weight} {pull} {i} {v} {a}");
        }
        for (k, friction) in [(4, 0.35), (5, 0.6)] {
            let [n, t, e, w] = [What::F, What::TangentF(None), What::TangentE(None), What::Slider(None)]
                .map(|what| of(&m, k, what));
            let place = if n == 0.0 { 0 } else { 1 + usize::from(w != 0.0) };
            met[place] += 1;
            match place {
                0 => assert!(t == 0.0 && (w - e).abs() < ROUNDING),
                1 => assert!(t.abs() <= friction * n),
                _ => assert!(
                    (t.abs() - friction * n).abs() < 100.0 * ROUNDING
                        && t * e > 0.0
                        && w / e < 1.0
                        && w * e > 0.0
                ),
            }
        }
        let states = m.states();
        m.advance_to(5.0).unwrap();
        assert!(states.iter().zip(m.states()).all(|(a, b)| (a - b).abs() < ROUNDING), "{weight} {pull}");
        let names = d.parameters();
        let columns: Vec<&str> = names.iter().map(|own| own.name.as_str()).collect();
        let mut by = Differentiated::new(assembly.clone(), &columns).unwrap();
        by.advance_to(0.5).unwrap();
        for (p, own) in names.iter().enumerate() {
            let h = 1e-6 * own.value.abs().max(1e-2);
            let side =
                |sign: f64| Some(motion(d.with([(own.name.as_str(), own.value + sign * h)]).ok()?).states());
            let (Some(above), Some(below)) = (side(1.0), side(-1.0)) else { continue };
            let Some(found) = by.state_derivative(p) else {
                // A number that is zero has no size that tells rounding from a change.
                assert_eq!(own.value, 0.0, "{weight} {pull} {}: {:?}", own.name, by.lost(p));
                continue;
            };
            for (found, (above, below)) in found.iter().zip(above.iter().zip(&below)) {
                let exact = (above - below) / (2.0 * h);
                assert!(
                    (found - exact).abs() < AT_REST * (1.0 + exact.abs()),
                    "{weight} {pull} by {}: {found} {exact}",
                    own.name
                );
            }
        }
    }
    assert!(met.iter().all(|count| *count > 1), "{met:?}");
    // Friction that lifts its own contact. A limit by the normal force without friction opens it.
    let jammed = "name = \"Jam\"\nstart = \"rest\"\nbody.n = { mass = 1.0 }\nspring.n = { between = [\"ground\", \"n\"], stiffness = 1.0 }\n\
        body.t = { mass = 1.0 }\nspring.t = { between = [\"ground\", \"t\"], stiffness = 1.0 }\n\
        contact.c = { normal = [\"ground\", \"n\"], tangent = { arms = { t = 1.0, n = 4.0 } }, gap = 0.0, stiffness = 9.0, tangential_stiffness = 900.0, friction = 2.0 }\n\
        load.fn = { on = \"n\", constant = 0.1 }\nload.ft = { on = \"t\", constant = 5.0 }\n";
    let m = motion(machine(jammed));
    let [n, t] = [What::F, What::TangentF(None)].map(|what| of(&m, 2, what));
    assert!(n > 0.0 && (t.abs() - 2.0 * n).abs() < 100.0 * ROUNDING, "{n} {t}");
    assert!((0..2).all(|i| m.body(i)[2].abs() < 100.0 * ROUNDING));
    let refused =
        vibro_machine::Assembly::new(machine(&jammed.replace("friction = 2.0", "friction = 900.0")))
            .err()
            .map(|error| error.to_string())
            .unwrap_or_default();
    assert!(refused.starts_with("contact.c.friction = 900"), "{refused}");
}

/// A saved state, and a start from the present state, continue the motion.
#[test]
fn second_method_a_motion_continues_from_its_states() {
    let mut m = motion(machine(OBLIQUE));
    let end = 3.0;
    let mut exact = m.clone();
    exact.advance_to(end).unwrap();
    for k in 1..30 {
        m.advance_to(0.1 * f64::from(k)).unwrap();
        let mut same = Motion::from_state(m.assembly().clone(), m.time(), &m.states()).unwrap();
        same.advance_to(end).unwrap();
        assert!((same.coordinate(0) - exact.coordinate(0)).abs() < 1e-10, "{k}");
        let mut resumed = Motion::resumed(m.assembly().clone(), &m.save()).unwrap();
        resumed.advance_to(end).unwrap();
        assert_eq!(resumed.coordinate(0), {
            let mut own = m.clone();
            own.advance_to(end).unwrap();
            own.coordinate(0)
        });
    }
}

/// Steps of prescribed ends. The slider follows the limit of ever faster steady motions: over a step
/// of the tangent it loses μ N times its way; over a step of the normal, the energy that the spring
/// can no longer hold.
#[test]
fn closed_form_steps_of_prescribed_ends() {
    let text = r#"
        name = "Steps"
        body.n = { motion = { constant = 0.1, steps = [[0.2, -0.06], [0.3, -0.08], [0.5, 0.12]] } }
        body.t = { motion = { steps = [[0.1, 0.03], [0.15, 0.05], [0.4, 0.2], [0.5, -0.02], [0.6, -0.5]] } }
        body.box = { mass = 1.0 }
        spring.k = { between = ["ground", "box"], stiffness = 1.0 }
        contact.c = { normal = ["ground", "n"], tangent = ["ground", "t"], gap = 0.0, stiffness = 100.0, tangential_stiffness = 50.0, friction = 0.2 }
    "#;
    let mut m = motion(machine(text));
    // Times, N, T and the loss so far. μ N = 2 N: elastic up to 0.04 m, then 0.04 m of slip.
    let (k, begin) = (50.0, unaccounted(&m));
    let mut lost = 0.0;
    let mut check = |time: f64, normal: f64, tangential: f64, by: f64| {
        lost += by;
        m.advance_to(time).unwrap();
        assert!((of(&m, 1, What::F) - normal).abs() < 1e-12, "{time}: {}", of(&m, 1, What::F));
        assert!(
            (of(&m, 1, What::TangentF(None)) - tangential).abs() < 1e-12,
            "{time}: {}",
            of(&m, 1, What::TangentF(None))
        );
        let found = m.energy().branches[0].value();
        assert!((found - lost).abs() < 1e-12, "{time}: {found} {lost}");
        assert!((unaccounted(&m) - begin).abs() < 1e-12, "{time}");
    };
    check(0.12, 10.0, 1.5, 0.0);
    check(0.17, 10.0, 2.0, 2.0 * 0.04);
    check(0.25, 4.0, 0.8, 0.5 * (2.0 * 2.0 - 0.8 * 0.8) / k);
    // Open, with the rest of the energy lost; then it moves without a force.
    check(0.35, 0.0, 0.0, 0.5 * 0.8 * 0.8 / k);
    check(0.45, 0.0, 0.0, 0.0);
    // From -0.04 to 0.08 m while e_t falls by 0.02 m: a third of the way is open. The rest stretches by
    // 0.0133 m, less than the limit of 0.032 m.
    check(0.55, 8.0, -k * 0.02 * 2.0 / 3.0, 0.0);
    check(0.65, 8.0, -1.6, 1.6 * (0.5 - (0.032 - 0.04 / 3.0)));
}

/// Without friction (μ = 0) the tangential force is zero, and the slider follows e_t.
#[test]
fn closed_form_without_friction_the_slider_follows() {
    let text =
        OBLIQUE.replace("friction = 0.35", "friction = 0.0").replace("friction = 0.6", "friction = 0.0");
    let mut m = motion(machine(&text));
    for k in 1..=40 {
        m.advance_to(0.1 * f64::from(k)).unwrap();
        for element in [4, 5] {
            assert!(of(&m, element, What::TangentF(None)).abs() < 1e-12);
            let off = of(&m, element, What::TangentE(None)) - of(&m, element, What::Slider(None));
            assert!(off.abs() < 1e-12, "{off:e}");
        }
    }
}

/// A pressed contact without friction beside a decaying motion: it has no events, and the motion is
/// that of the oscillator alone, also when only roundings are left and from the machine's rest.
/// Its derivative by the coefficient would be one-sided and is lost, along columns and in reverse.
#[test]
fn closed_form_without_friction_a_pressed_contact_has_no_events() {
    /// Roundings of a decay over 60 s from 0.02 m, m.
    const DECAYED: f64 = 1e-16;
    let [k, c] = [100.0, 5.0_f64];
    let text = format!(
        "name = \"Frictionless\"\n\
         body.n = {{ mass = 1.0 }}\nbody.t = {{ mass = 1.0 }}\n\
         spring.n = {{ between = [\"ground\", \"n\"], stiffness = {k} }}\n\
         spring.t = {{ between = [\"ground\", \"t\"], stiffness = {k}, damping = {c} }}\n\
         load.pull = {{ on = \"t\", constant = 2.0, steps = [[0.5, -2.0]] }}\n\
         [contact.pad]\nnormal = [\"ground\", \"n\"]\ntangent = [\"ground\", \"t\"]\npreload = 10.0\n\
         stiffness = 1000.0\ntangential_stiffness = 900.0\nfriction = 0.0\n"
    );
    let text = format!("start = \"rest\"\n{text}");
    let mut m = motion(machine(&text));
    let mut events = Vec::new();
    let (rate, omega) = (0.5 * c, (k - 0.25 * c * c).sqrt());
    for time in [0.3, 0.7, 5.0, 60.0] {
        m.advance_observed(time, &mut |event| events.push(event.clone())).unwrap();
        let after: f64 = (time - 0.5_f64).max(0.0);
        let (sin, cos) = (omega * after).sin_cos();
        let exact = 2.0 / k * (-rate * after).exp() * (cos + rate / omega * sin);
        assert!((m.state()[1] - exact).abs() <= DECAYED, "{time}: {} {exact}", m.state()[1]);
    }
    assert_eq!(events, [Event { time: 0.5, kind: EventKind::Knot }]);
    let free = ["contact.pad.friction", "spring.t.stiffness"];
    let (of_t, assembly) = (Quantity::of_body(1, What::S), || Assembly::new(machine(&text)).unwrap());
    let mut varied = Differentiated::new(assembly().into(), &free).unwrap();
    varied.advance_to(0.7).unwrap();
    assert_eq!(varied.lost(0).map(|lost| lost.element.clone()), Some("contact.pad".into()));
    assert!(varied.derivative(of_t, 1).is_some());
    let mut gradient = Gradient::new(assembly().into(), &free).unwrap();
    gradient.advance_to(0.7).unwrap();
    gradient.add(of_t, 1.0);
    let found = gradient.gradient().unwrap();
    assert!(found[0].is_err() && found[1].is_ok());
}

/// A body at rest at its gap, where a load begins to press and another to push: the first nonzero
/// derivative of the rate of slip decides, of any order.
#[test]
fn closed_form_the_first_derivative_decides_at_the_edge() {
    let begun = |normal: &str, tangential: &str| {
        let text = format!(
            "name = \"Edge\"\nbody.n = {{ mass = 2.0 }}\nbody.t = {{ mass = 0.5 }}\n\
             contact.c = {{ normal = [\"ground\", \"n\"], tangent = [\"ground\", \"t\"], gap = 0.0, \
             stiffness = 300.0, tangential_stiffness = 100.0, friction = 0.25 }}\n\
             load.fn = {{ on = \"n\", {normal} }}\nload.ft = {{ on = \"t\", {tangential} }}\n"
        );
        let m = motion(machine(&text));
        m.mode().sliders[0]
    };
    let constant = |x: f64| format!("constant = {x}");
    let ramp = |x: f64| format!("table = [[0.0, 0.0], [1.0, {x}]]");
    // The limit: p_t/m_t = μ k_n/k_t p_n/m_n, with p_n = 8 N: 3 m/s² and 1.5 N.
    for (tangential, state) in
        [(1.49, SliderState::Held), (1.51, SliderState::Up), (-1.51, SliderState::Down)]
    {
        assert_eq!(begun(&constant(8.0), &constant(tangential)), state, "{tangential}");
        assert_eq!(begun(&ramp(8.0), &ramp(tangential)), state, "{tangential}");
    }
    assert_eq!(begun(&constant(8.0), &ramp(100.0)), SliderState::Held);
    assert_eq!(begun(&ramp(8.0), &constant(1e-3)), SliderState::Up);
    assert_eq!(begun(&ramp(8.0), &constant(-1e-3)), SliderState::Down);
    assert_eq!(begun(&constant(-8.0), &constant(1.0)), SliderState::Off);
    assert_eq!(begun(&constant(0.0), &constant(1.0)), SliderState::Off);
}

/// Derivatives of a jump: with the height of a step, the limited force follows μ N, and the slider the
/// step; a contact that a step closes without a slip has none.
#[test]
fn closed_form_derivatives_over_steps_of_prescribed_ends() {
    let text = r#"
        name = "Steps"
        body.n = { motion = { constant = 0.1, steps = [[0.2, -0.06], [0.4, -0.08], [0.5, 0.12]] } }
        body.t = { motion = { steps = [[0.1, 0.1]] } }
        body.box = { mass = 1.0 }
        spring.k = { between = ["ground", "box"], stiffness = 1.0 }
        contact.c = { normal = ["ground", "n"], tangent = ["ground", "t"], gap = 0.0, stiffness = 100.0, tangential_stiffness = 50.0, friction = 0.2 }
    "#;
    let names = ["body.t.motion.steps[0].height", "body.n.motion.steps[0].height", "contact.c.friction"];
    let mut by = Differentiated::new(assembled(text), &names).unwrap();
    let quantity = |what| Quantity::of_element(1, what);
    let column =
        |by: &Differentiated, what| (0..3).map(|p| by.derivative(quantity(what), p)).collect::<Vec<_>>();
    by.advance_to(0.15).unwrap();
    // T = μ N = 0.2 · 10 N; the slider is at 0.1 m - T/k_t.
    assert_eq!(column(&by, What::TangentF(None)), [0.0, 0.0, 10.0].map(Some));
    let slider = column(&by, What::Slider(None));
    for (found, exact) in slider.iter().zip([1.0, 0.0, -0.2]) {
        assert!((found.unwrap() - exact).abs() < ROUNDING, "{slider:?}");
    }
    // The normal elongation falls by 0.06 m: N = 4 N and T = 0.8 N.
    by.advance_to(0.3).unwrap();
    let force = column(&by, What::TangentF(None));
    for (found, exact) in force.iter().zip([0.0, 20.0, 4.0]) {
        assert!((found.unwrap() - exact).abs() < 1e-11, "{force:?}");
    }
    by.advance_to(0.6).unwrap();
    assert!(by.derivative(quantity(What::TangentF(None)), 0).is_none());
    assert!(by.lost(0).unwrap().to_string().contains("contact.c is closed by a step"), "{:?}", by.lost(0));
}

/// Relative rounding of a derivative of a harmonic motion.
const OF_HARMONIC: f64 = 1e-12;

/// A slider that the start leaves where it is, closer to the body than to its zero or farther: the
/// body oscillates about it, x = w + (x₀ - w) cos ωt + (v₀/ω) sin ωt, and w does not follow x₀.
#[test]
fn closed_form_derivatives_of_a_slider_that_stays() {
    let (w, x, v, k, t) = (0.003_f64, 0.02_f64, 0.02_f64, 100.0_f64, 0.05_f64);
    let body = format!("name = \"S\"\nbody.x = {{ mass = 1.0, start = {{ s = {x}, v = {v} }} }}\n");
    let spring = format!(
        "spring.c = {{ between = [\"ground\", \"x\"], stiffness = {k}, slip = 27.0, slider = {w} }}\n"
    );
    let contact = format!(
        "body.n = {{ mass = 1.0 }}\n\
         contact.c = {{ normal = [\"ground\", \"n\"], tangent = [\"ground\", \"x\"], preload = 50.0, \
         stiffness = 1e3, tangential_stiffness = {k}, friction = 0.5, slider = {w} }}\n\
         load.n = {{ on = \"n\", constant = 50.0 }}\n"
    );
    let rate = k.sqrt();
    let (cosine, sine) = ((rate * t).cos(), (rate * t).sin());
    for (elements, slider) in [(&spring, "spring.c.slider"), (&contact, "contact.c.slider")] {
        let names = [slider, "body.x.start.s"];
        let text = format!("{body}{elements}");
        let mut motion = Differentiated::new(assembled(&text), &names).expect(&text);
        motion.advance_to(t).expect(&text);
        let exact = [[1.0 - cosine, cosine], [rate * sine, -rate * sine]];
        for (what, exact) in [What::S, What::V].into_iter().zip(exact) {
            for (p, exact) in exact.into_iter().enumerate() {
                let own = motion.derivative(Quantity::of_body(0, what), p).expect("a derivative");
                assert!((own / exact - 1.0).abs() < OF_HARMONIC, "{own} {exact} by {} in {text}", names[p]);
            }
        }
    }
}
