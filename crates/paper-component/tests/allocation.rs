//! Stepping, getting and setting allocate nothing, and neither does a motion of a queue. The test
//! has its own process, because it has its own allocator.
#![allow(unsafe_code)] // an allocator is one, and so is the C interface

#[path = "../../../tests/common/allocations.rs"]
mod allocations;

use allocations::COUNT;
use std::ffi::CString;
use vibro_impact::Parameters;
use vibro_impact::simulator::{
    Event, Maximum, MotionQueue, Plan, Reports, Simulator, State, TOGETHER, advance_queue,
};
use vibro_paper_component::component::variables::reference;
use vibro_paper_component::fmi2::abi::*;
use vibro_paper_component::fmi2::description;
use vibro_paper_component::fmi3::abi::*;
use vibro_paper_component::fmi3::description as description3;

/// Motions of different systems, a tenth of them with rest; everything is reported.
#[derive(Default)]
struct Motions {
    left: u32,
    samples: usize,
    rests: usize,
    maxima: usize,
}

impl MotionQueue for Motions {
    fn next(
        &mut self,
        lane: usize,
        simulators: &mut [Simulator],
        ended: Option<vibro_impact::Result<()>>,
    ) -> Option<Plan> {
        ended.transpose().expect("motions end well");
        self.left = self.left.checked_sub(1)?;
        let stop_restitution = if self.left.is_multiple_of(10) { 0.0 } else { 0.75 };
        let drive_amplitude = 0.1 + 0.001 * f64::from(self.left);
        let p = Parameters { drive_amplitude, stop_restitution, ..Parameters::default() };
        let state = State { x: [0.0; 3], v: [0.0, 1.0, 0.0] };
        simulators[lane].restart(&p, &state, 0.0).expect("a start");
        let reports =
            Reports { origin: 0.0, step: 0.5 * p.period(), first: 1, maxima_of: Some([0.0, 1.0, 0.0]) };
        Some(Plan { simulator: lane, end: 30.0 * p.period(), reports: Some(reports) })
    }

    fn sample(&mut self, _: usize, number: u32, _: &State) -> std::ops::ControlFlow<(), u32> {
        self.samples += 1;
        std::ops::ControlFlow::Continue(number + 1)
    }

    fn event(&mut self, _: usize, event: &Event, _: &vibro_impact::model::Augmented) -> Option<u32> {
        self.rests += usize::from(matches!(event, Event::Rest { .. }));
        None
    }

    fn maximum(&mut self, _: usize, _: &Maximum) {
        self.maxima += 1;
    }
}

#[test]
fn a_motion_of_a_queue_allocates_nothing() {
    let state = State { x: [0.0; 3], v: [0.0; 3] };
    let simulator = |_| Simulator::new(&Parameters::default(), &state, 0.0).unwrap();
    let mut simulators: Vec<Simulator> = (0..TOGETHER).map(simulator).collect();
    let mut allocated = |left| {
        let (before, mut motions) = (COUNT.get(), Motions { left, ..Motions::default() });
        advance_queue(&mut simulators, &mut motions);
        assert!(motions.samples >= 59 * left as usize && motions.rests > 0 && motions.maxima > 0);
        COUNT.get() - before
    };
    // The first run allocates memory that all others reuse.
    allocated(10 * TOGETHER as u32);
    assert_eq!(allocated(10 * TOGETHER as u32), allocated(40 * TOGETHER as u32));
}

