//! Sine sweeps compared with integrals in 40 digits, their formula, harmonics and differences.

use crate::common::*;
use std::f64::consts::TAU;
use vibro_machine::derivative::Gradient;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Differentiated, Motion};

/// Error that the page documents, in amplitudes, plus the same amount of rounding.
const ERROR: f64 = 2e-12;
/// Rounding, amplified by impacts.
const ROUNDING: f64 = 1e-10;
/// Step of central differences, whose error is proportional to its square.
const CHANGE: f64 = 1e-6;
const DIFFERENCE: f64 = 1e-7;

/// Law, from, to, duration and phase; a time; at this time sin φ, its two integrals from time 0
/// on, and the coordinate of an oscillator with m = 1, k = 400, c = 2 from rest, by quadrature in
/// 40 digits (mpmath).
type Known = (&'static str, [f64; 4], f64, [f64; 4]);
const KNOWN: [Known; 16] = [
    (
        "linear",
        [2.0, 7.0, 3.0, 0.3],
        0.4,
        [-0.11859921415770025, 0.01784398485609413, 0.03214145730072349, -0.004701375800965558],
    ),
    (
        "linear",
        [2.0, 7.0, 3.0, 0.3],
        1.1,
        [0.999270445339336, 0.07744903229779372, 0.083257856946958, -0.003703079334531155],
    ),
    (
        "linear",
        [2.0, 7.0, 3.0, 0.3],
        1.9,
        [-0.785978476455795, 0.05781130318608008, 0.14702601981723784, -0.000900550598420385],
    ),
    (
        "linear",
        [2.0, 7.0, 3.0, 0.3],
        3.7,
        [0.3224518299146796, 0.09816667905363617, 0.2840116805200297, 0.0008451295463721601],
    ),
    (
        "linear",
        [7.0, 0.0, 2.0, -1.0],
        0.4,
        [0.767117899660782, 0.031097212086682882, 0.003984648087767791, -0.00011366701232272237],
    ),
    (
        "linear",
        [7.0, 0.0, 2.0, -1.0],
        1.1,
        [0.46323075487309145, 0.05814882802123087, 0.012534881656976233, 0.0030067475593411382],
    ),
    (
        "linear",
        [7.0, 0.0, 2.0, -1.0],
        1.9,
        [-0.8956790053628113, -0.16260970799952917, 0.020608226614591326, -0.005377974644537077],
    ),
    (
        "linear",
        [7.0, 0.0, 2.0, -1.0],
        3.7,
        [-0.8414709848078965, -1.6791344033683158, -1.6386029126787265, -0.0012221718701445085],
    ),
    (
        "logarithmic",
        [1.0, 40.0, 2.5, 0.5],
        0.4,
        [-0.7058634699078242, 0.21172629124573686, 0.059284408889968145, -0.0023562074828148353],
    ),
    (
        "logarithmic",
        [1.0, 40.0, 2.5, 0.5],
        1.1,
        [-0.8540676235763472, 0.1285633434860566, 0.1577077834470457, 0.005062266246745576],
    ),
    (
        "logarithmic",
        [1.0, 40.0, 2.5, 0.5],
        1.9,
        [-0.515650886777168, 0.15193060705718256, 0.2717405224172382, -0.0006371839830692671],
    ),
    (
        "logarithmic",
        [1.0, 40.0, 2.5, 0.5],
        3.7,
        [-0.06509776735432739, 0.1475720297978307, 0.5301789373335692, -0.0005778149383361066],
    ),
    (
        "logarithmic",
        [30.0, 3.0, 2.0, 0.0],
        0.4,
        [-0.6678439844712125, 0.01150744493444777, 0.002171114422319428, 0.00022934253247971806],
    ),
    (
        "logarithmic",
        [30.0, 3.0, 2.0, 0.0],
        1.1,
        [-0.9739886023804587, 0.009169911094454813, 0.006184283934235391, 0.00040668635704533667],
    ),
    (
        "logarithmic",
        [30.0, 3.0, 2.0, 0.0],
        1.9,
        [0.7457334421656516, -0.024129159843588807, 0.008230898515215, -0.004397143627477971],
    ),
    (
        "logarithmic",
        [30.0, 3.0, 2.0, 0.0],
        3.7,
        [-0.3203605067350826, 0.056142037019289166, 0.022015327378636707, 0.009092090752500259],
    ),
];

fn sweep(law: &str, [from, to, duration, phase]: [f64; 4]) -> String {
    format!(
        "sweep = {{ amplitude = 1.0, from = {from:?}, to = {to:?}, duration = {duration:?}, phase = {phase:?}, law = \"{law}\" }}"
    )
}

#[test]
fn second_method_masses_oscillators_and_bases_under_sweeps() {
    for (law, numbers, time, [value, once, twice, place]) in KNOWN {
        let sweep = sweep(law, numbers);
        let mut m = moving(&format!(
            "name = \"All\"\n[body.mass]\nmass = 1.0\n[body.oscillator]\nmass = 1.0\n[load.l]\non = \"mass\"\n{sweep}\n\
             [load.o]\non = \"oscillator\"\n{sweep}\n[spring.k]\nbetween = [\"ground\", \"oscillator\"]\nstiffness = 400.0\n\
             damping = 2.0\n"
        ));
        m.advance_to(time).unwrap();
        near(m.body(0)[0], twice, ERROR * time * time);
        near(m.body(0)[1], once, ERROR * time.max(1.0));
        near(m.body(0)[2], value, ERROR);
        near(m.body(1)[0], place, ERROR);
        for (motion, exact) in [
            (sweep.clone(), [Some(value), None, None]),
            (format!("rate = {{ {sweep} }}"), [Some(once), Some(value), None]),
            (format!("acceleration = {{ {sweep} }}"), [Some(twice), Some(once), Some(value)]),
        ] {
            let mut m = moving(&format!(
                "name = \"Base\"\n[body.base]\nmotion = {{ {motion} }}\n[spring.k]\nbetween = [\"ground\", \"base\"]\nstiffness = 1.0\n"
            ));
            m.advance_to(time).unwrap();
            for (found, exact) in m.body(0).into_iter().zip(exact) {
                exact.into_iter().for_each(|exact| near(found, exact, ERROR * time.max(1.0).powi(2)));
            }
        }
    }
}

/// The phase keeps its digits over hundreds of thousands of turns, however many times it is
/// evaluated on the way.
#[test]
fn closed_form_long_sweeps_at_any_time() {
    for (to, duration) in [(2.0, 64.0), (500.0, 64.0), (4096.0, 1024.0)] {
        let sweep = sweep("linear", [16.0, to, duration, 0.0]);
        let mut m = moving(&format!("name = \"L\"\n[body.b]\nmass = 1.0\n[load.l]\non = \"b\"\n{sweep}\n"));
        let span = 3.0;
        let rise = (to - 16.0) / (2.0 * duration);
        for k in 0..200 {
            // Binary fractions: products with them are exact.
            let time = span * f64::from(k) / 256.0;
            m.advance_to(time).unwrap();
            // Turns by powers of two, less than 2⁴⁰ times 2⁻¹²: exact except for the last product.
            let turns = (16.0 * time).fract() + (rise * time * time).fract();
            near(m.body(0)[2], (TAU * turns).sin(), 20.0 * ERROR);
        }
    }
}

fn rig(signal: &str, bodies: usize) -> String {
    let mut toml = format!(
        "name = \"Rig\"\n[body.b0]\nmass = 1.0\n[spring.k0]\nbetween = [\"ground\", \"b0\"]\nstiffness = 150.0\ndamping = 0.4\n\
         [stop.r]\nbetween = [\"ground\", \"b0\"]\ngap = 0.01\nrestitution = 0.6\n[friction.f]\nbetween = [\"ground\", \"b0\"]\n\
         force = 0.05\n[load.l]\non = \"b0\"\n{signal}\n"
    );
    for i in 1..bodies {
        let before = i - 1;
        toml += &format!(
            "[body.b{i}]\nmass = 0.5\n[spring.k{i}]\nbetween = [\"b{before}\", \"b{i}\"]\nstiffness = 90.0\ndamping = 0.1\n"
        );
    }
    toml
}

fn moved(signal: &str, bodies: usize) -> (Motion, Vec<Event>) {
    let mut m = moving(&rig(signal, bodies));
    let all = events(&mut m, 4.0);
    (m, all)
}

/// A sweep with constant frequency is a harmonic, with tables of modes and without. So is a sweep
/// with an invisibly small change, which is computed in cells.
#[test]
fn second_method_an_even_sweep_is_a_harmonic() {
    for bodies in [1, 12] {
        let (harmonic, those) = moved("amplitude = 2.0\nfrequency = 1.75\nphase = 0.5", bodies);
        assert!(those.len() > 20, "{}", those.len());
        for (to, law) in [(1.75, "linear"), (1.75, "logarithmic"), (1.75 + 1e-15, "logarithmic")] {
            let sweep = format!(
                "sweep = {{ amplitude = 2.0, from = 1.75, to = {to:?}, duration = 3.0, phase = 0.5, law = \"{law}\" }}"
            );
            let (swept, these) = moved(&sweep, bodies);
            // Its only knot is its end.
            assert_eq!(times(&these, |kind| *kind == EventKind::Knot), [3.0]);
            let these: Vec<_> = these.into_iter().filter(|event| event.kind != EventKind::Knot).collect();
            assert_eq!(these.len(), those.len());
            for (a, b) in these.iter().zip(&those) {
                assert_eq!(std::mem::discriminant(&a.kind), std::mem::discriminant(&b.kind));
                near(a.time, b.time, ROUNDING);
            }
            (0..2).for_each(|k| near(swept.body(0)[k], harmonic.body(0)[k], ROUNDING));
        }
    }
}

#[test]
fn second_method_derivatives_and_gradients_by_the_numbers_of_sweeps() {
    for (law, bodies) in [("linear", 1), ("logarithmic", 1), ("logarithmic", 12)] {
        let signal = format!(
            "sweep = [{{ amplitude = 4.0, from = 1.5, to = 4.0, duration = 1.6, phase = 0.5, law = \"{law}\" }}, \
             {{ amplitude = 0.5, from = 6.0, to = 2.0, duration = 3.0 }}]"
        );
        let rig = assembled(&rig(&signal, bodies));
        let all = rig.description.parameters().into_iter().map(|p| p.name);
        let names: Vec<String> = all.filter(|name| name.contains(".sweep[") || name.contains("k0")).collect();
        assert_eq!(names.len(), 13, "{names:?}");
        let end = 2.1;
        let mut varied = Differentiated::new(rig.clone(), &names).unwrap();
        varied.advance_to(end).unwrap();
        assert!(varied.motion().impacts(0).count > 2);
        let mut sum = Gradient::new(rig.clone(), &names).unwrap();
        sum.advance_to(end).unwrap();
        let quantity = rig.description.quantities().next().unwrap();
        sum.add(quantity, 1.0);
        let gradient = sum.gradient().unwrap();
        for (p, name) in names.iter().enumerate() {
            let value = rig.description.get(name).unwrap();
            let at = |value: f64| {
                let mut m = motion(rig.description.with([(name.as_str(), value)]).unwrap());
                m.advance_to(end).unwrap();
                m.body(0)
            };
            let (more, less) = (at(value + CHANGE), at(value - CHANGE));
            let found = varied.state_derivative(p).unwrap_or_else(|| panic!("{name}"));
            let places = [found[0], found[bodies]];
            for (k, found) in places.into_iter().enumerate() {
                let exact = (more[k] - less[k]) / (2.0 * CHANGE);
                assert!(
                    (found - exact).abs() < DIFFERENCE * exact.abs().max(1.0),
                    "{law} {name}: {found} {exact}"
                );
            }
            near(*gradient[p].as_ref().unwrap(), found[0], ROUNDING);
        }
    }
}

#[test]
fn second_method_derivatives_of_integrated_sweeps() {
    for law in ["linear", "logarithmic"] {
        let toml = format!(
            "name = \"Base\"\n[body.b]\nmass = 1.0\n[body.base]\nmotion = {{ acceleration = {{ sweep = {{ amplitude = 3.0, from = 1.5, \
             to = 4.0, duration = 1.6, phase = 0.5, law = \"{law}\" }} }} }}\n[spring.k]\nbetween = [\"base\", \"b\"]\n\
             stiffness = 90.0\ndamping = 1.0\n"
        );
        let rig = assembled(&toml);
        let all = rig.description.parameters().into_iter().map(|p| p.name);
        let names: Vec<String> = all.filter(|name| name.contains(".sweep.")).collect();
        assert_eq!(names.len(), 5, "{names:?}");
        for end in [1.3, 2.1] {
            let mut varied = Differentiated::new(rig.clone(), &names).unwrap();
            varied.advance_to(end).unwrap();
            for (p, name) in names.iter().enumerate() {
                let value = rig.description.get(name).unwrap();
                let at = |value: f64| {
                    let mut m = motion(rig.description.with([(name.as_str(), value)]).unwrap());
                    m.advance_to(end).unwrap();
                    m.body(0)
                };
                let (more, less) = (at(value + CHANGE), at(value - CHANGE));
                let found = varied.state_derivative(p).unwrap_or_else(|| panic!("{name}"));
                for (k, found) in found.iter().enumerate() {
                    let exact = (more[k] - less[k]) / (2.0 * CHANGE);
                    assert!(
                        (found - exact).abs() < DIFFERENCE * exact.abs().max(1.0),
                        "{law} {name}: {found} {exact}"
                    );
                }
            }
        }
    }
}

/// The energy accounts of all signals and motions; cells cause no events.
#[test]
fn invariant_energy_balances_under_sweeps_periods_and_integrals() {
    for motion in [
        "acceleration = { sweep = { amplitude = 3.0, from = 1.0, to = 5.0, duration = 2.0, law = \"logarithmic\" } }, v = 0.1",
        "rate = { steps = [[0.1, 0.4], [0.3, -0.3]], repeat = 0.45, sweep = { amplitude = 0.2, from = 3.0, to = 1.0, duration = 1.5 } }",
        "table = [[0.0, 0.0], [0.1, 0.02], [0.3, -0.01]], interpolation = \"cubic\", repeat = 0.4",
    ] {
        let mut m = moving(&format!(
            "name = \"Balance\"\n[body.b]\nmass = 1.0\nstart = {{ s = 0.01 }}\n[body.base]\nmotion = {{ {motion} }}\n[spring.k]\n\
             between = [\"base\", \"b\"]\nstiffness = 80.0\ndamping = 0.3\n[stop.r]\nbetween = [\"base\", \"b\"]\ngap = 0.03\n\
             restitution = 0.7\n[friction.f]\nbetween = [\"ground\", \"b\"]\nforce = 0.1\n[load.l]\non = \"b\"\n\
             sweep = {{ amplitude = 1.0, from = 2.0, to = 0.5, duration = 2.5 }}\n"
        ));
        let energy = |m: &Motion| m.kinetic_and_stored().0 + m.kinetic_and_stored().1 - m.energy().balance();
        let start = energy(&m);
        let all = events(&mut m, 4.0);
        assert!(all.len() > 10, "{motion}: {}", all.len());
        near(energy(&m), start, ROUNDING);
    }
}

#[test]
fn invariant_what_is_refused_of_sweeps() {
    let refused = |sweep: &str| {
        let toml = format!("name = \"R\"\n[body.b]\nmass = 1.0\n[load.l]\non = \"b\"\nsweep = {sweep}\n");
        parse(&toml, "r.toml", &no_records).unwrap_err().to_string()
    };
    for (sweep, text) in [
        (
            "{ amplitude = 1.0, from = 0, to = \"5 Hz\", duration = 1.0, law = \"logarithmic\" }",
            "r.toml:6: load.l.sweep.from = 0: must be above 0 Hz in a logarithmic sweep",
        ),
        (
            "{ amplitude = 1.0, from = 1.0, to = \"5 Hz\", duration = 0.0 }",
            "r.toml:6: load.l.sweep.duration = 0.0: must be greater than 0",
        ),
        (
            "{ amplitude = 1.0, from = 0, to = 0, duration = 1.0 }",
            "r.toml:6: load.l.sweep.to = 0: `from` and `to` are both 0 Hz; one of them must be above 0 Hz",
        ),
        (
            "{ amplitude = 1.0, from = 1.0, to = 2.0, duration = 1.0, law = \"cubic\" }",
            "r.toml:6: load.l.sweep.law = \"cubic\": expected \"linear\" or \"logarithmic\"",
        ),
        (
            "{ amplitude = 1.0, from = 1.0, too = 2.0, duration = 1.0 }",
            "r.toml:6: load.l.sweep.too = 2.0: no such key; did you mean `to`?",
        ),
        (
            "3.0",
            "r.toml:6: load.l.sweep = 3.0: expected a sweep such as { amplitude = 1.0, from = \"5 Hz\", to = \"15 Hz\", duration = \"60 s\" }, or a list of sweeps",
        ),
    ] {
        assert_eq!(refused(sweep), text);
    }
    let toml = "name = \"R\"\n[body.p]\nmotion = { rate = { sweep = { amplitude = 1.0, from = 1e4, to = 1e6, duration = 1.0 } } }\n\
                [body.b]\nmass = 1.0\n[spring.k]\nbetween = [\"p\", \"b\"]\nstiffness = 1.0\n";
    assert_eq!(
        parse(toml, "r.toml", &no_records).unwrap_err().to_string(),
        "r.toml:3: body.p.motion.rate.sweep.duration = 1.0: the sweep makes 505000 turns; expected at most 100000 in a rate or an acceleration"
    );
}
