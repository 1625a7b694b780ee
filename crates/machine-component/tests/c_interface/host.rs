//! An FMI 3.0 host for one machine, with its messages.

use crate::*;
use fmi_doors::fmi3::abi::FmiInstance;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::ptr::null;
use vibro_machine::motion::Reached;
use vibro_machine::{Motion, file};
use vibro_machine_component::{FILE, Plan};

pub const OK: c_int = 0;
pub const DISCARD: c_int = 2;
pub const ERROR: c_int = 3;

/// The plan of an example after a change of its text.
pub fn plan(example: &str, change: impl Fn(String) -> String) -> Plan {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly").join(example);
    let machine = file::read(&path).unwrap();
    Plan::new(change(machine.to_toml()), FILE).unwrap()
}

/// A folder of resources with the machine's file.
pub fn resources(folder: &str, plan: &Plan) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(folder);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(FILE), plan.text()).unwrap();
    folder
}

pub unsafe extern "C-unwind" fn keep(text: *mut c_void, _: c_int, _: *const c_char, message: *const c_char) {
    let message = unsafe { CStr::from_ptr(message) }.to_str().unwrap().to_owned();
    unsafe { (*text.cast::<Vec<String>>()).push(message) };
}

/// Messages behind a raw pointer, through which the callback adds to them: a box would promise
/// unique access.
pub struct Messages(*mut Vec<String>);

impl std::ops::Deref for Messages {
    type Target = Vec<String>;

    fn deref(&self) -> &Vec<String> {
        // SAFETY: the list lives until the drop of this value; nothing is added while it is read.
        unsafe { &*self.0 }
    }
}

impl Drop for Messages {
    fn drop(&mut self) {
        // SAFETY: the pointer was made from a box.
        drop(unsafe { Box::from_raw(self.0) });
    }
}

impl std::fmt::Debug for Messages {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (**self).fmt(f)
    }
}

/// An instance of FMI 3.0 with its messages.
pub struct Instance<'a> {
    pub c: FmiInstance,
    pub plan: &'a Plan,
    pub messages: Messages,
}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        unsafe { fmi3FreeInstance(self.c) }
    }
}

impl<'a> Instance<'a> {
    pub fn new(folder: &Path, plan: &'a Plan, token: &str, events: bool) -> Self {
        let messages = Messages(Box::into_raw(Box::default()));
        let token = CString::new(token).unwrap();
        let folder = CString::new(folder.to_str().unwrap()).unwrap();
        let (events, environment) = (u8::from(events), messages.0.cast());
        let c = unsafe {
            fmi3InstantiateCoSimulation(
                c"a".as_ptr(),
                token.as_ptr(),
                folder.as_ptr(),
                0,
                1,
                events,
                events,
                null(),
                0,
                environment,
                Some(keep),
                None,
            )
        };
        Self { c, plan, messages }
    }

    pub fn of(name: &str, plan: &'a Plan, events: bool) -> Self {
        let instance = Self::new(&resources(name, plan), plan, plan.token(), events);
        assert!(!instance.c.is_null(), "{:?}", instance.messages);
        instance
    }

    pub fn begin(&self) {
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(self.c, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi3ExitInitializationMode(self.c), OK, "{:?}", self.messages);
        }
    }

    pub fn reference(&self, name: &str) -> u32 {
        self.plan.table.reference(name).unwrap_or_else(|| panic!("no {name}"))
    }

    pub fn get(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        let status = unsafe { fmi3GetFloat64(self.c, &self.reference(name), 1, &mut value, 1) };
        assert_eq!(status, OK, "{name}: {:?}", self.messages);
        value
    }

    pub fn whole(&self, name: &str) -> i32 {
        let mut value = -1;
        assert_eq!(unsafe { fmi3GetInt32(self.c, &self.reference(name), 1, &mut value, 1) }, OK);
        value
    }

    pub fn state(&self, name: &str) -> i64 {
        let mut value = -1;
        assert_eq!(unsafe { fmi3GetInt64(self.c, &self.reference(name), 1, &mut value, 1) }, OK);
        value
    }

    pub fn set(&self, name: &str, value: f64) -> c_int {
        unsafe { fmi3SetFloat64(self.c, &self.reference(name), 1, &value, 1) }
    }

    /// Makes a step. Returns whether an event is pending, whether it ended early, its end time.
    pub fn step(&self, point: f64, size: f64) -> (bool, bool, f64) {
        let (mut event, mut end, mut early, mut time) = (0, 0, 0, 0.0);
        let status =
            unsafe { fmi3DoStep(self.c, point, size, 1, &mut event, &mut end, &mut early, &mut time) };
        assert_eq!(status, OK, "{:?}", self.messages);
        (event != 0, early != 0, time)
    }

    /// Handles the events of this instant. Returns whether something has changed, and the time of
    /// the next event, if known.
    pub fn handle(&self) -> (bool, Option<f64>) {
        let (mut changed, mut defined, mut next) = (0, 0, 0.0);
        unsafe {
            let (mut again, mut end, mut nominals) = (0, 0, 0);
            let (again, end, nominals) = (&mut again, &mut end, &mut nominals);
            let (defined, next) = (&mut defined, &mut next);
            let status = fmi3UpdateDiscreteStates(self.c, again, end, nominals, &mut changed, defined, next);
            assert_eq!(status, OK, "{:?}", self.messages);
            assert_eq!(fmi3EnterStepMode(self.c), OK);
        }
        (changed != 0, (defined != 0).then_some(next))
    }
}

pub fn unchanged(text: String) -> String {
    text
}

pub fn native(plan: &Plan) -> Motion {
    Motion::new(plan.assembly.clone()).unwrap()
}

/// Returns the times up to `end` of a native motion's events, and of the reported ones. After the
/// end of a compliant stop's force, the opening of its gap is not reported.
pub fn native_events(plan: &Plan, end: f64) -> (Vec<f64>, Vec<f64>) {
    let (mut motion, mut due, mut told) = (native(plan), Vec::new(), Vec::new());
    while motion.advance_before_event(end, &mut |event| told.push(event.time)).unwrap() == Reached::Event {
        due.push(motion.time());
        motion.apply_event(&mut |event| told.push(event.time)).unwrap();
    }
    [&mut due, &mut told].into_iter().for_each(Vec::dedup);
    (due, told)
}
