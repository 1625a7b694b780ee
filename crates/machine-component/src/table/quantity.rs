//! Sources of the variables' values.

use vibro_machine::{Owner, What};

/// Source of a variable's value. Bodies and elements are given by their indices in the
/// description.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Time.
    Time,
    /// A parameter, by its index.
    Parameter(usize),
    /// A number or parameter that an expression computes; the field is its index.
    Following(usize),
    /// An input, by its index.
    Input(usize),
    /// A quantity of a body or an element.
    Column(vibro_machine::Quantity),
    /// The state of a stop.
    StopState(usize),
    /// The number of a stop's impacts so far.
    Impacts(usize),
    /// The impulse of a stop's last impact.
    Impulse(usize),
    /// The state of a friction element.
    FrictionState(usize),
    /// Index of the line of a piecewise linear spring that acts now, counted from 0 at the least
    /// elongation; the field is the spring's index.
    Line(usize),
    /// The state of a slider, by the index of its spring among the springs in series.
    SliderState(usize),
    /// A part of the energy balance.
    Energy(Energy),
    /// An event indicator, by its index.
    Indicator(usize),
    /// Derivatives of the states at the end of the last step with respect to the states at its
    /// start.
    Transition,
    /// Derivatives of the states at the end of the last step with respect to the inputs and their
    /// first three time derivatives at its start.
    Response,
    /// Derivatives of the states at the end of the last step with respect to tunable parameters.
    ByParameters,
}

impl Quantity {
    /// A body's coordinate (`order` 0), its rate (1) or its acceleration (2).
    pub fn of_body(body: usize, order: usize) -> Self {
        Self::Column(vibro_machine::Quantity::of_body(body, [What::S, What::V, What::A][order.min(2)]))
    }

    /// Returns body and order of a body's quantity, the inverse of [`of_body`](Self::of_body).
    pub fn as_body(self) -> Option<(usize, usize)> {
        let Self::Column(vibro_machine::Quantity { owner: Owner::Body(body), what }) = self else {
            return None;
        };
        Some((body, What::OF_BODIES.iter().position(|own| *own == what)?))
    }
}

/// A part of the energy balance, J.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Energy {
    /// Kinetic energy.
    Kinetic,
    /// Energy stored in springs, compliant stops and weight.
    Stored,
    /// Work of loads and prescribed motions since the start.
    Work,
    /// Energy lost in dashpots, stops and friction since the start.
    Lost,
    /// Energy that steps of stiffness have added since the start.
    Switched,
    /// Mechanical energy minus its value from start, work, losses and switching: round-off only.
    Residual,
}
