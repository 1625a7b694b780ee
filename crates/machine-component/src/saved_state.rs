//! Saved states and their serialization: "VIBROMCH", a checksum of the rest (FNV-1a, 64 bit,
//! little-endian), then the machine's token and the state in postcard's format.
//!
//! The token depends on the library's version, so that the layout may change between versions. The
//! checksum detects accidental damage, not forgery: the decoded state is checked as well.

use crate::machine::{SavedMoving, Shown};
use crate::problem::refused;
use fmi_doors::{Life, Problem};
use serde::{Deserialize, Serialize};
use vibro_machine::signals::Input;
use vibro_numerics::digest::fnv1a;

/// First bytes of a serialized state.
const MAGIC: [u8; 8] = *b"VIBROMCH";

/// The complete state of an instance, for `fmi2GetFMUstate` and `fmi3GetFMUState`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedState {
    pub(crate) life: Life,
    /// Values of all parameters.
    pub(crate) values: Vec<f64>,
    /// Additional phase of each parameter.
    pub(crate) phases: Vec<f64>,
    /// Whether parameters were set and do not act yet.
    pub(crate) changed: bool,
    /// Values of inputs that were set and do not act yet.
    pub(crate) pending: Vec<Option<Input>>,
    /// The motion, once initialized.
    pub(crate) moving: Option<SavedMoving>,
    pub(crate) latched: Option<Shown>,
}

impl SavedState {
    /// Serializes the state of the machine with this token.
    ///
    /// # Errors
    /// [`Problem::SavedState`] if postcard fails, which would be a bug.
    pub(crate) fn to_bytes(&self, token: &str) -> Result<Vec<u8>, Problem> {
        let payload = postcard::to_stdvec(&(token, self)).map_err(|error| refused(error.to_string()))?;
        let sum = fnv1a(&payload).to_le_bytes();
        Ok([&MAGIC[..], &sum[..], &payload[..]].concat())
    }

    /// Deserializes a state of the machine with this token.
    ///
    /// # Errors
    /// [`Problem::SavedState`] for bytes that are truncated, altered or from another machine.
    pub(crate) fn from_bytes(bytes: &[u8], token: &str) -> Result<Self, Problem> {
        let rest = bytes.strip_prefix(&MAGIC).ok_or_else(|| refused("it is not from a described machine"))?;
        let (sum, payload) = rest.split_first_chunk().ok_or_else(|| refused("it ends too early"))?;
        if *sum != fnv1a(payload).to_le_bytes() {
            return Err(refused("its checksum does not match: it is truncated or altered"));
        }
        let (written, rest) =
            postcard::take_from_bytes::<String>(payload).map_err(|error| refused(error.to_string()))?;
        if written != token {
            return Err(refused("it is from another machine or another version"));
        }
        postcard::from_bytes(rest).map_err(|error| refused(error.to_string()))
    }
}
