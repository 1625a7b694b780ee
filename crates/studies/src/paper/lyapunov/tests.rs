//! The spectrum against the closed form of the linear system, the identity of the sum, the exact
//! orbit's multipliers, and pairs of trajectories.

use super::super::motion::settled_simulator;
use super::super::stroboscopic::moving_block;
use super::super::variation::unit_frame;
use super::*;
use vibro_impact::parameters::{Groups, Parameters, Scales};
use vibro_impact::simulator::State;
use vibro_impact::steady::exact_orbit;

/// Tolerance for a real exponent and for the sum of two exponents with complex multipliers. Each
/// of these two differs from the limit by O(1/n) after n periods, but their sum does not.
const PAIR: f64 = 1e-6;
/// Tolerance for the rounding of some thousand products; the identity itself holds in each period.
const IDENTITY: f64 = 1e-8;

fn groups(f10: f64, kappa: f64) -> Parameters {
    Groups { f10, kappa, ..Groups::basic() }.to_parameters(Scales::default()).unwrap()
}

#[test]
fn closed_form_of_the_linear_damped_system() {
    // The block has no spring and never reaches a stop. The box's exponents are the real parts of
    // the roots of r² + c1 r + k1 (here overdamped), and likewise for the secondary oscillator
    // (underdamped). The exponents of block and phase are zero.
    let mut p = groups(0.0, 0.75);
    p.coupling_stiffness = 0.0;
    p.box_damping = 2.5;
    p.secondary_damping = 0.03;
    let start = State { x: [1e-3, 0.0, 1e-3], v: [0.0; 3] };
    let mut simulator = Simulator::new(&p, &start, 0.0).unwrap().without_energy_accounts();
    let found = spectrum(&mut simulator, &SpectrumOptions::default()).unwrap();
    assert_eq!(found.impacts, 0);
    let root = (2.5f64 * 2.5 - 4.0).sqrt();
    let expected = [0.0, 0.0, 0.0, -0.15, -0.15, 0.5 * (-2.5 + root), 0.5 * (-2.5 - root)];
    // A change of the block's speed makes its displacement grow linearly in time. So one exponent
    // tends to zero as ln(t)/t and another as -ln(t)/t.
    let time = 1550.0 * p.period();
    let slow = time.ln() / (1500.0 * p.period());
    for (i, (got, want)) in found.exponents.iter().zip(expected).enumerate() {
        let near = match i {
            0..3 => slow,
            // Exponents with complex multipliers.
            3 | 4 => 1e-3,
            _ => PAIR,
        };
        assert!((got - want).abs() < near, "{i}: {got} {want}");
    }
    assert!((found.exponents[3] + found.exponents[4] + 0.3).abs() < PAIR);
    assert!((found.exponents[0] + found.exponents[1] + found.exponents[2]).abs() < PAIR);
}

/// Real parts of the roots of r² + c r + k, the larger one first.
fn roots(c: f64, k: f64) -> [f64; 2] {
    let root = (0.25 * c * c - k).max(0.0).sqrt();
    [-0.5 * c + root, -0.5 * c - root]
}

#[test]
fn closed_form_of_exponents_far_apart() {
    // No impacts. With a slow drive or a strong damper, one variation shrinks relative to another
    // by more digits in one drive period than a double holds.
    let slow = Parameters {
        drive_frequency: 0.013,
        box_damping: 0.3,
        drive_amplitude: 0.05,
        ..Parameters::default()
    };
    let strong =
        Parameters { drive_frequency: 0.4, box_damping: 3.2, drive_amplitude: 0.05, ..Parameters::default() };
    for p in [slow, strong] {
        let mut simulator = Simulator::new(&p, &State::default(), 0.0).unwrap().without_energy_accounts();
        let options = SpectrumOptions { align: 200, periods: 400, ..SpectrumOptions::default() };
        let found = spectrum(&mut simulator, &options).unwrap();
        assert_eq!(found.impacts, 0);
        let of_box = roots(p.box_damping / p.box_mass, p.box_stiffness / p.box_mass);
        // The secondary oscillator's damper determines the sum of the four exponents of block and
        // secondary oscillator.
        let of_block = -p.secondary_damping / p.secondary_mass;
        let sum = found.exponents.iter().sum::<f64>();
        assert!((sum - of_box[0] - of_box[1] - of_block).abs() < PAIR, "{found:?}");
        let mean = 0.5 * (found.exponents[5] + found.exponents[6]);
        let near = |e: f64, expected: f64| (e - expected).abs() < 1e-3;
        assert!((mean - 0.5 * (of_box[0] + of_box[1])).abs() < PAIR, "{found:?}");
        assert!(near(found.exponents[5], of_box[0]) && near(found.exponents[6], of_box[1]), "{found:?}");
    }
}

