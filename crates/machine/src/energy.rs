//! Energy accounts: work of loads and prescribed motions, and losses in dashpots, compliant stops,
//! friction and impacts (docs/assembly-law.md (A20) to (A22)). The accounts do not use the
//! mechanical energy, so that the energy balance tests them.

mod long;
mod nodes;
mod powers;

pub use powers::{Powers, Rule, Samples};

use crate::flow::FlowTable;
pub use crate::kernel::{AtNodes, EIGHT, NODES, SHORT};
use crate::system::{Account, Part, System};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use vibro_numerics::double_double::DoubleDouble;

/// Sums since the start, J. Losses are positive.
///
///
/// Friction stops a block of 1 kg that slides with 2 m/s, and takes its 2 J:
///
/// ```
/// use vibro_machine::{Assembly, Motion, file};
///
/// let text = r#"
///     name = "Block"
///     body.block = { mass = 1.0, start = { v = 2.0 } }
///     friction.ground = { between = ["ground", "block"], force = 0.5 }
/// "#;
/// let machine = file::parse(text, "block.toml", &file::no_records)?;
/// let mut motion = Motion::new(Assembly::new(machine)?.into())?;
/// motion.advance_to(10.0)?;
/// assert!((motion.energy().frictions[0].value() - 2.0).abs() < 1e-14);
/// assert!((motion.energy().balance() + 2.0).abs() < 1e-14);
/// assert_eq!(motion.kinetic_and_stored(), (0.0, 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Accounts {
    enabled: bool,
    /// Work of each load.
    pub loads: Vec<DoubleDouble>,
    /// Work of the prescribed motions.
    pub motions: DoubleDouble,
    /// Loss in each spring's dashpot.
    pub dashpots: Vec<DoubleDouble>,
    /// Loss in each compliant stop.
    pub stops: Vec<DoubleDouble>,
    /// Loss in each friction element.
    pub frictions: Vec<DoubleDouble>,
    /// Loss in each dashpot or slider that is in series with a spring.
    pub branches: Vec<DoubleDouble>,
    /// Loss at impacts.
    pub impacts: DoubleDouble,
    /// Energy added by steps of stiffnesses.
    pub switched: DoubleDouble,
}

impl Accounts {
    /// Accounts of a machine, all zero.
    pub fn new(system: &System) -> Self {
        let zero = |count: usize| vec![DoubleDouble::default(); count];
        Self {
            enabled: true,
            loads: zero(system.loads.len()),
            motions: DoubleDouble::default(),
            dashpots: zero(system.springs.len()),
            stops: zero(system.stops.len()),
            frictions: zero(system.frictions.len()),
            branches: zero(system.branches.len()),
            impacts: DoubleDouble::default(),
            switched: DoubleDouble::default(),
        }
    }

    /// Switches the accounts off: their sums no longer change.
    pub fn off(mut self) -> Self {
        self.enabled = false;
        self
    }

    /// Work plus the energy added by steps of stiffnesses, minus losses, J. This equals the change
    /// of the mechanical energy since the start.
    pub fn balance(&self) -> f64 {
        let minus = |sum: DoubleDouble, x: &DoubleDouble| sum.minus(*x);
        let put_in = self.loads.iter().fold(self.motions + self.switched, |sum, x| sum + *x);
        let dashpots = self.dashpots.iter().fold(put_in, minus);
        let stops = self.stops.iter().fold(dashpots, minus);
        let frictions = self.frictions.iter().fold(stops, minus);
        let branches = self.branches.iter().fold(frictions, minus);
        branches.minus(self.impacts).value()
    }

    /// Adds an impact's loss, and the work of prescribed motions in it.
    pub fn impact(&mut self, lost: f64, work: f64) {
        self.impacts = self.impacts.plus(lost);
        self.motions = self.motions.plus(work);
    }

    /// Adds energy from steps of stiffnesses.
    pub(crate) fn switch(&mut self, work: f64) {
        self.switched = self.switched.plus(work);
    }

