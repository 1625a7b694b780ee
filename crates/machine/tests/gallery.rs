//! Gallery examples compared with independent solvers and closed forms.

use crate::common::{near, times};
use crate::matrix::cantilever;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::sync::Arc;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Assembly, Motion, file};

/// Events of a solver lie on a grid of a step over 2^HALVINGS, which is below 1e-11 s in all tests
/// here.
pub const HALVINGS: usize = 26;

pub fn example(name: &str) -> Motion {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/assembly/");
    let machine = file::read(format!("{folder}{name}.toml").as_ref()).unwrap_or_else(|e| panic!("{e}"));
    Motion::new(Arc::new(Assembly::new(machine).unwrap())).unwrap()
}

pub fn followed(motion: &mut Motion, end: f64) -> Vec<Event> {
    let mut all = Vec::new();
    motion.advance_observed(end, &mut |event| all.push(event.clone())).unwrap();
    all
}

/// A quantity by its name.
pub fn value(motion: &Motion, name: &str) -> f64 {
    let all = motion.assembly().description.named_quantities();
    motion.value(all.iter().find(|quantity| quantity.name == name).expect("a column").quantity)
}

fn press(event: &EventKind) -> bool {
    matches!(event, EventKind::Press { .. })
}

/// z' = A z: exp(A h/2^k) - 1 for each k. E(2h) = 2 E(h) + E(h)² preserves the digits.
pub fn flow(a: &DMatrix<f64>, step: f64) -> Vec<DMatrix<f64>> {
    let small = a * (step / f64::exp2(HALVINGS as f64));
    let mut e = &small + &small * &small / 2.0 + &small * &small * &small / 6.0;
    let mut all = vec![e.clone()];
    for _ in 0..HALVINGS {
        e = &e * 2.0 + &e * &e;
        all.push(e.clone());
    }
    all.reverse();
    all
}

/// A step, halved at each change to another piece; returns the times of the changes.
fn step(
    flows: &[Vec<DMatrix<f64>>],
    piece: &dyn Fn(&DVector<f64>) -> usize,
    z: &mut DVector<f64>,
    [time, length]: [f64; 2],
    halved: usize,
    begun: &mut Vec<(f64, usize)>,
) {
    let before = piece(z);
    let next = &*z + &flows[before][halved] * &*z;
    let after = piece(&next);
    if before == after || halved == HALVINGS {
        if before != after {
            begun.push((time + length, after));
        }
        *z = next;
        return;
    }
    for part in [0.0, 0.5] {
        step(flows, piece, z, [time + part * length, 0.5 * length], halved + 1, begun);
    }
}

#[track_caller]
fn agree(found: &[f64], expected: &[f64], allowed: f64) {
    assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
    for (one, other) in found.iter().zip(expected) {
        near(*one, *other, allowed);
    }
}

