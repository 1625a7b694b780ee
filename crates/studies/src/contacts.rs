//! Record of the contacts of a motion: impacts and rests on rigid stops, contacts with compliant
//! stops.

use super::flight::{Flow, Series, value_at};
use super::rows::Sparse;
use vibro_machine::energy::NODES;
use vibro_machine::mode::StopState;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::system::{Part, System};
use vibro_machine::{Assembly, Motion};
use vibro_numerics::sorting::sort_by;

/// Contact of a stop.
///
/// A body of 1 kg meets a stop of 100 N/m with 2 m/s. The contact is half an oscillation at
/// ω = 10 rad/s, and its force rises to v √(km):
///
/// ```
/// use std::f64::consts::PI;
/// use vibro_machine::{Assembly, Motion, file};
/// use vibro_studies::{ContactRecorder, Extremes, Followed};
///
/// # let text = r#"
/// #     name = "Buffered"
/// #     body.a = { mass = 1.0, start = { v = 2.0 } }
/// #     stop.buffer = { between = ["ground", "a"], gap = 1.0, stiffness = 100.0 }
/// # "#;
/// let machine = file::parse(text, "buffered.toml", &file::no_records)?;
/// let mut motion = Motion::new(Assembly::new(machine)?.into())?;
/// let extremes = Extremes::new(&[], (0.0, 2.0));
/// let mut followed = Followed::new(ContactRecorder::new(&motion, &[]), extremes);
/// followed.advance(&mut motion, 2.0, &mut |_| (), &mut |_| ())?;
/// let contact = followed.contacts.all()[0];
/// assert!((contact.end.unwrap() - contact.begin - PI / 10.0).abs() < 1e-14);
/// assert!((contact.peak.unwrap() - 20.0).abs() < 1e-12);
/// assert!((contact.impulse.unwrap() - 4.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopContact {
    /// Index of the stop.
    pub stop: usize,
    /// Time of the beginning, s: of an impact, of the closing of a rigid stop, or of the first
    /// touch of a compliant stop.
    pub begin: f64,
    /// Time of the end, s. For an impact it is the beginning; `None` while the contact lasts.
    pub end: Option<f64>,
    /// Largest force, N or N m; `None` for an impact, and if the flow was not observed.
    pub peak: Option<f64>,
    /// Integral of the force, or impulse of an impact, N s or N m s; `None` if the flow was not
    /// observed.
    pub impulse: Option<f64>,
    /// Closing speed at the beginning, m/s or rad/s. 0 when a rigid stop stays closed, since its
    /// impacts are separate contacts.
    pub speed: f64,
    /// Energy lost, J, at an impact or in a compliant stop, including the loss of its spring after
    /// its force is zero, or in the dashpot and the friction of a contact. `None` if the flow was not
    /// observed.
    pub lost: Option<f64>,
}

/// Recorder of the contacts of a motion that keeps its energy accounts.
#[derive(Clone, Debug)]
pub struct ContactRecorder {
    all: Vec<StopContact>,
    /// For each stop the index of the contact that lasts or still loses energy.
    current: Vec<Option<usize>>,
    /// Stops that have force or lose energy in the present mode, with their functionals.
    acting: Vec<Acting>,
}

#[derive(Clone, Debug)]
struct Acting {
    stop: usize,
    force: Sparse,
    /// Dissipative forces with their rates: of a dashpot, and of friction along the tangent. None
    /// for a rigid stop.
    losses: Vec<(Sparse, Sparse)>,
}

impl ContactRecorder {
    /// Starts with a motion at its start and the events that the motion reported there.
    pub fn new(motion: &Motion, told: &[Event]) -> Self {
        let current = vec![None; motion.mode().stops.len()];
        let mut contacts = Self { all: Vec::new(), current, acting: Vec::new() };
        contacts.meet(motion.assembly().system(), told, Some(motion.energy().impacts.value()));
        for (part, state) in motion.mode().stops.iter().enumerate() {
            let (system, i) = (motion.assembly().system(), motion.assembly().system().stop_of(part));
            let is_corner = system.is_corner(part);
            if holds(*state) && !is_corner && contacts.current[i].is_none() {
                let speed = if *state == StopState::Closed { 0.0 } else { motion.stop(i)[1] };
                contacts.begin(i, motion.time(), speed);
            }
        }
        contacts
    }

    /// The contacts so far, ordered by their beginning.
    pub fn all(&self) -> Vec<StopContact> {
        let mut all = self.all.clone();
        sort_by(&mut all, |a, b| a.begin.total_cmp(&b.begin));
        all
    }

    fn begin(&mut self, stop: usize, begin: f64, speed: f64) {
        self.current[stop] = Some(self.all.len());
        // Adding zero turns -0 into 0.
        let (speed, zero) = (speed + 0.0, Some(0.0));
        self.all.push(StopContact { stop, begin, end: None, peak: zero, impulse: zero, speed, lost: zero });
    }

    fn end(&mut self, stop: usize, time: f64) {
        if let Some(place) = self.current[stop] {
            let contact = &mut self.all[place];
            contact.end = contact.end.or(Some(time.max(contact.begin)));
        }
    }

