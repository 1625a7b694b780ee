//! Jump of variations of the motion at an impact (docs/theory.md (83), (84)).

use super::{Augmented, BOX_RATE, Model, RELATIVE, RELATIVE_RATE, SmoothMode};

/// Saltation matrix of an impact, docs/theory.md (78), in the coordinates (83): indices [`BOX`]
/// and [`BOX_RATE`] hold the variations of the centre of mass of box and block and of its rate.
/// One law holds for both stops, as w' before the impact enters with its sign.
///
/// [`BOX`]: super::BOX
///
/// ```
/// use vibro_impact::model::{Model, RELATIVE, RELATIVE_RATE, Saltation};
///
/// let model = Model::new(&vibro_impact::Parameters::default())?;
/// let mut after = [0.0; 8];
/// (after[RELATIVE], after[RELATIVE_RATE]) = (model.gap, -model.restitution * 0.5);
/// let jump = Saltation::new(&model, 0.5, &after, [0.0; 3], 1.0);
/// let mut varied = [0.0; 8];
/// varied[RELATIVE] = 1e-6;
/// jump.apply(&mut varied);
/// assert_eq!(varied[RELATIVE], -model.restitution * 1e-6);
/// # Ok::<(), vibro_impact::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Saltation {
    restitution: f64,
    /// δw' after the impact per δw before it.
    kick: f64,
    /// Change of the variation of the centre of mass's rate per change of δw; the damper's force
    /// on the box also jumps at the impact.
    push: f64,
}

impl Saltation {
    /// Jump at an impact with w' = `rate` before it, m/s, under `loads`, N. `after` is the state
    /// after the impact, and after the merge if one follows. Rates of variations are in units of
    /// displacement times `unit`, 1/s. An impact without speed has no jump and does not change
    /// variations.
    #[inline]
    pub fn new(model: &Model, rate: f64, after: &Augmented, loads: [f64; 3], unit: f64) -> Self {
        if rate == 0.0 {
            return Self { restitution: -1.0, kick: 0.0, push: 0.0 };
        }
        // a_w⁺ + κ a_w⁻. With the centre of mass fixed, docs/theory.md (83), the free acceleration
        // (6) is affine in w', and the parts in w' cancel. The result is 1 + κ times the free
        // acceleration for the state in which box and block both move with the velocity of their
        // centre of mass. This also holds after a merge.
        let mut together = *after;
        together[BOX_RATE] += model.block_share * after[RELATIVE_RATE];
        together[RELATIVE_RATE] = 0.0;
        let free = model.acceleration(SmoothMode::Flight, &together, Some(loads)).free;
        let kick = (1.0 + model.restitution) * free / (rate * unit);
        Self { restitution: model.restitution, kick, push: push(model, unit) }
    }

    /// Applies the impact to a variation.
    #[inline(always)]
    pub fn apply(&self, v: &mut Augmented) {
        let w = v[RELATIVE];
        v[RELATIVE] = -self.restitution * w;
        v[RELATIVE_RATE] = -self.restitution * v[RELATIVE_RATE] + self.kick * w;
        v[BOX_RATE] += self.push * (v[RELATIVE] - w);
    }

    /// Applies the merge into rest to a variation: its relative motion ends. The merge replaces a
    /// run of bounces, during which the damper changes the rate of the centre of mass in
    /// proportion to the change of w.
    #[inline(always)]
    pub fn merge(model: &Model, v: &mut Augmented, unit: f64) {
        v[BOX_RATE] -= push(model, unit) * v[RELATIVE];
        (v[RELATIVE], v[RELATIVE_RATE]) = (0.0, 0.0);
    }
}

/// Change of the rate of the centre of mass per change of w, by the damper's force on the box, in
/// `unit`.
#[inline(always)]
fn push(model: &Model, unit: f64) -> f64 {
    (1.0 - model.block_share) * model.block_share * model.c1 / unit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::Series;
    use crate::model::BOX;
    use crate::parameters::Parameters;

    /// Variation in the coordinates of the model from one in the coordinates (83), where `share`
    /// is the block's share of the mass. The negative share gives the inverse.
    fn turned(v: &Augmented, share: f64) -> Augmented {
        let mut z = *v;
        z[BOX] -= share * z[RELATIVE];
        z[BOX_RATE] -= share * z[RELATIVE_RATE];
        z
    }

    /// Compares a variation after the bounces of a chatter run, one by one, with the variation
    /// after the merge that replaces them. During the bounces the damper acts on the centre of
    /// mass.
    #[test]
    fn second_method_a_merge_is_what_the_bounces_come_to() {
        /// Relative tolerance. The run takes 4e-5 of the unit of time, and all other quantities
        /// change by at most this fraction.
        const SHORT: f64 = 1e-3;
        let p = Parameters {
            box_stiffness: 0.0,
            box_damping: 0.5,
            block_mass: 1.0,
            coupling_stiffness: 0.0,
            drive_amplitude: 0.0,
            stop_restitution: 0.5,
            ..Parameters::default()
        };
        let model = Model::new(&p).unwrap();
        let pressing = [0.0, 1.0, 0.0];
        let forces = pressing.map(|f| [f, 0.0, 0.0, 0.0]);
        let (mut z, mut v) = ([0.0; 8], [0.0; 8]);
        (z[RELATIVE], z[RELATIVE_RATE], v[RELATIVE]) = (model.gap, 1e-5, 1.0);
        let mut merged = v;
        for bounce in 0..40 {
            let rate = z[RELATIVE_RATE];
            model.impact(&mut z, 1.0);
            let jump = Saltation::new(&model, rate, &z, pressing, 1.0);
            jump.apply(&mut v);
            if bounce == 0 {
                jump.apply(&mut merged);
                Saltation::merge(&model, &mut merged, 1.0);
            }
            // Flight back to the stop: the acceleration is constant except for the damper.
            let free = model.acceleration(SmoothMode::Flight, &z, Some(pressing)).free;
            let mut span = -2.0 * z[RELATIVE_RATE] / free;
            let state_after = |z: &Augmented, forces, span| {
                Series::<12>::expand(&model, SmoothMode::Flight, z, forces, span).at(1.0)
            };
            for _ in 0..4 {
                let there = state_after(&z, Some(&forces), span);
                span -= (there[RELATIVE] - model.gap) / there[RELATIVE_RATE];
            }
            z = state_after(&z, Some(&forces), span);
            z[RELATIVE] = model.gap;
            v = turned(&state_after(&turned(&v, model.block_share), None, span), -model.block_share);
        }
        let lost = push(&model, 1.0);
        assert!(lost > 0.01 && (merged[BOX_RATE] + lost).abs() < SHORT * lost);
        assert!((v[BOX_RATE] - merged[BOX_RATE]).abs() < SHORT * lost, "{v:?} {merged:?}");
        assert!(v[RELATIVE].abs() < SHORT);
    }
}
