//! Bits of the states of many motions compared with digests in `tests/data/state_bits.<instruction
//! set>.txt`.
//!
//! A change of code without a change of arithmetic keeps every digest. After an intended change of
//! arithmetic, `UPDATE=1 cargo test --test state_bits` rewrites the file, and the commit says why.

mod common;

use common::bits::{Digest, compare};
use common::golden::weak;
use vibro_impact::simulator::{Contact, Loads, advance_together};
use vibro_impact::steady::{exact_orbit, multiple_scales, strong_coupling};
use vibro_impact::{Groups, Parameters, Scales, Simulator, State};

/// Points at which each motion is recorded.
const POINTS: u32 = 10_000;

fn moving(parameters: &Parameters) -> Simulator {
    let start = State { x: [0.0, 0.9 * parameters.stop_gap, 0.0], v: [0.0, 0.5 * parameters.stop_gap, 0.0] };
    Simulator::new(parameters, &start, 0.0).expect("valid")
}

fn record(digest: &mut Digest, s: &Simulator) {
    let (state, (w, rate), record, energy) =
        (s.state(), s.relative_motion(), s.impacts(), s.energy_accounts());
    digest.reals(&state.x);
    digest.reals(&state.v);
    digest.reals(&[s.time(), w, rate, s.contact_force(), s.drive_phase()]);
    digest.reals(&s.acceleration());
    digest.reals(&[energy.mechanical, energy.input, energy.damped, energy.impact]);
    digest.reals(&[record.last_time, record.last_impulse, record.last_speed, record.total_impulse]);
    let contact = match s.contact() {
        Contact::Flight => 0,
        Contact::RestUpper => 1,
        Contact::RestLower => 2,
    };
    for number in [record.upper, record.lower, contact] {
        digest.number(number);
    }
}

/// Digest of a motion at `POINTS` points, `step` periods apart; `disturb` is called before the
/// advance to each point.
fn run(mut s: Simulator, step: f64, mut disturb: impl FnMut(&mut Simulator, u32)) -> String {
    let (mut digest, dt, begin) = (Digest::new(), step * s.parameters().period().min(100.0), s.time());
    for i in 1..=POINTS {
        disturb(&mut s, i);
        if let Err(error) = s.advance_to(begin + f64::from(i) * dt) {
            digest.text(&error.to_string());
            break;
        }
        record(&mut digest, &s);
    }
    digest.finish()
}

fn plain(s: Simulator, step: f64) -> String {
    run(s, step, |_, _| {})
}

/// Pseudo-random numbers in [0, 1), equal on all machines.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

fn random_system(seed: u64) -> Parameters {
    let mut n = Numbers(seed);
    Groups::weak(
        n.between(0.02, 0.5),
        n.between(0.0, 1.0),
        n.between(0.3, 5.0),
        n.between(-0.5, 0.5),
        n.between(0.0, 1.0),
        n.between(0.0, 1.0),
        n.between(-0.5, 0.5),
        n.between(0.0, 1.0),
    )
    .to_parameters(Scales {
        mass: n.between(0.1, 10.0),
        stiffness: n.between(1.0, 1e4),
        length: n.between(0.001, 1.0),
    })
    .expect("valid")
}

fn load(i: u32) -> Loads {
    let mut n = Numbers(u64::from(i) + 77);
    let mut derivatives = [[0.0; 4]; 3];
    for d in derivatives.iter_mut().flatten() {
        *d = n.between(-0.02, 0.02);
    }
    Loads { derivatives }
}

fn motions(out: &mut Vec<(String, String)>) {
    for (kappa, f10) in [
        (0.75, 1.5),
        (0.75, 0.6),
        (0.75, 0.748497),
        (0.75, 2.45),
        (0.75, 2.85),
        (0.75, 3.6),
        (0.75, 4.5),
        (0.0, 1.5),
        (0.0, 3.0),
        (0.1, 3.5),
        (0.3, 2.5),
        (0.5, 0.8),
        (1.0, 1.5),
        (1.0, 0.5),
        (0.9, 3.0),
        (0.2, 1.2),
    ] {
        let s = moving(&weak(kappa, f10));
        out.push((format!("weak kappa {kappa} f10 {f10}, a hundredth"), plain(s.clone(), 0.01)));
        out.push((
            format!("weak kappa {kappa} f10 {f10}, without energy, a seventh"),
            plain(s.without_energy_accounts(), 1.0 / 7.3),
        ));
    }
    for seed in 1..=16 {
        out.push((format!("random system {seed}"), plain(moving(&random_system(seed)), 0.05)));
    }
    let basic = Parameters::default();
    out.push((
        "basic from rest".into(),
        plain(Simulator::new(&basic, &State::default(), 0.0).expect("valid"), 0.02),
    ));
    out.push((
        "basic, whole periods, from 1e6 s".into(),
        plain(Simulator::new(&basic, &State::default(), 1e6).expect("valid"), 1.0),
    ));
    let quiet = Parameters { drive_amplitude: 0.0, ..basic };
    out.push(("free decay".into(), plain(moving(&quiet), 0.02)));
    out.push((
        "constant force".into(),
        plain(moving(&Parameters { drive_frequency: 0.0, drive_phase: 1.0, ..basic }), 0.001),
    ));
    out.push(("free block".into(), plain(moving(&Parameters { coupling_stiffness: 0.0, ..basic }), 0.02)));
    let undamped = Parameters { box_damping: 0.0, secondary_damping: 0.0, ..basic };
    out.push(("undamped".into(), plain(moving(&undamped), 0.02)));
    out.push((
        "undamped at resonance".into(),
        plain(moving(&Parameters { drive_frequency: 1.0, ..undamped }), 0.02),
    ));
}

