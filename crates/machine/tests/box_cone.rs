//! Contacts with two tangents, each with the whole limit of friction (cone "box").

use crate::common::contacts::words;
use crate::common::*;
use vibro_machine::derivative::Gradient;
use vibro_machine::file::no_records;
use vibro_machine::motion::Event;
use vibro_machine::{Assembly, Description, Differentiated, Motion, Quantity, Start, What};

/// Some hundred roundings of numbers of order one.
const ROUNDING: f64 = 1e-12;

/// Rounding over some fifty events, which magnify it.
const OF_MOTION: f64 = 1e-10;

/// Relative rounding of derivatives over some fifty events.
const BY: f64 = 1e-8;

/// Three coordinates of a body that rubs on an oblique contact, and a second body on the first,
/// with the numbers of both contacts as parameters.
const OBLIQUE: &str = r#"
    name = "Box"
    [parameters]
    k = 200.0
    k2 = 90.0
    mu = 0.35
    mu2 = 0.6
    preload = 1.5
    kt = 150.0
    kt2 = 100.0
    gap = 0.02
    place = 0.003
    [body]
    n = { mass = 1.0, start = { v = 1.0 } }
    t = { mass = 1.3, start = { v = -0.5 } }
    s = { mass = 0.9, start = { v = 0.7 } }
    far = { mass = 0.7 }
    [spring]
    n = { between = ["ground", "n"], stiffness = 30.0, damping = 0.1 }
    t = { between = ["ground", "t"], stiffness = 20.0, damping = 0.1 }
    s = { between = ["ground", "s"], stiffness = 25.0, damping = 0.1 }
    nt = { between = ["n", "t"], stiffness = 9.0 }
    ns = { between = ["n", "s"], stiffness = 5.0 }
    far = { between = ["t", "far"], stiffness = 15.0 }
    [load]
    fn = { on = "n", constant = 4.0, amplitude = 9.0, frequency = 0.9 }
    ft = { on = "t", amplitude = 6.0, frequency = 0.7, phase = 1.0 }
    fs = { on = "s", amplitude = 5.0, frequency = 1.1 }
"#;

/// The contacts of [`OBLIQUE`], each with two tangents.
const BOXES: &str = r#"
    [contact.a]
    normal = ["ground", "n"]
    tangent = { arms = { t = 1.0, n = 0.3 } }
    second_tangent = { arms = { s = 1.0, t = -0.4 } }
    cone = "box"
    gap = "= gap"
    stiffness = "= k"
    tangential_stiffness = ["= kt", "= kt2"]
    friction = "= mu"
    slider = ["= place", -0.002]
    [contact.b]
    normal = ["n", "far"]
    tangent = ["far", "t"]
    second_tangent = ["far", "s"]
    cone = "box"
    preload = "= preload"
    stiffness = "= k2"
    tangential_stiffness = [70.0, 50.0]
    friction = "= mu2"
"#;

/// The same contacts as one with one tangent next to another: half the normal stiffness and twice
/// the coefficient of friction each.
const HALVES: &str = r#"
    [contact.a0]
    normal = ["ground", "n"]
    tangent = { arms = { t = 1.0, n = 0.3 } }
    gap = "= gap"
    stiffness = "= k / 2"
    tangential_stiffness = "= kt"
    friction = "= 2 * mu"
    slider = "= place"
    [contact.a1]
    normal = ["ground", "n"]
    tangent = { arms = { s = 1.0, t = -0.4 } }
    gap = "= gap"
    stiffness = "= k / 2"
    tangential_stiffness = "= kt2"
    friction = "= 2 * mu"
    slider = -0.002
    [contact.b0]
    normal = ["n", "far"]
    tangent = ["far", "t"]
    preload = "= preload / 2"
    stiffness = "= k2 / 2"
    tangential_stiffness = 70.0
    friction = "= 2 * mu2"
    [contact.b1]
    normal = ["n", "far"]
    tangent = ["far", "s"]
    preload = "= preload / 2"
    stiffness = "= k2 / 2"
    tangential_stiffness = 50.0
    friction = "= 2 * mu2"
"#;

/// The first contact's element.
const FIRST: usize = 6;

fn boxed() -> String {
    OBLIQUE.to_owned() + BOXES
}

fn halved() -> String {
    OBLIQUE.to_owned() + HALVES
}

