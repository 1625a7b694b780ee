//! Columns of a motion's derivatives: by a parameter, an initial state or the start time.

use crate::assembly::Assembly;
use crate::description::Description;
use crate::error::Error;
use crate::refusal::{Problem, Refusal};
use std::fmt;

/// A column of derivatives: a number with respect to which a motion is differentiated.
///
/// A text is the name of a parameter: `"stop.floor.gap".into()`.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum By {
    /// A number of the machine, by its name in
    /// [`Description::parameters`](crate::Description::parameters).
    Parameter(String),
    /// A number of the initial state, by its index: coordinates, then their rates, then states of
    /// first order. [`System::bodies_of`](crate::system::System::bodies_of) lists the bodies of
    /// the coordinates.
    Start(usize),
    /// The start time; the initial state stays the same.
    Time,
}

impl From<&str> for By {
    fn from(name: &str) -> Self {
        Self::Parameter(name.to_owned())
    }
}

impl From<String> for By {
    fn from(name: String) -> Self {
        Self::Parameter(name)
    }
}

impl fmt::Display for By {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Parameter(name) => f.write_str(name),
            Self::Start(place) => write!(f, "start[{place}]"),
            Self::Time => f.write_str("start.time"),
        }
    }
}

/// Whether motions have derivatives with respect to a parameter. They have none for the period of
/// a signal, nor for the sample times and delays of blocks.
///
///
/// ```
/// use vibro_machine::derivative::has_derivative;
/// use vibro_machine::file::{no_records, parse};
///
/// let text = r#"
///     name = "Knocked"
///     body.a = { mass = 1.0 }
///     load.knock = { on = "a", steps = [["0.1 s", "2 N"]], repeat = "1 s" }
/// "#;
/// let machine = parse(text, "knocked.toml", &no_records)?;
/// assert!(has_derivative(&machine, "body.a.mass"));
/// assert!(!has_derivative(&machine, "load.knock.repeat"));
/// # Ok::<(), vibro_machine::Refusal>(())
/// ```
pub fn has_derivative(d: &Description, name: &str) -> bool {
    let is_sampled = |name: &str| {
        name.starts_with("block.") && [".sample", ".delay"].iter().any(|end| name.ends_with(end))
    };
    let is_period = |name: &str| name.ends_with(".repeat") || is_sampled(name);
    !is_period(name) && !d.named.numbers_of(name).iter().any(|name| is_period(name))
}

impl By {
    /// Refuses a parameter or a place that the machine does not have.
    pub(super) fn check(&self, assembly: &Assembly) -> Result<(), Error> {
        let count = assembly.system.states();
        match self {
            Self::Parameter(name) => {
                let name = assembly.description.parameter(name)?.name;
                match has_derivative(&assembly.description, &name) {
                    true => Ok(()),
                    false => {
                        let text = "a motion has no derivative with respect to a period or a time \
                            between samples; use one of \
                            the machine's other numbers";
                        Err(Refusal::one(Problem::new(name, None, text)).into())
                    }
                }
            }
            Self::Start(place) if *place >= count => Err(Error::OutOfRange {
                name: "index of a start value".into(),
                value: *place as f64,
                allowed: format!("a whole number from 0 to {}", count - 1),
            }),
            Self::Start(_) | Self::Time => Ok(()),
        }
    }

    /// Returns the same column with the canonical name of its parameter.
    pub(super) fn by_usual_name(self, d: &Description) -> Result<Self, Error> {
        match self {
            Self::Parameter(name) => Ok(Self::Parameter(d.parameter(&name)?.name)),
            other => Ok(other),
        }
    }

    /// Returns the parameter's name; empty for other columns, which do not change the machine.
    pub(super) fn parameter(&self) -> &str {
        if let Self::Parameter(name) = self { name } else { "" }
    }
}
