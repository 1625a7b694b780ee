//! Why a motion has no derivative from an instant on (docs/assembly-law.md, section 14).

use std::fmt;

/// The instant at which a motion loses its derivative with respect to a parameter, and the reason.
///
///
/// From 1 s on, a pull just cancels the force that presses a body on a stop. If that force
/// changes, the body either stays or leaves:
///
/// ```
/// use vibro_machine::derivative::Cause;
/// use vibro_machine::{Assembly, Differentiated, Quantity, What, file};
///
/// # let text = r#"
/// #     name = "Pressed"
/// #     body.a = { mass = 1.0, start = { s = 0.1 } }
/// #     load.push = { on = "a", constant = 5.0, steps = [[1.0, -5.0]] }
/// #     stop.wall = { between = ["ground", "a"], gap = 0.1, restitution = 0.5 }
/// # "#;
/// let machine = file::parse(text, "pressed.toml", &file::no_records)?;
/// let mut motion = Differentiated::new(Assembly::new(machine)?.into(), &["load.push.constant"])?;
/// motion.advance_to(2.0)?;
/// let lost = motion.lost(0).unwrap();
/// assert_eq!((lost.time, lost.cause), (1.0, Cause::Limit));
/// assert_eq!(lost.element, "stop.wall");
/// assert_eq!(motion.derivative(Quantity::of_body(0, What::S), 0), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Lost {
    /// Time, s.
    pub time: f64,
    /// The element, such as `stop.NAME`, or a description such as `the step at 1 s`.
    pub element: String,
    /// The reason.
    pub cause: Cause,
}

impl Lost {
    /// The loss of a derivative whose value is not finite.
    pub(super) fn unknown(time: f64) -> Self {
        Self { time, element: "a value".into(), cause: Cause::Limit }
    }
}

/// The reason why a derivative does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// A limit is touched without speed, so that the changed motion may not reach it.
    Touch,
    /// Two events at one instant: their order depends on the change, and matters.
    Together,
    /// An extreme value that is reached at several times.
    Equal,
    /// A force that the law may divide between dependent contacts in any way.
    Shared,
    /// A step of a prescribed body that closes a contact without a slip: the place of the slider
    /// after it is not varied.
    Jump,
    /// A value at its limit, so that the changed motion follows another law on each side.
    Limit,
}

impl fmt::Display for Lost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reason = match self.cause {
            Cause::Touch => "only touches its limit",
            Cause::Together => "has an event together with another, and their order matters",
            Cause::Equal => "has its extreme value at several times",
            Cause::Shared => "shares its force with other contacts in a way that the law leaves open",
            Cause::Jump => "is closed by a step of a prescribed body, which has no derivative here",
            Cause::Limit => "is at its limit, so that derivatives differ on both sides",
        };
        write!(f, "no derivative from t = {} s on: {} {reason}", self.time, self.element)
    }
}
