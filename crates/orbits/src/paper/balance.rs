//! Reference positions of the three bodies for the states of an orbit.
//!
//! If springs hold the constant loads within reach of the stops, these are the rest positions,
//! docs/theory.md (99). Otherwise they are positions close together, with unbalanced loads.

use vibro_impact::parameters::{LOADS, Parameters};
use vibro_impact::simulator::Loads;
use vibro_impact::steady::exact_orbit::Vector6;
use vibro_studies::Result;

/// Constant loads on box, block and secondary oscillator, N: gravity, the tilt of the machine, an
/// off-centre gap.
///
/// Constant loads affect impacts only through the displacement w_s of the block in the box without
/// impacts (docs/theory.md (100)). A gap whose middle is b above the centre is the machine under
/// the loads (0, -k23 b, k23 b), docs/theory.md (97). A block without a spring has no static
/// displacement: it falls, and the load's acceleration acts on its flights instead (docs/theory.md
/// (111)).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ConstantLoads {
    /// On the box, the block and the secondary oscillator.
    pub forces: [f64; 3],
}

impl ConstantLoads {
    /// The loads in the simulator's form.
    pub fn loads(&self) -> Loads {
        Loads { derivatives: self.forces.map(|f| [f, 0.0, 0.0, 0.0]) }
    }
}

/// Upper limit of a soft spring's stiffness, relative to mass times ω1². Without an anchor the
/// equations of an orbit lose at least three digits there.
const SOFT: f64 = 1e-2;

/// The bodies whose position a missing or soft spring does not determine, docs/theory.md (112).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    /// The box, without a spring to the ground.
    Box,
    /// The block, without a spring to the secondary oscillator.
    Block,
    /// Block and secondary oscillator, without a spring to the ground.
    Pair,
}

impl Anchor {
    /// State index of the displacement whose return the first contact replaces.
    pub(super) fn place(self) -> usize {
        usize::from(self != Self::Box)
    }

    /// Index of the displacement that moves with the anchored one. The equations contain the
    /// return of their difference.
    pub(super) fn follower(self) -> Option<usize> {
        (self == Self::Pair).then_some(2)
    }

    /// All anchors, each with the stiffness holding it, relative to mass times ω1².
    pub(super) fn held(p: &Parameters) -> [(Self, f64); 3] {
        let part = |stiffness: f64, mass: f64| stiffness / (mass * p.drive_frequency.powi(2));
        [
            (Self::Box, part(p.box_stiffness, p.box_mass)),
            (Self::Block, part(p.coupling_stiffness, p.block_mass)),
            (Self::Pair, part(p.secondary_stiffness, p.block_mass + p.secondary_mass)),
        ]
    }

    /// The anchor with the smallest stiffness in any of the given machines; `None` unless this
    /// stiffness is soft.
    pub(super) fn of<'a>(machines: impl Iterator<Item = &'a Parameters>) -> Option<Self> {
        let least = machines.flat_map(Self::held).min_by(|a, b| a.1.total_cmp(&b.1));
        least.filter(|(_, stiffness)| *stiffness <= SOFT).map(|(anchor, _)| anchor)
    }
}

/// Displacement of the block in the box, units of L, beyond which states are measured from
/// positions close together. At this limit two digits are lost, and no motion without impacts
/// stays within the stops.
const FAR: f64 = 100.0;

/// Largest displacement, units of L. Differences of smaller displacements, and their products with
/// the rates of a machine, do not overflow.
const FARTHEST: f64 = 1e100;

/// Reference positions, units of L, and the unbalanced loads there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Balance {
    /// The reference positions.
    pub places: [f64; 3],
    /// The constant part of a state's rate, d of docs/theory.md (111).
    pub push: Vector6,
    /// Rest positions under the loads; a block without a spring is at the middle of the box.
    held: [f64; 3],
}

impl Balance {
    /// Displacement of the block in the box if the springs hold the loads.
    pub fn offset(&self) -> f64 {
        self.held[1] - self.held[0]
    }

    /// This balance with the rest positions as reference positions.
    pub fn at_rest(self) -> Self {
        if self.places == self.held {
            self
        } else {
            Self { places: self.held, push: Vector6::zeros(), ..self }
        }
    }
}

