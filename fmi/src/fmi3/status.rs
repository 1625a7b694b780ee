//! Log categories and log messages (FMI 3.0.2, 2.3.1 and 2.4.5).

use super::description::LOG_CATEGORIES;
use super::problem::Problem;
use super::states::Function;
use super::types::Status;
use crate::component::log::{CATEGORIES, Categories, Category, Log};
use crate::ffi::panics::guarded;
use std::ffi::CString;

/// A category's name in the model description.
pub fn name(category: Category) -> &'static str {
    LOG_CATEGORIES[category as usize].name
}

/// The category of that name; `None` when there is none, and for `logAll`, which is the set of all.
fn category(name: &str) -> Option<Category> {
    CATEGORIES.into_iter().find(|category| self::name(*category) == name)
}

/// Whether errors are logged although the host has switched logging off. FMI 3.0.2, 2.3.1 forbids any call of the logger then;
/// the standard's main branch after it (pull request 2097) asks for messages about errors in any case.
const ERRORS_IN_ANY_CASE: bool = false;

/// Which categories are enabled at instantiation.
pub fn enabled_at_start(logging_on: bool) -> Categories {
    let always = [Category::Refusals, Category::Failures];
    match (logging_on, ERRORS_IN_ANY_CASE) {
        (true, _) => Categories::ALL,
        (false, true) => always.into_iter().fold(Categories::NONE, |set, category| set.with(category, true)),
        (false, false) => Categories::NONE,
    }
}

/// `fmi3SetDebugLogging` for one category (FMI 3.0.2, 2.3.1).
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

/// A message as the host's logger takes it: # starts the reference of a variable there, so it is doubled (FMI 3.0.2, 2.3.1).
pub fn finished(message: &str) -> CString {
    c_text(&message.replace('#', "##"))
}

/// Text as a C string; null bytes, which would end it, are replaced.
pub fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "?")).unwrap_or_default()
}

/// Logs a problem where its category is enabled and returns its status.
#[cold]
pub fn report(enabled: Categories, sink: &mut dyn Sink, function: Function, problem: &Problem) -> Status {
    let (status, category) = (problem.status(function), problem.category(function));
    if enabled.contains(category) {
        // A second panic has nowhere to go but the status.
        let _ = guarded(|| sink.send(status, category, &format!("{}: {problem}", function.name())));
    }
    status
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
        assert_eq!(quiet, Categories::NONE);
        let events = with_category(Categories::NONE, "logEvents", true).unwrap();
        assert!(events.contains(Category::Events) && !events.contains(Category::Refusals));
        assert_eq!(with_category(Categories::NONE, "logAll", true), Ok(Categories::ALL));
        assert!(with_category(quiet, "nonsense", true).is_err());
    }
}