/// Ten elements of a steel strip with EI and ρA, integrated by matrix exponentials.
#[test]
fn second_method_a_strip_of_beam_elements_with_a_stop() {
    // Rounding of eigenvectors and of 6000 steps, which contacts magnify.
    const NEAR: f64 = 1e-9;
    let (length, [width, height]) = (0.5_f64, [0.03, 0.004_f64]);
    let (bending, line_mass) = (210e9 * width * height.powi(3) / 12.0, 7850.0 * width * height);
    let scale = DMatrix::from_fn(20, 20, |i, j| if i != j { 0.0 } else { length.powi((i % 2) as i32) });
    let [k, m] = cantilever(10);
    let k = &scale * k * &scale * (bending / length.powi(3));
    let m = &scale * m * &scale * (line_mass * length);
    let c = &m * 1.0 + &k * 2e-6;
    let inverse = m.try_inverse().unwrap();
    let (stiffness, damping, gap, omega) = (20e3, 2.0, 2e-3, TAU * 14.0);
    let (tip, middle, sine) = (18, 8, 40);
    // z: q, v, a sine and its cosine, 1.
    let piece = |pressed: bool| {
        let (mut k, mut c) = (k.clone(), c.clone());
        if pressed {
            k[(tip, tip)] += stiffness;
            c[(tip, tip)] += damping;
        }
        let mut a = DMatrix::zeros(43, 43);
        a.view_mut((0, 20), (20, 20)).fill_with_identity();
        a.view_mut((20, 0), (20, 20)).copy_from(&(-&inverse * k));
        a.view_mut((20, 20), (20, 20)).copy_from(&(-&inverse * c));
        a.view_mut((20, sine), (20, 1)).copy_from(&(inverse.column(middle) * 0.6));
        if pressed {
            a.view_mut((20, 42), (20, 1)).copy_from(&(inverse.column(tip) * (stiffness * gap)));
        }
        (a[(sine, sine + 1)], a[(sine + 1, sine)]) = (omega, -omega);
        a
    };
    let (h, steps) = (1e-4, 6000);
    let flows = [false, true].map(|pressed| flow(&piece(pressed), h));
    let pressed = |z: &DVector<f64>| {
        usize::from(z[tip] > gap && stiffness * (z[tip] - gap) + damping * z[20 + tip] > 0.0)
    };
    let mut z = DVector::zeros(43);
    (z[sine + 1], z[42]) = (1.0, 1.0);
    let mut begun = Vec::new();
    (0..steps).for_each(|n| step(&flows, &pressed, &mut z, [n as f64 * h, h], 0, &mut begun));
    let expected: Vec<f64> = begun.iter().filter(|(_, piece)| *piece == 1).map(|(time, _)| *time).collect();
    let mut strip = example("cantilever");
    let found = times(&followed(&mut strip, steps as f64 * h), press);
    assert!(found.len() >= 5, "{found:?}");
    agree(&found, &expected, NEAR);
    near(value(&strip, "strip.tip.s"), z[tip], NEAR);
}

/// The displacement along the pitch circles: x'' = -(r₁²/J₁ + r₂²/J₂) f + r₁ T₁/J₁ + r₂ T₂/J₂.
#[test]
fn second_method_a_gear_pair_with_steps_of_its_mesh() {
    // Rounding of 13,000 steps over times of ms.
    const NEAR: f64 = 1e-12;
    let (light, push) = (0.05 * 0.05 / 4e-4 + 0.08 * 0.08 / 2e-3, 0.05 * 60.0 / 4e-4 + 0.08 * 96.0 / 2e-3);
    let (damping, play) = (250.0, 40e-6);
    let piece = |k: f64, c: f64, gap: f64| {
        DMatrix::from_row_slice(
            3,
            3,
            &[0.0, 1.0, 0.0, -light * k, -light * c, light * k * gap + push, 0.0, 0.0, 0.0],
        )
    };
    let (period, parts) = (0.3e-3, 200);
    let h = period / parts as f64;
    let teeth = [200e6, 140e6];
    let flows = teeth.map(|k| {
        [piece(0.0, 0.0, 0.0), piece(k, damping, 0.0), piece(170e6, damping, -play)].map(|a| flow(&a, h))
    });
    let mut z = DVector::from_vec(vec![0.0, 0.0, 1.0]);
    let (mut begun, turns) = (Vec::new(), 66);
    for n in 0..turns * parts {
        let level = usize::from(n % parts >= parts * 13 / 20);
        let side = |z: &DVector<f64>| match (z[0], z[1]) {
            (x, v) if x > 0.0 && teeth[level] * x + damping * v > 0.0 => 1,
            (x, v) if -x > play && 170e6 * (-x - play) - damping * v > 0.0 => 2,
            _ => 0,
        };
        step(&flows[level], &side, &mut z, [n as f64 * h, h], 0, &mut begun);
    }
    let expected: Vec<f64> = begun.iter().filter(|(_, piece)| *piece == 1).map(|(time, _)| *time).collect();
    let mut gears = example("gear_mesh");
    let found = times(&followed(&mut gears, turns as f64 * period), press);
    assert!(found.len() > 40, "{found:?}");
    agree(&found, &expected[expected.len() - found.len()..], NEAR);
    near(0.05 * gears.coordinate(0) + 0.08 * gears.coordinate(1), z[0], NEAR);
}

