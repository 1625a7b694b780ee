//! The exported functions, except the access to values (FMI 3.0.2, 2.2, 2.3, 3.2 and 4.2).

/// Exports a [`Component`](crate::Component) by FMI 3.0: all functions of the standard, each a
/// public function with its C name. The macro belongs in a module of the library that hosts load,
/// with the type in scope.
#[macro_export]
macro_rules! export_fmi3 {
    ($component:ty) => {
        $crate::__instances_of_fmi3!($component);
        $crate::__values_of_fmi3!($component);
        $crate::__functions_of_fmi3! {
            $component;
            "2.3.1":
            fmi3SetDebugLogging, SetDebugLogging(flag loggingOn: $crate::fmi3::types::FmiBoolean, value nCategories: usize, texts categories[nCategories])
                |instance, _| instance.set_debug_logging(loggingOn, categories);
            fmi3Reset, Reset() |instance, _| instance.reset();

            "2.3.2":
            fmi3EnterInitializationMode, EnterInitializationMode(flag toleranceDefined: $crate::fmi3::types::FmiBoolean, value tolerance: f64,
                value startTime: f64, flag stopTimeDefined: $crate::fmi3::types::FmiBoolean, value stopTime: f64)
                |instance, _| instance.enter_initialization_mode(
                    toleranceDefined.then_some(tolerance), startTime, stopTimeDefined.then_some(stopTime));

            "2.3.3":
            fmi3ExitInitializationMode, ExitInitializationMode() |instance, host| instance.exit_initialization_mode(host);

            "2.3.4":
            fmi3Terminate, Terminate() |instance, _| instance.terminate();

            "2.2.7.4":
            /// Writes into a new FMU state, or over one that this instance has returned.
            fmi3GetFMUState, GetFMUState(handle FMUState)
                |instance, _| FMUState.replace(|old| instance.save(old));
            /// Any address is safe: only addresses that this instance has returned are accepted.
            fmi3SetFMUState, SetFMUState(state FMUState) |instance, _| instance.restore(FMUState);
            /// A null state is ignored.
            fmi3FreeFMUState, FreeFMUState(handle FMUState) |instance, _| FMUState.free(|old| instance.free(old));
            fmi3SerializedFMUStateSize, SerializedFMUStateSize(state FMUState, out size: usize[1])
                |instance, _| size.give(instance.serialized(FMUState).map(|bytes| bytes.len()));
            /// The array must have the size that `fmi3SerializedFMUStateSize` returns.
            fmi3SerializeFMUState, SerializeFMUState(state FMUState, out serializedState: u8[size], value size: usize)
                |instance, _| serializedState.copy(&instance.serialized(FMUState)?, "size");
            /// Writes into a new FMU state, or over one that this instance has returned.
            fmi3DeserializeFMUState, DeserializeFMUState(array serializedState: u8[size], value size: usize, handle FMUState)
                |instance, _| FMUState.replace(|old| instance.deserialize(serializedState, old));

            "2.3.2":
            /// Always refused, since no parameter is structural.
            fmi3EnterConfigurationMode, EnterConfigurationMode() |instance, _| instance.never();

            "2.3.6":
            /// Never allowed.
            fmi3ExitConfigurationMode, ExitConfigurationMode() |instance, _| instance.never();

            "3.2.1 and 4.2.1":
            fmi3EnterEventMode, EnterEventMode() |instance, _| instance.enter_event_mode();

            "2.3.5":
            /// Never allowed, since getters in Event Mode show the values after the event.
            fmi3EvaluateDiscreteStates, EvaluateDiscreteStates() |instance, _| instance.never();
            /// One call carries out all events of an instant, and nothing ends the simulation.
            fmi3UpdateDiscreteStates, UpdateDiscreteStates(out discreteStatesNeedUpdate: $crate::fmi3::types::FmiBoolean[1],
                out terminateSimulation: $crate::fmi3::types::FmiBoolean[1], out nominalsOfContinuousStatesChanged: $crate::fmi3::types::FmiBoolean[1],
                out valuesOfContinuousStatesChanged: $crate::fmi3::types::FmiBoolean[1], out nextEventTimeDefined: $crate::fmi3::types::FmiBoolean[1],
                out nextEventTime: f64[1])
                |instance, host| {
                    let $crate::fmi3::types::DiscreteStates { changed, next_event_time: next } =
                        instance.update_discrete_states(host)?;
                    for never in [discreteStatesNeedUpdate, terminateSimulation] {
                        never.put(0, 0);
                    }
                    nominalsOfContinuousStatesChanged.put(0, changed.nominals.into());
                    valuesOfContinuousStatesChanged.put(0, changed.states.into());
                    nextEventTimeDefined.put(0, next.is_some().into());
                    nextEventTime.put(0, next.unwrap_or(0.0));
                    instance.never()
                };
            fmi3EnterContinuousTimeMode, EnterContinuousTimeMode()
                |instance, host| instance.leave_event_mode($crate::fmi3::states::Function::EnterContinuousTimeMode, host);
            fmi3EnterStepMode, EnterStepMode() |instance, host| instance.leave_event_mode($crate::fmi3::states::Function::EnterStepMode, host);

            "3.2.1":
            fmi3CompletedIntegratorStep, CompletedIntegratorStep(flag noSetFMUStatePriorToCurrentPoint: $crate::fmi3::types::FmiBoolean,
                out enterEventMode: $crate::fmi3::types::FmiBoolean[1], out terminateSimulation: $crate::fmi3::types::FmiBoolean[1])
                |instance, _| {
                    enterEventMode.give(Component::complete_integrator_step(&mut instance.component).map(Into::into))?;
                    terminateSimulation.put(0, 0);
                    instance.never()
                };
            fmi3SetTime, SetTime(value time: f64) |instance, _| Component::set_time(&mut instance.component, time);
            fmi3SetContinuousStates, SetContinuousStates(states continuousStates: f64[nContinuousStates],
                value nContinuousStates: usize)
                |instance, _| $crate::Model::set_continuous_states(&mut instance.component, continuousStates);
            fmi3GetContinuousStateDerivatives, GetContinuousStateDerivatives(out derivatives: f64[nContinuousStates],
                value nContinuousStates: usize)
                |instance, _| derivatives.copy($crate::Model::state_derivatives(&instance.component)?.as_ref(), "nContinuousStates");
            fmi3GetEventIndicators, GetEventIndicators(out eventIndicators: f64[nEventIndicators],
                value nEventIndicators: usize)
                |instance, _| eventIndicators.copy($crate::Model::event_indicators(&instance.component)?.as_ref(), "nEventIndicators");

            "2.3.3":
            fmi3GetContinuousStates, GetContinuousStates(out continuousStates: f64[nContinuousStates],
                value nContinuousStates: usize)
                |instance, _| continuousStates.copy($crate::Model::continuous_states(&instance.component)?.as_ref(), "nContinuousStates");
            fmi3GetNominalsOfContinuousStates, GetNominalsOfContinuousStates(out nominals: f64[nContinuousStates],
                value nContinuousStates: usize)
                |instance, _| nominals.copy($crate::Model::nominals(&instance.component).as_ref(), "nContinuousStates");

            "2.3.2":
            fmi3GetNumberOfEventIndicators, GetNumberOfEventIndicators(out nEventIndicators: usize[1])
                |instance, _| {
                    nEventIndicators.put(0, $crate::Model::number_of_event_indicators(&instance.component));
                    instance.never()
                };
            fmi3GetNumberOfContinuousStates, GetNumberOfContinuousStates(out nContinuousStates: usize[1])
                |instance, _| {
                    nContinuousStates.put(0, instance.number_of_states());
                    instance.never()
                };

            "4.1.2":
            fmi3GetOutputDerivatives, GetOutputDerivatives(array valueReferences: u32[nValueReferences],
                value nValueReferences: usize, array orders: i32[nValueReferences], out values: f64[nValues],
                value nValues: usize)
                |instance, _| instance.output_derivatives(valueReferences, orders, nValues, |i, x| values.put(i, x));

            "5.2.1":
            /// Never allowed: Scheduled Execution is not offered.
            fmi3ActivateModelPartition, ActivateModelPartition(value clockReference: u32, value activationTime: f64)
                |instance, _| instance.never();
        }
    };
}

