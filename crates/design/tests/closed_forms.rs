//! Designs whose optimum is known in closed form.

use std::f64::consts::TAU;
use vibro_design::{Attractor, Check, Control, DesignRequest, Goal, Limit, Stage, Verdict, design};
use vibro_machine::file::{no_records, parse};
use vibro_studies::Machine;
use vibro_studies::design_sweep::{ParameterInterval, SampledAxis};

const CONTROL: Control = Control { go_on: &|| true, progress: &|_| () };

fn machine(text: &str) -> Machine {
    Machine::new(parse(text, "m.toml", &no_records).unwrap())
}

fn interval(name: &str, from: f64, to: f64) -> ParameterInterval<String> {
    ParameterInterval { name: name.into(), from, to }
}

/// Mass ratio of the absorber.
const RATIO: f64 = 0.1;
/// Natural frequency of the body without absorber, Hz.
const NATURAL: f64 = 10.0;

/// An undamped body with an absorber, driven by a load.
fn absorber() -> String {
    let k = (TAU * NATURAL).powi(2);
    format!(
        "name = \"Absorber\"\n[body.box]\nmass = 1.0\n[body.tuned]\nmass = {RATIO}\n\
         [spring.mount]\nbetween = [\"ground\", \"box\"]\nstiffness = {k}\n\
         [spring.absorber]\nbetween = [\"box\", \"tuned\"]\nstiffness = 300.0\ndamping = 1.0\n\
         [load.shaker]\non = \"box\"\namplitude = 1.0\nfrequency = {NATURAL}\n"
    )
}

/// The exact optimal absorber of an undamped body, with the smallest peak amplitude: ratio of the
/// natural frequencies, damping ratio, peak amplitude over the static one (O. Nishihara and T.
/// Asami, J. Vib. Acoust. 124 (2002) 576–582).
fn exact_absorber(mu: f64) -> [f64; 3] {
    let root = (4.0 + 3.0 * mu).sqrt();
    let inner = 2.0 * (16.0 + 23.0 * mu + 9.0 * mu * mu + 2.0 * (2.0 + mu) * root)
        / (3.0 * (64.0 + 80.0 * mu + 27.0 * mu * mu));
    let tuning = 2.0 / (1.0 + mu) * inner.sqrt();
    let damping = 0.25 * ((8.0 + 9.0 * mu - 4.0 * root) / (1.0 + mu)).sqrt();
    let square =
        ((8.0 + 9.0 * mu).powi(2) * (16.0 + 9.0 * mu) - 128.0 * root.powi(3)) / (3.0 * (32.0 + 27.0 * mu));
    [tuning, damping, square.sqrt() / (3.0 * mu)]
}

fn absorber_request() -> DesignRequest {
    let machine = machine(&absorber());
    let goal = Goal { measure: "amplitude.box.s".parse().unwrap(), maximize: false };
    let vary = vec![
        interval("spring.absorber.stiffness", 150.0, 600.0),
        interval("spring.absorber.damping", 0.5, 6.0),
    ];
    let values = (0..7).map(|k| NATURAL * (0.7 + 0.1 * f64::from(k))).collect();
    DesignRequest {
        over: vec![SampledAxis { name: "load.shaker.frequency".into(), values }],
        between: vec!["load.shaker.frequency".into()],
        evaluations: 30,
        ..DesignRequest::new(machine, goal, vary)
    }
}

/// Error of the peak amplitude: from the orbits' peaks, and the parameters' error squared.
const AMPLITUDE: f64 = 1e-8;
/// Error of the parameters; its square is the error of the amplitude.
const NUMBERS: f64 = 1e-4;

#[test]
fn closed_form_den_hartogs_absorber() {
    let found = design(&absorber_request(), &CONTROL).unwrap();
    let best = found.best.as_ref().unwrap();
    let [tuning, damping, largest] = exact_absorber(RATIO);
    let w = TAU * NATURAL;
    let exact = [RATIO * (tuning * w).powi(2), 2.0 * damping * RATIO * tuning * w];
    let size = largest / (w * w);
    assert!((best.goal.value / size - 1.0).abs() < AMPLITUDE, "{best:?} {size}");
    for (own, exact) in best.values.iter().zip(exact) {
        assert!((own / exact - 1.0).abs() < NUMBERS, "{best:?} {exact}");
    }
    assert_eq!((&found.verdict, found.has_gradients), (&Verdict::Decided, true));
    assert!(best.at_ends.is_empty() && found.rivals.iter().all(|own| own.is_told_apart), "{found:?}");
    // Without exact peaks, the search between the values of the band finds up to 1 % less.
    let sampled = found.evaluations.iter().filter(|own| own.stage == Stage::Gradient);
    assert!(sampled.filter_map(|own| own.goal).all(|goal| goal.value > 0.99 * size));
}

