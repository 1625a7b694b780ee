//! A warning if a host has set only some of the machine's parameters: the others keep the start
//! values of another machine.

use vibro_impact::parameters::{FIELDS, Parameters};

/// The parameters that determine a machine's scales of mass, time and length. A host that changes
/// one of them describes another machine.
const SCALES: [&str; 3] = ["box.m", "box.k", "stop.gap"];
/// Parameters that need not be set with the others: they are dimensionless or angles.
const FREE: [&str; 2] = ["stop.restitution", "drive.phase"];

/// The warning if a scale was changed but other parameters with a dimension were not set; `None`
/// if all of them were set. The parameters of an uncoupled secondary oscillator and the frequency
/// of a drive without force are not required.
pub(super) fn half_a_machine(parameters: &Parameters, given: u16) -> Option<String> {
    let standard = Parameters::default();
    let scaled = FIELDS.iter().any(|f| SCALES.contains(&f.name) && (f.get)(parameters) != (f.get)(&standard));
    let uncoupled = parameters.coupling_stiffness == 0.0;
    let still = parameters.drive_amplitude == 0.0;
    let idle = |name: &str| uncoupled && name.starts_with("secondary.") || still && name == "drive.frequency";
    let asked = |name: &str| !FREE.contains(&name) && !idle(name);
    let missing = FIELDS.iter().enumerate().filter(|(i, f)| given & (1 << i) == 0 && asked(f.name));
    let missing: Vec<_> =
        missing.map(|(_, f)| format!("{} = {} {}", f.name, (f.get)(parameters), f.unit)).collect();
    (scaled && !missing.is_empty()).then(|| {
        format!(
            "only a part of the machine was set; start values of another machine, a reconstruction \
             of 1 kg, 1 N/m and 1 m, remain for \
             {}: set them too",
            missing.join(", ")
        )
    })
}
