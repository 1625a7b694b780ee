//! Saved states, and their layout as bytes.
//!
//! ```text
//! bytes    content
//! 8        "VIBROFMU"
//! 4        VERSION of the layout, little-endian
//! 16       number of the build that wrote it (identity::number), little-endian
//! 4        length of the payload, little-endian
//! …        payload: SavedState in postcard's format
//! 8        checksum of all that comes before it (FNV-1a, 64 bit), little-endian
//! ```
//!
//! The payload holds the fields of [`SavedState`] one after the other, each in the order of its
//! declaration, without names or padding. A double takes its 8 bytes, so that every bit is
//! restored, also of NaN and -0; a Boolean, an `i8` and the tag of an `Option` take one byte.
//! Other whole numbers and the numbers of enum variants use 7 bits per byte, the lowest first. The
//! structs belong to this crate ([`Settings`], the motion) and to `vibro-impact` (`Snapshot`,
//! `Parameters`, `DoubleDouble`, …): **whoever changes one of their fields, or their order,
//! changes the layout and must raise [`VERSION`]**; the test `golden_file_of_the_layout` detects
//! it.
//!
//! Every field of the payload has a meaning in all protocols, so a state written by one door can
//! be read by another door of the same build. If a protocol cannot represent a part of the state,
//! such as an unhandled event, the restore resolves it. The checksum detects accidental damage; it
//! is not a signature.

use super::closed_form;
use super::continuous;
use super::event_state::EventState;
use super::identity;
use super::problem::{ComponentProblem, Outcome};
use super::settings::Settings;
use super::values::Tick;
use fmi_doors::{Experiment, Interface, Phase};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use vibro_impact::simulator::Snapshot;
use vibro_numerics::digest::fnv1a;

/// First bytes of a serialized state.
const MAGIC: [u8; 8] = *b"VIBROFMU";
/// Version of the layout of the bytes that follow.
pub const VERSION: u32 = 7;

/// All data that a component needs to continue: its phase, its settings and its motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedState {
    pub(super) interface: Interface,
    pub(super) phase: Phase,
    pub(super) settings: Settings,
    pub(super) experiment: Option<Experiment>,
    pub(super) slopes_set: [bool; 3],
    pub(super) parameters_set: bool,
    pub(super) loads_set: bool,
    pub(super) events: EventState,
    pub(super) tick: Tick,
    /// Nominal values of the states last reported to the host.
    pub(super) nominals_told: Option<[f64; 6]>,
    /// Start value of `stop_at_impact` in the protocol that saved the state. If the host kept it,
    /// a restore uses the start value of the restoring protocol.
    pub(super) stop_by_default: bool,
    /// Physical parameters set by the host, one bit each in the order of `FIELDS`.
    pub(super) given: u16,
    pub(super) engine: EngineState,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)] // saved states are boxed as a whole
pub(super) enum EngineState {
    None,
    Simulation(Snapshot),
    Closed(closed_form::Data),
    Continuous(continuous::Data),
}

fn refused(what: impl Into<Cow<'static, str>>) -> ComponentProblem {
    fmi_doors::Problem::SavedState { what: what.into() }.into()
}

/// Removes the first `N` bytes from `bytes`.
fn take<const N: usize>(bytes: &mut &[u8]) -> Outcome<[u8; N]> {
    let (head, rest) = bytes.split_first_chunk::<N>().ok_or_else(|| refused("it ends too early"))?;
    *bytes = rest;
    Ok(*head)
}

impl SavedState {
    /// Refuses a phase that does not fit the motion, as in a damaged saved state. The interface
    /// type's phases are checked in [`Life::take_over`](fmi_doors::Life::take_over).
    ///
    /// # Errors
    /// [`SavedState`](fmi_doors::Problem::SavedState).
    pub(super) fn check(&self) -> Outcome {
        let exchange = self.interface == Interface::ModelExchange;
        let fits = match &self.engine {
            EngineState::None => self.phase.has_motion() != Some(true),
            engine => {
                matches!(engine, EngineState::Continuous(_)) == exchange
                    && self.phase.has_motion() != Some(false)
            }
        };
        if fits { Ok(()) } else { Err(refused("its phase does not match its motion")) }
    }

    /// The bytes of the state: header, payload, checksum.
    ///
    /// # Errors
    /// [`SavedState`](fmi_doors::Problem::SavedState), which would be a bug in this crate.
    pub fn serialize(&self) -> Outcome<Vec<u8>> {
        let payload = postcard::to_stdvec(self).map_err(|error| refused(error.to_string()))?;
        let length = u32::try_from(payload.len()).map_err(|error| refused(error.to_string()))?;
        let mut bytes = Vec::with_capacity(payload.len() + 64);
        bytes.extend_from_slice(&MAGIC);
        bytes.extend_from_slice(&VERSION.to_le_bytes());
        bytes.extend_from_slice(&identity::number().to_le_bytes());
        bytes.extend_from_slice(&length.to_le_bytes());
        bytes.extend_from_slice(&payload);
        let checksum = fnv1a(&bytes);
        bytes.extend_from_slice(&checksum.to_le_bytes());
        Ok(bytes)
    }

    /// Reads a state from bytes. Restoring it checks whether a motion can continue from it.
    ///
    /// # Errors
    /// [`SavedState`](fmi_doors::Problem::SavedState) for bytes that are truncated, altered, of
    /// another version or of another build.
    pub fn deserialize(serialized: &[u8]) -> Outcome<Self> {
        let Some((content, sum)) = serialized.split_last_chunk::<8>() else {
            return Err(refused(format!("{} bytes are too few", serialized.len())));
        };
        let mut rest = content;
        if take(&mut rest)? != MAGIC {
            return Err(refused("the bytes are not from this FMU"));
        }
        let version = u32::from_le_bytes(take(&mut rest)?);
        if version != VERSION {
            return Err(refused(format!("version {version}: expected {VERSION}")));
        }
        if fnv1a(content) != u64::from_le_bytes(*sum) {
            return Err(refused("the checksum does not match: truncated or altered"));
        }
        if u128::from_le_bytes(take(&mut rest)?) != identity::number() {
            return Err(refused(
                "it comes from another build of this FMU (its variables or its version differ)",
            ));
        }
        let length = u32::from_le_bytes(take(&mut rest)?);
        if rest.len() != length as usize {
            return Err(refused(format!("{} bytes of payload: expected {length}", rest.len())));
        }
        Self::from_payload(rest)
    }

    fn from_payload(payload: &[u8]) -> Outcome<Self> {
        match postcard::take_from_bytes(payload).map_err(|error| refused(error.to_string()))? {
            (state, []) => Ok(state),
            (_, left) => Err(refused(format!("{} bytes too many", left.len()))),
        }
    }
}

#[cfg(test)]
mod tests;