#[test]
fn invariant_the_sum_of_the_exponents_where_slow_impacts_stretch() {
    // A long drive period contains hundreds of impacts. Each slow impact stretches one variation
    // and shrinks another. An impact multiplies the volume in phase space by the square of the
    // restitution coefficient, and the dampers shrink the volume at a constant rate.
    let p = Parameters {
        box_mass: 0.557_724_769_778_829,
        box_stiffness: 8.491_729_122_830_904,
        box_damping: 0.033_370_507_598_979_38,
        block_mass: 0.049_477_690_481_578_79,
        secondary_mass: 0.051_108_911_421_343_474,
        secondary_stiffness: 0.0,
        secondary_damping: 0.024_533_431_141_187_268,
        coupling_stiffness: 0.037_677_506_917_004_07,
        stop_restitution: 0.973_791_134_659_245,
        drive_amplitude: 30.946_572_112_086_287,
        drive_frequency: 0.030_040_808_668_644_642,
        drive_phase: 0.150_781_694_426_338_1,
        ..Parameters::default()
    };
    let mut simulator = settled_simulator(&p, &moving_block(&p), 150.0).unwrap();
    let options = SpectrumOptions { align: 100, periods: 200, ..SpectrumOptions::default() };
    let found = spectrum(&mut simulator, &options).unwrap();
    assert!(found.impacts > 10_000 && !found.rests, "{found:?}");
    let of_impacts = 2.0 * p.stop_restitution.ln() * found.impacts as f64 / (200.0 * p.period());
    let expected = of_impacts - p.box_damping / p.box_mass - p.secondary_damping / p.secondary_mass;
    let sum = found.exponents.iter().sum::<f64>();
    assert!((sum - expected).abs() < IDENTITY, "{sum} {expected}");
}

#[test]
fn closed_form_of_directions_that_nothing_mixes() {
    // Without impacts box and block do not act on each other, and nothing holds the secondary
    // oscillator: its position has exponent zero, and so has the phase. Both exponents are found
    // after the periods of alignment.
    let p = Parameters {
        secondary_stiffness: 0.0,
        drive_amplitude: 0.05,
        drive_frequency: 0.8,
        ..Parameters::default()
    };
    let mut simulator = Simulator::new(&p, &State::default(), 0.0).unwrap().without_energy_accounts();
    let found = spectrum(&mut simulator, &SpectrumOptions::default()).unwrap();
    assert!(found.impacts == 0 && found.exponents[..2].iter().all(|e| e.abs() < PAIR), "{found:?}");
}

#[test]
fn invariant_a_spectrum_that_is_broken_off_is_the_beginning_of_the_whole() {
    let p = groups(3.6, 0.75);
    let start = settled_simulator(&p, &moving_block(&p), 20.0).unwrap();
    let options = SpectrumOptions { align: 5, periods: 40, ..SpectrumOptions::default() };
    let whole = convergence(&mut start.clone(), &options).unwrap();
    let mut asked = 0;
    let mut go_on = || {
        asked += 1;
        asked <= 25
    };
    let part = convergence_while(&mut start.clone(), &options, &mut go_on).unwrap();
    assert_eq!((part.spectrum.periods, part.running.as_slice()), (20, &whole.running[..20]));
}

#[test]
fn invariant_sum_is_divergence_and_determinants() {
    for (f10, kappa) in
        [(0.6, 0.75), (1.5, 0.75), (2.7, 0.75), (3.6, 0.75), (4.5, 0.75), (3.0, 0.9), (1.5, 0.5)]
    {
        let p = groups(f10, kappa);
        let mut simulator = settled_simulator(&p, &moving_block(&p), 200.0).unwrap();
        let options = SpectrumOptions { align: 0, periods: 300, ..SpectrumOptions::default() };
        let found = spectrum(&mut simulator, &options).unwrap();
        assert!(!found.rests, "f10 = {f10}");
        let time = f64::from(found.periods) * p.period();
        let expected = -(p.box_damping / p.box_mass + p.secondary_damping / p.secondary_mass)
            + 2.0 * kappa.ln() * found.impacts as f64 / time;
        let sum: f64 = found.exponents.iter().sum();
        assert!((sum - expected).abs() < IDENTITY, "f10 = {f10}: {sum} {expected}");
        let zero = found.exponents.iter().map(|e| e.abs()).fold(f64::INFINITY, f64::min);
        assert!(zero < 2e-3, "the phase's exponent: {:?}", found.exponents);
    }
}

