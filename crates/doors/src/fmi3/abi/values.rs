//! Getting and setting variables, their dependencies and derivatives (FMI 3.0.2, 2.2.7 to 2.2.12).

/// The functions of values, for `export_fmi3!`.
#[doc(hidden)]
#[macro_export]
macro_rules! __values_of_fmi3 {
    ($component:ty) => {
        $crate::__functions_of_fmi3! {
            $component;
            "2.2.7.2":
            /// Fails for any reference, since no variable has this type. This holds for all such
            /// types below.
            fmi3GetFloat32, GetFloat32(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                out values: f32[nValues], value nValues: usize)
                |instance, _| instance.get_any($crate::fmi3::instance::none("Float32"), valueReferences, nValues, &mut |_, _| ());
            fmi3GetFloat64, GetFloat64(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                out values: f64[nValues], value nValues: usize)
                |instance, _| instance.get($crate::fmi3::instance::FLOAT64, valueReferences, nValues, |i, x| values.put(i, x));
            fmi3GetInt8, GetInt8(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                out values: i8[nValues], value nValues: usize)
                |instance, _| instance.get_any($crate::fmi3::instance::none("Int8"), valueReferences, nValues, &mut |_, _| ());
            fmi3GetUInt8, GetUInt8(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                out values: u8[nValues], value nValues: usize)
                |instance, _| instance.get_any($crate::fmi3::instance::none("UInt8"), valueReferences, nValues, &mut |_, _| ());
            fmi3GetInt16, GetInt16(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                out values: i16[nValues], value nValues: usize)
                |instance, _| instance.get_any($crate::fmi3::instance::none("Int16"), valueReferences, nValues, &mut |_, _| ());
            fmi3GetUInt16, GetUInt16(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                out values: u16[nValues], value nValues: usize)
                |instance, _| instance.get_any($crate::fmi3::instance::none("UInt16"), valueReferences, nValues, &mut |_, _| ());
            fmi3GetInt32, GetInt32(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                out values: i32[nValues], value nValues: usize)
                |instance, _| instance.get_any($crate::fmi3::instance::INT32, valueReferences, nValues, &mut |i, x| values.put(i, x as i32));
            fmi3GetUInt32, GetUInt32(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                out values: u32[nValues], value nValues: usize)
                |instance, _| instance.get_any($crate::fmi3::instance::none("UInt32"), valueReferences, nValues, &mut |_, _| ());
            /// Enumerations.
            fmi3GetInt64, GetInt64(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                out values: i64[nValues], value nValues: usize)
                |instance, _| instance.get_any($crate::fmi3::instance::INT64, valueReferences, nValues, &mut |i, x| values.put(i, x as i64));
            fmi3GetUInt64, GetUInt64(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                out values: u64[nValues], value nValues: usize)
                |instance, _| instance.get_any($crate::fmi3::instance::none("UInt64"), valueReferences, nValues, &mut |_, _| ());
            fmi3GetBoolean, GetBoolean(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                out values: $crate::fmi3::types::FmiBoolean[nValues], value nValues: usize)
                |instance, _| instance.get_any($crate::fmi3::instance::BOOLEAN, valueReferences, nValues, &mut |i, x| values.put(i, (x != 0.0).into()));
            fmi3GetString, GetString(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                out values: *const ::core::ffi::c_char[nValues], value nValues: usize)
                |instance, _| instance.get_any($crate::fmi3::instance::none("String"), valueReferences, nValues, &mut |_, _| ());
            fmi3GetBinary, GetBinary(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                out valueSizes: usize[nValues], out values: *const u8[nValues], value nValues: usize)
                |instance, _| instance.get_any($crate::fmi3::instance::none("Binary"), valueReferences, nValues, &mut |_, _| ());

            "2.2.8.4":
            fmi3GetClock, GetClock(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                out values: $crate::fmi3::types::FmiBoolean[nValueReferences])
                |instance, _| instance.get_any($crate::fmi3::instance::CLOCK, valueReferences, nValueReferences, &mut |i, x| values.put(i, (x != 0.0).into()));

            "2.2.7.2":
            fmi3SetFloat32, SetFloat32(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                array values: f32[nValues], value nValues: usize)
                |instance, _| instance.set_any($crate::fmi3::instance::none("Float32"), valueReferences, nValues, &|_| 0.0);
            fmi3SetFloat64, SetFloat64(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                array values: f64[nValues], value nValues: usize)
                |instance, _| instance.set($crate::fmi3::instance::FLOAT64, valueReferences, nValues, |i| values[i]);
            fmi3SetInt8, SetInt8(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                array values: i8[nValues], value nValues: usize)
                |instance, _| instance.set_any($crate::fmi3::instance::none("Int8"), valueReferences, nValues, &|_| 0.0);
            fmi3SetUInt8, SetUInt8(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                array values: u8[nValues], value nValues: usize)
                |instance, _| instance.set_any($crate::fmi3::instance::none("UInt8"), valueReferences, nValues, &|_| 0.0);
            fmi3SetInt16, SetInt16(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                array values: i16[nValues], value nValues: usize)
                |instance, _| instance.set_any($crate::fmi3::instance::none("Int16"), valueReferences, nValues, &|_| 0.0);
            fmi3SetUInt16, SetUInt16(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                array values: u16[nValues], value nValues: usize)
                |instance, _| instance.set_any($crate::fmi3::instance::none("UInt16"), valueReferences, nValues, &|_| 0.0);
            fmi3SetInt32, SetInt32(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                array values: i32[nValues], value nValues: usize)
                |instance, _| instance.set_any($crate::fmi3::instance::INT32, valueReferences, nValues, &|i| values[i].into());
            fmi3SetUInt32, SetUInt32(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                array values: u32[nValues], value nValues: usize)
                |instance, _| instance.set_any($crate::fmi3::instance::none("UInt32"), valueReferences, nValues, &|_| 0.0);
            /// Enumerations.
            fmi3SetInt64, SetInt64(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                array values: i64[nValues], value nValues: usize)
                |instance, _| instance.set_any($crate::fmi3::instance::INT64, valueReferences, nValues, &|i| values[i] as f64);
            fmi3SetUInt64, SetUInt64(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                array values: u64[nValues], value nValues: usize)
                |instance, _| instance.set_any($crate::fmi3::instance::none("UInt64"), valueReferences, nValues, &|_| 0.0);
            fmi3SetBoolean, SetBoolean(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                array values: $crate::fmi3::types::FmiBoolean[nValues], value nValues: usize)
                |instance, _| instance.set_any($crate::fmi3::instance::BOOLEAN, valueReferences, nValues, &|i| f64::from(values[i] != 0));
            fmi3SetString, SetString(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                array values: *const ::core::ffi::c_char[nValues], value nValues: usize)
                |instance, _| instance.set_any($crate::fmi3::instance::none("String"), valueReferences, nValues, &|_| 0.0);
            fmi3SetBinary, SetBinary(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                array valueSizes: usize[nValues], array values: *const u8[nValues], value nValues: usize)
                |instance, _| instance.set_any($crate::fmi3::instance::none("Binary"), valueReferences, nValues, &|_| 0.0);

            "2.2.8.4":
            /// Fails for any reference, since no variable is an input clock.
            fmi3SetClock, SetClock(array valueReferences: u32[nValueReferences], value nValueReferences: usize,
                array values: $crate::fmi3::types::FmiBoolean[nValueReferences])
                |instance, _| instance.set_any($crate::fmi3::instance::none("input Clock"), valueReferences, nValueReferences, &|_| 0.0);

            "2.2.9":
            fmi3GetNumberOfVariableDependencies, GetNumberOfVariableDependencies(value valueReference: u32,
                out nDependencies: usize[1])
                |instance, _| nDependencies.give(instance.dependencies(valueReference).map(|list| list.len()));
            /// Independent variables are scalars, with the element index 0.
            fmi3GetVariableDependencies, GetVariableDependencies(value dependent: u32,
                out elementIndicesOfDependent: usize[nDependencies], out independents: u32[nDependencies],
                out elementIndicesOfIndependents: usize[nDependencies], out dependencyKinds: $crate::fmi3::types::FmiDependencyKind[nDependencies],
                value nDependencies: usize)
                |instance, _| {
                    let list = instance.dependencies_counted(dependent, nDependencies)?;
                    for (i, entry) in list.into_iter().enumerate() {
                        elementIndicesOfDependent.put(i, entry.element);
                        independents.put(i, entry.reference);
                        elementIndicesOfIndependents.put(i, 0);
                        dependencyKinds.put(i, $crate::fmi3::types::dependency_kind(entry.kind));
                    }
                    instance.never()
                };

            "2.2.12":
            fmi3GetDirectionalDerivative, GetDirectionalDerivative(
                array unknowns: u32[nUnknowns], value nUnknowns: usize, array knowns: u32[nKnowns], value nKnowns: usize,
                array seed: f64[nSeed], value nSeed: usize, out sensitivity: f64[nSensitivity], value nSensitivity: usize)
                |instance, _| instance.directional_derivative(
                    (unknowns, knowns), (seed, nSensitivity), |i, x| sensitivity.put(i, x));
            fmi3GetAdjointDerivative, GetAdjointDerivative(
                array unknowns: u32[nUnknowns], value nUnknowns: usize, array knowns: u32[nKnowns], value nKnowns: usize,
                array seed: f64[nSeed], value nSeed: usize, out sensitivity: f64[nSensitivity], value nSensitivity: usize)
                |instance, _| instance.adjoint_derivative(
                    (unknowns, knowns), (seed, nSensitivity), |i, x| sensitivity.put(i, x));

            "2.2.8":
            /// Always refused, since no variable is an input clock. This holds for all functions
            /// of intervals and shifts below.
            fmi3GetIntervalDecimal, GetIntervalDecimal(array valueReferences: u32[nValueReferences],
                value nValueReferences: usize, out intervals: f64[nValueReferences],
                out qualifiers: $crate::fmi3::types::FmiIntervalQualifier[nValueReferences])
                |instance, _| instance.never();
            fmi3GetIntervalFraction, GetIntervalFraction(array valueReferences: u32[nValueReferences],
                value nValueReferences: usize, out counters: u64[nValueReferences], out resolutions: u64[nValueReferences],
                out qualifiers: $crate::fmi3::types::FmiIntervalQualifier[nValueReferences])
                |instance, _| instance.never();
            fmi3GetShiftDecimal, GetShiftDecimal(array valueReferences: u32[nValueReferences],
                value nValueReferences: usize, out shifts: f64[nValueReferences])
                |instance, _| instance.never();
            fmi3GetShiftFraction, GetShiftFraction(array valueReferences: u32[nValueReferences],
                value nValueReferences: usize, out counters: u64[nValueReferences], out resolutions: u64[nValueReferences])
                |instance, _| instance.never();
            fmi3SetIntervalDecimal, SetIntervalDecimal(array valueReferences: u32[nValueReferences],
                value nValueReferences: usize, array intervals: f64[nValueReferences])
                |instance, _| instance.never();
            fmi3SetIntervalFraction, SetIntervalFraction(array valueReferences: u32[nValueReferences],
                value nValueReferences: usize, array counters: u64[nValueReferences], array resolutions: u64[nValueReferences])
                |instance, _| instance.never();
            fmi3SetShiftDecimal, SetShiftDecimal(array valueReferences: u32[nValueReferences],
                value nValueReferences: usize, array shifts: f64[nValueReferences])
                |instance, _| instance.never();
            fmi3SetShiftFraction, SetShiftFraction(array valueReferences: u32[nValueReferences],
                value nValueReferences: usize, array counters: u64[nValueReferences], array resolutions: u64[nValueReferences])
                |instance, _| instance.never();
        }
    };
}
