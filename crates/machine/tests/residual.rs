//! Residual flexibility of bodies in modal coordinates (docs/assembly-law.md, section 25).

use crate::common::contacts::*;
use crate::common::*;
use std::f64::consts::{PI, SQRT_2};
use std::sync::Arc;
use vibro_machine::derivative::{By, Extremes};
use vibro_machine::description::Description;
use vibro_machine::motion::{Event, Reached};
use vibro_machine::{Assembly, Differentiated, Motion, Quantity, What};

/// A hundred roundings of numbers of order one.
const ROUNDING: f64 = 1e-13;

/// A free bar with its rigid motion and `n` modes.
struct Bar {
    n: usize,
    mass: f64,
    length: f64,
    /// Speed of waves.
    c: f64,
}

impl Bar {
    fn list(&self, of: impl Fn(usize) -> f64) -> String {
        let all: Vec<String> = (0..=self.n).map(|k| format!("{:?}", of(k))).collect();
        format!("[{}]", all.join(", "))
    }

    /// The factor of a mode at the end.
    fn at_end(&self, k: usize) -> f64 {
        if k == 0 { self.mass.sqrt().recip() } else { SQRT_2 / self.mass.sqrt() }
    }

    /// The flexibility at the end that the modes lack: the sum over all modes is L²/(3 m c²).
    fn residual(&self) -> f64 {
        let Self { n, mass, length, c } = *self;
        let omega = |k: usize| k as f64 * PI * c / length;
        let kept: f64 = (1..=n).map(|k| 2.0 / (mass * omega(k) * omega(k))).sum();
        length * length / (3.0 * mass * c * c) - kept
    }

    /// The body, with the rigid place and speed of its start.
    fn text(&self, [s, v]: [f64; 2], more: &str) -> String {
        let rigid = |x: f64| self.list(|k| if k == 0 { x * self.mass.sqrt() } else { 0.0 });
        format!(
            "name = \"Bar\"\ngravity = 10.0\n[modal.bar]\nfrequencies = {}\nnodes = {{ end = {} }}\n\
             start = {{ q = {}, v = {} }}\n{more}\n",
            self.list(|k| k as f64 * self.c / (2.0 * self.length)),
            self.list(|k| self.at_end(k)),
            rigid(s),
            rigid(v),
        )
    }

    fn flexible(&self) -> String {
        format!("residual = {{ nodes = [\"end\"], flexibility = [[{:?}]] }}", self.residual())
    }
}

const WALL: &str = "[stop.wall]\nbetween = [\"ground\", \"bar.end\"]\ngap = 0.0\n";

/// A bar that meets a rigid wall with 1 m/s stays until the wave has returned, after 1 s, and leaves
/// with -1 m/s. The modes lack as much as 1/n of it. A rigid stop with restitution 0 loses 1/(2n + 1)
/// of the energy at its first impact, which the bar does not.
#[test]
fn closed_form_a_bar_leaves_a_wall_with_the_wave_and_without_loss() {
    for n in [5, 10, 20, 40] {
        let bar = Bar { n, mass: 1.0, length: 1.0, c: 2.0 };
        let mut m = moving(&(bar.text([0.0, 1.0], &bar.flexible()) + WALL));
        let all = words(&events(&mut m, 1.5));
        assert!(matches!(all[..], [("free", time)] if (time - 1.0).abs() < 0.06 / n as f64), "{all:?}");
        let (kinetic, stored) = m.kinetic_and_stored();
        assert!((kinetic + stored - 0.5).abs() < ROUNDING);
        assert!((m.state()[n + 1] + 1.0).abs() < 0.02 / (n as f64).sqrt(), "{}", m.state()[n + 1]);
        let plastic = "[stop.wall]\nbetween = [\"ground\", \"bar.end\"]\ngap = 0.0\nrestitution = 0.0\n";
        let mut m = moving(&(bar.text([-1e-9, 1.0], "") + plastic));
        m.advance_to(1e-8).unwrap();
        let lost = m.energy().impacts.value() / 0.5;
        assert!((lost - 1.0 / (2 * n + 1) as f64).abs() < 1e-9, "{lost}");
    }
}

