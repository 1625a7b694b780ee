//! Path of the library that contains this code. The resources of an FMU are at a fixed location
//! relative to it.

#![allow(unsafe_code)] // the system is asked by its C functions
#![deny(unsafe_op_in_unsafe_fn)]

use std::path::PathBuf;

/// Path of the library or program that contains this code; `None` if the system does not provide
/// it.
pub fn own_path() -> Option<PathBuf> {
    of_address(own_path as *const () as usize)
}

/// Uses the table of the process's memory mappings (proc(5)), whose lines have the form `FROM-TO
/// PERMISSIONS OFFSET DEVICE INODE PATH`.
#[cfg(not(any(windows, target_vendor = "apple", target_family = "wasm")))]
fn of_address(address: usize) -> Option<PathBuf> {
    let maps = std::fs::read("/proc/self/maps").ok()?;
    maps.split(|byte| *byte == b'\n').find_map(|line| mapped_at(line, address))
}

/// The path of a line of that table, if the address lies in its range.
#[cfg(not(any(windows, target_vendor = "apple", target_family = "wasm")))]
fn mapped_at(line: &[u8], address: usize) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStrExt;
    let path = line.iter().position(|byte| *byte == b'/')?;
    let range = std::str::from_utf8(line.split(|byte| *byte == b' ').next()?).ok()?;
    let (from, to) = range.split_once('-')?;
    let bound = |text| usize::from_str_radix(text, 16).ok();
    let within = (bound(from)?..bound(to)?).contains(&address);
    within.then(|| PathBuf::from(std::ffi::OsStr::from_bytes(&line[path..])))
}

/// A WebAssembly module does not have a path.
#[cfg(target_family = "wasm")]
fn of_address(_address: usize) -> Option<PathBuf> {
    None
}

#[cfg(target_vendor = "apple")]
fn of_address(address: usize) -> Option<PathBuf> {
    use std::ffi::{CStr, OsStr};
    use std::os::unix::ffi::OsStrExt;
    let null = std::ptr::null_mut::<core::ffi::c_void>();
    let mut info =
        libc::Dl_info { dli_fname: null.cast(), dli_fbase: null, dli_sname: null.cast(), dli_saddr: null };
    // SAFETY: dladdr takes any address, and writes an `Info` to a variable of this type.
    let found = unsafe { libc::dladdr(address as *const core::ffi::c_void, &mut info) } != 0
        && !info.dli_fname.is_null();
    // SAFETY: if a library was found, `dli_fname` is a C string, valid until the library is
    // unloaded.
    found.then(|| PathBuf::from(OsStr::from_bytes(unsafe { CStr::from_ptr(info.dli_fname) }.to_bytes())))
}

#[cfg(windows)]
fn of_address(address: usize) -> Option<PathBuf> {
    use core::ffi::c_void;
    use std::ffi::OsString;
    use std::os::windows::ffi::OsStringExt;
    /// The argument is an address in the module, whose reference count does not change
    /// (`GET_MODULE_HANDLE_EX_FLAG_…`).
    const FROM_ADDRESS_UNCHANGED: u32 = 4 | 2;
    /// Length of the longest Windows path, in UTF-16 units.
    const LONGEST: usize = 1 << 15;
    #[link(name = "kernel32")]
    unsafe extern "system" {
        fn GetModuleHandleExW(flags: u32, address: *const c_void, module: *mut *mut c_void) -> i32;
        fn GetModuleFileNameW(module: *mut c_void, name: *mut u16, size: u32) -> u32;
    }
    let (mut module, mut name) = (std::ptr::null_mut(), vec![0u16; LONGEST]);
    // SAFETY: with this flag any address may be given; `module` and `name` have the type and size
    // that are passed.
    let length = unsafe {
        if GetModuleHandleExW(FROM_ADDRESS_UNCHANGED, address as *const c_void, &mut module) == 0 {
            return None;
        }
        GetModuleFileNameW(module, name.as_mut_ptr(), LONGEST as u32)
    };
    let length = length as usize;
    (length > 0 && length < LONGEST).then(|| PathBuf::from(OsString::from_wide(&name[..length])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_method_the_own_library_is_this_program() {
        assert_eq!(own_path(), std::env::current_exe().ok());
    }

    #[cfg(not(any(windows, target_vendor = "apple", target_family = "wasm")))]
    #[test]
    fn golden_lines_of_mapped_files() {
        let line = "7f00a000-7f00b000 r-xp 00000000 08:01 42   /tmp/a ü/lib 1.so".as_bytes();
        assert_eq!(mapped_at(line, 0x7f00_a000), Some(PathBuf::from("/tmp/a ü/lib 1.so")));
        assert_eq!(mapped_at(line, 0x7f00_b000), None);
        assert_eq!(mapped_at(b"7f00a000-7f00b000 rw-p 00000000 00:00 0", 0x7f00_a000), None);
        assert_eq!(mapped_at(b"x/y", 0), None);
    }
}
