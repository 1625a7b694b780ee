//! Energy accounts: the work of drive and loads and the losses in the dampers, integrated as
//! quadratic forms of the exact flow (docs/theory.md, section 12; docs/numerics.md, "Energy
//! accounts"). The accounts do not use the mechanical energy, so the energy balance tests them.

use crate::flow::{CENTRED, CORE, INTERVALS, Series, SubstepTable, UnitColumn, polynomial};
use crate::model::{
    Augmented, BOX, BOX_RATE, COORDINATES, DRIVE_COS, DRIVE_SIN, Forces, Model, RELATIVE_RATE,
    SECONDARY_RATE, SmoothMode,
};
use crate::parameters::Parameters;
use pulp::Simd;
use serde::{Deserialize, Serialize};
use vibro_numerics::double_double::DoubleDouble;
use vibro_numerics::simd::{StateRows, form, form_and_squares};

/// Gauss–Legendre rule on [0, 1].
pub struct Rule<const N: usize> {
    /// Nodes in (0, 1).
    pub nodes: [f64; N],
    /// Weights, of sum 1.
    pub weights: [f64; N],
}

/// Rule of five nodes. Over a length of 0.15/rate its error is under 6e-17 of the largest power
/// times the length (docs/numerics.md, section 4).
pub const FIVE: Rule<5> = Rule {
    nodes: [
        0.046_910_077_030_668_004,
        0.230_765_344_947_158_45,
        0.5,
        0.769_234_655_052_841_5,
        0.953_089_922_969_332,
    ],
    weights: [
        0.118_463_442_528_094_54,
        0.239_314_335_249_683_23,
        0.284_444_444_444_444_44,
        0.239_314_335_249_683_23,
        0.118_463_442_528_094_54,
    ],
};
/// Rule of four nodes. Over a length of 0.075/rate its error is under 3e-15 of the largest power
/// times the length (docs/numerics.md, section 4).
const FOUR: Rule<4> = Rule {
    nodes: [
        0.069_431_844_202_973_71,
        0.330_009_478_207_571_87,
        0.669_990_521_792_428_1,
        0.930_568_155_797_026_3,
    ],
    weights: [
        0.173_927_422_568_726_93,
        0.326_072_577_431_273_1,
        0.326_072_577_431_273_1,
        0.173_927_422_568_726_93,
    ],
};

/// Number of forms for input energy, and for damped energy: one from a sub-step's start to each
/// interval centre, and one to the sub-step's end.
const PREFIXES: usize = INTERVALS + 1;
/// Matrix of a quadratic form of the augmented state.
type Form = [[f64; COORDINATES]; COORDINATES];

/// Running sums in J, in extended precision so that 10⁶ periods lose nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sums {
    /// Work of drive and loads, and energy added by changes of parameters.
    pub input: DoubleDouble,
    /// Energy dissipated in the dampers.
    pub damped: DoubleDouble,
    /// Energy lost at impacts.
    pub impact: DoubleDouble,
}

/// Energies of the latest sub-steps in doubles, J, not yet added to the [`Sums`]; zero between two
/// advances.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub struct Pending {
    /// Dissipated energy, as parts to be summed.
    pub damped: [f64; COORDINATES],
    /// Work of the drive.
    pub input: f64,
}

impl Sums {
    /// Adds the pending energies and sets them to zero.
    pub fn settle(&mut self, pending: &mut Pending) {
        self.damped = self.damped.plus(pending.damped.iter().sum());
        self.input = self.input.plus(pending.input);
        *pending = Pending::default();
    }
}

/// Gramians of input and damped power from a sub-step's start to the centre of each interval and
/// to its end.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Gramians {
    input: [Form; PREFIXES],
    damped: [Form; PREFIXES],
    /// Damping coefficients c1 and c3 at the indices of x1' and x3'.
    weights: Augmented,
    /// F10, N.
    drive: f64,
    /// Drive work in closed form. `None` in rest and near an undamped resonance.
    work: Option<DriveWork>,
}

