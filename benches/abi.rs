//! The C interface in one process. Targets: a step without impact ≤ 0.5 µs; ten Reals read or
//! written ≤ 50 ns; the FMU state saved and restored ≤ 200 ns; an FMI 3.0 step within 10 % of the
//! FMI 2.0 step, as a ratio from alternating runs. `cargo test --test allocation` checks that none
//! of these allocates memory.
#![allow(unsafe_code)] // the C interface

use criterion::{Criterion, criterion_group, criterion_main};
use std::ffi::CString;
use std::hint::black_box;
use std::ptr::{null, null_mut};
use std::time::Instant;
use vibro_paper_component::component::variables::reference;
use vibro_paper_component::fmi2::abi::*;
use vibro_paper_component::fmi2::description;
use vibro_paper_component::fmi3::abi::*;
use vibro_paper_component::fmi3::description as description3;

const OUTPUTS: [&str; 10] = [
    "box.s",
    "box.v",
    "box.a",
    "block.s",
    "block.v",
    "block.a",
    "secondary.s",
    "secondary.v",
    "secondary.a",
    "stop.s",
];

/// Three loads and seven parameters that can be set between steps.
const SETTABLE: [&str; 10] = [
    "box.f",
    "block.f",
    "secondary.f",
    "box.k",
    "box.c",
    "secondary.k",
    "secondary.c",
    "coupling.k",
    "drive.amplitude",
    "drive.frequency",
];

/// Step size of the stepping bench, s: a hundredth of the drive period.
const STEP: f64 = 0.06;

fn initialized() -> FmiComponent {
    let guid = CString::new(description::guid()).expect("no null byte");
    // SAFETY: valid strings, a live component.
    unsafe {
        let c = fmi2Instantiate(c"bench".as_ptr(), 1, guid.as_ptr(), null(), null(), 0, 0);
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), 0);
        assert_eq!(fmi2EnterInitializationMode(c), 0);
        assert_eq!(fmi2ExitInitializationMode(c), 0);
        c
    }
}

fn impacts(c: FmiComponent) -> i32 {
    let (references, mut counts) = ([reference("impacts.upper"), reference("impacts.lower")], [0; 2]);
    // SAFETY: two references and two values.
    assert_eq!(unsafe { fmi2GetInteger(c, references.as_ptr(), 2, counts.as_mut_ptr()) }, 0);
    counts[0] + counts[1]
}

fn benches(criterion: &mut Criterion) {
    let c = initialized();
    // A start from rest has no impact for 100 steps; the state is restored once every hundred
    // steps.
    let (mut start, mut state, mut time) = (null_mut(), null_mut(), 0.0);
    // SAFETY (all below): a live component, arrays with the stated number of elements.
    unsafe {
        assert_eq!(fmi2GetFMUstate(c, &mut start), 0);
        criterion.bench_function("fmi2DoStep of 0.06 s without impact", |b| {
            b.iter(|| {
                if time > 99.0 * STEP {
                    fmi2SetFMUstate(c, start);
                    time = 0.0;
                }
                let status = fmi2DoStep(c, black_box(time), STEP, 1);
                time += STEP;
                status
            })
        });
        assert_eq!(impacts(c), 0);
        assert_eq!(fmi2SetFMUstate(c, start), 0);

        let (outputs, settable) = (OUTPUTS.map(reference), SETTABLE.map(reference));
        let mut values = [0.0; 10];
        criterion.bench_function("fmi2GetReal of ten", |b| {
            b.iter(|| fmi2GetReal(c, black_box(outputs.as_ptr()), 10, values.as_mut_ptr()))
        });
        assert_eq!(fmi2GetReal(c, settable.as_ptr(), 10, values.as_mut_ptr()), 0);
        criterion.bench_function("fmi2SetReal of ten", |b| {
            b.iter(|| fmi2SetReal(c, black_box(settable.as_ptr()), 10, values.as_ptr()))
        });
        criterion.bench_function("fmi2GetFMUstate and fmi2SetFMUstate", |b| {
            b.iter(|| fmi2GetFMUstate(c, black_box(&mut state)) + fmi2SetFMUstate(c, state))
        });
        fmi2FreeInstance(c);
    }
}

