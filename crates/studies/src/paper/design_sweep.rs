//! The paper's machine as a [`DesignMachine`].

use super::measures::{Measure, amplitude_without_block, is_of_window, measure};
use super::parameter_set::{Name, ParameterSet};
use super::start::StartRule;
use crate::design_sweep::{DesignMachine, MotionMeasures, SweepRequest};
use crate::error::{Error, Result};
use crate::measured::{Measured, unsettled_in_words};
use crate::sobol::coordinate;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::Simulator;

impl DesignMachine for ParameterSet {
    type Name = Name;
    type Start = StartRule;
    type Measure = Measure;
    const PART: usize = 1024;
    const AGAIN: u64 = 5_000_000;

    fn name(name: &Name) -> String {
        name.name().into()
    }

    fn is_same_quantity(a: &Name, b: &Name) -> bool {
        a.is_same_quantity(*b)
    }

    fn with_unit(&self, name: &Name, value: f64) -> String {
        self.with_unit(*name, value)
    }

    fn varied(&self, values: &[(Name, f64)]) -> Result<Self> {
        let mut own = self.clone();
        own.assign(values)?;
        Ok(own)
    }

    fn outcomes(&self, request: &SweepRequest<ParameterSet>) -> Vec<MotionMeasures> {
        from_all_starts(self.parameters(), request)
    }

    fn spread_starts(count: u32) -> Vec<StartRule> {
        spread_starts(count)
    }

    fn is_of_window(measure: &Measure) -> bool {
        is_of_window(measure)
    }

    /// Natural frequency of the box alone on its spring.
    fn resonances(&self, name: &Name) -> Vec<f64> {
        let is_drive = Name::find("drive.frequency").is_ok_and(|drive| drive == *name);
        if is_drive { vec![self.parameters().box_frequency()] } else { Vec::new() }
    }
}

/// Measures of the motions of one machine, which share the simulator's tables.
fn from_all_starts(p: &Parameters, request: &SweepRequest<ParameterSet>) -> Vec<MotionMeasures> {
    let mut shared: Option<Simulator> = None;
    // A closed form without a value is reported even if there is a motion.
    let asked = request.measures.contains(&Measure::AmplitudeWithoutBlock);
    let gap = asked.then(|| amplitude_without_block(p).err().map(|e| e.to_string())).flatten();
    let outcome = |start: &StartRule| {
        let found = one(p, *start, request, &mut shared);
        let refused = |error: Error| (without_motion(p, &request.measures), Some(error.to_string()));
        found.map_or_else(refused, |measured| {
            let unsettled = unsettled_in_words(&measured, &request.measures);
            (measured, gap.clone().or(unsettled))
        })
    };
    request.starts.iter().map(outcome).collect()
}

/// Measures of a machine that need no motion: closed forms.
fn without_motion(p: &Parameters, measures: &[Measure]) -> Measured {
    let number = |m: &Measure| match m {
        Measure::AmplitudeWithoutBlock => amplitude_without_block(p).ok(),
        _ => None,
    };
    let spreads = vec![0.0; measures.len()];
    Measured { numbers: measures.iter().map(number).collect(), spreads, ..Measured::default() }
}

/// Measures of one motion after it has settled.
fn one(
    p: &Parameters,
    start: StartRule,
    request: &SweepRequest<ParameterSet>,
    shared: &mut Option<Simulator>,
) -> Result<Measured> {
    let state = start.state(p)?;
    let mut simulator = match shared {
        Some(other) => other.with_state(&state, 0.0)?,
        None => {
            let new = Simulator::new(p, &state, 0.0)?;
            let keeps = request.measures.contains(&Measure::PowerInput);
            let new = if keeps { new } else { new.without_energy_accounts() };
            shared.insert(new).clone()
        }
    };
    if p.drive_frequency > 0.0 {
        simulator.advance_to(f64::from(request.discard) * p.period())?;
    }
    measure(&mut simulator, &request.measures, request.periods)
}

/// Starts spread evenly: |x1| and |x3| up to 2 L, |w| up to L, the velocities up to 2 L ω10. The
/// starts are points of the Sobol sequence, the same in every sweep. The sequence's first two
/// points are left out; the second one is the machine at rest.
pub fn spread_starts(count: u32) -> Vec<StartRule> {
    const REACH: f64 = 2.0;
    let start = |index: u32| {
        let [x1, w, x3, v1, v2, v3]: [f64; 6] = std::array::from_fn(|d| 2.0 * coordinate(index, d) - 1.0);
        let state = [REACH * x1, REACH * x1 + w, REACH * x3, REACH * v1, REACH * v2, REACH * v3];
        StartRule::scaled(state)
    };
    (2..count.saturating_add(2)).map(start).collect()
}
