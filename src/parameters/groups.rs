//! Dimensionless groups: their values, and a list of them by name with symbols, meanings, ranges
//! and accessors.

use super::{Parameters, Range, Scales, entry};
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// Dimensionless groups of the paper, docs/theory.md (21) and (22), all of unit 1; names have no
/// hats.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Groups {
    /// ε = m2/m1.
    pub epsilon: f64,
    /// Restitution coefficient κ.
    pub kappa: f64,
    /// f̂10 = F10/(k1 L ε).
    pub f10: f64,
    /// σ̂1 in Ω1 = ω1/ω10 = 1 + ε σ̂1: detuning of the drive.
    pub sigma1: f64,
    /// γ̂1 = c1/(m1 ω10 ε).
    pub gamma1: f64,
    /// α̂23 = β²/ε. Redundant with `beta2`, which determines the stiffness.
    pub alpha23: f64,
    /// β² = k23/(m2 ω10²).
    pub beta2: f64,
    /// σ̂30 in Ω30² = k3/(m3 ω10²) = 1 + ε σ̂30.
    pub sigma30: f64,
    /// γ̂3 = c3/(m3 ω10 ε).
    pub gamma3: f64,
    /// μ13 = m1/m3.
    pub mu13: f64,
}

impl Groups {
    /// Groups with weak coupling as in the paper's sections 2–4: m3 = m2 (μ13 = 1/ε) and β² = ε
    /// α̂23, docs/theory.md (25).
    #[allow(clippy::too_many_arguments)]
    pub fn weak(
        epsilon: f64,
        kappa: f64,
        f10: f64,
        sigma1: f64,
        gamma1: f64,
        alpha23: f64,
        sigma30: f64,
        gamma3: f64,
    ) -> Self {
        let (beta2, mu13) = (epsilon * alpha23, 1.0 / epsilon);
        Self { epsilon, kappa, f10, sigma1, gamma1, alpha23, beta2, sigma30, gamma3, mu13 }
    }

    /// Default data set (docs/theory.md, end of section 4). ε, κ and f̂10 are the paper's; the
    /// others are a reconstruction, since the available copy of the paper lacks the displayed
    /// numbers.
    pub fn basic() -> Self {
        Self::weak(0.1, 0.75, 1.5, 0.4, 1.0, 0.6, 0.0, 0.6)
    }

    /// Physical parameters with these groups in the given scales, docs/theory.md (23), with drive
    /// phase zero and without constant loads.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a resulting field is outside its range.
    pub fn to_parameters(&self, scales: Scales) -> Result<Parameters> {
        let Scales { mass: m1, stiffness: k1, length } = scales;
        let omega10 = (k1 / m1).sqrt();
        let (m2, m3) = (self.epsilon * m1, m1 / self.mu13);
        let parameters = Parameters {
            box_mass: m1,
            box_stiffness: k1,
            box_damping: self.gamma1 * m1 * omega10 * self.epsilon,
            block_mass: m2,
            secondary_mass: m3,
            secondary_stiffness: (1.0 + self.epsilon * self.sigma30) * m3 * omega10 * omega10,
            secondary_damping: self.gamma3 * m3 * omega10 * self.epsilon,
            coupling_stiffness: self.beta2 * m2 * omega10 * omega10,
            stop_gap: length,
            stop_restitution: self.kappa,
            drive_amplitude: self.f10 * k1 * length * self.epsilon,
            drive_frequency: (1.0 + self.epsilon * self.sigma1) * omega10,
            drive_phase: 0.0,
            constant_loads: [0.0; 3],
        };
        parameters.validate()?;
        Ok(parameters)
    }
}

/// A dimensionless group, the counterpart of the physical parameter [`Field`](super::Field).
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// Name of the field of [`Groups`], e.g. `sigma1`.
    pub name: &'static str,
    /// The paper's symbol, for labels.
    pub symbol: &'static str,
    /// Description, a noun phrase.
    pub description: &'static str,
    /// Allowed values of this group; [`check_together`] checks bounds that depend on others.
    pub range: Range,
    /// Range that pictures show by default.
    pub shown: (f64, f64),
    /// Reads the group.
    pub get: fn(&Groups) -> f64,
    /// Writes the group; the caller updates the groups that depend on it.
    pub set: fn(&mut Groups, f64),
}