/// A quantity along tangent `k` of contact `i`, of boxes and of halves.
fn both(i: usize, k: usize, what: fn(Option<usize>) -> What) -> [Quantity; 2] {
    let one = Quantity::of_element(FIRST + i, what(Some(k)));
    [one, Quantity::of_element(FIRST + 2 * i + k, what(None))]
}

/// Times of events with the names of a machine of boxes: `press contact.a`, `slip+ contact.a[0]`.
/// Both halves close and open at once.
fn named(assembly: &Assembly, events: &[Event]) -> Vec<(String, f64)> {
    let mut all: Vec<(String, f64)> = Vec::new();
    for (event, (word, time)) in events.iter().zip(words(events)) {
        let name = assembly.name_of_contact(event.contact().unwrap());
        let (of, half) = name.split_at("contact.a".len());
        let index = if half.is_empty() || half.starts_with('[') { half.into() } else { format!("[{half}]") };
        let own = match word {
            "press" | "free" => format!("{word} {of}"),
            _ => format!("{word} {of}{index}"),
        };
        if all.last().is_none_or(|last| last.0 != own || (last.1 - time).abs() > OF_MOTION) {
            all.push((own, time));
        }
    }
    // The order of events at one instant is that of the stops and sliders.
    all.sort_by(|a, b| if (a.1 - b.1).abs() < OF_MOTION { a.0.cmp(&b.0) } else { a.1.total_cmp(&b.1) });
    all.dedup_by(|a, b| a.0 == b.0 && (a.1 - b.1).abs() < OF_MOTION);
    all
}

/// Compares all bodies, forces, elongations, sliders and energies of boxes and halves.
#[track_caller]
fn compare(one: &Motion, other: &Motion, allowed: f64) {
    for i in 0..4 {
        let [a, b] = [one, other].map(|m| m.body(i));
        (0..3).for_each(|k| near(a[k], b[k], 100.0 * allowed));
    }
    for i in 0..2 {
        let normal = of(one, FIRST + i, What::F);
        let halves = of(other, FIRST + 2 * i, What::F) + of(other, FIRST + 2 * i + 1, What::F);
        near(normal, halves, 100.0 * allowed);
        for k in 0..2 {
            for what in [What::TangentE, What::TangentF, What::Slider] {
                let [own, half] = both(i, k, what);
                near(one.value(own), other.value(half), 100.0 * allowed);
            }
            near(
                one.energy().branches[2 * i + k].value(),
                other.energy().branches[2 * i + k].value(),
                allowed,
            );
        }
    }
    let [a, b] = [one, other].map(Motion::kinetic_and_stored);
    near(a.0, b.0, allowed);
    near(a.1, b.1, allowed);
}

/// A contact with two tangents is two contacts with one tangent each, half the normal stiffness
/// and twice the coefficient of friction: the same events, states, forces and losses.
#[test]
fn second_method_two_tangents_are_two_contacts_in_parallel() {
    let [mut one, mut other] = [boxed(), halved()].map(|text| moving(&text));
    compare(&one, &other, ROUNDING);
    let begin = unaccounted(&one);
    let (mut found, mut exact) = (Vec::new(), Vec::new());
    for k in 1..=60 {
        for (m, all) in [(&mut one, &mut found), (&mut other, &mut exact)] {
            m.advance_observed(0.1 * f64::from(k), &mut |event| all.push(event.clone())).unwrap();
        }
        compare(&one, &other, OF_MOTION);
        near(unaccounted(&one), begin, ROUNDING);
    }
    let [found, exact] = [(&one, found), (&other, exact)].map(|(m, all)| named(m.assembly(), &all));
    assert!(found.len() > 60, "{}", found.len());
    for (word, time) in &found {
        assert!(exact.iter().any(|own| own.0 == *word && (own.1 - time).abs() < OF_MOTION), "{word} {time}");
    }
    assert_eq!(found.len(), exact.len());
    for word in [
        "press",
        "free",
        "slip+ contact.a[0]",
        "slip- contact.a[1]",
        "stick contact.b[0]",
        "stick contact.b[1]",
    ] {
        assert!(found.iter().any(|own| own.0.starts_with(word)), "{word}");
    }
    // Without tables, and by the general law at every event.
    for mut m in [moving(&with_company(&boxed())), moving(&boxed()).by_general_law()] {
        let all = events(&mut m, 6.0);
        let all = named(m.assembly(), &all);
        assert_eq!(all.len(), found.len());
        all.iter().zip(&found).for_each(|(a, b)| assert!(a.0 == b.0 && (a.1 - b.1).abs() < OF_MOTION));
    }
}

