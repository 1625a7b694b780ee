//! Orbits of machines with curved forces against a Fourier collocation, the motion's own
//! derivatives and differences.

use super::*;
use nalgebra::{Complex, DVector};
use std::f64::consts::{PI, TAU};
use vibro_machine::Start;

/// Points in a period of the collocation. Twice as many change nothing above rounding.
const POINTS: usize = 101;
/// Tolerance for states of order 1: rounding of the collocation's second derivatives.
const COLLOCATED: f64 = 1e-10;
/// Tolerance for the frequency at which the plate grazes, Hz: the search of the largest
/// displacement.
const GRAZED: f64 = 1e-7;
/// Tolerance for the moduli of multipliers, and for an orbit that is simulated again.
const ROUNDING: f64 = 1e-9;
/// Tolerance for the multiplier at a branch point, where its derivative by the parameter is large.
const BRANCHING: f64 = 1e-5;
/// Tolerance for a column, relative: rounding of the difference that it is compared with.
const APART: f64 = 1e-6;
const ALLOWED: Allowed = Allowed { rounding: ROUNDING, apart: APART };

/// Two bodies with curved springs and a curved dashpot, driven at `frequency` Hz.
fn chain(frequency: f64, more: &str) -> Machine {
    machine(&format!(
        "name = \"Chain\"\nbody.a = {{ mass = 1.0 }}\nbody.b = {{ mass = 0.3 }}\n\
         spring.a = {{ between = [\"ground\", \"a\"], stiffness = 40.0, cubic = 300.0, damping = 0.4 }}\n\
         spring.b = {{ between = [\"a\", \"b\"], stiffness = 5.0, quadratic = 10.0, cubic = 200.0, damping = 0.1 }}\n\
         damper.c = {{ between = [\"ground\", \"b\"], damping = 0.05, cubic = 0.3 }}\n\
         load.l = {{ on = \"a\", amplitude = 6.0, frequency = {frequency} }}\n{more}"
    ))
}

/// Numbers of two bodies for the collocation.
struct Chain {
    masses: [f64; 2],
    /// Stiffness, cubic and damping of the spring between ground and a.
    ground: [f64; 3],
    /// Stiffness, quadratic, cubic and damping of the spring between a and b.
    between: [f64; 4],
    /// Damping and cubic of the dashpot between ground and b.
    damper: [f64; 2],
}

/// [`chain`].
const CHAIN: Chain = Chain {
    masses: [1.0, 0.3],
    ground: [40.0, 300.0, 0.4],
    between: [5.0, 10.0, 200.0, 0.1],
    damper: [0.05, 0.3],
};

/// Newton's method for the displacements of both bodies at [`POINTS`] times of a period, by the
/// equations of motion at these times, with derivatives of the trigonometric interpolation.
fn collocate(chain: &Chain, frequency: f64, force: f64, x: &mut DVector<f64>) {
    let n = POINTS;
    let Chain { masses: [ma, mb], ground: [ka, ca, da], between: [k, q, c, d], damper: [db, cb] } = chain;
    let slope = DMatrix::from_fn(n, n, |i, j| match i as i64 - j as i64 {
        0 => 0.0,
        k => PI * frequency * (-1f64).powi(k as i32) / (PI * k as f64 / n as f64).sin(),
    });
    let bend = &slope * &slope;
    for _ in 0..30 {
        let (a, b) = (x.rows(0, n).into_owned(), x.rows(n, n).into_owned());
        let (va, vb, aa, ab) = (&slope * &a, &slope * &b, &bend * &a, &bend * &b);
        let (mut residual, mut matrix) = (DVector::zeros(2 * n), DMatrix::zeros(2 * n, 2 * n));
        matrix.view_mut((0, 0), (n, n)).copy_from(&(&bend * *ma + &slope * (da + d)));
        matrix.view_mut((0, n), (n, n)).copy_from(&(&slope * -d));
        matrix.view_mut((n, 0), (n, n)).copy_from(&(&slope * -d));
        matrix.view_mut((n, n), (n, n)).copy_from(&(&bend * *mb + &slope * (d + db)));
        for i in 0..n {
            let (e, rate) = (b[i] - a[i], vb[i] - va[i]);
            let inner = k * e + q * e * e + c * e.powi(3) + d * rate;
            let stiffness = k + 2.0 * q * e + 3.0 * c * e * e;
            let load = force * (TAU * i as f64 / n as f64).sin();
            residual[i] = ma * aa[i] + ka * a[i] + ca * a[i].powi(3) + da * va[i] - inner - load;
            residual[n + i] = mb * ab[i] + inner + db * vb[i] + cb * vb[i].powi(3);
            matrix[(i, i)] += ka + 3.0 * ca * a[i] * a[i] + stiffness;
            matrix[(i, n + i)] -= stiffness;
            matrix[(n + i, i)] -= stiffness;
            matrix[(n + i, n + i)] += stiffness;
            for j in 0..n {
                matrix[(n + i, n + j)] += 3.0 * cb * vb[i] * vb[i] * slope[(i, j)];
            }
        }
        let step = matrix.lu().solve(&residual).expect("a regular matrix");
        *x -= &step;
        if step.amax() < 1e-15 {
            break;
        }
    }
}

