//! The equations of motion as the reference method integrates them (paper, section 2;
//! docs/theory.md (3), (13) and (14)).
//!
//! The same equations are in `model.rs` in other coordinates. The copies are deliberate: a
//! mistake in one copy makes the tests that compare the methods fail.

use crate::parameters::Parameters;
use crate::simulator::Loads;

/// x1, x2, x3 (m) and x1', x2', x3' (m/s).
pub(super) type Vector = [f64; 6];

/// Slack of the constraint relative to the coordinates, so that a block on the stop does not count
/// as outside because of rounding.
const SLACK: f64 = 8.0 * f64::EPSILON;

/// The equations of motion, docs/theory.md (3), divided by the masses.
#[derive(Clone, Debug)]
pub(super) struct Law {
    pub(super) m1: f64,
    pub(super) m2: f64,
    /// Reduced mass m1 m2/(m1+m2), docs/theory.md (10).
    pub(super) reduced: f64,
    pub(super) gap: f64,
    pub(super) restitution: f64,
    /// k1/m1.
    stiffness1: f64,
    /// c1/m1.
    damping1: f64,
    /// k23/m2.
    coupling2: f64,
    /// k23/m3.
    coupling3: f64,
    /// k3/m3.
    stiffness3: f64,
    /// c3/m3.
    damping3: f64,
    /// F10/m1.
    amplitude: f64,
    /// ω1.
    frequency: f64,
    /// Phase of the drive at time 0.
    phase: f64,
    /// Polynomial coefficients of the loads divided by the masses, m/s² per s^order, in the time
    /// since `since`.
    loads: Option<[[f64; 4]; 3]>,
    /// Constant loads of the parameters, N.
    constant: [f64; 3],
    masses: [f64; 3],
    since: f64,
}

impl Law {
    /// Equations of a system whose parameters have been checked.
    pub(super) fn new(p: &Parameters, time: f64) -> Self {
        let (m1, m2, m3) = (p.box_mass, p.block_mass, p.secondary_mass);
        let mut law = Self {
            m1,
            m2,
            reduced: m1 / (m1 + m2) * m2,
            gap: p.stop_gap,
            restitution: p.stop_restitution,
            stiffness1: p.box_stiffness / m1,
            damping1: p.box_damping / m1,
            coupling2: p.coupling_stiffness / m2,
            coupling3: p.coupling_stiffness / m3,
            stiffness3: p.secondary_stiffness / m3,
            damping3: p.secondary_damping / m3,
            amplitude: p.drive_amplitude / m1,
            frequency: p.drive_frequency,
            phase: p.drive_phase,
            loads: None,
            constant: p.constant_loads,
            masses: [m1, m2, m3],
            since: time,
        };
        law.set_loads(&Loads::default(), time);
        law
    }

    /// Sets the loads as polynomials in the time after `time`. The constant loads add to them.
    pub(super) fn set_loads(&mut self, loads: &Loads, time: f64) {
        self.since = time;
        let none = *loads == Loads::default() && self.constant == [0.0; 3];
        self.loads = (!none).then(|| {
            std::array::from_fn(|b| {
                let mut d = loads.derivatives[b];
                d[0] += self.constant[b];
                let d = d.map(|d| d / self.masses[b]);
                [d[0], d[1], d[2] / 2.0, d[3] / 6.0]
            })
        });
    }

    /// Typical angular frequency, rad/s, for the scale of velocities.
    pub(super) fn rate(&self, p: &Parameters) -> f64 {
        let rate = p.drive_frequency.max(self.stiffness1.sqrt());
        let rate =
            if rate > 0.0 { rate } else { self.coupling2.max(self.stiffness3 + self.coupling3).sqrt() };
        if rate > 0.0 { rate } else { 1.0 }
    }

    /// Tolerance for the rounding of a block on the stop, m: its distance past the stop.
    pub(super) fn slack(&self, y: &Vector) -> f64 {
        SLACK * (y[0].abs() + y[1].abs() + self.gap)
    }

    /// Drive acceleration of the box, m/s².
    #[inline]
    pub(super) fn drive(&self, time: f64) -> f64 {
        self.amplitude * (self.frequency * time + self.phase).sin()
    }

    /// Accelerations of the free bodies, m/s².
    #[inline]
    pub(super) fn accelerations(&self, y: &Vector, drive: f64, time: f64) -> [f64; 3] {
        let stretch = y[1] - y[2];
        let mut a = [
            drive - self.damping1 * y[3] - self.stiffness1 * y[0],
            -self.coupling2 * stretch,
            self.coupling3 * stretch - self.damping3 * y[5] - self.stiffness3 * y[2],
        ];
        if let Some(loads) = &self.loads {
            let t = time - self.since;
            for (a, c) in a.iter_mut().zip(loads) {
                *a += c[0] + t * (c[1] + t * (c[2] + t * c[3]));
            }
        }
        a
    }

    /// Right-hand side of the mode: flight for `side` 0, otherwise rest on that stop,
    /// docs/theory.md (13).
    #[inline]
    pub(super) fn slope(&self, y: &Vector, drive: f64, time: f64, side: f64) -> Vector {
        let mut a = self.accelerations(y, drive, time);
        if side != 0.0 {
            let common = (self.m1 * a[0] + self.m2 * a[1]) / (self.m1 + self.m2);
            (a[0], a[1]) = (common, common);
        }
        [y[3], y[4], y[5], a[0], a[1], a[2]]
    }

    /// Contact force of rest on stop `side`, docs/theory.md (14), N. It is negative if the block
    /// would leave the stop.
    pub(super) fn force(&self, y: &Vector, drive: f64, time: f64, side: f64) -> f64 {
        let a = self.accelerations(y, drive, time);
        self.reduced * side * (a[1] - a[0])
    }
}
