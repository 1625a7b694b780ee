//! A checked machine with its matrices and its start: immutable, shared by its motions.

use crate::description::{Body, BodyKind, Description};
use crate::elements::Element;
use crate::error::Error;
use crate::mode::Watch;
use crate::rates;
use crate::rest::equilibrium;
use crate::system::{Part, System};
use nalgebra::DVector;
use vibro_impact::numerics::double_double::DoubleDouble;

/// A checked machine with its matrices.
#[derive(Clone, Debug)]
pub struct Assembly {
    /// The description.
    pub description: Description,
    pub(crate) system: System,
    /// Coordinate and rate of each body at time 0; 0 for prescribed bodies.
    pub(crate) starts: Vec<(f64, f64)>,
}

impl Assembly {
    /// Checks a description and builds its matrices.
    ///
    /// # Errors
    /// As [`System::new`]; [`Error::TooFast`] for rates above 1e100 rad/s; [`Error::NoEquilibrium`]
    /// for a machine that starts at rest and has no equilibrium.
    pub fn new(description: Description) -> Result<Self, Error> {
        let system = System::new(&description)?;
        rates::check(&description, &system)?;
        let start = |b: &Body| if let BodyKind::Free(free) = &b.kind { (free.s, free.v) } else { (0.0, 0.0) };
        let mut starts: Vec<(f64, f64)> = description.bodies.iter().map(start).collect();
        if description.starts_at_rest {
            let rest = equilibrium(&description, &system)?;
            system.bodies_of.iter().zip(rest.iter()).for_each(|(&body, &s)| starts[body] = (s, 0.0));
        }
        Ok(Self { description, system, starts })
    }

    /// The bodies' coordinates in static equilibrium under the signals of time 0, m or rad.
    ///
    /// # Errors
    /// [`Error::NoEquilibrium`].
    pub fn equilibrium(&self) -> Result<Vec<f64>, Error> {
        let (system, q) = (&self.system, equilibrium(&self.description, &self.system)?);
        let mut z = DVector::zeros(system.signals.size);
        system.signals.fill(DoubleDouble::default(), &system.signals.no_inputs(), z.as_mut_slice());
        z.rows_mut(0, system.coordinates).copy_from(&q);
        Ok(system.bodies.iter().map(|body| body.s.dot(&z)).collect())
    }

    /// Replaces the start: coordinate and rate by body, m, m/s or rad, rad/s. Values of prescribed
    /// bodies, and of bodies that follow from others by links, are not used.
    #[must_use]
    pub fn starting_from(mut self, starts: Vec<(f64, f64)>) -> Self {
        self.starts = starts;
        self
    }

    /// Dotted name of the element of a watched functional, such as `stop.NAME`.
    pub(crate) fn name_of(&self, watch: Watch) -> String {
        match watch {
            Watch::Meets(i) | Watch::Opens(i) | Watch::Presses(i) | Watch::Changes(i) | Watch::Leaves(i) => {
                self.name_of_stop(i)
            }
            Watch::Stops(i) | Watch::Slips(i, _) | Watch::Level(i) => self.name_of_friction(i),
        }
    }

    /// Dotted name of the element that has a stop, by the stop's place.
    pub fn name_of_stop(&self, i: usize) -> String {
        self.name_of_part(Part::Stop(i))
    }

    /// Dotted name of the element that has a friction, by the friction's place.
    pub fn name_of_friction(&self, i: usize) -> String {
        self.name_of_part(Part::Friction(i))
    }

    fn name_of_part(&self, part: Part) -> String {
        let element = self.description.elements().nth(self.system.element_of(part));
        element.map_or_else(String::new, Element::dotted)
    }

    /// The machine as matrices.
    pub fn system(&self) -> &System {
        &self.system
    }
}
