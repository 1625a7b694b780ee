//! An input of a table that a host sets during a step with its callback, and callbacks that
//! misbehave.
#![allow(unsafe_code)] // the C interface

use fmi_doors::fmi3::abi::FmiInstance;
use fmi_doors::hybrid::Pieces;
use fmi_doors::log::Silence;
use fmi_doors::tabular::{FromTable, Row, Tabular};
use fmi_doors::{Bases, Component, EventHandling, Instantiation, Interface, Model, Piece, Version};
use std::ffi::{CString, c_int, c_void};
use std::ptr::{null, null_mut};

fmi_doors::export!(FromTable<Lag>);

const OK: c_int = 0;
const ERROR: c_int = 3;
const FATAL: c_int = 4;

/// y follows u: y' = u - y.
enum Lag {}

const TIME: usize = 0;
const U: usize = 1;
const Y: usize = 2;
const RATE: usize = 3;

impl Tabular for Lag {
    const NAME: &'static str = "Lag";
    const IDENTIFIER: &'static str = "lag";
    const DESCRIPTION: &'static str = "A first-order lag";
    const VERSION: &'static str = "1.0";
    const ROWS: &'static [Row] = &[
        Row::time("time"),
        Row::input("u", "1", 0.0, "What is followed"),
        Row::state("y", "1", 0.0, "What follows"),
        Row::derivative("der(y)", "1/s", Y, "Its rate"),
    ];

    fn evaluate(x: &mut [f64]) {
        x[RATE] = x[U] - x[Y];
    }

    fn advance(x: &mut [f64], time: f64) {
        x[Y] = x[U] + (x[Y] - x[U]) * (-(time - x[TIME])).exp();
    }
}

fn read(lag: &mut FromTable<Lag>, place: usize) -> f64 {
    let mut value = f64::NAN;
    lag.get(Bases::REAL, &[place as u32 + 1], |_, x| value = x).unwrap();
    value
}

/// The input is held in each of 16 parts of a step, at its value in their middle. The answer to a
/// ramp has an error of the square of a part over 24.
#[test]
fn closed_form_answer_of_a_lag_to_a_ramp_in_a_step() {
    const STEP: f64 = 0.5;
    const LEFT: f64 = (STEP / 16.0) * (STEP / 16.0) / 24.0;
    let token = FromTable::<Lag>::token();
    let mut lag = FromTable::<Lag>::instantiate(&Instantiation {
        version: Version::Fmi3,
        interface: Interface::CoSimulation,
        handling: EventHandling::default(),
        name: "lag",
        token: &token,
        resources: None,
    })
    .unwrap();
    lag.enter_initialization();
    lag.exit_initialization(&mut Silence).unwrap();
    let mut pieces = Pieces::begin(&lag, 0.0, STEP).unwrap();
    pieces.interpolate(&mut lag, U as u32 + 1, [0.0, 1.0, 2.0, 3.0].map(|k| k / 3.0 * STEP));
    pieces.start(&mut lag, &mut Silence).unwrap();
    assert_eq!(pieces.next(&mut lag, None, &mut Silence).unwrap(), Piece::End);
    let ended = pieces.end(&mut lag);
    assert_eq!((ended.time, ended.event, ended.early), (STEP, false, false));
    let answer = |t: f64| t - 1.0 + (-t).exp();
    let y = read(&mut lag, Y);
    assert!((y - answer(STEP)).abs() < LEFT, "{y} {}", answer(STEP));
    // From the step's end on the input holds its value at the end.
    assert!((read(&mut lag, U) - STEP).abs() < f64::EPSILON);
    lag.step_as_agreed(STEP, STEP, &mut Silence).unwrap();
    let held = STEP + (answer(STEP) - STEP) * (-STEP).exp();
    assert!((read(&mut lag, Y) - held).abs() < LEFT);
}

/// A call by the callback, and the statuses of these calls.
struct Within {
    c: FmiInstance,
    call: unsafe fn(FmiInstance) -> c_int,
    statuses: Vec<c_int>,
}

unsafe extern "C-unwind" fn misbehave(
    within: *mut c_void,
    _: f64,
    _: u8,
    _: u8,
    _: u8,
    _: u8,
    _: *mut u8,
    _: *mut f64,
) {
    let within = unsafe { &mut *within.cast::<Within>() };
    let status = unsafe { (within.call)(within.c) };
    within.statuses.push(status);
}

unsafe fn do_step(c: FmiInstance) -> (c_int, f64) {
    let (mut event, mut terminate, mut early, mut time) = (7, 7, 7, f64::NAN);
    let status = unsafe { fmi3DoStep(c, 0.0, 0.5, 1, &mut event, &mut terminate, &mut early, &mut time) };
    (status, time)
}

/// A step of a host that sets `u` during it and whose callback makes the given call. Returns
/// status, last successful time, the statuses of the calls inside, and the instance.
fn step_with(call: unsafe fn(FmiInstance) -> c_int) -> (c_int, f64, Vec<c_int>, FmiInstance) {
    let mut within = Within { c: null_mut(), call, statuses: Vec::new() };
    let (token, place) = (CString::new(FromTable::<Lag>::token()).unwrap(), &raw mut within);
    let (name, token, required) = (c"lag".as_ptr(), token.as_ptr(), [U as u32 + 1]);
    unsafe {
        let (list, callback) = (required.as_ptr(), Some(misbehave as _));
        let c = fmi3InstantiateCoSimulation(
            name,
            token,
            null(),
            0,
            0,
            0,
            0,
            list,
            1,
            place.cast(),
            None,
            callback,
        );
        (*place).c = c;
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(c), OK);
        let (status, time) = do_step(c);
        (status, time, (*place).statuses.clone(), c)
    }
}

/// Steps, resets and states of the whole FMU inside a step are errors; the step is undone, and
/// Reset helps. So are values not required, and reads while inputs are requested.
#[test]
fn calls_by_the_callback_that_change_the_step_are_refused() {
    let calls: [unsafe fn(FmiInstance) -> c_int; 6] = [
        |c| unsafe { do_step(c).0 },
        |c| unsafe { fmi3Reset(c) },
        |c| unsafe { fmi3GetFMUState(c, &mut null_mut()) },
        |c| unsafe { fmi3Terminate(c) },
        |c| unsafe { fmi3GetFloat64(c, &(Y as u32 + 1), 1, &mut 0.0, 1) },
        |c| unsafe { fmi3SetFloat64(c, &(Y as u32 + 1), 1, &0.0, 1) },
    ];
    for call in calls {
        let (status, time, inside, c) = step_with(call);
        assert_eq!((status, time, &inside[..]), (ERROR, 0.0, &[ERROR][..]));
        unsafe {
            assert_eq!(fmi3Reset(c), OK);
            fmi3FreeInstance(c);
        }
    }
}

#[test]
fn freeing_by_the_callback_is_ignored_and_its_panics_are_fatal() {
    let (status, time, inside, c) = step_with(|c| {
        unsafe { fmi3FreeInstance(c) };
        OK
    });
    assert_eq!((status, time), (OK, 0.5));
    assert_eq!(inside.len(), 4, "three for inputs, one at the end");
    unsafe { fmi3FreeInstance(c) };
    let (status, _, inside, c) = step_with(|_| panic!("in the callback"));
    assert_eq!((status, inside.len()), (FATAL, 0));
    unsafe {
        assert_eq!(fmi3Reset(c), ERROR);
        fmi3FreeInstance(c);
    }
}