/// The trigonometric interpolation of a body's displacement at a time in periods.
fn interpolated(x: &DVector<f64>, body: usize, time: f64) -> f64 {
    let n = POINTS as f64;
    let weight = |i: usize| {
        let turn = PI * (time - i as f64 / n);
        (n * turn).sin() / (n * turn.sin())
    };
    (0..POINTS).map(|i| weight(i) * x[body * POINTS + i]).sum()
}

/// The largest displacement of the first body.
fn largest(x: &DVector<f64>) -> f64 {
    // At the turn the slope of the interpolation is zero: three parabolas find it.
    let (mut at, mut step) = (x.rows(0, POINTS).argmax().0 as f64 / POINTS as f64, 0.01);
    for _ in 0..8 {
        let [a, b, c] = [-step, 0.0, step].map(|by| interpolated(x, 0, at + by + 1e-9));
        at += 0.5 * step * (a - c) / (a - 2.0 * b + c);
        step *= 0.5;
    }
    interpolated(x, 0, at)
}

#[test]
fn second_method_fourier_collocation_of_curved_chains() {
    for frequency in [0.5, 3.0, 4.0] {
        let orbit = Orbit::settled(&chain(frequency, ""), &Start::default(), 200).unwrap();
        let mut x = DVector::zeros(2 * POINTS);
        (1..=20).for_each(|k| collocate(&CHAIN, frequency, 0.3 * f64::from(k), &mut x));
        let (time, state) = orbit.middle_state();
        for (body, own) in state[..2].iter().enumerate() {
            let there = interpolated(&x, body, time * frequency);
            let off = (there - own).abs();
            assert!(off < COLLOCATED, "{frequency} Hz, body {body}: {there} by collocation, off by {off:e}");
        }
    }
}

/// The gallery's plate touches its rail at the frequency at which the largest displacement is the
/// gap.
#[test]
fn second_method_fourier_collocation_of_the_plate_that_grazes_its_rail() {
    let family = Family::new(&example("duffing_stop.toml"), "load.coil.frequency", (30.0, 45.0)).unwrap();
    let branches = grown(&family, 6, 0);
    let grazes = specials(&branches, 0, "GR");
    // The second body has no part in it.
    let plate = Chain { masses: [0.5, 1.0], ground: [2e4, 2e9, 4.0], between: [0.0; 4], damper: [1.0, 0.0] };
    let mut x = DVector::zeros(2 * POINTS);
    (0..=30).for_each(|k| collocate(&plate, 25.0 + 0.497 * f64::from(k), 6.0, &mut x));
    let (mut low, mut high) = (39.91, 39.95);
    while high - low > 0.1 * GRAZED {
        let middle = 0.5 * (low + high);
        let mut there = x.clone();
        collocate(&plate, middle, 6.0, &mut there);
        *if largest(&there) < 3e-3 { &mut low } else { &mut high } = middle;
    }
    assert!(nearest(&grazes, low) < GRAZED, "{grazes:?} {low}");
}

