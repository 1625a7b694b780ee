//! Statuses and log categories (FMI 2.0, 2.1.3, 2.1.5 and 2.2.4).

use super::description::LOG_CATEGORIES;
use super::panics::guarded;
use super::problem::Problem;
use super::states::Function;
use std::ffi::CString;

/// `fmi2Status` (FMI 2.0, 2.1.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i32)]
pub enum Status {
    /// All well.
    Ok = 0,
    /// Worth knowing.
    Warning = 1,
    /// Not all of it could be done.
    Discard = 2,
    /// Refused; the instance is as it was.
    Error = 3,
    /// The instance can no longer be used.
    Fatal = 4,
}

/// Log categories, in the order of [`LOG_CATEGORIES`]; `logAll` is the set of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// Impact, rest, release.
    Events,
    /// Warnings.
    Warning,
    /// Discarded steps and statuses.
    Discard,
    /// Refused calls.
    Error,
    /// Panics.
    Fatal,
}

impl Category {
    /// Its name in the model description.
    pub fn name(self) -> &'static str {
        LOG_CATEGORIES[self as usize].name
    }
}

/// Where log messages go.
pub trait Log {
    /// Takes one finished message without trailing line break.
    fn log(&mut self, status: Status, category: Category, message: &str);
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
pub fn report(enabled: Enabled, log: &mut dyn Log, function: Function, problem: &Problem) -> i32 {
    if enabled.contains(problem.category()) {
        // A second panic has nowhere to go but the status.
        let _ = guarded(|| {
            log.log(problem.status(), problem.category(), &format!("{}: {problem}", function.name()));
        });
    }
    problem.status() as i32
}

/// Which categories are enabled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Enabled(u8);

const ALL: u8 = (1 << LOG_CATEGORIES.len()) - 1;

impl Enabled {
    /// At instantiation: everything when debug logging is on; else what a user should be shown in any case
    /// (FMI 2.0, 2.1.3): warnings, errors and fatal errors.
    pub fn at_start(logging_on: bool) -> Self {
        let always =
            [Category::Warning, Category::Error, Category::Fatal].iter().fold(0, |m, c| m | 1 << *c as u8);
        Self(if logging_on { ALL } else { always })
    }

    /// Whether a category is enabled.
    pub fn contains(self, category: Category) -> bool {
        self.0 & (1 << category as u8) != 0
    }

    /// `fmi2SetDebugLogging` without categories (FMI 2.0, 2.1.5).
    pub fn all(on: bool) -> Self {
        Self(if on { ALL } else { 0 })
    }

    /// `fmi2SetDebugLogging` for one category; `None` when there is none of that name.
    pub fn with(self, name: &str, on: bool) -> Option<Self> {
        let place = LOG_CATEGORIES.iter().position(|category| category.name == name)?;
        let bits = if name == "logAll" { ALL } else { 1 << place };
        Some(Self(if on { self.0 | bits } else { self.0 & !bits }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn categories_have_their_names() {
        assert_eq!(Category::Events.name(), "logEvents");
        assert_eq!(Category::Warning.name(), "logStatusWarning");
        assert_eq!(Category::Discard.name(), "logStatusDiscard");
        assert_eq!(Category::Error.name(), "logStatusError");
        assert_eq!(Category::Fatal.name(), "logStatusFatal");
    }

    #[test]
    fn categories_are_switched_one_by_one_and_all_at_once() {
        let quiet = Enabled::at_start(false);
        assert!(quiet.contains(Category::Error) && !quiet.contains(Category::Events));
        let events = Enabled::all(false).with("logEvents", true).unwrap();
        assert!(events.contains(Category::Events) && !events.contains(Category::Error));
        assert_eq!(Enabled::all(false).with("logAll", true), Some(Enabled::all(true)));
        assert_eq!(quiet.with("nonsense", true), None);
    }
}