    /// Records the events of one instant. `lost` is the energy lost at its impacts, if known.
    pub(super) fn meet(&mut self, system: &System, events: &[Event], lost: Option<f64>) {
        let first = self.all.len();
        let closes = |i: usize| events.iter().any(|e| e.kind == EventKind::Close { stop: i });
        let (mut nominal, mut work) = (0.0, 0.0);
        for event in events {
            match event.kind {
                EventKind::Impact { stop, speed, impulse, .. } => {
                    // The last impact before a stop stays closed has no restitution.
                    let own = system.stops[stop].restitution().unwrap_or(0.0);
                    let restitution = if closes(stop) { 0.0 } else { own };
                    let loss = 0.5 * (1.0 - restitution) * speed * impulse;
                    (nominal, work) = (nominal + loss, work + speed * impulse);
                    let (end, peak, impulse) = (Some(event.time), None, Some(impulse));
                    let lost = Some(loss);
                    self.all.push(StopContact { stop, begin: event.time, end, peak, impulse, speed, lost });
                }
                EventKind::Close { stop } => self.begin(stop, event.time, 0.0),
                EventKind::Press { stop, speed } => self.begin(stop, event.time, speed),
                EventKind::Open { stop } | EventKind::Free { stop, .. } => self.end(stop, event.time),
                _ => {}
            }
        }
        // The impact that ends infinitely many bounces loses the rest.
        let left = lost.map_or(0.0, |lost| lost - nominal);
        for contact in self.all[first..].iter_mut().filter(|c| c.peak.is_none()) {
            let share = contact.speed * contact.impulse.unwrap_or(0.0) / work;
            if share.is_finite() {
                contact.lost = contact.lost.map(|loss| loss + left * share);
            }
        }
    }

    /// Enters a mode.
    pub(super) fn enter(&mut self, system: &System, flow: &Flow) {
        self.acting.clear();
        let system = &*system.at_mode(&flow.mode);
        for (stop, &state) in flow.mode.stops.iter().enumerate() {
            if (!holds(state) && state != StopState::Free) || system.is_corner(stop) {
                continue;
            }
            let force = system.force_row(Part::Stop(stop), &flow.mode, &flow.lambda);
            let rows = &system.stops[stop];
            let mut losses = Vec::new();
            if state != StopState::Closed {
                let beyond = force.iter().zip(rows.spring.iter()).map(|(f, k)| f - k);
                losses.push((Sparse::of(beyond), Sparse::of(rows.elongation.rate.iter().copied())));
            }
            for (i, branch) in system.branches.iter().enumerate().filter(|own| own.1.stop() == Some(stop)) {
                let force = system.force_row(Part::Branch(i), &flow.mode, &flow.lambda);
                let slider = flow.rate_of(branch.inner.as_slice());
                losses.push((Sparse::of(force.iter().copied()), Sparse::of(slider)));
            }
            let stop = system.stop_of(stop);
            self.acting.push(Acting { stop, force: Sparse::of(force.iter().copied()), losses });
        }
    }

    /// Records a stretch of a flight over `length` s.
    pub(super) fn stretch(&mut self, series: &Series, length: f64) {
        for Acting { stop, force, losses } in &self.acting {
            let Some(place) = self.current[*stop] else { continue };
            let contact = &mut self.all[place];
            if contact.end.is_none() {
                let f = force.along(series);
                super::flight::monotone_pieces(&f, &mut |x| contact.peak = contact.peak.map(|p| p.max(x)));
                let integral: f64 = f.iter().enumerate().map(|(k, c)| c / (k + 1) as f64).sum();
                contact.impulse = contact.impulse.map(|p| p + length * integral);
            }
            for (beyond, rate) in losses {
                let (beyond, rate) = (beyond.along(series), rate.along(series));
                let power = |u: f64| value_at(&beyond, u) * value_at(&rate, u);
                let work: f64 = NODES.iter().map(|(u, w)| w * power(*u)).sum();
                contact.lost = contact.lost.map(|lost| lost + length * work);
            }
        }
    }

    /// Removes contacts that begin after `time`, s, and the ends and sums of contacts that last
    /// longer.
    pub fn cut(&mut self, time: f64) {
        self.all.retain(|contact| contact.begin <= time);
        self.current.fill(None);
        for contact in self.all.iter_mut().filter(|contact| contact.end.is_none_or(|end| end > time)) {
            (contact.end, contact.peak, contact.impulse, contact.lost) = (None, None, None, None);
        }
    }

    /// Records a flight whose flow is not observed.
    pub(super) fn leave_out(&mut self) {
        for Acting { stop, .. } in &self.acting {
            let Some(place) = self.current[*stop] else { continue };
            let contact = &mut self.all[place];
            contact.lost = contact.lost.filter(|_| contact.peak.is_none());
            (contact.peak, contact.impulse) = (None, None);
        }
    }
}

/// Whether a stop has force in a state.
fn holds(state: StopState) -> bool {
    state == StopState::Closed || state.has_force()
}

impl StopContact {
    /// `stop.NAME`.
    pub fn element(&self, assembly: &Assembly) -> String {
        assembly.name_of_stop(self.stop)
    }
}

#[cfg(test)]
mod tests;
