//! Any calls with any arguments through the C interface of FMI 3.0, in both interface types, with
//! any handling of events, with a callback that makes any calls: no crash, no panic (`fmi3Fatal`),
//! no status outside the standard, nothing written beyond an array, only finite numbers, and an
//! instance that still answers. Saved states continue in an instance of FMI 2.0.
//!
//! `cargo fuzz run --fuzz-dir tests/fuzz -s none abi3 -- -max_total_time=1800` on the stable
//! toolchain; where there is a nightly one,
//! `cargo +nightly fuzz run --fuzz-dir tests/fuzz abi3 -- -max_total_time=1800` looks with
//! AddressSanitizer.

#![no_main]

mod shared;

use arbitrary::Arbitrary;
use libfuzzer_sys::fuzz_target;
use shared::{Buffer, Count, FATAL, GUARD, Number, ROOM, longest, mend, message};
use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};
use std::sync::LazyLock;
use vibro_paper_component::component::variables::{Base, VARIABLES, reference};
use vibro_paper_component::fmi2::abi::{
    fmi2DeSerializeFMUstate, fmi2DoStep, fmi2FreeInstance, fmi2GetReal, fmi2Instantiate, fmi2SetFMUstate,
};
use vibro_paper_component::fmi3::abi::*;
use vibro_paper_component::fmi3::description::{CLOCKED, MAIN, instantiation_token, value_reference, variables};

const OK: c_int = 0;
const ERROR: c_int = 3;
/// Value references are taken modulo this; references beyond the table are bad references.
const REFERENCES: u32 = 96;
const _: () = assert!(VARIABLES.len() < REFERENCES as usize, "more variables than references: double REFERENCES");

static TOKENS: LazyLock<[CString; 2]> =
    LazyLock::new(|| [MAIN, CLOCKED].map(|edition| CString::new(instantiation_token(edition)).expect("no null byte")));
static GUID: LazyLock<CString> =
    LazyLock::new(|| CString::new(vibro_paper_component::fmi2::description::guid()).expect("no null byte"));

#[derive(Arbitrary, Clone, Debug)]
struct Call {
    function: u8,
    references: [u32; 4],
    /// Whether the references are taken as they are, or brought near the table.
    wild: bool,
    numbers: [Number; 6],
    integers: [i32; 2],
    counts: [Count; 2],
    /// One bit for each pointer of the call.
    null: u8,
    slot: u8,
    flag: u8,
}

#[derive(Arbitrary, Debug)]
struct Input {
    exchange: bool,
    clocked: bool,
    logging: bool,
    event_mode: u8,
    early_return: u8,
    callback: bool,
    required: Vec<u8>,
    /// Calls that the callback makes, in turn.
    inside: Vec<Call>,
    calls: Vec<Call>,
    /// Whether errors are not followed by a reset.
    stubborn: bool,
}

/// An instance, the states taken from it, and the calls that its callback is to make.
struct Host {
    c: FmiInstance,
    states: [*mut c_void; 3],
    saved: Vec<u8>,
    inside: Vec<Call>,
    depth: u32,
}

unsafe extern "C-unwind" fn log(_: *mut c_void, status: c_int, category: *const c_char, text: *const c_char) {
    // SAFETY: the FMU passes C strings.
    let text = unsafe { message(status, category, text) };
    assert!(!text.replace("##", "").contains('#'), "{text}");
}

#[allow(clippy::too_many_arguments)]
unsafe extern "C-unwind" fn update(
    environment: *mut c_void,
    time: f64,
    set: u8,
    get: u8,
    finished: u8,
    can_return: u8,
    early: *mut u8,
    early_time: *mut f64,
) {
    assert!(time.is_finite() && set < 2 && get < 2 && finished < 2 && can_return < 2 && set != get);
    // SAFETY: the environment is the host; the FMU's pointers are valid.
    unsafe {
        let host = &mut *environment.cast::<Host>();
        assert_eq!(*early, 0);
        let Some(call) = host.inside.pop() else { return };
        (*early, *early_time) = (call.flag % 2, call.numbers[5].value());
        host.depth += 1;
        let status = host.play(&call);
        host.depth -= 1;
        assert!((0..FATAL).contains(&status), "status {status} of {call:?} inside");
    }
}

impl Host {
    fn real(&self, name: &str) -> f64 {
        let mut value = 0.0;
        // SAFETY: one reference, one value.
        let r = value_reference(CLOCKED, name).unwrap_or_default();
        let status = unsafe { fmi3GetFloat64(self.c, &r, 1, &mut value, 1) };
        if status == OK { value } else { 0.0 }
    }

    /// Longest step of an iteration, s.
    fn longest(&self) -> f64 {
        longest(|name| self.real(name))
    }

