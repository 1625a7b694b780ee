//! Kinds of status, log categories and log messages (FMI 2.0, 2.1.5, 2.2.4 and 4.2.3).

use super::description::LOG_CATEGORIES;
use super::problem::Problem;
use super::states::Function;
use super::types::Status;
use crate::component::log::{CATEGORIES, Categories, Category, Log};
use crate::component::{self, Outcome};
use crate::ffi::panics::guarded;
use std::ffi::CString;

/// `fmi2StatusKind` (FMI 2.0, 4.2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatusKind {
    /// Of an asynchronous step; there are none.
    DoStepStatus,
    /// Of an asynchronous step; there are none.
    PendingStatus,
    /// Time up to which the last step was computed.
    LastSuccessfulTime,
    /// Whether the instance wants to end the simulation; it never does.
    Terminated,
}

impl StatusKind {
    /// From the C enumeration.
    ///
    /// # Errors
    /// [`Problem::Value`](component::Problem::Value) for any other number.
    pub fn from_number(number: i32) -> Outcome<Self> {
        match number {
            0 => Ok(Self::DoStepStatus),
            1 => Ok(Self::PendingStatus),
            2 => Ok(Self::LastSuccessfulTime),
            3 => Ok(Self::Terminated),
            _ => Err(component::Problem::Value {
                name: "fmi2StatusKind",
                value: f64::from(number),
                allowed: "0 (fmi2DoStepStatus), 1 (fmi2PendingStatus), 2 (fmi2LastSuccessfulTime) or 3 (fmi2Terminated)",
            }),
        }
    }

    /// The answer to one who asks with the wrong function.
    pub fn not_available(self) -> Problem {
        Problem::StatusNotAvailable {
            what: match self {
                Self::DoStepStatus => "fmi2DoStepStatus is not available: steps are synchronous",
                Self::PendingStatus => "fmi2PendingStatus is not available: steps are synchronous",
                Self::LastSuccessfulTime => "fmi2LastSuccessfulTime is a Real: use fmi2GetRealStatus",
                Self::Terminated => "fmi2Terminated is a Boolean: use fmi2GetBooleanStatus",
            },
        }
    }
}

/// A category's name in the model description.
pub fn name(category: Category) -> &'static str {
    LOG_CATEGORIES[category as usize].name
}

/// The category of that name; `None` when there is none, and for `logAll`, which is the set of all.
fn category(name: &str) -> Option<Category> {
    CATEGORIES.into_iter().find(|category| self::name(*category) == name)
}

/// Which categories are enabled at instantiation: all when debug logging is on; else what a user should be shown in any
/// case (FMI 2.0, 2.1.3): warnings, errors and fatal errors.
pub fn enabled_at_start(logging_on: bool) -> Categories {
    if logging_on {
        return Categories::ALL;
    }
    let always = [Category::Warnings, Category::Refusals, Category::Failures];
    always.into_iter().fold(Categories::NONE, |set, category| set.with(category, true))
}

/// `fmi2SetDebugLogging` for one category (FMI 2.0, 2.1.5).
///
/// # Errors
/// [`Problem::Text`] when there is none of that name.
pub fn with_category(enabled: Categories, name: &str, on: bool) -> Result<Categories, Problem> {
    if name == "logAll" {
        return Ok(if on { Categories::ALL } else { Categories::NONE });
    }
    let category = category(name).ok_or_else(|| Problem::Text {
        argument: "category",
        value: name.to_owned(),
        allowed: LOG_CATEGORIES.map(|category| category.name).join(", "),
    })?;
    Ok(enabled.with(category, on))
}

/// Where log messages go.
pub trait Sink {
    /// Takes one finished message without trailing line break.
    fn send(&mut self, status: Status, category: Category, message: &str);
}

/// A log for one call of the component: messages that are enabled, with the function's name before warnings.
pub struct Logger<'a> {
    /// Where messages go.
    pub sink: &'a mut dyn Sink,
    /// Which of them.
    pub enabled: Categories,
    /// The call.
    pub function: Function,
}

impl Log for Logger<'_> {
    fn wants(&self, category: Category) -> bool {
        self.enabled.contains(category)
    }

    fn log(&mut self, category: Category, message: &str) {
        match category {
            Category::Events => self.sink.send(Status::of(category), category, message),
            _ => {
                let message = format!("{}: {message}", self.function.name());
                self.sink.send(Status::of(category), category, &message);
            }
        }
    }
}

/// A message as the host's logger takes it: the host formats it as printf does, with no arguments, and reads # as the
/// start of a variable reference (FMI 2.0, 2.1.5).
pub fn finished(message: &str) -> CString {
    c_text(&message.replace('%', "%%").replace('#', "##"))
}

/// Text as a C string; null bytes, which would end it, are replaced.
pub fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "?")).unwrap_or_default()
}

/// Logs a problem where its category is enabled and returns its status.
#[cold]
pub fn report(enabled: Categories, sink: &mut dyn Sink, function: Function, problem: &Problem) -> i32 {
    if enabled.contains(problem.category()) {
        // A second panic has nowhere to go but the status.
        let _ = guarded(|| {
            sink.send(problem.status(), problem.category(), &format!("{}: {problem}", function.name()));
        });
    }
    problem.status() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_names_of_the_categories() {
        let names = CATEGORIES.map(name);
        let standard =
            ["logEvents", "logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal"];
        assert_eq!(names, standard);
        assert_eq!(LOG_CATEGORIES.map(|c| c.name)[..5], standard);
        assert_eq!(LOG_CATEGORIES[5].name, "logAll");
    }

    #[test]
    fn invariant_categories_are_switched_one_by_one_and_all_at_once() {
        let quiet = enabled_at_start(false);
        assert!(quiet.contains(Category::Refusals) && !quiet.contains(Category::Events));
        let events = with_category(Categories::NONE, "logEvents", true).unwrap();
        assert!(events.contains(Category::Events) && !events.contains(Category::Refusals));
        assert_eq!(with_category(Categories::NONE, "logAll", true), Ok(Categories::ALL));
        assert!(with_category(quiet, "nonsense", true).is_err());
    }
}
