//! Springs with a piecewise linear force at rest. If no line falls, the force is one line plus
//! forces between bounds, which keep the energy convex (docs/assembly-law.md (A25)).

use super::{Holding, RestContact, RestSpring, direction};
use crate::description::{Description, ForcePoint};
use crate::functional::StateRow;
use crate::polyline::slopes;
use crate::system::System;

/// A spring whose force has several lines.
pub(super) struct Lined<'a> {
    /// Index among the springs.
    pub spring: usize,
    pub points: &'a [ForcePoint],
    pub slopes: Vec<f64>,
    /// Elongation at q = 0.
    pub e: f64,
}

impl<'a> Lined<'a> {
    /// All such springs of a machine with the augmented state `z` at q = 0.
    pub fn all(d: &'a Description, system: &System, z: &StateRow) -> Vec<Self> {
        let springs = d.springs.iter().enumerate().filter(|(_, spring)| spring.points.len() > 2);
        let lined = |(spring, own): (usize, &'a crate::description::Spring)| Self {
            spring,
            points: &own.points,
            slopes: slopes(&own.points),
            e: system.springs[spring].elongation.e.dot(z),
        };
        springs.map(lined).collect()
    }

    /// Whether a line falls.
    pub fn falls(&self) -> bool {
        self.slopes.iter().any(|slope| *slope < 0.0)
    }

    /// The value of line `j` at an elongation.
    pub fn line(&self, j: usize, e: f64) -> f64 {
        self.points[j].f + self.slopes[j] * (e - self.points[j].e)
    }

    /// Index of the line that acts at an elongation; the left line at a corner.
    pub fn of(&self, e: f64) -> usize {
        self.points[1..self.points.len() - 1].iter().filter(|corner| e > corner.e).count()
    }

    /// The range of elongations of line `j`.
    pub fn span(&self, j: usize) -> (f64, f64) {
        let below = if j == 0 { f64::NEG_INFINITY } else { self.points[j].e };
        let above = if j + 1 == self.slopes.len() { f64::INFINITY } else { self.points[j + 1].e };
        (below, above)
    }
}

impl Holding {
    /// Replaces the first line of a spring by a line of this stiffness, with this force at q = 0.
    pub(super) fn put_line(&mut self, system: &System, lined: &Lined, (stiffness, force): (f64, f64)) {
        let rows = &system.springs[lined.spring];
        let w = &rows.elongation.w;
        let first = lined.line(0, lined.e);
        self.force.axpy(first - force, w, 1.0);
        self.sizes += w.abs() * (first.abs() + force.abs());
        self.springs.retain(|own| own.spring != lined.spring);
        if stiffness != 0.0 {
            self.springs.push(RestSpring { w: direction(w), stiffness, spring: lined.spring });
        }
    }

    /// Adds a spring without falling lines: its least slope, and the excess slope of each line.
    pub(super) fn put_lines(&mut self, system: &System, lined: &Lined) {
        let least = lined.slopes.iter().copied().fold(f64::INFINITY, f64::min);
        let corner = lined.points[1];
        self.put_line(system, lined, (least, corner.f + least * (lined.e - corner.e)));
        let w = &system.springs[lined.spring].elongation.w;
        for (j, slope) in lined.slopes.iter().enumerate().filter(|(_, slope)| **slope > least) {
            let (steeper, (below, above)) = (slope - least, lined.span(j));
            let (from, force) = if j == 0 {
                (above, (f64::NEG_INFINITY, 0.0))
            } else {
                (below, (0.0, steeper * (above - below)))
            };
            let excess = lined.e - from;
            self.contacts.push(RestContact { w: direction(w), excess, force, compliance: 1.0 / steeper });
        }
    }
}
