//! Machines as components, without the C interface: all examples, and machines with every kind and
//! every law of elements.

mod dependencies;
mod energy;
mod events;
mod forces;
mod instants;
mod lists;
mod named;
mod protocol;
mod samples;
mod signs;
mod solver;

use std::path::Path;
use std::sync::Arc;
use vibro_machine::file;
use vibro_machine_component::{FILE, Plan};

fn plans() -> Vec<Arc<Plan>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly");
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    // The hammer drill begins with all its gaps at zero, where the states of its stops follow from
    // accelerations; its contacts are too stiff for the fixed steps of these solvers.
    let paths = paths.filter(|path| {
        path.extension().is_some_and(|ending| ending == "toml") && !path.ends_with("hammer_drill.toml")
    });
    let examples = paths.map(|path| Plan::of(&file::read(&path).unwrap()).unwrap());
    let texts = [
        include_str!("../common/everything.toml"),
        include_str!("../common/flexible.toml"),
        include_str!("../common/joint.toml"),
        include_str!("../common/contacts.toml"),
        include_str!("../common/box.toml"),
        include_str!("../common/residual.toml"),
        include_str!("../common/freewheels.toml"),
        include_str!("../common/signals.toml"),
        include_str!("../common/stepped.toml"),
        include_str!("../common/blocks.toml"),
        include_str!("../../../machine/tests/data/laws.toml"),
    ];
    examples.chain(texts.map(|text| Plan::new(text.into(), FILE).unwrap())).map(Arc::new).collect()
}
