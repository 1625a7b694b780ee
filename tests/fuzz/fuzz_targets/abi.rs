//! Any calls with any arguments through the C interface: no crash, no panic (`fmi2Fatal`), no
//! status the standard does not have, nothing written beyond an array, and an instance that still
//! answers.
//!
//! `cargo fuzz run --fuzz-dir tests/fuzz -s none abi -- -max_total_time=1800` on the stable
//! toolchain; where there is a nightly one,
//! `cargo +nightly fuzz run --fuzz-dir tests/fuzz abi -- -max_total_time=1800` looks with
//! AddressSanitizer.

#![no_main]

mod shared;

use arbitrary::Arbitrary;
use libfuzzer_sys::fuzz_target;
use shared::{Buffer, Count, FATAL, GUARD, Number, ROOM, longest, mend, message};
use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};
use std::sync::LazyLock;
use vibro_paper_component::fmi2::abi::*;
use vibro_paper_component::fmi2::description;
use vibro_paper_component::fmi2::types::FmiEventInfo;
use vibro_paper_component::component::variables::{VARIABLES, reference};

/// Value references are taken modulo this, so that a new variable does not change the meaning of
/// the kept inputs; references beyond the table are bad references.
const REFERENCES: u32 = 96;
const _: () = {
    let mut i = 0;
    while i < VARIABLES.len() {
        assert!(VARIABLES[i].reference < REFERENCES, "more references than REFERENCES: double it");
        i += 1;
    }
};

static GUID: LazyLock<CString> = LazyLock::new(|| CString::new(description::guid()).expect("no null byte"));

#[derive(Arbitrary, Debug)]
struct Call {
    function: u8,
    references: [u32; 4],
    /// Whether the references are taken as they are, or brought near the table.
    wild: bool,
    numbers: [Number; 6],
    integers: [i32; 2],
    count: Count,
    /// One bit for each pointer of the call.
    null: u8,
    slot: u8,
    text: Vec<u8>,
}

#[derive(Arbitrary, Debug)]
struct Input {
    kind: Option<bool>,
    logging: bool,
    calls: Vec<Call>,
}

unsafe extern "C" fn log(_: *mut c_void, _: *const c_char, status: c_int, category: *const c_char, text: *const c_char) {
    // SAFETY: the FMU passes C strings.
    let text = unsafe { message(status, category, text) };
    assert!(!text.replace("%%", "").contains('%'), "{text}");
}

type Plain = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char);

/// An instance and the states taken from it.
struct Host {
    c: FmiComponent,
    states: [*mut c_void; 3],
    saved: Vec<u8>,
}

impl Host {
    fn real(&self, name: &str) -> f64 {
        let mut value = 0.0;
        // SAFETY: one reference, one value.
        let status = unsafe { fmi2GetReal(self.c, &reference(name), 1, &mut value) };
        if status == 0 { value } else { 0.0 }
    }

    /// Longest step of an iteration, s.
    fn longest(&self) -> f64 {
        longest(|name| self.real(name))
    }

