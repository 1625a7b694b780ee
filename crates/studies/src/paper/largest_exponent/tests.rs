use super::*;
use crate::paper::lyapunov::{SpectrumOptions, spectrum};
use crate::paper::smooth_pieces::{PieceEnd, smooth_pieces};
use crate::paper::stroboscopic::moving_block;
use crate::paper::trajectories::{Program, Start, Workspace};
use crate::paper::variation::{DIMENSION, Variation};
use vibro_impact::parameters::{Groups, Scales};
use vibro_impact::simulator::{Simulator, State};
use vibro_impact::steady::exact_orbit;

fn system(f10: f64, kappa: f64) -> Parameters {
    Groups { f10, kappa, ..Groups::basic() }.to_parameters(Scales::default()).unwrap()
}

/// Logarithms of a variation's growth over some periods of a motion, by this module and by the
/// full matrices of `variation`; and how often the block came to rest.
fn growths(p: &Parameters, skipped: u32, periods: u32) -> ([f64; 2], u32) {
    let mut simulator = Simulator::new(p, &moving_block(p), 0.0).unwrap().without_energy_accounts();
    simulator.advance_to(f64::from(skipped) * p.period()).unwrap();
    let model = Model::new(p).unwrap();
    let mut tangent = Tangent::default();
    tangent.begin(p, simulator.contact().mode(), (simulator.time(), simulator.time()));
    let mut variation = Variation::new(&model);
    let mut frame = [[0.0; COORDINATES]; DIMENSION];
    frame[0] = tangent.v;
    let (mut time, mut rested, mut logarithm) = (simulator.time(), 0, 0.0);
    let begin = frame[0].iter().map(|x| x * x).sum::<f64>().ln() / 2.0;
    for i in 1..=periods {
        let end = f64::from(skipped + i) * p.period();
        smooth_pieces(&mut simulator, &model, end, &mut |piece| {
            time += piece.span;
            variation.propagate(&mut frame, piece);
            match piece.end {
                PieceEnd::Impact { side, rate, impulse, after, rests } => {
                    let (side, speed) = (side as i8, side * rate);
                    tangent.event(&Event::Impact { time, side, speed, impulse }, &after);
                    if rests {
                        rested += 1;
                        tangent.event(&Event::Rest { time, side }, &after);
                    }
                }
                PieceEnd::Release => {
                    tangent.event(&Event::Release { time, side: 1 }, &piece.start);
                }
                PieceEnd::End => {}
            }
        })
        .unwrap();
        let length = frame[0].iter().map(|x| x * x).sum::<f64>().sqrt();
        logarithm += length.ln();
        frame[0] = frame[0].map(|x| x / length);
    }
    // Less than a block, so that nothing is rescaled.
    tangent.carry(simulator.time(), None);
    ([0.5 * tangent.square().ln() - begin, logarithm - begin], rested)
}

#[test]
fn second_method_growth_is_that_of_full_matrices() {
    /// Tolerance for the truncation error of some twenty series for one variation: each is under
    /// 9e-6, and mostly far less.
    const CUT: f64 = 2e-5;
    for (f10, kappa, rests) in [(1.5, 0.75, false), (3.6, 0.75, false), (3.0, 0.0, true), (2.0, 0.3, false)] {
        let p = system(f10, kappa);
        let ([found, expected], rested) = growths(&p, 5, 7);
        assert!((found - expected).abs() < CUT, "f10 = {f10}, kappa = {kappa}: {found} {expected}");
        assert_eq!(rested > 0, rests, "f10 = {f10}, kappa = {kappa}");
    }
}

/// Largest exponent of the motion from the common start, 1/s, counted until its sign is decided or
/// `most` periods are over.
fn exponent(p: &Parameters, discard: u32, most: u32) -> LargestExponent {
    let program = Program { discard, observed: true, exponent: Some(most), ..Program::default() };
    let mut found = None;
    let start = Start { parameters: *p, state: moving_block(p) };
    Workspace::default().run(&mut std::iter::once(start), &program, &mut |_, outcome| {
        found = outcome.unwrap().exponent;
    });
    found.expect("no period")
}

#[test]
fn second_method_in_chaos_it_is_the_first_of_seven() {
    for f10 in [3.6, 4.5] {
        let p = system(f10, 0.75);
        let found = exponent(&p, 200, 400);
        let mut settled = Simulator::new(&p, &moving_block(&p), 0.0).unwrap().without_energy_accounts();
        settled.advance_to(200.0 * p.period()).unwrap();
        let seven = spectrum(&mut settled, &SpectrumOptions { periods: 2000, ..SpectrumOptions::default() });
        let expected = seven.unwrap().exponents[0];
        // Four standard errors: one in ten thousand by chance.
        assert!((found.value - expected).abs() < 4.0 * found.error, "f10 = {f10}: {found:?} {expected}");
        assert!(found.error < 0.2 * found.value && found.periods < 200, "f10 = {f10}: {found:?}");
    }
}

