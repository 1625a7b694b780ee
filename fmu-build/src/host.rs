//! A small host of FMI 2.0, and of FMI 3.0 in [`fmi3`]: loads the packaged binary and calls it
//! through its C ABI, as any importing tool does.
//!
//! The host's files are the only ones of this crate with `unsafe`, since the functions of a shared
//! library cannot be called in another way.
#![allow(unsafe_code)]

pub mod fmi3;
mod log;

use crate::error::Result;
use libloading::Library;
use log::Log;
use std::ffi::{CStr, CString, c_char, c_double, c_int, c_uint, c_void};
use std::path::Path;

type Component = *mut c_void;
type Environment = *const Log;
type Logger = unsafe extern "C" fn(Environment, *const c_char, c_int, *const c_char, *const c_char);

/// `fmi2CallbackFunctions` (FMI 2.0, 2.1.5). The logger is variadic in C. On every ABI of our
/// platforms, a function with only the fixed arguments is called in the same way; the variadic
/// arguments are not needed.
#[repr(C)]
struct Callbacks {
    logger: Option<Logger>,
    allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    step_finished: Option<unsafe extern "C" fn(Environment, c_int)>,
    environment: Environment,
}

type Instantiate = unsafe extern "C" fn(
    *const c_char,
    c_int,
    *const c_char,
    *const c_char,
    *const Callbacks,
    c_int,
    c_int,
) -> Component;
type Plain = unsafe extern "C" fn(Component) -> c_int;

/// The functions that this host calls, copied from the library, which [`Binary`] keeps loaded.
#[derive(Clone, Copy)]
struct Functions {
    instantiate: Instantiate,
    free_instance: unsafe extern "C" fn(Component),
    setup_experiment: unsafe extern "C" fn(Component, c_int, c_double, c_double, c_int, c_double) -> c_int,
    enter_initialization: Plain,
    exit_initialization: Plain,
    terminate: Plain,
    do_step: unsafe extern "C" fn(Component, c_double, c_double, c_int) -> c_int,
    get_real: unsafe extern "C" fn(Component, *const c_uint, usize, *mut c_double) -> c_int,
    set_real: unsafe extern "C" fn(Component, *const c_uint, usize, *const c_double) -> c_int,
    get_integer: unsafe extern "C" fn(Component, *const c_uint, usize, *mut c_int) -> c_int,
    get_version: unsafe extern "C" fn() -> *const c_char,
}

/// Loads a shared library and resolves all its undefined symbols at once. A missing symbol is then
/// an error here, and not a crash at its first call.
///
/// # Safety
/// As [`Library::new`].
unsafe fn open(path: &Path) -> std::result::Result<Library, libloading::Error> {
    #[cfg(unix)]
    {
        use libloading::os::unix::{self, RTLD_LOCAL, RTLD_NOW};
        // SAFETY: as the caller ensures.
        unsafe { unix::Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) }.map(Library::from)
    }
    // SAFETY: as the caller ensures; Windows resolves all symbols.
    #[cfg(not(unix))]
    unsafe {
        Library::new(path)
    }
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
                // SAFETY: the field's type is the C prototype of this function in FMI 2.0, which
                // the library exports.
                *unsafe { library.get(concat!($name, "\0")) }?
            };
        }
        let functions = Functions {
            instantiate: function!("fmi2Instantiate"),
            free_instance: function!("fmi2FreeInstance"),
            setup_experiment: function!("fmi2SetupExperiment"),
            enter_initialization: function!("fmi2EnterInitializationMode"),
            exit_initialization: function!("fmi2ExitInitializationMode"),
            terminate: function!("fmi2Terminate"),
            do_step: function!("fmi2DoStep"),
            get_real: function!("fmi2GetReal"),
            set_real: function!("fmi2SetReal"),
            get_integer: function!("fmi2GetInteger"),
            get_version: function!("fmi2GetVersion"),
        };
        Ok(Self { functions, _library: library })
    }

    /// `fmi2GetVersion`.
    pub fn version(&self) -> String {
        // SAFETY: the function takes nothing and returns a constant C string (FMI 2.0, 2.1.4).
        unsafe { CStr::from_ptr((self.functions.get_version)()) }.to_string_lossy().into_owned()
    }

    /// `fmi2Instantiate` for co-simulation.
    ///
    /// # Errors
    /// [`Error::Call`](crate::Error::Call) with the FMU's log if it returns null.
    pub fn instantiate(&self, guid: &str) -> Result<Fmi2Instance<'_>> {
        let log = Box::new(Log::default());
        let callbacks = Box::new(Callbacks {
            logger: Some(logger),
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            environment: &raw const *log,
        });
        let guid = CString::new(guid).unwrap_or_default();
        const CO_SIMULATION: c_int = 1;
        // SAFETY: all pointers are valid for the call; callbacks and log live in boxes while the
        // instance lives.
        let component = unsafe {
            let (resources, name) = (c"".as_ptr(), c"fmu-build".as_ptr());
            (self.functions.instantiate)(
                name,
                CO_SIMULATION,
                guid.as_ptr(),
                resources,
                &raw const *callbacks,
                0,
                0,
            )
        };
        let instance =
            Fmi2Instance { functions: self.functions, component, log, _callbacks: callbacks, _binary: self };
        if component.is_null() {
            return Err(instance.log.failure("fmi2Instantiate", "null"));
        }
        Ok(instance)
    }
}