/// Height of the lower end of the bar of Doyen, Ern and Piperno over a period of 16/3 s, from the waves
/// in it: free fall for 1 s, 2/3 s on the ground, and then the end's speed is v + g τ - 2 g k T in the
/// k-th interval T = 2 L/c after the contact began.
fn height(time: f64) -> f64 {
    let time = if time > 8.0 / 3.0 { 16.0 / 3.0 - time } else { time };
    if time <= 1.0 {
        return 5.0 - 5.0 * time * time;
    }
    let (g, v, period, mut height) = (10.0, 10.0, 2.0 / 3.0, 0.0);
    for k in 1..=4 {
        let (from, to) = (k as f64 * period, ((k + 1) as f64 * period).min(time - 1.0));
        if to > from {
            let k = k as f64;
            height += (v - 2.0 * g * k * period) * (to - from) + 0.5 * g * (to * to - from * from);
        }
    }
    height
}

#[test]
fn closed_form_the_bouncing_bar_of_doyen_ern_and_piperno() {
    let bar = Bar { n: 15, mass: 10.0, length: 10.0, c: 30.0 };
    let weight = bar.list(|k| if k == 0 { -bar.mass.sqrt() } else { 0.0 });
    let more = format!("gravity = {weight}\n{}", bar.flexible());
    let ground = "[stop.ground]\nbetween = [\"bar.end\", \"ground\"]\ngap = 0.0\n";
    let mut m = moving(&(bar.text([5.0, 0.0], &more) + ground));
    let end = m.assembly().description.bodies.iter().position(|body| body.name == "bar.end").unwrap();
    let (count, period, begin) = (2000, 16.0 / 3.0, unaccounted(&m));
    let mut sum = 0.0;
    for k in 1..=count {
        let time = period * f64::from(k) / f64::from(count);
        m.advance_to(time).unwrap();
        sum += (m.coordinate(end) - height(time)).powi(2);
    }
    let error = (sum / f64::from(count)).sqrt() / 5.0;
    assert!(error < 4.3e-3, "{error}");
    assert!((unaccounted(&m) - begin).abs() < 1e-12 * 500.0);
}

/// One stop alone is a compliant stop of the stiffness 1/(1/k + G) on the same modes; contacts with friction
/// whose normal and tangent share no flexibility are contacts with two such stiffnesses.
#[test]
fn second_method_a_force_alone_is_a_softer_element() {
    let body = "name = \"Beam\"\n[modal.beam]\nfrequencies = [1.0, 4.1, 9.3, 16.2]\ndamping_ratio = 0.01\n\
                nodes = { tip = { n = [1.0, -0.9, 0.8, -0.8], t = [0.3, 0.5, -0.4, 0.2] } }\n";
    let load = "[load.f]\non = \"beam.tip.n\"\nconstant = 0.2\namplitude = 9.0\nfrequency = 0.8\n\
                [load.t]\non = \"beam.tip.t\"\namplitude = 12.0\nfrequency = 1.1\n";
    let residual =
        "residual = { nodes = [\"tip.n\", \"tip.t\"], flexibility = [[2e-3, 0.0], [0.0, 3e-3]] }\n";
    let contact = |kn: f64, kt: f64| {
        format!(
            "[contact.c]\nbetween = [\"ground\", \"beam.tip\"]\nnormal = \"n\"\ntangent = \"t\"\ngap = 0.01\n\
             stiffness = {kn:?}\ntangential_stiffness = {kt:?}\nfriction = 0.5\n"
        )
    };
    let softer = |k: f64, g: f64| 1.0 / (1.0 / k + g);
    let stop =
        |k: f64| format!("[stop.c]\nbetween = [\"ground\", \"beam.tip.n\"]\ngap = 0.01\nstiffness = {k:?}\n");
    // Loads on residual nodes move the nodes; here they are on others.
    let other =
        body.replace("} }\n", "}, push = { n = [1.0, -0.9, 0.8, -0.8], t = [0.3, 0.5, -0.4, 0.2] } }\n");
    let load = load.replace("beam.tip", "beam.push");
    for (flexible, plain) in [
        (stop(500.0), stop(softer(500.0, 2e-3))),
        (contact(500.0, 300.0), contact(softer(500.0, 2e-3), softer(300.0, 3e-3))),
    ] {
        let mut one = moving(&format!("{other}{residual}{flexible}{load}"));
        let mut two = moving(&format!("{other}{plain}{load}"));
        let [first, second] = [&mut one, &mut two].map(|m| words(&events(m, 8.0)));
        assert!(first.len() > 10 && first.len() == second.len(), "{first:?}\n{second:?}");
        for (a, b) in first.iter().zip(&second) {
            assert!(a.0 == b.0 && (a.1 - b.1).abs() < 1e-12 * 8.0, "{a:?} {b:?}");
        }
        for k in 0..4 {
            assert!((one.coordinate(k) - two.coordinate(k)).abs() < 1e-12);
        }
    }
}

