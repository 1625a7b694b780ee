//! Getting, setting and serializing the complete FMU state (FMI 2.0, 2.1.8).

use super::{Engine, Experiment, Instance, Outcome};
use crate::fmi2::bytes;
use crate::fmi2::closed_form::{self, ClosedForm};
use crate::fmi2::continuous::{self, Continuous};
use crate::fmi2::problem::Problem;
use crate::fmi2::settings::Settings;
use crate::fmi2::states::{Function, Interface, State};
use serde::{Deserialize, Serialize};
use vibro_impact::simulator::{Simulator, Snapshot};

/// First bytes of a serialized state.
const MAGIC: [u8; 8] = *b"VIBROFMU";
/// Version of the bytes that follow.
const VERSION: u32 = 2;

/// Everything an instance needs to continue: its place in the state machine, what was set, and what moves. Log settings
/// and name are the instance's own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FmuState {
    /// The GUID's number: which table and crate version the state belongs to.
    origin: [u8; 16],
    interface: Interface,
    state: State,
    settings: Settings,
    experiment: Option<Experiment>,
    slopes_set: [bool; 3],
    parameters_set: bool,
    loads_set: bool,
    engine: EngineState,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)] // saved states are boxed as a whole
enum EngineState {
    None,
    Simulation(Snapshot),
    Closed(closed_form::Data),
    Continuous(continuous::Data),
}

/// What comes before the state.
#[derive(Serialize, Deserialize)]
struct Header {
    magic: [u8; 8],
    version: u32,
}

impl FmuState {
    /// `fmi2SerializeFMUstate` (FMI 2.0, 2.1.8): header, state, checksum, all little-endian.
    ///
    /// # Errors
    /// [`Problem::Memory`], which would be a mistake of ours.
    pub fn serialize(&self) -> Outcome<Vec<u8>> {
        let mut out = Vec::with_capacity(1024);
        let written = bytes::write(&Header { magic: MAGIC, version: VERSION }, &mut out)
            .and_then(|()| bytes::write(self, &mut out));
        written.map_err(|error| refused(error.to_string()))?;
        let checksum = bytes::checksum(&out);
        out.extend_from_slice(&checksum.to_le_bytes());
        Ok(out)
    }
}

fn refused(what: String) -> Problem {
    Problem::Memory { what }
}

impl Instance {
    /// `fmi2GetFMUstate` (FMI 2.0, 2.1.8).
    ///
    /// # Errors
    /// [`Problem::State`].
    pub fn fmu_state(&self) -> Outcome<FmuState> {
        self.guard(Function::GetFMUstate)?;
        Ok(self.image())
    }

    /// All that [`fmu_state`](Self::fmu_state) saves.
    pub(crate) fn image(&self) -> FmuState {
        FmuState {
            origin: self.origin,
            interface: self.interface,
            state: self.state,
            settings: self.settings,
            experiment: self.experiment,
            slopes_set: self.slopes_set,
            parameters_set: self.parameters_set,
            loads_set: self.loads_set,
            engine: match &self.engine {
                Engine::None => EngineState::None,
                Engine::Simulation(simulator) => EngineState::Simulation(simulator.snapshot()),
                Engine::Closed(form) => EngineState::Closed(form.data()),
                Engine::Continuous(continuous) => EngineState::Continuous(continuous.data()),
            },
        }
    }

    /// `fmi2SetFMUstate` (FMI 2.0, 2.1.8); also into an instance that was never initialized.
    ///
    /// # Errors
    /// [`Problem::Memory`] for a state of the other interface type, [`Problem::Model`] for one that is not possible;
    /// nothing has changed then.
    pub fn set_fmu_state(&mut self, saved: &FmuState) -> Outcome {
        self.guard(Function::SetFMUstate)?;
        if saved.interface != self.interface {
            return Err(refused(format!(
                "it is of {}, this instance is of {}",
                saved.interface.name(),
                self.interface.name()
            )));
        }
        match (&mut self.engine, &saved.engine) {
            (engine, EngineState::None) => *engine = Engine::None,
            (Engine::Simulation(simulator), EngineState::Simulation(snapshot)) => {
                simulator.restore(snapshot)?;
            }
            (engine, EngineState::Simulation(snapshot)) => {
                // Any valid simulator does: the snapshot brings its own parameters and state.
                let standard = Settings::default();
                let mut simulator = Simulator::new(&standard.parameters, &standard.start, 0.0)?;
                simulator.restore(snapshot)?;
                *engine = Engine::Simulation(Box::new(simulator));
            }
            (Engine::Closed(form), EngineState::Closed(data)) => form.restore(*data)?,
            (engine, EngineState::Closed(data)) => {
                *engine = Engine::Closed(Box::new(ClosedForm::of(*data)?));
            }
            (Engine::Continuous(continuous), EngineState::Continuous(data)) => continuous.restore(*data)?,
            (engine, EngineState::Continuous(data)) => {
                *engine = Engine::Continuous(Box::new(Continuous::of(*data)?));
            }
        }
        self.state = saved.state;
        self.derived_stale |= self.settings.parameters != saved.settings.parameters;
        self.settings = saved.settings;
        self.experiment = saved.experiment;
        self.slopes_set = saved.slopes_set;
        self.parameters_set = saved.parameters_set;
        self.loads_set = saved.loads_set;
        self.motion_stale = true;
        Ok(())
    }

