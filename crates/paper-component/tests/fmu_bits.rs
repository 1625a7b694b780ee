//! Bits of the FMU's outputs in many runs through the C interface, in all modes, compared with a
//! golden file (golden file: `tests/data/fmu_bits.<instruction set>.txt`); see
//! `tests/state_bits.rs` for the library's.
#![allow(unsafe_code)] // the C interface

#[path = "../../../tests/common/bits.rs"]
#[allow(missing_docs, dead_code)] // each user of the file takes what it needs
mod bits;

#[path = "common/fmi2.rs"]
mod fmi2;

use bits::{Digest, compare};
use fmi2::{Fmu2, OK};
use std::ffi::c_void;
use std::ptr::null_mut;
use vibro_paper_component::component::variables::{Base, reference};
use vibro_paper_component::fmi2::abi::*;
use vibro_paper_component::fmi2::description;
use vibro_paper_component::fmi2::types::FmiEventInfo;

/// Value references in the golden file: the variables of version 0.1, so that a new variable does
/// not change it.
const RECORDED: u32 = 72;
/// Points at which each run is recorded.
const POINTS: u32 = 10_000;

fn record(fmu: &Fmu2, digest: &mut Digest) {
    for (r, variable) in description::variables().filter(|(r, _)| *r < RECORDED) {
        let value = fmu.get(r, variable.base());
        let (real, whole) = if variable.base() == Base::Real { (value, -1) } else { (0.0, value as i32) };
        digest.reals(&[if real.is_nan() { 0.0 } else { real }]);
        digest.number(whole as u64);
    }
}

fn steps(start: &[(&str, f64)], size: f64, mut before: impl FnMut(&Fmu2, u32)) -> String {
    let fmu = Fmu2::started(start);
    let mut digest = Digest::new();
    for i in 0..POINTS {
        before(&fmu, i);
        fmu.step(f64::from(i) * size, size);
        record(&fmu, &mut digest);
    }
    digest.finish()
}

/// A solver by Euler's rule: derivatives, event indicators and the iteration at events.
fn exchange(start: &[(&str, f64)], size: f64) -> String {
    let (fmu, mut digest) = (Fmu2::quiet(0).start(start), Digest::new());
    let mut info = FmiEventInfo::default();
    let (mut x, mut rate, mut indicators) = ([0.0; 6], [0.0; 6], [0.0; 3]);
    let count = description::EVENT_INDICATORS;
    // SAFETY: a live component and arrays of the lengths given.
    unsafe {
        assert_eq!(fmi2NewDiscreteStates(fmu.c, &mut info), OK);
        assert_eq!(fmi2EnterContinuousTimeMode(fmu.c), OK);
        for i in 1..=POINTS {
            assert_eq!(fmi2GetContinuousStates(fmu.c, x.as_mut_ptr(), 6), OK);
            assert_eq!(fmi2GetDerivatives(fmu.c, rate.as_mut_ptr(), 6), OK);
            assert_eq!(fmi2GetEventIndicators(fmu.c, indicators.as_mut_ptr(), count), OK);
            digest.reals(&x);
            digest.reals(&rate);
            digest.reals(&indicators[..count]);
            let before = indicators;
            for (x, rate) in x.iter_mut().zip(rate) {
                *x += size * rate;
            }
            assert_eq!(fmi2SetTime(fmu.c, f64::from(i) * size), OK);
            assert_eq!(fmi2SetContinuousStates(fmu.c, x.as_ptr(), 6), OK);
            let (mut event, mut terminate) = (0, 0);
            assert_eq!(fmi2CompletedIntegratorStep(fmu.c, 1, &mut event, &mut terminate), OK);
            assert_eq!(fmi2GetEventIndicators(fmu.c, indicators.as_mut_ptr(), count), OK);
            if event != 0 || before.iter().zip(indicators).any(|(a, b)| (*a > 0.0) != (b > 0.0)) {
                assert_eq!(fmi2EnterEventMode(fmu.c), OK);
                assert_eq!(fmi2NewDiscreteStates(fmu.c, &mut info), OK);
                assert_eq!(fmi2EnterContinuousTimeMode(fmu.c), OK);
            }
            record(&fmu, &mut digest);
        }
    }
    digest.finish()
}

