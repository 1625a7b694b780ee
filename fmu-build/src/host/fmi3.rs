//! A small host of FMI 3.0: loads the packaged binary and runs Co-Simulation, without Event Mode
//! and early return.

use super::log::Log;
use super::open;
use crate::error::Result;
use libloading::Library;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::null;

type Handle = *mut c_void;
type Logger = unsafe extern "C" fn(*const Log, c_int, *const c_char, *const c_char);

type Instantiate = unsafe extern "C" fn(
    *const c_char,
    *const c_char,
    *const c_char,
    bool,
    bool,
    bool,
    bool,
    *const u32,
    usize,
    *const Log,
    Option<Logger>,
    *const c_void,
) -> Handle;
type Plain = unsafe extern "C" fn(Handle) -> c_int;
type DoStep =
    unsafe extern "C" fn(Handle, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int;

/// The functions that this host calls, copied from the library, which [`Binary`] keeps loaded.
#[derive(Clone, Copy)]
struct Functions {
    instantiate: Instantiate,
    free_instance: unsafe extern "C" fn(Handle),
    enter_initialization: unsafe extern "C" fn(Handle, bool, f64, f64, bool, f64) -> c_int,
    exit_initialization: Plain,
    terminate: Plain,
    do_step: DoStep,
    get_float64: unsafe extern "C" fn(Handle, *const u32, usize, *mut f64, usize) -> c_int,
    get_int32: unsafe extern "C" fn(Handle, *const u32, usize, *mut i32, usize) -> c_int,
    get_version: unsafe extern "C" fn() -> *const c_char,
}

/// A loaded binary.
pub struct Binary {
    functions: Functions,
    _library: Library, // keeps the functions' code in memory
}

impl Binary {
    /// Loads the shared library.
    ///
    /// # Errors
    /// [`Error::Load`](crate::Error::Load) if it cannot be loaded or lacks a function.
    pub fn load(path: &Path) -> Result<Self> {
        // SAFETY: loading runs the library's initializers; it is our own Rust cdylib, which has
        // none of its own.
        let library = unsafe { open(path) }?;
        macro_rules! function {
            ($name:literal) => {
                // SAFETY: the field's type is the C prototype of this function in FMI 3.0.2, which
                // the library exports.
                *unsafe { library.get(concat!($name, "\0")) }?
            };
        }
        let functions = Functions {
            instantiate: function!("fmi3InstantiateCoSimulation"),
            free_instance: function!("fmi3FreeInstance"),
            enter_initialization: function!("fmi3EnterInitializationMode"),
            exit_initialization: function!("fmi3ExitInitializationMode"),
            terminate: function!("fmi3Terminate"),
            do_step: function!("fmi3DoStep"),
            get_float64: function!("fmi3GetFloat64"),
            get_int32: function!("fmi3GetInt32"),
            get_version: function!("fmi3GetVersion"),
        };
        Ok(Self { functions, _library: library })
    }

    /// `fmi3GetVersion`.
    pub fn version(&self) -> String {
        // SAFETY: the function takes nothing and returns a constant C string (FMI 3.0.2, 2.2.5).
        unsafe { CStr::from_ptr((self.functions.get_version)()) }.to_string_lossy().into_owned()
    }

    /// `fmi3InstantiateCoSimulation`, with neither event mode nor early return.
    ///
    /// # Errors
    /// [`Error::Call`](crate::Error::Call) with the FMU's log if it returns null.
    pub fn instantiate(&self, token: &str) -> Result<Fmi3Instance<'_>> {
        let log = Box::new(Log::default());
        let token = CString::new(token).unwrap_or_default();
        let (name, resources) = (c"fmu-build".as_ptr(), c"".as_ptr());
        let environment = &raw const *log;
        // SAFETY: all pointers are valid for the call; the log lives in a box while the instance
        // lives.
        let handle = unsafe {
            let instantiate = self.functions.instantiate;
            let logger: Option<Logger> = Some(logger);
            instantiate(
                name,
                token.as_ptr(),
                resources,
                false,
                true,
                false,
                false,
                null(),
                0,
                environment,
                logger,
                null(),
            )
        };
        let instance = Fmi3Instance { functions: self.functions, handle, log, _binary: self };
        if handle.is_null() {
            return Err(instance.log.failure("fmi3InstantiateCoSimulation", "null"));
        }
        Ok(instance)
    }
}