#[test]
fn second_method_multipliers_of_the_exact_orbit() {
    let other =
        Groups::weak(0.1, 0.75, 1.5, 0.5, 0.4, 0.1, 0.5, 0.2).to_parameters(Scales::default()).unwrap();
    for p in [groups(1.5, 0.75), groups(1.1, 0.75), groups(1.9, 0.75), groups(1.2, 0.5), other] {
        let orbit = exact_orbit::solve(&p).unwrap().upper.unwrap();
        assert!(orbit.is_stable());
        let start = orbit.initial_state();
        let start = State { x: start.x, v: start.v };
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap().without_energy_accounts();
        simulator.advance_to(200.0 * p.period()).unwrap();
        let options = SpectrumOptions { align: 500, ..SpectrumOptions::default() };
        let found = spectrum(&mut simulator, &options).unwrap();
        let mut expected: Vec<f64> =
            orbit.multipliers().iter().map(|m| m.norm().ln() * 2.0 / p.period()).collect();
        expected.push(0.0);
        expected.sort_by(|a, b| b.total_cmp(a));
        // Equal moduli (a complex pair) are compared by their mean.
        let mut i = 0;
        while i < DIMENSION {
            let alike = expected[i..].iter().take_while(|e| (*e - expected[i]).abs() < 1e-9).count();
            let mean = found.exponents[i..i + alike].iter().sum::<f64>() / alike as f64;
            assert!((mean - expected[i]).abs() < PAIR, "{i}: {:?} {expected:?}", found.exponents);
            i += alike;
        }
    }
}

#[test]
fn second_method_two_trajectories_in_chaos() {
    const APART: f64 = 1e-8;
    const PERIODS: u32 = 6000;
    /// Tolerance for the difference of the two estimates, in standard errors. Chaos makes both
    /// estimates fluctuate; their standard errors follow from blocks of periods. By chance, one
    /// comparison in 10⁴ exceeds this tolerance.
    const ERRORS: f64 = 4.0;
    const BLOCK: u32 = 100;
    /// Largest relative error for which the comparison is meaningful.
    const WIDEST: f64 = 0.2;
    for f10 in [3.6, 4.5] {
        let p = groups(f10, 0.75);
        let mut one = settled_simulator(&p, &moving_block(&p), 200.0).unwrap();
        let options = SpectrumOptions { periods: PERIODS, ..SpectrumOptions::default() };
        let found = spectrum(&mut one.clone(), &options).unwrap();
        assert!(found.exponents[0] > 0.01, "f10 = {f10}: {:?}", found.exponents);
        let (mut blocks, mut other) = ([0.0; (PERIODS / BLOCK) as usize], one.state());
        other.x[2] += APART;
        for i in 1..=PERIODS {
            // Over whole periods, so that both may start again at time 0.
            let mut neighbour = Simulator::new(&p, &other, 0.0).unwrap().without_energy_accounts();
            one = Simulator::new(&p, &one.state(), 0.0).unwrap().without_energy_accounts();
            one.advance_to(p.period()).unwrap();
            neighbour.advance_to(p.period()).unwrap();
            let (a, b) = (one.state(), neighbour.state());
            let flat = |s: &State| [s.x[0], s.x[1], s.x[2], s.v[0], s.v[1], s.v[2]];
            let (a6, b6) = (flat(&a), flat(&b));
            let gap = a6.iter().zip(&b6).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
            blocks[((i - 1) / BLOCK) as usize] += (gap / APART).ln() / (f64::from(BLOCK) * p.period());
            let part = APART / gap;
            let c: [f64; 6] = std::array::from_fn(|k| a6[k] + part * (b6[k] - a6[k]));
            other = State { x: [c[0], c[1], c[2]], v: [c[3], c[4], c[5]] };
            let w = other.x[1] - other.x[0];
            other.x[1] = other.x[0] + w.clamp(-p.stop_gap, p.stop_gap);
            assert!(i > 1 || gap > 0.0);
        }
        let count = blocks.len() as f64;
        let estimate = blocks.iter().sum::<f64>() / count;
        let variance = blocks.iter().map(|b| (b - estimate).powi(2)).sum::<f64>() / (count - 1.0);
        let bound = ERRORS * (2.0 * variance / count).sqrt();
        assert!(bound < WIDEST * estimate, "f10 = {f10}: {bound} of {estimate}");
        assert!(
            (estimate - found.exponents[0]).abs() < bound,
            "f10 = {f10}: {estimate} {:?}",
            found.exponents
        );
    }
}

