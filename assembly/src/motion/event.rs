//! Events of a motion.

/// An event, with its time.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Time, s.
    pub time: f64,
    /// What happened.
    pub kind: EventKind,
}

/// Kind of an event, with the indices of stops and frictions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// A rigid stop was hit.
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
    /// The dashpot's share of an `ElastoGap` comes to its cap, or leaves it.
    Cap {
        /// Index of the stop.
        stop: usize,
        /// Whether the cap acts from now on.
        acts: bool,
    },
    /// Slipping ends.
    Stick {
        /// Index of the friction.
        friction: usize,
    },
    /// Slipping begins or turns round.
    Slip {
        /// Index of the friction.
        friction: usize,
        /// Sign of e'.
        direction: f64,
        /// Its force at that time, N or N m.
        force: f64,
    },
    /// A friction's level passes zero.
    Level {
        /// Index of the friction.
        friction: usize,
        /// Whether the friction acts from now on.
        acts: bool,
    },
    /// A signal's knot.
    Knot,
}