/// Relative displacement and amplitude of the shaken mass in all balances of one harmonic at a
/// frequency, smallest first, as complex amplitudes of sin by a force of 1.
fn balances(chain: &Chain, frequency: f64, force: f64) -> Vec<[Complex<f64>; 2]> {
    let (w, i) = (TAU * frequency, Complex::i());
    let Chain { masses: [m, sink], ground: [k, _, c], between: [_, _, cubic, d], .. } = *chain;
    let at = |size: f64| {
        let wire = 0.75 * cubic * size * size + i * w * d;
        let ratio = Complex::from(1.0) - wire / (sink * w * w);
        let per_size = (i * w * c + (k - m * w * w)) * ratio + wire;
        (per_size.norm() * size - force, [force / per_size, force / per_size * ratio])
    };
    let grid: Vec<f64> = (1..4000).map(|n| 1e-5 * f64::from(n)).collect();
    let pairs = grid.windows(2).filter(|pair| at(pair[0]).0 * at(pair[1]).0 < 0.0);
    pairs.map(|pair| at(0.5 * (pair[0] + pair[1])).1).collect()
}

/// The gallery's energy sink has three motions at 4.75 Hz. Two lie on a closed curve that no sweep
/// of the frequency reaches from the main branch.
#[test]
fn second_method_fourier_collocation_of_an_energy_sink_and_its_detached_curve() {
    let machine = example("energy_sink.toml");
    let family = Family::new(&machine, "body.table.motion.frequency", (4.5, 4.9)).unwrap();
    let struck = Orbit::settled_at(&family, 4.75, &Start::default(), 400).unwrap();
    let branches = [branch(&family, &struck, &Default::default()).unwrap()];
    let calm = machine.description.with([("body.mass.start.v", 0.0)]).unwrap();
    let calm = Family::new(&Machine::new(calm), "body.table.motion.frequency", (4.5, 4.9)).unwrap();
    let calm = Orbit::settled_at(&calm, 4.75, &Start::default(), 400).unwrap();
    // Orbits without events of one machine differ if their states do.
    assert!(branches[0].passes(&struck) && !branches[0].passes(&calm));
    let mut found = branches[0].orbits_at(4.75);
    found.push(calm);
    let folds = specials(&branches, 0, "LP");
    // Folds of the closed curve, by which the gallery's page gives its range.
    assert!(nearest(&folds, 4.6156) < 1e-4 && nearest(&folds, 4.8470) < 1e-4, "{folds:?}");
    let chain = Chain {
        masses: [1.0, 0.05],
        ground: [1000.0, 0.0, 0.4],
        between: [0.0, 0.0, 4e5, 0.4],
        damper: [0.0; 2],
    };
    // The table's motion is a force on the mass, with another phase.
    let force = 0.5e-3 * 1000f64.hypot(0.4 * TAU * 4.75);
    let balances = balances(&chain, 4.75, force);
    let mut sizes = Vec::new();
    for [between, mass] in &balances {
        let mut x = DVector::from_fn(2 * POINTS, |row, _| {
            let turn = Complex::from_polar(1.0, TAU * (row % POINTS) as f64 / POINTS as f64);
            (turn * if row < POINTS { *mass } else { mass - between }).im
        });
        collocate(&chain, 4.75, force, &mut x);
        sizes.push(largest(&x));
    }
    let size = |orbit: &Orbit| {
        let mass = vibro_machine::Quantity::of_body(1, vibro_machine::What::S);
        orbit.watched(&[mass]).extents[0].largest
    };
    let mut own: Vec<f64> = found.iter().map(size).collect();
    own.sort_by(f64::total_cmp);
    sizes.sort_by(f64::total_cmp);
    assert_eq!((own.len(), sizes.len()), (3, 3), "{own:?} {sizes:?}");
    for (own, other) in own.iter().zip(&sizes) {
        assert!((own - other).abs() < COLLOCATED, "{own} {other}");
    }
}

