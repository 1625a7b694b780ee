use super::*;
use crate::class::MotionClass;
use crate::paper::motion::{amplitude, record_flights, settled_simulator};
use crate::paper::stroboscopic::moving_block;
use crate::{Machine, settled};
use std::f64::consts::TAU;
use vibro_impact::State;
use vibro_impact::parameters::{Groups, Scales};
use vibro_impact::steady::exact_orbit;

/// Tolerance for the remainder of the transient as a fraction of L.
const SETTLED: f64 = 1e-9;
/// Tolerance for cubic interpolation between 128 samples a period (see `motion`).
const INTERPOLATION: f64 = 1e-7;
/// Number of phases of a sum, and its tolerance: the square of their distance, since the function
/// has corners.
const PHASES: u32 = 20_000;
const SUM: f64 = 1e-7;

fn at(f10: f64, kappa: f64) -> Parameters {
    Groups { f10, kappa, ..Groups::basic() }.to_parameters(Scales::default()).unwrap()
}

/// Values of measures by name.
fn found(simulator: &mut Simulator, names: &[String], periods: u32) -> Vec<f64> {
    let measures: Vec<Measure> = names.iter().map(|n| n.parse().unwrap()).collect();
    measure(simulator, &measures, periods).unwrap().numbers.into_iter().map(Option::unwrap).collect()
}

/// Values of measures of a settled motion with energy accounts.
fn numbers(p: &Parameters, names: &[&str], discard: f64, periods: u32) -> Vec<f64> {
    let mut simulator = Simulator::new(p, &moving_block(p), 0.0).unwrap();
    simulator.advance_to(discard * p.period()).unwrap();
    found(&mut simulator, &names.iter().map(|n| (*n).into()).collect::<Vec<_>>(), periods)
}

/// The value of a coordinate in a state.
fn of_state(coordinate: Coordinate, state: &State) -> f64 {
    let (x, v) = (state.x, state.v);
    [x[0], x[1], x[2], x[1] - x[0], v[0], v[1], v[2], v[1] - v[0]][coordinate as usize]
}

#[test]
fn second_method_amplitudes_and_mean_squares_of_the_exact_orbit() {
    let p = Parameters::default();
    let orbit = exact_orbit::solve(&p).unwrap().upper.unwrap();
    for c in Coordinate::ALL {
        let names =
            ["amplitude", "rms", "peak_to_peak", "maximum"].map(|kind| format!("{kind}.{}", c.name()));
        let mut simulator = settled_simulator(&p, &moving_block(&p), 600.0).unwrap();
        let [amplitude, rms, peak_to_peak, maximum] = found(&mut simulator, &names, 2)[..] else { panic!() };
        let values: Vec<f64> =
            (0..PHASES).map(|k| of_state(c, &orbit.state(TAU * f64::from(k) / f64::from(PHASES)))).collect();
        if let Some(weights) =
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 1.0, 0.0]].get(c as usize)
        {
            assert!((amplitude - orbit.amplitude_of(*weights)).abs() < SETTLED, "{names:?}");
        } else {
            // Samples miss impacts and extrema by half a phase, and never exceed the exact value.
            let most = values.iter().fold(0.0f64, |a, v| a.max(v.abs()));
            assert!(amplitude > most - SETTLED && amplitude - most < 1e-3, "{names:?}: {amplitude} {most}");
        }
        // The orbit is its own mirror image.
        assert!((maximum - amplitude).abs() < SETTLED && (peak_to_peak - 2.0 * amplitude).abs() < SETTLED);
        let square = values.iter().map(|v| v * v).sum::<f64>() / f64::from(PHASES);
        // Each jump of a velocity at an impact gives the sum an error of half a phase.
        let off = if c.unit() == "m" { SUM } else { 4.0 / f64::from(PHASES) };
        assert!((rms - square.sqrt()).abs() < off, "{names:?}: {rms} {}", square.sqrt());
    }
}