/// Roundings of numbers of order one over some ten events, before they are magnified.
const DIGITS: f64 = 2e-13;

/// Random bodies with two to four coupled contacts, with and without friction and stiffness, springs and
/// loads on residual flexibility, in 40 digits: every event, the end, and the sliders' places. Work
/// is stored or lost, and friction never gives energy.
#[test]
fn second_method_random_bodies_in_40_digits() {
    let mut met = 0;
    for row in include_str!("data/residual.txt").lines() {
        let fields: Vec<&str> = row.split(';').collect();
        let text = fields[0].replace('|', "\n");
        let (end, exact, factor) = (numbers(fields[1])[0], numbers(fields[3]), numbers(fields[4])[0]);
        let names: Vec<&str> = fields[2].split_whitespace().collect();
        // Tables, long series of actual states, and the general law at every event.
        for mut m in [moving(&text), moving(&with_company(&text)), moving(&text).by_general_law()] {
            let begin = unaccounted(&m);
            let (mut all, mut lost) = (Vec::new(), vec![0.0; m.energy().branches.len()]);
            for k in 1..=20 {
                all.extend(events(&mut m, end * f64::from(k) / 20.0));
                for (lost, now) in lost.iter_mut().zip(&m.energy().branches) {
                    assert!(now.value() >= *lost - 1e-14, "{row}");
                    *lost = now.value();
                }
            }
            let found = words(&all);
            let own: Vec<&str> = found.iter().map(|own| own.0).collect();
            assert_eq!(own, names.chunks(3).map(|own| own[1]).collect::<Vec<_>>(), "{row}");
            for (own, exact) in found.iter().zip(names.chunks(3)) {
                let time: f64 = exact[2].parse().unwrap();
                assert!((own.1 - time).abs() < DIGITS * factor, "{own:?} {exact:?} in {row}");
            }
            met += all.len();
            let modal = &m.assembly().description.modals[0];
            let modes = modal.first..modal.first + modal.frequencies.len();
            let places = modes.clone().map(|k| m.coordinate(k));
            let sliders = m.states().split_off(2 * m.system().coordinates);
            for (found, exact) in places.chain(modes.map(|k| m.rate(k))).chain(sliders).zip(&exact) {
                assert!((found - exact).abs() < 10.0 * DIGITS * factor, "{found} {exact} in {row}");
            }
            assert!((unaccounted(&m) - begin).abs() < 1e-12, "{} in {row}", unaccounted(&m) - begin);
        }
    }
    assert!(met > 300, "{met}");
}

/// Two points of a body, each with a contact, a spring between them, and loads.
const SHARED: &str = r#"
    name = "Shared"
    gravity = 9.81
    body.base = { motion = { amplitude = 0.01, frequency = 0.7 } }
    body.box = { mass = 0.4 }
    spring.box = { between = ["ground", "box"], stiffness = 60.0, damping = 0.2 }
    body.slide = { mass = 0.3, start = { v = 0.4 } }
    spring.slide = { between = ["ground", "slide"], stiffness = 30.0, damping = 0.1 }
    [modal.m]
    frequencies = [0.7, 1.9, 3.4, 5.2]
    damping_ratio = 0.01
    nodes = { a = { n = [0.9, -0.4, 0.5, 0.8], t = [-0.2, 0.7, 0.3, 0.5] }, b = { n = [0.8, 0.6, -0.5, 0.2], t = [0.1, -0.3, 0.9, 0.4] } }
    residual = { nodes = ["a.n", "a.t", "b.n", "b.t"], flexibility = [[4e-3, 8e-4, 9e-4, 0.0], [8e-4, 3e-3, 2e-4, 5e-4], [9e-4, 2e-4, 5e-3, -6e-4], [0.0, 5e-4, -6e-4, 4e-3]] }
    [contact.a]
    normal = { arms = { base = -1.0, "m.a.n" = 1.0 } }
    tangent = { arms = { "m.a.t" = 1.0 } }
    gap = 0.01
    stiffness = 300.0
    tangential_stiffness = 200.0
    friction = 0.4
    [contact.b]
    normal = ["box", "m.b.n"]
    tangent = ["ground", "slide"]
    gap = 0.02
    tangential_stiffness = 150.0
    friction = 0.3
    [stop.c]
    arms = { "m.a.n" = -1.0, "m.b.n" = 1.0 }
    gap = 0.03
    [spring.ab]
    arms = { "m.a.t" = -1.0, "m.b.t" = 1.0 }
    stiffness = 40.0
    preload = 0.3
    [load.f]
    on = "m.a.n"
    amplitude = 4.0
    frequency = 0.9
    [load.g]
    on = "m.b.t"
    constant = 0.2
    amplitude = 3.0
    frequency = 1.3
