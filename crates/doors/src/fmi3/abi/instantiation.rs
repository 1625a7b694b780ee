//! Making instances (FMI 3.0.2, 2.3.1).

use super::*;
use crate::ffi::panics::silence;
use crate::life::{EventHandling, Interface};
use crate::log::Categories;
use std::ptr;

/// Arguments that all instantiation functions share.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    /// `instanceName`.
    pub name: *const c_char,
    /// `instantiationToken`.
    pub token: *const c_char,
    /// `resourcePath`.
    pub resources: *const c_char,
    /// `loggingOn`.
    pub logging: FmiBoolean,
    /// `instanceEnvironment`.
    pub environment: *mut c_void,
    /// `logMessage`.
    pub logger: Option<FmiLogMessage>,
}

/// Name, token and location of the resources, checked.
type Who<'a> = (&'a str, (&'a str, Option<&'a str>));

impl Request {
    /// A new instance, made by `make` from name, token, resources and log categories. On an error
    /// the result is null, and a log message gives the reason.
    ///
    /// # Safety
    /// Name, token and resources are null or C strings.
    unsafe fn instantiate<C: Component>(
        self,
        function: &'static str,
        intermediate_update: Option<FmiIntermediateUpdate>,
        make: impl FnOnce(Who<'_>, Categories, &mut Host) -> Outcome<C, Instance<C>>,
    ) -> FmiInstance {
        silence();
        let enabled = status::enabled_at_start(self.logging != 0);
        let mut host = Host { logger: self.logger, environment: self.environment };
        let outcome = guarded(|| {
            // SAFETY: null or C strings.
            let (name, token, resources) = unsafe {
                let (name, token) =
                    (c_str(self.name, "instanceName")?, c_str(self.token, "instantiationToken")?);
                (name, token, c_str(self.resources, "resourcePath").ok())
            };
            let resources = resources.map(|resources| resources.to_string_lossy());
            let who = (&*name.to_string_lossy(), (&*token.to_string_lossy(), resources.as_deref()));
            let instance = make(who, enabled, &mut host)?;
            instance.tell(function, &mut host);
            Ok(instance)
        });
        match outcome.map_err(CallProblem::from).flatten() {
            Ok(instance) => Box::into_raw(Box::new(Shared {
                instance: RefCell::new((instance, host)),
                environment: self.environment,
                intermediate_update,
            }))
            .cast(),
            Err(problem) => {
                report(enabled, &mut host, function, problem.status(Function::FreeInstance), &problem);
                ptr::null_mut()
            }
        }
    }
}

/// `fmi3InstantiateModelExchange` (FMI 3.0.2, 2.3.1).
///
/// # Safety
/// The strings of the request are null or C strings; logger and environment stay valid until the
/// instance is freed.
pub unsafe fn instantiate_model_exchange<C: Component>(request: Request) -> FmiInstance {
    let handling = EventHandling { event_mode: true, early_return: false };
    // SAFETY: as the caller ensures.
    unsafe {
        request.instantiate::<C>("fmi3InstantiateModelExchange", None, |(name, files), enabled, _| {
            Instance::new(name, Interface::ModelExchange, files, handling, enabled)
        })
    }
}

/// `fmi3InstantiateCoSimulation` (FMI 3.0.2, 2.3.1), with `eventModeUsed` and
/// `earlyReturnAllowed`, `requiredIntermediateVariables` and their number.
///
/// # Safety
/// As for [`instantiate_model_exchange`]; the required variables are null or have the given
/// number; the callback stays valid until the instance is freed.
pub unsafe fn instantiate_co_simulation<C: Component>(
    request: Request,
    (event_mode, early_return): (FmiBoolean, FmiBoolean),
    (required, count): (*const u32, usize),
    intermediate_update: Option<FmiIntermediateUpdate>,
) -> FmiInstance {
    let handling = EventHandling { event_mode: event_mode != 0, early_return: early_return != 0 };
    // SAFETY: as the caller ensures.
    unsafe {
        request.instantiate::<C>(
            "fmi3InstantiateCoSimulation",
            intermediate_update,
            |(name, files), enabled, host| {
                let required = array(required, count, ("requiredIntermediateVariables", C::MAX_COUNT))?;
                let mut instance = Instance::new(name, Interface::CoSimulation, files, handling, enabled)?;
                instance.require_intermediate_variables(required, intermediate_update.is_some(), host)?;
                Ok(instance)
            },
        )
    }
}

/// `fmi3InstantiateScheduledExecution` (FMI 3.0.2, 2.3.1): always null and a log message.
///
/// # Safety
/// As for [`instantiate_model_exchange`].
pub unsafe fn instantiate_scheduled<C: Component>(request: Request) -> FmiInstance {
    // SAFETY: as the caller ensures.
    unsafe {
        request.instantiate::<C>("fmi3InstantiateScheduledExecution", None, |_, _, _| {
            Err(CallProblem::Sequence {
                what: "the model has no partitions to schedule: use Co-Simulation or Model Exchange",
            })
        })
    }
}