/// Receives one message of an instance's log.
unsafe extern "C" fn logger(
    log: Environment,
    _instance: *const c_char,
    _status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is the log passed to fmi2Instantiate, which outlives the instance;
    // the others are C strings (FMI 2.0, 2.1.5).
    unsafe { Log::take(log, category, message) }
}

/// An instance of the FMU; freed when dropped.
pub struct Fmi2Instance<'a> {
    functions: Functions,
    component: Component,
    log: Box<Log>,
    _callbacks: Box<Callbacks>, // the FMU keeps a pointer to them
    _binary: &'a Binary,
}

impl Fmi2Instance<'_> {
    /// `fmi2SetupExperiment`, `fmi2EnterInitializationMode`, `fmi2ExitInitializationMode`.
    ///
    /// # Errors
    /// [`Error::Call`](crate::Error::Call).
    pub fn initialize(&mut self, start: f64) -> Result<()> {
        let (f, c) = (self.functions, self.component);
        // SAFETY (all three): the component is live and not null.
        self.log.check("fmi2SetupExperiment", unsafe { (f.setup_experiment)(c, 0, 0.0, start, 0, 0.0) })?;
        self.log.check("fmi2EnterInitializationMode", unsafe { (f.enter_initialization)(c) })?;
        self.log.check("fmi2ExitInitializationMode", unsafe { (f.exit_initialization)(c) })
    }

    /// `fmi2DoStep`.
    ///
    /// # Errors
    /// [`Error::Call`](crate::Error::Call).
    pub fn step(&mut self, from: f64, size: f64) -> Result<()> {
        // SAFETY: the component is live and not null.
        self.log.check("fmi2DoStep", unsafe { (self.functions.do_step)(self.component, from, size, 1) })
    }

    /// `fmi2GetReal`.
    ///
    /// # Errors
    /// [`Error::Call`](crate::Error::Call).
    pub fn real<const N: usize>(&self, references: &[u32; N]) -> Result<[f64; N]> {
        let mut values = [0.0; N];
        let (from, to) = (references.as_ptr(), values.as_mut_ptr());
        // SAFETY: both arrays have N elements.
        self.log.check("fmi2GetReal", unsafe { (self.functions.get_real)(self.component, from, N, to) })?;
        Ok(values)
    }

    /// `fmi2SetReal`.
    ///
    /// # Errors
    /// [`Error::Call`](crate::Error::Call).
    pub fn set_real<const N: usize>(&mut self, references: &[u32; N], values: &[f64; N]) -> Result<()> {
        let (to, from) = (references.as_ptr(), values.as_ptr());
        // SAFETY: both arrays have N elements.
        self.log.check("fmi2SetReal", unsafe { (self.functions.set_real)(self.component, to, N, from) })
    }

    /// `fmi2GetInteger`.
    ///
    /// # Errors
    /// [`Error::Call`](crate::Error::Call).
    pub fn integer<const N: usize>(&self, references: &[u32; N]) -> Result<[i32; N]> {
        let mut values = [0; N];
        let (from, to) = (references.as_ptr(), values.as_mut_ptr());
        // SAFETY: both arrays have N elements.
        self.log
            .check("fmi2GetInteger", unsafe { (self.functions.get_integer)(self.component, from, N, to) })?;
        Ok(values)
    }

    /// `fmi2Terminate`.
    ///
    /// # Errors
    /// [`Error::Call`](crate::Error::Call).
    pub fn terminate(&mut self) -> Result<()> {
        // SAFETY: the component is live and not null.
        self.log.check("fmi2Terminate", unsafe { (self.functions.terminate)(self.component) })
    }
}

impl Drop for Fmi2Instance<'_> {
    fn drop(&mut self) {
        if !self.component.is_null() {
            // SAFETY: the component is live and is not used again.
            unsafe { (self.functions.free_instance)(self.component) };
        }
    }
}
