//! Serialization of a vector as a sequence of numbers, for `#[serde(with = "…")]`.

use nalgebra::DVector;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

pub(crate) fn serialize<S: Serializer>(vector: &DVector<f64>, to: S) -> Result<S::Ok, S::Error> {
    vector.as_slice().serialize(to)
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<DVector<f64>, D::Error> {
    Ok(DVector::from_vec(Vec::deserialize(from)?))
}