/// |T| <= μ N along each tangent, the slider is at rest while |T| < μ N, and friction never gives
/// energy.
#[test]
fn invariant_each_tangent_has_the_whole_limit() {
    let mut m = moving(&boxed());
    let (mut met, mut lost) = ([0; 3], vec![0.0; 4]);
    for time in 1..=1200 {
        m.advance_to(0.005 * f64::from(time)).unwrap();
        for (i, friction) in [(0, 0.35), (1, 0.6)] {
            let limit = friction * of(&m, FIRST + i, What::F);
            for k in 0..2 {
                let [force, rate] =
                    [What::TangentF, What::SliderRate].map(|what| of(&m, FIRST + i, what(Some(k))));
                assert!(force.abs() <= limit + ROUNDING, "{force} {limit}");
                match limit {
                    0.0 => met[0] += 1,
                    _ if force.abs() < limit - ROUNDING => {
                        met[1] += 1;
                        assert_eq!(rate, 0.0);
                    }
                    _ => {
                        met[2] += 1;
                        assert!(rate * force >= -ROUNDING, "{rate} {force}");
                    }
                }
                let own = m.energy().branches[2 * i + k].value();
                assert!(own >= lost[2 * i + k] - 1e-14);
                lost[2 * i + k] = own;
            }
        }
    }
    assert!(met.iter().all(|count| *count > 100) && lost.iter().all(|lost| *lost > 0.1), "{met:?} {lost:?}");
}

/// A block under a constant force N slides along both tangents at once. Along each it is stuck up
/// to the stretch μ N/k, is braked with μ N/m, and then sticks and oscillates about its slider.
#[test]
fn closed_form_a_block_slides_along_both_tangents_independently() {
    // N = 128 · 0.25 N without rounding.
    let (mass, limit) = (2.0_f64, 0.25 * 128.0 * 0.25);
    let directions = [("x", 400.0_f64, 1.5_f64), ("z", 250.0, -0.9)];
    let text = "name = \"Block\"\nbody.seat = { motion = { constant = 0.25 } }\n\
        body.x = { mass = 2.0, start = { v = 1.5 } }\nbody.z = { mass = 2.0, start = { v = -0.9 } }\n\
        contact.c = { normal = [\"ground\", \"seat\"], tangent = [\"ground\", \"x\"], second_tangent = [\"ground\", \"z\"], \
        cone = \"box\", gap = 0.0, stiffness = 128.0, tangential_stiffness = [400.0, 250.0], friction = 0.25 }\n";
    let end = 0.9;
    let mut m = moving(text);
    let all = events(&mut m, end);
    let found = words(&all);
    for (k, (body, stiffness, speed)) in directions.into_iter().enumerate() {
        let (omega, sign) = ((stiffness / mass).sqrt(), speed.signum());
        let stretch = limit / stiffness;
        let slip = (omega * stretch / speed.abs()).asin() / omega;
        let left = (speed * speed - (omega * stretch).powi(2)).sqrt();
        let stick = slip + left * mass / limit;
        let place = sign * (stretch + 0.5 * left * left * mass / limit);
        let slider = place - sign * stretch;
        let own = found.iter().zip(&all).filter(|(_, event)| {
            m.assembly().name_of_contact(event.contact().unwrap()) == format!("contact.c[{k}]")
        });
        let own: Vec<_> = own.map(|own| *own.0).collect();
        let word = if sign > 0.0 { "slip+" } else { "slip-" };
        assert_eq!(own.iter().map(|own| own.0).collect::<Vec<_>>(), [word, "stick"], "{body}");
        near(own[0].1, slip, ROUNDING);
        near(own[1].1, stick, ROUNDING);
        near(m.coordinate(1 + k), slider + sign * stretch * (omega * (end - stick)).cos(), ROUNDING);
        near(of(&m, 0, What::Slider(Some(k))), slider, ROUNDING);
        near(m.energy().branches[k].value(), limit * slider.abs(), ROUNDING);
    }
}

