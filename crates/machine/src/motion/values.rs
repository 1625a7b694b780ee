//! Values of a motion at its present time: bodies, elements and quantities.

use super::Motion;
use crate::mode::{Contact, FrictionState, StopState};
use crate::quantity::{Owner, Quantity, What};
use crate::system::{Elongation, Part};

impl Motion {
    /// A body's coordinate, rate and acceleration: m, m/s, m/s² or rad, rad/s, rad/s².
    pub fn body(&self, i: usize) -> [f64; 3] {
        let system = &self.assembly.system;
        let (rows, z, n) = (&system.bodies[i], &self.hybrid.z, system.coordinates);
        if system.is_residual_node(i) {
            let [s, v] = system.seen(i);
            let rates = v.terms().iter().map(|&(j, x)| x * self.table().a.row_times(j, z.as_slice()));
            return [s.dot(z), v.dot(z), rates.sum()];
        }
        let weights = rows.weights.terms().iter();
        let acceleration: f64 =
            weights.map(|&(k, w)| w * self.table().a.row_times(n + k, z.as_slice())).sum();
        [rows.s.dot(z), rows.v.dot(z), acceleration + rows.drift.dot(z)]
    }

    /// A body's coordinate, m or rad.
    pub fn coordinate(&self, i: usize) -> f64 {
        self.assembly.system.seen(i)[0].dot(&self.hybrid.z)
    }

    /// The rate of a body's coordinate, m/s or rad/s.
    pub fn rate(&self, i: usize) -> f64 {
        self.assembly.system.seen(i)[1].dot(&self.hybrid.z)
    }

    /// A spring's elongation, its rate and its force.
    pub fn spring(&self, i: usize) -> [f64; 3] {
        let (spring, z) = (&self.assembly.system.springs[i], &self.hybrid.z);
        let mut force = spring.force.dot(z);
        // The corners between its lines are stops; springs and dampers are the first elements.
        for part in &self.assembly.system.parts[i][1..] {
            if let Part::Stop(corner) = *part {
                force += self.stop_varied(corner)[2];
            }
        }
        let [e, rate] = self.seen_elongation(Part::Spring(i), &spring.elongation);
        [e, rate, force]
    }

