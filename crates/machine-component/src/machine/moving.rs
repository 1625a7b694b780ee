//! A motion, with the values that a host reads from it.

use crate::plan::Plan;
use crate::problem::MachineProblem;
use crate::problem::refused;
use crate::table::{Energy, Quantity};
use crate::units::{friction_state, slider_state, stop_state};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use vibro_machine::energy::Accounts;
use vibro_machine::mode::StopState;
use vibro_machine::motion::{Course, Event, Hybrid, StopRecord};
use vibro_machine::signals::Input;
use vibro_machine::system::Part;
use vibro_machine::{Assembly, Error, Motion};

/// A motion, with the reference of its energy balance.
#[derive(Clone, Debug)]
pub struct Moving {
    pub(super) motion: Motion,
    /// The mechanical energy that the motion would have without work and losses, J. A changed
    /// prescribed motion or parameter may stretch springs at once; the energy that this adds is
    /// included.
    pub(super) origin: f64,
    /// The last point of a host's solver, in Model Exchange.
    pub(super) course: Option<Course>,
    /// Values of the machine's parameters.
    numbers: Arc<Vec<f64>>,
}

/// A motion in a saved state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SavedMoving {
    hybrid: Hybrid,
    origin: f64,
    pub(super) course: Option<Course>,
    numbers: Vec<f64>,
}

impl Moving {
    /// Creates a motion that begins in a machine with these numbers.
    pub(super) fn new(motion: Motion, numbers: Vec<f64>) -> Self {
        let mut moving = Self { motion, origin: 0.0, course: None, numbers: Arc::new(numbers) };
        moving.origin = moving.unaccounted();
        moving
    }

    pub(super) fn save(&self) -> SavedMoving {
        let Self { motion, origin, course, numbers } = self;
        SavedMoving {
            hybrid: motion.save(),
            origin: *origin,
            course: course.clone(),
            numbers: numbers.to_vec(),
        }
    }

    /// Restores a saved motion of a plan's machine; reuses the tables of `present` if possible.
    pub(super) fn resumed(
        present: Option<&Self>,
        plan: &Plan,
        saved: &SavedMoving,
    ) -> Result<Self, MachineProblem> {
        let SavedMoving { hybrid, origin, course, numbers } = saved;
        let unfit = || refused("its motion is from another machine");
        let same = present.filter(|moving| *moving.numbers == *numbers);
        if numbers.len() != plan.table.parameters.len() || !origin.is_finite() {
            return Err(unfit().into());
        }
        let mut motion = match same {
            Some(moving) if hybrid.fits(moving.motion.assembly()) => {
                let mut motion = moving.motion.clone();
                motion.restore(hybrid);
                motion
            }
            Some(_) => return Err(unfit().into()),
            None => Motion::resumed(plan.machine(numbers, true)?, hybrid).ok_or_else(unfit)?,
        };
        if let Some(course) = course {
            if !course.fits(motion.assembly()) {
                return Err(unfit().into());
            }
            motion.resume_course();
        }
        Ok(Self { motion, origin: *origin, course: course.clone(), numbers: Arc::new(numbers.clone()) })
    }

    /// Hands the motion over to a host's solver.
    pub(super) fn begin_course(&mut self) -> Result<(), Error> {
        self.course = Some(self.motion.begin_course()?);
        Ok(())
    }

    pub(super) fn is_on_course(&self) -> bool {
        self.course.is_some()
    }

    fn accounts(&self) -> Accounts {
        match &self.course {
            Some(course) => self.motion.energy_on(course),
            None => self.motion.energy().clone(),
        }
    }

    /// Mechanical energy minus work plus losses.
    fn unaccounted(&self) -> f64 {
        let (kinetic, stored) = self.motion.kinetic_and_stored();
        kinetic + stored - self.accounts().balance()
    }

    /// Sets the given inputs.
    pub(super) fn set_inputs(&mut self, inputs: &[Option<Input>]) -> Result<(), Error> {
        if inputs.iter().all(Option::is_none) {
            return Ok(());
        }
        // Without prescribed motions no input changes the energy at once.
        let moves = self.jumps();
        let residual = if moves { self.unaccounted() - self.origin } else { 0.0 };
        // Set all at once: bodies that touch may jump together.
        let given = inputs.iter().enumerate().filter_map(|(i, input)| Some((i, (*input)?)));
        let new: Vec<(usize, Input)> = given.filter(|(i, input)| *input != self.motion.input(*i)).collect();
        match &mut self.course {
            Some(course) => self.motion.set_inputs_on(course, &new)?,
            None => self.motion.set_inputs(&new)?,
        }
        if moves {
            self.origin = self.unaccounted() - residual;
        }
        Ok(())
    }