/// Derivatives by every number of boxes, and gradients, are those of halves.
#[test]
fn second_method_derivatives_are_those_of_two_contacts() {
    let names =
        ["k", "k2", "mu", "mu2", "preload", "kt", "kt2", "gap", "place", "body.s.mass", "load.fs.amplitude"];
    let [one, other] = [boxed(), halved()].map(|text| assembled(&text));
    let both = [(one, true), (other, false)].map(|(assembly, is_boxed)| {
        let mut by = Differentiated::new(assembly.clone(), &names).unwrap();
        let mut sum = Gradient::new(assembly, by.columns()).unwrap();
        by.advance_to(2.0).unwrap();
        sum.advance_to(2.0).unwrap();
        let mut all: Vec<Quantity> =
            (0..4).flat_map(|i| [What::S, What::V].map(|what| Quantity::of_body(i, what))).collect();
        for (i, k) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let own = [What::TangentE, What::TangentF, What::Slider, What::SliderRate].map(|what| {
                let [one, other] = self::both(i, k, what);
                if is_boxed { one } else { other }
            });
            all.extend(own);
        }
        let columns: Vec<Vec<f64>> = (0..names.len())
            .map(|p| {
                all.iter()
                    .map(|own| by.derivative(*own, p).unwrap_or_else(|| panic!("{:?}", by.lost(p))))
                    .collect()
            })
            .collect();
        for (k, own) in all.iter().enumerate() {
            sum.add(*own, 1.0 - 0.07 * k as f64);
        }
        (columns, sum.gradient().unwrap())
    });
    let [(one, gradient), (other, _)] = both;
    for (p, name) in names.iter().enumerate() {
        let size = other[p].iter().fold(1e-3, |most: f64, x| most.max(x.abs()));
        for (a, b) in one[p].iter().zip(&other[p]) {
            assert!((a - b).abs() < BY * size, "{name}: {a} {b}");
        }
        let sum: f64 = one[p].iter().enumerate().map(|(k, x)| (1.0 - 0.07 * k as f64) * x).sum();
        let found = gradient[p].clone().unwrap();
        assert!((found - sum).abs() < 10.0 * BY * size, "{name}: {found} {sum}");
    }
}

/// Steps of prescribed ends move both sliders; a start at rest has both at 0 or at their limits.
#[test]
fn second_method_steps_and_a_start_at_rest() {
    let steps = |contacts: &str| {
        format!(
            "name = \"Steps\"\nbody.n = {{ motion = {{ constant = 0.1, steps = [[0.2, -0.06], [0.3, -0.08], [0.5, 0.12]] }} }}\n\
             body.t = {{ motion = {{ steps = [[0.1, 0.03], [0.15, 0.05], [0.4, 0.2], [0.5, -0.02], [0.6, -0.5]] }} }}\n\
             body.s = {{ motion = {{ steps = [[0.12, -0.05], [0.2, 0.1], [0.5, 0.07], [0.55, 0.4]] }} }}\n\
             body.box = {{ mass = 1.0 }}\nspring.k = {{ between = [\"ground\", \"box\"], stiffness = 1.0 }}\n{contacts}"
        )
    };
    let of_step = |name: &str, tangents: &str, k: f64, mu: f64| {
        format!(
            "contact.{name} = {{ normal = [\"ground\", \"n\"], {tangents}, gap = 0.0, stiffness = {k:?}, friction = {mu:?} }}\n"
        )
    };
    let t = "tangent = [\"ground\", \"t\"]";
    let boxed_step = format!(
        "{t}, second_tangent = [\"ground\", \"s\"], cone = \"box\", tangential_stiffness = [50.0, 40.0]"
    );
    let halves = of_step("a", &format!("{t}, tangential_stiffness = 50.0"), 50.0, 0.4)
        + &of_step("b", "tangent = [\"ground\", \"s\"], tangential_stiffness = 40.0", 50.0, 0.4);
    let [mut one, mut other] =
        [of_step("c", &boxed_step, 100.0, 0.2), halves].map(|contacts| moving(&steps(&contacts)));
    let begin = unaccounted(&one);
    for k in 1..=70 {
        one.advance_to(0.01 * f64::from(k) + 0.005).unwrap();
        other.advance_to(0.01 * f64::from(k) + 0.005).unwrap();
        for k in 0..2 {
            near(of(&one, 1, What::TangentF(Some(k))), of(&other, 1 + k, What::TangentF(None)), ROUNDING);
            near(of(&one, 1, What::Slider(Some(k))), of(&other, 1 + k, What::Slider(None)), ROUNDING);
            near(one.energy().branches[k].value(), other.energy().branches[k].value(), ROUNDING);
        }
        near(unaccounted(&one), begin, ROUNDING);
    }
    assert!(one.energy().branches.iter().all(|own| own.value() > 0.01));

    let at_rest = |text: String, [x, y, z]: [f64; 3]| {
        let start = text.find("    [load]").unwrap();
        let contacts = text.find("    [contact").unwrap();
        let text = text[..start].to_owned()
            + &format!(
                "    [load]\n    fn = {{ on = \"n\", constant = {x:?} }}\n    ft = {{ on = \"t\", constant = {y:?} }}\n    fs = {{ on = \"s\", constant = {z:?} }}\n"
            )
            + &text[contacts..];
        let text = text.replace("slider = [\"= place\", -0.002]\n", "").replace("slider = \"= place\"\n", "");
        let text = text.replace("slider = -0.002\n", "").replace("    place = 0.003\n", "");
        let text = text.replace(", start = { v = 1.0 }", "").replace(", start = { v = -0.5 }", "");
        moving(&text.replace(", start = { v = 0.7 }", "").replacen(
            "    name",
            "    start = \"rest\"\n    name",
            1,
        ))
    };
    let mut slipped = [0; 2];
    for loads in [[9.0, 3.0, 0.5], [9.0, 0.5, -6.0], [9.0, 8.0, 7.0], [0.2, 1.0, 2.0]] {
        let [one, other] = [boxed(), halved()].map(|text| at_rest(text, loads));
        compare(&one, &other, ROUNDING);
        for (k, slipped) in slipped.iter_mut().enumerate() {
            let slider = of(&one, FIRST, What::Slider(Some(k)));
            *slipped += usize::from(slider != 0.0 && of(&one, FIRST, What::F) > 0.0);
        }
    }
    assert!(slipped.iter().all(|count| *count > 0 && *count < 4), "{slipped:?}");
}