    /// # Safety
    /// The instance is live.
    unsafe fn play(&mut self, call: &Call) -> c_int {
        let c = self.c;
        let inside = |r: &u32| if call.wild { *r } else { r % REFERENCES };
        let references: Vec<u32> = call.references.iter().map(inside).collect();
        let numbers = call.numbers.map(Number::value);
        let mut vr = Buffer::new(&references, GUARD as u32);
        let (mut reals, mut results) = (Buffer::new(&numbers, f64::from_bits(GUARD)), Buffer::new(&[0.0], f64::from_bits(GUARD)));
        let (mut ints, mut longs) = (Buffer::new(&call.integers, GUARD as i32), Buffer::new(&call.integers.map(i64::from), GUARD as i64));
        let (mut bytes, mut sizes) = (Buffer::new(&[call.flag, 0, 1], GUARD as u8), Buffer::new(&[0_usize], GUARD as usize));
        let mut flags = Buffer::new(&[7_u8], GUARD as u8);
        let [n, m] = call.counts.map(Count::value);
        let absent = |bit: u8| call.null & call.null >> 1 & 1 << bit != 0;
        let (r, x, y) = (vr.pointer(absent(0)), reals.pointer(absent(1)), results.pointer(absent(2)));
        let (i, l, b, s, f) = (ints.pointer(absent(3)), longs.pointer(absent(3)), bytes.pointer(absent(4)), sizes.pointer(absent(5)), flags.0.as_mut_ptr());
        // The time must not be read inside the callback.
        let (time, longest) = if self.depth == 0 { (self.real("time"), self.longest()) } else { (0.0, 1.0) };
        let place = &mut self.states[usize::from(call.slot) % 3];
        // SAFETY: buffers of as many elements as are accepted; states are this instance's or
        // refused.
        let status = unsafe {
            match call.function % 72 {
                0 => fmi3SetDebugLogging(c, call.flag, n.min(1), null()),
                1 | 2 => fmi3EnterInitializationMode(c, call.flag & 1, numbers[0], numbers[1], call.flag & 2, numbers[2]),
                3 | 4 => fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0),
                5..=7 => fmi3ExitInitializationMode(c),
                8 => fmi3Terminate(c),
                9 => fmi3Reset(c),
                10 => fmi3GetFloat32(c, r, n, y.cast(), m),
                11..=13 => fmi3GetFloat64(c, r, n, y, m),
                14 => fmi3GetInt32(c, r, n, i, m),
                15 => fmi3GetInt64(c, r, n, l, m),
                16 => fmi3GetBoolean(c, r, n, b, m),
                17 => fmi3GetClock(c, r, n, b),
                18 => fmi3GetBinary(c, r, n, s, y.cast(), m),
                19 => fmi3GetString(c, r, n, y.cast(), m),
                20..=23 => fmi3SetFloat64(c, r, n, x, m),
                24 => fmi3SetInt32(c, r, n, i, m),
                25 => fmi3SetInt64(c, r, n, l, m),
                26 => fmi3SetBoolean(c, r, n, b, m),
                27 => fmi3SetClock(c, r, n, b),
                28 => fmi3SetUInt8(c, r, n, b, m),
                29 => fmi3GetNumberOfVariableDependencies(c, references[0], s),
                30 => fmi3GetVariableDependencies(c, references[0], s, r, s, i, m),
                31 | 32 => fmi3GetFMUState(c, place),
                33..=35 => fmi3SetFMUState(c, *place),
                36 => fmi3FreeFMUState(c, place),
                37 => fmi3SetFMUState(c, std::ptr::without_provenance_mut(call.integers[0] as usize)),
                38 | 39 => {
                    let mut size = 0;
                    let status = fmi3SerializedFMUStateSize(c, *place, &mut size);
                    if status != OK {
                        return status;
                    }
                    self.saved = vec![0; size];
                    fmi3SerializeFMUState(c, *place, self.saved.as_mut_ptr(), size)
                }
                40 | 41 => {
                    if call.flag & 1 != 0 && !self.saved.is_empty() {
                        let at = call.integers[0] as usize % self.saved.len();
                        self.saved[at] ^= call.flag;
                        mend(&mut self.saved);
                    }
                    fmi3DeserializeFMUState(c, self.saved.as_ptr(), self.saved.len(), place)
                }
                42 => fmi3GetDirectionalDerivative(c, r, n, r, m, x, m, y, n),
                43 => fmi3GetAdjointDerivative(c, r, n, r, m, x, n, y, m),
                44..=46 => fmi3EnterEventMode(c),
                47..=49 => fmi3UpdateDiscreteStates(c, f, f.add(1), f.add(2), f.add(3), f.add(4), y),
                50 | 51 => fmi3EnterContinuousTimeMode(c),
                52..=54 => fmi3EnterStepMode(c),
                55 => fmi3CompletedIntegratorStep(c, call.flag, f, f.add(1)),
                56 => fmi3SetTime(c, if call.wild { numbers[0] } else { time + numbers[0].clamp(0.0, 1.0) }),
                57 => fmi3SetContinuousStates(c, x, n),
                58 => fmi3GetContinuousStateDerivatives(c, y, n),
                59 => fmi3GetEventIndicators(c, y, n),
                60 => fmi3GetContinuousStates(c, y, n),
                61 => fmi3GetNominalsOfContinuousStates(c, y, n),
                62 => fmi3GetNumberOfEventIndicators(c, s) | fmi3GetNumberOfContinuousStates(c, s),
                63 => fmi3GetOutputDerivatives(c, r, n, i, y, m),
                64 => fmi3EvaluateDiscreteStates(c) | fmi3EnterConfigurationMode(c) | fmi3ExitConfigurationMode(c),
                65 => fmi3GetIntervalDecimal(c, r, n, y, i) | fmi3ActivateModelPartition(c, references[0], numbers[0]),
                _ => {
                    let point = if call.wild { numbers[0] } else { time };
                    fmi3DoStep(c, point, numbers[1].min(longest), call.flag, f, f.add(1), f.add(2), y)
                }
            }
        };
        assert_eq!(reals.0[ROOM].to_bits(), GUARD);
        assert_eq!(results.0[ROOM].to_bits(), GUARD);
        assert_eq!((ints.0[ROOM], longs.0[ROOM]), (GUARD as i32, GUARD as i64));
        assert_eq!((bytes.0[ROOM], flags.0[ROOM], sizes.0[ROOM]), (GUARD as u8, GUARD as u8, GUARD as usize));
        status
    }

    /// All numbers of the motion are finite.
    fn assert_finite(&self) {
        for (r, variable) in variables(CLOCKED) {
            let mut values = [0.0; 128];
            if variable.base() != Base::Real {
                continue;
            }
            // SAFETY: enough values for any variable.
            let status = unsafe { fmi3GetFloat64(self.c, &r, 1, values.as_mut_ptr(), variable.size()) };
            if status == OK {
                assert!(values.iter().all(|value| value.is_finite()), "{}: {values:?}", variable.name);
            } else if status == ERROR {
                return; // of another description, and now Terminated
            }
        }
    }
}