#[test]
fn second_method_extrema_by_samples_in_chaos_and_with_rest() {
    // Only a few periods, since chaos amplifies the rounding of the samples' steps.
    const PERIODS: u32 = 6;
    for (f10, kappa) in [(0.6, 0.75), (3.6, 0.75), (4.5, 0.9), (3.0, 0.0), (2.0, 0.3)] {
        let p = at(f10, kappa);
        let simulator = settled_simulator(&p, &moving_block(&p), 50.0).unwrap();
        let flights = record_flights(&mut simulator.clone(), PERIODS).unwrap();
        let weights = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 1.0, 0.0]];
        for (c, weights) in Coordinate::ALL.into_iter().zip(weights) {
            let names = [format!("amplitude.{}", c.name()), format!("maximum.{}", c.name())];
            let [largest, _] = found(&mut simulator.clone(), &names, PERIODS)[..] else { panic!() };
            let sampled = amplitude(&flights, &p, weights);
            assert!((largest - sampled).abs() < INTERPOLATION, "{f10}, {names:?}: {largest} {sampled}");
        }
        for c in &Coordinate::ALL[4..] {
            let values = flights.iter().flatten().map(|i| of_state(*c, &i.state));
            let (least, most) =
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
            let names = [format!("maximum.{}", c.name()), format!("peak_to_peak.{}", c.name())];
            let [maximum, range] = found(&mut simulator.clone(), &names, PERIODS)[..] else { panic!() };
            // 128 samples per period omit at most h²/8 of the third derivative.
            let (above, below) = (maximum - most, least - (maximum - range));
            let near = |x: f64| (-INTERPOLATION..2e-3).contains(&x);
            assert!(near(above) && near(below), "{f10}, {}: {above} {below}", c.name());
        }
    }
}

#[test]
fn invariant_the_drive_pays_for_all_losses_of_a_periodic_motion() {
    let names = ["power.input", "power.impact", "power.box.c", "power.secondary.c"];
    for (f10, kappa) in [(1.5, 0.75), (2.0, 0.3)] {
        let [input, impact, box_c, secondary_c] = numbers(&at(f10, kappa), &names, 800.0, 60)[..] else {
            panic!()
        };
        let off = input - (impact + box_c + secondary_c);
        assert!(impact > 0.0 && off.abs() < SETTLED * input, "{f10}: {input} {impact} {box_c} {secondary_c}");
    }
}

#[test]
fn closed_form_of_the_box_alone() {
    // Uncoupled, and with room for the block, the box is a driven oscillator that settles by its
    // own damping.
    let p = Parameters { coupling_stiffness: 0.0, stop_gap: 10.0, ..Parameters::default() };
    let mut simulator = Simulator::new(&p, &State::default(), 0.0).unwrap();
    simulator.advance_to(200.0 * p.period()).unwrap();
    let names =
        ["amplitude.x1", "rms.x1", "amplitude.without_block", "power.box.c", "power.input", "impacts"];
    let names: Vec<String> = names.map(Into::into).into();
    let [amplitude, rms, closed, lost, input, impacts] = found(&mut simulator, &names, 60)[..] else {
        panic!()
    };
    let stiffness = p.box_stiffness - p.box_mass * p.drive_frequency.powi(2);
    let expected = p.drive_amplitude / stiffness.hypot(p.box_damping * p.drive_frequency);
    assert!((closed - expected).abs() < 1e-15 && (amplitude - expected).abs() < SETTLED, "{amplitude}");
    assert!((rms * 2f64.sqrt() - expected).abs() < SETTLED && impacts == 0.0);
    let power = 0.5 * p.box_damping * (p.drive_frequency * expected).powi(2);
    assert!((lost - power).abs() < SETTLED && (input - power).abs() < SETTLED, "{lost} {input} {power}");
}

