//! Evaluation of an orbit: check by the machine's own motion, events, measures, energies.

use super::cycle::LegPart;
use super::orbit::{Orbit, middle};
use super::word::Letter;
use vibro_machine::description::Description;
use vibro_machine::elements::Action;
use vibro_machine::motion::{Event, EventKind, Reached};
use vibro_machine::system::{Part, System};
use vibro_machine::{Motion, Quantity};
use vibro_studies::flight::{Flows, ObservedFlight, Observer, Passage, dot, follow};
use vibro_studies::{Error, Result};
use vibro_studies::{Measure, QuantityName, Watcher};

/// Largest difference of simultaneous times, relative to the time: rounding.
const SAME_INSTANT: f64 = 1e-14;

/// Upper limit of the multipliers for a motion to stay on its orbit over a period.
const STAYS: f64 = 1e6;

impl Orbit {
    /// Simulates each flight from its middle to its event. Returns the largest difference between
    /// a simulated and a computed event time, s.
    ///
    /// # Errors
    /// [`Error::Described`] if the machine has another event or continues in another mode.
    pub fn check_by_motion(&self) -> Result<f64> {
        let system = self.place.assembly.system();
        let mut largest: f64 = 0.0;
        for (k, leg) in self.legs().iter().enumerate() {
            let (time, z) = middle(&self.place, leg);
            let motion = Motion::from_state(self.place.assembly.clone(), time, &system.given(&z))?;
            let mut motion = motion.without_energy_accounts();
            let end = leg.time + leg.span;
            let Some(letter) = self.word().letters.get((k + 1) % self.legs().len()) else {
                let mut events = 0;
                let mut count = |event: &Event| events += u32::from(event.kind != EventKind::Knot);
                motion.advance_observed(time + self.period(), &mut count)?;
                return if events == 0 { Ok(0.0) } else { Err(self.differs(end, "has an additional event")) };
            };
            if motion.mode() != &letter.modes[0] {
                return Err(self.differs(time, "is in another mode"));
            }
            let mut reached = motion.advance_before_event(end + leg.span, &mut |_| ())?;
            let is_there = |time: f64| (time - end).abs() <= SAME_INSTANT * end.abs();
            while reached == Reached::Event
                && motion.due().is_none()
                && !(letter.timed().is_some() && is_there(motion.time()))
            {
                // A knot of a signal.
                motion.apply_event(&mut |_| ())?;
                reached = motion.advance_before_event(end + leg.span, &mut |_| ())?;
            }
            // If event functions coincide, rounding decides which one is due.
            let row = |watch| leg.flow.watched.iter().find(|own| Some(own.0) == watch).map(|own| &own.1);
            let is_due = motion.due() == letter.watch()
                || row(motion.due()).is_some_and(|due| row(letter.watch()) == Some(due));
            if reached != Reached::Event || !is_due {
                return Err(self.differs(end, "has another event"));
            }
            largest = largest.max((motion.time() - end).abs());
            let mut events: Vec<Event> = Vec::new();
            motion.apply_event(&mut |event| events.push(event.clone()))?;
            // Simultaneous knots and samples are one event of the word.
            while letter.timed().is_some() && motion.next_time_event().is_some_and(is_there) {
                motion.advance_before_event(end.max(motion.time()), &mut |_| ())?;
                motion.apply_event(&mut |event| events.push(event.clone()))?;
            }
            if motion.mode() != &letter.modes[1] || (Letter { events, ..letter.clone() }) != *letter {
                return Err(self.differs(end, "continues differently"));
            }
        }
        Ok(largest)
    }

    fn differs(&self, time: f64, how: &str) -> Error {
        let words = self.word().in_words(&self.place.assembly);
        Error::Described {
            problem: format!(
                "at t = {time} s the simulated motion {how}; the orbit has the events [{words}]"
            ),
        }
    }

