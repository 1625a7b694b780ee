//! Kinds of arguments of the exported functions: their C types and conversion to safe types. Only
//! the library that exports a component expands these macros.

/// C type of an argument of this kind.
#[doc(hidden)]
#[macro_export]
#[rustfmt::skip]
macro_rules! __c_type {
    (flag $type:ty) => { $type };
    (value $type:ty) => { $type };
    (array $type:ty) => { *const $type };
    (states $type:ty) => { *const $type };
    (out $type:ty) => { *mut $type };
    (texts) => { *const *const ::core::ffi::c_char };
    (state) => { *mut ::core::ffi::c_void };
    (handle) => { *mut *mut ::core::ffi::c_void };
}

/// An argument of this kind in safe types, for use where `?` is allowed. The first argument is the
/// instance on which the function is called.
#[doc(hidden)]
#[macro_export]
#[rustfmt::skip]
macro_rules! __checked {
    ($instance:ident flag $name:ident) => { $name != 0 };
    ($instance:ident value $name:ident) => { $name };
    ($instance:ident state $name:ident) => { $name.addr() };
    // SAFETY (all below): null or valid for that count, as the exported function's caller ensures.
    ($instance:ident array $name:ident $count:expr) => {
        unsafe { $crate::ffi::pointers::array($name, $count, (stringify!($name), $instance.max_count())) }?
    };
    ($instance:ident states $name:ident $count:expr) => {
        unsafe {
            $crate::ffi::pointers::vector(
                $name, $count, $instance.number_of_states(), (stringify!($name), stringify!($count)),
            )
        }?
    };
    ($instance:ident out $name:ident $count:expr) => {
        unsafe { $crate::ffi::pointers::out($name, $count, (stringify!($name), $instance.max_count())) }?
    };
    ($instance:ident handle $name:ident) => {
        unsafe { $crate::ffi::pointers::handle($name, stringify!($name)) }?
    };
    ($instance:ident texts $name:ident $count:expr) => {
        unsafe { $crate::ffi::pointers::array($name, $count, (stringify!($name), $instance.max_count())) }?
            .iter()
            .map(|name| Ok(unsafe { $crate::ffi::pointers::c_str(*name, "category") }?.to_string_lossy()))
    };
}
