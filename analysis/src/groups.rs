//! The dimensionless groups by name: symbol, meaning, range and accessors, as [`FIELDS`](vibro_impact::parameters::FIELDS)
//! are for SI.

use super::error::Result;
use vibro_impact::error::Error;
use vibro_impact::parameters::Groups;

/// One dimensionless group.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// Name, e.g. `sigma1`.
    pub name: &'static str,
    /// The paper's symbol, for labels.
    pub symbol: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Allowed range in words.
    pub allowed: &'static str,
    /// Smallest allowed value (exclusive where `open_min`).
    pub min: f64,
    /// Largest allowed value.
    pub max: f64,
    /// Whether `min` itself is refused.
    pub open_min: bool,
    /// The range that pictures show unless told otherwise.
    pub shown: (f64, f64),
    /// Reads the group.
    pub get: fn(&Groups) -> f64,
    /// Writes the group alone; [`Settings`](super::Settings) keeps those that depend on it in step.
    pub set: fn(&mut Groups, f64),
}

impl PartialEq for Group {
    /// Names are unique.
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

macro_rules! group {
    ($field:ident, $symbol:literal, $allowed:literal, $min:expr, $max:expr, $open:literal, $shown:expr, $text:literal) => {
        Group {
            name: stringify!($field),
            symbol: $symbol,
            description: $text,
            allowed: $allowed,
            min: $min,
            max: $max,
            open_min: $open,
            shown: $shown,
            get: |g| g.$field,
            set: |g, value| g.$field = value,
        }
    };
}

const INF: f64 = f64::INFINITY;

/// All groups.
#[rustfmt::skip]
pub const GROUPS: [Group; 10] = [
    group!(epsilon, "ε", "0 < epsilon <= 1", 0.0, 1.0, true, (0.01, 0.3), "mass ratio m2/m1"),
    group!(kappa, "κ", "0 <= kappa <= 1", 0.0, 1.0, false, (0.0, 1.0), "restitution coefficient"),
    group!(f10, "f̂₁₀", "a finite number", -INF, INF, false, (0.0, 4.0), "excitation amplitude F10/(k1 L epsilon)"),
    group!(sigma1, "σ̂₁", "a finite number > -1/epsilon", -INF, INF, false, (-2.0, 2.0), "detuning of the excitation, omega1/omega10 = 1 + epsilon sigma1"),
    group!(gamma1, "γ̂₁", "a finite number >= 0", 0.0, INF, false, (0.0, 3.0), "damping of the box c1/(m1 omega10 epsilon)"),
    group!(alpha23, "α̂₂₃", "a finite number >= 0", 0.0, INF, false, (0.0, 2.0), "weak coupling k23/(k1 epsilon^2)"),
    group!(beta2, "β²", "a finite number >= 0", 0.0, INF, false, (0.0, 0.9), "coupling k23/(m2 omega10^2) = epsilon alpha23"),
    group!(sigma30, "σ̂₃₀", "a finite number >= -1/epsilon", -INF, INF, false, (-2.0, 2.0), "detuning of the secondary oscillator, k3/(m3 omega10^2) = 1 + epsilon sigma30"),
    group!(gamma3, "γ̂₃", "a finite number >= 0", 0.0, INF, false, (0.0, 3.0), "damping of the secondary oscillator c3/(m3 omega10 epsilon)"),
    group!(mu13, "μ₁₃", "a finite number > 0", 0.0, INF, true, (0.5, 20.0), "mass ratio m1/m3"),
];

impl Group {
    /// The group of a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        GROUPS.iter().find(|g| g.name == name)
    }

    /// Checks a value against the range; what depends on other groups is checked by [`check_together`].
    ///
    /// # Errors
    /// [`Error::OutOfRange`].
    pub fn check(&self, value: f64) -> Result<()> {
        let low = if self.open_min { value > self.min } else { value >= self.min };
        if value.is_finite() && low && value <= self.max {
            return Ok(());
        }
        Err(Error::OutOfRange { name: self.name, value, allowed: self.allowed }.into())
    }

    /// Label of an axis: symbol, meaning is in the caption, unit 1.
    pub fn label(&self) -> String {
        format!("{} (–)", self.symbol)
    }
}

/// The ranges that tie two groups: a positive excitation frequency, no negative stiffness.
///
/// # Errors
/// [`Error::OutOfRange`].
pub fn check_together(g: &Groups) -> Result<()> {
    let frequency = (&GROUPS[3], g.sigma1, 1.0 + g.epsilon * g.sigma1 > 0.0);
    let stiffness = (&GROUPS[7], g.sigma30, 1.0 + g.epsilon * g.sigma30 >= 0.0);
    for (group, value, holds) in [frequency, stiffness] {
        if !holds {
            return Err(Error::OutOfRange { name: group.name, value, allowed: group.allowed }.into());
        }
    }
    Ok(())
}