    /// Continues in a machine with changed numbers.
    pub(super) fn change(&mut self, assembly: Arc<Assembly>, numbers: Vec<f64>) -> Result<(), Error> {
        let residual = self.unaccounted() - self.origin;
        self.motion = match &mut self.course {
            Some(course) => self.motion.changed_on(course, assembly)?,
            None => self.motion.changed(assembly)?,
        };
        self.numbers = Arc::new(numbers);
        self.origin = self.unaccounted() - residual;
        Ok(())
    }

    /// Sets the states with these indices among the assembly's states.
    pub(super) fn set_states(&mut self, places: &[usize], states: &[f64]) {
        let mut all = self.motion.states();
        if places.len() == all.len() {
            return self.motion.set_states(states);
        }
        places.iter().zip(states).for_each(|(&place, state)| all[place] = *state);
        self.motion.set_states(&all);
    }

    /// Sets an input that a host's solver sees at once.
    pub(super) fn set_input_on_course(&mut self, i: usize, value: f64) {
        let residual = self.unaccounted() - self.origin;
        if let Some(course) = &mut self.course {
            self.motion.set_input_on(course, i, value);
        }
        self.origin = self.unaccounted() - residual;
    }

    /// Accepts a point of a host's solver; returns whether an event was passed.
    pub(super) fn accept(&mut self) -> bool {
        self.course.as_mut().is_some_and(|course| self.motion.accept(course))
    }

    /// Whether an event is pending.
    pub(super) fn is_event_due(&self) -> bool {
        match &self.course {
            Some(course) => self.motion.is_event_due_on(course),
            None => self.motion.is_event_due(),
        }
    }

    /// Whether there are prescribed bodies, which an input set at an event may make jump. Without
    /// them a host's solver sees the input at once.
    pub(super) fn jumps(&self) -> bool {
        self.motion.assembly().system().has_motions
    }

    /// Applies the law of an event; returns whether a solver has to restart.
    pub(super) fn handle(&mut self, observer: &mut dyn FnMut(&Event)) -> Result<bool, Error> {
        match &mut self.course {
            Some(course) => self.motion.handle_on(course, observer),
            None => self.motion.apply_event(observer).map(|()| true),
        }
    }

    /// Returns the values that change only at events.
    pub(super) fn discrete(&self) -> Shown {
        let mode = self.motion.mode();
        let stop = |i: usize| {
            let StopRecord { count, impulse } = self.motion.impacts(i);
            (stop_state(self.motion.stop_state(i)), count as f64, impulse)
        };
        Shown {
            stops: (0..mode.stops.len()).map(stop).collect(),
            frictions: mode.frictions.iter().copied().map(friction_state).collect(),
            lines: (0..self.motion.assembly().description.springs.len()).map(|i| self.line(i)).collect(),
            sliders: mode.sliders.iter().copied().map(slider_state).collect(),
            samples: self.motion.kept_by_samples(),
        }
    }

    /// Returns the number of corners that a spring has passed.
    fn line(&self, spring: usize) -> f64 {
        let (system, mode) = (self.motion.assembly().system(), self.motion.mode());
        let passed = |part: &&Part| matches!(part, Part::Stop(i) if mode.stops[*i] == StopState::Pressed);
        system.parts[spring].iter().filter(passed).count() as f64
    }

    /// Returns a value that is read from the motion; 0 for other quantities.
    pub(super) fn value(&self, quantity: Quantity) -> f64 {
        let motion = &self.motion;
        match quantity {
            Quantity::Energy(energy) => self.energy(energy),
            Quantity::StopState(i) => stop_state(motion.stop_state(i)),
            Quantity::Impacts(i) => motion.impacts(i).count as f64,
            Quantity::Impulse(i) => motion.impacts(i).impulse,
            Quantity::FrictionState(i) => friction_state(motion.mode().frictions[i]),
            Quantity::Line(i) => self.line(i),
            Quantity::SliderState(i) => slider_state(motion.mode().sliders[i]),
            Quantity::Indicator(i) => motion.indicators()[i],
            Quantity::Column(column) => motion.value(column),
            Quantity::Time
            | Quantity::Parameter(_)
            | Quantity::Following(_)
            | Quantity::Input(_)
            | Quantity::Transition
            | Quantity::Response
            | Quantity::ByParameters => 0.0,
        }
    }