"#;

/// What users see fits together at every instant: forces and true elongations obey each element's own law,
/// rates are derivatives of elongations, and nodes are where elements see them.
#[test]
fn invariant_columns_obey_the_law_of_each_element() {
    let mut m = moving(SHARED);
    let d = m.assembly().description.clone();
    let element = |name: &str| d.elements().position(|own| own.dotted() == name).unwrap();
    let body = |name: &str| d.bodies.iter().position(|own| own.name == name).unwrap();
    let [a, b, c, ab] = ["contact.a", "contact.b", "stop.c", "spring.ab"].map(element);
    let (mut pressed, h) = ([0; 3], 1e-6);
    for k in 1..=400 {
        m.advance_to(0.02 * f64::from(k)).unwrap();
        let value = |i: usize, what: What| of(&m, i, what);
        let contacts = [(0, a, 300.0, 200.0, 0.01, 0.4), (1, b, f64::INFINITY, 150.0, 0.02, 0.3)];
        for (place, i, kn, kt, gap, friction) in contacts {
            let (e, f) = (value(i, What::E), value(i, What::F));
            if f > 0.0 {
                pressed[place] += 1;
                assert!((e - gap - f / kn).abs() < ROUNDING, "{k}: {e} {f}");
            } else {
                assert!(e <= gap + ROUNDING, "{k}: {e}");
            }
            let slider = value(i, What::Slider(None));
            let limit = friction * f + 1e2 * ROUNDING;
            assert!(value(i, What::TangentF(None)).abs() <= limit, "{k}: beyond the limit {limit}");
            assert!(
                (value(i, What::TangentF(None)) - kt * (value(i, What::TangentE(None)) - slider)).abs()
                    < 1e2 * ROUNDING
            );
        }
        let (e, f) = (value(c, What::E), value(c, What::F));
        pressed[2] += i32::from(f > 0.0);
        assert!(if f > 0.0 { (e - 0.03).abs() < ROUNDING } else { e < 0.03 + ROUNDING }, "{k}: {e} {f}");
        assert!((value(ab, What::F) - 0.3 - 40.0 * value(ab, What::E)).abs() < 1e2 * ROUNDING);
        let [an, bn, bt, at] = ["m.a.n", "m.b.n", "m.b.t", "m.a.t"].map(|name| m.coordinate(body(name)));
        assert!(
            (value(c, What::E) - (bn - an)).abs() < ROUNDING
                && (value(ab, What::E) - (bt - at)).abs() < ROUNDING
        );
        assert!((value(a, What::E) - (an - m.coordinate(body("base")))).abs() < ROUNDING);
        // Rates, if no event is near.
        let mut later = m.clone();
        let events = events(&mut later, m.time() + h);
        for (i, pairs) in [(a, 2), (b, 2), (c, 1), (ab, 1)].into_iter().filter(|_| events.is_empty()) {
            let both = [(What::E, What::Rate), (What::Slider(None), What::SliderRate(None))];
            for (e, rate) in both.into_iter().take(pairs) {
                let by = (of(&later, i, e) - value(i, e)) / h;
                assert!((by - 0.5 * (value(i, rate) + of(&later, i, rate))).abs() < 1e-7, "{k} {i} {by}");
            }
        }
        for node in ["m.a.n", "m.b.t"].map(body).into_iter().filter(|_| events.is_empty()) {
            let [_, v, acceleration] = m.body(node);
            let by = (later.body(node)[1] - v) / h;
            assert!(
                (by - 0.5 * (acceleration + later.body(node)[2])).abs() < 1e-5,
                "{k} {by} {acceleration}"
            );
        }
    }
    assert!(pressed.iter().all(|count| *count > 20), "{pressed:?}");
}

