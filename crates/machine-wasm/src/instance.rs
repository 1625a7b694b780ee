//! The instances of both interface types: each function of WIT by the C function of its name.

#![allow(unsafe_code)] // calls of C functions, by `called!`

use crate::call::{Asked, Instance, called, restore, result, saved, status_of};
use crate::exports::fmi::fmi3::{co_simulation, model_exchange};
use crate::fmi::fmi3::types::{
    DependencyKind, DiscreteStatesInfo, IntervalFraction, IntervalQualifier, Status, VariableDependency,
};
use std::ptr;

/// An instance for Co-Simulation.
pub struct CoSimulation(Instance);

/// An instance for Model Exchange.
pub struct ModelExchange(Instance);

/// A value as the C functions have it.
trait AsC: Sized {
    type C: Clone + Default;
    fn to_c(self) -> Self::C;
    fn of_c(c: Self::C) -> Self;
}

macro_rules! as_itself {
    ($($type:ty)*) => {$(
        impl AsC for $type {
            type C = Self;
            fn to_c(self) -> Self { self }
            fn of_c(c: Self) -> Self { c }
        }
    )*};
}
as_itself!(f32 f64 i8 i16 i32 i64 u8 u16 u32 u64);

impl AsC for bool {
    type C = u8;
    fn to_c(self) -> u8 {
        self.into()
    }
    fn of_c(c: u8) -> Self {
        c != 0
    }
}

/// The values that a C function has written into an array.
fn values<T: AsC>(count: usize, write: impl FnOnce(*mut T::C) -> i32) -> Result<Vec<T>, Status> {
    let mut all = vec![T::C::default(); count];
    result(write(all.as_mut_ptr()), ())?;
    Ok(all.into_iter().map(T::of_c).collect())
}

fn c_values<T: AsC>(values: Vec<T>) -> Vec<T::C> {
    values.into_iter().map(T::to_c).collect()
}

/// `fmi3DependencyKind` of C.
fn kind_of(kind: i32) -> DependencyKind {
    match kind {
        1 => DependencyKind::Constant,
        2 => DependencyKind::Fixed,
        3 => DependencyKind::Tunable,
        4 => DependencyKind::Discrete,
        _ => DependencyKind::Dependent,
    }
}

fn qualifier_of(qualifier: i32) -> IntervalQualifier {
    match qualifier {
        0 => IntervalQualifier::IntervalNotYetKnown,
        1 => IntervalQualifier::IntervalUnchanged,
        _ => IntervalQualifier::IntervalChanged,
    }
}

fn fraction_of((counter, resolution): (&u64, &u64)) -> IntervalFraction {
    IntervalFraction { counter: *counter, resolution: *resolution }
}

fn parts_of(fractions: &[IntervalFraction]) -> [Vec<u64>; 2] {
    [fractions.iter().map(|own| own.counter).collect(), fractions.iter().map(|own| own.resolution).collect()]
}

/// `fmi3UpdateDiscreteStates`.
fn update_discrete_states(instance: &Instance) -> Result<DiscreteStatesInfo, Status> {
    let (mut flags, mut time) = ([0u8; 5], 0.0);
    let [needed, ends, nominals, states, defined] = flags.each_mut().map(ptr::from_mut);
    let status =
        called!(instance, fmi3UpdateDiscreteStates, needed, ends, nominals, states, defined, &raw mut time);
    let [needed, ends, nominals, states, defined] = flags.map(|flag| flag != 0);
    result(
        status,
        DiscreteStatesInfo {
            new_discrete_states_needed: needed,
            terminate_simulation: ends,
            nominals_of_continuous_states_changed: nominals,
            values_of_continuous_states_changed: states,
            next_event_time_defined: defined,
            next_event_time: time,
        },
    )
}

