//! A machine of which a host has set a part: the rest has start values that belong to another
//! machine.

use vibro_impact::parameters::{FIELDS, Parameters};

/// The parameters that give a machine its scales of mass, time and length: who sets another value
/// means another machine.
const SCALES: [&str; 3] = ["box.m", "box.k", "stop.gap"];
/// Parameters without a dimension of length, mass or time to carry over, and what one may leave as
/// it is.
const FREE: [&str; 2] = ["stop.restitution", "drive.phase"];

/// What is to be told of a machine whose scales were set while other parameters were not; nothing
/// where all was set that has a dimension. Of a secondary oscillator that is coupled to nothing
/// nothing is asked, nor of the frequency of a drive without force.
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
            "only a part of the machine was set; start values of another machine, a reconstruction of 1 kg, 1 N/m and 1 m, are left for \
             {}: set them too",
            missing.join(", ")
        )
    })
}