#[test]
fn second_method_multipliers_and_columns_of_curved_chains() {
    let stops = "stop.wall = { between = [\"ground\", \"b\"], gap = 0.3, restitution = 0.6 }\n\
                 stop.soft = { between = [\"a\", \"ground\"], gap = 0.2, stiffness = 500.0, damping = 1.0 }\n\
                 friction.f = { between = [\"ground\", \"a\"], force = 0.1 }\n";
    for (frequency, more) in [(0.5, ""), (1.1, stops)] {
        let machine = chain(frequency, more);
        let orbit = Orbit::settled(&machine, &Start::default(), 400).unwrap();
        assert_eq!(orbit.word().is_empty(), more.is_empty());
        let parameters = [
            "load.l.frequency",
            "load.l.amplitude",
            "spring.a.cubic",
            "spring.b.quadratic",
            "damper.c.cubic",
            "body.b.mass",
            "spring.a.stiffness",
        ];
        examine(&machine, &orbit, &parameters, &ALLOWED);
    }
}

/// Two bodies with formulas, a spring across the motion, stops and friction.
#[test]
fn second_method_multipliers_and_columns_of_formulas() {
    let stops = "stop.wall = { between = [\"ground\", \"b\"], gap = 0.3, restitution = 0.6 }\n\
                 stop.soft = { between = [\"a\", \"ground\"], gap = 0.2, stiffness = 500.0, damping = 1.0 }\n\
                 friction.f = { between = [\"ground\", \"a\"], force = 0.1 }\n";
    for (frequency, more) in [(0.5, ""), (1.1, stops)] {
        let machine = machine(&format!(
            "name = \"Formulas\"\nbody.a = {{ mass = 1.0 }}\nbody.b = {{ mass = 0.3 }}\n{more}\
             [parameters]\nk = 40.0\nw = 2.0\nc = 0.05\n[spring]\n\
             a = {{ between = [\"ground\", \"a\"], damping = 0.4, force = \"= k * sin(w * e) / w + 300 * e^3\" }}\n\
             b = {{ between = [\"a\", \"b\"], stiffness = 60.0, damping = 0.1, offset = 0.2, free_length = 0.18 }}\n\
             [damper]\nc = {{ between = [\"ground\", \"b\"], force = \"= c * (rate + tanh(w * rate))\" }}\n\
             [load]\nl = {{ on = \"a\", amplitude = 6.0, frequency = {frequency} }}\n"
        ));
        let orbit = Orbit::settled(&machine, &Start::default(), 400).unwrap();
        assert_eq!(orbit.word().is_empty(), more.is_empty());
        let parameters = [
            "load.l.frequency",
            "load.l.amplitude",
            "k",
            "w",
            "c",
            "spring.b.offset",
            "spring.b.free_length",
        ];
        examine(&machine, &orbit, &parameters, &ALLOWED);
    }
}

/// Contacts with an exponent and a dissipation, and drag: flights along series that begin and end at
/// their edges.
#[test]
fn second_method_multipliers_and_columns_of_contacts() {
    let machine = machine(
        "name = \"Contacts\"\nbody.b = { mass = 0.5 }\n\
         spring.k = { between = [\"ground\", \"b\"], stiffness = 300.0, damping = 0.5 }\n\
         damper.air = { between = [\"ground\", \"b\"], quadratic = 0.3 }\n\
         stop.h = { between = [\"ground\", \"b\"], gap = 0.01, stiffness = 2e5, exponent = 1.5, dissipation = 0.3 }\n\
         load.l = { on = \"b\", amplitude = 6.0, frequency = 4.5 }\n",
    );
    let orbit = Orbit::settled(&machine, &Start::default(), 400).unwrap();
    assert!(!orbit.word().is_empty());
    let parameters = ["stop.h.stiffness", "stop.h.gap", "stop.h.dissipation", "damper.air.quadratic"];
    examine(&machine, &orbit, &parameters, &ALLOWED);
}

