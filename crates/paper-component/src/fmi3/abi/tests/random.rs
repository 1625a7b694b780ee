//! Random calls with random arguments: no crash, no panic, nothing but finite numbers, and the
//! instance answers afterwards.

use super::*;
use crate::component::variables::{Base, COUNT};
use crate::random::{CALLS, Random};
use std::cell::Cell;

const ROOM: usize = 128;

/// Buffers of a call: as many elements as any variable has, and more than any count that is not
/// refused asks for.
struct Call {
    references: Cell<[u32; 8]>,
    reals: Cell<[f64; ROOM]>,
    results: Cell<[f64; ROOM]>,
    longs: Cell<[i64; ROOM]>,
    orders: Cell<[i32; ROOM]>,
    bytes: Cell<[u8; ROOM]>,
    sizes: Cell<[usize; ROOM]>,
    count: usize,
    values: usize,
    null: [bool; 3],
}

impl Call {
    fn new(random: &mut Random) -> Self {
        let count = match random.below(16) {
            0 => usize::MAX,
            1 => random.next() as usize | 1 << 20, // far too many
            n => n as usize % 9,
        };
        Self {
            references: Cell::new([(); 8].map(|()| match random.below(20) {
                0 => random.next() as u32,
                _ => random.below(COUNT as u64 + 2) as u32,
            })),
            reals: Cell::new([(); ROOM].map(|()| random.number())),
            results: Cell::new([0.0; ROOM]),
            longs: Cell::new([(); ROOM].map(|()| random.next() as i64 >> (random.below(8) * 8))),
            orders: Cell::new([(); ROOM].map(|()| random.below(6) as i32 - 1)),
            bytes: Cell::new([(); ROOM].map(|()| random.next() as u8)),
            sizes: Cell::new([0; ROOM]),
            count,
            values: if random.one_in(8) { random.below(ROOM as u64) as usize } else { count },
            null: [(); 3].map(|()| random.one_in(30)),
        }
    }

    fn vr(&self) -> *const u32 {
        if self.null[0] { null() } else { self.references.as_ptr().cast() }
    }

    fn reals(&self) -> *mut f64 {
        if self.null[1] { null_mut() } else { self.reals.as_ptr().cast() }
    }
}

