//! Columns of the bifurcation diagram: the settled motion at one value of a parameter.

use crate::machine::state_of;
use crate::set::Set;
use vibro_impact::simulator::{Event, Simulator};
use vibro_impact::{Parameters, Result, State};
use vibro_studies::paper::lyapunov::{SpectrumOptions, dimensionless};
use vibro_studies::paper::maxima::{Displacement, record_periods};
use vibro_studies::paper::{Name, ParameterSet};
use wasm_bindgen::prelude::*;

/// Quantity shown by a column.
#[derive(Clone, Copy, Debug)]
enum Ordinate {
    /// Local maxima of a displacement, units of L.
    Maxima(Displacement),
    /// The displacement of the block at whole drive periods, units of L.
    Stroboscopic,
    /// Approach speeds of the impacts, negative at the lower stop, units of L ω1.
    Speeds,
}

/// A varied parameter, and the quantity shown over it.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Columns {
    set: ParameterSet,
    name: Name,
    ordinate: Ordinate,
}

/// A state in units of L and L/s. In these units it stays between the stops if the gap changes.
fn scaled(state: &State, length: f64) -> [f64; 6] {
    let (x, v) = (state.x.map(|x| x / length), state.v.map(|v| v / length));
    [x[0], x[1], x[2], v[0], v[1], v[2]]
}

/// State in SI units from a state in units of L and L/s, with the block within the stops. Rounding
/// may have moved it past a stop by a few units in the last place.
fn within(numbers: &[f64], length: f64) -> State {
    let mut state = state_of(&numbers.iter().map(|x| x * length).collect::<Vec<_>>());
    let room = length * (1.0 - 1e-12);
    state.x[1] = state.x[0] + (state.x[1] - state.x[0]).clamp(-room, room);
    state
}

#[wasm_bindgen]
impl Columns {
    /// Columns over the parameter `name`. `shown` is `x1`, `x2`, `x3` or `w` (local maxima),
    /// `strobe` (x2 at whole drive periods) or `speed` (approach speeds of impacts).
    ///
    /// # Errors
    /// An error if a name is unknown.
    #[wasm_bindgen(constructor)]
    pub fn new(set: &Set, name: &str, shown: &str) -> std::result::Result<Columns, JsError> {
        let ordinate = match shown {
            "strobe" => Ordinate::Stroboscopic,
            "speed" => Ordinate::Speeds,
            other => Ordinate::Maxima(other.parse()?),
        };
        Ok(Self { set: set.0.clone(), name: Name::find(name)?, ordinate })
    }

    /// The settled motion at a parameter value. The motion begins at `start`, a state in units of
    /// L and L/s, and settles for `settle` drive periods. Returns the state at the end, six
    /// numbers in these units, followed by the shown numbers of `keep` further drive periods.
    ///
    /// # Errors
    /// An error if the value is out of range or the simulator stops with an error.
    pub fn column(
        &self,
        value: f64,
        start: &[f64],
        settle: u32,
        keep: u32,
    ) -> std::result::Result<Vec<f64>, JsError> {
        let parameters = *self.set.with(self.name, value)?.parameters();
        let mut simulator = self.settled(&parameters, start, settle)?;
        let mut shown = vec![0.0; 6];
        self.collect(&mut simulator, keep, &mut shown)?;
        shown[..6].copy_from_slice(&scaled(&simulator.state(), parameters.stop_gap));
        Ok(shown)
    }

    /// The two largest Lyapunov exponents of the settled motion that continues from the state
    /// `start`, over `periods` drive periods, per unit of the dimensionless time. For a periodic
    /// motion the largest is 0, the exponent of the drive's phase.
    ///
    /// # Errors
    /// As [`column`](Self::column).
    pub fn exponents(
        &self,
        value: f64,
        start: &[f64],
        periods: u32,
    ) -> std::result::Result<Vec<f64>, JsError> {
        let parameters = *self.set.with(self.name, value)?.parameters();
        let mut simulator = self.settled(&parameters, start, 0)?;
        let options = SpectrumOptions { align: periods / 5, periods, ..SpectrumOptions::default() };
        let found = dimensionless(&mut simulator, &options)?.spectrum.exponents;
        Ok(vec![found[0], found[1]])
    }
}

impl Columns {
    fn settled(&self, parameters: &Parameters, start: &[f64], settle: u32) -> Result<Simulator> {
        let state = within(start, parameters.stop_gap);
        let mut simulator = Simulator::new(parameters, &state, 0.0)?.without_energy_accounts();
        simulator.advance_to(f64::from(settle) * parameters.period())?;
        Ok(simulator)
    }

    /// Appends the shown numbers of the next `keep` drive periods.
    fn collect(&self, simulator: &mut Simulator, keep: u32, shown: &mut Vec<f64>) -> Result<()> {
        let (length, period) = (simulator.parameters().stop_gap, simulator.parameters().period());
        let (speed, begin) = (length * simulator.parameters().drive_frequency, simulator.time());
        match self.ordinate {
            Ordinate::Maxima(of) => record_periods(simulator, of, keep, &mut |record| {
                shown.extend(record.maxima.iter().map(|m| m.value / length));
            }),
            Ordinate::Stroboscopic => (1..=keep).try_for_each(|i| {
                simulator.advance_to(begin + f64::from(i) * period)?;
                shown.push(simulator.state().x[1] / length);
                Ok(())
            }),
            Ordinate::Speeds => simulator.advance_observed(begin + f64::from(keep) * period, &mut |event| {
                if let Event::Impact { side, speed: v, .. } = *event {
                    shown.push(f64::from(side) * v / speed);
                }
            }),
        }
    }
}