/// Ratio of the ball's mass to the box's, restitution, damping ratio, force and frequency.
const BALL: f64 = 0.1;
const RESTITUTION: f64 = 0.6;
const RATIO_OF_DAMPING: f64 = 0.02;
const FORCE: f64 = 4.0;

/// The gallery's damper: a box at resonance with a ball between two rigid stops.
fn impact_damper() -> Machine {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/assembly/impact_damper.toml");
    let description = vibro_machine::file::read(path.as_ref()).unwrap();
    let w = TAU * NATURAL;
    let numbers = [
        ("body.ball.mass", BALL),
        ("stop.left.restitution", RESTITUTION),
        ("spring.mount.damping", 2.0 * RATIO_OF_DAMPING * w),
        ("spring.mount.stiffness", w * w),
        ("load.shaker.amplitude", FORCE),
    ];
    for (name, value) in numbers {
        assert!((description.get(name).unwrap() / value - 1.0).abs() < f64::EPSILON * 4.0, "{name}");
    }
    Machine::new(description)
}

/// Largest amplitude of the box in the symmetric motion with two impacts a period, by the closed
/// form at resonance (S. F. Masri and T. K. Caughey, J. Appl. Mech. 33 (1966) 586–592).
///
/// With y = (x, x') of the box after an impact, P the free motion over half a period, p the forced
/// motion at its start, and y⁻ = (x, x'⁻) before the impact: P (y - p) - p = -y⁻.
fn amplitude_with_two_impacts(gap: f64) -> f64 {
    let w = TAU * NATURAL;
    let (half, zeta, mu, e) = (0.5 / NATURAL, RATIO_OF_DAMPING, BALL, RESTITUTION);
    let wd = w * (1.0 - zeta * zeta).sqrt();
    let free = |t: f64, [x, v]: [f64; 2]| {
        let (decay, s, c) = ((-zeta * w * t).exp(), (wd * t).sin(), (wd * t).cos());
        let part = zeta * w / wd * s;
        [decay * ((c + part) * x + s / wd * v), decay * (-w * w / wd * s * x + (c - part) * v)]
    };
    // At resonance the forced motion lags by a quarter period: size · sin(w t + α).
    let size = FORCE / (2.0 * zeta * w * w);
    // The ball's velocity u after its impact, from its flight over half a period: linear in x.
    let u = |x: f64| -(2.0 * gap + 2.0 * x) / half;
    let (after, before) = ((1.0 - e - 2.0 * mu * e) / (1.0 + e), (1.0 - e + 2.0 * mu) / (1.0 + e));
    // (P + 1) p = P y + y⁻ for x = 0 and 1; p is (size sin α, size w cos α).
    let forced = |x: f64| {
        let [a, b] = free(half, [x, after * u(x)]);
        let right = [a + x, b + before * u(x)];
        let columns = [free(half, [1.0, 0.0]), free(half, [0.0, 1.0])];
        let [[p, r], [q, s]] = [[columns[0][0] + 1.0, columns[0][1]], [columns[1][0], columns[1][1] + 1.0]];
        let determinant = p * s - q * r;
        [
            (s * right[0] - q * right[1]) / determinant / size,
            (p * right[1] - r * right[0]) / determinant / size / w,
        ]
    };
    let (at_0, at_1) = (forced(0.0), forced(1.0));
    let by = [at_1[0] - at_0[0], at_1[1] - at_0[1]];
    let [a, b, c] = [
        by[0] * by[0] + by[1] * by[1],
        at_0[0] * by[0] + at_0[1] * by[1],
        at_0[0] * at_0[0] + at_0[1] * at_0[1] - 1.0,
    ];
    let root = (b * b - a * c).sqrt();
    // The root for which the ball flies back.
    let x = [(-b + root) / a, (-b - root) / a].into_iter().find(|x| u(*x) < 0.0).unwrap();
    let phase = forced(x);
    let own = [x - size * phase[0], after * u(x) - size * w * phase[1]];
    let at = |t: f64| free(t, own)[0] + size * (phase[0] * (w * t).cos() + phase[1] * (w * t).sin());
    (0..=20_000).map(|k| at(half * f64::from(k) / 20_000.0).abs()).fold(0.0, f64::max)
}

/// Error of an amplitude from samples of its closed form: the square of their spacing.
const SAMPLED: f64 = 1e-7;