#[test]
fn a_step_with_impacts_loads_and_rest_allocates_nothing() {
    let guid = CString::new(description::guid()).unwrap();
    let outputs = [reference("box.s"), reference("block.a"), reference("energy.damped"), reference("box.k")];
    let inputs = [reference("box.f"), reference("block.f")];
    let (mut values, mut state) = ([0.0; 4], std::ptr::null_mut());
    // SAFETY: valid pointers, counts that fit, and the instance is freed last.
    unsafe {
        let none = std::ptr::null();
        let c = fmi2Instantiate(c"counted".as_ptr(), 1, guid.as_ptr(), none, std::ptr::null(), 0, 0);
        fmi2SetReal(c, &reference("stop.restitution"), 1, &0.3);
        fmi2SetReal(c, &reference("drive.amplitude"), 1, &0.4);
        fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0);
        fmi2EnterInitializationMode(c);
        assert_eq!(fmi2ExitInitializationMode(c), 0);
        assert_eq!(fmi2GetFMUstate(c, &mut state), 0);
        let mut steps = |from: i32, to: i32| {
            for i in from..to {
                let load = [0.01 * f64::from(i % 3), 0.02];
                assert_eq!(fmi2SetReal(c, inputs.as_ptr(), 2, load.as_ptr()), 0);
                assert_eq!(fmi2SetRealInputDerivatives(c, inputs.as_ptr(), 1, &1, &0.01), 0);
                assert_eq!(fmi2DoStep(c, 0.5 * f64::from(i), 0.5, 1), 0);
                assert_eq!(fmi2GetReal(c, outputs.as_ptr(), 4, values.as_mut_ptr()), 0);
                assert_eq!(fmi2GetFMUstate(c, &mut state), 0);
                assert_eq!(fmi2SetFMUstate(c, state), 0);
            }
        };
        steps(0, 1);
        let before = COUNT.get();
        steps(1, 400);
        assert_eq!(COUNT.get(), before);
        let mut impacts = [0; 2];
        let counts = [reference("impacts.upper"), reference("impacts.lower")];
        assert_eq!(fmi2GetInteger(c, counts.as_ptr(), 2, impacts.as_mut_ptr()), 0);
        assert!(impacts[0] > 50, "{impacts:?}");
        fmi2FreeInstance(c);
    }
}

/// FMI 3.0: steps with loads, ends at impacts, Event Mode with getters, an input set in Event Mode
/// and the announced next event; without event mode, the same without these.
#[test]
fn a_step_of_fmi3_with_its_events_allocates_nothing() {
    let token = CString::new(description3::instantiation_token(description3::MAIN)).unwrap();
    let vr = |name| description3::value_reference(description3::MAIN, name).unwrap();
    let outputs = [vr("box.s"), vr("block.a"), vr("energy.damped"), vr("impacts.nextTime")];
    for events in [1, 0] {
        let (mut values, mut flags, mut met) = ([0.0; 4], [0_u8; 5], 0);
        // SAFETY: valid pointers, counts that fit, and the instance is freed last.
        unsafe {
            let (none, null) = (std::ptr::null(), std::ptr::null_mut());
            let name = c"counted".as_ptr();
            let c = fmi3InstantiateCoSimulation(
                name,
                token.as_ptr(),
                none,
                0,
                0,
                events,
                events,
                std::ptr::null(),
                0,
                null,
                None,
                None,
            );
            for (name, value) in [("stop.restitution", 0.3), ("drive.amplitude", 0.4)] {
                assert_eq!(fmi3SetFloat64(c, &vr(name), 1, &value, 1), 0);
            }
            assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), 0);
            assert_eq!(fmi3ExitInitializationMode(c), 0);
            if events == 1 {
                assert_eq!(fmi3EnterStepMode(c), 0);
            }
            let (mut state, mut time) = (null, 0.0);
            assert_eq!(fmi3GetFMUState(c, &mut state), 0);
            let mut step = |i: i32| {
                let [event, terminate, early, d, e] = &mut flags;
                let load = 0.01 * f64::from(i % 3);
                assert_eq!(fmi3SetFloat64(c, &vr("box.f"), 1, &load, 1), 0);
                assert_eq!(fmi3DoStep(c, time, 0.5, 1, event, terminate, early, &mut time), 0);
                assert_eq!(fmi3GetFloat64(c, outputs.as_ptr(), 4, values.as_mut_ptr(), 4), 0);
                if *event == 1 {
                    met += 1;
                    assert_eq!(fmi3EnterEventMode(c), 0);
                    assert_eq!(fmi3SetFloat64(c, &vr("block.f"), 1, &(0.5 * load), 1), 0);
                    assert_eq!(fmi3GetFloat64(c, outputs.as_ptr(), 4, values.as_mut_ptr(), 4), 0);
                    let mut next = 0.0;
                    assert_eq!(fmi3UpdateDiscreteStates(c, event, terminate, early, d, e, &mut next), 0);
                    assert_eq!(fmi3EnterStepMode(c), 0);
                }
                assert_eq!(fmi3GetFMUState(c, &mut state), 0);
                assert_eq!(fmi3SetFMUState(c, state), 0);
            };
            (0..40).for_each(&mut step);
            let before = COUNT.get();
            (40..1000).for_each(&mut step);
            assert_eq!(COUNT.get(), before, "events: {events}");
            assert_eq!(met > 50, events == 1, "{met}");
            fmi3FreeInstance(c);
        }
    }
}
