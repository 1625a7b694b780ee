//! Derivatives of an orbit's measures with respect to every parameter of its machine.
//!
//! The orbit satisfies F(u, p) = 0, the equations of its word. A parameter p moves its unknowns u
//! by u' = -F_u⁻¹ F_p. The derivative of a measure m(u, p) is the derivative along (u', 1),
//! computed by a fourth-order difference.

use super::cycle::Cycle;
use super::orbit::Orbit;
use super::place::Family;
use super::problem::{Problem, Residual};
use crate::curve::is_degenerate;
use crate::obstacle::Obstacle;
use nalgebra::{DMatrix, DVector, Dyn, LU};
use rayon::prelude::*;
use std::sync::Arc;
use vibro_studies::Result;
use vibro_studies::{Machine, Measure};

/// Step of the differences, in units of the parameter and of the unknowns: its fourth power, and
/// rounding divided by the step, are about 1e-12.
const STEP: f64 = 1e-3;
/// Step for accumulating impacts, whose number jumps.
const CHATTER_STEP: f64 = 1e-2;
/// Unit of a parameter as a fraction of its value; a value of zero has the unit 1.
const UNIT: f64 = 0.1;
/// Half of the family's range, in units of the parameter: the curve's unit is then the same.
const HALF_RANGE: f64 = 2.5;
/// Positions, in steps, and weights of fourth-order differences: on both sides, or on one side if
/// values on the other are not allowed.
const BOTH: &[(f64, f64)] = &[(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)];
const ONE: &[(f64, f64)] =
    &[(0.0, -25.0 / 12.0), (1.0, 4.0), (2.0, -3.0), (3.0, 4.0 / 3.0), (4.0, -1.0 / 4.0)];

/// The derivative of a measure with respect to a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterDerivative {
    /// The parameter's name.
    pub parameter: String,
    /// Its SI unit.
    pub unit: &'static str,
    /// Its value, SI.
    pub value: f64,
    /// The derivative, SI, or the reason why there is none.
    pub derivative: std::result::Result<f64, String>,
}

/// The derivative at 0 of a function, with values at multiples of `step`; tries both sides, then
/// each side alone.
fn difference(
    step: f64,
    at: impl Fn(f64) -> std::result::Result<Vec<f64>, Obstacle>,
) -> std::result::Result<DVector<f64>, Obstacle> {
    let by = |weights: &[(f64, f64)], step: f64| -> std::result::Result<DVector<f64>, Obstacle> {
        let mut sum: Option<DVector<f64>> = None;
        for (place, weight) in weights {
            let own = DVector::from_vec(at(place * step)?) * (weight / step);
            sum = Some(sum.map_or_else(|| own.clone(), |sum| sum + &own));
        }
        sum.ok_or(Obstacle::NoConvergence)
    };
    by(BOTH, step).or_else(|_| by(ONE, step)).or_else(|_| by(ONE, -step))
}

/// The equations at an orbit, with F_u, which is the same for every parameter.
struct Linear {
    cycle: Cycle,
    matrix: DMatrix<f64>,
    factors: LU<f64, Dyn, Dyn>,
}

impl Linear {
    fn of(orbit: &Orbit) -> std::result::Result<Self, Obstacle> {
        let Residual { matrix, cycle, .. } = orbit.problem.residual(&orbit.place, &orbit.u, true)?;
        let matrix = matrix.filter(|matrix| !is_degenerate(matrix)).ok_or(Obstacle::Singular)?;
        Ok(Self { cycle, factors: matrix.clone().lu(), matrix })
    }
}