/// Receives a log message of an instance.
unsafe extern "C" fn logger(
    log: *const Log,
    _status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is the log passed at instantiation, which outlives the instance; the
    // others are C strings (FMI 3.0.2, 2.3.1).
    unsafe { Log::take(log, category, message) }
}

/// An instance of the FMU; freed when dropped.
pub struct Fmi3Instance<'a> {
    functions: Functions,
    handle: Handle,
    log: Box<Log>,
    _binary: &'a Binary,
}

impl Fmi3Instance<'_> {
    /// `fmi3EnterInitializationMode`, `fmi3ExitInitializationMode`.
    ///
    /// # Errors
    /// [`Error::Call`](crate::Error::Call).
    pub fn initialize(&mut self, start: f64) -> Result<()> {
        let (f, i) = (self.functions, self.handle);
        // SAFETY (both): the instance is live and not null.
        let entered = unsafe { (f.enter_initialization)(i, false, 0.0, start, false, 0.0) };
        self.log.check("fmi3EnterInitializationMode", entered)?;
        self.log.check("fmi3ExitInitializationMode", unsafe { (f.exit_initialization)(i) })
    }

    /// `fmi3DoStep`.
    ///
    /// # Errors
    /// [`Error::Call`](crate::Error::Call).
    pub fn step(&mut self, from: f64, size: f64) -> Result<()> {
        let (mut event, mut terminate, mut early, mut reached) = (false, false, false, 0.0);
        // SAFETY: the instance is live and not null, and the places for the results are valid.
        let status = unsafe {
            (self.functions.do_step)(
                self.handle,
                from,
                size,
                true,
                &raw mut event,
                &raw mut terminate,
                &raw mut early,
                &raw mut reached,
            )
        };
        self.log.check("fmi3DoStep", status)
    }

    /// `fmi3GetFloat64` of scalars.
    ///
    /// # Errors
    /// [`Error::Call`](crate::Error::Call).
    pub fn real<const N: usize>(&self, references: &[u32; N]) -> Result<[f64; N]> {
        let mut values = [0.0; N];
        let (from, to) = (references.as_ptr(), values.as_mut_ptr());
        // SAFETY: both arrays have N elements.
        self.log
            .check("fmi3GetFloat64", unsafe { (self.functions.get_float64)(self.handle, from, N, to, N) })?;
        Ok(values)
    }

    /// `fmi3GetInt32` of scalars.
    ///
    /// # Errors
    /// [`Error::Call`](crate::Error::Call).
    pub fn integer<const N: usize>(&self, references: &[u32; N]) -> Result<[i32; N]> {
        let mut values = [0; N];
        let (from, to) = (references.as_ptr(), values.as_mut_ptr());
        // SAFETY: both arrays have N elements.
        self.log.check("fmi3GetInt32", unsafe { (self.functions.get_int32)(self.handle, from, N, to, N) })?;
        Ok(values)
    }

    /// `fmi3Terminate`.
    ///
    /// # Errors
    /// [`Error::Call`](crate::Error::Call).
    pub fn terminate(&mut self) -> Result<()> {
        // SAFETY: the instance is live and not null.
        self.log.check("fmi3Terminate", unsafe { (self.functions.terminate)(self.handle) })
    }
}

impl Drop for Fmi3Instance<'_> {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: the instance is live and is not used again.
            unsafe { (self.functions.free_instance)(self.handle) };
        }
    }
}