impl Gramians {
    /// All zero, to be filled.
    pub fn zero() -> Self {
        Self {
            input: [[[0.0; COORDINATES]; COORDINATES]; PREFIXES],
            damped: [[[0.0; COORDINATES]; COORDINATES]; PREFIXES],
            weights: [0.0; COORDINATES],
            drive: 0.0,
            work: None,
        }
    }

    /// Sets the coefficients of the powers. Must be called first when parameters change.
    pub fn set_powers(&mut self, p: &Parameters, model: &Model, mode: SmoothMode) {
        self.drive = p.drive_amplitude;
        self.weights = [0.0, 0.0, 0.0, p.box_damping, 0.0, p.secondary_damping, 0.0, 0.0];
        self.work = match mode {
            SmoothMode::Flight => DriveWork::new(p.drive_amplitude, model),
            SmoothMode::Rest => None,
        };
    }

    /// F10, c1, c3.
    #[inline(always)]
    fn coefficients(&self) -> (f64, f64, f64) {
        (self.drive, self.weights[BOX_RATE], self.weights[SECONDARY_RATE])
    }

    /// Drive work in closed form; `None` if the closed form would lose digits.
    #[inline(always)]
    pub fn drive_work(&self) -> Option<&DriveWork> {
        self.work.as_ref()
    }

    /// Integrates the Gramians of `mode` over a sub-step `h`; `core` is the table of the same mode
    /// and sub-step. The forms over the two halves of an interval are equal about every centre,
    /// and the transition matrices carry them to the sub-step's start. The forms of input are
    /// filled only if the drive's work has no closed form.
    pub fn fill(&mut self, core: &SubstepTable<CORE>, model: &Model, mode: SmoothMode, h: f64) {
        let radius = 0.5 * h / INTERVALS as f64;
        let columns: [Series<CENTRED>; COORDINATES] =
            std::array::from_fn(|j| Series::expand(model, mode, &UnitColumn::unit(j).z, None, radius));
        let halves = [-1.0, 1.0].map(|end| self.over_half(&columns, end, radius));
        let by_difference = self.work.is_some();
        for (forms, part) in [(&mut self.damped, 1), (&mut self.input, 0)] {
            if part == 0 && by_difference {
                continue;
            }
            let mut sum: Form = [[0.0; COORDINATES]; COORDINATES];
            for (i, centre) in core.centre.iter().enumerate() {
                add_carried(&mut sum, &halves[0][part], centre);
                forms[i] = sum;
                add_carried(&mut sum, &halves[1][part], centre);
            }
            forms[INTERVALS] = sum;
        }
    }

    /// Forms [input, damped] between an interval's centre and its `end` (-1 or 1), in the state at
    /// the centre.
    fn over_half(&self, columns: &[Series<CENTRED>; COORDINATES], end: f64, radius: f64) -> [Form; 2] {
        let (drive, c1, c3) = self.coefficients();
        let (mut input, mut damped): (Form, Form) =
            ([[0.0; COORDINATES]; COORDINATES], [[0.0; COORDINATES]; COORDINATES]);
        for (node, weight) in FIVE.nodes.iter().zip(&FIVE.weights) {
            let weight = weight * radius;
            // Rows x1', x3' and sin θ of the transition matrix to the node, by columns.
            let at: [[f64; 3]; COORDINATES] = std::array::from_fn(|j| {
                let z = columns[j].at(end * node);
                [z[BOX_RATE], z[SECONDARY_RATE], z[DRIVE_SIN]]
            });
            for (i, [v1, v3, s]) in at.iter().enumerate() {
                for (j, [u1, u3, r]) in at.iter().enumerate() {
                    input[i][j] += 0.5 * weight * drive * (v1 * r + s * u1);
                    damped[i][j] += weight * (c1 * v1 * u1 + c3 * v3 * u3);
                }
            }
        }
        [input, damped]
    }

    /// Input energy from the start `z` to the centre of interval `index`, or to the sub-step's end
    /// if `index` is [`INTERVALS`].
    #[inline(always)]
    pub fn input_up_to<S: Simd>(&self, simd: S, index: usize, z: &Augmented) -> f64 {
        form(simd, &self.input[index], z)
    }