impl Orbit {
    /// The derivatives of a measure of the orbit with respect to every parameter. Parameters of
    /// the machine's start are left out, since no orbit depends on them. The word is kept.
    ///
    /// # Errors
    /// As [`measure`](Self::measure).
    ///
    /// # Examples
    ///
    /// The closing speed gT/(1 + ε) of a ball on a shaken table does not depend on its mass:
    ///
    /// ```
    /// use vibro_orbits::Orbit;
    /// use vibro_studies::{Machine, Start};
    ///
    /// # let text = r#"
    /// #     name = "Juggler"
    /// #     gravity = 10.0
    /// #     body.table = { motion = { amplitude = "4 mm", frequency = "5 Hz" } }
    /// #     body.ball = { mass = "20 g", gravity = -1.0, start = { v = 1.0 } }
    /// #     stop.table = { between = ["ball", "table"], gap = 0.0, restitution = 0.8 }
    /// # "#;
    /// let machine = Machine::parse(text, "juggler.toml", &vibro_machine::file::no_records)?;
    /// let orbit = Orbit::settled(&machine, &Start::default(), 400)?;
    /// let all = orbit.gradient(&"impact.speed.table".parse()?)?;
    /// let by = |name: &str| {
    ///     let found = all.iter().find(|own| own.parameter == name);
    ///     found.unwrap().derivative.clone().unwrap()
    /// };
    /// assert!((by("stop.table.restitution") + 2.0 / (1.8 * 1.8)).abs() < 1e-9);
    /// assert!(0.02 * by("body.ball.mass").abs() < 1e-9); // times the mass
    /// # Ok::<(), vibro_studies::Error>(())
    /// ```
    pub fn gradient(&self, measure: &Measure) -> Result<Vec<ParameterDerivative>> {
        let machine = self.problem.family.at(self.value())?;
        let all = machine.description.parameters().into_iter().filter(|p| !p.name.contains(".start."));
        let all: Vec<_> = all.map(|p| (p.name, p.unit, p.value)).collect();
        self.derivatives(&machine, measure, all)
    }

    /// The derivatives of a measure of the orbit with respect to some parameters, as in
    /// [`gradient`](Self::gradient).
    ///
    /// # Errors
    /// As [`measure`](Self::measure); [`Error::Refusal`](vibro_studies::Error::Refusal) for an
    /// unknown parameter.
    pub fn gradient_by(&self, measure: &Measure, names: &[String]) -> Result<Vec<ParameterDerivative>> {
        let machine = self.problem.family.at(self.value())?;
        let named = |name: &String| {
            let found = machine.description.parameter(name)?;
            Ok((found.name, found.unit, found.value))
        };
        let some = names.iter().map(named).collect::<Result<Vec<_>>>()?;
        self.derivatives(&machine, measure, some)
    }

    fn derivatives(
        &self,
        machine: &Machine,
        measure: &Measure,
        by: Vec<(String, &'static str, f64)>,
    ) -> Result<Vec<ParameterDerivative>> {
        self.measure(measure)?;
        let linear = Linear::of(self).map_err(in_words);
        let of = |(parameter, unit, value): (String, &'static str, f64)| {
            let derivative = linear.as_ref().map_err(Clone::clone).and_then(|linear| {
                self.derivative(linear, machine, (&parameter, value), measure).map_err(in_words)
            });
            ParameterDerivative { parameter, unit, value, derivative }
        };
        Ok(by.into_par_iter().map(of).collect())
    }

    fn derivative(
        &self,
        linear: &Linear,
        machine: &Machine,
        (parameter, value): (&str, f64),
        measure: &Measure,
    ) -> std::result::Result<f64, Obstacle> {
        let unit = if value == 0.0 { 1.0 } else { UNIT * value.abs() };
        let range = (value - HALF_RANGE * unit, value + HALF_RANGE * unit);
        let family = Family { machine: machine.clone(), parameter: parameter.to_owned(), range };
        let problem = Problem { family: Arc::new(family), ..self.problem.clone() };
        let step = if problem.word.has_run() { CHATTER_STEP } else { STEP };
        let u = problem.point(&self.place, &self.numbers, value);
        let column = problem.by_parameter((&self.place, &u), &linear.cycle, &linear.matrix)?;
        let along = linear.factors.solve(&-column).ok_or(Obstacle::Singular)?;
        if along.iter().any(|x| !x.is_finite()) {
            return Err(Obstacle::Singular);
        }
        let direction = along.push(1.0);
        // The unknowns move by at most one step.
        let step = step / direction.amax().max(1.0);
        let found = difference(step, |by| {
            let moved = &u + &direction * by;
            let orbit = Orbit::at(problem.clone(), problem.place(&moved)?, moved)?;
            Ok(vec![orbit.measure(measure)?])
        })?;
        Ok(found[0] / unit)
    }
}

fn in_words(obstacle: Obstacle) -> String {
    match obstacle {
        Obstacle::Refused(error) => error.to_string(),
        Obstacle::Singular => "the orbit is at a fold or belongs to a family of orbits, so it has \
                               no derivative"
            .into(),
        Obstacle::Order => "the order of the events changes".into(),
        _ => "the orbit's equations cannot be followed".into(),
    }
}
