//! A checked machine with its matrices and its start: immutable, shared by its motions.

use crate::description::{Body, BodyKind, Description};
use crate::elements::Element;
use crate::error::Error;
use crate::mode::{Contact, Watch};
use crate::quantity::{Quantity, What};
use crate::rates;
use crate::rest::equilibrium;
use crate::system::{Part, System, in_series, starts_of_blocks};

/// A checked machine with its matrices.
///
///
/// A rigid link leaves one coordinate for two bodies:
///
/// ```
/// use vibro_machine::{Assembly, file};
///
/// let text = r#"
///     name = "Gears"
///     body.pinion = { inertia = 0.1 }
///     body.wheel = { inertia = 0.4 }
///     link.mesh = { arms = { pinion = 1.0, wheel = 2.0 } }
/// "#;
/// let assembly = Assembly::new(file::parse(text, "gears.toml", &file::no_records)?)?;
/// assert_eq!(assembly.description.bodies.len(), 2);
/// assert_eq!(assembly.system().coordinates, 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Assembly {
    /// The description.
    pub description: Description,
    pub(crate) system: System,
    /// Coordinate and rate of each body at time 0; 0 for prescribed bodies.
    pub(crate) starts: Vec<(f64, f64)>,
    /// First-order states at time 0.
    pub(crate) inner: Vec<f64>,
}

impl Assembly {
    /// Checks a description and builds its matrices.
    ///
    /// # Errors
    /// As [`System::new`]; [`Error::TooFast`] for rates above 1e100 rad/s;
    /// [`Error::NoEquilibrium`] for a machine that starts at rest and has no equilibrium;
    /// [`Error::GivesWay`] if it does not reach the equilibrium as its loads grow.
    pub fn new(description: Description) -> Result<Self, Error> {
        let system = System::new(&description)?;
        rates::check(&description, &system)?;
        let start = |b: &Body| if let BodyKind::Free(free) = &b.kind { (free.s, free.v) } else { (0.0, 0.0) };
        let mut starts: Vec<(f64, f64)> = description.bodies.iter().map(start).collect();
        let mut inner: Vec<f64> = in_series(&description).map(|own| own.slider).collect();
        let blocks: Vec<f64> = starts_of_blocks(&description).collect();
        if description.starts_at_rest {
            let rest = equilibrium(&description, &system)?;
            system.bodies_of.iter().zip(rest.iter()).for_each(|(&body, &s)| starts[body] = (s, 0.0));
            inner = system.inner_at_rest(&rest);
        }
        inner.extend(blocks);
        Ok(Self { description, system, starts, inner })
    }

