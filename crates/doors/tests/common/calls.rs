//! Random calls with random arguments on a component, through FMI 2.0 and FMI 3.0. Nothing may
//! crash or panic, and the instance must still answer afterwards. A seed or the bytes of a fuzzer
//! choose the calls. The component under test is the sibling module `component`.

use super::component::*;
use fmi_doors::fmi2::abi::FmiComponent;
use fmi_doors::fmi2::types::FmiEventInfo;
use fmi_doors::fmi3::abi::FmiInstance;
use std::ffi::{CString, c_int, c_void};
use std::ptr::{null, null_mut};

const OK: c_int = 0;

/// Arguments that make an instance.
pub struct Target {
    /// The token of its description.
    pub token: CString,
    /// Path of its resources; `None` if it has none.
    pub resources: Option<CString>,
    /// Value references are drawn below this.
    pub references: u64,
    /// Input that the FMU requests within steps of FMI 3.0. The host's callback sets it, and also
    /// reads variables.
    pub input: Option<u32>,
}

/// Source of choices: bytes while there are any, then SplitMix64.
pub struct Random<'a> {
    pub bytes: &'a [u8],
    pub seed: u64,
}

impl Random<'_> {
    pub fn below(&mut self, limit: u64) -> u64 {
        if let Some((first, rest)) = self.bytes.split_first_chunk() {
            self.bytes = rest;
            return u64::from(u16::from_le_bytes(*first)) % limit;
        }
        self.seed = self.seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.seed ^ (self.seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % limit
    }

    fn number(&mut self) -> f64 {
        match self.below(10) {
            0 => f64::from_bits(self.below(u64::MAX)),
            1 => f64::NAN,
            2 => f64::INFINITY,
            3 => -1.0,
            4 => 1e300,
            _ => self.below(1000) as f64 / 500.0,
        }
    }

    /// A number of elements: at most eight, or far too many.
    fn count(&mut self) -> usize {
        if self.below(12) == 0 { usize::MAX } else { self.below(9) as usize }
    }
}

/// Buffers of a call, with eight elements each.
struct Call {
    references: [u32; 8],
    reals: [f64; 8],
    integers: [c_int; 8],
    flags: [u8; 8],
    count: usize,
}

impl Call {
    fn new(random: &mut Random<'_>, references: u64) -> Self {
        Self {
            references: [(); 8].map(|()| random.below(references) as u32),
            reals: [(); 8].map(|()| random.number()),
            integers: [(); 8].map(|()| random.below(5) as c_int),
            flags: [0; 8],
            count: random.count(),
        }
    }
}

unsafe fn call_fmi2(
    c: FmiComponent,
    random: &mut Random<'_>,
    references: u64,
    states: &mut [*mut c_void; 2],
    time: f64,
) -> c_int {
    let mut call = Call::new(random, references);
    let (vr, n) = (call.references.as_ptr(), call.count);
    let (x, i) = (call.reals.as_mut_ptr(), call.integers.as_mut_ptr());
    let state = &mut states[random.below(2) as usize];
    unsafe {
        match random.below(26) {
            0 => fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
            1 => fmi2EnterInitializationMode(c),
            2 => fmi2ExitInitializationMode(c),
            3 if random.below(10) == 0 => fmi2Terminate(c),
            4 if random.below(5) == 0 => fmi2Reset(c),
            5 => fmi2GetReal(c, vr, n, x),
            6 => fmi2GetInteger(c, vr, n, i),
            7 => fmi2GetBoolean(c, vr, n, i),
            8 | 9 => fmi2SetReal(c, vr, n, x),
            10 => fmi2SetInteger(c, vr, n, i),
            11 => fmi2GetFMUstate(c, state),
            12 => fmi2SetFMUstate(c, *state),
            13 => fmi2FreeFMUstate(c, state),
            14 => {
                let mut size = 0;
                let status = fmi2SerializedFMUstateSize(c, *state, &mut size);
                if status != OK {
                    return status;
                }
                let mut bytes = vec![0; size];
                fmi2SerializeFMUstate(c, *state, bytes.as_mut_ptr(), size);
                bytes[random.below(size as u64) as usize] ^= 1 << random.below(8);
                fmi2DeSerializeFMUstate(c, bytes.as_ptr(), size, state)
            }
            15 => fmi2GetDirectionalDerivative(c, vr, n, vr, 1, x, [0.0; 8].as_mut_ptr()),
            16 => fmi2EnterEventMode(c),
            17 => fmi2NewDiscreteStates(c, &mut FmiEventInfo::default()),
            18 => fmi2EnterContinuousTimeMode(c),
            19 => fmi2CompletedIntegratorStep(c, 1, i, i.add(1)),
            20 => fmi2SetTime(c, random.number()),
            21 => fmi2SetContinuousStates(c, x, n),
            22 => fmi2GetDerivatives(c, x, n.min(8)),
            23 => fmi2GetEventIndicators(c, x, 1),
            24 => fmi2SetRealInputDerivatives(c, vr, n, i, x),
            _ => fmi2DoStep(c, time, random.number().clamp(-1.0, 1.0), 1),
        }
    }
}

