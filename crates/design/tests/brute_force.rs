//! The engineer's damper against a brute-force program on a grid of designs: closed-form flights
//! between impacts, which are found by steps and bisection.

use std::f64::consts::TAU;
use vibro_design::{Control, DesignRequest, Goal, design};
use vibro_machine::file::{no_records, parse};
use vibro_studies::Machine;
use vibro_studies::design_sweep::{ParameterInterval, SampledAxis};

const BOX: f64 = 12.0;
const STIFFNESS: f64 = 48e3;
const DAMPING: f64 = 150.0;
const FORCE: f64 = 80.0;
const RESTITUTION: f64 = 0.6;
/// Frequencies over which a design is judged by its worst amplitude, Hz.
const FREQUENCIES: [f64; 2] = [9.6, 10.2];
/// Number of periods until the motions have settled, and number of measured periods.
const SETTLE: u32 = 120;
const MEASURED: u32 = 12;
/// Number of steps in a period.
const STEPS: u32 = 120;

/// The state of the box without contact, after a time `by` from a state at time `from`.
fn box_after(frequency: f64, [x, v]: [f64; 2], (from, by): (f64, f64)) -> [f64; 2] {
    let (w0, w) = ((STIFFNESS / BOX).sqrt(), TAU * frequency);
    let delta = 0.5 * DAMPING / BOX;
    let wd = (w0 * w0 - delta * delta).sqrt();
    // The forced motion is a cos w t + b sin w t.
    let (re, im) = (w0 * w0 - w * w, 2.0 * delta * w);
    let size = FORCE / BOX / (re * re + im * im);
    let (a, b) = (-size * im, size * re);
    let forced = |t: f64| {
        let (s, c) = (w * t).sin_cos();
        [a * c + b * s, w * (b * c - a * s)]
    };
    let [p, q] = forced(from);
    let (x, v) = (x - p, v - q);
    let (s, c) = (wd * by).sin_cos();
    let decay = (-delta * by).exp();
    let free =
        [decay * (x * c + (v + delta * x) / wd * s), decay * (v * c - (w0 * w0 * x + delta * v) / wd * s)];
    let [p, q] = forced(from + by);
    [free[0] + p, free[1] + q]
}

/// Largest displacement of the box in the settled motion.
fn amplitude(frequency: f64, gap: f64, mass: f64) -> f64 {
    let dt = 1.0 / frequency / f64::from(STEPS);
    let (mut t, mut own, mut block) = (0.0, [0.0, 0.0], [0.0, 0.3]);
    let mut most = 0.0f64;
    let ahead = |t: f64, own, block: [f64; 2], by: f64| {
        let own = box_after(frequency, own, (t, by));
        (own, [block[0] + by * block[1], block[1]])
    };
    let passes = |own: [f64; 2], block: [f64; 2]| (block[0] - own[0]).abs() > gap;
    for step in 0..(SETTLE + MEASURED) * STEPS {
        let mut left = dt;
        loop {
            let (next, flown) = ahead(t, own, block, left);
            if !passes(next, flown) {
                (own, block, t) = (next, flown, t + left);
                break;
            }
            let (mut low, mut high) = (0.0, left);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                let (next, flown) = ahead(t, own, block, middle);
                if passes(next, flown) { high = middle } else { low = middle }
            }
            (own, block) = ahead(t, own, block, low);
            (t, left) = (t + low, left - low);
            let rate = block[1] - own[1];
            if rate * (block[0] - own[0]) > 0.0 {
                let impulse = (1.0 + RESTITUTION) * rate / (1.0 / BOX + 1.0 / mass);
                own[1] += impulse / BOX;
                block[1] -= impulse / mass;
            } else {
                // It is already flying away; rounding has left it beyond the stop.
                (own, block) = ahead(t, own, block, left);
                t += left;
                break;
            }
        }
        if step >= SETTLE * STEPS {
            most = most.max(own[0].abs());
        }
    }
    most
}

fn machine() -> Machine {
    let stop = |name: &str, between: &str| {
        format!("[stop.{name}]\nbetween = {between}\ngap = \"= gap\"\nrestitution = {RESTITUTION}\n")
    };
    let text = format!(
        "name = \"Damper\"\n[parameters]\ngap = \"15 mm\"\n[body.box]\nmass = {BOX}\n[body.block]\nmass = 0.8\n\
         start = {{ v = 0.3 }}\n[spring.mount]\nbetween = [\"ground\", \"box\"]\nstiffness = {STIFFNESS}\n\
         damping = {DAMPING}\n{}{}[load.shaker]\non = \"box\"\namplitude = {FORCE}\nfrequency = 10.0\n",
        stop("up", "[\"box\", \"block\"]"),
        stop("down", "[\"block\", \"box\"]")
    );
    Machine::new(parse(&text, "m.toml", &no_records).unwrap())
}

/// Error of the brute force: displacements are sampled once per step, and its motions have settled
/// to this accuracy.
const STEPPED: f64 = 1e-3;

#[test]
fn second_method_the_engineers_damper_by_brute_force() {
    let (gaps, masses) = ((0.004, 0.016), (0.6, 1.4));
    let vary = [("gap", gaps), ("body.block.mass", masses)];
    let vary = vary.map(|(name, (from, to))| ParameterInterval { name: name.into(), from, to });
    let goal = Goal { measure: "amplitude.box.s".parse().unwrap(), maximize: false };
    let request = DesignRequest {
        over: vec![SampledAxis { name: "load.shaker.frequency".into(), values: FREQUENCIES.to_vec() }],
        evaluations: 60,
        ..DesignRequest::new(machine(), goal, vary.into())
    };
    let control = Control { go_on: &|| true, progress: &|_| () };
    let found = design(&request, &control).unwrap();
    let best = found.best.as_ref().unwrap();
    let worst =
        |gap: f64, mass: f64| FREQUENCIES.map(|f| amplitude(f, gap, mass)).into_iter().fold(0.0, f64::max);
    let mut least = (f64::INFINITY, 0.0, 0.0);
    for i in 0..=12 {
        for j in 0..=4 {
            let gap = gaps.0 + (gaps.1 - gaps.0) * f64::from(i) / 12.0;
            let mass = masses.0 + (masses.1 - masses.0) * f64::from(j) / 4.0;
            let own = worst(gap, mass);
            if own < least.0 {
                least = (own, gap, mass);
            }
        }
    }
    assert!(best.goal.value < least.0 * (1.0 + STEPPED), "{best:?} {least:?}");
    let own = worst(best.values[0], best.values[1]);
    assert!((own / best.goal.value - 1.0).abs() < STEPPED, "{best:?} {own}");
}
