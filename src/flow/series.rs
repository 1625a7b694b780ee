//! Taylor series of the augmented state about a point, by the recurrence docs/theory.md (8). The
//! number of coefficients follows from the radius, which is the sub-step of 2.4/rate or a part of
//! it; [`super`] divides the sub-step into 16 intervals.

use super::polynomial;
use crate::model::{
    Acceleration, Augmented, BOX, BOX_RATE, COORDINATES, DRIVE_COS, DRIVE_SIN, Forces, Model, RELATIVE,
    RELATIVE_RATE, SECONDARY, SECONDARY_RATE, SmoothMode,
};

/// Bound on the remainder of a series of seven coefficients or more, up to a time of `reach`/rate
/// from its point, relative to the motion's size S (docs/numerics.md, section 1). The bound is
/// reach^n/(n-1)! and not reach^n/n!, because the rate bounds the motion of the bodies alone, and
/// the contributions of a drive at resonance add up from order to order.
pub const fn remainder(coefficients: usize, reach: f64) -> f64 {
    assert!(coefficients >= 7, "the bound on a coefficient holds from order seven on");
    assert!(reach < coefficients as f64, "the terms left out fall from the first on");
    let mut term = reach;
    let mut k = 1;
    while k < coefficients {
        term *= reach / k as f64;
        k += 1;
    }
    term / (1.0 - reach / coefficients as f64)
}

/// Number of coefficients of a series about an interval's centre, of radius 0.075/rate: the
/// remainder is under 0.075¹⁰/9! < 1.6e-17 of the motion's size S (docs/numerics.md, section 1).
pub const CENTRED: usize = 10;
/// Number of coefficients of a series about an interval's start, of radius 0.15/rate: the
/// remainder is under 4e-18 of the motion's size.
pub const ANCHORED: usize = 12;
/// Number of coefficients of a series over a whole sub-step of 2.4/rate, for the tables: the
/// remainder is under 4e-20 of the motion's size.
pub const WHOLE: usize = 30;

/// Number of coefficients of each series of [`expand_along`]: the remainder is under 3.4e-16 of
/// the motion's size.
pub const PIECE: usize = 20;
/// Length limit of a series of [`expand_along`], times the model's rate.
const PIECE_TIMES_RATE: f64 = 1.2;
const _: () = assert!(remainder(PIECE, PIECE_TIMES_RATE) < 3.4e-16);

/// 1/(k+1) of the recurrence.
const RECIPROCALS: [f64; WHOLE] = {
    let mut r = [0.0; WHOLE];
    let mut k = 0;
    while k < WHOLE {
        r[k] = 1.0 / (k + 1) as f64;
        k += 1;
    }
    r
};

/// Taylor coefficients about a point, scaled by the radius r: `z(t0 + u r) = Σ_k states[k] u^k`,
/// and likewise for the free relative acceleration.
#[derive(Clone, Copy)]
pub struct Series<const N: usize> {
    /// Coefficients of the augmented state, by order.
    pub states: [Augmented; N],
    /// Coefficients of the free relative acceleration, by order.
    pub free: [f64; N],
}

impl<const N: usize> Series<N> {
    /// Series about `z` by the recurrence docs/theory.md (8): each order follows from the one
    /// before through the equations of motion.
    #[inline(always)]
    pub fn expand(
        model: &Model,
        mode: SmoothMode,
        z: &Augmented,
        forces: Option<&Forces>,
        radius: f64,
    ) -> Self {
        let mut states = [[0.0; COORDINATES]; N];
        let mut free = [0.0; N];
        states[0] = *z;
        let mut scale = 1.0; // r^k / k!
        for k in 0..N {
            let f = forces.map(|d| if k < 4 { d.map(|b| b[k] * scale) } else { [0.0; 3] });
            let c = states[k];
            let Acceleration { coordinates: a, free: relative } = model.acceleration(mode, &c, f);
            free[k] = relative;
            if k + 1 < N {
                let q = radius * RECIPROCALS[k];
                scale *= q;
                let turn = q * model.omega;
                states[k + 1] = [
                    q * c[BOX_RATE],
                    q * c[RELATIVE_RATE],
                    q * c[SECONDARY_RATE],
                    q * a[0],
                    q * a[1],
                    q * a[2],
                    -turn * c[DRIVE_SIN],
                    turn * c[DRIVE_COS],
                ];
            }
        }
        Self { states, free }
    }

    /// Augmented state at u.
    #[inline(always)]
    pub fn at(&self, u: f64) -> Augmented {
        polynomial(&self.states, u)
    }

    /// Augmented state at u, for the shortest steps: the change is summed first and added to the
    /// constant term once. [`at`](Self::at) adds the even orders to the constant term one by one.
    /// For the shortest steps these additions lose the small terms, or round them in one direction
    /// at every step.
    #[inline(always)]
    pub fn after_way(&self, u: f64) -> Augmented {
        let mut terms = self.states;
        terms[0] = [0.0; COORDINATES];
        let way = polynomial(&terms, u);
        std::array::from_fn(|j| self.states[0][j] + way[j])
    }

    /// Coefficients of `side · w - gap` (gap is L), negative while the block is inside.
    #[inline(always)]
    pub fn excess_polynomial(&self, side: f64, gap: f64) -> [f64; N] {
        let mut p = [0.0; N];
        for (pk, state) in p.iter_mut().zip(&self.states) {
            *pk = side * state[RELATIVE];
        }
        p[0] -= gap;
        p
    }

    /// Time derivatives of the three bodies' displacements at the centre, `[body][order]` for the
    /// orders below M ≤ N, m/s^order: the coefficients times k!/r^k, with `rate` = 1/r in 1/s.
    pub fn derivatives<const M: usize>(&self, rate: f64) -> [[f64; M]; 3] {
        let mut derivatives = [[0.0; M]; 3];
        let mut scale = 1.0; // k!/r^k
        for (k, state) in self.states.iter().enumerate().take(M) {
            if k > 0 {
                scale *= k as f64 * rate;
            }
            let bodies = [state[BOX], state[BOX] + state[RELATIVE], state[SECONDARY]];
            for (derivative, value) in derivatives.iter_mut().zip(bodies) {
                derivative[k] = value * scale;
            }
        }
        derivatives
    }

    /// Coefficients of the event functional: w in flight, the free relative acceleration in rest.
    #[inline(always)]
    pub fn functional(&self, mode: SmoothMode) -> [f64; N] {
        match mode {
            SmoothMode::Flight => self.states.map(|state| state[RELATIVE]),
            SmoothMode::Rest => self.free,
        }
    }
}

/// Flow from `start` over `span` s under constant forces, as consecutive series. `visit` gets each
/// series, whose variable runs over [0, 1], and the series' length in s. Returns the state at the
/// end.
#[inline(always)]
pub fn expand_along(
    model: &Model,
    mode: SmoothMode,
    (start, forces): (&Augmented, Option<&Forces>),
    span: f64,
    mut visit: impl FnMut(&Series<PIECE>, f64),
) -> Augmented {
    let count = (span * model.rate / PIECE_TIMES_RATE).ceil().max(1.0);
    let radius = span / count;
    let mut z = *start;
    for _ in 0..count as u64 {
        let series = Series::<PIECE>::expand(model, mode, &z, forces, radius);
        visit(&series, radius);
        z = series.at(1.0);
        if mode == SmoothMode::Rest {
            (z[RELATIVE], z[RELATIVE_RATE]) = (start[RELATIVE], 0.0);
        }
    }
    z
}
