//! Model Exchange: both limits of an event, and a motion integrated by a host's solver, compared
//! with Co-Simulation.

use super::host::*;
use vibro_paper_component::component::structure::EVENT_INDICATORS;
use vibro_paper_component::fmi3::abi::*;

/// A host with Heun's rule and bisection between event indicators.
struct Solver {
    fmu: Fmu,
    time: f64,
}

impl Solver {
    fn new(start: &[(&str, f64)]) -> Self {
        let fmu = Fmu::exchange();
        for (name, value) in start {
            assert_eq!(fmu.set(name, *value), OK);
        }
        fmu.initialize();
        fmu.update();
        let solver = Self { fmu, time: 0.0 };
        solver.go_on();
        solver
    }

    fn go_on(&self) {
        // SAFETY: a live instance.
        assert_eq!(unsafe { fmi3EnterContinuousTimeMode(self.fmu.c) }, OK, "{}", self.fmu.last());
    }

    fn states(&self) -> [f64; 6] {
        let mut x = [0.0; 6];
        // SAFETY: six elements.
        assert_eq!(unsafe { fmi3GetContinuousStates(self.fmu.c, x.as_mut_ptr(), 6) }, OK);
        x
    }

    fn rates(&self) -> [f64; 6] {
        let mut x = [0.0; 6];
        // SAFETY: six elements.
        assert_eq!(unsafe { fmi3GetContinuousStateDerivatives(self.fmu.c, x.as_mut_ptr(), 6) }, OK);
        x
    }

    fn indicators(&self) -> [f64; EVENT_INDICATORS] {
        let mut z = [0.0; EVENT_INDICATORS];
        // SAFETY: `z.len()` elements.
        assert_eq!(unsafe { fmi3GetEventIndicators(self.fmu.c, z.as_mut_ptr(), z.len()) }, OK);
        z
    }

    fn put(&self, time: f64, x: &[f64; 6]) {
        // SAFETY: six elements.
        unsafe {
            assert_eq!(fmi3SetTime(self.fmu.c, time), OK);
            assert_eq!(fmi3SetContinuousStates(self.fmu.c, x.as_ptr(), 6), OK, "{}", self.fmu.last());
        }
    }

    /// Result of a classical Runge-Kutta step of `h`.
    fn stage(&self, x: &[f64; 6], h: f64) -> [f64; 6] {
        let at = |k: &[f64; 6], s: f64| std::array::from_fn(|i| x[i] + s * k[i]);
        self.put(self.time, x);
        let k1 = self.rates();
        self.put(self.time + 0.5 * h, &at(&k1, 0.5 * h));
        let k2 = self.rates();
        self.put(self.time + 0.5 * h, &at(&k2, 0.5 * h));
        let k3 = self.rates();
        self.put(self.time + h, &at(&k3, h));
        let k4 = self.rates();
        std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    }

    /// A step with its event, if any; returns whether there was one.
    fn step(&mut self, h: f64) -> bool {
        let x = self.states();
        let before = self.indicators().map(|z| z > 0.0);
        let crossed = |solver: &Self, h: f64| {
            let y = solver.stage(&x, h);
            solver.put(solver.time + h, &y);
            solver.indicators().map(|z| z > 0.0) != before
        };
        let (mut low, mut high) = (0.0, h);
        let event = crossed(self, h);
        while event && high - low > 1e-13 {
            let middle = 0.5 * (low + high);
            if crossed(self, middle) { high = middle } else { low = middle }
        }
        crossed(self, high);
        self.time += high;
        let (mut enter, mut terminate) = (7, 7);
        // SAFETY: one of each.
        unsafe {
            assert_eq!(fmi3CompletedIntegratorStep(self.fmu.c, 1, &mut enter, &mut terminate), OK);
        }
        assert_eq!(terminate, 0);
        event || enter == 1
    }
}

const START: &[(&str, f64)] = &[("block.s", 0.9), ("block.v", 0.5)];

/// The rule's error at this step, grown over the impacts of 20 s.
const RULE: f64 = 1e-7;

#[test]
fn second_method_exchange_against_cosimulation() {
    let mut solver = Solver::new(START);
    let mut impacts = 0;
    while solver.time < 20.0 {
        let h = (20.0 - solver.time).min(0.01);
        if !solver.step(h) {
            continue;
        }
        let (before, counted) =
            (solver.states(), solver.fmu.get("impacts.upper") + solver.fmu.get("impacts.lower"));
        solver.fmu.enter_event_mode();
        // Getters show the values after the event, before the event is handled.
        let after = solver.states();
        let shown = solver.fmu.get("impacts.upper") + solver.fmu.get("impacts.lower");
        assert_eq!(solver.fmu.motion(), after);
        assert!(solver.indicators().iter().all(|z| *z != 0.0));
        let update = solver.fmu.update();
        assert_eq!(update.values_changed, before != after);
        assert_eq!(update.next, None, "the solver's to find");
        assert_eq!(solver.states(), after);
        impacts += usize::from(shown > counted);
        solver.go_on();
    }
    let plain = Fmu::started(FF, START);
    plain.step(0.0, 20.0);
    assert!(impacts > 3);
    for name in ["impacts.upper", "impacts.lower"] {
        assert_eq!(plain.get(name), solver.fmu.get(name), "{name}");
    }
    for (name, (a, b)) in MOTION.iter().zip(plain.motion().into_iter().zip(solver.states())) {
        assert!((a - b).abs() < RULE, "{name}: {a} {b}");
    }
}

