//! The C interfaces of described machines: the first byte chooses the machine and how it is used, the others calls and arguments.
#![no_main]
#![allow(missing_docs)]

#[path = "../../../doors/tests/common/calls.rs"]
mod calls;

/// The functions that the library of described machines exports.
mod component {
    use vibro_assembly_fmi::Machine;

    fmi_doors::export!(Machine);
}

use calls::{Random, Target, run_fmi2, run_fmi3};
use libfuzzer_sys::fuzz_target;
use std::ffi::CString;
use std::path::Path;
use std::sync::LazyLock;
use vibro_assembly::file;
use vibro_assembly_fmi::{FILE, Plan};

/// Calls a run, more than the bytes of most inputs choose.
const CALLS: usize = 64;

/// Every kind of element and of signal, with inputs of all four kinds.
const EVERYTHING: &str = r#"name = "Everything"
gravity = 9.81
[body.table]
motion = { amplitude = 0.01, frequency = 3.0, input = true }
[body.box]
mass = 3.0
[body.block]
mass = 0.5
gravity = 1.0
start = { s = 0.1, v = 1.0 }
[body.wheel]
inertia = 0.2
[body.drum]
inertia = 0.1
[spring.mount]
between = ["table", "box"]
stiffness = 40.0
damping = 0.5
[stop.upper]
between = ["box", "block"]
gap = 0.4
restitution = 0.6
[stop.lower]
between = ["block", "box"]
gap = 0.3
stiffness = 2e3
damping = 4.0
[stop.rubber]
between = ["box", "ground"]
gap = 0.2
stiffness = 1e3
damping = 9.0
law = "elastogap"
[friction.guide]
between = ["box", "block"]
force = { constant = 0.2, input = true }
static = { constant = 0.3, input = true }
[spring.rack]
arms = { box = "1", wheel = "-50 mm" }
stiffness = 500.0
[link.gear]
arms = { wheel = 1.0, drum = -3.0 }
[load.push]
on = "box"
input = true
steps = [[0.3, 2.0]]
table = [[0.0, 0.0], [0.5, 1.0], [2.0, -1.0]]
interpolation = "cubic"
"#;

/// The machines, each with the folder of its resources in the system's folder for such files.
static MACHINES: LazyLock<Vec<Target>> = LazyLock::new(|| {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly");
    let text = |name: &str| file::read(&examples.join(name)).expect("an example").to_toml();
    let names = ["damper_with_buffer.toml", "bouncing_ball.toml", "gear_backlash.toml", "msl_coupled_clutches.toml"];
    let texts = names.into_iter().map(text).chain([EVERYTHING.to_owned()]);
    let target = |text: String| {
        let plan = Plan::new(text, FILE).expect("a machine");
        let folder = std::env::temp_dir().join(format!("vibro-fuzz-{}-{}", plan.name(), std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for such files");
        std::fs::write(folder.join(FILE), plan.text()).expect("a file there");
        Target {
            token: CString::new(plan.token()).expect("no null byte"),
            resources: Some(CString::new(folder.to_str().expect("UTF-8")).expect("no null byte")),
            references: plan.table.rows.len() as u64 + 3,
            input: plan.table.inputs.first().copied(),
        }
    };
    texts.map(target).collect()
});

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let (kind, way) = (usize::from(*kind), *kind / 8 % 5);
    let machine = &MACHINES[kind % MACHINES.len()];
    let mut random = Random { bytes, seed: kind as u64 };
    match way {
        0 | 1 => run_fmi2(machine, &mut random, i32::from(way), CALLS),
        other => run_fmi3(machine, &mut random, other == 2, other == 3, CALLS),
    }
});
