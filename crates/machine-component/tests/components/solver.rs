//! A host's solver for machines as components: the fourth-order Runge-Kutta method, with events
//! found by bisection.

use fmi_doors::log::{Category, Log};
use fmi_doors::{Base, Bases, Component, EventHandling, Interface, Life, Model, Phase};
use std::sync::Arc;
use vibro_machine_component::{Machine, Plan, SavedState};

pub struct Silent;

impl Log for Silent {
    fn wants(&self, _: Category) -> bool {
        false
    }

    fn log(&mut self, _: Category, _: &str) {}
}

/// Bisections of a step in the search for an event.
const HALVINGS: usize = 40;
/// Iterations of the power method for the largest rate; the second half counts.
const TURNS: usize = 60;
/// Largest product of step and rate: two thirds of the stability limit, 2.8 on either axis.
const STABLE: f64 = 1.9;

/// A machine under the solver.
pub struct Solver {
    pub machine: Machine,
    pub time: f64,
    /// The longest step for which the fastest motion of the machine at its start stays bounded, s.
    longest: f64,
}

impl Solver {
    pub fn instance(plan: &Arc<Plan>, interface: Interface) -> Machine {
        Machine::new(plan.clone(), Life::new(interface, EventHandling::default()))
    }

    pub fn new(plan: &Arc<Plan>) -> Self {
        let mut machine = Self::instance(plan, Interface::ModelExchange);
        machine.set_experiment(None, 0.0, None).unwrap();
        machine.enter_initialization();
        machine.exit_initialization(&mut Silent).unwrap();
        let mut solver = Self { machine, time: 0.0, longest: f64::INFINITY };
        solver.handle();
        solver.longest = solver.longest_step();
        solver
    }

    /// [`STABLE`] over the largest rate of the states, by the power method on their slopes.
    fn longest_step(&mut self) -> f64 {
        let (from, norm) = (self.states(), |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt());
        let here = self.slope(0.0, &from);
        let (mut along, mut growth) = (vec![1.0; from.len()], 0.0);
        for turn in 0..TURNS {
            let size = norm(&along).max(f64::MIN_POSITIVE);
            along.iter_mut().for_each(|x| *x /= size);
            let beside: Vec<f64> = from.iter().zip(&along).map(|(x, v)| x + v).collect();
            let there = self.slope(0.0, &beside);
            along = there.iter().zip(&here).map(|(a, b)| a - b).collect();
            growth += if turn < TURNS / 2 { 0.0 } else { norm(&along).max(f64::MIN_POSITIVE).ln() };
        }
        self.put(0.0, &from);
        STABLE / (growth / (TURNS - TURNS / 2) as f64).exp()
    }

    fn handle(&mut self) {
        self.machine.enter_event().unwrap();
        self.machine.handle_events(&mut Silent).unwrap();
        self.machine.enter_continuous().unwrap();
    }

    fn states(&self) -> Vec<f64> {
        self.machine.continuous_states().unwrap().as_ref().to_vec()
    }

    fn put(&mut self, time: f64, states: &[f64]) {
        self.machine.set_time(time).unwrap();
        self.machine.set_continuous_states(states).unwrap();
    }

    fn slope(&mut self, time: f64, states: &[f64]) -> Vec<f64> {
        self.put(time, states);
        self.machine.state_derivatives().unwrap().as_ref().to_vec()
    }

    /// Whether an event has been passed.
    fn is_past(&self) -> bool {
        self.machine.event_indicators().unwrap().as_ref().iter().any(|z| *z <= 0.0)
    }

    fn go(&mut self, from: &[f64], h: f64) {
        let along =
            |x: &[f64], k: &[f64], h: f64| -> Vec<f64> { x.iter().zip(k).map(|(x, k)| x + h * k).collect() };
        let t = self.time;
        let a = self.slope(t, from);
        let b = self.slope(t + 0.5 * h, &along(from, &a, 0.5 * h));
        let c = self.slope(t + 0.5 * h, &along(from, &b, 0.5 * h));
        let d = self.slope(t + h, &along(from, &c, h));
        let mean = |k: usize| (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]) / 6.0;
        let mean: Vec<f64> = (0..a.len()).map(mean).collect();
        self.put(t + h, &along(from, &mean, h));
    }

    /// Makes a step of `h`, or of the longest stable step, or up to the next event, whose law is
    /// then applied.
    pub fn step(&mut self, h: f64) {
        let h = h.min(self.longest);
        let from = self.states();
        let knot = self.machine.next_event_time().filter(|knot| *knot <= self.time + h);
        let mut length = knot.map_or(h, |knot| knot - self.time);
        self.go(&from, length);
        if self.is_past() {
            let mut before = 0.0;
            for _ in 0..HALVINGS {
                let middle = 0.5 * (before + length);
                self.go(&from, middle);
                *(if self.is_past() { &mut length } else { &mut before }) = middle;
            }
            self.go(&from, length);
        }
        self.time += length;
        if knot == Some(self.time) || knot.is_some_and(|knot| (knot - self.time).abs() < 1e-15) {
            self.time = knot.unwrap_or(self.time);
            let now = self.states();
            self.put(self.time, &now);
        }
        if self.machine.complete_integrator_step().unwrap() {
            self.handle();
        }
    }

    /// Restores a state that was saved between events.
    pub fn restore(&mut self, saved: &SavedState) {
        self.machine.restore(saved).unwrap();
        assert_eq!(self.machine.life().phase, Phase::Continuous);
    }
}

/// A variable's value of any type; `None` if it cannot be read.
pub fn get(machine: &mut Machine, reference: u32) -> Option<f64> {
    let mut value = f64::NAN;
    machine.get(Bases::ANY, &[reference], |_, x| value = x).ok()?;
    Some(value)
}

pub fn set(machine: &mut Machine, reference: u32, value: f64) -> bool {
    machine.set(Bases::new("Real", &[Base::Real]), &[reference], |_| value).is_ok()
}
