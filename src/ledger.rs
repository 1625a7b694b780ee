//! Energy accounts: the work of drive and loads and the losses in the dampers, integrated as quadratic forms of the
//! exact flow (performance.md, item 7). They are found without the mechanical energy, so their balance is a test.

use crate::extended::Extended;
use crate::flow::{CENTRED, INTERVALS, Series, WHOLE, polynomial};
use crate::model::{Augmented, Forces, LANES, Mode, Model};
use crate::parameters::Parameters;
use crate::vector::{self, Rows, dot, multiply_add, product};
use pulp::Simd;
use serde::{Deserialize, Serialize};

/// Gauss–Legendre nodes and weights on [0, 1] of a rule.
pub(crate) struct Rule<const N: usize> {
    pub(crate) nodes: [f64; N],
    pub(crate) weights: [f64; N],
}

/// Over a length of 0.15/rate the error is under 1e-18 of the integral.
pub(crate) const FIVE: Rule<5> = Rule {
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
/// Over a length of 0.075/rate the error is under 1e-16 of the integral.
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

/// Over a length of 0.075/rate the error is under 5e-13 of the power over the rate, which is 2e-13 of a flight's energy.
const THREE: Rule<3> = Rule {
    nodes: [0.112_701_665_379_258_31, 0.5, 0.887_298_334_620_741_7],
    weights: [0.277_777_777_777_777_8, 0.444_444_444_444_444_4, 0.277_777_777_777_777_8],
};

/// Pieces into which the Gramians' own quadrature divides an interval's half.
const PREFIXES: usize = INTERVALS + 1;
/// Two 8 × 8 forms side by side: lanes 0…7 input, 8…15 damped.
type Form = [[f64; 2 * LANES]; LANES];

/// What the powers are made of: F10, c1, c3 in SI units.
#[derive(Clone, Copy, Debug, Default)]
struct Powers {
    drive: f64,
    c1: f64,
    c3: f64,
}

/// Running sums in J, in extended precision so that 10⁶ periods lose nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Sums {
    pub(crate) input: Extended,
    pub(crate) damped: Extended,
    pub(crate) impact: Extended,
}

/// Gramians of input and damped power from a sub-step's start to the centre of each interval and to its end.
#[derive(Clone, Debug)]
pub(crate) struct Gramians {
    prefix: [Form; PREFIXES],
    powers: Powers,
}

impl Gramians {
    pub(crate) fn zero() -> Self {
        Self { prefix: [[[0.0; 2 * LANES]; LANES]; PREFIXES], powers: Powers::default() }
    }

    /// Sets the powers; to be called before anything else when parameters change.
    pub(crate) fn set_powers(&mut self, p: &Parameters) {
        self.powers = Powers { drive: p.drive_amplitude, c1: p.box_damping, c3: p.secondary_damping };
    }

    /// Integrates the Gramians over a sub-step `h` of `mode`.
    pub(crate) fn fill(&mut self, model: &Model, mode: Mode, h: f64) {
        let columns: [Series<WHOLE>; LANES] = std::array::from_fn(|j| {
            let mut unit = [0.0; LANES];
            unit[j] = 1.0;
            Series::expand(model, mode, &unit, None, h)
        });
        // Only the rows x1', x3' and sin θ of the transition matrix enter the powers.
        let row = |lane: usize| -> [[f64; LANES]; WHOLE] {
            std::array::from_fn(|k| std::array::from_fn(|j| columns[j].lanes[k][lane]))
        };
        let (box_speed, secondary_speed, sine) = (row(3), row(5), row(7));
        let at = |row: &[[f64; LANES]; WHOLE], u: f64| -> [f64; LANES] {
            let mut r = row[WHOLE - 1];
            for k in (0..WHOLE - 1).rev() {
                for j in 0..LANES {
                    r[j] = r[j] * u + row[k][j];
                }
            }
            r
        };
        let Powers { drive, c1, c3 } = self.powers;
        let piece = 0.5 / INTERVALS as f64;
        let mut form: Form = [[0.0; 2 * LANES]; LANES];
        for half in 0..2 * INTERVALS {
            for (node, weight) in FIVE.nodes.iter().zip(&FIVE.weights) {
                let u = (half as f64 + node) * piece;
                let weight = weight * piece * h;
                let (v1, v3, s) = (at(&box_speed, u), at(&secondary_speed, u), at(&sine, u));
                for i in 0..LANES {
                    for j in 0..LANES {
                        form[i][j] += 0.5 * weight * drive * (v1[i] * s[j] + s[i] * v1[j]);
                        form[i][LANES + j] += weight * (c1 * v1[i] * v1[j] + c3 * v3[i] * v3[j]);
                    }
                }
            }
            if half % 2 == 0 {
                self.prefix[half / 2] = form;
            }
        }
        self.prefix[INTERVALS] = form;
    }

    /// (input, damped) from the start `z` to the centre of interval `index`, or to the end with [`INTERVALS`].
    #[inline(always)]
    pub(crate) fn up_to<S: Simd>(&self, simd: S, index: usize, z: &Augmented) -> (f64, f64) {
        let y = product(simd, &self.prefix[index], z);
        (dot(simd, &y[..LANES], z), dot(simd, &y[LANES..], z))
    }

    /// (input, damped) of a free flight along `rows` from 0 to `u`; `radius` in s.
    #[inline(always)]
    pub(crate) fn along_rows<S: Simd>(
        &self,
        simd: S,
        rows: &Rows<S, CENTRED>,
        u: f64,
        radius: f64,
    ) -> (f64, f64) {
        let Powers { drive, c1, c3 } = self.powers;
        let (mut input, mut damped) = (0.0, 0.0);
        for (node, weight) in THREE.nodes.iter().zip(&THREE.weights) {
            let at = vector::polynomial(simd, rows, u * node);
            let (v1, v3, sine) = (at[3], at[5], at[7]);
            input = multiply_add::<S>(weight * v1, sine, input);
            damped = multiply_add::<S>(*weight, multiply_add::<S>(c1 * v1, v1, c3 * v3 * v3), damped);
        }
        let length = u * radius;
        (drive * length * input, length * damped)
    }

    /// (input, damped) along a series from u0 to u1; `radius` in s. Loads included where given (at u = 0).
    #[inline(always)]
    pub(crate) fn along<const N: usize>(
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
        let Powers { drive, c1, c3 } = self.powers;
        // Of the augmented state the powers need the rates and sin θ only.
        let rates: [[f64; 4]; N] = series.lanes.map(|z| [z[3], z[4], z[5], z[7]]);
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

/// Kinetic and elastic energy in J of an augmented state.
pub(crate) fn mechanical(p: &Parameters, y: &[f64; 6]) -> f64 {
    let (stretch, v2) = ((y[0] - y[2]) + y[1], y[3] + y[4]);
    0.5 * (p.box_mass * y[3] * y[3]
        + p.block_mass * v2 * v2
        + p.secondary_mass * y[5] * y[5]
        + p.box_stiffness * y[0] * y[0]
        + p.secondary_stiffness * y[2] * y[2]
        + p.coupling_stiffness * stretch * stretch)
}