/// Further functions, and null pointers. Not chosen by a fuzzer's bytes: additional calls would
/// change the meaning of stored fuzzer inputs.
unsafe fn further_fmi2(c: FmiComponent, random: &mut Random<'_>, references: u64) -> c_int {
    let mut call = Call::new(random, references);
    let absent = random.below(8);
    let vr = if absent == 0 { null() } else { call.references.as_ptr() };
    let x = if absent == 1 { null_mut() } else { call.reals.as_mut_ptr() };
    let i = if absent == 2 { null_mut() } else { call.integers.as_mut_ptr() };
    let (n, kind) = (call.count, random.below(5) as c_int);
    let wild = random.below(u64::MAX) as usize;
    unsafe {
        match random.below(14) {
            0 => fmi2SetDebugLogging(c, kind, n, null()),
            1 => fmi2GetString(c, vr, n, null_mut()),
            2 => fmi2SetBoolean(c, vr, n, i),
            3 => fmi2SetFMUstate(c, std::ptr::without_provenance_mut(wild)),
            4 => fmi2DeSerializeFMUstate(c, x.cast(), 8 * call.reals.len(), &mut null_mut()),
            5 => fmi2GetNominalsOfContinuousStates(c, x, n),
            6 => fmi2GetRealOutputDerivatives(c, vr, n, i, x),
            7 => fmi2CancelStep(c),
            8 => fmi2GetStatus(c, kind, i),
            9 => fmi2GetRealStatus(c, kind, x),
            10 => fmi2GetBooleanStatus(c, kind, i),
            11 => fmi2GetStringStatus(c, kind, &mut null()),
            12 => fmi2GetReal(c, vr, n, x),
            _ => fmi2SetReal(c, vr, n, x),
        }
    }
}

/// Like [`further_fmi2`].
unsafe fn further_fmi3(c: FmiInstance, random: &mut Random<'_>, references: u64) -> c_int {
    let mut call = Call::new(random, references);
    let absent = random.below(8);
    let vr = if absent == 0 { null() } else { call.references.as_ptr() };
    let x = if absent == 1 { null_mut() } else { call.reals.as_mut_ptr() };
    let b = if absent == 2 { null_mut() } else { call.flags.as_mut_ptr() };
    let (n, m) = (call.count, if random.below(8) == 0 { call.count } else { random.below(9) as usize });
    let (mut longs, mut y, mut sizes) = ([0_i64; 8], [0.0; 8], [0_usize; 8]);
    let wild = random.below(u64::MAX) as usize;
    unsafe {
        match random.below(16) {
            0 => fmi3SetDebugLogging(c, 1, n, null()),
            1 => fmi3GetInt64(c, vr, n, longs.as_mut_ptr(), m),
            2 => fmi3SetInt64(c, vr, n, longs.as_ptr(), m),
            3 => fmi3GetBoolean(c, vr, n, b, m),
            4 => fmi3SetBoolean(c, vr, n, b, m),
            5 => fmi3GetBinary(c, vr, n, sizes.as_mut_ptr(), x.cast(), m),
            6 => fmi3SetString(c, vr, n, x.cast(), m),
            7 => fmi3GetClock(c, vr, n, b),
            8 => fmi3SetClock(c, vr, n, b),
            9 => fmi3SetFMUState(c, std::ptr::without_provenance_mut(wild)),
            10 => fmi3DeserializeFMUState(c, x.cast(), 8 * call.reals.len(), &mut null_mut()),
            11 => fmi3GetDirectionalDerivative(c, vr, n, vr, m, x, m, y.as_mut_ptr(), n),
            12 => fmi3CompletedIntegratorStep(c, 1, b, b.wrapping_add(1)),
            13 => fmi3GetFloat64(c, vr, n, x, m),
            14 => {
                let (mut knowns, mut others) = ([0_u32; 8], [0_usize; 8]);
                let (kinds, reference) = (call.integers.as_mut_ptr(), call.references[0]);
                let (sizes, others) = (sizes.as_mut_ptr(), others.as_mut_ptr());
                fmi3GetVariableDependencies(c, reference, sizes, knowns.as_mut_ptr(), others, kinds, m)
            }
            _ => fmi3SetFloat64(c, vr, n, x, m),
        }
    }
}