fn disturbed(out: &mut Vec<(String, String)>) {
    let basic = Parameters::default();
    for (name, kappa) in [("0.75", 0.75), ("0.2", 0.2), ("0", 0.0)] {
        let s = moving(&weak(kappa, 1.5));
        out.push((
            format!("loads every 10 points, kappa {name}"),
            run(s.clone(), 0.03, |s, i| {
                if i % 10 == 0 {
                    s.set_loads(&load(i)).expect("a load");
                }
            }),
        ));
        out.push((
            format!("block pressed to the stop and let go, kappa {name}"),
            run(s.clone(), 0.02, |s, i| {
                if i % 100 == 0 {
                    let force = if i % 200 == 0 { 0.3 } else { 0.0 };
                    s.set_loads(&Loads { derivatives: [[0.0; 4], [force, 0.0, 0.0, 0.0], [0.0; 4]] })
                        .expect("a load");
                }
            }),
        ));
        out.push((
            format!("parameters changed every 50 points, kappa {name}"),
            run(s.clone(), 0.02, |s, i| {
                if i % 50 == 0 {
                    let mut n = Numbers(u64::from(i));
                    let p = Parameters {
                        drive_frequency: n.between(0.8, 1.2),
                        drive_phase: n.between(-3.0, 3.0),
                        drive_amplitude: n.between(0.0, 0.4),
                        box_damping: n.between(0.0, 0.2),
                        stop_restitution: n.next(),
                        coupling_stiffness: n.between(0.0, 0.05),
                        ..*s.parameters()
                    };
                    s.set_parameters(&p).expect("valid");
                }
            }),
        ));
        let (first, mut kept) = (s.snapshot(), s.snapshot());
        out.push((
            format!("snapshots put back, kappa {name}"),
            run(s, 0.02, |s, i| match i % 500 {
                100 => kept = s.snapshot(),
                200 => {
                    let time = s.time();
                    s.restore(&first).expect("our own");
                    s.restore(&kept).expect("our own");
                    s.advance_to(time).expect("it went so far before");
                }
                _ => {}
            }),
        ));
    }
    // Machines near the limits of double precision.
    let stiff = Parameters { coupling_stiffness: 1e4, ..basic };
    out.push(("stiff coupling".into(), plain(moving(&stiff), 0.002)));
    let far = State { x: [1e6, 1e6 + 0.5, 1e6], v: [0.0; 3] };
    let soft = Parameters { box_stiffness: 1e-8, secondary_stiffness: 0.0, ..basic };
    out.push(("far from the origin".into(), plain(Simulator::new(&soft, &far, 0.0).expect("valid"), 0.02)));
}

fn together(out: &mut Vec<(String, String)>) {
    const MANY: u64 = 20;
    let mut simulators: Vec<Simulator> =
        (1..=MANY).map(|seed| moving(&random_system(seed)).without_energy_accounts()).collect();
    simulators
        .extend([0.0, 0.2, 0.5, 0.75, 1.0].map(|kappa| moving(&weak(kappa, 1.5)).without_energy_accounts()));
    let mut digests: Vec<Digest> = simulators.iter().map(|_| Digest::new()).collect();
    for i in 1..=POINTS / 20 {
        let end = |s: &Simulator| 0.37 * f64::from(i) * s.parameters().period();
        let results = advance_together(&mut simulators, end);
        for ((s, result), digest) in simulators.iter().zip(results).zip(&mut digests) {
            match result {
                Ok(()) => record(digest, s),
                Err(error) => digest.text(&error.to_string()),
            }
        }
    }
    for (i, digest) in digests.into_iter().enumerate() {
        out.push((format!("together {i}"), digest.finish()));
    }
}

fn closed_forms(out: &mut Vec<(String, String)>) {
    for f10 in [0.9, 1.2, 1.5, 2.0, 3.0] {
        let phases = (0..POINTS).map(|i| f64::from(i) * 0.001);
        let groups = Groups { f10, ..Groups::basic() };
        let (mut scales, mut strong, mut exact) = (Digest::new(), Digest::new(), Digest::new());
        let point = multiple_scales::fixed_points(&groups).expect("valid").expect("it exists").upper;
        let other = strong_coupling::solve(&groups).expect("valid").expect("it exists").upper;
        let p = groups.to_parameters(Scales::default()).expect("valid");
        let orbit = exact_orbit::solve(&p).expect("valid").upper.expect("it exists");
        for theta in phases {
            for (digest, motion) in
                [(&mut scales, point.motion_at_drive(theta)), (&mut strong, other.motion_at_drive(theta))]
            {
                digest.reals(&motion.x);
                digest.reals(&motion.dx);
            }
            let state = orbit.state(theta);
            exact.reals(&state.x);
            exact.reals(&state.v);
        }
        for (name, digest) in
            [("multiple scales", scales), ("strong coupling", strong), ("exact orbit", exact)]
        {
            out.push((format!("{name} f10 {f10}"), digest.finish()));
        }
    }
}

#[test]
fn golden_state_bits_of_the_library() {
    let mut found = Vec::new();
    motions(&mut found);
    disturbed(&mut found);
    together(&mut found);
    closed_forms(&mut found);
    assert!(found.len() > 60);
    compare("state_bits", &found);
}
