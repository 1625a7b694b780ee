//! Events of a motion.

use crate::mode::Contact;
use crate::system::SampleAction;

/// An event, with its time.
///
///
/// A ball that falls from 5 m keeps half its speed at each impact:
///
/// ```
/// use vibro_machine::motion::EventKind;
/// use vibro_machine::{Assembly, Motion, file};
///
/// # let text = r#"
/// #     name = "Ball"
/// #     gravity = 10.0
/// #     body.ball = { mass = "20 g", gravity = 1.0 }
/// #     stop.floor = { between = ["ground", "ball"], gap = "5 m", restitution = 0.5 }
/// # "#;
/// let machine = file::parse(text, "ball.toml", &file::no_records)?;
/// let mut motion = Motion::new(Assembly::new(machine)?.into())?;
/// let mut impacts = Vec::new();
/// motion.advance_observed(2.6, &mut |event| {
///     if let EventKind::Impact { speed, .. } = event.kind {
///         impacts.push((event.time, speed));
///     }
/// })?;
/// let exact = [(1.0, 10.0), (2.0, 5.0), (2.5, 2.5)];
/// assert_eq!(impacts.len(), exact.len());
/// for ((time, speed), (t, v)) in impacts.into_iter().zip(exact) {
///     assert!((time - t).abs() < 1e-14 && (speed - v).abs() < 1e-13);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Time, s.
    pub time: f64,
    /// Kind of the event.
    pub kind: EventKind,
}

impl Event {
    /// Returns the action of a sampled block, if this is a sample.
    pub fn sample(&self) -> Option<SampleAction> {
        if let EventKind::Sample { action } = self.kind { Some(action) } else { None }
    }

    /// Whether the event is a row of a table of events; samples are not.
    pub fn is_listed(&self) -> bool {
        !matches!(self.kind, EventKind::Sample { .. })
    }

    /// The stop, friction element or slider that has the event; `None` for a knot.
    pub fn contact(&self) -> Option<Contact> {
        match self.kind {
            EventKind::Impact { stop, .. }
            | EventKind::Close { stop }
            | EventKind::Open { stop }
            | EventKind::Press { stop, .. }
            | EventKind::Free { stop, .. }
            | EventKind::Cap { stop, .. }
            | EventKind::Corner { corner: stop, .. } => Some(Contact::Stop(stop)),
            EventKind::Stick { friction }
            | EventKind::Slip { friction, .. }
            | EventKind::Level { friction, .. } => Some(Contact::Friction(friction)),
            EventKind::Yield { slider, .. } | EventKind::Hold { slider, .. } => Some(Contact::Slider(slider)),
            EventKind::Limit { stop, .. } => stop.map(Contact::Stop),
            EventKind::Knot | EventKind::Sample { .. } => None,
        }
    }
}

/// Kind of an event, with the indices of its elements.
///
///
/// A block that slides with 3 m/s against a friction of 2 N sticks after 1.5 s:
///
/// ```
/// use vibro_machine::motion::EventKind;
/// use vibro_machine::{Assembly, Motion, file};
///
/// let text = r#"
///     name = "Block"
///     body.block = { mass = 1.0, start = { v = 3.0 } }
///     friction.ground = { between = ["ground", "block"], force = 2.0 }
/// "#;
/// let machine = file::parse(text, "block.toml", &file::no_records)?;
/// let mut motion = Motion::new(Assembly::new(machine)?.into())?;
/// let mut events = Vec::new();
/// motion.advance_observed(5.0, &mut |event| events.push(event.clone()))?;
/// assert_eq!(events.len(), 1);
/// assert_eq!(events[0].kind, EventKind::Stick { friction: 0 });
/// assert!((events[0].time - 1.5).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// An impact at a rigid stop.
    Impact {
        /// Index of the stop.
        stop: usize,
        /// Closing speed, m/s or rad/s.
        speed: f64,
        /// Impulse, N s or N m s.
        impulse: f64,
        /// Number of stops with an impulse in this impact.
        stops: usize,
    },
    /// A rigid stop closes; the event's time is the time at which its bounces accumulate.
    Close {
        /// Index of the stop.
        stop: usize,
    },
    /// A closed stop opens.
    Open {
        /// Index of the stop.
        stop: usize,
    },
    /// The force of a compliant stop begins.
    Press {
        /// Index of the stop.
        stop: usize,
        /// e', m/s or rad/s.
        speed: f64,
    },
    /// The force of a compliant stop ends: the stop is left, or its force falls to zero while e
    /// still exceeds the gap. Leaving the gap later without a force is not a reported event.
    Free {
        /// Index of the stop.
        stop: usize,
        /// e', m/s or rad/s.
        rate: f64,
    },
    /// The force of an `ElastoGap`'s dashpot reaches its cap, or leaves it.
    Cap {
        /// Index of the stop.
        stop: usize,
        /// Whether the cap now acts.
        acts: bool,
    },
    /// A corner of a spring's force is passed.
    Corner {
        /// Index of the corner among stops and corners.
        corner: usize,
        /// e', m/s or rad/s.
        rate: f64,
    },
    /// A friction element begins to stick.
    Stick {
        /// Index of the friction element.
        friction: usize,
    },
    /// A friction element begins to slip, or reverses.
    Slip {
        /// Index of the friction element.
        friction: usize,
        /// Sign of e'.
        direction: f64,
        /// Friction force at that time, N or N m.
        force: f64,
    },
    /// The level of a friction element passes zero.
    Level {
        /// Index of the friction element.
        friction: usize,
        /// Whether friction now acts.
        acts: bool,
    },
    /// The slider of a branch begins to slip.
    Yield {
        /// Index of the branch.
        slider: usize,
        /// Sign of e'.
        direction: f64,
        /// The branch's force at that time, N or N m.
        force: f64,
    },
    /// The slider of a branch begins to be held.
    Hold {
        /// Index of the branch.
        slider: usize,
        /// The branch's force at that time, N or N m.
        force: f64,
    },
    /// A knot of a signal.
    Knot,
    /// An output of a block comes to a limit, or leaves it.
    Limit {
        /// Index of the block.
        block: usize,
        /// Index among its outputs.
        output: usize,
        /// 1 at the upper limit, -1 at the lower one, 0 between.
        side: f64,
        /// The output's value.
        value: f64,
        /// Index of the limit among the stops, for a continuous block.
        stop: Option<usize>,
    },
    /// A sampled block reads its inputs, or its outputs act. Not a row of a table of events.
    Sample {
        /// Whether the block reads, or its outputs act.
        action: SampleAction,
    },
}
