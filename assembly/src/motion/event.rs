//! Events of a motion.

/// An event, with its time.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// s.
    pub time: f64,
    /// Kind of the event.
    pub kind: EventKind,
}

/// The kind of an event, with the places of stops and frictions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// An impact at a rigid stop.
    Impact {
        /// Its place.
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
        /// Its place.
        stop: usize,
    },
    /// A closed stop opens.
    Open {
        /// Its place.
        stop: usize,
    },
    /// A compliant stop is met.
    Press {
        /// Its place.
        stop: usize,
        /// e', m/s or rad/s.
        speed: f64,
    },
    /// A compliant stop is left, or its force falls to zero beyond its gap.
    Free {
        /// Its place.
        stop: usize,
    },
    /// The dashpot's force of an `ElastoGap` reaches its cap, or leaves it.
    Cap {
        /// Its place.
        stop: usize,
        /// Whether it is at the cap from now on.
        acts: bool,
    },
    /// A friction begins to stick.
    Stick {
        /// Place of the friction.
        friction: usize,
    },
    /// A friction begins to slip, or reverses.
    Slip {
        /// Place of the friction.
        friction: usize,
        /// Sign of e'.
        direction: f64,
        /// The friction's force just after the event, N or N m.
        force: f64,
    },
    /// The level of a friction passes zero.
    Level {
        /// Place of the friction.
        friction: usize,
        /// Whether it acts from now on.
        acts: bool,
    },
    /// A knot of a signal.
    Knot,
}