/// The balance of a machine under loads.
///
/// # Errors
/// An error if a load is not finite, if it acts on a body without a spring, or if a spring would
/// hold it farther than 1e100 L away.
pub(super) fn balance(p: &Parameters, loads: ConstantLoads) -> Result<Balance> {
    let held = rest(p, loads)?;
    let anchor = Anchor::of(std::iter::once(p)).filter(|_| (held[1] - held[0]).abs() > FAR);
    let places = anchor.map_or(held, |anchor| near(p, loads, held, anchor));
    let acceleration = |force: f64, mass: f64| force / (mass * p.stop_gap * p.drive_frequency.powi(2));
    let [f1, f2, f3] = loads.forces;
    let mut push = Vector6::zeros();
    if anchor.is_some() {
        let [x1, x2, x3] = places.map(|x| x * p.stop_gap);
        let coupling = p.coupling_stiffness * (x2 - x3);
        push[3] = acceleration(f1 - p.box_stiffness * x1, p.box_mass);
        push[4] = acceleration(f2 - coupling, p.block_mass);
        push[5] = acceleration(f3 + coupling - p.secondary_stiffness * x3, p.secondary_mass);
    } else if p.coupling_stiffness == 0.0 {
        push[4] = acceleration(f2, p.block_mass);
    }
    Ok(Balance { places, push, held })
}

/// Reference positions close together, with all bodies in balance except the softly held ones.
fn near(p: &Parameters, loads: ConstantLoads, [x1, x2, x3]: [f64; 3], anchor: Anchor) -> [f64; 3] {
    let [_, f2, f3] = loads.forces.map(|force| force / p.stop_gap);
    let (coupling, ground) = (p.coupling_stiffness, p.secondary_stiffness);
    match anchor {
        Anchor::Box => [x2, x2, x3],
        Anchor::Block => [x1, x1, (f3 + coupling * x1) / (coupling + ground)],
        Anchor::Pair => [x1, x1, x1 - f2 / coupling],
    }
}

/// The displacements at which the springs hold the loads, units of L: docs/theory.md (99).
fn rest(p: &Parameters, loads: ConstantLoads) -> Result<[f64; 3]> {
    let [f1, f2, f3] = loads.forces;
    for (field, value) in LOADS.iter().zip(loads.forces) {
        if !value.is_finite() {
            let name = field.name;
            let error = vibro_impact::Error::OutOfRange { name, value, allowed: "a finite number" };
            return Err(error.into());
        }
    }
    let held = |name, load: f64, stiffness: f64, allowed| {
        if load == 0.0 {
            Ok(0.0)
        } else if stiffness > 0.0 {
            Ok(load / stiffness)
        } else {
            let needed_by = "orbit under a constant load";
            Err(vibro_impact::Error::Undefined { name, value: stiffness, needed_by, allowed })
        }
    };
    let x1 = held("box.k", f1, p.box_stiffness, "box.k > 0, or load.box = 0")?;
    let third = |load, allowed| held("secondary.k", load, p.secondary_stiffness, allowed);
    let x = if p.coupling_stiffness == 0.0 {
        [x1, x1, third(f3, "secondary.k > 0, or load.secondary = 0")?]
    } else {
        let x3 = third(f2 + f3, "secondary.k > 0, or load.block + load.secondary = 0")?;
        [x1, x3 + f2 / p.coupling_stiffness, x3]
    };
    let places = x.map(|x| x / p.stop_gap);
    let springs = [
        (0, "box.k", p.box_stiffness),
        (2, "secondary.k", p.secondary_stiffness),
        (1, "coupling.k", p.coupling_stiffness),
    ];
    // False for NaN.
    let told = |place: f64| (-FARTHEST..=FARTHEST).contains(&place);
    match springs.into_iter().find(|(body, ..)| !told(places[*body])) {
        None => Ok(places),
        Some((_, name, value)) => {
            let (needed_by, allowed) = (
                "orbit under a constant load",
                "a larger value, so that the load displaces the body by less than 1e100 gaps",
            );
            Err(vibro_impact::Error::Undefined { name, value, needed_by, allowed }.into())
        }
    }
}
