//! Parts that every C interface needs: pointers that are checked before they are followed, panics
//! that do not leave the library, and handles that are searched, not followed. Nothing here
//! depends on FMI or a component.

mod arguments;
pub mod handles;
pub mod library;
pub mod panics;
pub mod pointers;

/// Reason why an argument was refused, or a panic inside the library.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// A pointer that is null, or misaligned for its type.
    #[error("{argument} is null or misaligned: expected a valid pointer")]
    Pointer {
        /// The argument.
        argument: &'static str,
    },
    /// A count that is not possible.
    #[error("{argument} = {value}: expected {allowed}")]
    Count {
        /// The argument.
        argument: &'static str,
        /// Its value.
        value: usize,
        /// The valid values.
        allowed: String,
    },
    /// A text that is not valid.
    #[error("{argument} = \"{value}\": expected {allowed}")]
    Text {
        /// The argument.
        argument: &'static str,
        /// Its value.
        value: String,
        /// The valid texts.
        allowed: String,
    },
    /// A handle that the library has not returned, or has freed.
    #[error("the pointer is not one this instance has given out, or it was freed")]
    Handle,
    /// A panic inside the library.
    #[error("internal error: {what}; the instance can no longer be used")]
    Panic {
        /// The panic's message.
        what: String,
    },
}