/// A state of FMI 3.0 continues in FMI 2.0, or is refused.
unsafe fn go_on_in_fmi2(saved: &[u8]) {
    // SAFETY: valid strings; the component is freed once.
    unsafe {
        let c = fmi2Instantiate(c"two".as_ptr(), 1, GUID.as_ptr(), null(), null(), 0, 0);
        let (mut state, mut time) = (null_mut(), 0.0);
        if fmi2DeSerializeFMUstate(c, saved.as_ptr(), saved.len(), &mut state) == OK && fmi2SetFMUstate(c, state) == OK {
            fmi2GetReal(c, &reference("time"), 1, &mut time);
            assert!((0..FATAL).contains(&fmi2DoStep(c, time, 1e-3, 1)));
        }
        fmi2FreeInstance(c);
    }
}

fuzz_target!(|input: Input| {
    let mut host = Box::new(Host {
        c: null_mut(),
        states: [null_mut(); 3],
        saved: Vec::new(),
        inside: input.inside.iter().take(32).cloned().collect(),
        depth: 0,
    });
    let environment: *mut c_void = std::ptr::from_mut(&mut *host).cast();
    let token = TOKENS[usize::from(input.clocked)].as_ptr();
    let required: Vec<u32> = input.required.iter().take(4).map(|r| u32::from(*r) % (VARIABLES.len() as u32) + 1).collect();
    let (name, none) = (c"fuzz".as_ptr(), null());
    // SAFETY: valid strings and callbacks; the instance is used until it is freed, once.
    unsafe {
        let logger: Option<FmiLogMessage> = if input.logging { Some(log) } else { None };
        let c = if input.exchange {
            fmi3InstantiateModelExchange(name, token, none, 0, 1, environment, logger)
        } else {
            let callback: Option<FmiIntermediateUpdate> = if input.callback { Some(update) } else { None };
            let (events, early) = (input.event_mode, input.early_return);
            fmi3InstantiateCoSimulation(
                name, token, none, 0, 1, events, early, required.as_ptr(), required.len(), environment, logger, callback,
            )
        };
        if c.is_null() {
            return; // a variable of the other description was required
        }
        host.c = c;
        for call in input.calls.iter().take(64) {
            let status = host.play(call);
            assert!((0..FATAL).contains(&status), "status {status} of {call:?}");
            if status == ERROR && !input.stubborn {
                let state = host.states[usize::from(call.slot) % 3];
                if state.is_null() || fmi3SetFMUState(c, state) != OK {
                    assert_eq!(fmi3Reset(c), OK);
                }
            }
        }
        host.assert_finite();
        go_on_in_fmi2(&host.saved);
        assert_eq!(fmi3Reset(c), OK);
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(c), OK);
        fmi3FreeInstance(c);
    }
});