/// `fmi3GetVariableDependencies`.
fn dependencies(instance: &Instance, dependent: u32) -> Result<Vec<VariableDependency>, Status> {
    let mut n = 0;
    let status = called!(instance, fmi3GetNumberOfVariableDependencies, dependent, &raw mut n);
    result(status, ())?;
    let (mut elements, mut of) = (vec![0; n], vec![0; n]);
    let (mut independents, mut kinds) = (vec![0; n], vec![0; n]);
    let status = called!(
        instance,
        fmi3GetVariableDependencies,
        dependent,
        elements.as_mut_ptr(),
        independents.as_mut_ptr(),
        of.as_mut_ptr(),
        kinds.as_mut_ptr(),
        n
    );
    result(status, ())?;
    let one = |i: usize| VariableDependency {
        dependent_value_reference: dependent,
        element_index_of_dependent: elements[i] as u32,
        independent_value_reference: independents[i],
        element_index_of_independent: of[i] as u32,
        kind: kind_of(kinds[i]),
    };
    Ok((0..n).map(one).collect())
}

/// `fmi3GetOutputDerivatives`.
fn output_derivatives(instance: &Instance, requests: &[(u32, u32)]) -> Result<Vec<f64>, Status> {
    let references: Vec<u32> = requests.iter().map(|own| own.0).collect();
    let orders: Vec<i32> = requests.iter().map(|own| i32::try_from(own.1).unwrap_or(i32::MAX)).collect();
    let n = requests.len();
    values(n, |to| {
        called!(instance, fmi3GetOutputDerivatives, references.as_ptr(), n, orders.as_ptr(), to, n)
    })
}

/// A number that a C function writes.
fn count(write: impl FnOnce(*mut usize) -> i32) -> Result<u64, Status> {
    let mut n = 0;
    result(write(&raw mut n), n as u64).map(|_| n as u64)
}

