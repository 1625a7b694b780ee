//! Serialized form of vectors and multipliers in the parts of a long study: plain lists of numbers,
//! bit for bit.

/// A vector.
pub(super) mod vector {
    use nalgebra::DVector;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(u: &DVector<f64>, to: S) -> Result<S::Ok, S::Error> {
        u.as_slice().serialize(to)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<DVector<f64>, D::Error> {
        Ok(DVector::from_vec(Vec::deserialize(from)?))
    }
}

/// The multipliers.
pub(super) mod multipliers {
    use nalgebra::Complex;
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<S: Serializer>(all: &[Complex<f64>], to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(all.iter().map(|m| (m.re, m.im)))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Complex<f64>>, D::Error> {
        let pairs = Vec::<(f64, f64)>::deserialize(from)?;
        Ok(pairs.into_iter().map(|(re, im)| Complex::new(re, im)).collect())
    }
}
