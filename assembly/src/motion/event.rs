//! Events of a motion.

/// An event, with its time.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Time, s.
    pub time: f64,
    /// Kind of the event.
    pub kind: EventKind,
}

/// Kind of an event, with the indices of stops and frictions.
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
    /// A rigid stop closes; the event's time is that at which its bounces accumulate.
    Close {
        /// Index of the stop.
        stop: usize,
    },
    /// A closed stop opens.
    Open {
        /// Index of the stop.
        stop: usize,
    },
    /// A compliant stop is entered.
    Press {
        /// Index of the stop.
        stop: usize,
        /// e', m/s or rad/s.
        speed: f64,
    },
    /// A compliant stop is left, or its force falls to zero beyond its gap.
    Free {
        /// Index of the stop.
        stop: usize,
    },
    /// The dashpot's force of an `ElastoGap` reaches its cap, or leaves it.
    Cap {
        /// Index of the stop.
        stop: usize,
        /// Whether the cap acts from now on.
        acts: bool,
    },
    /// A friction begins to stick.
    Stick {
        /// Index of the friction.
        friction: usize,
    },
    /// A friction begins to slip, or reverses.
    Slip {
        /// Index of the friction.
        friction: usize,
        /// Sign of e'.
        direction: f64,
        /// Its force at that time, N or N m.
        force: f64,
    },
    /// The level of a friction passes zero.
    Level {
        /// Index of the friction.
        friction: usize,
        /// Whether the friction acts from now on.
        acts: bool,
    },
    /// A knot of a signal.
    Knot,
}
