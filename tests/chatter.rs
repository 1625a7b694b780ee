//! Chatter under varying loads: chatter is closed only if it comes to rest, and soon.

use vibro_impact::simulator::{Event, Loads};
use vibro_impact::{Parameters, Simulator, State};

/// Half a unit in the last place: e_c of docs/theory.md (18).
const CLOSED: f64 = 0.5 * f64::EPSILON;

/// A box without spring and damper, and a block on which only its load acts: the relative
/// acceleration is the load over the block's mass. The secondary oscillator sets the fastest
/// `rate`, which limits how fast loads may change.
fn machine(kappa: f64, rate: f64) -> Parameters {
    Parameters {
        box_stiffness: 0.0,
        box_damping: 0.0,
        block_mass: 1.0,
        secondary_mass: 1.0,
        secondary_stiffness: rate * rate,
        coupling_stiffness: 0.0,
        drive_amplitude: 0.0,
        stop_restitution: kappa,
        ..Parameters::default()
    }
}

/// The block at the upper stop with a first rebound speed `u` and the load `derivatives`, advanced
/// by `span`: the simulator and its events.
fn bounce((kappa, rate): (f64, f64), u: f64, derivatives: [f64; 4], span: f64) -> (Simulator, Vec<Event>) {
    let at_stop = State { x: [0.0, 1.0, 0.0], v: [0.0, u / kappa, 0.0] };
    let mut simulator = Simulator::new(&machine(kappa, rate), &at_stop, 0.0).unwrap();
    simulator.set_loads(&Loads { derivatives: [[0.0; 4], derivatives, [0.0; 4]] }).unwrap();
    let mut events = Vec::new();
    simulator.advance_observed(span, &mut |event| events.push(*event)).unwrap();
    (simulator, events)
}

/// Chatter is closed at the impact after which the bounces move the block by at most 2⁻⁵³ gaps.
/// The bounces after a rebound u at constant acceleration a add up to u²/((1 - κ²) a), and (18)
/// bounds half of that times 1 + κ.
#[test]
fn closed_form_runs_are_closed_by_the_way_that_is_left() {
    let (kappa, a0) = (0.5, 1e-3);
    let limit = (0.5 * (1.0 - kappa) * CLOSED * a0).sqrt();
    assert!(limit * limit / ((1.0 - kappa * kappa) * a0) <= CLOSED);
    for (part, closed) in [(0.5, true), (0.99, true), (1.01, false), (1.9, false)] {
        let (_, events) = bounce((kappa, 1.0), part * limit, [a0, 0.0, 0.0, 0.0], 1e-12);
        assert!(matches!(events[0], Event::Impact { .. }), "{events:?}");
        assert_eq!(matches!(events.get(1), Some(Event::Rest { .. })), closed, "{part}: {events:?}");
    }
}

/// Under the load a0 - c t², whose jerk is initially zero, the acceleration reverses before the
/// block is back: it never comes back.
#[test]
fn closed_form_a_block_that_its_load_lets_go_does_not_come_to_rest() {
    /// Relative rounding of a sum of two speeds.
    const ROUNDING: f64 = 1e-12;
    let (kappa, a0) = (0.5, 1e-3);
    for part in [0.3, 0.6, 0.99] {
        let u = part * (0.5 * (1.0 - kappa) * CLOSED * a0).sqrt();
        // The path -u + a0 t/2 - c t³/12 stays below zero for c > 2 a0³/(9 u²).
        for excess in [1.1, 3.0] {
            let c = excess * 2.0 * a0 * a0 * a0 / (9.0 * u * u);
            let t = 20.0 * u / a0;
            let (simulator, events) = bounce((kappa, 1.0), u, [a0, 0.0, -2.0 * c, 0.0], t);
            assert!(matches!(events[..], [Event::Impact { .. }]), "{events:?}");
            let exact = t * (a0 - c * t * t / 3.0) - u;
            let rate = simulator.relative_motion().1;
            assert!((rate - exact).abs() <= ROUNDING * exact.abs(), "{rate:e} {exact:e}");
        }
    }
}

/// Under the load a0 - c t³, whose jerk and snap are initially zero, the block never comes back.
#[test]
fn closed_form_a_block_that_its_load_lets_go_late_does_not_come_to_rest() {
    let (kappa, a0) = (0.5, 1e-3);
    for part in [0.3, 0.6, 0.99] {
        let u = part * (0.5 * (1.0 - kappa) * CLOSED * a0).sqrt();
        // The path -u + a0 t/2 - c t⁴/20 stays below zero for c > 135 a0⁴/(1024 u³).
        for excess in [1.1, 3.0] {
            let c = excess * 135.0 * a0.powi(4) / (1024.0 * u.powi(3));
            let (_, events) = bounce((kappa, 1e3), u, [a0, 0.0, 0.0, -6.0 * c], 20.0 * u / a0);
            assert!(matches!(events[..], [Event::Impact { .. }]), "{events:?}");
        }
    }
}