/// Masing's rule: after a reversal the force follows the initial loading curve at twice its size;
/// a closed loop of half width X loses 4 slip (X - slip/k) in each slider.
#[test]
fn closed_form_loops_of_an_iwan_joint() {
    const NEAR: f64 = 1e-10;
    let (k, slips, period) = (20e3, [2.0, 5.0, 9.0, 14.0], 1.0 / 36.0);
    let mut joint = example("iwan_joint");
    let force = |joint: &Motion| (1..5).map(|i| value(joint, &format!("slip{i}.f"))).sum::<f64>();
    let loading = |x: f64| slips.iter().map(|slip| f64::min(*slip, k * x)).sum::<f64>();
    let losses = |joint: &Motion| joint.energy().branches.iter().map(|lost| lost.value()).sum::<f64>();
    joint.advance_to(108.0 * period).unwrap();
    let before = losses(&joint);
    let found = followed(&mut joint, 109.0 * period);
    let lost = losses(&joint) - before;
    let turns = times(&found, |kind| matches!(kind, EventKind::Hold { .. }));
    let turns: Vec<f64> = turns.chunks(4).map(|four| four[0] + period).collect();
    assert_eq!((turns.len(), found.len()), (2, 16));
    let ends = [turns[0], turns[1]].map(|time| {
        joint.advance_to(time).unwrap();
        [value(&joint, "bolt.e"), force(&joint)]
    });
    let half = 0.5 * (ends[0][0] - ends[1][0]).abs();
    near(lost, slips.iter().map(|slip| 4.0 * slip * (half - slip / k)).sum(), NEAR);
    let sign = ends[1][0].signum();
    for part in 1..10 {
        joint.advance_to(turns[1] + 0.05 * f64::from(part) * period).unwrap();
        let way = (value(&joint, "bolt.e") - ends[1][0]).abs();
        near(force(&joint), ends[1][1] - sign * 2.0 * loading(0.5 * way), 1e3 * NEAR);
    }
}

/// The acceleration of the base is held from knot to knot, so the coordinate of the base is an
/// ordinary state.
#[test]
fn second_method_a_rig_under_a_held_record() {
    const NEAR: f64 = 1e-10;
    let record = include_str!("../../../examples/assembly/shaken_rig.csv");
    let held: Vec<f64> =
        record.lines().skip(2).map(|line| line.split_once(',').unwrap().1.parse().unwrap()).collect();
    let (spacing, parts) = (0.01, 16);
    let ([m, panel], [k, c], [kp, cp], [ks, cs], gap) =
        ([300.0, 20.0], [28e3, 600.0], [50e3, 60.0], [2e6, 2e3], 0.025);
    // z: base s, v, a; cabinet s, v; panel s, v; 1. `side` is 1 at the left snubber, -1 at the
    // right.
    let piece = |side: f64| {
        let [ks, cs] = [ks, cs].map(|x| x * side.abs());
        let mut a = DMatrix::zeros(8, 8);
        for (place, rate) in [(0, 1), (1, 2), (3, 4), (5, 6)] {
            a[(place, rate)] = 1.0;
        }
        let row = [k + ks, c + cs, 0.0, -k - ks - kp, -c - cs - cp, kp, cp, ks * gap * side];
        (0..8).for_each(|j| a[(4, j)] = row[j] / m);
        let row = [0.0, 0.0, 0.0, kp, cp, -kp, -cp, 0.0];
        (0..8).for_each(|j| a[(6, j)] = row[j] / panel);
        a
    };
    let h = spacing / parts as f64;
    let flows = [0.0, 1.0, -1.0].map(|side| flow(&piece(side), h));
    let side = |z: &DVector<f64>| {
        let (e, rate) = (z[3] - z[0], z[4] - z[1]);
        let acts = |e: f64, rate: f64| e > gap && ks * (e - gap) + cs * rate > 0.0;
        if acts(e, rate) { 1 } else { 2 * usize::from(acts(-e, -rate)) }
    };
    let mut z = DVector::zeros(8);
    z[7] = 1.0;
    let mut begun = Vec::new();
    for (n, a) in held.iter().enumerate() {
        z[2] = *a;
        let times = (0..parts).map(|part| n as f64 * spacing + part as f64 * h);
        times.for_each(|time| step(&flows, &side, &mut z, [time, h], 0, &mut begun));
    }
    let expected: Vec<f64> = begun.iter().filter(|(_, piece)| *piece > 0).map(|(time, _)| *time).collect();
    let mut rig = example("shaken_rig");
    let found = times(&followed(&mut rig, held.len() as f64 * spacing), press);
    assert_eq!(found.len(), 5);
    agree(&found, &expected, NEAR);
    (0..3).for_each(|body| near(rig.coordinate(body), z[[0, 3, 5][body]], NEAR));
}

