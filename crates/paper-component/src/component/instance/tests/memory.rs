//! Saved states.

use super::*;

#[test]
fn restore_then_continue_is_bit_identical() {
    let mut fmu = initialized();
    set(&mut fmu, "box.f", 0.01).unwrap();
    step(&mut fmu, 0.0, 13.7).unwrap();
    set(&mut fmu, "box.c", 0.09).unwrap(); // pending
    set(&mut fmu, "drive.amplitude", 0.12).unwrap();
    set(&mut fmu, "block.f", 0.003).unwrap();
    fmu.set_input_derivatives(&[reference("secondary.f")], &[2], &[1e-4]).unwrap();
    let saved = fmu.save();
    let bytes = saved.serialize().unwrap();
    step(&mut fmu, 13.7, 20.0).unwrap();
    let straight = motion(&mut fmu);

    fmu.restore(&saved).unwrap();
    step(&mut fmu, 13.7, 20.0).unwrap();
    assert_eq!(motion(&mut fmu), straight);

    let mut fresh = instance();
    restore_bytes(&mut fresh, &bytes).unwrap();
    assert_eq!(fresh.phase(), Phase::Step);
    assert_eq!(get(&mut fresh, "box.c"), 0.09);
    assert!((get(&mut fresh, "groups.f10") - 1.2).abs() < 1e-12);
    step(&mut fresh, 13.7, 20.0).unwrap();
    assert_eq!(motion(&mut fresh), straight);
}

#[test]
fn a_state_of_before_initialization_comes_back_too() {
    let mut fmu = instance();
    set(&mut fmu, "box.s", 0.5).unwrap();
    let saved = fmu.save();
    let bytes = saved.serialize().unwrap();
    let mut fmu = initialize(fmu);
    step(&mut fmu, 0.0, 1.0).unwrap();
    restore_bytes(&mut fmu, &bytes).unwrap();
    assert_eq!(fmu.phase(), Phase::Instantiated);
    let mut fmu = initialize(fmu);
    assert_eq!((get(&mut fmu, "box.s"), get(&mut fmu, "time")), (0.5, 0.0));
}

#[test]
fn damaged_and_foreign_bytes_are_refused() {
    let mut fmu = initialized();
    step(&mut fmu, 0.0, 13.7).unwrap();
    let bytes = fmu.save().serialize().unwrap();
    for length in 0..bytes.len() {
        assert!(
            matches!(
                SavedState::deserialize(&bytes[..length]),
                Err(ComponentProblem::Door(fmi_doors::Problem::SavedState { .. }))
            ),
            "{length}"
        );
    }
    for place in 0..bytes.len() {
        let mut altered = bytes.clone();
        altered[place] ^= 0x10;
        assert!(SavedState::deserialize(&altered).is_err(), "{place}");
    }
    let mut longer = bytes.clone();
    longer.push(0);
    assert!(SavedState::deserialize(&longer).is_err());
    // A state of the other interface type.
    let mut exchange = Instance::new(Interface::ModelExchange);
    assert!(restore_bytes(&mut exchange, &bytes).is_err());
    assert_eq!(exchange.phase(), Phase::Instantiated);
}

#[test]
fn reset_is_as_new() {
    let mut fmu = instance();
    set(&mut fmu, "box.k", 3.0).unwrap();
    let mut fmu = initialize(fmu);
    step(&mut fmu, 0.0, 20.0).unwrap();
    fmu.reset();
    let mut fmu = initialize(fmu);
    step(&mut fmu, 0.0, 20.0).unwrap();
    let mut fresh = initialized();
    step(&mut fresh, 0.0, 20.0).unwrap();
    assert_eq!(motion(&mut fmu), motion(&mut fresh));
}
