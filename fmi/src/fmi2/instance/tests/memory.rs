//! FMU states.

use super::*;

#[test]
fn restore_then_continue_is_bit_identical() {
    let mut fmu = initialized();
    set(&mut fmu, "box.f", 0.01).unwrap();
    step(&mut fmu, 0.0, 13.7).unwrap();
    set(&mut fmu, "box.c", 0.09).unwrap(); // pending
    set(&mut fmu, "block.f", 0.003).unwrap();
    fmu.set_real_input_derivatives(&[reference("secondary.f")], &[2], &[1e-4]).unwrap();
    let saved = fmu.fmu_state().unwrap();
    let bytes = saved.serialize().unwrap();
    step(&mut fmu, 13.7, 20.0).unwrap();
    let straight = motion(&mut fmu);

    fmu.set_fmu_state(&saved).unwrap();
    step(&mut fmu, 13.7, 20.0).unwrap();
    assert_eq!(motion(&mut fmu), straight);

    let mut fresh = instance();
    restore_bytes(&mut fresh, &bytes).unwrap();
    assert_eq!(fresh.state(), State::StepComplete);
    assert_eq!(get(&mut fresh, "box.c"), 0.09);
    assert!((get(&mut fresh, "groups.gamma1") - 0.9).abs() < 1e-12);
    step(&mut fresh, 13.7, 20.0).unwrap();
    assert_eq!(motion(&mut fresh), straight);
}

#[test]
fn a_state_of_before_initialization_comes_back_too() {
    let mut fmu = instance();
    set(&mut fmu, "box.s", 0.5).unwrap();
    let saved = fmu.fmu_state().unwrap();
    let bytes = saved.serialize().unwrap();
    let mut fmu = initialize(fmu);
    step(&mut fmu, 0.0, 1.0).unwrap();
    restore_bytes(&mut fmu, &bytes).unwrap();
    assert_eq!(fmu.state(), State::Instantiated);
    let mut fmu = initialize(fmu);
    assert_eq!((get(&mut fmu, "box.s"), get(&mut fmu, "time")), (0.5, 0.0));
}

#[test]
fn damaged_and_foreign_bytes_are_refused() {
    let mut fmu = initialized();
    step(&mut fmu, 0.0, 13.7).unwrap();
    let bytes = fmu.fmu_state().unwrap().serialize().unwrap();
    for length in 0..bytes.len() {
        assert!(matches!(fmu.deserialize(&bytes[..length]), Err(Problem::Memory { .. })), "{length}");
    }
    for place in 0..bytes.len() {
        let mut altered = bytes.clone();
        altered[place] ^= 0x10;
        assert!(fmu.deserialize(&altered).is_err(), "{place}");
    }
    let mut longer = bytes.clone();
    longer.push(0);
    assert!(fmu.deserialize(&longer).is_err());
    // Of another build, with a right checksum.
    let mut foreign = bytes[..bytes.len() - 8].to_vec();
    foreign[12] ^= 1;
    let checksum = crate::fmi2::bytes::checksum(&foreign);
    foreign.extend_from_slice(&checksum.to_le_bytes());
    assert!(fmu.deserialize(&foreign).unwrap_err().to_string().contains("another build"));
    // Of the other interface type.
    let mut exchange = Instance::new("test", Interface::ModelExchange, &description::guid(), true).unwrap();
    assert!(restore_bytes(&mut exchange, &bytes).is_err());
    assert_eq!(exchange.state(), State::Instantiated);
}

#[test]
fn handles_are_looked_up_and_never_followed() {
    let mut fmu = initialized();
    let first = fmu.keep(fmu.fmu_state().unwrap(), 0).unwrap();
    step(&mut fmu, 0.0, 1.0).unwrap();
    let second = fmu.keep(fmu.fmu_state().unwrap(), 0).unwrap();
    assert_ne!(first, second);
    assert_eq!(fmu.keep(fmu.fmu_state().unwrap(), second).unwrap(), second);
    fmu.restore_kept(first).unwrap();
    assert_eq!(get(&mut fmu, "time"), 0.0);
    fmu.restore_kept(second).unwrap();
    assert_eq!(get(&mut fmu, "time"), 1.0);
    fmu.free_kept(first).unwrap();
    assert!(fmu.free_kept(first).is_err());
    assert!(fmu.restore_kept(first).is_err());
    assert!(fmu.restore_kept(12345).is_err());
    assert!(initialized().restore_kept(second).is_err());
    fmu.restore_kept(second).unwrap();
}

#[test]
fn reset_is_as_new() {
    let mut fmu = instance();
    set(&mut fmu, "box.k", 3.0).unwrap();
    let mut fmu = initialize(fmu);
    step(&mut fmu, 0.0, 20.0).unwrap();
    fmu.reset().unwrap();
    let mut fmu = initialize(fmu);
    step(&mut fmu, 0.0, 20.0).unwrap();
    let mut fresh = initialized();
    step(&mut fresh, 0.0, 20.0).unwrap();
    assert_eq!(motion(&mut fmu), motion(&mut fresh));
}
