//! Values that this machine accepts and refuses in FMI 3.0. The doors' example tests wrong
//! arguments of any kind (`crates/doors/tests/second_component/arguments.rs`).

use super::host::*;
use std::ffi::CString;
use std::ptr::{null, null_mut};
use vibro_paper_component::fmi3::abi::*;

#[test]
fn impossible_starts_are_discarded_and_can_be_mended() {
    let fmu = Fmu::new(FF);
    assert_eq!(fmu.set("block.s", 1.5), OK);
    // SAFETY: a live instance.
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(fmu.c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(fmu.c), DISCARD, "{}", fmu.last());
        assert_eq!(fmu.set("block.s", 0.5), OK);
        assert_eq!(fmi3ExitInitializationMode(fmu.c), OK);
    }
}

#[test]
fn loads_in_a_closed_form_are_discarded() {
    for flags in [FF, TT] {
        let fmu = Fmu::started(flags, &[("mode", 3.0)]);
        fmu.step(0.0, 0.1);
        assert_eq!(fmu.set("box.f", 0.1), DISCARD);
        assert!(fmu.last().contains("box.f = 0.1: expected 0 in a closed-form mode"), "{}", fmu.last());
        assert_eq!(fmu.set("box.f", 0.0), OK);
        fmu.step(0.1, 0.1);
    }
}

/// `fmi3Boolean` is one byte; any value except 0 is true.
#[test]
fn booleans_are_bytes() {
    let fmu = Fmu::new(FF);
    let r = vr("startOnOrbit");
    for (byte, expected) in [(1_u8, 1), (255, 1), (2, 1), (0, 0)] {
        let mut read = [7_u8; 3];
        // SAFETY: one of each; the neighbouring byte is not touched.
        unsafe {
            assert_eq!(fmi3SetBoolean(fmu.c, &r, 1, &byte, 1), OK);
            assert_eq!(fmi3GetBoolean(fmu.c, &r, 1, &mut read[1], 1), OK);
        }
        assert_eq!(read, [7, expected, 7]);
    }
}

/// Start values can be read before initialization, for hosts that show them.
#[test]
fn start_values_are_read_before_initialization() {
    let fmu = Fmu::new(FF);
    assert_eq!(fmu.get("stopAtImpact"), 1.0);
    assert_eq!(fmu.set("block.s", 0.25), OK);
    assert_eq!((fmu.get("block.s"), fmu.get("mode")), (0.25, 1.0));
    for (_, variable) in
        vibro_paper_component::fmi3::description::variables(vibro_paper_component::fmi3::description::MAIN)
    {
        let _ = fmu.get(variable.name);
    }
    assert!(fmu.log().is_empty(), "{:?}", fmu.log());
}

/// The versions have different value references, so their tokens are not interchangeable.
#[test]
fn the_guid_of_fmi2_is_not_a_token_of_fmi3() {
    let guid = CString::new(vibro_paper_component::fmi2::description::guid()).unwrap();
    // SAFETY: valid strings.
    let c =
        unsafe { fmi3InstantiateModelExchange(c"a".as_ptr(), guid.as_ptr(), null(), 0, 0, null_mut(), None) };
    assert!(c.is_null());
}