    /// Adds the loss of a slider that is moved instantaneously.
    pub(crate) fn slide(&mut self, i: usize, lost: f64) {
        self.branches[i] = self.branches[i].plus(lost);
    }

    /// Adds the work and losses over an interval of length `dt` in a mode with these powers.
    /// `values` is scratch memory.
    #[inline(always)]
    pub fn add(&mut self, powers: &Powers, dt: f64, samples: &Samples, values: &mut Vec<AtNodes>) {
        if !self.enabled || dt == 0.0 {
            return;
        }
        powers.for_each(samples, values, |account, power| self.put(account, dt * power));
    }

    /// Adds the work and losses over 2^`k` sub-steps from `z` in a mode with these powers.
    pub fn add_long(&mut self, powers: &Powers, k: usize, table: &FlowTable, z: &[f64]) {
        powers.for_each_work(k, table, z, |account, work| self.put(account, work));
    }

    #[inline(always)]
    fn put(&mut self, account: Account, work: f64) {
        let sum = match account {
            Account::Load(i) => &mut self.loads[i],
            Account::Motions => &mut self.motions,
            Account::Dashpot(i) => &mut self.dashpots[i],
            Account::Stop(i) => &mut self.stops[i],
            Account::Friction(i) => &mut self.frictions[i],
            Account::Branch(i) => &mut self.branches[i],
        };
        *sum = sum.plus(work);
    }

    /// Whether the accounts are enabled.
    pub(crate) fn are_kept(&self) -> bool {
        self.enabled
    }
}

/// Kinetic and stored energy, J. The stored energy is the sum of ½ k e² + preload e over springs,
/// the integrals of curved forces, ½ k max(0, e - gap)² (with an exponent, its integral) over compliant stops and corners of
/// springs, ½ b²/k over springs in series, and the potential energy of weight. Springs by points
/// count from e = 0.
pub fn mechanical(system: &System, z: &DVector<f64>) -> (f64, f64) {
    let (mut kinetic, mut stored) = (0.0, 0.0);
    for ((body, &inertia), &weight) in system.bodies.iter().zip(&system.inertias).zip(&system.weights) {
        let v = body.v.dot(z);
        kinetic += 0.5 * inertia * v * v;
        stored -= weight * body.s.dot(z);
    }
    let is_rigid = |part: Part| !system.is_residual(part);
    let springs = system.springs.iter().enumerate().filter(|own| is_rigid(Part::Spring(own.0)));
    for (_, spring) in springs {
        let e = spring.elongation.e.dot(z);
        stored += e * (0.5 * spring.stiffness * e + spring.preload);
        for &(curve, factor) in &spring.curves {
            let curved = &system.curved[curve];
            if !curved.is_of_rate {
                stored += factor * curved.operation.integral(e);
            }
        }
        if let Some(own) = &spring.formula {
            stored += own.stored(e);
        }
    }
    for (_, branch) in system.branches.iter().enumerate().filter(|own| is_rigid(Part::Branch(own.0))) {
        let force = branch.force.dot(z);
        stored += 0.5 * force * force / branch.stiffness;
    }
    let (stops, others) = system.stops.split_at(system.first_corner);
    let stops = stops.iter().enumerate().filter(|own| is_rigid(Part::Stop(own.0)));
    for (_, stop) in stops.filter(|own| !own.1.is_off(z)) {
        let excess = stop.excess.dot(z).max(0.0);
        stored += match &stop.contact {
            Some(own) => stop.stiffness() * excess.powf(own.exponent + 1.0) / (own.exponent + 1.0),
            None => 0.5 * stop.spring.dot(z).max(0.0) * excess,
        };
    }
    for other in others.iter().filter(|other| !other.is_off(z)) {
        stored += other.stored(z);
    }
    (kinetic, stored + system.stored_in_residual(z.as_slice()) - system.stored_at_zero)
}