    /// Passes one period of the orbit to observers.
    pub fn observe(&self, observers: &mut [&mut dyn Observer]) {
        let (system, count) = (self.place.assembly.system(), self.legs().len());
        for (k, leg) in self.legs().iter().enumerate() {
            if let Some((time, z)) = &leg.run {
                let motion = Motion::from_state(self.place.assembly.clone(), *time, &system.given(z));
                // The run was already simulated from this state, so it cannot fail.
                if let Ok(motion) = motion {
                    let mut motion = motion.without_energy_accounts();
                    let _ = follow(&mut motion, &mut Flows::default(), leg.time, observers, &mut |_| false);
                }
            }
            for (i, part) in leg.parts().enumerate() {
                let LegPart { time, span, start } = part;
                if let Some((time, [before, after])) = i.checked_sub(1).map(|i| &leg.knots[i]) {
                    let events = [Event { time: *time, kind: EventKind::Knot }];
                    let (flows, states) = ([&*leg.flow, &*leg.flow], [&before[..], &after[..]]);
                    let passage =
                        Passage { time: *time, watch: None, flows, states, events: &events, lost: 0.0 };
                    observers.iter_mut().for_each(|o| o.passage(system, passage));
                }
                let flight = ObservedFlight { time, flow: &leg.flow, start, span };
                observers.iter_mut().for_each(|o| o.flight(system, flight));
            }
            let Some(letter) = self.word().letters.get((k + 1) % count) else { continue };
            let next = self.legs().get(k + 1);
            let after = next.map_or(&self.cycle.back, |leg| &leg.states[0]);
            let flow = &self.legs()[(k + 1) % count].flow;
            let time = leg.time + leg.span;
            let events =
                present(letter, system, [&letter.arrived(system, time, &leg.states[1]), after], time);
            let passage = Passage {
                time,
                watch: letter.watch(),
                flows: [&leg.flow, flow],
                states: [&leg.states[1], after],
                events: &events,
                lost: 0.0,
            };
            observers.iter_mut().for_each(|o| o.passage(system, passage));
        }
    }

    /// The events of a period, with this orbit's times and speeds.
    pub fn events(&self) -> Vec<Event> {
        let (system, count) = (self.place.assembly.system(), self.legs().len());
        let at = |(k, letter): (usize, &Letter)| {
            let before = &self.legs()[(k + count - 1) % count];
            let (time, own) = (self.numbers.times[k], &self.legs()[k]);
            let after = if k == 0 { &self.cycle.back[..] } else { own.entered() };
            present(letter, system, [&letter.arrived(system, time, &before.states[1]), after], time)
        };
        self.word().letters.iter().enumerate().flat_map(at).collect()
    }

    /// Extrema and mean squares of quantities over a period, and the contacts of stops.
    pub fn watched(&self, quantities: &[Quantity]) -> Watcher {
        let stops = self.place.assembly.system().stops.len();
        let mut watcher = Watcher::of(quantities, stops);
        self.observe(&mut [&mut watcher]);
        watcher
    }
}

impl Orbit {
    /// A measure over a period. Impacts are counted per common period of the drive, or per period
    /// of an autonomous machine.
    ///
    /// # Errors
    /// [`Error::Described`] for a name that the machine does not have, and for powers, class and
    /// exponent, which are not measures of an orbit.
    pub fn measure(&self, measure: &Measure) -> Result<f64> {
        let d = &self.place.assembly.description;
        check_measure(measure, d)?;
        let name = measure.quantity();
        let places = name.into_iter().map(|q| Ok(q.find(d)?.quantity)).collect::<Result<Vec<_>>>()?;
        let names: Vec<&QuantityName> = name.into_iter().collect();
        let times = (f64::from(self.word().periods.unwrap_or(1)), self.period());
        Ok(self.watched(&places).number(measure, d, &names, times).unwrap_or(0.0))
    }

    /// The energy that each load supplies and that each other element absorbs, J per period, by
    /// name, from the machine's own motion over a period. `None` if the orbit is too unstable for
    /// a motion to stay on it.
    ///
    /// # Errors
    /// As [`Motion::advance_to`].
    pub fn energies(&self) -> Result<Option<Vec<(String, f64)>>> {
        if self.spectral_radius() > STAYS {
            return Ok(None);
        }
        let (assembly, (time, state)) = (&self.place.assembly, self.middle_state());
        let mut motion = Motion::from_state(assembly.clone(), time, &state)?;
        motion.advance_to(time + self.period())?;
        let accounts = motion.energy();
        let mut all: Vec<(String, f64)> = Vec::new();
        for (element, parts) in assembly.description.elements().zip(&assembly.system().parts) {
            let energy: f64 = parts
                .iter()
                .map(|part| match *part {
                    Part::Spring(i) => accounts.dashpots[i].value(),
                    Part::Stop(i) => accounts.stops[i].value(),
                    Part::Friction(i) => accounts.frictions[i].value(),
                    Part::Branch(i) => accounts.branches[i].value(),
                    Part::Load(i) => accounts.loads[i].value(),
                })
                .sum();
            if element.action() != Action::Tying {
                all.push((element.dotted(), energy));
            }
        }
        all.push(("impacts of all rigid stops".into(), accounts.impacts.value()));
        Ok(Some(all))
    }
}

