//! What FMI 3.0 alone says of log messages (FMI 3.0.2, 2.3.1).

use crate::log::Categories;
use crate::messages::c_text;
use std::ffi::CString;

/// Which categories are enabled at instantiation. Where the host has switched logging off, none,
/// not even of errors: FMI 3.0.2, 2.3.1 forbids any call of the logger then; the standard's main
/// branch after it (pull request 2097) asks for messages about errors in any case.
pub fn enabled_at_start(logging_on: bool) -> Categories {
    if logging_on { Categories::ALL } else { Categories::NONE }
}

/// A message as the host's logger takes it: # starts the reference of a variable there, so it is
/// doubled (FMI 3.0.2, 2.3.1).
pub fn finished(message: &str) -> CString {
    c_text(&message.replace('#', "##"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_nothing_is_enabled_at_start_where_logging_is_off() {
        assert_eq!(enabled_at_start(false), Categories::NONE);
        assert_eq!(enabled_at_start(true), Categories::ALL);
    }
}