/// Fourth-order Runge-Kutta method, with steps halved at the stop.
#[test]
fn second_method_a_run_up_with_impacts() {
    // (ωh)⁴/120 per radian with ωh = 0.01, over 400 radians.
    const NEAR: f64 = 1e-7;
    let (m, k, c, gap, restitution) = (40.0, 40e3, 60.0, 0.012, 0.5);
    let rate = |t: f64, [x, v]: [f64; 2]| {
        let phase = TAU * (2.0 * t + 0.5 * 7.0 / 20.0 * t * t);
        [v, (70.0 * phase.sin() - k * x - c * v) / m]
    };
    let along = |y: [f64; 2], d: [f64; 2], h: f64| [y[0] + h * d[0], y[1] + h * d[1]];
    let one = |t: f64, y: [f64; 2], h: f64| {
        let a = rate(t, y);
        let b = rate(t + 0.5 * h, along(y, a, 0.5 * h));
        let c = rate(t + 0.5 * h, along(y, b, 0.5 * h));
        let d = rate(t + h, along(y, c, h));
        along(y, [0, 1].map(|i| a[i] + 2.0 * (b[i] + c[i]) + d[i]), h / 6.0)
    };
    let (whole, end) = (2.5e-4, 15.0);
    let (mut t, mut h, mut y) = (0.0, whole, [0.0, 0.0]);
    let mut expected = Vec::new();
    while t < end - 1e-9 {
        let next = one(t, y, h);
        if next[0] < gap {
            (t, y) = (t + h, next);
            // Back to the grid of whole steps.
            h = (whole * ((t / whole + 1e-6).floor() + 1.0) - t).min(whole);
        } else if h > 1e-13 {
            h *= 0.5;
        } else {
            expected.push(t);
            y = [y[0], -restitution * y[1]];
            h = whole * ((t / whole + 1e-6).floor() + 1.0) - t;
        }
    }
    let mut fan = example("run_up");
    let found = times(&followed(&mut fan, end), |kind| matches!(kind, EventKind::Impact { .. }));
    assert_eq!(found.len(), 27);
    agree(&found, &expected, NEAR);
    near(fan.coordinate(0), y[0], NEAR);
}

/// Relative rounding of an impact speed and an amplitude after some ten series.
const PULLED: f64 = 1e-12;

/// From rest the magnet's work is the leaf's energy and the armature's: c/(d - s) - c/d = k s²/2 +
/// m v²/2. Below c = k d³/8 the armature turns round where k s/2 = c/(d (d - s)).
#[test]
fn closed_form_pull_in_of_a_relay() {
    let (m, k, d, gap) = (2e-3f64, 100.0f64, 1.5e-3f64, 1.2e-3f64);
    let mut motion = example("pull_in");
    let events = followed(&mut motion, 0.1);
    let EventKind::Impact { speed: found, .. } = events[0].kind else { panic!("{:?}", events[0]) };
    let energy = 4.4e-8 * (1.0 / (d - gap) - 1.0 / d) - 0.5 * k * gap * gap;
    let speed = (2.0 * energy / m).sqrt();
    assert!((found / speed - 1.0).abs() < PULLED, "{found} {speed}");
    // The bounces end, and the magnet holds the armature.
    assert!(motion.body(0)[..2] == [gap, 0.0], "{:?}", motion.body(0));
    let limit = k * d * d * d / 8.0;
    let description = motion.assembly().description.with([("magnet", 0.99 * limit)]).unwrap();
    let mut motion = Motion::new(Arc::new(Assembly::new(description).unwrap())).unwrap();
    let mut largest = 0.0f64;
    while motion.time() < 0.1 {
        motion.advance_to(motion.time() + 1e-5).unwrap();
        largest = largest.max(motion.body(0)[0]);
    }
    let turning = 0.5 * d * (1.0 - (1.0f64 - 0.99).sqrt());
    // The samples miss the turning point by at most a(5e-6 s)²/2.
    assert!(largest <= turning * (1.0 + PULLED) && largest > turning - 1e-8, "{largest} {turning}");
}

