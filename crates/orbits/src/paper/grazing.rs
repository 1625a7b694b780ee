//! Grazing: an orbit that touches a stop at zero speed has two words, with and without this impact
//! (docs/theory.md, section 14).

use super::cycle::{Cycle, Functional};
use super::family::{ContactEquations, Family};
use super::flights::{self, PENETRATION_ROUNDING};
use crate::curve::{Equations, Linearization, solve};
use crate::obstacle::Obstacle;
use crate::stop_word::OrbitWord;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Touch of a stop by an orbit, described in the word that lists the touch as an impact.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Touch {
    /// The word with the touch.
    pub longer: OrbitWord,
    /// Index of the touch in the longer word.
    pub index: usize,
    /// Phases and parameters as a point of a curve of the longer word.
    #[serde(with = "crate::stored::vector")]
    pub u: DVector<f64>,
    /// Indices of other impacts at zero speed in the longer word. For example, a repeated orbit
    /// touches a stop in each repetition.
    pub also: Vec<usize>,
    /// Whether the followed branch lists the touch.
    pub from_longer: bool,
}

impl Touch {
    /// Phases and parameters without the touch.
    pub fn without(&self) -> DVector<f64> {
        self.u.clone().remove_row(self.index)
    }

    /// Phases and parameters as a point of the followed branch.
    pub fn on_branch(&self) -> DVector<f64> {
        if self.from_longer { self.u.clone() } else { self.without() }
    }

    /// The word without the touch.
    pub fn shorter(&self) -> OrbitWord {
        self.longer.removed(self.index)
    }
}

/// Touches indicated by a cycle that is not an orbit of the machine: its impacts without a
/// positive approach speed, and its extrema of w past a stop.
pub(super) fn announced(cycle: &Cycle, u: &DVector<f64>) -> Vec<Touch> {
    let mut found = Vec::new();
    let word = cycle.word;
    for index in (0..word.len()).filter(|i| cycle.speed(*i) <= 0.0) {
        found.push(Touch { longer: word.clone(), index, u: u.clone(), also: Vec::new(), from_longer: true });
    }
    for flight in 0..word.len() {
        let (z, phase) = (cycle.departure(flight), cycle.phases[flight]);
        let span = cycle.arrival(flight) - phase;
        for side in [1i8, -1] {
            let s = f64::from(side);
            // If the block would stay on its stop after the impact at the start of this flight, w
            // is past this stop from the start of the flight. Such an extremum is not a touch.
            if cycle.stays(flight) && s * word.side(flight) > 0.0 {
                continue;
            }
            let maxima = flights::maxima(cycle.system, z, phase, span, [-s, s, 0.0]);
            for (phase, _) in maxima.into_iter().filter(|m| m.1 > 1.0 + PENETRATION_ROUNDING) {
                let index = flight + 1;
                let u = u.clone().insert_row(index, phase);
                found.push(Touch {
                    longer: word.inserted(index, side),
                    index,
                    u,
                    also: Vec::new(),
                    from_longer: false,
                });
            }
        }
    }
    found
}

/// Equations (109) of docs/theory.md: the contact equations of a word, and the condition that one
/// of its impacts has zero approach speed.
pub(super) struct Touching<'a> {
    pub contacts: ContactEquations<'a>,
    pub index: usize,
}

impl Equations for Touching<'_> {
    fn linearize(&self, u: &DVector<f64>, _: Option<&DMatrix<f64>>) -> Result<Linearization, Obstacle> {
        let ContactEquations { family, word } = self.contacts;
        let n = word.len();
        let system = family.system_at(u)?;
        let cycle = Cycle::new(&system, word, &u.as_slice()[..n])?;
        let flight = cycle.flight_to(self.index);
        let side = word.side(flight + 1);
        let speed = |c: &Cycle| side * c.rates[flight];
        let [gap, rate] = [Functional::Gap, Functional::Rate].map(|f| cycle.derivative(f, 1.0));
        let (gap, rate) = gap.zip(rate).ok_or(Obstacle::Singular)?;
        let mut matrix = DMatrix::zeros(n + 1, u.len());
        matrix.view_mut((0, 0), (n, n)).copy_from(&gap);
        matrix.view_mut((n, 0), (1, n)).copy_from(&(rate.row(flight) * side));
        let both = |c: &Cycle| c.residual.iter().copied().chain([speed(c)]).collect();
        for (k, column) in family.by_parameters(u, &cycle, both)?.iter().enumerate() {
            matrix.set_column(n + k, column);
        }
        Ok(Linearization { value: cycle.residual_vector().push(speed(&cycle)), matrix })
    }
}

/// The gradient of the approach speed of an impact at a point of a curve.
pub(super) fn speed_gradient(touching: &Touching, u: &DVector<f64>) -> Result<DVector<f64>, Obstacle> {
    let matrix = touching.linearize(u, None)?.matrix;
    Ok(matrix.row(matrix.nrows() - 1).transpose())
}

/// The point with zero speed at the touch, from the equations of the longer word. These equations
/// are regular on both branches: on the branch with the touch and on the branch without it.
pub(super) fn locate(family: &Family, touch: &Touch) -> Result<Touch, Obstacle> {
    let touching =
        Touching { contacts: ContactEquations { family, word: &touch.longer }, index: touch.index };
    let u = solve(&touch.u, |u| touching.linearize(u, None))?;
    Ok(Touch { u, ..touch.clone() })
}

/// Tolerance for zero approach speed of another impact at a touch, units of ω1 L.
const NO_SPEED: f64 = 1e-6;

/// Properties of the cycle of the longer word at a touch.
pub(super) struct ExaminedTouch {
    /// The touch, with the other touches at the same point.
    pub(super) touch: Touch,
    /// Whether the cycle is an orbit of the machine, apart from the zero speed at the touches.
    pub(super) is_orbit: bool,
    /// Whether the block is pressed into the stop at a touch, which would cause chatter.
    pub(super) pressed: bool,
}

/// Examines the cycle of the longer word at a touch.
pub(super) fn examine(family: &Family, touch: Touch) -> Result<ExaminedTouch, Obstacle> {
    let system = family.system_at(&touch.u)?;
    let n = touch.longer.len();
    let cycle = Cycle::new(&system, &touch.longer, &touch.u.as_slice()[..n])?;
    let others = || (0..n).filter(|i| *i != touch.index);
    let also = others().filter(|i| cycle.speed(*i).abs() < NO_SPEED).collect();
    let approach = others().all(|i| cycle.speed(i) > -NO_SPEED);
    let flight = cycle.flight_to(touch.index);
    let pressed = touch.longer.side(flight + 1) * cycle.approach_acceleration(flight) >= 0.0;
    let is_orbit = approach && super::orbit::is_clear(&cycle);
    Ok(ExaminedTouch { touch: Touch { also, ..touch }, is_orbit, pressed })
}