#[test]
fn second_method_impacts_by_their_events() {
    let p = at(3.6, 0.75);
    let simulator = settled_simulator(&p, &moving_block(&p), 50.0).unwrap();
    let names =
        ["impacts", "impacts.upper", "impacts.lower", "impact.speed", "impact.impulse"].map(String::from);
    let measured = found(&mut simulator.clone(), &names, 20);
    let (mut counts, mut speeds, mut impulses) = ([0.0; 2], 0.0f64, 0.0f64);
    let end = simulator.time() + 20.0 * p.period();
    simulator
        .clone()
        .advance_observed(end, &mut |event| {
            if let vibro_impact::simulator::Event::Impact { side, speed, impulse, .. } = *event {
                counts[usize::from(side < 0)] += 1.0 / 20.0;
                (speeds, impulses) = (speeds.max(speed), impulses.max(impulse));
            }
        })
        .unwrap();
    let expected = [counts[0] + counts[1], counts[0], counts[1], speeds, impulses];
    for (a, b) in measured.iter().zip(expected) {
        assert!((a - b).abs() < INTERPOLATION, "{measured:?} {expected:?}");
    }
}

#[test]
fn classes_and_exponents_of_known_motions() {
    let measures = [Measure::Class, Measure::Exponent];
    for (f10, class) in [(1.5, MotionClass::Periodic(1)), (3.6, MotionClass::Chaotic)] {
        let p = at(f10, 0.75);
        let mut simulator = settled_simulator(&p, &moving_block(&p), 400.0).unwrap();
        let found = measure(&mut simulator, &measures, 1).unwrap();
        let exponent = found.numbers[1].unwrap();
        assert_eq!((found.class, found.numbers[0]), (Some(class), None));
        assert_eq!(exponent > 1e-2, class == MotionClass::Chaotic, "{exponent}");
    }
}

#[test]
fn what_has_no_value_is_refused_by_name() {
    let still = Parameters { drive_frequency: 0.0, ..Parameters::default() };
    let mut simulator = Simulator::new(&still, &State::default(), 0.0).unwrap();
    let error = measure(&mut simulator, &[Measure::Impacts], 1).unwrap_err().to_string();
    assert!(error.contains("drive.frequency"), "{error}");
    let resonant = Parameters { box_damping: 0.0, drive_frequency: 1.0, ..Parameters::default() };
    let error = amplitude_without_block(&resonant).unwrap_err().to_string();
    assert!(error.contains("box.c"), "{error}");
}

#[test]
fn names_come_back_and_misspelt_ones_suggest_the_nearest() {
    assert_eq!(Measure::all().count(), 4 * 8 + 12);
    for measure in Measure::all() {
        assert_eq!(measure.name().parse::<Measure>().unwrap(), measure);
        assert!(!measure.description().is_empty() && !measure.unit().is_empty());
    }
    let error = |name: &str| name.parse::<Measure>().unwrap_err().to_string();
    assert_eq!(
        error("amplitud.x1"),
        "no output is named `amplitud.x1`; did you mean `amplitude.x1`? `amplitude.x1`: largest |x1|"
    );
    assert!(error("temperature").contains("expected one of amplitude.x1, amplitude.x2"));
}

