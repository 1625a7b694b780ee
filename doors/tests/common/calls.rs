//! Random calls with random arguments on the bouncing ball, by both doors: no crash, no panic, and the instance answers afterwards. What
//! is called comes from a seed, or from the bytes of a fuzzer.

use super::bouncing_ball::*;
use fmi_doors::fmi2::abi::FmiComponent;
use fmi_doors::fmi2::types::FmiEventInfo;
use fmi_doors::fmi3::abi::FmiInstance;
use fmi_doors::tabular::FromTable;
use std::ffi::{CString, c_int, c_void};
use std::ptr::{null, null_mut};

const OK: c_int = 0;

/// What is drawn: bytes while there are any, then SplitMix64.
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

/// Buffers of a call, of eight elements each.
struct Call {
    references: [u32; 8],
    reals: [f64; 8],
    integers: [c_int; 8],
    flags: [u8; 8],
    count: usize,
}

impl Call {
    fn new(random: &mut Random<'_>) -> Self {
        Self {
            references: [(); 8].map(|()| random.below(11) as u32),
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
    states: &mut [*mut c_void; 2],
    time: f64,
) -> c_int {
    let mut call = Call::new(random);
    let (vr, n) = (call.references.as_ptr(), call.count);
    let (x, i) = (call.reals.as_mut_ptr(), call.integers.as_mut_ptr());
    let state = &mut states[random.below(2) as usize];
    let mut bytes = [0; 256];
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
                if status != OK || size > bytes.len() {
                    return status;
                }
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

unsafe fn call_fmi3(
    c: FmiInstance,
    random: &mut Random<'_>,
    states: &mut [*mut c_void; 2],
    time: f64,
) -> c_int {
    let mut call = Call::new(random);
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

fn token() -> CString {
    CString::new(FromTable::<Ball>::token()).unwrap()
}

/// Calls of FMI 2.0 on an instance of the interface type 0 or 1.
///
/// # Panics
/// At a status that says a panic was caught, and where the instance does not answer afterwards.
pub fn run_fmi2(random: &mut Random<'_>, kind: c_int, calls: usize) {
    let mut states = [null_mut(); 2];
    // SAFETY: the instance is the one made here, and all buffers are of eight elements, which counts of more make the door refuse.
    unsafe {
        let c = fmi2Instantiate(c"ball".as_ptr(), kind, token().as_ptr(), null(), null(), 0, 0);
        for _ in 0..calls {
            let mut time = 0.0;
            fmi2GetReal(c, &1, 1, &mut time);
            let status = call_fmi2(c, random, &mut states, time);
            assert!((0..4).contains(&status), "status {status}");
        }
        assert_eq!(fmi2Reset(c), OK);
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        assert_eq!(fmi2ExitInitializationMode(c), OK);
        fmi2FreeInstance(c);
    }
}

/// Calls of FMI 3.0 on an instance for Model Exchange, or for Co-Simulation with or without event mode.
///
/// # Panics
/// As [`run_fmi2`].
pub fn run_fmi3(random: &mut Random<'_>, exchange: bool, event_mode: bool, calls: usize) {
    let mut states = [null_mut(); 2];
    let (name, token, event_mode) = (c"ball".as_ptr(), token(), u8::from(event_mode));
    // SAFETY: as above.
    unsafe {
        let c = if exchange {
            fmi3InstantiateModelExchange(name, token.as_ptr(), null(), 0, 0, null_mut(), None)
        } else {
            let (none, list) = (null_mut(), null());
            fmi3InstantiateCoSimulation(
                name,
                token.as_ptr(),
                null(),
                0,
                0,
                event_mode,
                1,
                list,
                0,
                none,
                None,
                None,
            )
        };
        for _ in 0..calls {
            let mut time = 0.0;
            fmi3GetFloat64(c, &1, 1, &mut time, 1);
            let status = call_fmi3(c, random, &mut states, time);
            assert!((0..4).contains(&status), "status {status}");
            if status == 3 && random.below(4) > 0 {
                assert_eq!(fmi3Reset(c), OK);
                states = [null_mut(); 2]; // they stay with the instance
            }
        }
        assert_eq!(fmi3Reset(c), OK);
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(c), OK);
        fmi3FreeInstance(c);
    }
}