/// A symmetric orbit loses its symmetry where a multiplier of the motion passes 1, and continues
/// as an unstable orbit.
#[test]
fn second_method_a_symmetric_orbit_loses_its_symmetry() {
    let text = "name = \"Softening\"\nbody.b = { mass = 1.0 }\n\
        spring.e = { between = [\"ground\", \"b\"], stiffness = 1.0, cubic = -0.2, damping = 0.1 }\n\
        load.l0 = { on = \"b\", amplitude = 0.15, frequency = 0.13 }\n";
    let (machine, range) = (machine(text), (0.01, 0.6));
    let family = Family::new(&machine, "load.l0.amplitude", range).unwrap();
    let orbit = Orbit::settled(&machine, &Start::default(), 400).unwrap();
    let branches = [branch(&family, &orbit, &Default::default()).unwrap()];
    let found = specials(&branches, 0, "BP");
    let orbits = |value: f64| branches.iter().flat_map(move |b| b.orbits_at(value));
    let symmetric = |orbit: &Orbit| {
        let extents =
            &orbit.watched(&[vibro_machine::Quantity::of_body(0, vibro_machine::What::S)]).extents[0];
        (extents.largest + extents.least).abs() < ROUNDING
    };
    for value in &found {
        let orbit = orbits(*value).find(symmetric).expect("an orbit");
        assert!((moduli_by_motion(&orbit)[0] - 1.0).abs() < BRANCHING, "{value}");
    }
    assert_eq!(found.len(), 1, "{found:?}");
    let beyond = orbits(0.6).find(symmetric).expect("the symmetric orbit beyond");
    assert_eq!(beyond.stability(), Stability::Unstable);
    assert!(specials(&branches, 0, "LP").iter().all(|fold| (fold - found[0]).abs() > BRANCHING));
}

/// A limit cycle that leaves its stop has no events by which its period would be known: the branch
/// ends at the touch.
#[test]
fn invariant_a_limit_cycle_that_leaves_its_stop_ends_at_the_touch() {
    let text = "name = \"Cycle\"\nbody.b = { mass = 1.0, start = { s = 0.5, v = 0.2 } }\n\
        spring.e = { between = [\"ground\", \"b\"], stiffness = 1.0, cubic = 2.0 }\n\
        damper.d = { between = [\"ground\", \"b\"], cubic = 0.05, damping = -0.2 }\n\
        stop.s = { between = [\"ground\", \"b\"], gap = 0.8, restitution = 0.7 }\n";
    let family = Family::new(&machine(text), "stop.s.gap", (0.8, 1.5)).unwrap();
    let branches = grown(&family, 3, 1);
    assert_eq!(specials(&branches, 1, "GR").len(), 1);
}

/// A van der Pol oscillator has no events. A stop almost without stiffness gives it a section.
#[test]
fn second_method_limit_cycle_of_a_van_der_pol_oscillator() {
    // Period at μ = 1, from Poincaré-Lindstedt series of high order (C. M. Andersen and J. F. Geer,
    // SIAM J. Appl. Math. 42, 1982) and many integrations.
    const PERIOD: f64 = 6.663_286_859_323_13;
    // The section's stiffness of 1e-9 N/m shortens the period by twice as much.
    const STIFFENED: f64 = 4e-9;
    let text = |more: &str| {
        format!(
            "name = \"VanDerPol\"\nbody.a = {{ mass = 1.0, start = {{ s = 0.1 }} }}\n\
             spring.k = {{ between = [\"ground\", \"a\"], stiffness = 1.0, force = \"= -(1 - e^2)*rate\" }}\n{more}"
        )
    };
    let refused = Orbit::settled(&machine(&text("")), &Start::default(), 100).unwrap_err().to_string();
    let (_, advice) = refused.split_once("stop.section").unwrap();
    let advice = format!("stop.section{}\n", advice.trim_end_matches('`').replace("BODY", "a"));
    let orbit = Orbit::settled(&machine(&text(&advice)), &Start::default(), 100).unwrap();
    assert!((orbit.period() - PERIOD).abs() < STIFFENED, "{}", orbit.period());
}