unsafe fn random_call(
    c: FmiInstance,
    random: &mut Random,
    states: &mut [*mut c_void; 4],
    time: f64,
) -> FmiStatus {
    let call = Call::new(random);
    let (vr, n, m, x) = (call.vr(), call.count, call.values, call.reals());
    let (y, long): (*mut f64, *mut i64) = (call.results.as_ptr().cast(), call.longs.as_ptr().cast());
    let (order, byte): (*mut i32, *mut u8) = (call.orders.as_ptr().cast(), call.bytes.as_ptr().cast());
    let sizes: *mut usize = call.sizes.as_ptr().cast();
    let state = &mut states[random.below(4) as usize];
    let near = if random.one_in(5) { random.number() } else { time };
    let flag = random.next() as u8;
    let mut flags = [7_u8; 6];
    let [a, b, d, e, f, _] = &mut flags;
    unsafe {
        match random.below(60) {
            0 => fmi3SetDebugLogging(c, flag, n, null()),
            1..=3 => fmi3EnterInitializationMode(c, 0, 0.0, random.number().clamp(-1.0, 1.0), 0, 0.0),
            4..=6 => fmi3ExitInitializationMode(c),
            7 if random.one_in(10) => fmi3Terminate(c),
            8 if random.one_in(3) => fmi3Reset(c),
            9..=11 => fmi3GetFloat64(c, vr, n, x, m),
            12 => fmi3GetInt32(c, vr, n, order, m),
            13 => fmi3GetInt64(c, vr, n, long, m),
            14 => fmi3GetBoolean(c, vr, n, byte, m),
            15 => fmi3GetFloat32(c, vr, n, y.cast(), m),
            16 => fmi3GetBinary(c, vr, n, sizes, x.cast(), m),
            17 => fmi3GetClock(c, vr, n, byte),
            18..=21 => fmi3SetFloat64(c, vr, n, x, m),
            22 => fmi3SetInt32(c, vr, n, order, m),
            23 => fmi3SetInt64(c, vr, n, long, m),
            24 => fmi3SetBoolean(c, vr, n, byte, m),
            25 => fmi3SetString(c, vr, n, x.cast(), m),
            26 => fmi3SetClock(c, vr, n, byte),
            27 => fmi3GetFMUState(c, state),
            28 | 29 => fmi3SetFMUState(c, *state),
            30 => fmi3FreeFMUState(c, state),
            31 => {
                let (mut size, mut bytes) = (0, [0_u8; 2048]);
                let status = fmi3SerializedFMUStateSize(c, *state, &mut size);
                if status != OK || size > bytes.len() {
                    return status;
                }
                fmi3SerializeFMUState(c, *state, bytes.as_mut_ptr(), size);
                if random.one_in(3) {
                    bytes[random.below(size as u64) as usize] ^= 1 << random.below(8);
                }
                fmi3DeserializeFMUState(c, bytes.as_ptr(), size, state)
            }
            32 => fmi3GetDirectionalDerivative(c, vr, n, vr, m.min(8), x, m, y, n),
            33 => fmi3GetAdjointDerivative(c, vr, m.min(8), vr, n, x, m.min(8), y, n),
            34 => fmi3GetNumberOfVariableDependencies(c, random.below(COUNT as u64 + 2) as u32, sizes),
            35 => fmi3GetVariableDependencies(
                c,
                *call.references.as_ptr().cast::<u32>(),
                sizes,
                y.cast(),
                sizes,
                order,
                m,
            ),
            36..=38 => fmi3EnterEventMode(c),
            39..=41 => fmi3UpdateDiscreteStates(c, a, b, d, e, f, x),
            42 => fmi3EnterContinuousTimeMode(c),
            43..=45 => fmi3EnterStepMode(c),
            46 => fmi3CompletedIntegratorStep(c, 1, a, b),
            47 => fmi3SetTime(c, near + random.size()),
            48 => fmi3SetContinuousStates(c, x, if random.one_in(3) { n } else { 6 }),
            49 => fmi3GetContinuousStateDerivatives(c, y, 6),
            50 => fmi3GetEventIndicators(c, y, 3),
            51 => fmi3GetContinuousStates(c, y, if random.one_in(3) { n } else { 6 }),
            52 => fmi3GetOutputDerivatives(c, vr, n, order, y, m),
            53 => fmi3EvaluateDiscreteStates(c),
            _ => fmi3DoStep(c, near, random.size(), 1, a, b, d, y),
        }
    }
}

/// No number that can be read is NaN or infinite; reading may be refused, which leaves the instance
/// Terminated.
fn assert_finite(host: &Box3) {
    let variables = description::variables(description::MAIN);
    for (r, variable) in variables.filter(|(_, variable)| variable.base() == Base::Real) {
        let mut values = [0.0; ROOM];
        let status = unsafe { fmi3GetFloat64(host.c, &r, 1, values.as_mut_ptr(), variable.size()) };
        if status == OK {
            assert!(values.iter().all(|value| value.is_finite()), "{}: {values:?}", variable.name);
        } else if status == ERROR {
            return;
        }
    }
}

#[test]
fn random_calls_neither_crash_nor_panic() {
    for seed in 0..12_u64 {
        let interface = if seed % 3 == 0 { Interface::ModelExchange } else { Interface::CoSimulation };
        let (host, mut random) = (Box3::new(interface), Random(seed));
        let mut states = [null_mut(); 4];
        for call in 0..CALLS {
            let mut time = 0.0;
            unsafe {
                fmi3GetFloat64(host.c, &vr("time"), 1, &mut time, 1);
                let status = random_call(host.c, &mut random, &mut states, time);
                assert!((0..4).contains(&status), "status {status}, seed {seed}: {}", host.last());
                if status == ERROR && !random.one_in(4) {
                    // Errors terminate: most of the time a state or a new start leads on.
                    let state = states[random.below(4) as usize];
                    if state.is_null() || fmi3SetFMUState(host.c, state) != OK {
                        assert_eq!(fmi3Reset(host.c), OK, "{}", host.last());
                    }
                }
            }
            if call % 500 == 0 {
                assert_finite(&host);
            }
        }
        unsafe {
            assert_eq!(fmi3Reset(host.c), OK);
            assert_eq!(fmi3EnterInitializationMode(host.c, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi3ExitInitializationMode(host.c), OK);
        }
    }
}
