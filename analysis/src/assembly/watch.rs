//! What is read off a motion along the way: extrema and mean squares, local maxima, contacts.

use super::flight::{Flight, Observer, Passage, coefficients, monotone_pieces};
use super::quantity::Place;
use vibro_assembly::energy::NODES;
use vibro_assembly::motion::EventKind;
use vibro_assembly::system::System;

/// Values of a plateau differ by less than this part of the largest.
const FLAT: f64 = 1e-12;

/// Extrema of a quantity so far, and the integral of its square.
#[derive(Clone, Debug)]
pub struct Extent {
    place: Place,
    /// The least value.
    pub least: f64,
    /// The largest value.
    pub largest: f64,
    /// ∫ q² dt.
    pub square: f64,
}

/// The local maxima of a quantity. One that lasts counts once, where it ends.
#[derive(Clone, Debug)]
pub struct Maxima {
    place: Place,
    last: Option<f64>,
    rising: bool,
    size: f64,
    /// In order.
    pub found: Vec<f64>,
}

impl Maxima {
    /// Of a quantity.
    pub fn new(place: Place) -> Self {
        Self { place, last: None, rising: false, size: 0.0, found: Vec::new() }
    }

    /// The next value; the quantity is monotone from one to the next.
    fn meet(&mut self, value: f64) {
        self.size = self.size.max(value.abs());
        let Some(last) = self.last else {
            self.last = Some(value);
            return;
        };
        if value > last + FLAT * self.size {
            self.rising = true;
        } else if value < last - FLAT * self.size {
            if self.rising {
                self.found.push(last);
            }
            self.rising = false;
        } else {
            return;
        }
        self.last = Some(value);
    }
}

/// Contacts of a stop.
#[derive(Clone, Copy, Debug, Default)]
pub struct Contacts {
    /// Impacts, or first touches of a compliant stop.
    pub count: u32,
    /// The largest closing speed.
    pub speed: f64,
    /// The largest impulse of a rigid stop.
    pub impulse: f64,
    /// Energy lost at impacts, J: ½ (1 - ε) u P each.
    pub lost: f64,
}

/// Looks at several things at once, which share the series.
#[derive(Clone, Debug, Default)]
pub struct Watcher {
    /// Extents of quantities.
    pub extents: Vec<Extent>,
    /// Maxima of one.
    pub maxima: Option<Maxima>,
    /// By stop.
    pub contacts: Vec<Contacts>,
    /// Events of any element.
    pub events: u32,
}

impl Watcher {
    /// Of the extents of some quantities.
    pub fn of(places: &[Place], stops: usize) -> Self {
        let extent =
            |&place: &Place| Extent { place, least: f64::INFINITY, largest: f64::NEG_INFINITY, square: 0.0 };
        Self {
            extents: places.iter().map(extent).collect(),
            maxima: None,
            contacts: vec![Contacts::default(); stops],
            events: 0,
        }
    }

    /// Takes in the extents and contacts that another saw after it.
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

    /// Forgets what was seen, but for where maxima stand.
    pub fn clear(&mut self) {
        for extent in &mut self.extents {
            (extent.least, extent.largest, extent.square) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
        }
        self.contacts.iter_mut().for_each(|c| *c = Contacts::default());
        self.events = 0;
    }
}

impl Observer for Watcher {
    fn flight(&mut self, system: &System, flight: Flight<'_>) {
        if self.extents.is_empty() && self.maxima.is_none() {
            return;
        }
        let rows: Vec<Vec<f64>> = self.extents.iter().map(|e| e.place.row(system, flight.flow)).collect();
        let top = self.maxima.as_ref().map(|m| m.place.row(system, flight.flow));
        flight.flow.stretches(flight.start, flight.span, &mut |series, length| {
            for (extent, row) in self.extents.iter_mut().zip(&rows) {
                let q = coefficients(row, series);
                let value = |u: f64| q.iter().rev().fold(0.0, |sum, c| sum * u + c);
                extent.square += length * NODES.iter().map(|(u, w)| w * value(*u).powi(2)).sum::<f64>();
                let spread: f64 = q[1..].iter().map(|c| c.abs()).sum();
                // Between the ends it cannot pass the extrema met so far.
                if q[0] + spread > extent.largest || q[0] - spread < extent.least {
                    monotone_pieces(&q, &mut |x| {
                        extent.least = extent.least.min(x);
                        extent.largest = extent.largest.max(x);
                    });
                }
            }
            if let (Some(maxima), Some(row)) = (&mut self.maxima, &top) {
                monotone_pieces(&coefficients(row, series), &mut |x| maxima.meet(x));
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