/// In chaos the spread of one window predicts the scatter of many: of an extreme by (N3), of a
/// mean square by (N4).
#[test]
fn second_method_spreads_of_one_window_by_the_scatter_of_many() {
    const WINDOWS: usize = 60;
    const PERIODS: u32 = 60;
    /// Limits of observed to predicted scatter. Sixty windows give their scatter to a tenth. Parts
    /// of ten drive periods are not quite independent, so the spread of a mean may be too small.
    /// The limit law of extremes holds for long parts: if the motion reaches the edge of its
    /// attractor in most windows, an extreme scatters less than (N3) predicts.
    const LEAST: f64 = 0.65;
    const MOST: f64 = 5.0;
    let names = ["amplitude.x1", "amplitude.x2", "impact.speed", "rms.x1"];
    for f10 in [2.86, 3.6] {
        let p = at(f10, 0.75);
        let mut simulator = settled_simulator(&p, &moving_block(&p), 300.0).unwrap();
        let measures: Vec<Measure> = names.iter().map(|n| n.parse().unwrap()).collect();
        let found: Vec<_> =
            (0..WINDOWS).map(|_| measure(&mut simulator, &measures, PERIODS).unwrap()).collect();
        for (i, name) in names.iter().enumerate() {
            let numbers: Vec<f64> = found.iter().map(|m| m.numbers[i].unwrap()).collect();
            let mean = numbers.iter().sum::<f64>() / WINDOWS as f64;
            let scatter = numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (WINDOWS - 1) as f64;
            let told = found.iter().map(|m| m.spreads[i].powi(2)).sum::<f64>() / WINDOWS as f64;
            let ratio = (told / scatter).sqrt();
            println!("f10 = {f10}, {name}: {ratio}");
            assert!((LEAST..MOST).contains(&ratio), "f10 = {f10}, {name}: {ratio}");
        }
    }
}

/// Without a spring between box and ground ω10 is zero, and not a unit of an exponent.
#[test]
fn second_method_the_exponent_of_a_machine_without_the_boxs_spring_is_that_of_its_description() {
    /// Tolerance, 1/s: a length oscillates by the ratio of its axes, whose logarithm is divided by
    /// the time of the spectrum.
    const TURNED: f64 = 1e-4;
    let p = Parameters { box_stiffness: 0.0, drive_amplitude: 1.0, ..Parameters::default() };
    let start = State { x: [0.0, 0.5, 0.0], v: [0.0, 0.6, 0.0] };
    let mut simulator = settled_simulator(&p, &start, 400.0).unwrap();
    let [exponent] = found(&mut simulator, &["exponent".into()], 6)[..] else { panic!("one number") };
    let path = std::path::Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../examples/assembly/paper_machine.toml"
    ));
    let machine = Machine::new(vibro_machine::file::read(path).unwrap());
    let machine = machine.with([("spring.mount.stiffness", 0.0), ("load.drive.amplitude", 1.0)]).unwrap();
    let (mut motion, section) = machine.motion(&Default::default()).unwrap();
    crate::discard(&mut motion, &section, 400).unwrap();
    let described = settled(&mut motion, &section, Some(64)).unwrap().exponent.unwrap().value;
    assert!((exponent - described).abs() < TURNED && exponent < 0.0, "{exponent} {described}");
    let refused = lyapunov::dimensionless(&mut simulator, &SpectrumOptions::default()).unwrap_err();
    assert!(refused.to_string().contains("box.k = 0"), "{refused}");
}

#[test]
fn second_method_the_power_of_the_drive_is_without_that_of_constant_loads() {
    // A box on a very soft spring that its load pushes away, and a box in chaos: F10 sin θ x1' by
    // the midpoint rule.
    const STEPS: u32 = 4000;
    let soft = Parameters { box_stiffness: 1e-4, constant_loads: [0.5, 0.0, 0.0], ..Parameters::default() };
    let chaos = Parameters { constant_loads: [0.03, -0.02, 0.01], ..at(3.6, 0.75) };
    for p in [soft, chaos] {
        let mut simulator = Simulator::new(&p, &moving_block(&p), 0.0).unwrap();
        simulator.advance_to(20.0 * p.period()).unwrap();
        let mut other = simulator.clone();
        let input = found(&mut simulator, &["power.input".into()], 3)[0];
        let (begin, step) = (other.time(), p.period() / f64::from(STEPS));
        let mut mean = 0.0;
        for k in 0..3 * STEPS {
            other.advance_to(begin + (f64::from(k) + 0.5) * step).unwrap();
            mean += p.drive_amplitude * other.drive_phase().sin() * other.state().v[0] / f64::from(3 * STEPS);
        }
        // Half a step at each impact.
        assert!((input - mean).abs() < 1e-3 * mean.abs(), "{input} {mean}");
    }
}
