//! Columns of a motion's derivatives: by a parameter, an initial state or the start time.

use crate::assembly::Assembly;
use crate::description::Description;
use crate::error::Error;
use crate::refusal::{Problem, Refusal};
use crate::slots::EXPONENT;
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

/// Whether motions have derivatives with respect to a parameter. The period of a signal has none,
/// nor have the sample times and delays of blocks, nor an exponent.
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
    let has_none = |name: &str| name.ends_with(".repeat") || name.ends_with(EXPONENT) || is_sampled(name);
    !has_none(name) && !d.named.numbers_of(name).iter().any(|name| has_none(name))
}

impl By {
    /// Columns with the canonical names of their parameters, which their numbers have.
    ///
    /// # Errors
    /// [`Error::Refused`] for an unknown parameter or a period; [`Error::OutOfRange`] for an index
    /// of a start value that the machine does not have.
    pub(super) fn known(mut columns: Vec<Self>, assembly: &Assembly) -> Result<Vec<Self>, Error> {
        let (d, count) = (&assembly.description, assembly.system.states());
        let given: Vec<&str> = columns
            .iter()
            .filter_map(|by| if let Self::Parameter(name) = by { Some(name.as_str()) } else { None })
            .collect();
        let mut usual = d.usual_names(&given)?.into_iter();
        for by in &mut columns {
            match by {
                Self::Parameter(name) => {
                    *name = usual.next().unwrap_or_default();
                    if !has_derivative(d, name) {
                        let text = "a motion has no derivative with respect to a period, a time \
                            between samples or an exponent; use one of \
                            the machine's other numbers";
                        return Err(Refusal::one(Problem::new(&*name, None, text)).into());
                    }
                }
                Self::Start(place) if *place >= count => {
                    return Err(Error::OutOfRange {
                        name: "index of a start value".into(),
                        value: *place as f64,
                        allowed: format!("a whole number from 0 to {}", count - 1),
                    });
                }
                Self::Start(_) | Self::Time => {}
            }
        }
        Ok(columns)
    }

    /// Returns the parameter's name; empty for other columns, which do not change the machine.
    pub(super) fn parameter(&self) -> &str {
        if let Self::Parameter(name) = self { name } else { "" }
    }
}
