//! Statuses, log categories and messages that are common to FMI 2.0 and 3.0, for both doors.

use crate::ffi::Fault;
use crate::ffi::panics::guarded;
use crate::log::{self, CATEGORIES, Categories, Log};
use std::ffi::CString;
use std::fmt::Display;

/// The status of a call, with the numbers of `fmi2Status` (FMI 2.0, 2.1.3) and `fmi3Status` (FMI
/// 3.0.2, 2.2.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Status {
    /// No problem.
    Ok = 0,
    /// Done, with a warning.
    Warning = 1,
    /// FMI 2.0: the call was carried out in part, or a value is not available. FMI 3.0: the call
    /// was not carried out; the instance is unchanged, and the simulation may continue.
    Discard = 2,
    /// Refused. FMI 2.0: the instance is unchanged. FMI 3.0: it is
    /// [Terminated](crate::fmi3::states::Stage::Terminated).
    Error = 3,
    /// The instance can no longer be used.
    Fatal = 4,
}

impl Status {
    /// The status with which a message of a category is logged.
    pub fn of(category: log::Category) -> Self {
        match category {
            log::Category::Events => Self::Ok,
            log::Category::Warnings => Self::Warning,
            log::Category::Incomplete => Self::Discard,
            log::Category::Refusals => Self::Error,
            log::Category::Failures => Self::Fatal,
        }
    }

    /// The log category of a problem with this status.
    pub fn category(self) -> log::Category {
        match self {
            Self::Discard => log::Category::Incomplete,
            Self::Fatal => log::Category::Failures,
            _ => log::Category::Refusals,
        }
    }
}

/// A log category as a model description declares it (FMI 2.0, 2.2.4; FMI 3.0.2, 2.4.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Category {
    /// Name.
    pub name: &'static str,
    /// Messages that belong to the category.
    pub description: &'static str,
}

/// The log categories, all with standard names: the component's categories in their order, then
/// the set of all. `events` describes the logged events of the component; `discard` describes the
/// status Discard, whose meaning differs between the versions.
pub const fn log_categories(events: &'static str, discard: &'static str) -> [Category; 6] {
    [
        Category { name: "logEvents", description: events },
        Category {
            name: "logStatusWarning",
            description: "Things worth knowing that do not stop the simulation",
        },
        Category { name: "logStatusDiscard", description: discard },
        Category { name: "logStatusError", description: "Why a call was refused" },
        Category { name: "logStatusFatal", description: "Why the instance can no longer be used" },
        Category { name: ALL, description: "All of the above" },
    ]
}

/// The set of all categories.
const ALL: &str = "logAll";

/// A category's name in the model description.
pub fn name(category: log::Category) -> &'static str {
    log_categories("", "")[category as usize].name
}

/// `fmi2SetDebugLogging` and `fmi3SetDebugLogging` for one category (FMI 2.0, 2.1.5; FMI 3.0.2,
/// 2.3.1).
///
/// # Errors
/// [`Fault::Text`] if no category has the name.
pub fn with_category(enabled: Categories, name: &str, on: bool) -> Result<Categories, Fault> {
    if name == ALL {
        return Ok(if on { Categories::ALL } else { Categories::NONE });
    }
    let category = CATEGORIES.into_iter().find(|category| self::name(*category) == name);
    let category = category.ok_or_else(|| Fault::Text {
        argument: "category",
        value: name.to_owned(),
        allowed: format!("one of {}", log_categories("", "").map(|category| category.name).join(", ")),
    })?;
    Ok(enabled.with(category, on))
}

/// Destination of log messages.
pub trait Sink {
    /// Takes one finished message without trailing line break.
    fn send(&mut self, status: Status, category: log::Category, message: &str);
}

/// A log for one call of the component. It puts the function's name before all messages except
/// events. A caller asks `wants` first: `log` passes on any message.
pub struct Logger<'a> {
    /// Destination of messages.
    pub sink: &'a mut dyn Sink,
    /// Enabled categories.
    pub enabled: Categories,
    /// The C name of the called function.
    pub function: &'static str,
}

impl Log for Logger<'_> {
    fn wants(&self, category: log::Category) -> bool {
        self.enabled.contains(category)
    }

    fn log(&mut self, category: log::Category, message: &str) {
        match category {
            log::Category::Events => self.sink.send(Status::of(category), category, message),
            _ => {
                let message = format!("{}: {message}", self.function);
                self.sink.send(Status::of(category), category, &message);
            }
        }
    }
}

/// Text as a C string; null bytes, which would end it, are replaced.
pub fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "?")).unwrap_or_default()
}

/// Logs the reason why a call of `function` was refused, if the category of its status is enabled.
#[cold]
pub fn report(
    enabled: Categories,
    sink: &mut dyn Sink,
    function: &str,
    status: Status,
    problem: &dyn Display,
) {
    let category = status.category();
    if enabled.contains(category) {
        // A second panic is reported by the status only.
        let _ = guarded(|| sink.send(status, category, &format!("{function}: {problem}")));
    }
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
        let declared = log_categories("", "").map(|category| category.name);
        assert_eq!(declared[..5], standard);
        assert_eq!(declared[5], "logAll");
    }

    #[test]
    fn invariant_categories_are_switched_one_by_one_and_all_at_once() {
        let events = with_category(Categories::NONE, "logEvents", true).unwrap();
        assert!(events.contains(log::Category::Events) && !events.contains(log::Category::Refusals));
        assert_eq!(with_category(Categories::NONE, "logAll", true), Ok(Categories::ALL));
        assert_eq!(with_category(Categories::ALL, "logAll", false), Ok(Categories::NONE));
        let unknown = with_category(Categories::NONE, "nonsense", true).unwrap_err().to_string();
        assert!(unknown.contains("category = \"nonsense\": expected one of logEvents, "), "{unknown}");
    }
}