/// The functions that make, free and step instances, for `export_fmi3!`.
#[doc(hidden)]
#[macro_export]
macro_rules! __instances_of_fmi3 {
    ($component:ty) => {
        /// `fmi3GetVersion` (FMI 3.0.2, 2.2.5).
        #[unsafe(no_mangle)]
        #[allow(unsafe_code, non_snake_case)]
        pub extern "C" fn fmi3GetVersion() -> *const ::core::ffi::c_char {
            c"3.0".as_ptr()
        }

        /// `fmi3InstantiateModelExchange` (FMI 3.0.2, 2.3.1): a new instance, or null and a log
        /// message. Instances are independent and may be used from different threads, each from
        /// one thread at a time.
        ///
        /// # Safety
        /// `instanceName`, `instantiationToken` and `resourcePath` are null or C strings; logger
        /// and environment stay valid until the instance is freed.
        #[unsafe(no_mangle)]
        #[allow(unsafe_code, non_snake_case)]
        pub unsafe extern "C" fn fmi3InstantiateModelExchange(
            instanceName: *const ::core::ffi::c_char,
            instantiationToken: *const ::core::ffi::c_char,
            resourcePath: *const ::core::ffi::c_char,
            _visible: $crate::fmi3::types::FmiBoolean,
            loggingOn: $crate::fmi3::types::FmiBoolean,
            instanceEnvironment: *mut ::core::ffi::c_void,
            logMessage: Option<$crate::fmi3::abi::FmiLogMessage>,
        ) -> $crate::fmi3::abi::FmiInstance {
            let request = $crate::fmi3::abi::Request {
                name: instanceName,
                token: instantiationToken,
                resources: resourcePath,
                logging: loggingOn,
                environment: instanceEnvironment,
                logger: logMessage,
            };
            // SAFETY: as the caller ensures.
            unsafe { $crate::fmi3::abi::instantiate_model_exchange::<$component>(request) }
        }

        /// `fmi3InstantiateCoSimulation` (FMI 3.0.2, 2.3.1): as [`fmi3InstantiateModelExchange`].
        ///
        /// # Safety
        /// As for [`fmi3InstantiateModelExchange`]; `requiredIntermediateVariables` is null or has
        /// the given number of elements; `intermediateUpdate` stays valid until the instance is
        /// freed.
        #[unsafe(no_mangle)]
        #[allow(unsafe_code, non_snake_case, clippy::too_many_arguments)] // the standard's
        pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
            instanceName: *const ::core::ffi::c_char,
            instantiationToken: *const ::core::ffi::c_char,
            resourcePath: *const ::core::ffi::c_char,
            _visible: $crate::fmi3::types::FmiBoolean,
            loggingOn: $crate::fmi3::types::FmiBoolean,
            eventModeUsed: $crate::fmi3::types::FmiBoolean,
            earlyReturnAllowed: $crate::fmi3::types::FmiBoolean,
            requiredIntermediateVariables: *const u32,
            nRequiredIntermediateVariables: usize,
            instanceEnvironment: *mut ::core::ffi::c_void,
            logMessage: Option<$crate::fmi3::abi::FmiLogMessage>,
            intermediateUpdate: Option<$crate::fmi3::abi::FmiIntermediateUpdate>,
        ) -> $crate::fmi3::abi::FmiInstance {
            let request = $crate::fmi3::abi::Request {
                name: instanceName,
                token: instantiationToken,
                resources: resourcePath,
                logging: loggingOn,
                environment: instanceEnvironment,
                logger: logMessage,
            };
            let required = (requiredIntermediateVariables, nRequiredIntermediateVariables);
            let events = (eventModeUsed, earlyReturnAllowed);
            // SAFETY: as the caller ensures.
            unsafe {
                $crate::fmi3::abi::instantiate_co_simulation::<$component>(
                    request,
                    events,
                    required,
                    intermediateUpdate,
                )
            }
        }

        /// `fmi3InstantiateScheduledExecution` (FMI 3.0.2, 2.3.1): always null and a log message,
        /// since the model has no partitions.
        ///
        /// # Safety
        /// As for [`fmi3InstantiateModelExchange`].
        #[unsafe(no_mangle)]
        #[allow(unsafe_code, non_snake_case, clippy::too_many_arguments)] // the standard's
        pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
            instanceName: *const ::core::ffi::c_char,
            instantiationToken: *const ::core::ffi::c_char,
            resourcePath: *const ::core::ffi::c_char,
            _visible: $crate::fmi3::types::FmiBoolean,
            loggingOn: $crate::fmi3::types::FmiBoolean,
            instanceEnvironment: *mut ::core::ffi::c_void,
            logMessage: Option<$crate::fmi3::abi::FmiLogMessage>,
            _clockUpdate: Option<unsafe extern "C" fn(*mut ::core::ffi::c_void)>,
            _lockPreemption: Option<unsafe extern "C" fn()>,
            _unlockPreemption: Option<unsafe extern "C" fn()>,
        ) -> $crate::fmi3::abi::FmiInstance {
            let request = $crate::fmi3::abi::Request {
                name: instanceName,
                token: instantiationToken,
                resources: resourcePath,
                logging: loggingOn,
                environment: instanceEnvironment,
                logger: logMessage,
            };
            // SAFETY: as the caller ensures.
            unsafe { $crate::fmi3::abi::instantiate_scheduled::<$component>(request) }
        }

        /// `fmi3FreeInstance` (FMI 3.0.2, 2.3.1). It also frees the FMU states that the host has
        /// not freed. Null is ignored, and so is a call from inside the instance's logger or
        /// callback.
        ///
        /// # Safety
        /// `instance` is null or from an instantiation and not freed; nothing uses it or its FMU
        /// states afterwards.
        #[unsafe(no_mangle)]
        #[allow(unsafe_code, non_snake_case)]
        pub unsafe extern "C" fn fmi3FreeInstance(instance: $crate::fmi3::abi::FmiInstance) {
            // SAFETY: as the caller ensures.
            unsafe { $crate::fmi3::abi::free::<$component>(instance) }
        }

        /// `fmi3DoStep` (FMI 3.0.2, 4.2.1). `lastSuccessfulTime` is always written, even on an
        /// error.
        ///
        /// # Safety
        /// The instance is null or from an instantiation and not freed, and no call on it is
        /// running in another thread. Every other pointer is null or valid for one element.
        #[unsafe(no_mangle)]
        #[allow(unsafe_code, non_snake_case, clippy::too_many_arguments)] // the standard's
        pub unsafe extern "C" fn fmi3DoStep(
            instance: $crate::fmi3::abi::FmiInstance,
            currentCommunicationPoint: f64,
            communicationStepSize: f64,
            _noSetFMUStatePriorToCurrentPoint: $crate::fmi3::types::FmiBoolean,
            eventHandlingNeeded: *mut $crate::fmi3::types::FmiBoolean,
            terminateSimulation: *mut $crate::fmi3::types::FmiBoolean,
            earlyReturn: *mut $crate::fmi3::types::FmiBoolean,
            lastSuccessfulTime: *mut f64,
        ) -> $crate::fmi3::types::FmiStatus {
            let step = (currentCommunicationPoint, communicationStepSize);
            let flags = [eventHandlingNeeded, terminateSimulation, earlyReturn];
            // SAFETY: as the caller ensures.
            unsafe { $crate::fmi3::abi::do_step::<$component>(instance, step, flags, lastSuccessfulTime) }
        }
    };
}