    /// # Safety
    /// The component is live.
    unsafe fn play(&mut self, call: &Call) -> c_int {
        let c = self.c;
        let inside = |r: &u32| if call.wild { *r } else { r % REFERENCES };
        let references: Vec<u32> = call.references.iter().map(inside).collect();
        let numbers = call.numbers.map(Number::value);
        let mut vr = Buffer::new(&references, GUARD as u32);
        let mut reals = Buffer::new(&numbers, f64::from_bits(GUARD));
        let mut results = Buffer::new(&numbers, f64::from_bits(GUARD));
        let mut integers = Buffer::new(&call.integers, GUARD as i32);
        let mut others = Buffer::new(&call.integers, GUARD as i32);
        let mut bytes = Buffer::new(&[0_u8], GUARD as u8);
        let mut strings = Buffer::new(&[c"".as_ptr()], null());
        let absent = |bit: u8| call.null & (1 << bit) != 0 && call.null & 0x80 != 0;
        let (n, count) = (vr.pointer(absent(0)), call.count.value());
        let (x, y) = (reals.pointer(absent(1)), results.pointer(absent(2)));
        let (i, j) = (integers.pointer(absent(3)), others.pointer(absent(4)));
        let (b, s) = (bytes.pointer(absent(5)), strings.pointer(absent(6)));
        let time = self.real("time");
        let longest = self.longest();
        let state = &mut self.states[usize::from(call.slot) % 3];
        let place = if absent(0) { null_mut() } else { &raw mut *state };
        let known = *state;
        // SAFETY: every pointer is null or to a buffer of as many elements as are not refused.
        let status = unsafe {
            match call.function % 45 {
                0 => fmi2SetDebugLogging(c, call.integers[0], count, s),
                1 => {
                    let text = CString::new(call.text.iter().copied().filter(|b| *b != 0).collect::<Vec<_>>());
                    fmi2SetDebugLogging(c, 1, 1, &text.expect("filtered").as_ptr())
                }
                2 => fmi2SetupExperiment(c, call.integers[0], numbers[0], numbers[1], call.integers[1], numbers[2]),
                3 => fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
                4 => fmi2EnterInitializationMode(c),
                5 => fmi2ExitInitializationMode(c),
                6 => fmi2Terminate(c),
                7 => fmi2Reset(c),
                8 => fmi2GetReal(c, n, count, x),
                9 => fmi2GetInteger(c, n, count, i),
                10 => fmi2GetBoolean(c, n, count, i),
                11 => fmi2GetString(c, n, count, s),
                12 | 13 => fmi2SetReal(c, n, count, x),
                14 => fmi2SetInteger(c, n, count, i),
                15 => fmi2SetBoolean(c, n, count, i),
                16 => fmi2SetString(c, n, count, s),
                17 => fmi2GetFMUstate(c, place),
                18 => fmi2SetFMUstate(c, known),
                19 => fmi2SetFMUstate(c, std::ptr::without_provenance_mut(call.count.value())),
                20 => fmi2FreeFMUstate(c, place),
                21 => {
                    let mut size = 0;
                    let status = fmi2SerializedFMUstateSize(c, known, if absent(0) { null_mut() } else { &mut size });
                    if status == 0 {
                        assert!(size <= ROOM);
                        let status = fmi2SerializeFMUstate(c, known, b, size);
                        if status == 0 {
                            self.saved = bytes.0[..size].to_vec();
                        }
                    }
                    status
                }
                22 => fmi2SerializeFMUstate(c, known, b, count),
                23 => {
                    let mut bytes = self.saved.clone();
                    for pair in call.text.chunks_exact(2) {
                        let place = usize::from(pair[0]) * 7 % bytes.len().max(1);
                        if let Some(byte) = bytes.get_mut(place) {
                            *byte ^= pair[1];
                        }
                    }
                    if call.wild {
                        mend(&mut bytes);
                    }
                    fmi2DeSerializeFMUstate(c, bytes.as_ptr(), bytes.len(), place)
                }
                24 => fmi2DeSerializeFMUstate(c, call.text.as_ptr(), call.text.len(), place),
                25 => fmi2GetDirectionalDerivative(c, n, count, vr.0.as_ptr(), call.integers[0] as usize % 4, x, y),
                26 => fmi2GetDirectionalDerivative(c, n, 1, vr.0.as_ptr().add(1), 1, x, y),
                27 => fmi2EnterEventMode(c),
                28 => fmi2NewDiscreteStates(c, if absent(0) { null_mut() } else { &mut FmiEventInfo::default() }),
                29 => fmi2EnterContinuousTimeMode(c),
                30 => fmi2CompletedIntegratorStep(c, call.integers[0], i, j),
                31 => fmi2SetTime(c, if call.wild { numbers[0] } else { time + numbers[0].clamp(0.0, 1.0) }),
                32 => fmi2SetContinuousStates(c, x, count),
                33 => fmi2GetDerivatives(c, x, count),
                34 => fmi2GetEventIndicators(c, x, count),
                35 => fmi2GetContinuousStates(c, x, count),
                36 => fmi2GetNominalsOfContinuousStates(c, x, count),
                37 => fmi2SetRealInputDerivatives(c, n, count, i, x),
                38 => fmi2GetRealOutputDerivatives(c, n, count, i, x),
                39 => fmi2CancelStep(c),
                40 => fmi2GetStatus(c, call.integers[0], i),
                41 => fmi2GetRealStatus(c, call.integers[0], x),
                42 => fmi2GetIntegerStatus(c, call.integers[0], i) | fmi2GetStringStatus(c, call.integers[0], s),
                43 => fmi2GetBooleanStatus(c, call.integers[0], i),
                _ => {
                    let point = if call.wild { numbers[0] } else { time };
                    fmi2DoStep(c, point, numbers[1].min(longest), call.integers[0])
                }
            }
        };
        assert_eq!(reals.0[ROOM].to_bits(), GUARD);
        assert_eq!(results.0[ROOM].to_bits(), GUARD);
        assert_eq!((integers.0[ROOM], others.0[ROOM]), (GUARD as i32, GUARD as i32));
        assert_eq!((bytes.0[ROOM], strings.0[ROOM]), (GUARD as u8, null()));
        status
    }
}

fuzz_target!(|input: Input| {
    // SAFETY: on the platforms of the fuzzer a variadic call without variadic arguments is an
    // ordinary one.
    let logger = unsafe { std::mem::transmute::<Plain, FmiLogger>(log) };
    let functions = FmiCallbackFunctions {
        logger: Some(logger),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: null_mut(),
    };
    let functions = if input.logging { &raw const functions } else { null() };
    let kind = input.kind.map_or(2, c_int::from);
    // SAFETY: valid strings and callbacks; the component is used until it is freed, once.
    unsafe {
        let c = fmi2Instantiate(c"fuzz".as_ptr(), kind, GUID.as_ptr(), null(), functions, 0, 1);
        assert_eq!(c.is_null(), kind == 2);
        let mut host = Host { c, states: [null_mut(); 3], saved: Vec::new() };
        for call in input.calls.iter().take(64) {
            let status = host.play(call);
            assert!((0..FATAL).contains(&status), "status {status} of {call:?}");
        }
        if !c.is_null() {
            assert_eq!(fmi2Reset(c), 0);
            assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), 0);
            assert_eq!(fmi2EnterInitializationMode(c), 0);
            assert_eq!(fmi2ExitInitializationMode(c), 0);
        }
        fmi2FreeInstance(c);
    }
});
