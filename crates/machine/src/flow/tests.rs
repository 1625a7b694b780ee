//! The flow of chains with closed contacts, pressed stops, friction and loads, against the matrix
//! exponential by Padé approximants.

mod remainder;
mod wide;

use super::*;
use crate::file::{no_records, parse};
use crate::kernel::NODES;
use crate::mode::Watch;
use crate::{Assembly, Motion};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Tolerance relative to the largest coordinate: some thousands of rounding errors.
const ROUNDING: f64 = 1e-12;
/// Tolerance for a stiff mode's flow, whose rate times time is up to 62.
const STIFF_ROUNDING: f64 = 1e-10;
/// Number of points at which a bound is compared with the bounded value.
const PLACES: usize = 24;

/// A chain on the ground. Its first body presses a buffer, its last body meets a rigid stop and,
/// if `holds`, its second body sticks to the ground. A load turns once in a second.
fn chain(count: usize, stiffness: f64, holds: bool) -> (FlowTable, usize) {
    let mut text = "name = \"C\"\ngravity = 9.81\n".to_owned();
    for i in 0..count {
        let (mass, s) = (1.0 + 0.3 * i as f64, if i == 0 { 0.02 } else { 0.0 });
        text += &format!("[body.b{i}]\nmass = {mass}\ngravity = 1.0\nstart = {{ s = {s}, v = 0.0 }}\n");
        let before = if i == 0 { "ground".into() } else { format!("b{}", i - 1) };
        let (k, c) = (if i == 1 { stiffness } else { 40.0 + 3.0 * i as f64 }, 0.5 + 0.1 * i as f64);
        text +=
            &format!("[spring.k{i}]\nbetween = [\"{before}\", \"b{i}\"]\nstiffness = {k}\ndamping = {c}\n");
    }
    let last = count - 1;
    text += "[stop.buffer]\nbetween = [\"ground\", \"b0\"]\ngap = 0.01\nstiffness = 90.0\ndamping = 2.0\n";
    text += &format!("[stop.end]\nbetween = [\"ground\", \"b{last}\"]\ngap = 0.5\nrestitution = 0.5\n");
    text += "[load.l]\non = \"b0\"\namplitude = 3.0\nfrequency = 1.0\n";
    if holds {
        text += "[friction.f]\nbetween = [\"ground\", \"b1\"]\nforce = 1000.0\n";
    }
    let machine = Arc::new(Assembly::new(parse(&text, "c.toml", &no_records).unwrap()).unwrap());
    let motion = Motion::new(machine.clone()).unwrap();
    let (system, mode) = (machine.system(), motion.mode());
    assert_eq!(mode.basis.len(), usize::from(holds));
    (FlowTable::new(system.linear(mode), system.signals.one), system.signals.one)
}

/// Chains with tables, with a stiff spring that is computed separately, and with so many
/// coordinates that series replace the tables.
fn tables() -> Vec<(FlowTable, usize)> {
    let mut all = Vec::new();
    for holds in [false, true] {
        for (count, stiffness) in [(3, 60.0), (3, 4e4), (12, 60.0), (12, 4e4)] {
            all.push(chain(count, stiffness, holds));
        }
    }
    assert!(all.iter().any(|(t, _)| t.is_dense() && t.apart.is_some() && t.loose.is_some()));
    assert!(all.iter().any(|(t, _)| t.is_dense() && t.apart.is_none()));
    assert!(all.iter().any(|(t, _)| !t.is_dense()));
    all
}

/// A as a matrix.
fn dense(a: &SparseMatrix) -> DMatrix<f64> {
    DMatrix::from_fn(a.len(), a.len(), |i, j| a.entry(i, j))
}

/// States whose coordinates are in no simple ratio, most of them with one large coordinate.
fn states(size: usize, one: usize) -> Vec<DVector<f64>> {
    let of = |k: usize| {
        let mut z = DVector::from_fn(size, |i, _| ((3 * i + 7 * k) as f64 * 0.77 + 0.3).sin());
        z[one] = 1.0;
        z[k % one] *= [1.0, 30.0, -30.0][k % 3];
        z
    };
    (0..6).map(of).collect()
}

