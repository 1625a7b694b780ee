//! A host of FMI 2.0 in a few lines.

// Each test program uses only a part of this module.
#![allow(dead_code, missing_docs)]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};
use vibro_paper_component::component::variables::{Base, find, reference};
use vibro_paper_component::fmi2::abi::*;
use vibro_paper_component::fmi2::description;

pub const OK: c_int = 0;
pub const WARNING: c_int = 1;
pub const ERROR: c_int = 3;

pub const MOTION: [&str; 6] = ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"];

pub type Record = (c_int, String, String);

unsafe extern "C" fn keep(
    environment: *mut c_void,
    _: *const c_char,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is the host's list; the FMU passes C strings.
    unsafe {
        let text = |p| CStr::from_ptr(p).to_str().unwrap().to_owned();
        (*environment.cast::<Vec<Record>>()).push((status, text(category), text(message)));
    }
}

type Plain = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char);

pub struct Fmu2 {
    pub c: FmiComponent,
    log: *mut Vec<Record>,
}

impl Fmu2 {
    /// An instance of a `fmi2Type`, without a logger.
    pub fn quiet(kind: c_int) -> Self {
        Self::new(kind, None, false)
    }

    /// A Co-Simulation instance with all messages in the log.
    pub fn logged() -> Self {
        // SAFETY: on the platforms of the tests, a variadic call without variadic arguments is an
        // ordinary call.
        let logger = unsafe { std::mem::transmute::<Plain, FmiLogger>(keep) };
        Self::new(1, Some(logger), true)
    }

    pub fn new(kind: c_int, logger: Option<FmiLogger>, logging: bool) -> Self {
        let guid = CString::new(description::guid()).unwrap();
        let log = Box::into_raw(Box::new(Vec::<Record>::new()));
        let functions = FmiCallbackFunctions {
            logger,
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: log.cast(),
        };
        // SAFETY: valid strings; the callbacks may be freed after the call, the logger and its
        // environment remain.
        let c = unsafe {
            fmi2Instantiate(c"box".as_ptr(), kind, guid.as_ptr(), null(), &functions, 0, logging.into())
        };
        assert!(!c.is_null());
        Self { c, log }
    }

    /// A Co-Simulation instance without a logger, ready for the first step.
    pub fn started(start: &[(&str, f64)]) -> Self {
        Self::quiet(1).start(start)
    }

    /// Sets start values and initializes.
    pub fn start(self, start: &[(&str, f64)]) -> Self {
        self.set_all(start);
        self.initialize();
        self
    }

    pub fn initialize(&self) {
        // SAFETY: a live component. Undefined values are not read.
        unsafe {
            assert_eq!(fmi2SetupExperiment(self.c, 0, f64::NAN, 0.0, 0, -1.0), OK);
            assert_eq!(fmi2EnterInitializationMode(self.c), OK);
            assert_eq!(fmi2ExitInitializationMode(self.c), OK);
        }
    }

    pub fn log(&self) -> &[Record] {
        // SAFETY: freed with the host; the logger does not run now.
        unsafe { &*self.log }
    }

    pub fn set(&self, name: &str, value: f64) {
        let r = reference(name);
        // SAFETY: one reference and one value each.
        let status = unsafe {
            match find(name).unwrap().base() {
                Base::Real => fmi2SetReal(self.c, &r, 1, &value),
                Base::Boolean => fmi2SetBoolean(self.c, &r, 1, &(value as c_int)),
                _ => fmi2SetInteger(self.c, &r, 1, &(value as c_int)),
            }
        };
        assert_eq!(status, OK, "{name} = {value}");
    }

    pub fn set_all(&self, values: &[(&str, f64)]) {
        values.iter().for_each(|(name, value)| self.set(name, *value));
    }

    pub fn get(&self, r: u32, base: Base) -> f64 {
        let (mut real, mut whole) = (f64::NAN, -1);
        // SAFETY: one reference and one value each.
        let status = unsafe {
            match base {
                Base::Real => fmi2GetReal(self.c, &r, 1, &mut real),
                Base::Boolean => fmi2GetBoolean(self.c, &r, 1, &mut whole),
                _ => fmi2GetInteger(self.c, &r, 1, &mut whole),
            }
        };
        assert_eq!(status, OK, "{r}");
        if base == Base::Real { real } else { whole.into() }
    }

    pub fn motion(&self) -> [f64; 6] {
        let (references, mut values) = (MOTION.map(reference), [f64::NAN; 6]);
        // SAFETY: six of each.
        assert_eq!(unsafe { fmi2GetReal(self.c, references.as_ptr(), 6, values.as_mut_ptr()) }, OK);
        values
    }

    pub fn time(&self) -> f64 {
        self.get(reference("time"), Base::Real)
    }

    pub fn try_step(&self, point: f64, size: f64) -> c_int {
        // SAFETY: a live component.
        unsafe { fmi2DoStep(self.c, point, size, 1) }
    }

    pub fn step(&self, point: f64, size: f64) {
        assert_eq!(self.try_step(point, size), OK);
    }

    pub fn bytes(&self) -> Vec<u8> {
        let (mut state, mut size) = (null_mut(), 0);
        // SAFETY: a live component; the stated number of bytes.
        unsafe {
            assert_eq!(fmi2GetFMUstate(self.c, &mut state), OK);
            assert_eq!(fmi2SerializedFMUstateSize(self.c, state, &mut size), OK);
            let mut bytes = vec![0; size];
            assert_eq!(fmi2SerializeFMUstate(self.c, state, bytes.as_mut_ptr(), size), OK);
            assert_eq!(fmi2FreeFMUstate(self.c, &mut state), OK);
            bytes
        }
    }

    pub fn restore(&self, bytes: &[u8]) {
        // The variable that receives the state may contain anything before.
        let mut state = std::ptr::without_provenance_mut(0xdead_beef);
        // SAFETY: as above.
        unsafe {
            assert_eq!(fmi2DeSerializeFMUstate(self.c, bytes.as_ptr(), bytes.len(), &mut state), OK);
            assert_eq!(fmi2SetFMUstate(self.c, state), OK);
            assert_eq!(fmi2FreeFMUstate(self.c, &mut state), OK);
        }
    }
}

impl Drop for Fmu2 {
    fn drop(&mut self) {
        // SAFETY: the component is not used again, and then nor is its log.
        unsafe {
            fmi2FreeInstance(self.c);
            drop(Box::from_raw(self.log));
        }
    }
}
