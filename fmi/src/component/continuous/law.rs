//! What happens at an event of the model for a host's own solver.

use super::Continuous;
use vibro_impact::model::{Augmented, BOX_RATE, Impact, RELATIVE_RATE, SmoothMode};
use vibro_impact::simulator::{Contact, Event};

/// A block this near to a stop, in gaps, is at it: a solver's root finding leaves it about 1e-10
/// off. A bounce lower than this cannot be told from resting, so there a chatter run ends.
const CONTACT: f64 = 1e-9;
/// After an event the block is put this far inside the stop, in gaps, so that no event indicator
/// restarts at zero, where a host could not tell a crossing; it is far below [`CONTACT`] and above
/// the rounding of displacements up to a thousand gaps.
const SHIFT: f64 = 1e-12;
/// Where the bodies have gone farther, it is so many units in the last place of their
/// displacements, since w is their difference.
const SHIFT_UNITS: f64 = 4.0;
/// And a block is at a stop within so many of these shifts.
const CONTACT_SHIFTS: f64 = 2.0;

impl Continuous {
    /// The laws at an event: impact, rest or release, as far as the present point calls for one;
    /// reports them and returns whether states changed.
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

    /// At stop `side`: an impact when it is approached, rest when it is pressed on without
    /// bouncing. A block that leaves from just inside the stop, where the last call has put it, is
    /// left alone: a further call at an event does nothing.
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
            return; // it is where it was put, but for rounding
        }
        let rebound = -side * z[RELATIVE_RATE];
        let pressing = side * self.model.acceleration(SmoothMode::Flight, &z, Some(self.data.forces)).free;
        // Height of the bounce: rebound²/(2 pressing), of which the block is to make up the way
        // past the stop to which the host's solver has let it go. Dampers bring that of an elastic
        // block down too.
        let low = pressing > 0.0 && rebound * rebound <= 2.0 * pressing * (self.contact_width() + past);
        if low && self.rest(z, side) {
            report(&Event::Rest { time, side: stop });
            return;
        }
        if pressing > 0.0 {
            // On its way to where it is put the block loses speed, of which it has enough by the
            // height above: else low bounces would grow by that way, each of them.
            let slower = (rebound * rebound - 2.0 * pressing * way).max(0.0).sqrt();
            let change = side * (rebound - slower);
            z[RELATIVE_RATE] += change;
            z[BOX_RATE] -= self.model.block_share * change;
            self.data.record.box_impulse -= self.model.reduced_mass * change;
        }
        self.set_rates(&z);
        self.keep_off(side);
    }

    /// Merges box and block on stop `side` where the stop presses on them then; else nothing
    /// happens.
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

    /// Takes the velocities of box and block over.
    fn set_rates(&mut self, z: &Augmented) {
        (self.data.state.v[0], self.data.state.v[1]) = (z[BOX_RATE], z[BOX_RATE] + z[RELATIVE_RATE]);
    }

    /// Puts the block a little off stop `side`; further inside it stays where it is.
    fn keep_off(&mut self, side: f64) {
        let way = self.way_off(side);
        if way > 0.0 {
            self.bring_closer(side * way);
        }
    }

    /// How far the block is from where it is put at stop `side`, m; 0 further inside.
    fn way_off(&self, side: f64) -> f64 {
        (side * self.excess(side, self.model.gap - self.shift())).max(0.0)
    }

    /// How far inside a stop the block is put, m.
    fn shift(&self) -> f64 {
        let [x1, x2, _] = self.data.state.x;
        (SHIFT * self.model.gap).max(SHIFT_UNITS * f64::EPSILON * x1.abs().max(x2.abs()))
    }

    /// How near to a stop a block is at it, m.
    fn contact_width(&self) -> f64 {
        (CONTACT * self.model.gap).max(CONTACT_SHIFTS * self.shift())
    }

    /// By how much box and block are farther apart than `reach` on `side`, with the sign of w.
    fn excess(&self, side: f64, reach: f64) -> f64 {
        let x = &self.data.state.x;
        (x[1] - x[0]) - side * reach
    }

    /// Brings box and block closer by a part of w, their centre of mass held.
    fn bring_closer(&mut self, by: f64) {
        let x = &mut self.data.state.x;
        x[0] += self.model.block_share * by;
        x[1] -= (1.0 - self.model.block_share) * by;
    }
}
