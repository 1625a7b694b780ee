//! `vibro fit`: the page docs/fit.md against the machine by which its record was made, and
//! refusals.

#[path = "common/mod.rs"]
mod command;
#[path = "common/guide.rs"]
mod guide;

use command::folder;
use guide::Guide;
use std::path::Path;
use std::process::Command;

/// Standard errors within which an estimate lies but for one in some ten thousand.
const FAR: f64 = 4.0;

/// The number after a key of a JSON text, from a place on.
fn number_after(text: &str, place: &str, key: &str) -> f64 {
    let from = text.find(place).unwrap_or_else(|| panic!("{place}: {text}"));
    let rest = text[from..].split_once(&format!("\"{key}\": ")).unwrap().1;
    rest.split([',', '}']).next().unwrap().parse().unwrap()
}

#[test]
fn made_record_of_the_page() {
    let guide = Guide::read("fit.md");
    let said = guide.perform("fit", &[]);
    let home = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fit");
    let json = std::fs::read_to_string(home.join("fit/fit.json")).unwrap();
    for (name, truth) in [("spring.mount.stiffness", 1e4), ("friction.guide.force", 1.0)] {
        let (value, error) = (number_after(&json, name, "value"), number_after(&json, name, "error"));
        assert!((value - truth).abs() < FAR * error && error < 0.01 * truth, "{name} {value} ± {error}");
    }
    assert!(said[0].contains("spring.mount.stiffness ="), "{}", said[0]);
    assert!(said[0].contains("verdict: fits") && json.contains("\"verdict\": \"fits\""), "{}", said[0]);
    // Mass, stiffness and friction change by one part.
    let valley = std::fs::read_to_string(home.join("valley/fit.json")).unwrap();
    let part = |name: &str| number_after(&valley, "combination", name).abs();
    for name in ["body.slide.mass", "spring.mount.stiffness", "friction.guide.force"] {
        assert!((part(name) - 3f64.sqrt().recip()).abs() < 1e-3, "{name}: {valley}");
    }
    assert!(valley.contains("\"error\": null") && said[1].contains("does not determine"), "{}", said[1]);
    // A range without a unit is in the unit of the file, kN/m.
    let line = "fit drive.toml --data record.csv --free spring.mount.stiffness --within spring.mount.stiffness=7:9 --out within";
    let output =
        Command::new(env!("CARGO_BIN_EXE_vibro")).args(line.split(' ')).current_dir(&home).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let within = std::fs::read_to_string(home.join("within/fit.json")).unwrap();
    assert_eq!(number_after(&within, "spring.mount.stiffness", "value"), 9e3);
    // The fitted file is a machine.
    let fitted = std::fs::read_to_string(home.join("fit/fitted.toml")).unwrap();
    assert!(fitted.contains("[spring.mount]"), "{fitted}");
}

#[test]
fn what_is_no_record_is_refused_by_name_and_row() {
    let out = folder("fit-refused");
    std::fs::create_dir_all(&out).unwrap();
    let table = |name: &str, text: &str| {
        let path = out.join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let sound = table("sound.csv", "time,mass.s\n0,1e-3\n0.01,2e-3\n0.02,1e-3\n");
    let cases = [
        (
            table("columns.csv", "time,mas.s\n0,1\n1,2\n"),
            "friction.floor.force",
            "the machine has no `mas.s`",
        ),
        (table("time.csv", "t,mass.s\n0,1\n1,2\n"), "friction.floor.force", "has no column `time`"),
        (
            table("falls.csv", "time,mass.s\n0,1\n1,2\n0.5,2\n"),
            "friction.floor.force",
            "row 3 has the time 0.5 s",
        ),
        (table("nan.csv", "time,mass.s\n0,1\n1,NaN\n"), "friction.floor.force", "row 2: mass.s = `NaN`"),
        (table("empty.csv", "time,mass.s\n"), "friction.floor.force", "no sample"),
        (table("near.csv", "time,mas.s\n0,1\n1,2\n"), "friction.floor.force", "the nearest is `mass.s`"),
        (sound.clone(), "friction.floor.forc", "the nearest is `friction.floor.force`"),
        (sound.clone(), "friction.floor.force,record.offset.floor.f", "the record has no such column"),
        (
            sound.clone(),
            "friction.floor.force,spring.mount.stiffness,body.mass.mass,body.mass.start.s",
            "3 samples for 4 free numbers",
        ),
    ];
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for (record, free, words) in cases {
        let output = Command::new(env!("CARGO_BIN_EXE_vibro"))
            .args([
                "fit",
                "examples/assembly/coulomb_oscillator.toml",
                "--data",
                &record,
                "--free",
                free,
                "--out",
            ])
            .arg(out.join("fit"))
            .current_dir(&root)
            .output()
            .unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && error.contains(words), "{free}: {error}");
    }
}
