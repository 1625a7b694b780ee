//! The impact law in the units of the closed forms, for states and for their variations.
//!
//! `model.rs` has the law of the simulator. The law is written twice on purpose: the exact orbit
//! is an oracle for the simulator and therefore shares only the parameters with it
//! (docs/design.md, "Oracles and shared code").

use super::flight::{Flight, Vector6};

impl Flight {
    /// State after an impulse p on the block away from the upper stop, in units of m2 ω1 L: -p g
    /// of docs/theory.md (77).
    pub(super) fn pushed(&self, z: &Vector6, p: f64) -> Vector6 {
        let mut after = *z;
        after[3] += p * self.epsilon;
        after[4] -= p;
        after
    }

    /// State after the impact law J of docs/theory.md (27). The rate w' before the impact is the
    /// rate of `z` plus `forced`. The sign of w' is the stop's sign, so that one law holds for
    /// both stops.
    pub fn strike(&self, z: &Vector6, forced: f64) -> Vector6 {
        self.kicked(*z, z[4] - z[3] + forced)
    }

    fn kicked(&self, mut z: Vector6, rate: f64) -> Vector6 {
        z[3] += self.kick[0] * rate;
        z[4] += self.kick[1] * rate;
        z
    }

    /// Change of the state just after an impact per unit of phase delay of the impact, J f⁻ - f⁺
    /// of docs/theory.md (78) and (104). `approach` and `departure` are the rates of the state
    /// just before and just after the impact; `forced` is added to the w'' of `approach`.
    pub fn delay(&self, approach: &Vector6, forced: f64, departure: &Vector6) -> Vector6 {
        self.kicked(approach - departure, approach[4] - approach[3] + forced)
    }

    /// Variation of the state after an impact, by S of docs/theory.md (78). `delay` is
    /// [`delay`](Self::delay) divided by w' before the impact, as the neighbouring motion meets
    /// the stop later by -δw/w'.
    pub fn saltate(&self, variation: &Vector6, delay: &Vector6) -> Vector6 {
        let w = variation[1] - variation[0];
        self.kicked(variation - delay * w, variation[4] - variation[3])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Augmented, BOX_RATE, Model, RELATIVE_RATE};
    use crate::parameters::Parameters;

    /// The impact law of the closed forms agrees with the simulator's, at both stops.
    #[test]
    fn second_method_the_two_laws_agree() {
        const ROUNDING: f64 = 1e-15;
        for kappa in [0.0, 0.3, 1.0] {
            let p = Parameters { block_mass: 0.7, stop_restitution: kappa, ..Parameters::default() };
            let (flight, model) = (Flight::new(&p).unwrap(), Model::new(&p).unwrap());
            for (v1, w) in [(0.2, 0.9), (-0.4, -0.6)] {
                let mut z: Augmented = [0.0; 8];
                (z[BOX_RATE], z[RELATIVE_RATE]) = (v1, w);
                let impact = model.impact(&mut z, f64::signum(w));
                let before = Vector6::new(0.0, 0.0, 0.0, v1, v1 + w, 0.0);
                let after = flight.strike(&before, 0.0);
                // A rate given apart acts like one that is part of the state.
                let apart = flight.strike(&Vector6::new(0.0, 0.0, 0.0, v1, v1, 0.0), w);
                for (found, exact) in [
                    (after[3], z[BOX_RATE]),
                    (after[4], z[BOX_RATE] + z[RELATIVE_RATE]),
                    (apart[3], z[BOX_RATE]),
                    (apart[4] + w, z[BOX_RATE] + z[RELATIVE_RATE]),
                ] {
                    assert!((found - exact).abs() < ROUNDING, "{found} {exact}");
                }
                let p = f64::signum(w) * impact.impulse / p.block_mass;
                assert!((flight.pushed(&before, p) - after).norm() < ROUNDING);
            }
        }
    }
}
