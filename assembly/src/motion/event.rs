//! What happens in a motion.

/// An event, with its time.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// s.
    pub time: f64,
    /// What happened.
    pub kind: EventKind,
}

/// What happened, by the places of stops and frictions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// A rigid stop was hit.
    Impact {
        /// Its place.
        stop: usize,
        /// Closing speed, m/s or rad/s.
        speed: f64,
        /// Impulse, N s or N m s.
        impulse: f64,
        /// How many stops took part with an impulse.
        stops: usize,
    },
    /// A rigid stop stays closed from now on; its time is that at which the bounces accumulate.
    Close {
        /// Its place.
        stop: usize,
    },
    /// A closed stop opens.
    Open {
        /// Its place.
        stop: usize,
    },
    /// A compliant stop is met, with this rate.
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
    /// The dashpot's share of an `ElastoGap` comes to its cap, or leaves it.
    Cap {
        /// Its place.
        stop: usize,
        /// Whether it is at the cap from now on.
        acts: bool,
    },
    /// Slipping ends.
    Stick {
        /// Place of the friction.
        friction: usize,
    },
    /// Slipping begins or turns round.
    Slip {
        /// Place of the friction.
        friction: usize,
        /// Sign of e'.
        direction: f64,
        /// The friction's force at that time, N or N m.
        force: f64,
    },
    /// A friction's level passes zero.
    Level {
        /// Place of the friction.
        friction: usize,
        /// Whether it acts from now on.
        acts: bool,
    },
    /// A signal's knot.
    Knot,
}
