//! The constants of docs/numerics.md, sections 1 and 2, with machines and states chosen to break
//! them.

use vibro_impact::flow::{CENTRED, CORE, INTERVALS, Series, SubstepTable, WHOLE, remainder, substep};
use vibro_impact::model::{
    Augmented, BOX, BOX_RATE, COORDINATES, Forces, Model, RELATIVE, RELATIVE_RATE, SECONDARY, SECONDARY_RATE,
    SmoothMode,
};
use vibro_impact::{Parameters, Simulator, State};
use vibro_numerics::double_double::DoubleDouble;

/// Relative rounding of sums of positive terms and of their bounds.
const ROUNDING: f64 = 1e-12;

/// Pseudo-random numbers in [0, 1).
fn random(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Undamped box at resonance, alone: k1 = ω = F/m = 1, so that r = 1.
fn resonant_box() -> Model {
    let p = Parameters {
        box_damping: 0.0,
        secondary_damping: 0.0,
        secondary_stiffness: 0.0,
        coupling_stiffness: 0.0,
        drive_amplitude: 1.0,
        drive_frequency: 1.0,
        ..Parameters::default()
    };
    Model::new(&p).unwrap()
}

/// Random machine of springs, masses and dampers that are equal or differ by orders of magnitude;
/// springs and dampers may be zero. Half of the machines are driven at the rate r. The bounds are
/// nearly attained if a single element determines r.
fn any_machine(next: &mut impl FnMut() -> f64) -> Model {
    let mut one_of = |values: [f64; 4]| values[(4.0 * next()) as usize % 4];
    let mut p = Parameters::default();
    for stiffness in [&mut p.box_stiffness, &mut p.secondary_stiffness, &mut p.coupling_stiffness] {
        *stiffness = one_of([0.0, 1.0, 1.0, 1e-3]);
    }
    for damping in [&mut p.box_damping, &mut p.secondary_damping] {
        *damping = one_of([0.0, 0.0, 0.1, 1.0]);
    }
    for mass in [&mut p.block_mass, &mut p.secondary_mass] {
        *mass = one_of([1.0, 1.0, 0.1, 1e-4]);
    }
    p.stop_gap = one_of([1.0, 1.0, 1e-2, 1e-6]);
    let still = Parameters { drive_frequency: 0.0, ..p };
    let rate = Model::new(&still).unwrap().rate;
    p.drive_frequency = rate * one_of([1.0, 1.0, 0.5, 1e-3]);
    Model::new(&p).unwrap()
}

/// Random state, drive and loads. Each coordinate, the drive and each coefficient of a load
/// contributes 0 or 1 to the terms of [`size`].
fn any_start(model: &Model, next: &mut impl FnMut() -> f64) -> (Model, Augmented, Forces) {
    let mut corner = || -> f64 { [-1.0, 0.0, 1.0, 1.0, -1.0][(5.0 * next()) as usize % 5] };
    // Each part of the size is present or absent, so that often there is only one.
    let (bodies, drive, loads) = (corner().abs(), corner().abs(), corner().min(0.0).abs());
    let r = model.rate;
    let gap = model.gap;
    let rates = [r, r, r].map(|r| bodies * r * corner());
    let angle = [0.0, 0.25, 0.5, 1.0][((corner() + 1.0) as usize) % 4] * std::f64::consts::PI;
    let mut model = *model;
    model.drive = r * r * drive;
    let z = [
        bodies * corner(),
        gap * corner(),
        bodies * corner(),
        rates[0],
        rates[1],
        rates[2],
        angle.cos(),
        angle.sin(),
    ];
    let mut forces = [[0.0; 4]; 3];
    for (f, inverse_mass) in forces.iter_mut().zip(model.inverse_mass) {
        let mut unit = r * r / inverse_mass;
        for f in f.iter_mut() {
            *f = loads * unit * corner();
            unit *= r;
        }
    }
    (model, z, forces)
}

/// Size S of a motion: the sum of the gap, the largest of the other coordinates, drive and loads,
/// all as lengths.
fn size(model: &Model, z: &Augmented, forces: &Forces) -> f64 {
    let r = model.rate;
    let rates = z[BOX_RATE].abs().max(z[RELATIVE_RATE].abs()).max(z[SECONDARY_RATE].abs()) / r;
    let mut sum = model.gap + z[BOX].abs().max(z[SECONDARY].abs()).max(rates) + model.drive / (r * r);
    for (f, inverse_mass) in forces.iter().zip(model.inverse_mass) {
        for (k, f) in f.iter().enumerate() {
            sum += f.abs() * inverse_mass / r.powi(k as i32 + 2);
        }
    }
    sum
}

/// Largest coordinate of a coefficient, with rates over r.
fn largest(model: &Model, state: &Augmented) -> f64 {
    let displacements = state[..3].iter().fold(0.0f64, |most, x| most.max(x.abs()));
    state[3..6].iter().fold(displacements, |most, v| most.max(v.abs() / model.rate))
}

/// Derivatives x^(k) = ±(1 + k/2) for even k: at resonance the contributions of the drive add up
/// from order to order, since r bounds only the matrix of the bodies, without the drive.
#[test]
fn closed_form_coefficients_of_a_box_in_resonance() {
    let model = resonant_box();
    assert_eq!(model.rate, 1.0);
    let z = [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let series = Series::<CENTRED>::expand(&model, SmoothMode::Flight, &z, None, 1.0);
    let mut factorial = 1.0;
    for (k, state) in series.states.iter().enumerate().skip(1) {
        factorial *= k as f64;
        if k % 2 == 0 {
            assert!(
                (state[BOX].abs() * factorial - (1.0 + 0.5 * k as f64)).abs() < ROUNDING,
                "{k}: {state:?}"
            );
        }
    }
}

/// Remainder of series for a resonant box that only its drive moves: about 0.35 of the bound,
/// because the coefficients of the displacement are √½ (k-1)/2 or √½ k/2, over k!. A bound without
/// the drive's part would be smaller by a factor of n, and would be wrong.
#[test]
fn closed_form_remainders_of_a_box_in_resonance() {
    fn left_out<const N: usize>(model: &Model, reach: f64) -> f64 {
        let z = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5f64.sqrt(), 0.5f64.sqrt()];
        let series = Series::<WHOLE>::expand(model, SmoothMode::Flight, &z, None, reach);
        let sum =
            |coordinate: usize| series.states[N..].iter().map(|state| state[coordinate]).sum::<f64>().abs();
        sum(BOX).max(sum(BOX_RATE))
    }
    let model = resonant_box();
    let parts = [
        left_out::<9>(&model, 0.08) / remainder(9, 0.08),
        left_out::<10>(&model, 0.09) / remainder(10, 0.09),
        left_out::<12>(&model, 0.15) / remainder(12, 0.15),
        left_out::<20>(&model, 1.2) / remainder(20, 1.2),
    ];
    assert!(parts.iter().all(|part| *part > 0.2 && *part <= 1.0), "{parts:?}");
}

/// Coefficients of order k ≥ 7 are at most (rT)ᵏ/(k-1)! S; coefficients of the free acceleration
/// at rest are at most (3k+1) (rT)ᵏ/k! r² S.
#[test]
fn invariant_coefficients_stay_under_their_bound() {
    let mut next = random(1);
    let mut most = [0.0f64; 2];
    for _ in 0..20_000 {
        let (model, z, forces) = any_start(&any_machine(&mut next), &mut next);
        let size = size(&model, &z, &forces);
        let radius = 1.0 / model.rate;
        let flight = Series::<WHOLE>::expand(&model, SmoothMode::Flight, &z, Some(&forces), radius);
        let mut held = z;
        (held[RELATIVE], held[RELATIVE_RATE]) = (model.gap, 0.0);
        let rest = Series::<WHOLE>::expand(&model, SmoothMode::Rest, &held, Some(&forces), radius);
        let mut factorial = 720.0; // (k-1)!
        for k in 7..WHOLE {
            let bound = size / factorial;
            for series in [&flight, &rest] {
                most[0] = most[0].max(largest(&model, &series.states[k]) / bound);
            }
            factorial *= k as f64;
            let bound = (3 * k + 1) as f64 * size * model.rate * model.rate / factorial;
            most[1] = most[1].max(rest.free[k].abs() / bound);
        }
    }
    // The largest coefficient exceeds half of its bound. So it exceeds (rT)ᵏ/k! S, the bound
    // without the accumulating drive.
    assert!(most[0] > 0.5, "{most:?}");
    assert!(most.iter().all(|part| *part <= 1.0 + ROUNDING), "{most:?}");
}

/// δ of docs/numerics.md, section 2, in ε S.
const SAMPLE_ROUNDING: f64 = 900.0;

/// Sum of a sample's roundings by the bounds of docs/numerics.md: roundings of the table's entries
/// order by order, and roundings of twenty products and sums.
#[test]
fn closed_form_roundings_of_a_sample_add_up_to_less_than_is_said() {
    /// r times the length of a sub-step.
    const REACH: f64 = 2.4;
    const TERMS: f64 = 20.0;
    let (mut entries, mut power) = (0.0, 1.0);
    for k in (1..WHOLE).map(|k| k as f64) {
        power *= REACH / k;
        // Bound on the coefficient of order k of w, in S.
        let bound = if k == 1.0 { 1.0 } else { k.max(2.5 + 0.5 * k) };
        entries += (5.5 * k + 0.5 * k + 1.0) * bound * power;
    }
    assert!(entries < 690.0, "{entries}");
    assert!(entries + 10.5 * TERMS < SAMPLE_ROUNDING, "{entries}");
}

/// The sum of the absolute values of a sample's terms is at most 20 S; more than 7 S occur. The
/// rounding of the sample is at most [`SAMPLE_ROUNDING`] ε S.
#[test]
fn second_method_rounding_of_samples() {
    const TERMS: f64 = 20.0;
    const ERROR: f64 = SAMPLE_ROUNDING * f64::EPSILON;
    let mut next = random(2);
    let (mut terms, mut error) = (0.0f64, 0.0f64);
    for n in 0..400 {
        let machine = if n == 0 { resonant_box() } else { any_machine(&mut next) };
        let h = substep(&machine);
        for _ in 0..4 {
            let (model, z, _) = any_start(&machine, &mut next);
            let mut table = SubstepTable::<CORE>::zero();
            table.fill(pulp::Scalar, &model, SmoothMode::Flight, h);
            let size = size(&model, &z, &[[0.0; 4]; 3]);
            let mut g = [0.0; INTERVALS];
            table.samples(&z, &mut g);
            let exact = exact_states(&model, &z, h);
            for (i, exact) in exact.iter().enumerate() {
                let sum: f64 = (0..CORE).map(|j| (table.sample[j][i] * z[j]).abs()).sum();
                terms = terms.max(sum / size);
                error = error.max(exact[RELATIVE].plus(-g[i]).value().abs() / size);
            }
        }
    }
    println!("Σ |T| |z| up to {terms} S, rounding up to {} ε S", error / f64::EPSILON);
    assert!(terms > 7.0 && terms <= TERMS, "{terms}");
    assert!(error <= ERROR, "{}", error / f64::EPSILON);
}

/// Rounding error of the state at a time within a sub-step. It is about ε S, and several times as
/// much if a strong damper gives the series large terms of alternating sign, as for this machine
/// and state, found by a search for large rounding.
#[test]
fn second_method_rounding_of_a_sub_step() {
    /// Limits on the errors of displacements and of rates/r, in ε S: one and a half times the
    /// values of docs/numerics.md, section 1.
    const MOST: [f64; 2] = [10.5, 13.5];
    let p = Parameters {
        box_mass: 1.0,
        block_mass: 0.047_582_201_853_492_2,
        secondary_mass: 0.05,
        box_stiffness: 0.0,
        coupling_stiffness: 0.516_015_768_440_704_6,
        secondary_stiffness: 0.955_374_550_001_833_1,
        box_damping: 0.132_414_428_281_472_57,
        secondary_damping: 15.807_257_112_632_993,
        drive_amplitude: 0.0,
        ..Parameters::default()
    };
    let (model, s) = (Model::new(&p).unwrap(), 8.493_480_670_410_356);
    let r = model.rate;
    let (x1, v1) = (0.684_232_842_383_883_8 * s, -0.058_972_940_576_079_4 * s * r);
    let x = [x1, x1, -0.974_890_383_402_363_9 * s];
    let v = [v1, v1 - 0.181_519_199_693_590_86 * r, 3.865_994_584_097_759 * s * r];
    let mut simulator = Simulator::new(&p, &State { x, v }, 0.0).unwrap();
    let (start, end) = (simulator.augmented(), 0.939_866_118_486_223_8 * substep(&model));
    let exact = exact_states(&model, &start, end)[INTERVALS - 1];
    simulator.advance_to(end).unwrap();
    let size = size(&model, &start, &[[0.0; 4]; 3]);
    let off = |j: usize| exact[j].plus(-simulator.augmented()[j]).value().abs() / (f64::EPSILON * size);
    let most = |first: usize| (first..first + 3).map(off).fold(0.0, f64::max);
    let (places, rates) = (most(BOX), most(BOX_RATE) / r);
    println!("rounding of a sub-step: {places} ε S, {rates} ε r S");
    // The error of the rates exceeds one unit in the last place of r S.
    assert!(rates > 2.0 && places < MOST[0] && rates < MOST[1], "{places} {rates}");
}

/// State at the interval ends to 30 digits, by the series of docs/theory.md (8) in double-doubles.
fn exact_states(model: &Model, z: &Augmented, h: f64) -> [[DoubleDouble; COORDINATES]; INTERVALS] {
    let wide = DoubleDouble::new;
    let times = |a: f64, b: DoubleDouble| wide(a).times(b);
    let mut order: [DoubleDouble; COORDINATES] = z.map(wide);
    let mut sums = [order; INTERVALS];
    for k in 1..60 {
        let [x1, w, x3, v1, vw, v3, cos, sin] = order;
        let stretch = x1.minus(x3) + w;
        let a1 = times(model.drive, sin).minus(times(model.k1, x1)).minus(times(model.c1, v1));
        let a2 = times(-model.k2, stretch);
        let a3 = times(model.k32, stretch).minus(times(model.k3, x3)).minus(times(model.c3, v3));
        let next = [v1, vw, v3, a1, a2.minus(a1), a3, times(-model.omega, sin), times(model.omega, cos)];
        // Time is in intervals: at the end of interval i the term of order k is iᵏ times its
        // coefficient.
        let unit = wide(h / INTERVALS as f64);
        order = next.map(|x| {
            let y = x.times(unit);
            divided(y, f64::from(k))
        });
        for (i, sums) in sums.iter_mut().enumerate() {
            for (sum, mut power) in sums.iter_mut().zip(order) {
                for _ in 0..k {
                    power = times(i as f64 + 1.0, power);
                }
                *sum = *sum + power;
            }
        }
    }
    sums
}

/// x/n in extended precision.
fn divided(x: DoubleDouble, n: f64) -> DoubleDouble {
    let first = x.value() / n;
    let rest = x.minus(DoubleDouble::new(first).times(DoubleDouble::new(n))).value();
    DoubleDouble::new(first).plus(rest / n)
}

/// The table's bound on |w''| holds throughout a sub-step, even between the interval centres: it
/// is the largest value at a centre times a bound on the growth over half an interval.
#[test]
fn invariant_the_bound_holds_between_the_samples() {
    /// Places in an interval on each side of its centre.
    const PLACES: i32 = 5;
    let mut next = random(6);
    let mut most = 0.0f64;
    for _ in 0..2_000 {
        let (model, z, _) = any_start(&any_machine(&mut next), &mut next);
        let mut table = Box::new(SubstepTable::<CORE>::zero());
        table.fill(pulp::Scalar, &model, SmoothMode::Flight, substep(&model));
        let (bound, radius) = (table.curvature(&z), 0.5 * substep(&model) / INTERVALS as f64);
        for columns in &table.centre {
            let mut centre = [0.0; 8];
            SubstepTable::transit(columns, &z, &mut centre);
            let series = Series::<CENTRED>::expand(&model, SmoothMode::Flight, &centre, None, radius);
            for place in -PLACES..=PLACES {
                let u = f64::from(place) / f64::from(PLACES);
                let terms = series.states.iter().enumerate().skip(2);
                let bend: f64 =
                    terms.map(|(k, c)| (k * (k - 1)) as f64 * c[RELATIVE] * u.powi(k as i32 - 2)).sum();
                most = most.max(bend.abs() / (radius * radius * bound));
            }
        }
    }
    assert!(most > 0.9 && most <= 1.0, "{most}");
}

/// In a search for an event in flight, the absolute values of the coefficients add up to little
/// more than twice the size of the motion at the centre of the series (docs/numerics.md, "Second
/// stage"). In the random states the path of the fast block in an interval is at most `MAX_REACH`
/// gaps. They are tested at the start, and at the centres of the intervals up to the first one
/// that ends beyond a stop.
#[test]
fn invariant_searched_coefficients_add_up_to_little_more_than_two_sizes() {
    const MOST: f64 = 2.3;
    /// `MAX_REACH`, in gaps.
    const REACH: f64 = 4.0;
    let mut next = random(5);
    let (mut most, mut searched) = (0.0f64, 0);
    for _ in 0..2_000 {
        let (model, mut z, _) = any_start(&any_machine(&mut next), &mut next);
        let h = substep(&model) / INTERVALS as f64;
        let mut table = Box::new(SubstepTable::<CORE>::zero());
        table.fill(pulp::Scalar, &model, SmoothMode::Flight, substep(&model));
        z[RELATIVE] = model.gap * (2.0 * next() - 1.0);
        let sum = |z: &Augmented, radius: f64| {
            let series = Series::<CENTRED>::expand(&model, SmoothMode::Flight, z, None, radius);
            let sizes: f64 = series.states.iter().map(|state| state[RELATIVE].abs()).sum();
            (model.gap + sizes) / size(&model, z, &[[0.0; 4]; 3])
        };
        // Bound on the block's path in an interval. The speed is drawn up to the largest at which
        // this path is `MAX_REACH` gaps. States whose acceleration alone exceeds this are skipped.
        let path = |z: &Augmented| {
            let bound = table.curvature(z);
            z[RELATIVE_RATE].abs() * h + 0.5 * bound * h * h
        };
        z[RELATIVE_RATE] = 0.0;
        let still = path(&z);
        z[RELATIVE_RATE] = if next() < 0.5 { -1.0 } else { 1.0 } * REACH * model.gap / h;
        let fastest = path(&z) - still;
        z[RELATIVE_RATE] *= ((REACH * model.gap - still) / fastest).max(0.0) * next();
        if path(&z) > REACH * model.gap * (1.0 + ROUNDING) {
            continue;
        }
        most = most.max(sum(&z, h));
        let mut w = [0.0; INTERVALS];
        table.samples(&z, &mut w);
        for (columns, w) in table.centre.iter().zip(&w) {
            let mut centre = [0.0; 8];
            SubstepTable::transit(columns, &z, &mut centre);
            most = most.max(sum(&centre, 0.5 * h));
            searched += 1;
            if w.abs() > model.gap {
                break;
            }
        }
    }
    println!("{searched} series: {most} sizes at most");
    assert!(searched > 2_000 && most > 1.5 && most <= MOST, "{searched}: {most}");
}