    /// `fmi2DeSerializeFMUstate` (FMI 2.0, 2.1.8).
    ///
    /// # Errors
    /// [`Problem::Memory`] for bytes that are truncated, altered, of another version or of another FMU.
    pub fn deserialize(&self, serialized: &[u8]) -> Outcome<FmuState> {
        self.guard(Function::DeSerializeFMUstate)?;
        let Some((content, checksum)) = serialized.split_last_chunk::<8>() else {
            return Err(refused(format!("{} bytes are too few", serialized.len())));
        };
        let (header, rest) = bytes::read::<Header>(content).map_err(|error| refused(error.to_string()))?;
        if header.magic != MAGIC {
            return Err(refused("the bytes are not of this FMU".to_owned()));
        }
        if header.version != VERSION {
            return Err(refused(format!("version {}: allowed is {VERSION}", header.version)));
        }
        if bytes::checksum(content) != u64::from_le_bytes(*checksum) {
            return Err(refused("the checksum does not fit: truncated or altered".to_owned()));
        }
        if !rest.starts_with(&self.origin) {
            return Err(refused("it comes from another build of this FMU (its GUID differs)".to_owned()));
        }
        match bytes::read::<FmuState>(rest).map_err(|error| refused(error.to_string()))? {
            (state, []) => Ok(state),
            (_, left) => Err(refused(format!("{} bytes too many", left.len()))),
        }
    }

    /// Keeps a state for the host, in the place of `handle` where that is one of ours, and returns its handle. Handles are
    /// looked up, never followed, so a wrong one is an error and not a crash.
    ///
    /// # Errors
    /// [`Problem::Memory`] for a handle that is neither zero nor ours.
    pub fn keep(&mut self, state: FmuState, handle: usize) -> Outcome<usize> {
        if handle != 0 {
            let place = self.place(handle)?;
            *self.kept[place] = state;
            return Ok(handle);
        }
        let kept = Box::new(state);
        let handle = address(&kept);
        self.kept.push(kept);
        Ok(handle)
    }

    /// As [`keep`](Self::keep), but any handle that is not ours stands for none: what a host has in a variable that is
    /// only written to may be anything.
    ///
    /// # Errors
    /// None.
    pub fn keep_new(&mut self, state: FmuState, handle: usize) -> Outcome<usize> {
        let known = self.place(handle).is_ok();
        self.keep(state, if known { handle } else { 0 })
    }

    /// The state of that handle.
    ///
    /// # Errors
    /// [`Problem::Memory`] when there is none.
    pub fn kept(&self, handle: usize) -> Outcome<&FmuState> {
        Ok(&self.kept[self.place(handle)?])
    }

    /// Bytes of the state of that handle.
    ///
    /// # Errors
    /// As [`kept`](Self::kept).
    pub fn serialized(&self, handle: usize) -> Outcome<Vec<u8>> {
        self.kept(handle)?.serialize()
    }

    /// `fmi2SetFMUstate` by handle.
    ///
    /// # Errors
    /// As [`kept`](Self::kept) and [`set_fmu_state`](Self::set_fmu_state).
    pub fn restore_kept(&mut self, handle: usize) -> Outcome {
        self.guard(Function::SetFMUstate)?;
        let place = self.place(handle)?;
        // Taken out and put back: the state is not part of what it changes.
        let kept = self.kept.swap_remove(place);
        let outcome = self.set_fmu_state(&kept);
        self.kept.push(kept);
        outcome
    }

    /// `fmi2FreeFMUstate` by handle.
    ///
    /// # Errors
    /// As [`kept`](Self::kept).
    pub fn free_kept(&mut self, handle: usize) -> Outcome {
        self.guard(Function::FreeFMUstate)?;
        let place = self.place(handle)?;
        self.kept.swap_remove(place);
        Ok(())
    }

    /// Place of a handle; the last ones first, since hosts mostly come back to where they just were.
    fn place(&self, handle: usize) -> Outcome<usize> {
        self.kept.iter().rposition(|kept| address(kept) == handle).ok_or_else(|| {
            refused("the pointer is not one this instance has given out, or it was freed".to_owned())
        })
    }
}

#[allow(clippy::borrowed_box)] // the heap address is meant
fn address(kept: &Box<FmuState>) -> usize {
    std::ptr::from_ref::<FmuState>(kept).addr()
}
