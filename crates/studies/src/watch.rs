//! Quantities observed along a motion: extrema and mean squares, local maxima, contacts.

use super::flight::{ObservedFlight, Observer, Passage, coefficients, monotone_pieces};
use vibro_machine::Quantity;
use vibro_machine::energy::NODES;
use vibro_machine::motion::EventKind;
use vibro_machine::system::System;

/// Tolerance of a plateau: two values that differ by at most this fraction of the largest size so
/// far belong to one plateau.
const FLAT: f64 = 1e-12;
/// Relative rounding error of an event's time; both the clock and the flight's length are rounded.
const CLOCK: f64 = 4.0 * f64::EPSILON;
/// An extremum smaller than this fraction of the largest size counts as zero, for example the
/// elongation of a stop with gap 0 at its impacts. The value covers the clock: after 1e5 periods
/// the clock is rounded to about 1e-11 of a period.
const ZERO: f64 = 1e-10;

/// The value, or zero if it is rounding relative to `size`.
fn rounded(value: f64, size: f64) -> f64 {
    if value.abs() <= ZERO * size { 0.0 } else { value }
}

/// Extrema of a quantity so far, and the integral of its square.
#[derive(Clone, Debug)]
pub struct Extent {
    quantity: Quantity,
    /// Smallest value.
    pub least: f64,
    /// Largest value.
    pub largest: f64,
    /// ∫ q² dt.
    pub square: f64,
}

/// Local maxima of a quantity. A plateau counts once, at its end.
#[derive(Clone, Debug)]
pub struct Maxima {
    quantity: Quantity,
    last: Option<f64>,
    rising: bool,
    size: f64,
    /// Upper bound of the rate during the last stretch of a flight, per second.
    rate: f64,
    /// Additional tolerance for the first value of a flight, due to the rounding of the clock.
    slack: f64,
    /// Maxima in order.
    pub found: Vec<f64>,
}

impl Maxima {
    /// Starts a search for the maxima of a quantity.
    pub fn new(quantity: Quantity) -> Self {
        Self { quantity, last: None, rising: false, size: 0.0, rate: 0.0, slack: 0.0, found: Vec::new() }
    }

    /// Begins a flight at a time. Because the clock is rounded, the first value of this flight may
    /// differ from the last value of the previous flight. This difference counts neither as a rise
    /// nor as a fall.
    fn begin(&mut self, time: f64, rate: f64) {
        self.slack = CLOCK * time.abs() * rate.max(self.rate);
    }

    /// Includes the next value. The quantity is monotone between two values.
    fn meet(&mut self, value: f64) {
        self.size = self.size.max(value.abs());
        let Some(last) = self.last else {
            self.last = Some(value);
            return;
        };
        let flat = FLAT * self.size + std::mem::take(&mut self.slack);
        if value > last + flat {
            self.rising = true;
        } else if value < last - flat {
            if self.rising {
                self.found.push(rounded(last, self.size));
            }
            self.rising = false;
        } else {
            return;
        }
        self.last = Some(value);
    }
}

/// Upper bound of the rate of a quantity with these coefficients over a stretch of `length` s.
fn largest_rate(q: &[f64], length: f64) -> f64 {
    let sum: f64 = q.iter().enumerate().map(|(k, c)| k as f64 * c.abs()).sum();
    if sum == 0.0 { 0.0 } else { sum / length }
}

/// Summary of the contacts of a stop.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactSummary {
    /// Number of impacts, or of first touches of a compliant stop.
    pub count: u32,
    /// Largest closing speed.
    pub speed: f64,
    /// Largest impulse of a rigid stop.
    pub impulse: f64,
    /// Energy lost at impacts, J: ½ (1 - ε) u P each.
    pub lost: f64,
}

/// Observer of extents, maxima and contacts. Extents and maxima are read from the same power
/// series of a flight.
#[derive(Clone, Debug, Default)]
pub struct Watcher {
    /// Extents of quantities.
    pub extents: Vec<Extent>,
    /// Maxima of one quantity.
    pub maxima: Option<Maxima>,
    /// Contacts by stop.
    pub contacts: Vec<ContactSummary>,
    /// Number of events of any element.
    pub events: u32,
}

