//! Making instances (FMI 3.0.2, 2.3.1).

use super::*;
use crate::component::log::Categories;
use crate::component::{EventHandling, Interface};
use crate::ffi::panics::silence;
use std::ptr;

/// What all instantiations have in common.
struct Request {
    function: &'static str,
    name: *const c_char,
    token: *const c_char,
    logging: FmiBoolean,
    environment: *mut c_void,
    logger: Option<FmiLogMessage>,
}

impl Request {
    /// A new instance as `make` makes it of name, token and log categories; or null and a log message.
    ///
    /// # Safety
    /// Name and token are null or C strings.
    unsafe fn instantiate(
        self,
        intermediate_update: Option<FmiIntermediateUpdate>,
        make: impl FnOnce(&str, &str, Categories, &mut Host) -> Outcome<Instance>,
    ) -> FmiInstance {
        silence();
        let enabled = status::enabled_at_start(self.logging != 0);
        let mut host = Host { logger: self.logger, environment: self.environment };
        let outcome = guarded(|| {
            // SAFETY: null or C strings.
            let (name, token) =
                unsafe { (c_str(self.name, "instanceName")?, c_str(self.token, "instantiationToken")?) };
            make(&name.to_string_lossy(), &token.to_string_lossy(), enabled, &mut host)
        });
        match outcome.map_err(Problem::from).flatten() {
            Ok(instance) => Box::into_raw(Box::new(Shared {
                instance: RefCell::new((instance, host)),
                environment: self.environment,
                intermediate_update,
            }))
            .cast(),
            Err(problem) => {
                report(enabled, &mut host, self.function, problem.status(Function::FreeInstance), &problem);
                ptr::null_mut()
            }
        }
    }
}

/// `fmi3InstantiateModelExchange` (FMI 3.0.2, 2.3.1): a new instance, or null and a log message. The name is only checked;
/// resources and visibility are not used. Instances are independent of each other and may be used from different threads,
/// each from one at a time.
///
/// # Safety
/// `instanceName` and `instantiationToken` are null or C strings; logger and environment stay valid until the instance is freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    instanceName: *const c_char,
    instantiationToken: *const c_char,
    _resourcePath: *const c_char,
    _visible: FmiBoolean,
    loggingOn: FmiBoolean,
    instanceEnvironment: *mut c_void,
    logMessage: Option<FmiLogMessage>,
) -> FmiInstance {
    let request = Request {
        function: "fmi3InstantiateModelExchange",
        name: instanceName,
        token: instantiationToken,
        logging: loggingOn,
        environment: instanceEnvironment,
        logger: logMessage,
    };
    let handling = EventHandling { event_mode: true, early_return: false };
    // SAFETY: as the caller says.
    unsafe {
        request.instantiate(None, |name, token, enabled, _| {
            Instance::new(name, Interface::ModelExchange, token, handling, enabled)
        })
    }
}

/// `fmi3InstantiateCoSimulation` (FMI 3.0.2, 2.3.1): as [`fmi3InstantiateModelExchange`].
///
/// # Safety
/// As for [`fmi3InstantiateModelExchange`]; `requiredIntermediateVariables` is null or has as many elements as the count says;
/// `intermediateUpdate` stays valid until the instance is freed.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // the standard's
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    instanceName: *const c_char,
    instantiationToken: *const c_char,
    _resourcePath: *const c_char,
    _visible: FmiBoolean,
    loggingOn: FmiBoolean,
    eventModeUsed: FmiBoolean,
    earlyReturnAllowed: FmiBoolean,
    requiredIntermediateVariables: *const u32,
    nRequiredIntermediateVariables: usize,
    instanceEnvironment: *mut c_void,
    logMessage: Option<FmiLogMessage>,
    intermediateUpdate: Option<FmiIntermediateUpdate>,
) -> FmiInstance {
    let request = Request {
        function: "fmi3InstantiateCoSimulation",
        name: instanceName,
        token: instantiationToken,
        logging: loggingOn,
        environment: instanceEnvironment,
        logger: logMessage,
    };
    let handling = EventHandling { event_mode: eventModeUsed != 0, early_return: earlyReturnAllowed != 0 };
    // SAFETY: as the caller says.
    unsafe {
        request.instantiate(intermediateUpdate, |name, token, enabled, host| {
            let required = array(
                requiredIntermediateVariables,
                nRequiredIntermediateVariables,
                "requiredIntermediateVariables",
            )?;
            let mut instance = Instance::new(name, Interface::CoSimulation, token, handling, enabled)?;
            instance.require_intermediate_variables(required, intermediateUpdate.is_some(), host)?;
            instance.warn_of_clocks(host);
            Ok(instance)
        })
    }
}

/// `fmi3InstantiateScheduledExecution` (FMI 3.0.2, 2.3.1): always null and a log message, since the model has no partitions.
///
/// # Safety
/// As for [`fmi3InstantiateModelExchange`].
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // the standard's
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    instanceName: *const c_char,
    instantiationToken: *const c_char,
    _resourcePath: *const c_char,
    _visible: FmiBoolean,
    loggingOn: FmiBoolean,
    instanceEnvironment: *mut c_void,
    logMessage: Option<FmiLogMessage>,
    _clockUpdate: Option<unsafe extern "C" fn(*mut c_void)>,
    _lockPreemption: Option<unsafe extern "C" fn()>,
    _unlockPreemption: Option<unsafe extern "C" fn()>,
) -> FmiInstance {
    let request = Request {
        function: "fmi3InstantiateScheduledExecution",
        name: instanceName,
        token: instantiationToken,
        logging: loggingOn,
        environment: instanceEnvironment,
        logger: logMessage,
    };
    // SAFETY: as the caller says.
    unsafe {
        request.instantiate(None, |_, _, _, _| {
            Err(Problem::Sequence {
                what: "the model has no partitions to schedule: use Co-Simulation or Model Exchange",
            })
        })
    }
}