    /// Damped energy from the start `z` to the centre of interval `index`, or to the sub-step's
    /// end if `index` is [`INTERVALS`].
    #[inline(always)]
    pub fn damped_up_to<S: Simd>(&self, simd: S, index: usize, z: &Augmented) -> f64 {
        form(simd, &self.damped[index], z)
    }

    /// Adds the energy damped in a free flight to `total`, as parts to be summed: from the start
    /// `z` to the centre of interval `index`, if given, and then along the series `rows` from 0 to
    /// u. `end` is the state at u, and `radius` is in s. The error of the rule is under 7e-11 of
    /// the largest power times the length (docs/numerics.md, section 4).
    #[inline(always)]
    pub fn damped_along<S: Simd>(
        &self,
        simd: S,
        index: Option<usize>,
        z: &Augmented,
        rows: &StateRows<S, CENTRED>,
        (u, end, radius): (f64, &Augmented, f64),
        total: &mut Augmented,
    ) {
        let before = index.map(|index| (&self.damped[index], z));
        form_and_squares(simd, before, rows, (u, end), u * radius, &self.weights, total);
    }

    /// Input energy in a free flight along the series `rows` from 0 to u; `radius` is in s.
    #[inline(always)]
    pub fn input_along<S: Simd>(
        &self,
        simd: S,
        rows: &StateRows<S, CENTRED>,
        (u, radius): (f64, f64),
    ) -> f64 {
        let mut input = 0.0;
        for (node, weight) in FOUR.nodes.iter().zip(&FOUR.weights) {
            let at = vibro_numerics::simd::polynomial(simd, rows, u * node);
            input += weight * at[BOX_RATE] * at[DRIVE_SIN];
        }
        self.drive * u * radius * input
    }

    /// (input, damped) energy along a series from u0 to u1; `radius` is in s. Input includes the
    /// work of `forces`, if given; they are the values and derivatives at u = 0.
    #[inline(always)]
    pub fn along<const N: usize>(
        &self,
        series: &Series<N>,
        forces: Option<&Forces>,
        (u0, u1): (f64, f64),
        radius: f64,
    ) -> (f64, f64) {
        if N > CENTRED || u1 - u0 > 1.0 {
            self.by_rule(&FIVE, series, forces, (u0, u1), radius)
        } else {
            self.by_rule(&FOUR, series, forces, (u0, u1), radius)
        }
    }

    #[inline(always)]
    fn by_rule<const N: usize, const R: usize>(
        &self,
        rule: &Rule<R>,
        series: &Series<N>,
        forces: Option<&Forces>,
        (u0, u1): (f64, f64),
        radius: f64,
    ) -> (f64, f64) {
        let (drive, c1, c3) = self.coefficients();
        // The powers need only the rates and sin θ.
        let rates: [[f64; 4]; N] =
            series.states.map(|z| [z[BOX_RATE], z[RELATIVE_RATE], z[SECONDARY_RATE], z[DRIVE_SIN]]);
        let (mut input, mut damped) = (0.0, 0.0);
        let width = u1 - u0;
        for (node, weight) in rule.nodes.iter().zip(&rule.weights) {
            let u = u0 + width * node;
            let [v1, rate, v3, sine] = polynomial(&rates, u);
            let mut power = drive * sine * v1;
            if let Some(forces) = forces {
                let f = crate::flow::shifted(forces, u * radius);
                power += f[0][0] * v1 + f[1][0] * (v1 + rate) + f[2][0] * v3;
            }
            input += weight * power;
            damped += weight * (c1 * v1 * v1 + c3 * v3 * v3);
        }
        let scale = width * radius;
        (input * scale, damped * scale)
    }
}

/// Adds Φᵀ `form` Φ to `sum`, where Φ has the `columns`.
fn add_carried(sum: &mut Form, form: &Form, columns: &[Augmented; COORDINATES]) {
    let mut along: Form = [[0.0; COORDINATES]; COORDINATES];
    for (y, column) in along.iter_mut().zip(columns) {
        SubstepTable::transit(form, column, y);
    }
    for (i, column) in columns.iter().enumerate() {
        for j in i..COORDINATES {
            let value: f64 = column.iter().zip(&along[j]).map(|(a, b)| a * b).sum();
            sum[i][j] += value;
            if j > i {
                sum[j][i] += value;
            }
        }
    }
}