/// A saved state, and a start from the present state, continue the motion; so do changed parameters.
#[test]
fn second_method_a_motion_continues_from_its_states() {
    let (mut m, end) = (moving(SHARED), 3.0);
    let begin = unaccounted(&m);
    let mut exact = m.clone();
    exact.advance_to(end).unwrap();
    assert!((unaccounted(&exact) - begin).abs() < 1e-12);
    for k in 1..30 {
        m.advance_to(0.1 * f64::from(k)).unwrap();
        let mut same = Motion::from_state(m.assembly().clone(), m.time(), &m.states()).unwrap();
        same.advance_to(end).unwrap();
        assert!((same.coordinate(1) - exact.coordinate(1)).abs() < 1e-10, "{k}");
        let mut changed = m.changed(m.assembly().clone()).unwrap();
        changed.advance_to(end).unwrap();
        assert!((changed.coordinate(1) - exact.coordinate(1)).abs() < 1e-10, "{k}");
        let mut resumed = Motion::resumed(m.assembly().clone(), &m.save()).unwrap();
        resumed.advance_to(end).unwrap();
        let mut own = m.clone();
        own.advance_to(end).unwrap();
        assert_eq!(resumed.coordinate(1), own.coordinate(1));
    }
}

/// A difference of motions over 1e-6 has half of its square as its error, magnified by some events.
const DIFFERENCE: f64 = 1e-5;

/// Variations by the coordinates and rates of a start are differences of motions, through every event.
#[test]
fn second_method_variations_are_differences() {
    let (mut m, end, h) = (moving(SHARED), 1.5, 1e-6);
    let start = m.states();
    let mut variations = m.unit_variations();
    while m.advance_with(end, &mut variations).unwrap() == Reached::Event {}
    let n = m.system().coordinates;
    for k in 0..2 * n {
        let side = |sign: f64| {
            let mut other = start.clone();
            other[k] += sign * h;
            let mut own = Motion::from_state(m.assembly().clone(), 0.0, &other).unwrap();
            own.advance_to(end).unwrap();
            own.states()
        };
        let (above, below) = (side(1.0), side(-1.0));
        for j in 0..2 * n {
            let by = (above[j] - below[j]) / (2.0 * h);
            assert!(
                (variations[k][j] - by).abs() < DIFFERENCE * (1.0 + by.abs()),
                "{k} {j}: {} {by}",
                variations[k][j]
            );
        }
    }
}

/// A contact that starts pressed, beyond the limit of its friction: the slider is put to the nearest
/// allowed place.
#[test]
fn closed_form_a_start_beyond_the_limit_of_friction() {
    let text = |slider: f64| {
        format!(
            "name = \"A\"\n[modal.m]\nfrequencies = [1.0, 2.0]\nnodes = {{ p = {{ n = [1.0, 0.0], t = [0.0, 1.0] }} }}\n\
             residual = {{ nodes = [\"p.n\", \"p.t\"], flexibility = [[1e-2, 4e-3], [4e-3, 2e-2]] }}\n\
             start = {{ q = [0.1, 0.3], v = [0.0, 0.0] }}\n[contact.c]\nbetween = [\"ground\", \"m.p\"]\nnormal = \"n\"\n\
             tangent = \"t\"\ngap = 0.0\nstiffness = 200.0\ntangential_stiffness = 100.0\nfriction = 0.5\nslider = {slider:?}\n"
        )
    };
    // Slip: (1/kn + Gnn + mu Gnt) N = 0.1. Stick: the slider stays.
    for (slider, is_slipping) in [(0.0, true), (0.29, false)] {
        let m = moving(&text(slider));
        let (normal, tangential) = (of(&m, 1, What::F), of(&m, 1, What::TangentF(None)));
        if is_slipping {
            let exact = 0.1 / (5e-3 + 1e-2 + 0.5 * 4e-3);
            assert!((normal - exact).abs() < 1e-12 && (tangential - 0.5 * exact).abs() < 1e-12);
            // e_t = 0.3 - G_tn N - G_tt T, and T = k_t (e_t - w).
            let place = 0.3 - 4e-3 * exact - 3e-2 * 0.5 * exact;
            assert!((of(&m, 1, What::Slider(None)) - place).abs() < 1e-14);
        } else {
            assert!((of(&m, 1, What::Slider(None)) - slider).abs() < 1e-15);
            let det = 1.5e-2 * 3e-2 - 4e-3 * 4e-3;
            assert!((normal - (0.1 * 3e-2 - 0.01 * 4e-3) / det).abs() < 1e-12);
            assert!((tangential - (1.5e-2 * 0.01 - 4e-3 * 0.1) / det).abs() < 1e-12);
        }
    }
}

