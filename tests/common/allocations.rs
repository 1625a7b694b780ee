//! A counting allocator, for tests in separate processes.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    /// Allocations of the test's own thread, since the harness allocates in other threads.
    pub static COUNT: Cell<usize> = const { Cell::new(0) };
    /// Bytes of these allocations.
    #[allow(dead_code)] // used by some of the tests
    pub static BYTES: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: passes every call to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        BYTES.set(BYTES.get() + layout.size());
        // SAFETY: as the caller vouches.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller vouches.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;
