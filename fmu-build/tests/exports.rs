//! The packaged binary exports the functions of FMI 2.0 and nothing else.

use fmu_build::compile;
use object::Object;
use std::collections::BTreeSet;

/// Every function of FMI 2.0 (2.1, 3.2, 4.2), each with the prefix `fmi2`. Hosts load them all by name, whatever the
/// capabilities say.
const FUNCTIONS: &str = "GetTypesPlatform GetVersion SetDebugLogging Instantiate FreeInstance SetupExperiment \
    EnterInitializationMode ExitInitializationMode Terminate Reset \
    GetReal GetInteger GetBoolean GetString SetReal SetInteger SetBoolean SetString \
    GetFMUstate SetFMUstate FreeFMUstate SerializedFMUstateSize SerializeFMUstate DeSerializeFMUstate \
    GetDirectionalDerivative \
    EnterEventMode NewDiscreteStates EnterContinuousTimeMode CompletedIntegratorStep SetTime SetContinuousStates \
    GetDerivatives GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates \
    SetRealInputDerivatives GetRealOutputDerivatives DoStep CancelStep \
    GetStatus GetRealStatus GetIntegerStatus GetBooleanStatus GetStringStatus";

#[test]
fn exports_are_the_functions_of_fmi2() {
    let bytes = std::fs::read(compile::library().unwrap()).unwrap();
    let binary = object::File::parse(&*bytes).unwrap();
    let exported: BTreeSet<String> = binary
        .exports()
        .unwrap()
        .map(|export| {
            let name = export.unwrap().into_name().into_name().expect("exported by name, not by number");
            String::from_utf8_lossy(&name).into_owned()
        })
        // Mach-O puts an underscore before C names.
        .map(|name| name.strip_prefix("_fmi2").map_or(name.clone(), |rest| format!("fmi2{rest}")))
        .collect();
    let standard: BTreeSet<String> = FUNCTIONS.split_whitespace().map(|name| format!("fmi2{name}")).collect();
    assert_eq!(exported, standard);
}