#[test]
fn closed_form_rest_and_dead_impacts_lose_directions() {
    // κ = 0 with rest: two exponents are -∞. The other exponents are finite, and one of them is
    // the exponent zero of the phase.
    let p = groups(3.0, 0.0);
    let found =
        spectrum(&mut settled_simulator(&p, &moving_block(&p), 200.0).unwrap(), &SpectrumOptions::default())
            .unwrap();
    let lost = found.exponents.iter().filter(|e| **e == f64::NEG_INFINITY).count();
    assert_eq!((found.rests, lost), (true, 2), "{found:?}");
    assert!(found.exponents[..5].iter().all(|e| e.is_finite()), "{found:?}");
    assert!(found.exponents[..5].iter().any(|e| e.abs() < 1e-3), "{found:?}");
    assert!(found.deviation.is_finite());
}

#[test]
fn closed_form_variations_through_rest() {
    // The frame carried through chatter into rest and out of it, compared with differences of
    // whole motions. Two widths cancel the second-order error of the differences (Richardson).
    const NARROW: f64 = 1e-6;
    const WIDE: f64 = 3e-6;
    /// Tolerance for the differences. A chatter run is closed at a bounce with a speed of about
    /// 1e-8, in a neighbouring motion one bounce earlier or later, and NARROW divides this error.
    const DIFFERENCE: f64 = 1e-3;
    for (f10, kappa, periods) in [(3.0, 0.0, 60), (2.0, 0.0, 60), (0.3, 0.3, 20), (0.3, 0.5, 20)] {
        let p = groups(f10, kappa);
        let mut simulator = settled_simulator(&p, &moving_block(&p), f64::from(periods)).unwrap();
        let model = Model::new(&p).unwrap();
        // Continues until a rest is over.
        let start = simulator.snapshot();
        let from = simulator.time();
        let (mut now, mut passed) = (from, None);
        smooth_pieces(&mut simulator, &model, from + 20.0 * p.period(), &mut |piece| {
            now += piece.span;
            if matches!(piece.end, PieceEnd::Release) && passed.is_none() {
                passed = Some(now + 0.05);
            }
        })
        .unwrap();
        let Some(end) = passed else { panic!("no rest at f10 = {f10}, kappa = {kappa}") };
        simulator.restore(&start).unwrap();
        let mut variation = Variation::new(&model);
        let mut frame = unit_frame(&simulator.augmented());
        smooth_pieces(&mut simulator, &model, end, &mut |piece| {
            variation.propagate(&mut frame, piece);
        })
        .unwrap();
        // Displacement (in L) and velocity (in L times the model's rate) of the third coordinate.
        for (direction, unit) in [(2, p.stop_gap), (5, p.stop_gap * model.rate)] {
            let share = model.block_share;
            let end_of = |change: f64| {
                let mut s = Simulator::new(&p, &State::default(), 0.0).unwrap();
                s.restore(&start).unwrap();
                let mut state = s.state();
                let of = if direction == 2 { &mut state.x[2] } else { &mut state.v[2] };
                *of += change * unit;
                let mut s = Simulator::new(&p, &state, from).unwrap().without_energy_accounts();
                s.advance_to(end).unwrap();
                let z = s.augmented();
                [z[0] + share * z[1], z[2], (z[3] + share * z[4]) / model.rate, z[5] / model.rate]
            };
            let [near, far] = [NARROW, WIDE].map(|apart| {
                let (a, b) = (end_of(apart), end_of(-apart));
                [0, 1, 2, 3].map(|k| (a[k] - b[k]) / (2.0 * apart * p.stop_gap))
            });
            let led = [frame[direction][0], frame[direction][2], frame[direction][3], frame[direction][5]];
            for k in 0..4 {
                let difference = (9.0 * near[k] - far[k]) / 8.0;
                let allowed = DIFFERENCE * (1.0 + led[k].abs());
                let words = format!("f10 = {f10}, {direction} {k}: {difference} {}", led[k]);
                assert!((difference - led[k]).abs() < allowed, "{words}");
            }
        }
    }
}

#[test]
fn closed_form_early_stop_by_the_deviation() {
    let p = Parameters::default();
    let all = convergence(
        &mut settled_simulator(&p, &moving_block(&p), 400.0).unwrap(),
        &SpectrumOptions { align: 0, ..SpectrumOptions::default() },
    )
    .unwrap();
    let options = SpectrumOptions { align: 0, threshold: 1e-4, ..SpectrumOptions::default() };
    let early = convergence(&mut settled_simulator(&p, &moving_block(&p), 400.0).unwrap(), &options).unwrap();
    let count = early.running.len();
    assert!(early.spectrum.settled && (200..1500).contains(&count), "{count}");
    assert_eq!(early.running[..], all.running[..count], "the same way, only shorter");
    assert!(early.spectrum.deviation < 1e-4 && !all.spectrum.settled);
}
