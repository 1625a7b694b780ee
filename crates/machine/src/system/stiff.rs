//! Stiff ties: springs and pressed compliant stops that tie coordinates to a group. Much softer
//! forces move the group as a whole.
//!
//! A tie exerts no net force on its group: terms of the size k times a coordinate cancel. If each
//! term were rounded separately, a force of 1e-16 k times the coordinate would remain on the
//! group, with the same direction for many sub-steps. For a softer k', the motion's relative error
//! would be 1e-16 k/k'. So a tie's force is evaluated once and then applied to both sides.

use super::{Elongation, System};
use crate::description::StopLaw;
use vibro_numerics::sorting::{sort_by, sort_by_key};

/// A tie is stiff if it is faster, by more than this factor, than all forces on its group from
/// outside. So are all elastic forces of a mode if they raise its rate by more than this factor.
pub(crate) const STIFF: f64 = 30.0;

/// A spring, a pressed compliant stop, or a passed corner of a spring, whose stiffness may be
/// negative.
struct Tie<'a> {
    elongation: &'a Elongation,
    stiffness: f64,
    damping: f64,
}

impl Tie<'_> {
    /// The coordinates on which the tie acts, with their arms.
    fn arms(&self) -> impl Iterator<Item = (usize, f64)> {
        self.elongation.w.terms().iter().copied()
    }

    /// The rate of a motion under this tie alone, rad/s.
    fn rate(&self) -> f64 {
        let compliance = self.elongation.w.along(&self.elongation.mobility);
        (self.stiffness.abs() * compliance).sqrt().max(self.damping * compliance)
    }

    /// Adds the tie's stiffness and damping, `times` 1 or -1, to its coordinates.
    fn add(&self, times: f64, outside: &mut [Outside]) {
        for (k, w) in self.arms() {
            outside[k].0 += times * w * w * self.stiffness;
            outside[k].1 += times * w * w * self.damping;
        }
    }
}

/// Stiffness and damping that act on a coordinate from outside its group.
type Outside = (f64, f64);

impl System {
    /// Returns sorted indices of the stiff ties in the list of all springs, then `pressed` stops.
    /// Ties are merged into groups by descending rate. Ties in a group are stiff if they are
    /// faster, by the factor [`STIFF`], than everything outside that acts on the group.
    pub(crate) fn stiff_ties(&self, pressed: &[usize]) -> Vec<usize> {
        let springs = self.springs.iter().map(|s| Tie {
            elongation: &s.elongation,
            stiffness: s.stiffness,
            damping: s.damping,
        });
        let stops = pressed.iter().filter_map(|&i| match self.stops[i].law {
            StopLaw::Compliant { stiffness, damping, .. } => {
                Some(Tie { elongation: &self.stops[i].elongation, stiffness, damping })
            }
            StopLaw::Rigid { .. } => None,
        });
        let ties: Vec<Tie> = springs.chain(stops).collect();
        let mut outside = vec![(0.0, 0.0); self.coordinates];
        ties.iter().for_each(|tie| tie.add(1.0, &mut outside));
        let branches = self.branches.iter();
        let branches =
            branches.map(|b| Tie { elongation: &b.elongation, stiffness: b.stiffness, damping: 0.0 });
        branches.for_each(|tie| tie.add(1.0, &mut outside));
        let between = (0..ties.len()).filter(|&i| ties[i].arms().count() > 1);
        let mut between: Vec<(f64, usize)> = between.map(|i| (ties[i].rate(), i)).collect();
        sort_by(&mut between, |a, b| b.0.total_cmp(&a.0));
        let mut group_of: Vec<usize> = (0..self.coordinates).collect();
        let mut members: Vec<Vec<usize>> = (0..self.coordinates).map(|k| vec![k]).collect();
        let mut inside: Vec<Vec<usize>> = vec![Vec::new(); self.coordinates];
        let mut stiff = Vec::new();
        for (rate, i) in between {
            ties[i].add(-1.0, &mut outside);
            let mut groups: Vec<usize> = ties[i].arms().map(|(k, _)| group_of[k]).collect();
            sort_by_key(&mut groups, |&group| std::cmp::Reverse(members[group].len()));
            let to = groups[0];
            for from in groups.into_iter().filter(|&group| group != to) {
                for k in std::mem::take(&mut members[from]) {
                    group_of[k] = to;
                    members[to].push(k);
                }
                let tied = std::mem::take(&mut inside[from]);
                inside[to].extend(tied);
            }
            inside[to].push(i);
            if members[to].iter().all(|&k| rate > STIFF * self.rate_of(k, outside[k])) {
                stiff.append(&mut inside[to]);
            }
        }
        stiff.sort_unstable();
        stiff
    }

    /// The rate of a coordinate under this stiffness and damping, rad/s; negative rounding
    /// residues count as zero.
    fn rate_of(&self, k: usize, (stiffness, damping): Outside) -> f64 {
        let inertia = self.mass[(k, k)];
        (stiffness.max(0.0) / inertia).sqrt().max(damping / inertia)
    }
}