/// Derivatives by gaps, stiffnesses, friction, preloads and loads in 40 digits, through every event of
/// coupled contacts; the gradient has the same.
#[test]
fn second_method_derivatives_in_40_digits() {
    let count = compare_derivatives(include_str!("data/residual_by.txt"), |d, k| {
        let modes = d.modals[0].frequencies.len();
        Quantity::of_body(d.modals[0].first + k % modes, [What::S, What::V][k / modes])
    });
    assert!(count > 10, "{count}");
}

/// Derivatives of all values at the end, of all event times and of largest values by all numbers, also
/// with the signals of a varied frequency, are differences of motions.
#[test]
fn second_method_derivatives_are_differences() {
    let (d, end) = (machine(SHARED), 1.5);
    // A dashpot on residual flexibility is refused, so that it has no differences.
    let (names, met) = differences::compare(&d, end);
    assert!(met > 10 && names.len() > 40, "{met} {names:?}");
    let columns: Vec<&str> = names.iter().map(String::as_str).collect();
    let followed = |d: Description, columns: &[&str]| {
        let mut largest: Vec<Extremes> = d.quantities().map(Extremes::new).collect();
        let (mut times, mut m) =
            (Vec::new(), Differentiated::new(Arc::new(Assembly::new(d).unwrap()), columns).unwrap());
        let mut note = |event: &Event, by: &[Option<f64>]| times.push((event.time, by.to_vec()));
        m.advance_with_extremes(end, &mut largest, &mut note).unwrap();
        let largest: Vec<_> = largest.iter().map(|own| own.highest().unwrap().clone()).collect();
        (largest, times)
    };
    let (largest, times) = followed(d.clone(), &columns);
    let mut at_two_times = 0;
    for (p, name) in names.iter().enumerate() {
        let (value, near) = (d.get(name).unwrap(), DIFFERENCE);
        let h = 1e-6 * value.abs().max(1e-2);
        let [above, below] = [h, -h].map(|h| followed(d.with([(name.as_str(), value + h)]).unwrap(), &[]));
        for (k, own) in largest.iter().enumerate() {
            let exact = (above.0[k].value - below.0[k].value) / (2.0 * h);
            // A largest value at two times, such as 0 of a stop, has no derivative.
            match &own.by[p] {
                Err(_) => at_two_times += 1,
                Ok(found) => {
                    assert!(
                        (found - exact).abs() < near * (1.0 + exact.abs()),
                        "{k} by {name}: {found} {exact}"
                    );
                }
            }
        }
        for (k, (time, by)) in times.iter().enumerate() {
            let exact = (above.1[k].0 - below.1[k].0) / (2.0 * h);
            let found = by[p].unwrap();
            assert!((found - exact).abs() < near * (1.0 + exact.abs()), "{time} by {name}: {found} {exact}");
        }
    }
    assert!(10 * at_two_times < largest.len() * names.len(), "{at_two_times}");
}

