//! A host of FMI 3.0 in a few lines.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};
use vibro_paper_component::component::variables::{Base, find};
use vibro_paper_component::fmi3::abi::*;
use vibro_paper_component::fmi3::description;

pub const OK: c_int = 0;
pub const WARNING: c_int = 1;
pub const DISCARD: c_int = 2;
pub const ERROR: c_int = 3;

pub const MOTION: [&str; 6] = ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"];

/// Flags of an instantiation.
#[derive(Clone, Copy, Default)]
pub struct Flags {
    pub event_mode: bool,
    pub early_return: bool,
}

pub const FF: Flags = Flags { event_mode: false, early_return: false };
pub const FT: Flags = Flags { event_mode: false, early_return: true };
pub const TF: Flags = Flags { event_mode: true, early_return: false };
pub const TT: Flags = Flags { event_mode: true, early_return: true };

/// Result of `fmi3DoStep`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct End {
    pub event: bool,
    pub terminate: bool,
    pub early: bool,
    pub time: f64,
}

/// Result of `fmi3UpdateDiscreteStates`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Update {
    pub values_changed: bool,
    pub next: Option<f64>,
}

pub type Record = (c_int, String, String);

unsafe extern "C-unwind" fn keep(
    environment: *mut c_void,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is the host's; the FMU passes C strings.
    unsafe {
        let text = |p| CStr::from_ptr(p).to_str().unwrap().to_owned();
        (*environment.cast::<Vec<Record>>()).push((status, text(category), text(message)));
    }
}

pub struct Fmu {
    pub c: FmiInstance,
    pub edition: description::Edition,
    log: *mut Vec<Record>,
}

/// Value reference in the main description.
pub fn vr(name: &str) -> u32 {
    description::value_reference(description::MAIN, name).unwrap()
}

pub fn token() -> CString {
    CString::new(description::instantiation_token(description::MAIN)).unwrap()
}

impl Fmu {
    pub fn new(flags: Flags) -> Self {
        Self::with_callback(flags, &[], None, null_mut())
    }

    /// An instance of the description with arrays.
    pub fn arrays(flags: Flags) -> Self {
        Self::with(description::ARRAYS, flags, &[], None, null_mut())
    }

    /// An instance of the description with a clock.
    pub fn clocked(flags: Flags) -> Self {
        Self::with(description::CLOCKED, flags, &[], None, null_mut())
    }

    /// Messages go to the log unless the callback has an environment, which the logger would get
    /// too.
    pub fn with_callback(
        flags: Flags,
        required: &[u32],
        callback: Option<FmiIntermediateUpdate>,
        environment: *mut c_void,
    ) -> Self {
        Self::with(description::MAIN, flags, required, callback, environment)
    }

    fn with(
        edition: description::Edition,
        flags: Flags,
        required: &[u32],
        callback: Option<FmiIntermediateUpdate>,
        environment: *mut c_void,
    ) -> Self {
        let token = CString::new(description::instantiation_token(edition)).unwrap();
        let log = Box::into_raw(Box::new(Vec::<Record>::new()));
        let (environment, logger) = match environment.is_null() {
            true => (log.cast(), Some(keep as FmiLogMessage)),
            false => (environment, None),
        };
        // SAFETY: valid strings, the right number of references, and what the host vouches for
        // lives longer.
        let c = unsafe {
            fmi3InstantiateCoSimulation(
                c"box".as_ptr(),
                token.as_ptr(),
                null(),
                0,
                1,
                flags.event_mode.into(),
                flags.early_return.into(),
                required.as_ptr(),
                required.len(),
                environment,
                logger,
                callback,
            )
        };
        assert!(!c.is_null());
        Self { c, edition, log }
    }

    pub fn exchange() -> Self {
        let log = Box::into_raw(Box::new(Vec::<Record>::new()));
        // SAFETY: as above.
        let c = unsafe {
            fmi3InstantiateModelExchange(
                c"box".as_ptr(),
                token().as_ptr(),
                null(),
                0,
                1,
                log.cast(),
                Some(keep),
            )
        };
        assert!(!c.is_null());
        Self { c, edition: description::MAIN, log }
    }

    pub fn log(&self) -> &[Record] {
        // SAFETY: freed with the host; the logger does not run now.
        unsafe { &*self.log }
    }

    pub fn last(&self) -> &str {
        self.log().last().map_or("", |record| &record.2)
    }