    fn energy(&self, energy: Energy) -> f64 {
        let work =
            |accounts: &Accounts| accounts.loads.iter().fold(accounts.motions, |sum, x| sum + *x).value();
        match energy {
            Energy::Kinetic => self.motion.kinetic_and_stored().0,
            Energy::Stored => self.motion.kinetic_and_stored().1,
            Energy::Work => work(&self.accounts()),
            Energy::Lost => {
                let accounts = self.accounts();
                work(&accounts) + accounts.switched.value() - accounts.balance()
            }
            Energy::Switched => self.accounts().switched.value(),
            Energy::Residual => self.unaccounted() - self.origin,
        }
    }
}

/// The values that change only at events, as a host sees them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shown {
    /// State, number of impacts and last impulse of each stop.
    pub(super) stops: Vec<(f64, f64, f64)>,
    /// State of each friction element.
    pub(super) frictions: Vec<f64>,
    /// Number of passed corners of each spring.
    pub(super) lines: Vec<f64>,
    /// State of each spring in series.
    pub(super) sliders: Vec<f64>,
    /// States and outputs of sampled blocks.
    pub(super) samples: Vec<f64>,
}

impl Shown {
    /// Whether the numbers of all elements agree.
    pub(super) fn has_the_shape_of(&self, other: &Self) -> bool {
        let counts =
            |shown: &Self| [&shown.frictions, &shown.lines, &shown.sliders, &shown.samples].map(Vec::len);
        self.stops.len() == other.stops.len() && counts(self) == counts(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAIR: &str = "name = \"Pair\"\n[body.a]\nmass = 2.0\nstart = { s = 0.1 }\n[spring.k]\nbetween = [\"ground\", \"a\"]\n\
        stiffness = 9.0\n[load.push]\non = \"a\"\ninput = true\n";

    fn moving(plan: &Plan) -> Moving {
        let numbers: Vec<f64> = plan.table.parameters.iter().map(|parameter| parameter.value).collect();
        let motion = Motion::new(plan.machine(&numbers, false).unwrap()).unwrap();
        let mut moving = Moving::new(motion, numbers);
        moving.motion.advance_to(0.5).unwrap();
        moving
    }

    #[test]
    fn a_saved_motion_is_resumed_where_each_part_fits_and_refused_otherwise() {
        let plan = Plan::new(PAIR.into(), crate::plan::FILE).unwrap();
        let own = moving(&plan);
        let saved = own.save();
        let mut other_numbers = saved.clone();
        other_numbers.numbers[0] += 1e-3;
        for present in [None, Some(&own)] {
            for fit in [&saved, &other_numbers] {
                let resumed = Moving::resumed(present, &plan, fit).unwrap();
                assert_eq!(&resumed.save(), fit);
            }
            let refused = |change: &dyn Fn(&mut SavedMoving)| {
                let mut wrong = saved.clone();
                change(&mut wrong);
                Moving::resumed(present, &plan, &wrong).is_err()
            };
            assert!(
                refused(&|wrong| wrong.origin = f64::NAN) && refused(&|wrong| wrong.origin = f64::INFINITY)
            );
            assert!(refused(&|wrong| _ = wrong.numbers.pop()) && refused(&|wrong| wrong.numbers.push(1.0)));
            let second = format!(
                "{PAIR}[body.b]\nmass = 1.0\n[spring.b]\nbetween = [\"a\", \"b\"]\nstiffness = 1.0\n"
            );
            let larger = moving(&Plan::new(second, crate::plan::FILE).unwrap()).save();
            assert!(refused(&|wrong| wrong.hybrid = larger.hybrid.clone()), "another machine's");
        }
    }

    /// The energy at the start, whatever its value, is the origin of the balance.
    #[test]
    fn invariant_the_energy_of_a_start_is_no_residual() {
        let own = moving(&Plan::new(PAIR.into(), crate::plan::FILE).unwrap());
        // ½ · 9 · 0.1².
        let stored =
            own.value(Quantity::Energy(Energy::Stored)) + own.value(Quantity::Energy(Energy::Kinetic));
        assert!(
            (stored - 0.045).abs() < 1e-12 && own.value(Quantity::Energy(Energy::Residual)).abs() < 1e-12
        );
    }
}
