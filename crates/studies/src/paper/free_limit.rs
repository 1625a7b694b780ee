//! Limit of the damped motion without impacts, and whether it is clear of the stops.

use nalgebra::Complex;
use vibro_impact::Parameters;

/// Whether every motion without impacts tends to a limit with the drive's period: its linear flow
/// is damped in every part; the block needs the coupling for this. All starts have one limit if
/// springs hold the box and the secondary oscillator.
pub(crate) fn is_damped(p: &Parameters) -> bool {
    [p.box_damping, p.secondary_damping, p.coupling_stiffness].iter().all(|c| *c > 0.0)
}

/// Dynamic stiffness of the box alone at the drive's frequency, N/m.
pub(crate) fn dynamic_stiffness(p: &Parameters) -> Complex<f64> {
    let omega = p.drive_frequency;
    Complex::new(p.box_stiffness - p.box_mass * omega * omega, p.box_damping * omega)
}

/// Forced vibration of the box alone.
pub(crate) fn forced(p: &Parameters) -> Complex<f64> {
    p.drive_amplitude / dynamic_stiffness(p)
}

/// Positions at which the constant loads hold the three bodies at rest with the block off its
/// stops. Not finite if no spring opposes a load.
pub(crate) fn middle(p: &Parameters) -> [f64; 3] {
    let [box_load, block_load, secondary_load] = p.constant_loads;
    let way = |load: f64, stiffness: f64| if load == 0.0 { 0.0 } else { load / stiffness };
    let secondary = way(block_load + secondary_load, p.secondary_stiffness);
    [way(box_load, p.box_stiffness), secondary + way(block_load, p.coupling_stiffness), secondary]
}

/// Whether the limit of the damped motion without impacts is clear of the stops (docs/theory.md
/// (100)). If it is not clear, every motion meets a stop again, even after a long time without
/// impacts.
pub(crate) fn limit_keeps_clear(p: &Parameters) -> bool {
    let [box_middle, block_middle, _] = middle(p);
    forced(p).norm() + (block_middle - box_middle).abs() < p.stop_gap
}