impl Watcher {
    /// Observes the extents of some quantities.
    pub fn of(quantities: &[Quantity], stops: usize) -> Self {
        let extent = |&quantity: &Quantity| Extent {
            quantity,
            least: f64::INFINITY,
            largest: f64::NEG_INFINITY,
            square: 0.0,
        };
        Self {
            extents: quantities.iter().map(extent).collect(),
            maxima: None,
            contacts: vec![ContactSummary::default(); stops],
            events: 0,
        }
    }

    /// Joins the extents and contacts of a later observer.
    pub fn join(&mut self, later: &Self) {
        for (own, of) in self.extents.iter_mut().zip(&later.extents) {
            own.least = own.least.min(of.least);
            own.largest = own.largest.max(of.largest);
            own.square += of.square;
        }
        for (own, of) in self.contacts.iter_mut().zip(&later.contacts) {
            own.count += of.count;
            own.speed = own.speed.max(of.speed);
            own.impulse = own.impulse.max(of.impulse);
            own.lost += of.lost;
        }
    }

    /// Resets extents, contacts and the number of events. The search for maxima continues, and
    /// keeps the maxima found.
    pub fn clear(&mut self) {
        for extent in &mut self.extents {
            (extent.least, extent.largest, extent.square) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
        }
        self.contacts.iter_mut().for_each(|c| *c = ContactSummary::default());
        self.events = 0;
    }
}

impl Observer for Watcher {
    fn flight(&mut self, system: &System, flight: ObservedFlight<'_>) {
        if self.extents.is_empty() && self.maxima.is_none() {
            return;
        }
        let rows: Vec<Vec<f64>> =
            self.extents.iter().map(|e| flight.flow.row_of(system, e.quantity)).collect();
        let top = self.maxima.as_ref().map(|m| flight.flow.row_of(system, m.quantity));
        let mut is_first = true;
        flight.flow.stretches(flight.start, flight.span, &mut |series, length| {
            for (extent, row) in self.extents.iter_mut().zip(&rows) {
                let q = coefficients(row, series);
                let value = |u: f64| q.iter().rev().fold(0.0, |sum, c| sum * u + c);
                extent.square += length * NODES.iter().map(|(u, w)| w * value(*u).powi(2)).sum::<f64>();
                let spread: f64 = q[1..].iter().map(|c| c.abs()).sum();
                // On this stretch the quantity lies between q[0] - spread and q[0] + spread. The
                // stretch is searched only if this range exceeds the extrema found so far.
                if q[0] + spread > extent.largest || q[0] - spread < extent.least {
                    monotone_pieces(&q, &mut |x| {
                        extent.least = extent.least.min(x);
                        extent.largest = extent.largest.max(x);
                    });
                    let size = extent.largest.max(-extent.least);
                    extent.least = rounded(extent.least, size);
                    extent.largest = rounded(extent.largest, size);
                }
            }
            if let (Some(maxima), Some(row)) = (&mut self.maxima, &top) {
                let q = coefficients(row, series);
                let rate = largest_rate(&q, length);
                if std::mem::take(&mut is_first) {
                    maxima.begin(flight.time, rate);
                }
                maxima.rate = rate;
                monotone_pieces(&q, &mut |x| maxima.meet(x));
            }
        });
    }