/// A box that swings away on its spring moves as -X cos t. The load on the block follows it to
/// third order, and the relative acceleration is a0 - X t⁴/24. The block never comes back.
#[test]
fn closed_form_a_block_that_a_swinging_box_leaves_does_not_come_to_rest() {
    let (kappa, rate) = (0.5, 1.0);
    // So small that the chatter takes half the radius of convergence of the series.
    let a0 = 2e-12;
    for part in [0.6, 0.99] {
        let u = part * (0.5 * (1.0 - kappa) * CLOSED * a0).sqrt();
        // The path -u + a0 t/2 - X t⁵/720 stays below zero for X > 72 a0 (a0/(2.5 u))⁴.
        for excess in [1.1, 3.0] {
            let x = excess * 72.0 * a0 * (a0 / (2.5 * u)).powi(4);
            let p = Parameters { box_stiffness: 1.0, ..machine(kappa, rate) };
            let at_stop = State { x: [-x, 1.0 - x, 0.0], v: [0.0, u / kappa, 0.0] };
            // The box's speed is zero after the impact that begins the run.
            let kick = (1.0 + kappa) * u / kappa * p.block_mass / (p.box_mass + p.block_mass);
            let at_stop = State { v: [-kick, u / kappa - kick, 0.0], ..at_stop };
            let mut simulator = Simulator::new(&p, &at_stop, 0.0).unwrap();
            let load = [a0 + x, 0.0, -x, 0.0].map(|a| a * p.block_mass);
            simulator.set_loads(&Loads { derivatives: [[0.0; 4], load, [0.0; 4]] }).unwrap();
            let mut events = Vec::new();
            simulator.advance_observed(8.0 * u / a0, &mut |event| events.push(*event)).unwrap();
            assert!(matches!(events[..], [Event::Impact { .. }]), "{events:?}");
        }
    }
}

/// Speeds of departure and return of a flight of length τ that begins at t0, under the
/// acceleration a(t) = 1 + b t + c t² + d t³ in the time unit of the run: ∫ (τ - t) a(t0 + t) dt /
/// τ and ∫ t a(t0 + t) dt / τ over 0..τ.
fn speeds(a: &[f64; 4], t0: f64, tau: f64) -> (f64, f64) {
    let [one, b, c, d] = *a;
    let shifted =
        [one + t0 * (b + t0 * (c + t0 * d)), b + t0 * (2.0 * c + 3.0 * t0 * d), c + 3.0 * t0 * d, d];
    let (mut leaving, mut returning, mut power) = (0.0, 0.0, tau);
    for (k, coefficient) in shifted.iter().enumerate() {
        let k = k as f64;
        leaving += coefficient * power / ((k + 1.0) * (k + 2.0));
        returning += coefficient * power / (k + 2.0);
        power *= tau;
    }
    (leaving, returning)
}

/// Length of a run that begins with the speed 1 under a(t), bounce by bounce, in units of
/// 2/(1 - κ); infinite if the block does not come back.
fn run_length(kappa: f64, a: &[f64; 4]) -> f64 {
    let (mut t, mut u) = (0.0, 1.0);
    while u > 1e-9 {
        let (mut low, mut high) = (0.0, 2.0 * u);
        while speeds(a, t, high).0 < u {
            (low, high) = (high, 1.1 * high);
            if high > 1e3 {
                return f64::INFINITY;
            }
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if speeds(a, t, middle).0 < u { low = middle } else { high = middle }
        }
        u = kappa * speeds(a, t, high).1;
        t += high;
    }
    0.5 * t * (1.0 - kappa)
}

/// Under loads of any shape, chatter that the simulator closes ends within twice its length at
/// constant acceleration, if its bounces are computed one by one.
#[test]
fn second_method_closed_runs_end_within_twice_their_length() {
    let mut state = 1u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let (mut closed, mut open, mut longest) = (0, 0, 0.0f64);
    for n in 0..6000 {
        let kappa = [0.1, 0.5, 0.9][n % 3];
        let a0 = 1e-2;
        let u = 0.95 * (0.5 * (1.0 - kappa) * CLOSED * a0).sqrt();
        // Coefficients of a(t)/a0 in the time unit u/a0 of the run, which lasts 2/(1 - κ) units.
        let length = 2.0 / (1.0 - kappa);
        let mut a = [1.0, 0.0, 0.0, 0.0];
        let size = 10f64.powf(3.0 * next() - 3.0);
        for (k, a) in a.iter_mut().enumerate().skip(1) {
            *a = (2.0 * next() - 1.0) * size / length.powi(k as i32);
        }
        let rate = a0 / u;
        let load = [a0, a0 * a[1] * rate, 2.0 * a0 * a[2] * rate * rate, 6.0 * a0 * a[3] * rate.powi(3)];
        let (_, events) = bounce((kappa, 1e3), u, load, 1e-3 * u / a0);
        if events.iter().any(|event| matches!(event, Event::Rest { .. })) {
            closed += 1;
            longest = longest.max(run_length(kappa, &a));
        } else {
            open += 1;
        }
    }
    assert!(closed > 500 && open > 500, "{closed} closed, {open} not");
    assert!(longest <= 2.0, "{longest}");
}

/// If 1 - κ < 10⁻³, a run is closed as soon as its bounces are lower than 10⁻¹² gaps, even if it
/// would never end.
#[test]
fn closed_form_nearly_elastic_runs_are_closed_by_the_height_of_their_bounces() {
    const HEIGHT: f64 = 1e-12;
    let a = 1e-3;
    for kappa in [0.9995, 1.0] {
        for (part, closed) in [(0.99, true), (1.01, false)] {
            let u = (2.0 * a * part * HEIGHT).sqrt();
            let (simulator, events) = bounce((kappa, 1.0), u, [a, 0.0, 0.0, 0.0], 3.0 * u / a);
            let first = matches!(events[0], Event::Impact { .. });
            match events[1] {
                Event::Rest { time, .. } => assert!(first && closed && time == 0.0, "{kappa}: {events:?}"),
                _ => assert!(first && !closed && simulator.impacts().upper >= 2, "{kappa}: {events:?}"),
            }
        }
    }
}
