//! Motions that continue with changed parameters, or from a saved state.

use super::jump::Parted;
use super::{Hybrid, Motion};
use crate::assembly::Assembly;
use crate::error::Error;
use crate::law::Sizes;
use crate::mode::{Contact, StopState};
use crate::signals::Input;
use crate::system::{BlockRows, System};
use nalgebra::DVector;
use std::sync::Arc;
use vibro_numerics::double_double::DoubleDouble;

/// Returns the entries of sliders in the list of kept places.
fn inner_places(standing: &[(Contact, f64)]) -> Vec<(Contact, f64)> {
    standing.iter().filter(|held| matches!(held.0, Contact::Slider(_))).copied().collect()
}

impl Motion {
    /// Continues from a saved state; `None` if the state does not [fit](Hybrid::fits) the machine.
    ///
    ///
    /// A saved state continues in another motion of the machine, with the same bits:
    ///
    /// ```
    /// use std::sync::Arc;
    /// use vibro_machine::{Assembly, Motion, file};
    ///
    /// # let text = r#"
    /// #     name = "Ball"
    /// #     gravity = 9.81
    /// #     body.ball = { mass = "20 g", gravity = 1.0 }
    /// #     stop.floor = { between = ["ground", "ball"], gap = "1 m", restitution = 0.9 }
    /// # "#;
    /// let machine = file::parse(text, "ball.toml", &file::no_records)?;
    /// let assembly = Arc::new(Assembly::new(machine)?);
    /// let mut motion = Motion::new(assembly.clone())?;
    /// motion.advance_to(0.6)?;
    /// let mut copy = Motion::resumed(assembly, &motion.save()).unwrap();
    /// motion.advance_to(3.0)?;
    /// copy.advance_to(3.0)?;
    /// assert_eq!(copy.save(), motion.save());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn resumed(assembly: Arc<Assembly>, saved: &Hybrid) -> Option<Self> {
        if !saved.fits(&assembly) {
            return None;
        }
        let mut motion = Self::of(assembly, saved.clone());
        motion.take_rows();
        motion.place = motion.tables.place_of(&saved.mode, &motion.assembly.system);
        Some(motion)
    }

    /// Continues from the present instant in a machine with the same elements and changed
    /// parameters. Bodies keep coordinates and rates; signals take their new values at once. A
    /// pending event is applied first, with the old parameters. The energy accounts continue, so
    /// that the balance jumps by the energy that the change has added.
    ///
    /// # Errors
    /// [`Error::Violated`] if a rigid stop's gap is now less than its e; [`Error::Jammed`];
    /// [`Error::OutOfRange`] for a machine with another number of stops or states, or with other
    /// bodies as coordinates.
    ///
    /// # Examples
    /// An oscillator with ω = 2 rad/s passes its middle with 2 m/s after π/4 s. A spring four
    /// times as stiff then doubles ω and halves the amplitude:
    ///
    /// ```
    /// use std::f64::consts::PI;
    /// use vibro_machine::{Assembly, Motion, file};
    ///
    /// # let text = r#"
    /// #     name = "Oscillator"
    /// #     body.a = { mass = 1.0, start = { s = 1.0 } }
    /// #     spring.k = { between = ["ground", "a"], stiffness = 4.0 }
    /// # "#;
    /// let machine = file::parse(text, "oscillator.toml", &file::no_records)?;
    /// let stiffer = Assembly::new(machine.with([("spring.k.stiffness", 16.0)])?)?;
    /// let mut motion = Motion::new(Assembly::new(machine)?.into())?;
    /// motion.advance_to(PI / 4.0)?;
    /// let mut motion = motion.changed(stiffer.into())?;
    /// motion.advance_to(3.0 * PI / 8.0)?;
    /// assert!((motion.coordinate(0) + 0.5).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn changed(&self, assembly: Arc<Assembly>) -> Result<Self, Error> {
        let mut old = self.clone();
        old.pass_event(&mut None)?;
        old.include_flight();
        let stood = old.before_jump();
        let (system, bodies) = (&assembly.system, &old.assembly.system.bodies_of);
        let other = system.states() != old.assembly.system.states();
        if system.bodies_of != *bodies || system.stops.len() != old.hybrid.impacts.len() || other {
            let (value, allowed) =
                (system.coordinates as f64, format!("{}, as in this motion", bodies.len()));
            return Err(Error::OutOfRange {
                name: "coordinates of the changed machine".into(),
                value,
                allowed,
            });
        }
        let Hybrid { time, inputs, .. } = &old.hybrid;
        let (size, own) = (system.signals.size, system.signals.one);
        let mut z = DVector::zeros(size);
        z.rows_mut(0, own).copy_from(&old.hybrid.z.rows(0, own));
        let inputs = old.going_on(system, (*time, inputs), &mut z);
        let was = old.assembly.system.elongations_in_series(old.hybrid.z.as_slice());
        let mut sizes = Sizes(DVector::zeros(size));
        sizes.0.rows_mut(0, own).copy_from(&old.hybrid.sizes.0.rows(0, own));
        sizes.0.rows_range_mut(own..system.signals.constant_size_until()).fill(1.0);
        system.fill_curved(z.as_mut_slice());
        sizes.include(z.as_slice());
        system.include_curved(z.as_slice(), sizes.0.as_mut_slice());
        let departing = Vec::new();
        let is_own = |(a, b): (&BlockRows, &BlockRows)| {
            let times = |own: &BlockRows| own.sampler.as_ref().map(|own| [own.period, own.delay]);
            times(a) == times(b)
        };
        let pairs = system.blocks.iter().zip(&old.assembly.system.blocks);
        let clocks = match pairs.into_iter().all(is_own) {
            true => old.hybrid.clocks.clone(),
            false => system.clocks(time.value(), false),
        };
        let hybrid = Hybrid {
            clocks,
            z,
            since: time.value(),
            sizes,
            departing,
            inputs,
            chain: 0,
            carried: 0,
            turns: 0,
            last: None,
            standing: inner_places(&old.hybrid.standing),
            due: None,
            ..old.hybrid
        };
        let (overshoot, is_general, most_work) = (old.overshoot, old.is_general, old.most_work);
        let mut motion = Self { overshoot, is_general, most_work, ..Self::of(assembly, hybrid) };
        motion.tables.most = old.tables.most;
        motion.stretch(&was);
        let mut parted = stood.map_or_else(Parted::default, |mut stood| {
            stood.branches = motion.assembly.system.elongations_in_series(motion.hybrid.z.as_slice());
            motion.jump(&stood)
        });
        parted.sliders = true;
        motion.clamp();
        motion.open_grown_gaps()?;
        motion.settle(&[], &parted, &mut None)?;
        Ok(motion)
    }

    /// Returns inputs with which the integrals of a changed machine continue from their present
    /// values; fills in its signals.
    fn going_on(
        &self,
        system: &System,
        (time, inputs): (DoubleDouble, &[(f64, Input)]),
        z: &mut DVector<f64>,
    ) -> Vec<(f64, Input)> {
        let (was, mut inputs) = (&self.assembly.system, inputs.to_vec());
        system.signals.fill(time, &inputs, z.as_mut_slice());
        let bodies = self.assembly.description.bodies.iter().enumerate();
        let prescribed = bodies.filter(|(_, body)| body.kind.is_prescribed()).map(|(i, _)| i);
        for (signal, body) in prescribed.enumerate() {
            let (own, old) = (&system.bodies[body], &was.bodies[body]);
            let moved = [old.s.dot(&self.hybrid.z) - own.s.dot(z), old.v.dot(&self.hybrid.z) - own.v.dot(z)];
            system.signals.displace(&mut inputs, signal, time.value(), moved);
        }
        system.signals.fill(time, &inputs, z.as_mut_slice());
        inputs
    }

    /// Opens closed stops whose gap has grown and freewheels that get a rate. Refuses stops whose
    /// gap is now less than e.
    fn open_grown_gaps(&mut self) -> Result<(), Error> {
        let (system, sizes) = (&self.assembly.system, &self.hybrid.sizes);
        let mut off = Vec::new();
        for (i, stop) in system.stops.iter().enumerate().filter(|(_, stop)| stop.keeps_gap()) {
            let (excess, zero) = (stop.excess.dot(&self.hybrid.z), sizes.zero_of(&stop.excess));
            if excess > zero {
                return Err(self.violated(i, excess));
            }
            if excess < -zero {
                off.push(i);
            }
        }
        // A freewheel whose changed arms give it a rate is no longer engaged.
        let turns = |&i: &usize| {
            let rate = &system.stops[i].elongation.rate;
            rate.dot(&self.hybrid.z).abs() > sizes.zero_of(rate)
        };
        off.extend(system.freewheels().filter(turns));
        off.into_iter().for_each(|i| self.hybrid.mode.stops[i] = StopState::Open);
        Ok(())
    }
}