    fn passage(&mut self, system: &System, passage: Passage<'_>) {
        self.events += u32::from(passage.watch.is_some());
        for event in passage.events {
            match event.kind {
                EventKind::Impact { stop, speed, impulse, .. } => {
                    let own = &mut self.contacts[stop];
                    own.count += 1;
                    own.speed = own.speed.max(speed);
                    own.impulse = own.impulse.max(impulse);
                    let restitution = system.stops[stop].restitution().unwrap_or(0.0);
                    own.lost += 0.5 * (1.0 - restitution) * speed * impulse;
                }
                EventKind::Press { stop, speed } => {
                    let own = &mut self.contacts[stop];
                    own.count += 1;
                    own.speed = own.speed.max(speed);
                }
                _ => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Machine, Measure, QuantityName, discard, measure};
    use super::*;
    use vibro_machine::file::no_records;

    /// The wall touches the body where the spring is relaxed, so the largest coordinate is 0 at
    /// every impact. Without the wall there are no impacts.
    #[test]
    fn closed_form_what_is_zero_has_no_rounding_and_no_sign() {
        let text = "name = \"M\"\n[body.a]\nmass = 1.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 100.0\n\
            damping = 0.5\n[load.f]\non = \"a\"\namplitude = 1.0\nfrequency = 2.3\n";
        let wall = "[stop.w]\nbetween = [\"ground\", \"a\"]\ngap = 0.0\nrestitution = 0.6\n";
        let measured = |text: &str, names: &[&str]| {
            let machine = Machine::parse(text, "m.toml", &no_records).unwrap();
            let (mut motion, section) = machine.motion(&Default::default()).unwrap();
            discard(&mut motion, &section, 200).unwrap();
            let names: Vec<Measure> = names.iter().map(|n| n.parse().unwrap()).collect();
            measure(&mut motion, &section, &names, 10).unwrap().numbers
        };
        let found = measured(&format!("{text}{wall}"), &["maximum.a.s", "maximum.w.e", "impacts"]);
        assert_eq!(found, [Some(0.0), Some(0.0), Some(1.0)]);
        let found = measured(text, &["impacts", "impact.rate"]);
        assert!(found.iter().all(|x| x.is_some_and(|x| x == 0.0 && x.is_sign_positive())), "{found:?}");
    }

    fn maxima(values: &[f64]) -> Vec<f64> {
        let d = Machine::parse(crate::tests::OSCILLATOR, "m.toml", &no_records).unwrap().description;
        let mut maxima = Maxima::new("a.s".parse::<QuantityName>().unwrap().find(&d).unwrap().quantity);
        values.iter().for_each(|x| maxima.meet(*x));
        maxima.found
    }

    #[test]
    fn closed_form_maxima_of_sequences() {
        for (values, expected) in [
            (&[0.0, 1.0, 0.5, 2.0, -1.0, -0.5, -3.0][..], &[1.0, 2.0, -0.5][..]),
            // A value that falls from the start or rises at the end is not a maximum.
            (&[3.0, 1.0, 2.0], &[]),
            // A plateau with rounding is one maximum if the values rise before it and fall after
            // it.
            (&[0.0, 1.0, 1.0 + 1e-14, 1.0, 1.0 - 1e-14, 0.5], &[1.0]),
            (&[2.0, 0.5, 0.5 + 1e-14, 0.5, 0.0, 1.0], &[]),
            (&[-2.0, 0.5, 0.5 - 1e-14, 0.5, 1.0], &[]),
            // A maximum below 1e-10 of the largest value so far is zero.
            (&[-5.0, 4e-10, -5.0, 6e-10, -5.0], &[0.0, 6e-10]),
        ] {
            assert_eq!(maxima(values), expected, "{values:?}");
        }
    }

    #[test]
    fn closed_form_joined_extents_are_those_of_the_whole() {
        let part = |least: f64, largest: f64, square: f64, (count, speed): (u32, f64)| {
            let machine = Machine::parse(crate::tests::OSCILLATOR, "m.toml", &no_records).unwrap();
            let place = "a.s".parse::<QuantityName>().unwrap().find(&machine.description).unwrap().quantity;
            let mut watcher = Watcher::of(&[place], 1);
            let own = &mut watcher.extents[0];
            assert!(own.least == f64::INFINITY && own.largest == f64::NEG_INFINITY && own.square == 0.0);
            (own.least, own.largest, own.square) = (least, largest, square);
            watcher.contacts[0] = ContactSummary { count, speed, impulse: 2.0 * speed, lost: 3.0 * speed };
            watcher.events = count;
            watcher
        };
        for (a, b) in [((-1.0, 2.0), (0.0, 3.0)), ((0.0, 3.0), (-1.0, 2.0))] {
            let mut whole = part(a.0, a.1, 0.5, (2, 4.0));
            whole.join(&part(b.0, b.1, 0.25, (3, 1.0)));
            let own = &whole.extents[0];
            assert_eq!((own.least, own.largest, own.square), (-1.0, 3.0, 0.75));
            let own = whole.contacts[0];
            assert_eq!((own.count, own.speed, own.impulse, own.lost), (5, 4.0, 8.0, 15.0));
            whole.clear();
            let (extent, contacts) = (&whole.extents[0], whole.contacts[0]);
            assert!(
                extent.least == f64::INFINITY && extent.largest == f64::NEG_INFINITY && extent.square == 0.0
            );
            assert_eq!((contacts.count, contacts.speed, contacts.impulse, contacts.lost), (0, 0.0, 0.0, 0.0));
            assert_eq!(whole.events, 0);
        }
    }
}
