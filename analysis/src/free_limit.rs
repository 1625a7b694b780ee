//! The motion without impacts to which dampers lead: whether there is one, and whether the stops
//! are in its way.

use nalgebra::Complex;
use vibro_impact::Parameters;

/// Whether a motion without impacts comes to a limit of the drive's period: its flow is linear, and
/// every part of it is damped, for which the block needs the coupling. It is one limit for all
/// starts where springs hold the box and the secondary oscillator.
pub(crate) fn is_damped(p: &Parameters) -> bool {
    [p.box_damping, p.secondary_damping, p.coupling_stiffness].iter().all(|c| *c > 0.0)
}

/// The force that vibrates the box alone by one metre at the drive's frequency.
pub(crate) fn dynamic_stiffness(p: &Parameters) -> Complex<f64> {
    let omega = p.drive_frequency;
    Complex::new(p.box_stiffness - p.box_mass * omega * omega, p.box_damping * omega)
}

/// The forced vibration of the box alone.
pub(crate) fn forced(p: &Parameters) -> Complex<f64> {
    p.drive_amplitude / dynamic_stiffness(p)
}

/// Where the constant loads hold the three bodies when nothing moves and the block is off its
/// stops. Not finite where a load has no spring against it.
pub(crate) fn middle(p: &Parameters) -> [f64; 3] {
    let [box_load, block_load, secondary_load] = p.constant_loads;
    let way = |load: f64, stiffness: f64| if load == 0.0 { 0.0 } else { load / stiffness };
    let secondary = way(block_load + secondary_load, p.secondary_stiffness);
    [way(box_load, p.box_stiffness), secondary + way(block_load, p.coupling_stiffness), secondary]
}

/// Whether the motion without impacts to which dampers lead keeps clear of the stops
/// (docs/theory.md (100)). Where it does not, every motion comes back to a stop, however long it
/// has met none.
pub(crate) fn limit_keeps_clear(p: &Parameters) -> bool {
    let [box_middle, block_middle, _] = middle(p);
    forced(p).norm() + (block_middle - box_middle).abs() < p.stop_gap
}