fn saved(start: &[(&str, f64)], size: f64) -> String {
    let mut kept: *mut c_void = null_mut();
    let digest = steps(start, size, |fmu, i| {
        // SAFETY: a live component; the bytes have the requested length.
        unsafe {
            match i % 200 {
                50 => assert_eq!(fmi2GetFMUstate(fmu.c, &mut kept), OK),
                51 => {
                    let mut length = 0;
                    assert_eq!(fmi2SerializedFMUstateSize(fmu.c, kept, &mut length), OK);
                    let mut bytes = vec![0; length];
                    assert_eq!(fmi2SerializeFMUstate(fmu.c, kept, bytes.as_mut_ptr().cast(), length), OK);
                    assert_eq!(fmi2FreeFMUstate(fmu.c, &mut kept), OK);
                    assert_eq!(fmi2DeSerializeFMUstate(fmu.c, bytes.as_ptr().cast(), length, &mut kept), OK);
                    assert_eq!(fmi2SetFMUstate(fmu.c, kept), OK);
                    fmu.step(f64::from(i - 1) * size, size);
                    assert_eq!(fmi2FreeFMUstate(fmu.c, &mut kept), OK);
                }
                _ => {}
            }
        }
    });
    assert!(kept.is_null());
    digest
}

#[test]
fn golden_bits_of_the_outputs() {
    let basic: &[(&str, f64)] = &[("block.s", 0.9), ("block.v", 0.5)];
    let resting = [basic, &[("stop.restitution", 0.2)]].concat();
    let chaotic = [basic, &[("drive.amplitude", 0.45)]].concat();
    let plastic = [basic, &[("stop.restitution", 0.0), ("drive.phase", 1.0)]].concat();
    let mut found = Vec::new();
    for (name, start) in
        [("basic", basic), ("resting", &resting), ("chaotic", &chaotic), ("plastic", &plastic)]
    {
        found.push((format!("{name}, a hundredth of a period"), steps(start, 0.06, |_, _| {})));
        found.push((format!("{name}, long steps"), steps(start, 7.7, |_, _| {})));
        found.push((format!("{name}, Model Exchange by Euler's rule"), exchange(start, 0.003)));
        found.push((format!("{name}, states saved, serialized and put back"), saved(start, 0.06)));
        found.push((
            format!("{name}, loads with derivatives, parameters changed"),
            steps(start, 0.06, |fmu, i| {
                let wave = |k: f64| (k * f64::from(i % 1000)).rem_euclid(1.0) - 0.5;
                fmu.set_all(&[
                    ("box.f", 0.1 * wave(0.37)),
                    ("block.f", 0.02 * wave(0.11)),
                    ("secondary.f", 0.02 * wave(0.53)),
                ]);
                let (r, order, value) = (reference("block.f"), 1, 0.01 * wave(0.29));
                // SAFETY: one of each.
                assert_eq!(unsafe { fmi2SetRealInputDerivatives(fmu.c, &r, 1, &order, &value) }, OK);
                if i % 70 == 0 {
                    fmu.set_all(&[
                        ("drive.frequency", 1.0 + 0.1 * wave(0.61)),
                        ("stop.restitution", 0.5 + wave(0.17) * 0.9),
                    ]);
                }
            }),
        ));
    }
    for mode in [2.0, 3.0] {
        found.push((
            format!("closed form {mode}"),
            steps(&[("mode", mode)], 0.06, |fmu, i| {
                if i % 500 == 499 {
                    fmu.set_all(&[("drive.amplitude", 0.14 + 0.02 * f64::from(i % 3))]);
                }
            }),
        ));
    }
    found.push(("started on the orbit".into(), steps(&[("startOnOrbit", 1.0)], 0.06, |_, _| {})));
    compare("fmu_bits", &found);
}