unsafe fn call_fmi3(
    c: FmiInstance,
    random: &mut Random<'_>,
    references: u64,
    states: &mut [*mut c_void; 2],
    time: f64,
) -> c_int {
    let mut call = Call::new(random, references);
    let (vr, n) = (call.references.as_ptr(), call.count);
    let (x, i) = (call.reals.as_mut_ptr(), call.integers.as_mut_ptr());
    let state = &mut states[random.below(2) as usize];
    let [a, b, d, e, f, ..] = &mut call.flags;
    unsafe {
        match random.below(24) {
            0 => fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0),
            1 => fmi3ExitInitializationMode(c),
            2 if random.below(10) == 0 => fmi3Terminate(c),
            3 => fmi3GetFloat64(c, vr, n, x, n),
            4 => fmi3GetInt32(c, vr, n, i, n),
            5 => fmi3GetFloat32(c, vr, n, x.cast(), n),
            6 | 7 => fmi3SetFloat64(c, vr, n, x, n),
            8 => fmi3SetInt32(c, vr, n, i, n),
            9 => fmi3GetFMUState(c, state),
            10 => fmi3SetFMUState(c, *state),
            11 => fmi3FreeFMUState(c, state),
            12 => fmi3GetAdjointDerivative(c, vr, n, vr, 1, x, n, [0.0; 8].as_mut_ptr(), 1),
            13 => fmi3GetNumberOfVariableDependencies(c, *vr, &mut 0),
            14 => fmi3EnterEventMode(c),
            15 => fmi3UpdateDiscreteStates(c, a, b, d, e, f, x),
            16 => fmi3EnterStepMode(c),
            17 => fmi3EnterContinuousTimeMode(c),
            18 => fmi3SetTime(c, random.number()),
            19 => fmi3SetContinuousStates(c, x, n),
            20 => fmi3GetContinuousStateDerivatives(c, x, 2),
            21 => fmi3GetOutputDerivatives(c, vr, n, i, x, n),
            _ => fmi3DoStep(c, time, random.number().clamp(-1.0, 1.0), 1, a, b, d, x),
        }
    }
}

/// Data of a host's callback.
struct Within {
    instance: std::cell::Cell<FmiInstance>,
    input: u32,
}

/// A callback that sets the input when it is requested, otherwise reads a few variables, and
/// sometimes ends steps early.
unsafe extern "C-unwind" fn update(
    host: *mut c_void,
    time: f64,
    set: u8,
    _: u8,
    _: u8,
    may_return: u8,
    early: *mut u8,
    end: *mut f64,
) {
    // SAFETY: `host` points to the `Within` of this run, which outlives the instance; `early` and
    // `end` are valid pointers.
    unsafe {
        let host = &*host.cast::<Within>();
        let (c, ends) = (host.instance.get(), may_return != 0 && time.to_bits().is_multiple_of(3));
        (*early, *end) = (u8::from(ends), time);
        if set != 0 {
            fmi3SetFloat64(c, &host.input, 1, &(time * 1e6).sin(), 1);
        } else {
            fmi3GetFloat64(c, [1, 2, host.input].as_ptr(), 3, [0.0; 3].as_mut_ptr(), 3);
        }
    }
}

