//! Values that a host can set, and derived values that need no motion. Both are plain data, which
//! the accessors of the variable table read and write.

use serde::{Deserialize, Serialize};
use vibro_impact::parameters::{Groups, Parameters};
use vibro_impact::simulator::{Loads, State};

/// Method that gives the motion; the numbers belong to the enumeration `Mode`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum SolutionMode {
    /// Event-driven simulation.
    #[default]
    EventDriven,
    /// Closed-form steady state by multiple scales.
    MultipleScales,
    /// Closed-form exact two-impact orbit.
    ExactOrbit,
}

impl SolutionMode {
    /// Number of the mode in the enumeration.
    pub fn number(self) -> i32 {
        match self {
            Self::EventDriven => 1,
            Self::MultipleScales => 2,
            Self::ExactOrbit => 3,
        }
    }

    /// The mode with a number; `None` for other numbers.
    pub fn from_number(number: i32) -> Option<Self> {
        [Self::EventDriven, Self::MultipleScales, Self::ExactOrbit].into_iter().find(|m| m.number() == number)
    }
}

/// Everything a host can set. `Default` holds the start values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Physical parameters.
    pub parameters: Parameters,
    /// Start values of displacements and velocities.
    pub start: State,
    /// Loads and their derivatives at the coming communication point.
    pub loads: Loads,
    /// Method that gives the motion.
    pub mode: SolutionMode,
    /// Start on the exact orbit instead of at `start`.
    pub start_on_orbit: bool,
    /// End a step at its first impact.
    pub stop_at_impact: bool,
}

/// Values that follow from the parameters alone. All are zero in `Default`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Derived {
    /// The dimensionless groups, every one finite.
    pub groups: Groups,
    /// The steady state.
    pub steady: Steady,
}

impl Default for Derived {
    fn default() -> Self {
        let groups = Groups {
            epsilon: 0.0,
            kappa: 0.0,
            f10: 0.0,
            sigma1: 0.0,
            gamma1: 0.0,
            alpha23: 0.0,
            beta2: 0.0,
            sigma30: 0.0,
            gamma3: 0.0,
            mu13: 0.0,
        };
        Self { groups, steady: Steady::default() }
    }
}

/// Numbers of the steady state; 0 without one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steady {
    /// A real solution exists.
    pub exists: bool,
    /// The block stays between the stops, the steady state is a stable fixed point of the slow
    /// flow, and the two-impact motion is stable.
    pub stable: bool,
    /// Amplitude of the secondary oscillator, in units of the gap.
    pub a3: f64,
    /// Phase of the drive at the impact on the upper stop, rad.
    pub phase: f64,
    /// Amplitude of the box, in units of the gap.
    pub a1: f64,
    /// Amplitude of the block, in units of the gap.
    pub a2: f64,
    /// Impulse of each impact of the exact orbit, N·s.
    pub impulse: f64,
    /// Spectral radius of the exact orbit's half-cycle map.
    pub spectral_radius: f64,
}