/// Largest difference of two states, relative to the largest coordinate or to 1.
fn apart(a: &[f64], b: &DVector<f64>) -> f64 {
    a.iter().zip(b.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / b.amax().max(1.0)
}

#[test]
fn second_method_states_and_functionals_within_a_sub_step() {
    for (table, one) in tables().into_iter().filter(|(table, _)| table.is_dense()) {
        let (a, size, step) = (dense(&table.a), table.a.len(), table.interval());
        let flow = |t: f64| (&a * t).exp();
        let ends: Vec<_> = (0..=INTERVALS).map(|i| flow(i as f64 * step)).collect();
        let part = flow(0.37 * step);
        for z in states(size, one) {
            let (mut rates, mut second, mut ahead, mut heads) = (vec![], vec![], Ahead::default(), vec![]);
            table.look_ahead(z.as_slice(), [&mut rates, &mut second], &mut heads);
            let mut to = z.as_slice().to_vec();
            table.at_end(z.as_slice(), [&rates, &second], &mut to);
            assert!(apart(&to, &(&ends[INTERVALS] * &z)) < ROUNDING, "{size}: end");
            for i in [0, 3, INTERVALS - 1] {
                let from = &ends[i] * &z;
                table.at_interval_start(i, z.as_slice(), &mut to);
                assert!(apart(&to, &from) < ROUNDING, "{size}: interval {i}");
                let exact = &part * &from;
                for all in [true, false] {
                    to.copy_from_slice(from.as_slice());
                    table.within(from.as_slice(), 0.37 * step, all, &mut ahead, &mut to);
                    let known = if all { size } else { one };
                    let off = apart(&to[..known], &exact.rows(0, known).into_owned());
                    assert!(off < ROUNDING * exact.amax().max(1.0), "{size}: {off} within {i}, {all}");
                }
                for (place, w) in table.watched.iter().enumerate() {
                    let c = table.local(place, from.as_slice());
                    let sum = c.iter().rev().fold(0.0, |sum, c| sum * 0.37 + c);
                    let scale = w.row.size(exact.abs().as_slice()).max(1.0) * table.rate.max(1.0);
                    assert!((sum - w.row.dot(exact.as_slice())).abs() < ROUNDING * scale, "{size}: {place}");
                }
            }
            table.look_ahead(z.as_slice(), [&mut rates, &mut second], &mut heads);
            for (place, w) in table.watched.iter().enumerate() {
                let head = head_of(&heads, place);
                let rate = &a * &z;
                let scale = w.row.size(rate.abs().as_slice()).max(1.0) * table.rate.max(1.0);
                assert!((head.value - w.row.dot(z.as_slice())).abs() < ROUNDING * scale);
                assert!(
                    (head.slope - w.row.dot(rate.as_slice())).abs() < ROUNDING * scale,
                    "{size}: {place}"
                );
                let bow = w.row.dot((&a * &rate).as_slice());
                assert!((table.bow(w, z.as_slice()) - bow).abs() < ROUNDING * scale * table.rate.powi(2));
                for (k, sample) in table.samples(place, z.as_slice()).into_iter().enumerate() {
                    let exact = w.row.dot((&ends[k + 1] * &z).as_slice());
                    assert!(
                        (sample - exact).abs() < ROUNDING * scale,
                        "{size}: {place} {k}: {sample} {exact}"
                    );
                }
            }
        }
    }
}

/// A series omits less than 1e-18 of its largest term; spans end at the predicted event.
#[test]
fn second_method_states_functionals_and_nodes_along_a_series() {
    for (table, one) in tables() {
        let a = dense(&table.a);
        for z in states(table.a.len(), one) {
            let mut ahead = Ahead::default();
            ahead.find(&table, z.as_slice(), f64::INFINITY, |_| (0, 0.0));
            assert!(ahead.span > 0.0 && ahead.span * table.rate <= 4.0 * (1.0 + ROUNDING));
            let mut to = z.as_slice().to_vec();
            for part in [0.0, 0.31, 1.0] {
                let exact = (&a * (part * ahead.span)).exp() * &z;
                ahead.series.at(part, &mut to);
                assert!(apart(&to, &exact) < ROUNDING * exact.amax().max(1.0), "{part}");
                for (place, w) in table.watched.iter().enumerate() {
                    let value = ahead.way(&w.row).iter().rev().fold(0.0, |sum, c| sum * part + c);
                    let scale = w.row.size(exact.abs().as_slice()).max(1.0) * table.rate.max(1.0);
                    assert!((value - w.row.dot(exact.as_slice())).abs() < ROUNDING * scale, "{place}");
                }
            }
            let mut nodes = Vec::new();
            ahead.series.at_nodes(&NODES, 0.6, 0, &mut nodes);
            for (node, abscissa) in NODES.iter().enumerate() {
                ahead.series.at(0.6 * abscissa.0, &mut to);
                let there: Vec<f64> = nodes.iter().map(|at| at[node]).collect();
                assert!(apart(&there, &DVector::from_column_slice(&to)) < ROUNDING, "{node}");
            }
        }
    }
}

#[test]
fn invariant_bends_stay_within_their_bounds() {
    // Single coordinates, where no other term hides a bound that is too low, and all together.
    // Each bound is itself at most |row| exp(|A| h) |A|² |z|.
    for (table, one) in tables().into_iter().filter(|(table, _)| table.is_dense()) {
        let (a, size) = (dense(&table.a), table.a.len());
        let single = (0..size).map(|j| DVector::from_fn(size, |i, _| if i == j { 1.0 } else { 0.0 }));
        let all: Vec<_> = single.chain(states(size, one)).collect();
        let flows: Vec<_> =
            (0..=PLACES).map(|k| (&a * (table.length * k as f64 / PLACES as f64)).exp()).collect();
        for z in &all {
            let (mut rates, mut second, mut heads) = (vec![], vec![], vec![]);
            table.look_ahead(z.as_slice(), [&mut rates, &mut second], &mut heads);
            let bow = &a * (&a * z);
            for (place, w) in table.watched.iter().enumerate() {
                let bend = head_of(&heads, place).bend;
                let row = &DVector::from_vec(w.row.dense(size));
                let bound =
                    row.abs().dot(&((a.abs() * table.length).exp() * (a.abs() * (a.abs() * z.abs()))));
                assert!(bend <= bound * (1.0 + ROUNDING) + ROUNDING, "{size}: {bend} of {bound}");
                for (k, flow) in flows.iter().enumerate() {
                    let there = row.dot(&(flow * &bow)).abs();
                    let rounding = ROUNDING * row.amax() * flow.amax() * bow.amax();
                    assert!(there <= bend + rounding, "{size}: {there} beyond {bend} at {k}");
                }
            }
        }
    }
}

#[test]
fn second_method_long_steps_and_their_bounds() {
    for (table, one) in tables() {
        let (a, size) = (dense(&table.a), table.a.len());
        for k in 0..5 {
            let rung = table.rung(k);
            assert_eq!(rung.length, table.long_length(k));
            let end = (&a * rung.length).exp();
            let after = rung.after(&DMatrix::identity(size, size));
            assert!((after - &end).amax() < STIFF_ROUNDING * end.amax(), "{size}: {k}");
            for z in states(size, one) {
                let (mut rates, mut to) = (vec![0.0; size], vec![0.0; size]);
                table.rates(z.as_slice(), &mut rates);
                rung.at_end(z.as_slice(), &rates, &mut to);
                assert!(apart(&to, &(&end * &z)) < STIFF_ROUNDING, "{size}: {k}");
                // A non-integer number of sub-steps.
                let time = 1.3 * rung.length;
                let exact = (&a * time).exp() * &z;
                to.copy_from_slice(z.as_slice());
                table.carry(&mut to, time);
                assert!(apart(&to, &exact) < STIFF_ROUNDING, "{size}: {k}, carried");
            }
            for part in 0..=PLACES {
                let flow = (&a * (rung.length * part as f64 / PLACES as f64)).exp();
                for (place, w) in table.watched.iter().enumerate() {
                    let row = flow.tr_mul(&DVector::from_vec(w.row.dense(size)));
                    for j in 0..size {
                        let unit: Vec<f64> = (0..size).map(|i| if i == j { -1.0 } else { 0.0 }).collect();
                        let bound = rung.bend(place, &unit);
                        assert!(
                            row[j].abs() <= bound * (1.0 + ROUNDING) + ROUNDING,
                            "{size}: {k} {part} {j}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn invariant_the_rate_bounds_the_flow() {
    // No eigenvalue is larger. With balanced weights, the rate of an oscillator of ω and damping δ
    // is at most ω + 2δ.
    for (table, _) in tables() {
        let fastest = dense(&table.a).complex_eigenvalues().iter().map(|x| x.norm()).fold(0.0, f64::max);
        assert!(table.rate >= fastest * (1.0 - ROUNDING), "{} {fastest}", table.rate);
        assert!(table.rate < 8.0 * fastest, "{} {fastest}", table.rate);
    }
    for (stiffness, damping, frequency) in
        [(100.0, 0.0, 0.1), (100.0, 6.0, 0.1), (1.0, 0.0, 7.0), (0.0, 0.0, 3.0)]
    {
        let text = format!(
            "name = \"O\"\n[body.b]\nmass = 1.0\n[spring.k]\nbetween = [\"ground\", \"b\"]\nstiffness = {stiffness}\n\
             damping = {damping}\n[load.l]\non = \"b\"\namplitude = 3.0\nfrequency = {frequency}\n"
        );
        let machine = Arc::new(Assembly::new(parse(&text, "o.toml", &no_records).unwrap()).unwrap());
        let motion = Motion::new(machine.clone()).unwrap();
        let system = machine.system();
        let rate = rate_bound(&system.linear(motion.mode()).a, system.signals.one);
        let omega = f64::sqrt(stiffness);
        let least = omega.max(TAU * frequency);
        // Signals add at most a quarter.
        let most = 1.25 * (omega + damping).max(TAU * frequency) * (1.0 + ROUNDING);
        assert!((least..most).contains(&rate) || rate == least, "{rate}: {least} to {most}");
    }
}

#[test]
fn closed_form_the_order_with_which_a_functional_leaves_zero() {
    // A load grows from zero with force t, so that the first body moves by t³/6; each further body
    // of the chain has two more orders.
    let text = "name = \"D\"\n[body.a]\nmass = 1.0\n[body.b]\nmass = 1.0\n\
                [spring.k]\nbetween = [\"a\", \"b\"]\nstiffness = 1.0\n\
                [stop.a]\nbetween = [\"ground\", \"a\"]\ngap = 0.0\nrestitution = 0.5\n\
                [stop.b]\nbetween = [\"ground\", \"b\"]\ngap = 0.0\nrestitution = 0.5\n\
                [load.l]\non = \"a\"\namplitude = -1.0\nfrequency = 1.0\n";
    let machine = Arc::new(Assembly::new(parse(text, "d.toml", &no_records).unwrap()).unwrap());
    let motion = Motion::new(machine.clone()).unwrap();
    let system = machine.system();
    let (mut mode, one) = (motion.mode().clone(), system.signals.one);
    mode.stops.fill(crate::mode::StopState::Open);
    mode.basis.clear();
    let table = FlowTable::new(system.linear(&mode), one);
    let mut z = DVector::zeros(system.signals.size);
    (z[one], z[one + 1]) = (1.0, 1.0);
    let sizes = z.map(|_| 1.0);
    // In units of the sub-step: ω h³/3! for e of the first stop, ω h⁵/5! for the second.
    let turn = |order: i32| -TAU * table.length.powi(order) / (1..=order).map(f64::from).product::<f64>();
    for (stop, order) in [(0, 3), (1, 5)] {
        let w = table.watched.iter().find(|w| w.watch == Watch::Meets(stop)).unwrap();
        let found = table.departure(w, z.as_slice(), sizes.as_slice(), 1.0, &mut DepartureRows::default());
        let (at, value) = found.unwrap();
        assert_eq!(at, order);
        assert!((value / turn(order as i32) - 1.0).abs() < ROUNDING, "{value} {}", turn(order as i32));
    }
}

#[test]
fn closed_form_signals_add_a_quarter_to_the_rate() {
    // Weight, cosine and sine act on an undamped oscillator. Balanced rows have the sum ω; each of
    // the three signals adds a third of a quarter, whatever its amplitude.
    for (stiffness, amplitude) in [(100.0, 3.0), (2.5e3, 1e-3)] {
        let text = format!(
            "name = \"O\"\ngravity = 9.81\n[body.b]\nmass = 1.0\ngravity = 1.0\n[spring.k]\nbetween = [\"ground\", \"b\"]\n\
             stiffness = {stiffness}\n[load.l]\non = \"b\"\namplitude = {amplitude}\nfrequency = 0.1\nphase = {}\n",
            std::f64::consts::FRAC_PI_4
        );
        let machine = Arc::new(Assembly::new(parse(&text, "o.toml", &no_records).unwrap()).unwrap());
        let motion = Motion::new(machine.clone()).unwrap();
        let system = machine.system();
        let rate = rate_bound(&system.linear(motion.mode()).a, system.signals.one);
        let exact = 1.25 * f64::sqrt(stiffness);
        assert!((rate / exact - 1.0).abs() < ROUNDING, "{rate} {exact}");
    }
}
