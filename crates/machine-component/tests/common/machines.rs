//! Machines for random calls by tests and fuzzers. Users of this module also include the calls
//! (`calls`) and the exported functions of the library (`component`).

use super::calls::{Random, Target, run_fmi2, run_fmi3};
use std::ffi::CString;
use std::path::Path;
use vibro_machine::file;
use vibro_machine_component::{FILE, Plan};

/// Largest number of calls for one fuzzer input.
const CALLS: usize = 64;

/// Returns the machines, each without and with arrays; writes the files of their resources to this
/// folder.
pub fn machines(folder: &Path) -> Vec<Target> {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().find_map(|above| {
        let examples = above.join("examples/assembly");
        examples.is_dir().then_some(examples)
    });
    let examples = examples.expect("the folder of examples");
    let text = |name: &&str| file::read(&examples.join(name)).expect("an example").to_toml();
    let names =
        ["damper_with_buffer.toml", "bouncing_ball.toml", "gear_backlash.toml", "msl_coupled_clutches.toml"];
    let own = [
        include_str!("everything.toml"),
        include_str!("../../../machine/tests/data/laws.toml"),
        include_str!("formulas.toml"),
    ];
    let texts = names.iter().map(text).chain(own.map(str::to_owned));
    let target = |(text, arrays): (String, bool)| {
        let plan = Plan::new(text, FILE).expect("a machine");
        let folder = folder.join(plan.name());
        std::fs::create_dir_all(&folder).expect("a folder for such files");
        std::fs::write(folder.join(FILE), plan.text()).expect("a file there");
        let plan = if arrays { plan.with_arrays() } else { plan };
        Target {
            token: CString::new(plan.token()).expect("no null byte"),
            resources: Some(CString::new(folder.to_str().expect("UTF-8")).expect("no null byte")),
            references: plan.table.rows.len() as u64 + 3,
            input: plan.table.inputs.first().copied(),
        }
    };
    texts.flat_map(|text| [(text.clone(), false), (text, true)]).map(target).collect()
}

/// Runs a fuzzer input: the first byte chooses the machine and its use, the other bytes choose
/// calls and arguments.
pub fn run(machines: &[Target], bytes: &[u8]) {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let (place, way) = (usize::from(*kind) % (machines.len() / 2), *kind / 8 % 5);
    let mut random = Random { bytes, seed: u64::from(*kind) };
    match way {
        // FMI 2.0 has no arrays.
        0 | 1 => run_fmi2(&machines[2 * place], &mut random, i32::from(way), CALLS),
        2 => run_fmi3(&machines[2 * place], &mut random, true, false, CALLS),
        3 => run_fmi3(&machines[2 * place + 1], &mut random, false, true, CALLS),
        _ => run_fmi3(&machines[2 * place + 1], &mut random, false, false, CALLS),
    }
}