/// Numbers of the gallery's brake: mass, stiffness, damping, level at high speeds and the part that
/// falls, and the speed at which it falls.
const BRAKE: [f64; 6] = [2.0, 20e3, 120.0, 30.0, 30.0, 0.1];

/// The classical Runge-Kutta method for the slipping pad, in steps that are halved where the pad
/// reaches the disc's speed.
#[test]
fn second_method_stick_and_slip_of_a_brake_with_stribeck_friction() {
    // (ωh)⁴ with ωh = 1e-3, over 5 radians, and rounding of 5000 steps.
    const NEAR: f64 = 1e-11;
    let ([m, k, c, level, falling, scale], disc) = (BRAKE, 0.1);
    let slope = |[x, v]: [f64; 2]| {
        let rate = (disc - v) / scale;
        [v, (level + falling * (-rate * rate).exp() - k * x - c * v) / m]
    };
    let along = |y: [f64; 2], d: [f64; 2], h: f64| [y[0] + h * d[0], y[1] + h * d[1]];
    let step = |y: [f64; 2], h: f64| {
        let a = slope(y);
        let b = slope(along(y, a, 0.5 * h));
        let c = slope(along(y, b, 0.5 * h));
        let d = slope(along(y, c, h));
        along(y, [0, 1].map(|i| a[i] + 2.0 * (b[i] + c[i]) + d[i]), h / 6.0)
    };
    // The pad leaves the disc where the spring and its dashpot take up the static force.
    let start = (level + falling - c * disc) / k;
    let (mut y, mut slip, mut h) = ([start, disc], 0.0, 1e-5);
    while h > 1e-15 {
        let next = step(y, h);
        if slip > 0.0 && next[1] > disc {
            h *= 0.5;
        } else {
            (y, slip) = (next, slip + h);
        }
    }
    let stick = (start - y[0]) / disc;
    let all = followed(&mut example("stribeck_brake"), 1.0);
    let slips = times(&all, |kind| matches!(kind, EventKind::Slip { .. }));
    let sticks = times(&all, |kind| matches!(kind, EventKind::Stick { .. }));
    let last = slips[slips.len() - 2];
    let end = sticks.iter().find(|time| **time > last).expect("the pad sticks again");
    near(end - last, slip, NEAR);
    near(slips[slips.len() - 1] - end, stick, NEAR);
}

/// Near steady sliding the pad has the damping c - S(v) with the slope S(v) = 2 v/s² F exp(-(v/s)²).
#[test]
fn closed_form_steady_sliding_of_a_brake_is_unstable_below_a_critical_speed() {
    // Relative: the curvature of the friction times the rate of 1e-6 m/s.
    const LINEAR: f64 = 1e-4;
    let [m, k, c, level, falling, scale] = BRAKE;
    let fallen = |v: f64| falling * (-(v / scale).powi(2)).exp();
    let slope = |v: f64| 2.0 * v / (scale * scale) * fallen(v);
    // The slope is largest at s/sqrt(2).
    let (mut low, mut high) = (scale * 0.5f64.sqrt(), 2.0 * scale);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *if slope(middle) > c { &mut low } else { &mut high } = middle;
    }
    // The value on the gallery's page.
    near(low, 0.13932, 1e-5);
    for (factor, grows) in [(0.99, true), (1.01, false)] {
        let (disc, begin, time) = (factor * low, 1e-8, 1.0);
        let middle = (level + fallen(disc)) / k;
        let numbers = [("disc", disc), ("body.pad.start.s", middle + begin)];
        let description = example("stribeck_brake").assembly().description.with(numbers).unwrap();
        let mut motion = Motion::new(Arc::new(Assembly::new(description).unwrap())).unwrap();
        motion.advance_to(time).unwrap();
        let growth = 0.5 * (slope(disc) - c) / m;
        let turn = (k / m - growth * growth).sqrt();
        let (sin, cos) = (turn * time).sin_cos();
        let expected = begin * (growth * time).exp() * (cos - growth / turn * sin);
        let size = begin * (growth * time).exp();
        assert_eq!(growth > 0.0, grows);
        near((value(&motion, "pad.s") - middle) / size, expected / size, LINEAR);
    }
}

