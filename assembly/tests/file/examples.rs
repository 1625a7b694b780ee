//! The examples are machines.

use std::path::Path;
use vibro_assembly::file::{no_records, parse, read};

/// Each example is read, names its reference, and is written so that it reads back equal.
#[test]
fn invariant_every_example_is_a_machine() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/assembly");
    let files =
        std::fs::read_dir(folder).expect("the folder is there").map(|entry| entry.expect("an entry").path());
    let mut names = Vec::new();
    for file in files.filter(|file| file.extension().is_some_and(|e| e == "toml")) {
        let machine = read(&file).unwrap_or_else(|refusal| panic!("{refusal}"));
        let text = std::fs::read_to_string(&file).expect("it was read before");
        assert!(
            text.starts_with('#') && text.contains("# Held against: "),
            "{} says nothing of itself",
            file.display()
        );
        assert_eq!(
            parse(&machine.to_toml(), "written.toml", &no_records).as_ref(),
            Ok(&machine),
            "{}",
            file.display()
        );
        names.push(machine.name);
    }
    let all = names.len();
    names.sort();
    names.dedup();
    assert_eq!((names.len(), all >= 31), (all, true), "each example has a name of its own");
}

/// The machines on the grammar's page are read as they stand there.
#[test]
fn golden_machines_of_the_page_are_machines() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/assemblies.md");
    let page = std::fs::read_to_string(page).expect("the page is there");
    let blocks: Vec<_> =
        page.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    let machines: Vec<_> = blocks.into_iter().filter(|block| block.contains("name = ")).collect();
    assert!(machines.len() >= 3);
    for machine in machines {
        let read = parse(machine, "docs/assemblies.md", &no_records);
        assert!(read.is_ok(), "{}\n{machine}", read.unwrap_err());
    }
}