#[test]
fn closed_form_the_best_gap_of_an_impact_damper() {
    let goal = Goal { measure: "amplitude.box.s".parse().unwrap(), maximize: false };
    let request = DesignRequest {
        evaluations: 24,
        ..DesignRequest::new(impact_damper(), goal, vec![interval("gap", 0.006, 0.016)])
    };
    let found = design(&request, &CONTROL).unwrap();
    let best = found.best.as_ref().unwrap();
    // Golden section.
    let (mut low, mut high) = (0.006, 0.016);
    for _ in 0..60 {
        let [a, b] = [0.618_034, 0.381_966].map(|part| part * low + (1.0 - part) * high);
        if amplitude_with_two_impacts(a) < amplitude_with_two_impacts(b) { high = b } else { low = a }
    }
    let least = amplitude_with_two_impacts(low);
    assert!((best.goal.value / least - 1.0).abs() < SAMPLED, "{best:?} {least} {low}");
    assert!((best.values[0] / low - 1.0).abs() < NUMBERS.sqrt(), "{best:?} {low}");
    assert_eq!((&found.verdict, found.has_gradients), (&Verdict::Decided, true));
    // All designs on this branch have the value of the closed form.
    let own = found.evaluations.iter().filter(|own| own.goal.is_some_and(|goal| goal.is_exact));
    let on_branch = own.filter(|own| {
        let exact = amplitude_with_two_impacts(own.values[0]);
        (own.goal.unwrap().value / exact - 1.0).abs() < SAMPLED
    });
    assert!(on_branch.count() > 10);
}

/// A body on a spring and a dashpot, driven above its resonance.
fn mounted(k: f64, c: f64, frequency: f64) -> Machine {
    machine(&format!(
        "name = \"Mounted\"\n[body.box]\nmass = 1.0\n[spring.mount]\nbetween = [\"ground\", \"box\"]\nstiffness = {k}\n\
         damping = {c}\n[load.shaker]\non = \"box\"\namplitude = 1.0\nfrequency = {frequency}\n"
    ))
}

/// Error of the amplitude of a settled linear motion.
const SETTLED: f64 = 1e-8;

#[test]
fn closed_form_the_best_design_lies_at_an_active_limit() {
    // Damping lowers the amplitude and, above √2 times the natural frequency, raises the force.
    let (k, w) = (1000.0, TAU * 8.0);
    let amplitude = |c: f64| 1.0 / (k - w * w).hypot(c * w);
    let force = |c: f64| k.hypot(c * w) * amplitude(c);
    let limit = 0.8;
    // k² + (c w)² = limit² ((k - w²)² + (c w)²).
    let exact = ((limit * limit * (k - w * w).powi(2) - k * k) / (1.0 - limit * limit)).sqrt() / w;
    assert!((force(exact) - limit).abs() < 1e-12);
    let own = mounted(k, 5.0, 8.0);
    let request = DesignRequest {
        limits: vec![Limit::read("amplitude.mount.f <= 0.8 N", &own).unwrap()],
        evaluations: 20,
        ..DesignRequest::new(
            own,
            Goal { measure: "amplitude.box.s".parse().unwrap(), maximize: false },
            vec![interval("spring.mount.damping", 1.0, 100.0)],
        )
    };
    let found = design(&request, &CONTROL).unwrap();
    let best = found.best.as_ref().unwrap();
    // The search stays on the permitted side by a millionth of the limit.
    assert!((best.values[0] / exact - 1.0).abs() < 1e-5, "{best:?} {exact}");
    assert!((best.goal.value / amplitude(best.values[0]) - 1.0).abs() < SETTLED, "{best:?}");
    assert_eq!((best.limits[0].1, &found.verdict), (Check::Met, &Verdict::Decided));
    // A limit that no damping meets is reported as missed.
    let limits = vec![Limit::read("amplitude.mount.f<=0.5", &request.machine).unwrap()];
    let missed = design(&DesignRequest { limits, ..request }, &CONTROL).unwrap();
    assert!(
        matches!(&missed.verdict, Verdict::NoneFound(why) if why.contains("amplitude.mount.f")),
        "{missed:?}"
    );
    assert_eq!(missed.best.unwrap().limits[0].1, Check::NotMet);
}

#[test]
fn closed_form_the_largest_amplitude_within_tolerances() {
    // Both ends of the stiffness range (1 ± 0.05) k have the same amplitude if k is the stiffness
    // at resonance.
    let (w, c) = (TAU * 8.0, 5.0);
    let request = DesignRequest {
        robust: 0.05,
        evaluations: 16,
        ..DesignRequest::new(
            mounted(2000.0, c, 8.0),
            Goal { measure: "amplitude.box.s".parse().unwrap(), maximize: true },
            vec![interval("spring.mount.stiffness", 1500.0, 3500.0)],
        )
    };
    let found = design(&request, &CONTROL).unwrap();
    let best = found.best.as_ref().unwrap();
    let worst = 1.0 / (0.05 * w * w).hypot(c * w);
    assert!((best.values[0] / (w * w) - 1.0).abs() < 1e-6, "{best:?} {}", w * w);
    assert!((best.goal.value / worst - 1.0).abs() < 1e-6, "{best:?} {worst}");
    assert!(best.place.contains("spring.mount.stiffness") && best.place.contains("5 %"), "{best:?}");
}