/// The functions that both interface types have.
macro_rules! common {
    () => {
        fn set_debug_logging(&self, logging_on: bool, categories: Vec<String>) -> Status {
            let all = categories.into_iter().map(|name| std::ffi::CString::new(name).unwrap_or_default());
            let all: Vec<_> = all.collect();
            let pointers: Vec<_> = all.iter().map(|name| name.as_ptr()).collect();
            let (on, n) = (logging_on.into(), pointers.len());
            status_of(called!(self.0, fmi3SetDebugLogging, on, n, pointers.as_ptr()))
        }

        fn enter_initialization_mode(&self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Status {
            let [has_tolerance, has_stop] = [tolerance, stop].map(|own| own.is_some().into());
            let [tolerance, stop] = [tolerance, stop].map(Option::unwrap_or_default);
            let initial = called!(
                self.0,
                fmi3EnterInitializationMode,
                has_tolerance,
                tolerance,
                start,
                has_stop,
                stop
            );
            status_of(initial)
        }

        common!(plain:
            exit_initialization_mode fmi3ExitInitializationMode, enter_event_mode fmi3EnterEventMode,
            terminate fmi3Terminate, reset fmi3Reset, enter_step_mode fmi3EnterStepMode,
            enter_configuration_mode fmi3EnterConfigurationMode,
            exit_configuration_mode fmi3ExitConfigurationMode,
            evaluate_discrete_states fmi3EvaluateDiscreteStates);

        fn update_discrete_states(&self) -> Result<DiscreteStatesInfo, Status> {
            update_discrete_states(&self.0)
        }

        common!(values:
            get_float32 set_float32 f32 fmi3GetFloat32 fmi3SetFloat32,
            get_float64 set_float64 f64 fmi3GetFloat64 fmi3SetFloat64,
            get_int8 set_int8 i8 fmi3GetInt8 fmi3SetInt8,
            get_int16 set_int16 i16 fmi3GetInt16 fmi3SetInt16,
            get_int32 set_int32 i32 fmi3GetInt32 fmi3SetInt32,
            get_int64 set_int64 i64 fmi3GetInt64 fmi3SetInt64,
            get_uint8 set_uint8 u8 fmi3GetUInt8 fmi3SetUInt8,
            get_uint16 set_uint16 u16 fmi3GetUInt16 fmi3SetUInt16,
            get_uint32 set_uint32 u32 fmi3GetUInt32 fmi3SetUInt32,
            get_uint64 set_uint64 u64 fmi3GetUInt64 fmi3SetUInt64,
            get_boolean set_boolean bool fmi3GetBoolean fmi3SetBoolean);

        /// No variable is a text: any reference is an error.
        fn get_string(&self, references: Vec<u32>) -> Result<Vec<String>, Status> {
            let n = references.len();
            let mut none = vec![ptr::null(); n];
            let status = called!(self.0, fmi3GetString, references.as_ptr(), n, none.as_mut_ptr(), n);
            result(status, Vec::new())
        }

        fn set_string(&self, references: Vec<u32>, _: Vec<String>) -> Status {
            let n = references.len();
            let empty = vec![c"".as_ptr(); n];
            status_of(called!(self.0, fmi3SetString, references.as_ptr(), n, empty.as_ptr(), n))
        }

        /// No variable is binary: any reference is an error.
        fn get_binary(&self, references: Vec<u32>) -> Result<Vec<Vec<u8>>, Status> {
            let n = references.len();
            let (mut sizes, mut none) = (vec![0; n], vec![ptr::null(); n]);
            let (sizes, none) = (sizes.as_mut_ptr(), none.as_mut_ptr());
            result(called!(self.0, fmi3GetBinary, references.as_ptr(), n, sizes, none, n), Vec::new())
        }

        fn set_binary(&self, references: Vec<u32>, _: Vec<Vec<u8>>) -> Status {
            let n = references.len();
            let (sizes, empty) = (vec![0; n], vec![ptr::null(); n]);
            let (sizes, empty) = (sizes.as_ptr(), empty.as_ptr());
            status_of(called!(self.0, fmi3SetBinary, references.as_ptr(), n, sizes, empty, n))
        }

        fn get_clock(&self, references: Vec<u32>) -> Result<Vec<bool>, Status> {
            let n = references.len();
            values(n, |to| called!(self.0, fmi3GetClock, references.as_ptr(), n, to))
        }

        fn set_clock(&self, references: Vec<u32>, values: Vec<bool>) -> Status {
            let (n, values) = (references.len().min(values.len()), c_values(values));
            status_of(called!(self.0, fmi3SetClock, references.as_ptr(), n, values.as_ptr()))
        }

        fn get_number_of_variable_dependencies(&self, dependent: u32) -> Result<u64, Status> {
            count(|to| called!(self.0, fmi3GetNumberOfVariableDependencies, dependent, to))
        }

        fn get_variable_dependencies(&self, dependent: u32) -> Result<Vec<VariableDependency>, Status> {
            dependencies(&self.0, dependent)
        }

        fn get_fmu_state(&self) -> Result<Vec<u8>, Status> {
            saved(&self.0)
        }

        fn set_fmu_state(&self, state: Vec<u8>) -> Status {
            restore(&self.0, &state)
        }

        common!(derivatives:
            get_directional_derivative fmi3GetDirectionalDerivative true,
            get_adjoint_derivative fmi3GetAdjointDerivative false);

        fn get_interval_decimal(&self, references: Vec<u32>) -> Result<Vec<(f64, IntervalQualifier)>, Status> {
            let (r, n) = (references.as_ptr(), references.len());
            let (mut intervals, mut kinds) = (vec![0.0; n], vec![0; n]);
            let to = (intervals.as_mut_ptr(), kinds.as_mut_ptr());
            result(called!(self.0, fmi3GetIntervalDecimal, r, n, to.0, to.1), ())?;
            Ok(intervals.into_iter().zip(kinds).map(|(own, kind)| (own, qualifier_of(kind))).collect())
        }

        fn get_interval_fraction(
            &self,
            references: Vec<u32>,
        ) -> Result<Vec<(IntervalFraction, IntervalQualifier)>, Status> {
            let (r, n) = (references.as_ptr(), references.len());
            let (mut counters, mut resolutions, mut kinds) = (vec![0; n], vec![0; n], vec![0; n]);
            let to = (counters.as_mut_ptr(), resolutions.as_mut_ptr(), kinds.as_mut_ptr());
            result(called!(self.0, fmi3GetIntervalFraction, r, n, to.0, to.1, to.2), ())?;
            let fractions = counters.iter().zip(&resolutions).map(fraction_of);
            Ok(fractions.zip(kinds).map(|(own, kind)| (own, qualifier_of(kind))).collect())
        }

        fn get_shift_decimal(&self, references: Vec<u32>) -> Result<Vec<f64>, Status> {
            let n = references.len();
            values(n, |to| called!(self.0, fmi3GetShiftDecimal, references.as_ptr(), n, to))
        }

        fn get_shift_fraction(&self, references: Vec<u32>) -> Result<Vec<IntervalFraction>, Status> {
            let (r, n) = (references.as_ptr(), references.len());
            let (mut counters, mut resolutions) = (vec![0; n], vec![0; n]);
            let to = (counters.as_mut_ptr(), resolutions.as_mut_ptr());
            result(called!(self.0, fmi3GetShiftFraction, r, n, to.0, to.1), ())?;
            Ok(counters.iter().zip(&resolutions).map(fraction_of).collect())
        }

        common!(times:
            set_interval_decimal fmi3SetIntervalDecimal set_interval_fraction fmi3SetIntervalFraction,
            set_shift_decimal fmi3SetShiftDecimal set_shift_fraction fmi3SetShiftFraction);

        fn get_output_derivatives(&self, requests: Vec<(u32, u32)>) -> Result<Vec<f64>, Status> {
            output_derivatives(&self.0, &requests)
        }
    };
    (plain: $($name:ident $function:ident),*) => {$(
        fn $name(&self) -> Status {
            status_of(called!(self.0, $function))
        }
    )*};
    (values: $($get:ident $set:ident $type:ident $c_get:ident $c_set:ident),*) => {$(
        fn $get(&self, references: Vec<u32>) -> Result<Vec<$type>, Status> {
            let n = references.len();
            values(n, |to| called!(self.0, $c_get, references.as_ptr(), n, to, n))
        }

        fn $set(&self, references: Vec<u32>, values: Vec<$type>) -> Status {
            let (r, n, values) = (references.as_ptr(), references.len(), c_values(values));
            status_of(called!(self.0, $c_set, r, n, values.as_ptr(), values.len()))
        }
    )*};
    (derivatives: $($name:ident $function:ident $is_forward:literal),*) => {$(
        fn $name(&self, unknowns: Vec<u32>, knowns: Vec<u32>, seed: Vec<f64>) -> Result<Vec<f64>, Status> {
            let [u, k] = [&unknowns, &knowns].map(|own| (own.as_ptr(), own.len()));
            let (s, n) = ((seed.as_ptr(), seed.len()), if $is_forward { u.1 } else { k.1 });
            values(n, |to| called!(self.0, $function, u.0, u.1, k.0, k.1, s.0, s.1, to, n))
        }
    )*};
    (times: $($decimal:ident $c_decimal:ident $fraction:ident $c_fraction:ident),*) => {$(
        fn $decimal(&self, references: Vec<u32>, values: Vec<f64>) -> Status {
            let n = references.len().min(values.len());
            status_of(called!(self.0, $c_decimal, references.as_ptr(), n, values.as_ptr()))
        }

        fn $fraction(&self, references: Vec<u32>, values: Vec<IntervalFraction>) -> Status {
            let (n, [a, b]) = (references.len().min(values.len()), parts_of(&values));
            status_of(called!(self.0, $c_fraction, references.as_ptr(), n, a.as_ptr(), b.as_ptr()))
        }
    )*};
}

impl co_simulation::GuestCoSimulationInstance for CoSimulation {
    fn instantiate_co_simulation(
        name: String,
        token: String,
        visible: bool,
        logging_on: bool,
        event_mode_used: bool,
        early_return_allowed: bool,
        required: Vec<u32>,
    ) -> Option<co_simulation::CoSimulationInstance> {
        let asked = Asked { name, token, flags: [visible, logging_on] };
        let steps = Some((event_mode_used, early_return_allowed, required));
        Some(co_simulation::CoSimulationInstance::new(Self(Instance::new(asked, steps)?)))
    }

    common!();

    fn set_input_derivatives(&self, _: Vec<(u32, u32)>, _: Vec<f64>) -> Status {
        self.0.refuse("set-input-derivatives")
    }

    fn do_step(
        &self,
        point: f64,
        size: f64,
        no_set_state: bool,
    ) -> Result<co_simulation::DoStepResult, Status> {
        let (mut flags, mut time) = ([0u8; 3], 0.0);
        let [needed, ends, early] = flags.each_mut().map(ptr::from_mut);
        let no_set_state = no_set_state.into();
        let status =
            called!(self.0, fmi3DoStep, point, size, no_set_state, needed, ends, early, &raw mut time);
        let [needed, ends, early] = flags.map(|flag| flag != 0);
        result(
            status,
            co_simulation::DoStepResult {
                last_successful_time: time,
                event_handling_needed: needed,
                terminate_simulation: ends,
                early_return: early,
            },
        )
    }
}

impl model_exchange::GuestModelExchangeInstance for ModelExchange {
    fn instantiate_model_exchange(
        name: String,
        token: String,
        visible: bool,
        logging_on: bool,
    ) -> Option<model_exchange::ModelExchangeInstance> {
        let asked = Asked { name, token, flags: [visible, logging_on] };
        Some(model_exchange::ModelExchangeInstance::new(Self(Instance::new(asked, None)?)))
    }

    common!();

    fn enter_continuous_time_mode(&self) -> Status {
        status_of(called!(self.0, fmi3EnterContinuousTimeMode))
    }

    fn set_time(&self, time: f64) -> Status {
        status_of(called!(self.0, fmi3SetTime, time))
    }

    fn set_continuous_states(&self, states: Vec<f64>) -> Status {
        status_of(called!(self.0, fmi3SetContinuousStates, states.as_ptr(), states.len()))
    }

    fn get_continuous_state_derivatives(&self) -> Result<Vec<f64>, Status> {
        self.states(|to, n| called!(self.0, fmi3GetContinuousStateDerivatives, to, n))
    }

    fn get_continuous_states(&self) -> Result<Vec<f64>, Status> {
        self.states(|to, n| called!(self.0, fmi3GetContinuousStates, to, n))
    }

    fn get_nominals_of_continuous_states(&self) -> Result<Vec<f64>, Status> {
        self.states(|to, n| called!(self.0, fmi3GetNominalsOfContinuousStates, to, n))
    }

    fn get_event_indicators(&self) -> Result<Vec<f64>, Status> {
        let n = self.get_number_of_event_indicators()? as usize;
        values(n, |to| called!(self.0, fmi3GetEventIndicators, to, n))
    }

    fn get_number_of_event_indicators(&self) -> Result<u64, Status> {
        count(|to| called!(self.0, fmi3GetNumberOfEventIndicators, to))
    }

    fn get_number_of_continuous_states(&self) -> Result<u64, Status> {
        count(|to| called!(self.0, fmi3GetNumberOfContinuousStates, to))
    }

    fn completed_integrator_step(
        &self,
        no_set_state: bool,
    ) -> Result<model_exchange::CompletedStepResult, Status> {
        let mut flags = [0u8; 2];
        let [event, ends] = flags.each_mut().map(ptr::from_mut);
        let status = called!(self.0, fmi3CompletedIntegratorStep, no_set_state.into(), event, ends);
        let [enter_event_mode, terminate_simulation] = flags.map(|flag| flag != 0);
        result(status, model_exchange::CompletedStepResult { enter_event_mode, terminate_simulation })
    }
}

impl ModelExchange {
    /// An array with a number for each continuous state.
    fn states(&self, write: impl FnOnce(*mut f64, usize) -> i32) -> Result<Vec<f64>, Status> {
        let n = model_exchange::GuestModelExchangeInstance::get_number_of_continuous_states(self)? as usize;
        values(n, |to| write(to, n))
    }
}
