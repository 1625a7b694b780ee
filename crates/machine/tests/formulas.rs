//! Springs and dampers whose forces are formulas: motions in closed form, energies, events, ends.

use std::f64::consts::PI;
use std::sync::Arc;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::{Event, EventKind, Motion};
use vibro_machine::{Assembly, Differentiated, Quantity, What};

fn described(text: &str) -> Result<vibro_machine::description::Description, String> {
    parse(text, "m.toml", &no_records).map_err(|refusal| refusal.to_string())
}

fn machine(text: &str) -> Arc<Assembly> {
    let description = described(text).expect("a machine");
    Arc::new(Assembly::new(description).expect("an assembly"))
}

/// Rounding of a state after some periods, relative to its amplitudes.
const RETURNED: f64 = 1e-12;
/// Tolerance on the difference from 40 digits, divided by the motion's amplification of a change
/// of its start: some tens of roundings of coordinates and rates of order 1 to 10.
const ROUNDINGS: f64 = 1e-13;
/// Difference of the energy from its accounts, relative to the first energy.
const BALANCE: f64 = 1e-13;

/// Complete elliptic integral of the first kind of a modulus by the arithmetic-geometric mean.
fn complete(modulus: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - modulus * modulus).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    PI / (2.0 * a)
}

/// Jacobi's sn by descending Landen transformations.
fn sn(u: f64, modulus: f64) -> f64 {
    let (mut means, mut a, mut b) = (Vec::new(), 1.0, (1.0 - modulus * modulus).sqrt());
    for _ in 0..20 {
        let c = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        means.push(c / a);
    }
    let mut angle = u * a * f64::from(1u32 << means.len());
    for c in means.iter().rev() {
        angle = 0.5 * (angle + (c * angle.sin()).asin());
    }
    angle.sin()
}

/// A pendulum that starts at rest at 170°: sin(φ/2) = k sn(K(k) - ω t).
#[test]
fn closed_form_pendulum_from_170_degrees() {
    let (inertia, moment, start) = (0.7, 2.3, 170.0 / 180.0 * PI);
    let text = format!(
        "name = \"Pendulum\"\n[parameters]\nm = 0.5\ng = 9.2\nl = 0.5\n\
         [body.arm]\ninertia = {inertia}\nstart = {{ s = {start} }}\n\
         [spring.weight]\nbetween = [\"ground\", \"arm\"]\nforce = \"= m*g*l * sin(e)\"\n"
    );
    let (omega, modulus) = ((moment / inertia as f64).sqrt(), (start / 2.0).sin());
    let mut motion = Motion::new(machine(&text)).expect("a motion");
    let period = 4.0 * complete(modulus) / omega;
    let mut largest = 0.0f64;
    for k in 1..=200 {
        let time = f64::from(k) * 0.02 * period;
        motion.advance_to(time).expect("an end");
        let exact = 2.0 * (modulus * sn(complete(modulus) - omega * time, modulus)).asin();
        largest = largest.max((motion.coordinate(0) - exact).abs());
    }
    assert!(largest < RETURNED, "{largest:e}");
    assert!((motion.body(0)[0] - start).abs() < RETURNED && motion.body(0)[1].abs() < RETURNED);
    let (kinetic, stored) = motion.kinetic_and_stored();
    let whole = moment * (1.0 - start.cos());
    assert!((kinetic + stored - whole).abs() < BALANCE * whole, "{:e}", kinetic + stored - whole);
}

/// Random chains against an extrapolation in 50 digits (`data/make_formulas.py`): number of
/// impacts, and states up to the rounding that the motion has amplified; the energy balances.
#[test]
fn second_method_random_chains_in_forty_digits() {
    let all = include_str!("data/formulas.txt");
    for row in all.lines() {
        let fields: Vec<&str> = row.split(';').collect();
        let number = |text: &str| text.trim().parse::<f64>().expect("a number");
        let (end, impacts, factor) = (number(fields[1]), number(fields[2]), number(fields[3]));
        let mut motion = Motion::new(machine(&fields[0].replace('|', "\n"))).expect("a motion");
        let energy = |motion: &Motion| motion.kinetic_and_stored().0 + motion.kinetic_and_stored().1;
        let first = energy(&motion);
        let mut count = 0.0;
        let mut observer =
            |event: &Event| count += f64::from(u8::from(matches!(event.kind, EventKind::Impact { .. })));
        motion.advance_observed(end, &mut observer).expect("an end");
        assert_eq!(count, impacts, "{row}");
        let bodies = fields[4].split(',').count() / 2;
        for (k, x) in fields[4].split(',').map(number).enumerate() {
            let own = motion.body(k % bodies)[k / bodies];
            let off = (own - x).abs() / factor.max(1.0);
            assert!(off < ROUNDINGS, "{off:e}: {own} {x} of {row}");
        }
        let put_in = motion.energy().loads.iter().map(|own| own.value().abs()).sum::<f64>();
        let size = first.abs() + put_in + energy(&motion).abs() + 1.0;
        let off = energy(&motion) - first - motion.energy().balance();
        assert!(off.abs() < BALANCE * size, "{off:e} of {size} in {row}");
    }
}
