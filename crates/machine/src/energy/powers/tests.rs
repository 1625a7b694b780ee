//! Means of powers from stored coefficients and from states, against the exact mean and against
//! each other.

use super::*;
use crate::file::{no_records, parse};
use crate::{Assembly, Motion};
use nalgebra::DMatrix;
use std::sync::Arc;

/// Tolerance for sums of some tens of terms, relative to the largest power.
const ROUNDING: f64 = 1e-11;

const MACHINE: &str = "name = \"P\"\ngravity = 9.81\n\
    [body.a]\nmass = 1.3\ngravity = 1.0\nstart = { s = 0.1, v = -2.0 }\n[body.b]\nmass = 0.7\nstart = { s = 0.1, v = 3.0 }\n\
    [body.belt]\nmotion = { rate = 0.4 }\n\
    [spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 60.0\ndamping = 0.8\n\
    [spring.m]\nbetween = [\"a\", \"b\"]\nstiffness = 35.0\ndamping = 1.7\n\
    [stop.buffer]\nbetween = [\"ground\", \"a\"]\ngap = 0.05\nstiffness = 90.0\ndamping = 0.1\n\
    [friction.f]\nbetween = [\"belt\", \"b\"]\nforce = 2.5\n\
    [load.l]\non = \"b\"\namplitude = 3.0\nfrequency = 1.4\nphase = 0.6\n";

#[test]
fn second_method_means_of_powers_by_two_ways_and_over_long_steps() {
    let machine = Arc::new(Assembly::new(parse(MACHINE, "p.toml", &no_records).unwrap()).unwrap());
    let motion = Motion::new(machine.clone()).unwrap();
    let (system, mode) = (machine.system(), motion.mode());
    let table = FlowTable::new(system.linear(mode), system.signals.one);
    let powers = Powers::new(system, mode, &table);
    let (size, one) = (system.signals.size, system.signals.one);
    assert!(powers.are_dense());
    let mut z: Vec<f64> = (0..size).map(|i| (1.7 * i as f64 + 0.4).sin()).collect();
    z[one] = 1.0;
    let a = DMatrix::from_fn(size, size, |i, j| table.a.entry(i, j));
    let state = DMatrix::from_column_slice(size, 1, &z);
    let means = |samples: &Samples| {
        let (mut values, mut found) = (Vec::new(), Vec::new());
        powers.for_each(samples, &mut values, |account, mean| found.push((account, mean)));
        found
    };
    for part in [1.0, 0.43, 0.02] {
        let states: Vec<f64> = NODES
            .iter()
            .flat_map(|node| ((&a * (node.0 * part * table.length)).exp() * &state).as_slice().to_vec())
            .collect();
        let exact = means(&Samples::States(&states, size));
        let most = exact.iter().map(|x| x.1.abs()).fold(1.0, f64::max);
        let found = means(&Samples::Start(&z, part));
        assert_eq!(found.len(), exact.len());
        for (x, y) in found.iter().zip(&exact) {
            assert!(x.0 == y.0 && (x.1 - y.1).abs() < ROUNDING * most, "{part}: {x:?} {y:?}");
        }
    }
    // Over 2ᵏ sub-steps: the sum over all of them.
    for k in 0..6 {
        let (mut sums, mut there, mut most) = (vec![0.0; powers.all.len()], state.clone(), 1.0f64);
        let step = (&a * table.length).exp();
        for _ in 0..1 << k {
            for (sum, (_, mean)) in sums.iter_mut().zip(means(&Samples::Start(there.as_slice(), 1.0))) {
                *sum += mean * table.length;
                most = most.max(mean.abs());
            }
            there = &step * there;
        }
        let (mut found, mut accounts) = (Vec::new(), Vec::new());
        powers.for_each_work(k, &table, &z, |account, work| {
            found.push(work);
            accounts.push(account);
        });
        assert_eq!(accounts, powers.all.iter().map(|p| p.account).collect::<Vec<_>>());
        let states = NodeStates::over(k, &table, &z);
        let works = powers.all.iter().map(|power| {
            let [left, right] = power.of.map(|place| &powers.rows[place]);
            power.factor * states.product(left, right)
        });
        for ((x, other), y) in found.iter().zip(works).zip(&sums) {
            for x in [*x, other] {
                assert!((x - y).abs() < ROUNDING * most * f64::from(1u32 << k), "{k}: {x} {y}");
            }
        }
    }
    // Each account occurs: one load, two dashpots, the buffer, the friction, and the drive of the
    // belt.
    let has = |account: Account| powers.all.iter().any(|power| power.account == account);
    assert!(has(Account::Load(0)) && has(Account::Dashpot(0)) && has(Account::Dashpot(1)));
    assert!(has(Account::Stop(0)) && has(Account::Friction(0)) && has(Account::Motions));
}