    pub fn initialize(&self) {
        // SAFETY: a live instance. Undefined values are not read.
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(self.c, 0, f64::NAN, 0.0, 0, -1.0), OK, "{}", self.last());
            assert_eq!(fmi3ExitInitializationMode(self.c), OK, "{}", self.last());
        }
    }

    pub fn started(flags: Flags, start: &[(&str, f64)]) -> Self {
        Self::new(flags).start(flags, start)
    }

    /// Sets start values and initializes up to the first step.
    pub fn start(self, flags: Flags, start: &[(&str, f64)]) -> Self {
        let fmu = self;
        for (name, value) in start {
            assert_eq!(fmu.set(name, *value), OK, "{name}: {}", fmu.last());
        }
        fmu.initialize();
        if flags.event_mode {
            fmu.update();
            fmu.enter_step_mode();
        }
        fmu
    }

    /// Value reference in this instance's description.
    pub fn vr(&self, name: &str) -> u32 {
        description::value_reference(self.edition, name).unwrap()
    }

    pub fn set(&self, name: &str, value: f64) -> c_int {
        let r = self.vr(name);
        // SAFETY: one reference and one value each.
        unsafe {
            match find(name).unwrap().base() {
                Base::Real => fmi3SetFloat64(self.c, &r, 1, &value, 1),
                Base::Boolean => fmi3SetBoolean(self.c, &r, 1, &u8::from(value != 0.0), 1),
                Base::Integer => fmi3SetInt32(self.c, &r, 1, &(value as i32), 1),
                _ => fmi3SetInt64(self.c, &r, 1, &(value as i64), 1),
            }
        }
    }

    pub fn get(&self, name: &str) -> f64 {
        let r = self.vr(name);
        let (mut real, mut flag, mut short, mut long) = (f64::NAN, 0, 0, 0);
        // SAFETY: one reference and one value each.
        let base = find(name).unwrap().base();
        let status = unsafe {
            match base {
                Base::Real => fmi3GetFloat64(self.c, &r, 1, &mut real, 1),
                Base::Boolean => fmi3GetBoolean(self.c, &r, 1, &mut flag, 1),
                Base::Integer => fmi3GetInt32(self.c, &r, 1, &mut short, 1),
                Base::Enumeration => fmi3GetInt64(self.c, &r, 1, &mut long, 1),
                Base::Clock => fmi3GetClock(self.c, &r, 1, &mut flag),
            }
        };
        assert_eq!(status, OK, "{name}: {}", self.last());
        match base {
            Base::Real => real,
            Base::Boolean | Base::Clock => flag.into(),
            Base::Integer => short.into(),
            Base::Enumeration => long as f64,
        }
    }

    pub fn motion(&self) -> [f64; 6] {
        MOTION.map(|name| self.get(name))
    }

    pub fn try_step(&self, point: f64, size: f64) -> (c_int, End) {
        let (mut event, mut terminate, mut early, mut time) = (7, 7, 7, f64::NAN);
        // SAFETY: a live instance, one of each.
        let status =
            unsafe { fmi3DoStep(self.c, point, size, 1, &mut event, &mut terminate, &mut early, &mut time) };
        let end = End { event: event == 1, terminate: terminate == 1, early: early == 1, time };
        if status == OK {
            assert!([event, terminate, early].iter().all(|flag| *flag < 2));
        }
        (status, end)
    }

    pub fn step(&self, point: f64, size: f64) -> End {
        let (status, end) = self.try_step(point, size);
        assert_eq!(status, OK, "{}", self.last());
        end
    }

    pub fn enter_event_mode(&self) {
        // SAFETY: a live instance.
        assert_eq!(unsafe { fmi3EnterEventMode(self.c) }, OK, "{}", self.last());
    }

    pub fn enter_step_mode(&self) {
        // SAFETY: a live instance.
        assert_eq!(unsafe { fmi3EnterStepMode(self.c) }, OK, "{}", self.last());
    }

    pub fn update(&self) -> Update {
        let (mut again, mut terminate, mut nominals, mut values, mut defined, mut next) =
            (7, 7, 7, 7, 7, f64::NAN);
        // SAFETY: a live instance, one of each.
        let status = unsafe {
            fmi3UpdateDiscreteStates(
                self.c,
                &mut again,
                &mut terminate,
                &mut nominals,
                &mut values,
                &mut defined,
                &mut next,
            )
        };
        assert_eq!(status, OK, "{}", self.last());
        assert_eq!([again, terminate, nominals], [0; 3]);
        assert!(values < 2 && defined < 2);
        Update { values_changed: values == 1, next: (defined == 1).then_some(next) }
    }

    /// Enters Event Mode and leaves it, like a host that changes nothing.
    pub fn handle_event(&self) -> Update {
        self.enter_event_mode();
        let update = self.update();
        self.enter_step_mode();
        update
    }

    /// Advances to `end` through all events in steps of at most `size`; returns the events' count.
    pub fn run(&self, begin: f64, end: f64, size: f64) -> usize {
        let (mut time, mut events) = (begin, 0);
        while time < end {
            let reached = self.step(time, size.min(end - time));
            time = reached.time;
            if reached.event {
                events += 1;
                self.handle_event();
            }
        }
        events
    }

    pub fn save(&self) -> *mut c_void {
        let mut state = null_mut();
        // SAFETY: a live instance.
        assert_eq!(unsafe { fmi3GetFMUState(self.c, &mut state) }, OK, "{}", self.last());
        state
    }

    pub fn bytes(&self) -> Vec<u8> {
        let (state, mut size) = (self.save(), 0);
        // SAFETY: a live instance; the stated number of bytes.
        unsafe {
            assert_eq!(fmi3SerializedFMUStateSize(self.c, state, &mut size), OK);
            let mut bytes = vec![0; size];
            assert_eq!(fmi3SerializeFMUState(self.c, state, bytes.as_mut_ptr(), size), OK);
            bytes
        }
    }

    pub fn restore(&self, bytes: &[u8]) {
        let mut state = null_mut();
        // SAFETY: as above.
        unsafe {
            assert_eq!(fmi3DeserializeFMUState(self.c, bytes.as_ptr(), bytes.len(), &mut state), OK);
            assert_eq!(fmi3SetFMUState(self.c, state), OK, "{}", self.last());
        }
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        // SAFETY: the instance is not used again, and then nor is its log.
        unsafe {
            fmi3FreeInstance(self.c);
            drop(Box::from_raw(self.log));
        }
    }
}