/// Drive work in flight in closed form. In flight the only forces on the box are from its spring,
/// its damper and the drive. With c = cos θ, s = sin θ, the system matrix A of the box alone and
/// `q + ip = (Aᵀ + iω1)⁻¹ (0, F10)`,
///
/// ```text
/// F10 s x1' = mean + d/dt [c (p0 x1 + p1 x1') + s (q0 x1 + q1 x1')
///                          + (q1 s c - p1 s²) F10/(2 m1 ω1)]
/// ```
///
/// So the work between two impacts is the difference of two values plus the mean power times the
/// time. At an impact the value jumps because x1' jumps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveWork {
    p: [f64; 2],
    q: [f64; 2],
    /// F10/(2 m1 ω1).
    swing: f64,
    /// Mean power of the drive in the forced vibration of the box alone, W.
    mean: f64,
}

impl DriveWork {
    /// Coefficients of the closed form. `None` if the forced vibration of the box is so large that
    /// the differences would lose more than three digits. This happens near resonance with hardly
    /// any damping, and under a drive so strong and slow that a flight is a small part of the
    /// forced vibration (docs/theory.md (96)).
    fn new(amplitude: f64, model: &Model) -> Option<Self> {
        /// Smallest impedance, relative to the sum of the sizes of its parts.
        const LEAST: f64 = 1e-3;
        /// Largest amplitude of the forced vibration, in gaps. The values have the size of F10
        /// times this amplitude, the work in a flight has the size of F10 times the gap.
        const LARGEST: f64 = 100.0;
        let Model { k1, c1, omega, gap, drive, .. } = *model;
        let (stiff, inert) = (k1 / omega, omega);
        let reactance = inert - stiff;
        let square = c1 * c1 + reactance * reactance;
        let parts = c1 + stiff + inert;
        let impedance = square.sqrt();
        let usable = impedance >= LEAST * parts
            && drive.abs() <= LARGEST * gap * omega * impedance
            && square.is_finite()
            && square >= f64::MIN_POSITIVE;
        usable.then(|| {
            let (q1, p1) = (-amplitude * c1 / square, -amplitude * reactance / square);
            Self {
                p: [-stiff * q1, p1],
                q: [stiff * p1, q1],
                swing: 0.5 * model.drive / omega,
                mean: -0.5 * q1 * model.drive,
            }
        })
    }

    /// Value, J, of the function whose difference between two instants, plus `mean` times the time
    /// between them, is the work.
    #[inline(always)]
    pub fn value(&self, z: &Augmented) -> f64 {
        let (x, v, c, s) = (z[BOX], z[BOX_RATE], z[DRIVE_COS], z[DRIVE_SIN]);
        let [p0, p1] = self.p;
        let [q0, q1] = self.q;
        c * (p0 * x + p1 * v) + s * (q0 * x + q1 * v) + self.swing * s * (q1 * c - p1 * s)
    }

    /// Jump of [`value`](Self::value) when x1' changes by `change`, J.
    #[inline(always)]
    pub fn jump(&self, z: &Augmented, change: f64) -> f64 {
        (z[DRIVE_COS] * self.p[1] + z[DRIVE_SIN] * self.q[1]) * change
    }

    /// Mean power, W.
    #[inline(always)]
    pub fn mean(&self) -> f64 {
        self.mean
    }
}

/// Kinetic and elastic energy in J of an augmented state.
pub fn mechanical(p: &Parameters, y: &[f64; 6]) -> f64 {
    let (stretch, v2) = ((y[0] - y[2]) + y[1], y[3] + y[4]);
    0.5 * (p.box_mass * y[3] * y[3]
        + p.block_mass * v2 * v2
        + p.secondary_mass * y[5] * y[5]
        + p.box_stiffness * y[0] * y[0]
        + p.secondary_stiffness * y[2] * y[2]
        + p.coupling_stiffness * stretch * stretch)
}

#[cfg(test)]
mod tests;