#[test]
fn closed_form_of_the_exact_orbit() {
    let p = system(1.5, 0.75);
    let orbit = exact_orbit::solve(&p).unwrap().upper.unwrap();
    let expected = p.drive_frequency / std::f64::consts::PI * orbit.spectral_radius().ln();
    // Range in which the logarithm of the length swings around its mean, over short and long
    // times, if multipliers are a complex pair.
    const SWING: f64 = 2.0;
    const PERIODS: u32 = 400;
    let mut simulator = Simulator::new(&p, &moving_block(&p), 0.0).unwrap().without_energy_accounts();
    simulator.advance_to(300.0 * p.period()).unwrap();
    let model = Model::new(&p).unwrap();
    let mut tangent = Tangent::default();
    tangent.begin(&p, simulator.contact().mode(), (simulator.time(), simulator.time()));
    let mut time = simulator.time();
    let end = time + f64::from(PERIODS) * p.period();
    smooth_pieces(&mut simulator, &model, end, &mut |piece| {
        time += piece.span;
        if let PieceEnd::Impact { side, rate, impulse, after, .. } = piece.end {
            let event = Event::Impact { time, side: side as i8, speed: side * rate, impulse };
            tangent.event(&event, &after);
        }
    })
    .unwrap();
    tangent.end_block(end);
    let found = tangent.exponent();
    assert_eq!(found.periods, PERIODS - ALIGN * BLOCK);
    let tolerance = SWING / (f64::from(found.periods) * p.period());
    assert!((found.value - expected).abs() < tolerance, "{found:?} {expected}");
    assert!(found.value < -tolerance && tangent.is_decided(10_000), "{found:?}");
}

#[test]
fn second_method_beside_a_drive_far_slower_than_the_dampers_it_is_a_number() {
    /// Tolerance: swing of the logarithm of the length of a turning variation, a few units,
    /// relative to more than 5000 in each block.
    const SWING: f64 = 1e-3;
    // A variation shrinks by e⁻⁵⁰⁰ or more in each drive period.
    let p = Parameters {
        secondary_damping: 0.1,
        coupling_stiffness: 0.1,
        drive_frequency: 5e-4,
        drive_amplitude: 0.0,
        ..Parameters::default()
    };
    let mut simulator = Simulator::new(&p, &State { x: [0.0; 3], v: [0.0; 3] }, 0.0).unwrap();
    let options = SpectrumOptions { align: 1, periods: 2, ..SpectrumOptions::default() };
    // The largest exponent besides the zero of the drive's phase.
    let expected = spectrum(&mut simulator, &options).unwrap().exponents[1];
    let mut tangent = Tangent::default();
    tangent.begin(&p, SmoothMode::Flight, (0.0, 0.0));
    for block in 1..=ALIGN + LEAST_BLOCKS {
        // Rounding must not move it past the end.
        tangent.end_block(f64::from(block * BLOCK) * p.period() * (1.0 - f64::EPSILON));
    }
    let found = tangent.exponent();
    assert!((found.value / expected - 1.0).abs() < SWING, "{found:?} {expected}");
}

#[test]
fn closed_form_rule_of_decision() {
    let p = system(1.5, 0.75);
    let rate = p.box_frequency();
    // Blocks with a mean growth and an alternating deviation from it.
    let tangent = |blocks: u32, mean: f64, scatter: f64| Tangent {
        parameters: p,
        block: f64::from(BLOCK) * p.period(),
        growth: Growth {
            blocks: ALIGN + blocks,
            sums: [f64::from(blocks) * mean, f64::from(blocks) * (mean * mean + scatter * scatter)],
            ..Growth::default()
        },
        ..Tangent::default()
    };
    let error = tangent(17, 2.0, 1.0).exponent().error * f64::from(BLOCK) * p.period();
    assert!((error - 0.25).abs() < 1e-12, "{error}");
    assert!(tangent(17, 2.0, 1.0).is_decided(400) && tangent(17, -2.0, 1.0).is_decided(400));
    // Too much scatter; too little growth; nothing left; enough periods.
    assert!(!tangent(17, 2.0, 1.5).is_decided(400));
    assert!(!tangent(17, 1.0, 0.1).is_decided(400));
    assert!(tangent(1, f64::NEG_INFINITY, 0.0).is_decided(400));
    assert!(tangent(50, 0.0, 0.1).is_decided(400));
    assert!(tangent(50, 0.0, 0.1).exponent().value < ZERO_EXPONENT * rate);
}

#[test]
fn second_method_motions_whose_chaos_has_ended_have_no_more_impacts() {
    // Under a weak drive chaos is a transient that ends without impacts.
    let mut starts = (0..120).map(|k| {
        let groups = Groups { f10: 0.28, sigma1: -1.2 + 0.02 * f64::from(k), ..Groups::basic() };
        let parameters = groups.to_parameters(Scales::default()).unwrap();
        Start { parameters, state: moving_block(&parameters) }
    });
    let starts: Vec<Start> = starts.by_ref().collect();
    let program = Program {
        discard: 300,
        until_settled: true,
        observed: true,
        exponent: Some(400),
        ..Program::default()
    };
    let mut ended = 0;
    Workspace::default().run(&mut starts.iter().copied(), &program, &mut |number, outcome| {
        let outcome = outcome.unwrap();
        if outcome.exponent.is_none_or(|e| e.error != 0.0) {
            return;
        }
        ended += 1;
        assert!(outcome.attractor.is_some_and(|a| a.approaching));
        let p = &starts[number].parameters;
        let mut simulator = Simulator::new(p, &outcome.state, 0.0).unwrap();
        simulator.advance_to(300.0 * p.period()).unwrap();
        assert_eq!((simulator.impacts().upper, simulator.impacts().lower), (0, 0), "{number}");
    });
    assert!(ended > 2, "{ended}");
}
