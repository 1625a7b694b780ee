//! Runs the real `vibro new` and `vibro fmu`.

#[path = "common/mod.rs"]
mod command;

use command::{drawn, folder, refused};
use std::fs;
use std::process::Command;
use vibro::gallery::EXAMPLES;
use vibro_pack::{Binaries, KIT_FILE, Kit, archive};

#[test]
fn new_writes_every_machine_of_the_gallery_as_it_stands_there_and_overwrites_nothing() {
    let out = folder("new");
    fs::create_dir_all(&out).unwrap();
    let list = drawn(&out, &["new"]);
    let help = drawn(&out, &["new", "--help"]);
    assert!(["damper_with_buffer", "gear_backlash"].iter().all(|name| help.contains(name)), "{help}");
    let page = include_str!("../../../docs/gallery/README.md");
    assert_eq!(EXAMPLES.len(), page.matches("alt=\"sketch\"").count(), "the gallery's machines");
    for example in EXAMPLES {
        assert!(list.contains(example.name) && list.contains(&example.about()), "{list}");
        assert!(example.about().ends_with('.'), "{}: {}", example.name, example.about());
        let path = out.join(format!("{}.toml", example.name));
        let told = drawn(&out, &["new", example.name, &path.display().to_string()]);
        assert!(told.contains(&path.display().to_string()), "{told}");
        assert!(fs::read_to_string(&path).unwrap() == example.text && example.text.starts_with("# "));
        assert!(drawn(&out, &["check", &path.display().to_string()]).contains("degree"), "{}", example.name);
        let (code, told) = refused(&["new", example.name, &path.display().to_string()]);
        assert!(code == 2 && told.contains("exists already and is not overwritten"), "{told}");
    }
    // Without a second name the current folder is used; a record there is not overwritten.
    let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
    assert!(
        vibro.args(["new", "damper_with_buffer"]).current_dir(&out).output().unwrap().status.code()
            == Some(2)
    );
    let (code, told) = refused(&["new", "valve_train", &out.join("other.toml").display().to_string()]);
    assert!(code == 2 && told.contains("cam_lift.csv") && !out.join("other.toml").exists(), "{told}");
    let (code, told) = refused(&["new", "dampr"]);
    assert!(
        code == 2
            && told.contains("new dampr")
            && told.contains("expected one of damper_with_buffer, gear_backlash, brake_squeal"),
        "{told}"
    );
}

/// A machine has one name: of its page, of its file, and in the file, where it is capitalised.
#[test]
fn machines_of_the_gallery_have_the_name_of_their_page_and_names_of_version_0_3_say_it() {
    let out = folder("new-old-names");
    fs::create_dir_all(&out).unwrap();
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    for example in EXAMPLES {
        let words = example.name.split('_').map(|word| word[..1].to_uppercase() + &word[1..]);
        let own = format!("name = \"{}\"", words.collect::<String>());
        assert!(example.text.lines().any(|line| line == own), "{}: expected {own}", example.name);
        assert!(fs::exists(format!("{root}/docs/gallery/{}.md", example.name)).unwrap(), "{}", example.name);
    }
    for (old, new) in [("damper", "damper_with_buffer"), ("run-up", "run_up"), ("shock", "shaken_rig")] {
        let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
        let done = vibro.args(["new", old]).current_dir(&out).output().unwrap();
        let expected =
            format!("note: `vibro new {old}` is now `vibro new {new}`; the old name works until 0.5\n");
        assert!(done.status.success() && String::from_utf8(done.stderr).unwrap() == expected);
        let example = EXAMPLES.iter().find(|example| example.name == new).unwrap();
        assert!(fs::read_to_string(out.join(format!("{old}.toml"))).unwrap() == example.text);
    }
}

#[test]
fn fmu_packs_around_the_library_that_is_named_and_says_how_to_get_one() {
    let out = folder("packed");
    fs::create_dir_all(&out).unwrap();
    let damper = format!("{}/../../examples/assembly/damper_with_buffer.toml", env!("CARGO_MANIFEST_DIR"));
    let kit = out.join(KIT_FILE);
    Kit { binaries: Binaries::own(b"a library".to_vec()), ..Kit::default() }.write(&kit).unwrap();
    let kit = kit.display().to_string();
    let archives = [("2", "DamperWithBuffer.fmu"), ("3", "DamperWithBuffer-FMI3.fmu")];
    for again in [false, true] {
        for (fmi, name) in archives {
            let told =
                drawn(&out, &["fmu", &damper, "--fmi", fmi, "--kit", &kit, "--set", "stop.steel.gap=5mm"]);
            assert!(told.contains(&format!("{name} (FMI {fmi}.0)")), "{told}");
            assert_eq!(told.contains("replacing the previous file"), again, "{told}");
        }
    }
    // Neither version has overwritten the other.
    for (fmi, name) in archives {
        let entries = archive::read_all(&out.join(name)).unwrap();
        let description = String::from_utf8(entries["modelDescription.xml"].clone()).unwrap();
        assert!(description.contains(&format!("fmiVersion=\"{fmi}.0\"")), "{description}");
        assert!(description.contains("0.005") && entries.values().any(|bytes| bytes == b"a library"));
    }
    let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
    vibro.args(["fmu", &damper]).env("VIBRO_IMPACT_ARCHIVES", out.join("nowhere"));
    let told = String::from_utf8(vibro.output().unwrap().stderr).unwrap();
    assert!(
        told.is_empty() || told.contains("cargo run --bin fmu-build") && told.contains("--kit"),
        "{told}"
    );
    let (code, told) = refused(&["fmu", &damper, "--kit", &damper]);
    assert!(code == 2 && told.contains("--kit"), "{told}");
}
