//! Laws at events of the model for a host's own solver.

use super::Continuous;
use vibro_impact::model::{Augmented, BOX_RATE, Impact, RELATIVE_RATE, SmoothMode};
use vibro_impact::simulator::{Contact, Event};

/// Distance from a stop within which a block is in contact, in gaps; a solver's root finding has
/// an error of about 1e-10. A bounce lower than this distance cannot be distinguished from rest,
/// so a chatter run ends there.
const CONTACT: f64 = 1e-9;
/// Distance from the stop at which the block is placed after an event, in gaps. No event indicator
/// then restarts at zero, where a host could not detect a crossing. The distance is far below
/// [`CONTACT`] and above the rounding of displacements up to a thousand gaps.
const SHIFT: f64 = 1e-12;
/// Smallest value of [`SHIFT`], in units in the last place of the displacements. It applies to
/// large displacements, since w is their difference.
const SHIFT_UNITS: f64 = 4.0;
/// Lower limit of the contact width, as a multiple of the shift.
const CONTACT_SHIFTS: f64 = 2.0;

impl Continuous {
    /// Applies the laws that hold at the present point: impact, rest or release. Reports them and
    /// returns whether states changed.
    pub(crate) fn handle_event(&mut self, report: &mut dyn FnMut(&Event)) -> bool {
        let before = self.data.state;
        match self.data.contact {
            Contact::Flight => {
                let w = before.x[1] - before.x[0];
                if self.model.gap - w.abs() <= self.contact_width() {
                    self.touch(w.signum(), report);
                }
            }
            contact => {
                if contact.side() * self.accelerations().1 <= 0.0 {
                    self.data.contact = Contact::Flight;
                    self.data.state.v[1] = self.data.state.v[0];
                    self.keep_off(contact.side());
                    let side = contact.side() as i8;
                    report(&Event::Release { time: self.data.time, side });
                }
            }
        }
        self.anchor();
        self.data.state != before
    }

    /// Applies the law at stop `side`: an impact if the block approaches the stop, rest if the
    /// block is pressed on the stop and the bounce is low. A block that leaves from the position
    /// where the last call placed it is not changed, so a further call at an event does nothing.
    fn touch(&mut self, side: f64, report: &mut dyn FnMut(&Event)) {
        let (time, stop) = (self.data.time, side as i8);
        let mut z = self.augmented();
        let (past, way) = ((side * self.excess(side, self.model.gap)).max(0.0), self.way_off(side));
        if side * z[RELATIVE_RATE] > 0.0 {
            let Impact { speed, impulse, lost } = self.model.impact(&mut z, side);
            self.data.record.count(side, time, speed, impulse);
            self.data.lost += lost;
            report(&Event::Impact { time, side: stop, speed, impulse });
        } else if way <= 0.5 * self.shift() {
            return; // up to rounding, the block is where the last call placed it
        }
        let rebound = -side * z[RELATIVE_RATE];
        let pressing = side * self.model.acceleration(SmoothMode::Flight, &z, Some(self.data.forces)).free;
        // The height of the bounce is rebound²/(2 pressing). A bounce is low if its height is at
        // most the contact width plus `past`, the penetration that the host's solver has caused.
        // Dampers make the bounces of an elastic block low, too.
        let low = pressing > 0.0 && rebound * rebound <= 2.0 * pressing * (self.contact_width() + past);
        if low && self.rest(z, side) {
            report(&Event::Rest { time, side: stop });
            return;
        }
        if pressing > 0.0 {
            // The block is moved by `way` off the stop. Its speed is reduced by the loss over this
            // distance; otherwise each low bounce would grow by `way`. A bounce that is not low
            // has enough speed for this.
            let slower = (rebound * rebound - 2.0 * pressing * way).max(0.0).sqrt();
            let change = side * (rebound - slower);
            z[RELATIVE_RATE] += change;
            z[BOX_RATE] -= self.model.block_share * change;
            self.data.record.box_impulse -= self.model.reduced_mass * change;
        }
        self.set_rates(&z);
        self.keep_off(side);
    }

    /// Merges box and block at stop `side` if the stop then presses on the block. Otherwise
    /// nothing changes.
    fn rest(&mut self, mut z: Augmented, side: f64) -> bool {
        let before = self.data;
        self.data.record.box_impulse += self.model.reduced_mass * z[RELATIVE_RATE];
        self.data.lost += self.model.merge(&mut z);
        self.data.contact = if side > 0.0 { Contact::RestUpper } else { Contact::RestLower };
        self.set_rates(&z);
        self.bring_closer(self.excess(side, self.model.gap));
        self.data.state.v[1] = self.data.state.v[0];
        if side * self.accelerations().1 > 0.0 {
            return true;
        }
        self.data = before;
        false
    }

    /// Sets the velocities of box and block from `z`.
    fn set_rates(&mut self, z: &Augmented) {
        (self.data.state.v[0], self.data.state.v[1]) = (z[BOX_RATE], z[BOX_RATE] + z[RELATIVE_RATE]);
    }

    /// Moves the block a small distance off stop `side`. A block farther inside is not moved.
    fn keep_off(&mut self, side: f64) {
        let way = self.way_off(side);
        if way > 0.0 {
            self.bring_closer(side * way);
        }
    }

    /// Distance that moves the block off stop `side`, m; 0 if it is farther inside.
    fn way_off(&self, side: f64) -> f64 {
        (side * self.excess(side, self.model.gap - self.shift())).max(0.0)
    }

    /// Distance from a stop at which the block is placed, m.
    fn shift(&self) -> f64 {
        let [x1, x2, _] = self.data.state.x;
        (SHIFT * self.model.gap).max(SHIFT_UNITS * f64::EPSILON * x1.abs().max(x2.abs()))
    }

    /// Distance from a stop within which a block is in contact, m.
    fn contact_width(&self) -> f64 {
        (CONTACT * self.model.gap).max(CONTACT_SHIFTS * self.shift())
    }

    /// Relative displacement w beyond `reach` on `side`; it has the sign of w.
    fn excess(&self, side: f64, reach: f64) -> f64 {
        let x = &self.data.state.x;
        (x[1] - x[0]) - side * reach
    }

    /// Reduces w by `by`; the centre of mass of box and block does not move.
    fn bring_closer(&mut self, by: f64) {
        let x = &mut self.data.state.x;
        x[0] += self.model.block_share * by;
        x[1] -= (1.0 - self.model.block_share) * by;
    }
}
