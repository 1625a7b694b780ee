//! A panic inside an FMI call prints nothing; all other panics still reach the program's own hook.
//! The test has its own process, because all code shares one hook.
#![allow(unsafe_code)] // the C interface

use std::ffi::CString;
use std::panic::{catch_unwind, set_hook};
use std::ptr::null;
use std::sync::atomic::{AtomicUsize, Ordering};
use vibro_paper_component::ffi::Fault;
use vibro_paper_component::ffi::panics::guarded;
use vibro_paper_component::fmi2::abi::{fmi2FreeInstance, fmi2Instantiate};
use vibro_paper_component::fmi2::description;

static SEEN: AtomicUsize = AtomicUsize::new(0);

#[test]
fn only_panics_of_others_reach_the_hook() {
    set_hook(Box::new(|_| {
        SEEN.fetch_add(1, Ordering::Relaxed);
    }));
    let guid = CString::new(description::guid()).unwrap();
    for _ in 0..2 {
        // SAFETY: valid strings, and the instance is freed once.
        unsafe {
            let c = fmi2Instantiate(c"quiet".as_ptr(), 1, guid.as_ptr(), null(), null(), 0, 0);
            assert!(!c.is_null());
            fmi2FreeInstance(c);
        }
        let caught = guarded(|| -> () { panic!("of {}", "ours") });
        assert_eq!(caught, Err(Fault::Panic { what: "of ours".to_owned() }));
    }
    assert_eq!(SEEN.load(Ordering::Relaxed), 0);
    catch_unwind(|| panic!("of the program")).unwrap_err();
    assert_eq!(SEEN.load(Ordering::Relaxed), 1);
}