#[test]
fn names_of_the_structure_are_its_vectors() {
    let solver = Solver::new(START);
    solver.put(0.125, &[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
    let derivatives = ["der(box.s)", "der(block.s)", "der(secondary.s)", "box.a", "block.a", "secondary.a"];
    assert_eq!(derivatives.map(|name| solver.fmu.get(name)), solver.rates());
    let indicators = ["stop.indicator.upper", "stop.indicator.lower", "stop.indicator.rest"];
    assert_eq!(indicators.map(|name| solver.fmu.get(name)), solver.indicators());
    assert_eq!(MOTION.map(|name| solver.fmu.get(name)), solver.states());
    let (mut states, mut indicators) = (0, 0);
    // SAFETY: one of each.
    unsafe {
        assert_eq!(fmi3GetNumberOfContinuousStates(solver.fmu.c, &mut states), OK);
        assert_eq!(fmi3GetNumberOfEventIndicators(solver.fmu.c, &mut indicators), OK);
    }
    assert_eq!((states, indicators), (6, 3));
    let mut nominals = [0.0; 6];
    // SAFETY: six elements.
    assert_eq!(unsafe { fmi3GetNominalsOfContinuousStates(solver.fmu.c, nominals.as_mut_ptr(), 6) }, OK);
    assert!(nominals.iter().all(|x| *x > 0.0));
}

/// Values read between events depend on time, states and inputs, and not on earlier calls.
#[test]
fn invariant_values_do_not_depend_on_the_order_of_calls() {
    let solver = Solver::new(START);
    let points = [(0.1, 0.3), (0.2, -0.4), (0.05, 0.1), (0.3, 0.0)];
    let read = |(time, s): (f64, f64)| {
        solver.put(time, &[0.1 * s, s, -s, s, 2.0 * s, 0.5]);
        (
            solver.rates().map(f64::to_bits),
            solver.indicators().map(f64::to_bits),
            solver.fmu.get("box.a").to_bits(),
        )
    };
    let there = points.map(read);
    let mut back = points;
    back.reverse();
    let mut back = back.map(read);
    back.reverse();
    assert_eq!(there, back);
}

#[test]
fn states_that_no_motion_has_are_discarded() {
    let solver = Solver::new(START);
    let good = [0.0, 0.5, 0.0, 0.0, 0.5, 0.0];
    solver.put(0.1, &good);
    for (i, value) in [(0, f64::NAN), (3, f64::INFINITY), (1, 100.0), (1, -100.0)] {
        let mut bad = good;
        bad[i] = value;
        // SAFETY: six elements.
        assert_eq!(unsafe { fmi3SetContinuousStates(solver.fmu.c, bad.as_ptr(), 6) }, DISCARD, "{value}");
        assert_eq!(solver.states(), good);
    }
    // A solver that searches across an event goes slightly beyond the stop.
    solver.put(0.1, &[0.0, 1.5, 0.0, 0.0, 0.5, 0.0]);
}

/// In Event Mode: inputs, tunable parameters and the states that events do not change (FMI 3.0.2,
/// 2.3.5); time only if unchanged.
#[test]
fn what_may_be_set_in_event_mode() {
    let fmu = Fmu::exchange();
    fmu.initialize();
    for (name, value) in
        [("box.f", 0.1), ("drive.amplitude", 0.2), ("secondary.s", 0.3), ("secondary.v", -0.3)]
    {
        assert_eq!(fmu.set(name, value), OK, "{name}: {}", fmu.last());
        assert_eq!(fmu.get(name), value);
    }
    // SAFETY: a live instance.
    assert_eq!(unsafe { fmi3SetTime(fmu.c, 0.0) }, OK);
    let state = fmu.save();
    for name in ["box.s", "box.v", "block.s", "block.v"] {
        assert_eq!(fmu.set(name, 0.1), ERROR, "{name}");
        // SAFETY: its own state.
        assert_eq!(unsafe { fmi3SetFMUState(fmu.c, state) }, OK);
    }
    // SAFETY: a live instance.
    assert_eq!(unsafe { fmi3SetTime(fmu.c, 0.5) }, ERROR);
}

/// fmpy and others set an input in Event Mode before the update: a resting contact is released
/// there.
#[test]
fn an_input_set_at_an_event_takes_part_in_it() {
    let fmu = Fmu::exchange();
    for (name, value) in [("block.s", 1.0), ("block.f", 5.0)] {
        assert_eq!(fmu.set(name, value), OK);
    }
    fmu.initialize();
    fmu.update();
    assert_eq!(fmu.get("stop.state"), 2.0);
    assert_eq!(fmu.set("block.f", -5.0), OK);
    assert_eq!(fmu.get("stop.state"), 1.0, "shown");
    fmu.update();
    assert_eq!(fmu.get("stop.state"), 1.0);
}
