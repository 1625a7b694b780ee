//! The examples are valid machines.

use std::path::Path;
use vibro_machine::file::{no_records, parse, read};

/// Each example is read, names its reference, and is written so that it reads back equal.
#[test]
fn invariant_every_example_is_a_machine() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly");
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

/// Blocks of TOML on the pages of described machines: blocks with a name are complete machines,
/// other blocks are parts of files.
#[test]
fn golden_machines_of_the_pages_are_machines() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let mut machines = 0;
    for name in ["assemblies.md", "machine-file.md", "machine-studies.md"] {
        let page = std::fs::read_to_string(folder.join(name)).expect("the page is there");
        for block in page.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()) {
            assert!(block.parse::<toml::Table>().is_ok(), "{name}\n{block}");
            if block.starts_with("name = ") {
                let read = parse(block, name, &no_records);
                assert!(read.is_ok(), "{}\n{block}", read.unwrap_err());
                machines += 1;
            }
        }
    }
    assert!(machines >= 4, "{machines}");
}

/// The introductory page takes ten minutes to read, at 220 words per minute for technical text.
#[test]
fn the_page_to_begin_with_stays_short() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/assemblies.md");
    let words = std::fs::read_to_string(page).expect("the page is there").split_whitespace().count();
    assert!(words <= 2200, "{words} words: tables belong on docs/machine-file.md");
}

/// The lines of the table of kinds, together with the bodies that they name, are one machine.
#[test]
fn golden_lines_of_the_table_of_kinds_are_a_machine() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/assemblies.md");
    let page = std::fs::read_to_string(page).expect("the page is there");
    let (_, table) = page.split_once("| kind | meaning |").expect("the table");
    let table = table.split("\n\n").next().expect("its end");
    let lines = table.lines().filter_map(|row| row.rsplit_once("| `")?.1.strip_suffix("` |"));
    let lines: Vec<&str> = lines.filter(|line| line.contains(" = {")).collect();
    assert!(lines.len() >= 10, "{lines:?}");
    let text = format!(
        "name = \"Kinds\"\n{}\nbody.block = {{ mass = 1 }}\nbody.wheel = {{ inertia = 1 }}\nbody.arm = {{ inertia = 1 }}\nbody.rack = {{ mass = 1 }}\nspring.table = {{ between = [\"table\", \"box\"], stiffness = 1 }}",
        lines.join("\n")
    );
    let read = parse(&text, "assemblies.md", &no_records);
    assert!(read.is_ok(), "{}\n{text}", read.unwrap_err());
}