/// Benches of FMI 3.0, without and with event mode; target: a step within 10 % of FMI 2.0's.
fn benches_of_fmi3(criterion: &mut Criterion) {
    for (events, name) in [(0, ""), (1, " in event mode")] {
        let c = initialized3(events);
        let (mut start, mut state, mut time) = (null_mut(), null_mut(), 0.0);
        let (mut flags, mut reached) = ([0_u8; 3], 0.0);
        // SAFETY (all below): a live instance, arrays with the stated number of elements.
        unsafe {
            assert_eq!(fmi3GetFMUState(c, &mut start), 0);
            criterion.bench_function(&format!("fmi3DoStep of 0.06 s without impact{name}"), |b| {
                b.iter(|| {
                    if time > 99.0 * STEP {
                        fmi3SetFMUState(c, start);
                        time = 0.0;
                    }
                    let [event, terminate, early] = &mut flags;
                    let status =
                        fmi3DoStep(c, black_box(time), STEP, 1, event, terminate, early, &mut reached);
                    time += STEP;
                    status
                })
            });
            assert_eq!(flags, [0; 3]);
            assert_eq!(fmi3SetFMUState(c, start), 0);
            if events == 0 {
                let (outputs, settable) = (OUTPUTS.map(vr), SETTABLE.map(vr));
                let mut values = [0.0; 10];
                criterion.bench_function("fmi3GetFloat64 of ten", |b| {
                    b.iter(|| fmi3GetFloat64(c, black_box(outputs.as_ptr()), 10, values.as_mut_ptr(), 10))
                });
                assert_eq!(fmi3GetFloat64(c, settable.as_ptr(), 10, values.as_mut_ptr(), 10), 0);
                criterion.bench_function("fmi3SetFloat64 of ten", |b| {
                    b.iter(|| fmi3SetFloat64(c, black_box(settable.as_ptr()), 10, values.as_ptr(), 10))
                });
                criterion.bench_function("fmi3GetFMUState and fmi3SetFMUState", |b| {
                    b.iter(|| fmi3GetFMUState(c, black_box(&mut state)) + fmi3SetFMUState(c, state))
                });
            } else {
                criterion.bench_function("fmi3 Event Mode without an event, the next announced", |b| {
                    b.iter(|| event_mode(c))
                });
            }
            fmi3FreeInstance(c);
        }
    }
}

fn vr(name: &str) -> u32 {
    description3::value_reference(description3::MAIN, name).expect("it is in the table")
}

fn initialized3(events: u8) -> FmiInstance {
    let token = description3::instantiation_token(description3::MAIN);
    let token = CString::new(token).expect("no null byte");
    // SAFETY: valid strings, a live instance.
    unsafe {
        let (none, name) = (null(), c"bench".as_ptr());
        let c = fmi3InstantiateCoSimulation(
            name,
            token.as_ptr(),
            none,
            0,
            0,
            events,
            events,
            null(),
            0,
            null_mut(),
            None,
            None,
        );
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), 0);
        assert_eq!(fmi3ExitInitializationMode(c), 0);
        if events == 1 {
            assert_eq!(fmi3EnterStepMode(c), 0);
        }
        c
    }
}

/// # Safety
/// A live instance in Step Mode.
unsafe fn event_mode(c: FmiInstance) -> i32 {
    let (mut flags, mut next) = ([0_u8; 5], 0.0);
    let [a, b, d, e, f] = &mut flags;
    // SAFETY: guaranteed by the caller; one variable per output argument.
    unsafe {
        fmi3EnterEventMode(c) + fmi3UpdateDiscreteStates(c, a, b, d, e, f, &mut next) + fmi3EnterStepMode(c)
    }
}

/// Time per step, s, over rounds of 99 steps from rest; the state is restored after each round.
fn time_steps(mut step: impl FnMut(f64) -> i32, put_back: impl Fn() -> i32) -> f64 {
    const ROUNDS: usize = 100;
    let begin = Instant::now();
    for _ in 0..ROUNDS {
        for i in 0..99 {
            assert_eq!(step(black_box(f64::from(i) * STEP)), 0);
        }
        assert_eq!(put_back(), 0);
    }
    begin.elapsed().as_secs_f64() / (99 * ROUNDS) as f64
}

/// Ratio of an FMI 3.0 step to an FMI 2.0 step, without and with event mode: the median over
/// alternating runs, so that background load affects all alike.
fn compare_steps(_: &mut Criterion) {
    const TURNS: usize = 301;
    let (c2, c3) = (initialized(), [0, 1].map(initialized3));
    let (mut start2, mut start3) = (null_mut(), [null_mut(); 2]);
    let mut times: [Vec<f64>; 3] = Default::default();
    let (mut flags, mut reached) = ([0_u8; 3], 0.0);
    // SAFETY: live instances, each with its own saved state; one variable per output argument.
    unsafe {
        assert_eq!(fmi2GetFMUstate(c2, &mut start2), 0);
        for (c, start) in c3.iter().zip(&mut start3) {
            assert_eq!(fmi3GetFMUState(*c, start), 0);
        }
        for _ in 0..TURNS {
            times[0].push(time_steps(|time| fmi2DoStep(c2, time, STEP, 1), || fmi2SetFMUstate(c2, start2)));
            for (k, (c, start)) in c3.into_iter().zip(start3).enumerate() {
                let step = |time| {
                    let [event, terminate, early] = &mut flags;
                    fmi3DoStep(c, time, STEP, 1, event, terminate, early, &mut reached)
                };
                times[k + 1].push(time_steps(step, || fmi3SetFMUState(c, start)));
            }
        }
        fmi2FreeInstance(c2);
        c3.into_iter().for_each(|c| fmi3FreeInstance(c));
    }
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    for (name, k) in [("without event mode", 1), ("in event mode", 2)] {
        let mut ratios: Vec<f64> = times[k].iter().zip(&times[0]).map(|(a, b)| a / b).collect();
        println!("a step of FMI 3.0 {name} over one of FMI 2.0: {:.3}", median(&mut ratios));
    }
    println!("a step of FMI 2.0: {:.0} ns", 1e9 * median(&mut times[0]));
}

criterion_group!(abi, compare_steps, benches, benches_of_fmi3);
criterion_main!(abi);