    /// The bodies' coordinates in static equilibrium under the signals of time 0, m or rad.
    ///
    /// # Errors
    /// [`Error::NoEquilibrium`], [`Error::GivesWay`].
    ///
    /// # Examples
    /// A weight of 20 N on a spring of 1 kN/m sinks by 20 mm:
    ///
    /// ```
    /// use vibro_machine::{Assembly, file};
    ///
    /// let text = r#"
    ///     name = "Hanging"
    ///     gravity = 10.0
    ///     body.weight = { mass = 2.0, gravity = 1.0 }
    ///     spring.k = { between = ["ground", "weight"], stiffness = "1 kN/m" }
    /// "#;
    /// let assembly = Assembly::new(file::parse(text, "hanging.toml", &file::no_records)?)?;
    /// assert!((assembly.equilibrium()?[0] - 0.02).abs() < 1e-16);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn equilibrium(&self) -> Result<Vec<f64>, Error> {
        let (system, q) = (&self.system, equilibrium(&self.description, &self.system)?);
        let z = system.at_rest(Some(&q));
        Ok(system.bodies.iter().map(|body| body.s.dot(&z)).collect())
    }

    /// Replaces the start: coordinate and rate by body, m, m/s or rad, rad/s. Values of prescribed
    /// bodies, and of bodies that follow from others by links, are not used.
    #[must_use]
    pub fn starting_from(mut self, starts: Vec<(f64, f64)>) -> Self {
        self.starts = starts;
        self
    }

    /// The machine with derivatives that ignore the rounding of blocks' inputs to a quantum, for
    /// searches. The exact derivative of a rounded input is 0 and does not show the next multiple.
    #[must_use]
    pub fn varying_rounded(mut self) -> Self {
        let samplers = self.system.blocks.iter_mut().filter_map(|block| block.sampler.as_mut());
        samplers.for_each(|sampler| sampler.varies_rounded = true);
        self
    }

    /// Whether a block is sampled.
    pub fn has_samples(&self) -> bool {
        self.system.blocks.iter().any(|block| block.sampler.is_some())
    }

    /// Whether all blocks have the states of the machine's start.
    pub(crate) fn is_fresh(&self, state: &[f64]) -> bool {
        let first = self.system.branches.len();
        let own = self.inner.get(first..).unwrap_or_default();
        state.get(2 * self.system.coordinates + first..).is_some_and(|state| state == own)
    }

    /// Names of the values that blocks keep, in the order of the first-order states.
    pub(crate) fn names_of_blocks(&self) -> Vec<String> {
        self.description.names_of_blocks()
    }

    /// Dotted name of the element of a watched functional, such as `stop.NAME`.
    pub(crate) fn name_of(&self, watch: Watch) -> String {
        match watch {
            Watch::Meets(i)
            | Watch::Opens(i)
            | Watch::Presses(i)
            | Watch::Changes(i)
            | Watch::Leaves(i)
            | Watch::Turns(i) => self.name_of_stop(i),
            Watch::Stops(i) | Watch::Slips(i, _) | Watch::Level(i) => self.name_of_friction(i),
            Watch::Yields(i, _) | Watch::Reverses(i) => self.name_of_branch(i),
        }
    }

    /// The continuous states and their rates as quantities, in the order of the augmented state:
    /// coordinates of bodies, then their rates, then first-order states.
    ///
    ///
    /// ```
    /// use vibro_machine::{Assembly, Quantity, What, file};
    ///
    /// # let text = r#"
    /// #     name = "Wall"
    /// #     body.a = { mass = 1.0, start = { v = 2.0 } }
    /// #     stop.wall = { between = ["ground", "a"], gap = 1.0, restitution = 0.25 }
    /// # "#;
    /// let assembly = Assembly::new(file::parse(text, "wall.toml", &file::no_records)?)?;
    /// let [s, v, a] = [What::S, What::V, What::A].map(|what| Quantity::of_body(0, what));
    /// assert_eq!(assembly.state_quantities(), [[s, v], [v, a]]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn state_quantities(&self) -> Vec<[Quantity; 2]> {
        let system = &self.system;
        let of_bodies = |whats: [What; 2]| {
            system.bodies_of.iter().map(move |&body| whats.map(|what| Quantity::of_body(body, what)))
        };
        let sliders = self.description.elements().enumerate().flat_map(|(i, element)| {
            let of = move |k| [What::Slider(k), What::SliderRate(k)];
            element.branches().map(move |k| of(k).map(|what| Quantity::of_element(i, what)))
        });
        let own = of_bodies([What::S, What::V]).chain(of_bodies([What::V, What::A])).chain(sliders);
        let first = self.description.elements().count() - system.blocks.len();
        let blocks = system.blocks.iter().enumerate().flat_map(|(i, block)| {
            let both = move |k| [What::State(k), What::StateRate(k)];
            (0..block.kept()).map(move |k| both(k).map(|what| Quantity::of_element(first + i, what)))
        });
        own.chain(blocks).collect()
    }

    /// Name of the state with index `place` in the augmented state: `body.NAME.s`, `body.NAME.v`,
    /// `spring.NAME.slider`, `contact.NAME.slider`, `contact.NAME.slider[0]`, `block.NAME.x[0]`.
    pub(crate) fn name_of_state(&self, place: usize) -> String {
        let (n, own) = (self.system.coordinates, |k: usize| self.system.bodies_of[k]);
        let body = |k: usize| &self.description.bodies[own(k)].name;
        match place {
            _ if place < n => format!("body.{}.s", body(place)),
            _ if place < 2 * n => format!("body.{}.v", body(place - n)),
            _ if place >= 2 * n + self.system.branches.len() => {
                let block = self.system.blocks.iter().rposition(|own| own.first <= place).unwrap_or_default();
                let what = What::State(place - self.system.blocks[block].first);
                format!("block.{}", self.description.blocks[block].name_of(what))
            }
            _ => {
                let branch = self.system.branches.iter().position(|own| own.place == place);
                let own = in_series(&self.description).nth(branch.unwrap_or_default());
                own.map_or_else(String::new, |own| format!("{}.{}", own.section, own.name_of_slider()))
            }
        }
    }

    /// Dotted name of the element that has a stop, by the stop's index.
    pub fn name_of_stop(&self, i: usize) -> String {
        self.name_of_part(Part::Stop(i))
    }

    /// Dotted name of the element that has a friction, by the friction's index.
    pub fn name_of_friction(&self, i: usize) -> String {
        self.name_of_part(Part::Friction(i))
    }

    /// Dotted name of the element that has a branch, by the branch's index; for one of the two
    /// tangents of a contact, with the tangent's index: `contact.NAME[0]`.
    pub fn name_of_branch(&self, i: usize) -> String {
        let own = in_series(&self.description).nth(i);
        own.map_or_else(String::new, |own| format!("{}.{}{}", own.section, own.name, own.index))
    }

    /// Dotted name of the element of a contact or a slider.
    pub fn name_of_contact(&self, contact: Contact) -> String {
        match contact {
            Contact::Stop(i) => self.name_of_stop(i),
            Contact::Friction(i) => self.name_of_friction(i),
            Contact::Slider(i) => self.name_of_branch(i),
        }
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
