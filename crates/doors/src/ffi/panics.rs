//! Panics at the C interface: caught, turned into a problem, and kept from printing.
//!
//! The default hook of std would write to the host's standard error and, with `RUST_BACKTRACE`
//! set, read the debug information of every loaded library. It also leaves a thread-local value
//! with a destructor behind, which pins the library in memory. The hook installed here ignores
//! panics inside a call from C and passes all others to the previous hook. The packaged library
//! has its own std, so no other panics occur there. A Rust program that links this crate keeps the
//! behaviour of its hook.

use super::Fault;
use std::any::Any;
use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::{Once, OnceLock};

thread_local! {
    // Constant and without destructor: registering one would pin the library.
    static CALLS: Cell<u32> = const { Cell::new(0) };
}

type Hook = Box<dyn Fn(&PanicHookInfo<'_>) + Sync + Send>;

// A static instead of a capture: neither hook then takes memory that would remain after unloading.
static PREVIOUS: OnceLock<Hook> = OnceLock::new();
static INSTALL: Once = Once::new();

/// Keeps panics inside [`guarded`] calls from being printed, once the first instance exists.
pub fn silence() {
    if std::thread::panicking() {
        return; // a hook cannot be changed now; a later instance will
    }
    INSTALL.call_once(|| {
        if PREVIOUS.set(panic::take_hook()).is_ok() {
            panic::set_hook(Box::new(hook));
        }
    });
}

fn hook(info: &PanicHookInfo<'_>) {
    if let (0, Some(previous)) = (CALLS.get(), PREVIOUS.get()) {
        previous(info);
    }
}

/// Runs `body`; a panic in it becomes a [`Fault::Panic`].
///
/// # Errors
/// [`Fault::Panic`] with the panic's message.
#[inline]
pub fn guarded<T>(body: impl FnOnce() -> T) -> Result<T, Fault> {
    CALLS.set(CALLS.get() + 1);
    let outcome = panic::catch_unwind(AssertUnwindSafe(body));
    CALLS.set(CALLS.get() - 1);
    outcome.map_err(|panic| Fault::Panic { what: text_of(&*panic) })
}

#[cold]
fn text_of(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "panic".to_owned())
}
