//! Described machines as [`design_sweep::DesignMachine`]s.

use super::measures::need_accounts;
use super::oscillations::oscillations;
use super::timescales::settle;
use super::{Machine, Measure, Start, measure};
use crate::design_sweep::{self, MotionMeasures, SweepRequest, failed};
use crate::error::Result;
use crate::measured::{Measured, unsettled_in_words};
use vibro_machine::Assembly;

impl design_sweep::DesignMachine for Machine {
    type Name = String;
    type Start = Start;
    type Measure = Measure;
    const PART: usize = 64;
    const AGAIN: u64 = 300_000;

    fn name(name: &String) -> String {
        name.clone()
    }

    fn is_same_quantity(a: &String, b: &String) -> bool {
        a == b
    }

    fn with_unit(&self, name: &String, value: f64) -> String {
        self.told(name, value)
    }

    fn varied(&self, values: &[(String, f64)]) -> Result<Self> {
        self.with(values.iter().map(|(name, value)| (name.as_str(), *value)))
    }

    fn outcomes(&self, request: &SweepRequest<Self>) -> Vec<MotionMeasures> {
        let one = |start: &Start| -> Result<_> {
            let (mut motion, section) = self.motion(start)?;
            if !need_accounts(&request.measures) {
                motion = motion.without_energy_accounts();
            }
            settle(&mut motion, &section, request.discard)?;
            measure(&mut motion, &section, &request.measures, request.periods)
        };
        let told = |found: Measured| {
            let reason = unsettled_in_words(&found, &request.measures);
            (found, reason)
        };
        let outcome = |start| one(start).map_or_else(|e| failed(&e, request.measures.len()), told);
        request.starts.iter().map(outcome).collect()
    }

    fn spread_starts(_: u32) -> Vec<Start> {
        Vec::new()
    }

    fn is_of_window(measure: &Measure) -> bool {
        measure.is_of_window()
    }

    fn resonances(&self, name: &String) -> Vec<f64> {
        if self.si_unit(name) != "Hz" {
            return Vec::new();
        }
        let assembly = Assembly::new(self.description.clone());
        assembly.map_or(Vec::new(), |assembly| oscillations(assembly.system()))
    }
}