/// Asserts that every Real that can be read is finite.
fn assert_finite(target: &Target, mut get: impl FnMut(*const u32, *mut f64) -> c_int) {
    for reference in 0..target.references as u32 {
        let mut value = 0.0;
        let status = get(&reference, &mut value);
        assert!(status != OK || value.is_finite(), "{value} of {reference}");
    }
}

/// Calls of FMI 2.0 on an instance of the interface type 0 or 1.
///
/// # Panics
/// If a status reports a caught panic, a value is NaN or infinite, or the instance does not answer
/// afterwards.
pub fn run_fmi2(target: &Target, random: &mut Random<'_>, kind: c_int, calls: usize) {
    let mut states = [null_mut(); 2];
    let resources = target.resources.as_ref().map_or(null(), |path| path.as_ptr());
    // SAFETY: the instance is the one made here, and all buffers have eight elements. Larger
    // counts, null pointers, unknown FMU states and strings are refused before they are read.
    unsafe {
        let c = fmi2Instantiate(c"any".as_ptr(), kind, target.token.as_ptr(), resources, null(), 0, 0);
        assert!(!c.is_null());
        let with_further = random.bytes.is_empty();
        for call in 0..calls {
            let mut time = 0.0;
            fmi2GetReal(c, &1, 1, &mut time);
            let status = if with_further && call % 4 == 0 {
                further_fmi2(c, random, target.references)
            } else {
                call_fmi2(c, random, target.references, &mut states, time)
            };
            assert!((0..4).contains(&status), "status {status}");
            if call % 32 == 0 || call + 1 == calls {
                assert_finite(target, |reference, x| fmi2GetReal(c, reference, 1, x));
            }
        }
        assert_eq!(fmi2Reset(c), OK);
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        assert_eq!(fmi2ExitInitializationMode(c), OK);
        fmi2FreeInstance(c);
    }
}

/// Calls of FMI 3.0 on an instance for Model Exchange, or for Co-Simulation with or without event
/// mode.
///
/// # Panics
/// As [`run_fmi2`].
pub fn run_fmi3(target: &Target, random: &mut Random<'_>, exchange: bool, event_mode: bool, calls: usize) {
    let mut states = [null_mut(); 2];
    let (name, event_mode) = (c"any".as_ptr(), u8::from(event_mode));
    let token = target.token.as_ptr();
    let resources = target.resources.as_ref().map_or(null(), |path| path.as_ptr());
    let within = Within { instance: null_mut::<c_void>().into(), input: target.input.unwrap_or_default() };
    let host = std::ptr::from_ref(&within).cast_mut().cast();
    // SAFETY: as above.
    unsafe {
        let c = if exchange {
            fmi3InstantiateModelExchange(name, token, resources, 0, 0, null_mut(), None)
        } else {
            let asked = target.input.is_some();
            let (callback, count) = (asked.then_some(update as _), usize::from(asked));
            let list = &raw const within.input;
            fmi3InstantiateCoSimulation(
                name, token, resources, 0, 0, event_mode, 1, list, count, host, None, callback,
            )
        };
        assert!(!c.is_null());
        within.instance.set(c);
        let with_further = random.bytes.is_empty();
        for call in 0..calls {
            let mut time = 0.0;
            fmi3GetFloat64(c, &1, 1, &mut time, 1);
            let status = if with_further && call % 4 == 0 {
                further_fmi3(c, random, target.references)
            } else {
                call_fmi3(c, random, target.references, &mut states, time)
            };
            assert!((0..4).contains(&status), "status {status}");
            // Reading a reference that is not a Float64 variable terminates the instance, so this
            // is done only after a call has failed.
            if status == 3 && call % 32 < 4 {
                assert_finite(target, |reference, x| fmi3GetFloat64(c, reference, 1, x, 1));
            }
            if status == 3 && random.below(4) > 0 {
                assert_eq!(fmi3Reset(c), OK);
                states = [null_mut(); 2]; // the instance frees the saved states
            }
        }
        assert_eq!(fmi3Reset(c), OK);
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(c), OK);
        fmi3FreeInstance(c);
    }
}