    /// A stop's elongation, its rate and its force.
    ///
    ///
    /// A block that rests on a floor presses it with its weight:
    ///
    /// ```
    /// use vibro_machine::{Assembly, Motion, file};
    ///
    /// let text = r#"
    ///     name = "Resting"
    ///     gravity = 10.0
    ///     start = "rest"
    ///     body.block = { mass = 3.0, gravity = 1.0 }
    ///     stop.floor = { between = ["ground", "block"], gap = 0.5, restitution = 0.2 }
    /// "#;
    /// let machine = file::parse(text, "resting.toml", &file::no_records)?;
    /// let motion = Motion::new(Assembly::new(machine)?.into())?;
    /// let [elongation, rate, force] = motion.stop(0);
    /// assert_eq!((elongation, rate), (0.5, 0.0));
    /// assert!((force - 30.0).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn stop(&self, i: usize) -> [f64; 3] {
        let present = self.assembly.system.present(i, &self.hybrid.mode.stops);
        let [e, rate, _] = self.stop_varied(i);
        [e, rate, self.part_force(present)]
    }

    /// Returns the state of a stop, at the present level of its stiffness.
    pub fn stop_state(&self, i: usize) -> StopState {
        let stops = &self.hybrid.mode.stops;
        stops[self.assembly.system.present(i, stops)]
    }

    /// The force of a stop, or of a corner of a spring.
    fn part_force(&self, i: usize) -> f64 {
        let [_, _, force] = self.stop_varied(i);
        // The force of most stops is never a pull, by (A14); if it vanishes, rounding has either
        // sign. A host's solver goes beyond the end of a contact and sees the pull that its
        // accelerations contain.
        let system = &self.assembly.system;
        let is_contact =
            (system.first_contact..system.first_corner).contains(&i) || system.is_residual(Part::Stop(i));
        let is_seen = self.overshoot > 0.0 || (system.stops[i].may_pull() && !is_contact);
        if is_seen { force } else { force.max(0.0) }
    }

    /// Returns a stop's elongation, its rate and its force as linear functions of the state. The
    /// force may be negative.
    fn stop_varied(&self, i: usize) -> [f64; 3] {
        let (system, z) = (&self.assembly.system, &self.hybrid.z);
        let stop = &system.stops[i];
        let state = self.hybrid.mode.stops[i];
        let force = match state {
            StopState::Closed => self.contact_force(Contact::Stop(i)),
            _ => system.stop_force_at(i, state, z).unwrap_or(0.0),
        };
        let [e, rate] = self.seen_elongation(Part::Stop(i), &stop.elongation);
        [e, rate, force]
    }

    /// Elongation and rate of a part, with residual flexibility.
    fn seen_elongation(&self, part: Part, own: &Elongation) -> [f64; 2] {
        let rows = self.assembly.system.seen_elongation(part).unwrap_or([&own.e, &own.rate]);
        rows.map(|row| row.dot(&self.hybrid.z))
    }

    /// A friction element's elongation, its rate and its force.
    pub fn friction(&self, i: usize) -> [f64; 3] {
        let (system, z) = (&self.assembly.system, &self.hybrid.z);
        let friction = &system.frictions[i];
        let state = self.hybrid.mode.frictions[i];
        let force = match state {
            FrictionState::Stuck => self.contact_force(Contact::Friction(i)),
            _ => system.friction_force_at(i, state, &self.hybrid.mode.stops, z).unwrap_or(0.0),
        };
        [friction.elongation.e.dot(z), friction.elongation.rate.dot(z), force]
    }

    /// Returns the value of a quantity of the machine, in SI units.
    ///
    ///
    /// ```
    /// use vibro_machine::{Assembly, Motion, file};
    ///
    /// let text = r#"
    ///     name = "Oscillator"
    ///     body.a = { mass = 1.0, start = { s = 1.0 } }
    ///     spring.k = { between = ["ground", "a"], stiffness = 4.0 }
    /// "#;
    /// let machine = file::parse(text, "oscillator.toml", &file::no_records)?;
    /// let named = machine.named_quantities();
    /// let force = named.iter().find(|own| own.name == "k.f").unwrap().quantity;
    /// let mut motion = Motion::new(Assembly::new(machine)?.into())?;
    /// motion.advance_to(0.7)?;
    /// assert!((motion.value(force) - 4.0 * 1.4f64.cos()).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn value(&self, quantity: Quantity) -> f64 {
        self.value_by(quantity, |i| self.part_force(i))
    }

    /// Returns the value of a quantity in a motion that represents a derivative: a stop's force
    /// may have either sign.
    pub fn value_varied(&self, quantity: Quantity) -> f64 {
        self.value_by(quantity, |i| self.stop_varied(i)[2])
    }

    fn value_by(&self, quantity: Quantity, stop_force: impl Fn(usize) -> f64) -> f64 {
        let i = match (quantity.owner, quantity.what) {
            (Owner::Body(i), What::S) => return self.coordinate(i),
            (Owner::Body(i), What::V) => return self.rate(i),
            (Owner::Body(i), _) => return self.body(i)[2],
            (Owner::Element(i), _) => i,
        };
        let (parts, z) = (self.assembly.system.parts_of(i, quantity.what), &self.hybrid.z);
        let elongation = || parts.first().and_then(|part| self.assembly.system.seen_elongation(*part));
        let branch = |k| self.assembly.system.branch_of(i, k);
        match quantity.what {
            What::F | What::TangentF(_) => {
                let force = |part: &Part| match *part {
                    Part::Spring(i) => self.assembly.system.springs[i].force.dot(z),
                    Part::Stop(i) => stop_force(i),
                    Part::Friction(i) => self.friction(i)[2],
                    Part::Branch(i) => self.branch_force(i),
                    Part::Load(i) => self.load(i),
                };
                parts.iter().map(force).sum()
            }
            What::Slider(k) => branch(k).map_or(0.0, |i| self.inner_place(i)),
            What::SliderRate(k) => branch(k).map_or(0.0, |i| self.inner_rate(i)),
            What::Value | What::Output(_) => {
                self.assembly.system.block_row(i, quantity.what, &self.hybrid.mode.stops).dot(z)
            }
            What::State(_) | What::StateRate(_) => {
                let place = self.assembly.system.block_place(i, quantity.what);
                match quantity.what {
                    What::StateRate(_) => self.table().a.row_times(place, z.as_slice()),
                    _ => z[place],
                }
            }
            What::E | What::TangentE(_) => elongation().map_or(0.0, |own| own[0].dot(z)),
            _ => elongation().map_or(0.0, |own| own[1].dot(z)),
        }
    }

    /// A load's force.
    pub fn load(&self, i: usize) -> f64 {
        let (system, z, stops) = (&self.assembly.system, &self.hybrid.z, &self.hybrid.mode.stops);
        // The difference of two values would have the rounding of the unlimited output.
        if system.load_limits[i].iter().any(|own| stops[own.0] == StopState::Pressed) {
            return system.load_row(i, stops).dot(z);
        }
        system.loads[i].dot(z)
    }

    /// The force of a spring in series.
    pub(super) fn branch_force(&self, i: usize) -> f64 {
        let state = self.hybrid.mode.sliders[i];
        self.assembly.system.branch_force_at(i, state, self.hybrid.z.as_slice())
    }

    fn contact_force(&self, contact: Contact) -> f64 {
        let place = self.hybrid.mode.basis.iter().position(|&c| c == contact);
        place.map_or(0.0, |k| self.table().lambda[k].dot(self.hybrid.z.as_slice()))
    }
}