/// The hammer drill's displacements of striker, beater and bit, then their rates.
type Drill = [f64; 6];

/// Depths of the three contacts.
fn depths(y: &Drill) -> [f64; 3] {
    [y[0] - y[1], y[1] - y[2], y[2]]
}

/// The derivative of the hammer drill's state in time.
fn drilled(t: f64, y: &Drill) -> Drill {
    let [x, [striker, beater, bit]] = [depths(y), [y[3], y[4], y[5]]];
    let contact = |n: usize, rate: f64, k: f64, d: f64| {
        let depth = x[n].max(0.0);
        (k * depth * depth.sqrt() * (1.0 + 1.5 * d * rate)).max(0.0)
    };
    let blow = contact(0, striker - beater, 21e9, 0.05);
    let shank = contact(1, beater - bit, 21e9, 0.05);
    let rock = contact(2, bit, 8e7, 0.6);
    let air = 20e3 * (y[0] - 15e-3 * (TAU * 45.0 * t).sin());
    let (seat, feed) = (2e3 * y[1] + 20.0 * beater - 20.0, 1e3 * y[2] + 20.0 * bit - 150.0);
    let drag = 20.0 * bit * bit.abs();
    let forces = [-air - blow, blow - shank - seat, shank - rock - feed - drag];
    [striker, beater, bit, forces[0] / 0.16, forces[1] / 0.09, forces[2] / 0.3]
}

/// The classical Runge-Kutta method, whose steps are halved at the edge of a contact and grow again
/// after it, since the force of x^1.5 is not smooth there.
#[test]
fn second_method_contacts_of_a_hammer_drill() {
    // Errors of steps of 2e-7 s in contacts of 1e-4 s, which 30 contacts magnify.
    const NEAR: f64 = 1e-9;
    // Relative tolerance of the closing speeds, which the same errors change.
    const SPEED: f64 = 1e-6;
    let (whole, least, end) = (2e-7, 1e-13, 0.0275);
    let along = |y: &Drill, d: &Drill, h: f64| -> Drill { std::array::from_fn(|i| y[i] + h * d[i]) };
    let step = |t: f64, y: &Drill, h: f64| {
        let a = drilled(t, y);
        let b = drilled(t + 0.5 * h, &along(y, &a, 0.5 * h));
        let c = drilled(t + 0.5 * h, &along(y, &b, 0.5 * h));
        let d = drilled(t + h, &along(y, &c, h));
        along(y, &std::array::from_fn(|i| a[i] + 2.0 * (b[i] + c[i]) + d[i]), h / 6.0)
    };
    let sides = |y: &Drill| depths(y).map(|depth| depth > 0.0);
    let (mut t, mut h, mut y) = (0.0, 1e-9, Drill::default());
    let mut pressed: Vec<(f64, f64)> = Vec::new();
    while t < end {
        let next = step(t, &y, h);
        let (before, after) = (sides(&y), sides(&next));
        if before != after && h > least {
            h *= 0.5;
            continue;
        }
        (t, y) = (t + h, next);
        h = if before == after { (2.0 * h).min(whole) } else { 1e-11 };
        let rates = [y[3] - y[4], y[4] - y[5], y[5]];
        // At the start all bodies touch.
        let begun = (0..3).filter(|n| after[*n] && !before[*n] && t > 1e-6);
        pressed.extend(begun.map(|n| (t, rates[n])));
    }
    let all = followed(&mut example("hammer_drill"), end);
    let own: Vec<&Event> = all.iter().filter(|event| press(&event.kind) && event.time > 1e-6).collect();
    assert_eq!(own.len(), pressed.len());
    assert!(own.len() > 30, "{}", own.len());
    for (event, (time, rate)) in own.iter().zip(&pressed) {
        let EventKind::Press { speed, .. } = event.kind else { panic!("{:?}", event.kind) };
        near(event.time, *time, NEAR);
        near(speed / rate, 1.0, SPEED);
    }
    // The blow on the gallery's page.
    let fastest = pressed.iter().map(|(_, rate)| *rate).fold(0.0, f64::max);
    near(fastest, 11.1414, 1e-4);
}