/// A motion continues from its saved state, from its states, and from its start, as a file, as a
/// line and set by name.
#[test]
fn second_method_a_motion_continues_from_its_start() {
    let mut m = moving(&boxed());
    let assembly = m.assembly().clone();
    let d: &Description = &assembly.description;
    for k in 1..20 {
        m.advance_to(0.3 * f64::from(k)).unwrap();
        let mut exact = m.clone();
        exact.advance_to(m.time() + 0.1).unwrap();
        let start = Start::of(&m);
        let text = start.to_toml();
        let read = Start::parse(&text, "start.toml", d).unwrap_or_else(|refusal| panic!("{refusal}"));
        assert_eq!(read, start);
        let mut set = Start::default();
        for (name, value) in start.numbers() {
            set.set(d, &name, value).unwrap();
        }
        assert_eq!(set, start);
        let line = Start::try_from(String::from(start.clone())).unwrap();
        assert_eq!(line.numbers().len(), start.numbers().len());
        for own in [start, line] {
            let mut same = own.motion(assembly.clone()).unwrap();
            same.advance_to(exact.time()).unwrap();
            near(same.coordinate(2), exact.coordinate(2), OF_MOTION);
        }
        let mut same = Motion::resumed(assembly.clone(), &m.save()).unwrap();
        same.advance_to(exact.time()).unwrap();
        assert_eq!(same.states(), exact.states());
    }
    let text = Start::of(&m).to_toml();
    assert!(text.contains("[contact.a]\n\"slider[0]\" = "), "{text}");
    let names = Start::names(&assembly);
    let sliders: Vec<&str> = names.iter().filter(|own| own.contains("slider")).map(String::as_str).collect();
    assert_eq!(sliders, ["a.slider[0]", "a.slider[1]", "b.slider[0]", "b.slider[1]"]);
    let wrong = Start::parse("time = 0.0\n[contact.a]\nslider = 0.1\n", "s.toml", d).unwrap_err().to_string();
    assert!(wrong.contains("contact.a.slider = 0.1: no such key; did you mean `slider[0]`?"), "{wrong}");
    let again = vibro_machine::file::parse(&d.to_toml(), "w.toml", &no_records).unwrap();
    assert_eq!(&again, d);
}