impl PartialEq for Group {
    /// Compares the names, which are unique.
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

macro_rules! group {
    ($field:ident, $symbol:literal, $range:expr, $shown:expr, $text:literal) => {
        entry!(Group, stringify!($field), $field, $range, $text, symbol: $symbol, shown: $shown)
    };
}

/// Range of the mass ratio: the block is not heavier than the box.
const MASS_RATIO: Range = Range { min: 0.0, max: 1.0, open_min: true, allowed: "0 < epsilon <= 1" };
/// Range of the restitution coefficient, from plastic to elastic impacts.
pub(crate) const RESTITUTION: Range =
    Range { min: 0.0, max: 1.0, open_min: false, allowed: "0 <= kappa <= 1" };
/// Range of the drive's detuning: the frequency is positive, as [`check_together`] checks.
const DRIVE_DETUNING: Range = Range::any("a finite number > -1/epsilon");
/// Range of the secondary oscillator's detuning: the stiffness is not negative, as
/// [`check_together`] checks.
const SECONDARY_DETUNING: Range = Range::any("a finite number >= -1/epsilon");

const SIGMA1: Group = group!(
    sigma1,
    "σ̂₁",
    DRIVE_DETUNING,
    (-2.0, 2.0),
    "detuning of the excitation, omega1/omega10 = 1 + epsilon sigma1"
);
const SIGMA30: Group = group!(
    sigma30,
    "σ̂₃₀",
    SECONDARY_DETUNING,
    (-2.0, 2.0),
    "detuning of the secondary oscillator, k3/(m3 omega10^2) = 1 + epsilon sigma30"
);

/// All groups, in the order of the fields of [`Groups`]; `alpha23` and `beta2` describe one
/// quantity.
#[rustfmt::skip]
pub const GROUPS: [Group; 10] = [
    group!(epsilon, "ε", MASS_RATIO, (0.01, 0.3), "mass ratio m2/m1"),
    group!(kappa, "κ", RESTITUTION, (0.0, 1.0), "restitution coefficient"),
    group!(f10, "f̂₁₀", Range::FINITE, (0.0, 4.0), "excitation amplitude F10/(k1 L epsilon)"),
    SIGMA1,
    group!(gamma1, "γ̂₁", Range::NOT_NEGATIVE, (0.0, 3.0), "damping of the box c1/(m1 omega10 epsilon)"),
    group!(alpha23, "α̂₂₃", Range::NOT_NEGATIVE, (0.0, 2.0), "weak coupling k23/(k1 epsilon^2)"),
    group!(beta2, "β²", Range::NOT_NEGATIVE, (0.0, 0.9), "coupling k23/(m2 omega10^2) = epsilon alpha23"),
    SIGMA30,
    group!(gamma3, "γ̂₃", Range::NOT_NEGATIVE, (0.0, 3.0), "damping of the secondary oscillator c3/(m3 omega10 epsilon)"),
    group!(mu13, "μ₁₃", Range::POSITIVE, (0.5, 20.0), "mass ratio m1/m3"),
];

impl Group {
    /// Group with a given name.
    pub fn named(name: &str) -> Option<&'static Self> {
        GROUPS.iter().find(|g| g.name == name)
    }

    /// Checks a value against the range; [`check_together`] checks bounds that depend on another
    /// group.
    ///
    /// # Errors
    /// [`Error::OutOfRange`], which names this group, if the value is outside the range, NaN or
    /// infinite.
    pub fn check(&self, value: f64) -> Result<()> {
        Ok(self.range.check(self.name, value)?)
    }

    /// Label of an axis: symbol and unit 1.
    pub fn label(&self) -> String {
        format!("{} (–)", self.symbol)
    }
}

/// Checks the bounds that depend on two groups: the drive's frequency ω1 = (1 + ε σ̂1) ω10 is
/// positive and the secondary oscillator's stiffness (1 + ε σ̂30) m3 ω10² is not negative,
/// docs/theory.md (23).
///
/// # Errors
/// [`Error::OutOfRange`], which names `sigma1` or `sigma30`, if its bound is violated.
pub fn check_together(g: &Groups) -> Result<()> {
    let frequency = (&SIGMA1, g.sigma1, 1.0 + g.epsilon * g.sigma1 > 0.0);
    let stiffness = (&SIGMA30, g.sigma30, 1.0 + g.epsilon * g.sigma30 >= 0.0);
    for (group, value, holds) in [frequency, stiffness] {
        if !holds {
            return Err(Error::OutOfRange { name: group.name, value, allowed: group.range.allowed });
        }
    }
    Ok(())
}