/// The derivatives of a motion under way, by numbers and by its state, are those from its state.
#[test]
fn second_method_derivatives_from_now_on_are_those_from_the_state() {
    let mut m = moving(SHARED);
    m.advance_to(0.6).unwrap();
    let names = ["contact.a.friction", "contact.b.gap", "spring.ab.stiffness", "load.g.frequency"];
    let mut one = Differentiated::from_state(m.assembly().clone(), 0.6, &m.states(), &names).unwrap();
    let mut other = Differentiated::from_motion(m.clone(), &names).unwrap();
    [&mut one, &mut other].into_iter().for_each(|own| own.advance_to(1.5).unwrap());
    for quantity in m.assembly().description.quantities() {
        for (p, name) in names.iter().enumerate() {
            let [a, b] = [&one, &other].map(|own| own.derivative(quantity, p).unwrap());
            assert!((a - b).abs() < BY * (1.0 + a.abs()), "{quantity:?} by {name}: {a} {b}");
        }
    }
    // By the state: the variations of the motion.
    let columns: Vec<By> = (0..2 * m.system().coordinates).map(By::Start).collect();
    let mut by = Differentiated::from_state(m.assembly().clone(), 0.6, &m.states(), &columns).unwrap();
    by.advance_to(1.5).unwrap();
    let mut own = Motion::from_state(m.assembly().clone(), 0.6, &m.states()).unwrap();
    let mut variations = own.unit_variations();
    while own.advance_with(1.5, &mut variations).unwrap() == Reached::Event {}
    for (k, variation) in variations.iter().take(columns.len()).enumerate() {
        for (a, b) in variation.iter().take(columns.len()).zip(by.state_derivative(k).unwrap()) {
            assert!((a - b).abs() < BY * (1.0 + a.abs()), "by {k}: {a} {b}");
        }
    }
}

/// All principal minors are positive up to the largest friction that the refusal names.
#[test]
fn closed_form_friction_is_unique_below_its_bound() {
    // One contact: mu |Gnt| < Gnn + 1/kn.
    let one = |friction: f64| {
        format!(
            "name = \"A\"\n[modal.m]\nfrequencies = [1.0, 2.0]\nnodes = {{ p = {{ n = [1.0, 0.0], t = [0.0, 1.0] }} }}\n\
             residual = {{ nodes = [\"p.n\", \"p.t\"], flexibility = [[1e-2, 8e-3], [8e-3, 1e-2]] }}\n[contact.c]\n\
             between = [\"ground\", \"m.p\"]\nnormal = \"n\"\ntangent = \"t\"\ngap = 0.0\nstiffness = 500.0\n\
             tangential_stiffness = 100.0\nfriction = {friction:?}\n"
        )
    };
    machine(&one(1.4999));
    assert!(refusal(&one(1.5001)).contains("expected at most 1.500000, or"), "{}", refusal(&one(1.5001)));
    // Ten contacts, by the least eigenvalue.
    let many = |friction: f64| {
        let nodes: Vec<String> =
            (0..10).map(|k| format!("p{k} = {{ n = [1.0, {k}.0], t = [-1.0, 0.5] }}")).collect();
        let names: Vec<String> =
            (0..10).flat_map(|k| [format!("\"p{k}.n\""), format!("\"p{k}.t\"")]).collect();
        let entry = |i: usize, j: usize| match (i == j, i / 2 == j / 2) {
            (true, _) => "1e-2",
            (_, true) => "4e-3",
            _ => "1e-5",
        };
        let row = |i: usize| format!("[{}]", (0..20).map(|j| entry(i, j)).collect::<Vec<_>>().join(", "));
        let rows: Vec<String> = (0..20).map(row).collect();
        let contacts = (0..10).map(|k| {
            format!(
                "[contact.c{k}]\nbetween = [\"ground\", \"m.p{k}\"]\nnormal = \"n\"\ntangent = \"t\"\ngap = 0.0\nstiffness = 500.0\n\
                 tangential_stiffness = 100.0\nfriction = {friction:?}\n"
            )
        });
        format!(
            "name = \"A\"\n[modal.m]\nfrequencies = [1.0, 2.0]\nnodes = {{ {} }}\nresidual = {{ nodes = [{}], flexibility = [{}] }}\n{}",
            nodes.join(", "),
            names.join(", "),
            rows.join(", "),
            contacts.collect::<String>()
        )
    };
    // Scaled to a diagonal of 1, the least eigenvalue is about 1 - 0.26, and slips add 0.26 √(0.02/0.012)
    // of the friction.
    machine(&many(0.5));
    assert!(refusal(&many(3.0)).contains("the force would not be unique"));
}
