//! Rules for log messages that only FMI 3.0 has (FMI 3.0.2, 2.3.1).

use crate::log::Categories;
use crate::messages::c_text;
use std::ffi::CString;

/// Categories enabled at instantiation. If the host has switched logging off, none is enabled, not
/// even errors: FMI 3.0.2, 2.3.1 then forbids any call of the logger. The later main branch of the
/// standard (pull request 2097) requires messages about errors in every case.
pub fn enabled_at_start(logging_on: bool) -> Categories {
    if logging_on { Categories::ALL } else { Categories::NONE }
}

/// A message in the format of the host's logger. The logger reads # as the start of a variable's
/// reference, so each # is doubled (FMI 3.0.2, 2.3.1).
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