/// Measures of an orbit, for messages.
const MEASURES: &str = "amplitude.Q, rms.Q, peak_to_peak.Q or maximum.Q of a quantity Q such as \
                        box.s or buffer.f; impacts, impact.rate, each alone or with .STOP; \
                        impact.speed.STOP, impact.impulse.STOP; or a quantity, such as box.s, for its \
                        largest value";

/// Parses the name of an orbit's measure; the name of a quantity alone means its largest value.
///
/// # Errors
/// [`Error::Described`] for a name that is not an orbit's measure; as [`check_measure`].
pub fn read_measure(name: &str, d: &Description) -> Result<Measure> {
    let largest = |_| name.parse().map(Measure::Maximum);
    let measure = name.parse().or_else(largest).map_err(|_: Error| no_measure(name))?;
    check_measure(&measure, d)?;
    Ok(measure)
}

fn no_measure(name: &str) -> Error {
    Error::Described { problem: format!("{name}: is not a measure of an orbit; expected {MEASURES}") }
}

/// Checks that a measure is defined for an orbit and for the machine's bodies and elements.
///
/// # Errors
/// [`Error::Described`] for a name that the machine does not have, and for powers, class and
/// exponent.
pub fn check_measure(measure: &Measure, d: &Description) -> Result<()> {
    let is_other =
        matches!(measure, Measure::Power(_) | Measure::PowerLost | Measure::Class | Measure::Exponent);
    if is_other { Err(no_measure(&measure.to_string())) } else { measure.check(d) }
}

/// The reports of an event with speeds and impulses from the states before and after it.
fn present(letter: &Letter, system: &System, [before, after]: [&[f64]; 2], time: f64) -> Vec<Event> {
    let mut z = before.to_vec();
    let closes = |stop: usize| letter.events.iter().any(|e| e.kind == EventKind::Close { stop });
    let (mut events, mut left) = (Vec::new(), 0);
    for (i, event) in letter.events.iter().enumerate() {
        let rate = |z: &[f64], stop: usize| dot(system.stops[stop].elongation.rate.as_slice(), z);
        let kind = match event.kind {
            EventKind::Impact { stop, stops, .. } => {
                let speed = rate(&z, stop);
                let compliance = system.stops[stop].elongation.w.dot(&system.stops[stop].elongation.mobility);
                let restitution = system.stops[stop].restitution().filter(|_| !closes(stop)).unwrap_or(0.0);
                let impulse = if compliance > 0.0 { (1.0 + restitution) * speed / compliance } else { 0.0 };
                // Stops of one impact are hit together; the state changes after the last.
                left = if left == 0 { stops.max(1) } else { left } - 1;
                if left == 0 {
                    let own = Letter { events: letter.events[..=i].to_vec(), ..letter.clone() };
                    z = before.to_vec();
                    own.strike(system, [&mut z[..]]);
                }
                EventKind::Impact { stop, speed, impulse, stops }
            }
            EventKind::Press { stop, .. } => EventKind::Press { stop, speed: rate(&z, stop) },
            EventKind::Free { stop, .. } => EventKind::Free { stop, rate: rate(&z, stop) },
            EventKind::Yield { slider, direction, .. } => {
                let force = system.branch_force_at(slider, letter.modes[1].sliders[slider], &z);
                EventKind::Yield { slider, direction, force }
            }
            EventKind::Hold { slider, .. } => {
                let force = system.branch_force_at(slider, letter.modes[0].sliders[slider], &z);
                EventKind::Hold { slider, force }
            }
            EventKind::Limit { block, output, side, stop, .. } => {
                let states = &letter.modes[1].stops;
                let row = system.blocks[block].outputs[output].row_in(&system.stops, states);
                EventKind::Limit { block, output, side, value: dot(row.as_slice(), after), stop }
            }
            kind => kind,
        };
        events.push(Event { time, kind });
    }
    events
}
