//! Random calls with random arguments: no crash, no panic, and the instance answers afterwards.

use super::*;
use crate::component::variables::COUNT;
use crate::random::{CALLS, Random};
use std::cell::Cell;

/// Buffers of a call: eight elements each, as many as `count` says at most.
struct Call {
    references: Cell<[u32; 8]>,
    reals: Cell<[f64; 8]>,
    results: Cell<[f64; 8]>,
    integers: Cell<[c_int; 8]>,
    count: usize,
    null: [bool; 3],
}

impl Call {
    fn new(random: &mut Random) -> Self {
        let references = [(); 8].map(|()| match random.below(20) {
            0 => random.next() as u32,
            _ => random.below(COUNT as u64 + 1) as u32,
        });
        let count = match random.below(12) {
            0 => usize::MAX,
            1 => random.next() as usize | 1 << 20, // far too many
            n => n as usize % 9,
        };
        Self {
            references: Cell::new(references),
            reals: Cell::new([(); 8].map(|()| random.number())),
            results: Cell::new([0.0; 8]),
            integers: Cell::new([(); 8].map(|()| random.integer())),
            count,
            null: [(); 3].map(|()| random.one_in(25)),
        }
    }

    fn vr(&self) -> *const u32 {
        if self.null[0] { null() } else { self.references.as_ptr().cast() }
    }

    fn reals(&self) -> *mut f64 {
        if self.null[1] { null_mut() } else { self.reals.as_ptr().cast() }
    }

    fn integers(&self) -> *mut c_int {
        if self.null[2] { null_mut() } else { self.integers.as_ptr().cast() }
    }
}

unsafe fn random_call(
    host: &Host,
    random: &mut Random,
    states: &mut [*mut c_void; 4],
    time: f64,
) -> FmiStatus {
    let c = host.c;
    let call = Call::new(random);
    let (vr, count) = (call.vr(), call.count);
    let (reals, integers) = (call.reals(), call.integers());
    let state = &mut states[random.below(4) as usize];
    let near = if random.one_in(5) { random.number() } else { time };
    let mut bytes = [0_u8; 1024];
    unsafe {
        match random.below(48) {
            0 => fmi2SetDebugLogging(c, random.integer(), count, null()),
            1 => fmi2SetupExperiment(c, 0, 0.0, random.number().clamp(-1.0, 1.0), 0, 0.0),
            2 | 3 => fmi2EnterInitializationMode(c),
            4 | 5 => fmi2ExitInitializationMode(c),
            6 if random.one_in(10) => fmi2Terminate(c),
            7 if random.one_in(5) => fmi2Reset(c),
            8..=10 => fmi2GetReal(c, vr, count, reals),
            11 => fmi2GetInteger(c, vr, count, integers),
            12 => fmi2GetBoolean(c, vr, count, integers),
            13 => fmi2GetString(c, vr, 0, null_mut()),
            14..=16 => fmi2SetReal(c, vr, count, reals),
            17 => fmi2SetInteger(c, vr, count, integers),
            18 => fmi2SetBoolean(c, vr, count, integers),
            19 => fmi2GetFMUstate(c, state),
            20 => fmi2SetFMUstate(c, *state),
            21 => fmi2FreeFMUstate(c, state),
            22 => fmi2SetFMUstate(c, std::ptr::without_provenance_mut(random.next() as usize)),
            23 => {
                let mut size = 0;
                let status = fmi2SerializedFMUstateSize(c, *state, &mut size);
                if status != OK || size > bytes.len() {
                    return status;
                }
                fmi2SerializeFMUstate(c, *state, bytes.as_mut_ptr(), size);
                if random.one_in(3) {
                    bytes[random.below(size as u64) as usize] ^= 1 << random.below(8);
                }
                fmi2DeSerializeFMUstate(c, bytes.as_ptr(), size, state)
            }
            24 => fmi2DeSerializeFMUstate(c, bytes.as_ptr(), random.below(1024) as usize, state),
            25 => fmi2GetDirectionalDerivative(c, vr, count, vr, 2, reals, call.results.as_ptr().cast()),
            26 => fmi2GetDirectionalDerivative(c, vr, 2, vr, 1, [1.0].as_ptr(), [0.0; 2].as_mut_ptr()),
            27 => fmi2EnterEventMode(c),
            28 => fmi2NewDiscreteStates(c, &mut FmiEventInfo::default()),
            29 => fmi2EnterContinuousTimeMode(c),
            30 => fmi2CompletedIntegratorStep(c, 1, integers, integers),
            31 => fmi2SetTime(c, near + random.size()),
            32 => fmi2SetContinuousStates(c, reals, if random.one_in(3) { count } else { 6 }),
            33 => fmi2GetDerivatives(c, reals, if random.one_in(3) { count } else { 6 }),
            34 => fmi2GetEventIndicators(c, reals, 3),
            35 => fmi2GetContinuousStates(c, reals, 6),
            36 => fmi2GetNominalsOfContinuousStates(c, reals, 6),
            37 => fmi2SetRealInputDerivatives(c, vr, count, integers, reals),
            38 => fmi2GetRealOutputDerivatives(c, vr, count, integers, reals),
            39 => fmi2CancelStep(c),
            40 => fmi2GetStatus(c, random.integer(), integers),
            41 => fmi2GetRealStatus(c, random.integer(), reals),
            42 => fmi2GetBooleanStatus(c, random.integer(), integers),
            43 => fmi2GetStringStatus(c, random.integer(), &mut null()),
            _ => fmi2DoStep(c, near, random.size(), random.integer()),
        }
    }
}

#[test]
fn random_calls_neither_crash_nor_panic() {
    for seed in 0..12_u64 {
        let interface = if seed % 2 == 0 { Interface::CoSimulation } else { Interface::ModelExchange };
        let (host, mut random) = (Host::new(interface), Random(seed));
        let mut states = [null_mut(); 4];
        for _ in 0..CALLS {
            let mut time = 0.0;
            unsafe {
                fmi2GetReal(host.c, &reference("time"), 1, &mut time);
                let status = random_call(&host, &mut random, &mut states, time);
                assert!((0..4).contains(&status), "status {status}, seed {seed}: {}", host.last());
            }
        }
        unsafe {
            assert_eq!(fmi2Reset(host.c), OK);
            assert_eq!(fmi2SetupExperiment(host.c, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi2EnterInitializationMode(host.c), OK);
            assert_eq!(fmi2ExitInitializationMode(host.c), OK);
        }
    }
}

#[test]
fn instances_live_side_by_side_in_threads() {
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                for _ in 0..25 {
                    let host = Host::initialized();
                    assert_eq!(unsafe { fmi2DoStep(host.c, 0.0, 50.0, 1) }, OK);
                    assert_eq!(host.get("time"), 50.0);
                }
            });
        }
    });
}