#[test]
fn closed_form_an_attractor_without_contacts_coexists_with_the_best() {
    // Above its resonance the body may swing between the buffers without contact, or press them:
    // both motions are stable.
    let (w, f) = (TAU * 13.0, TAU * 10.0);
    let text = format!(
        "name = \"Buffers\"\n[body.box]\nmass = 1.0\nstart = {{ s = 0.02 }}\n[spring.mount]\nbetween = [\"ground\", \"box\"]\n\
         stiffness = {}\ndamping = 2.0\n[load.shaker]\non = \"box\"\namplitude = 10.0\nfrequency = 13.0\n\
         [stop.right]\nbetween = [\"ground\", \"box\"]\ngap = 0.012\nstiffness = 8000.0\n\
         [stop.left]\nbetween = [\"box\", \"ground\"]\ngap = 0.012\nstiffness = 8000.0\n",
        f * f
    );
    let goal = Goal { measure: "amplitude.box.s".parse().unwrap(), maximize: true };
    let request = DesignRequest {
        evaluations: 10,
        ..DesignRequest::new(machine(&text), goal, vec![interval("stop.right.stiffness", 7900.0, 8100.0)])
    };
    let found = design(&request, &CONTROL).unwrap();
    let best = found.best.as_ref().unwrap();
    let linear = 10.0 / (f * f - w * w).hypot(2.0 * w);
    let near = |own: &&Attractor| (own.goal.value / linear - 1.0).abs() < SETTLED;
    let free = best.attractors.iter().find(near).unwrap_or_else(|| panic!("{linear} {best:?}"));
    assert!(best.goal.value > 1.2 * linear && free.is_worse && !free.is_requested, "{best:?}");
    assert_eq!((free.impacts, free.class.name().as_str()), (0.0, "1T"));
}

#[test]
fn invariant_a_search_does_not_depend_on_threads_and_is_ended_by_hand_with_its_best() {
    let goal = Goal { measure: "amplitude.box.s".parse().unwrap(), maximize: false };
    let request = DesignRequest {
        evaluations: 16,
        ..DesignRequest::new(
            mounted(2000.0, 5.0, 8.0),
            goal,
            vec![interval("spring.mount.stiffness", 1500.0, 2200.0)],
        )
    };
    let of_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| design(&request, &CONTROL)).unwrap()
    };
    let all = of_threads(1);
    assert_eq!(all, of_threads(3));
    assert_eq!(all.best.unwrap().at_ends, ["spring.mount.stiffness"]);
    let count = std::sync::atomic::AtomicUsize::new(0);
    let ended = Control {
        go_on: &|| count.fetch_add(1, std::sync::atomic::Ordering::Relaxed) < 5,
        progress: &|_| (),
    };
    let found = design(&request, &ended).unwrap();
    assert_eq!(
        (found.verdict.to_string().as_str(), found.evaluations.len()),
        ("undecided: ended by hand", 5)
    );
    let least = found
        .evaluations
        .iter()
        .filter_map(|own| own.goal)
        .map(|goal| goal.value)
        .fold(f64::INFINITY, f64::min);
    assert_eq!(found.best.unwrap().goal.value, least);
}

#[test]
fn closed_form_two_frequencies_with_the_same_amplitude() {
    // With the resonance between both frequencies, the amplitudes at both are equal: (k - a²)² +
    // (c a)² = (b² - k)² + (c b)².
    let (c, a, b) = (2.0, TAU * 7.0, TAU * 9.0);
    let request = DesignRequest {
        over: vec![SampledAxis { name: "load.shaker.frequency".into(), values: vec![7.0, 9.0] }],
        evaluations: 20,
        ..DesignRequest::new(
            mounted(1000.0, c, 8.0),
            Goal { measure: "amplitude.box.s".parse().unwrap(), maximize: true },
            vec![interval("spring.mount.stiffness", 1500.0, 4000.0)],
        )
    };
    let found = design(&request, &CONTROL).unwrap();
    let best = found.best.as_ref().unwrap();
    let exact = 0.5 * (a * a + b * b + c * c);
    assert!((best.values[0] / exact - 1.0).abs() < 1e-6, "{best:?} {exact}");
    assert!((best.goal.value * (exact - a * a).hypot(c * a) - 1.0).abs() < 1e-6, "{best:?}");
}
