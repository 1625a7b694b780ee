//! Orbits near a resonance of an undamped mode against the closed form.

use crate::paper::{Orbit, OrbitWord, System};
use vibro_impact::parameters::Parameters;
use vibro_impact::steady::exact_orbit;

/// Tolerance of phases (rad) and, relatively, of the largest multipliers. Near the resonance,
/// force and impacts cancel, and digits are lost.
const CANCELLED: f64 = 1e-6;

/// A machine whose box, or whose pair of block and secondary oscillator, oscillates undamped at
/// `1 + off` times the drive frequency.
fn machine(box_swings: bool, off: f64) -> Parameters {
    let frequency = 1.4 * (1.0 + off);
    let square = frequency * frequency;
    let p = Parameters {
        box_mass: 1.9,
        box_stiffness: 1.9 * square,
        box_damping: 0.0,
        block_mass: 0.057,
        secondary_mass: 0.15,
        secondary_stiffness: 0.0193,
        secondary_damping: 0.0035,
        coupling_stiffness: 0.033,
        stop_restitution: 0.0,
        drive_amplitude: 0.0687,
        drive_frequency: 1.4,
        ..Parameters::default()
    };
    if box_swings {
        return p;
    }
    let (block, coupling) = (p.coupling_stiffness - p.block_mass * square, p.coupling_stiffness);
    let secondary_stiffness = coupling * coupling / block - coupling + p.secondary_mass * square;
    Parameters { box_stiffness: 2.2, box_damping: 0.3, secondary_damping: 0.0, secondary_stiffness, ..p }
}

#[test]
fn closed_form_of_symmetric_orbits_next_to_a_resonance() {
    let word = OrbitWord::new("U", -1, 1).unwrap();
    let mut found = [0; 2];
    for k in 0..40 {
        let size = 1e-3 * 0.8_f64.powi(k);
        for (box_swings, off) in [(true, size), (true, -size), (false, size), (false, -size)] {
            let p = machine(box_swings, off);
            let roots = exact_orbit::solve(&p).unwrap();
            for exact in [roots.lower, roots.upper].into_iter().flatten().filter(|o| o.is_clear()) {
                let own = Orbit::find(&System::new(&p).unwrap(), &word, &[exact.drive_phase()]).unwrap();
                assert!(own.is_certified(), "{box_swings} {off:e}");
                assert!((own.phases()[0] - exact.drive_phase()).abs() < CANCELLED, "{box_swings} {off:e}");
                let [a, b] = [own.spectral_radius(), exact.spectral_radius()];
                assert!((a / b - 1.0).abs() < CANCELLED, "{box_swings} {off:e} {a} {b}");
                found[usize::from(box_swings)] += 1;
            }
        }
    }
    assert!(found.iter().all(|n| *n > 40), "{found:?}");
}
