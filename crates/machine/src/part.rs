//! Parts of elements, by index: the law sees parts, the user sees elements.

/// A part of an element, by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Index in [`System::springs`](crate::system::System::springs).
    Spring(usize),
    /// Index in [`System::stops`](crate::system::System::stops).
    Stop(usize),
    /// Index in [`System::frictions`](crate::system::System::frictions).
    Friction(usize),
    /// Index in [`System::branches`](crate::system::System::branches).
    Branch(usize),
    /// Index in [`System::loads`](crate::system::System::loads).
    Load(usize),
}
