//! `vibro design`: its files and words compared with the closed form of an absorber; errors.

#[path = "common/mod.rs"]
mod command;

use command::{drawn, folder};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A driven body whose damping lowers the amplitude and raises the force on the ground.
const MOUNT: &str = "\
# An engine on its mounts.
name = \"Mount\"
[body.engine]
mass = \"1 kg\"
[spring.mount]            # to be chosen
between = [\"ground\", \"engine\"]
stiffness = \"1 kN/m\"
damping = \"5 N s/m\"
[load.unbalance]
on = \"engine\"
amplitude = \"1 N\"
frequency = \"8 Hz\"
";

fn written(out: &Path) -> String {
    std::fs::create_dir_all(out).unwrap();
    let path: PathBuf = out.join("mount.toml");
    std::fs::write(&path, MOUNT).unwrap();
    path.display().to_string()
}

const GOAL: [&str; 4] = ["--minimize", "amplitude.engine.s", "--vary", "spring.mount.damping=1:100"];

/// Error of numbers on the screen.
const SHOWN: f64 = 1e-5;

#[test]
fn closed_form_the_damping_at_a_limit_of_the_force_in_words_table_and_file() {
    let (home, out) = (folder("design-machine"), folder("design"));
    let file = written(&home);
    let own = ["--subject-to", "amplitude.mount.f<=800 mN", "--evaluations", "20"];
    let text = drawn(&out, &[&["design", &file][..], &GOAL, &own].concat());
    let (k, w, limit) = (1000.0, TAU * 8.0, 0.8f64);
    let exact = ((limit * limit * (k - w * w).powi(2) - k * k) / (1.0 - limit * limit)).sqrt() / w;
    let amplitude = 1.0 / (k - w * w).hypot(exact * w);
    assert!(text.contains("verdict: decided") && text.contains("<= 0.8 N: met"), "{text}");
    assert!(text.contains("with the parameters of the file: "), "{text}");
    let after = |word: &str| -> f64 {
        let rest = text.split_once(word).unwrap_or_else(|| panic!("{word}: {text}")).1;
        rest.split_whitespace().next().unwrap().parse().unwrap()
    };
    assert!((after("best: amplitude.engine.s = ") / (1e3 * amplitude) - 1.0).abs() < SHOWN, "{text}");
    assert!((after("spring.mount.damping = ") / exact - 1.0).abs() < SHOWN, "{text}");
    // The best file is the user's except for one number, and a first line with the verdict.
    let best = std::fs::read_to_string(out.join("best.toml")).unwrap();
    let lines: Vec<&str> = best.lines().collect();
    assert_eq!(lines[0], "# vibro design: decided");
    let same = lines[1..].iter().zip(MOUNT.lines()).filter(|(a, b)| *a == b).count();
    assert_eq!((lines.len() - 1, same), (MOUNT.lines().count(), MOUNT.lines().count() - 1), "{best}");
    let machine = vibro_machine::file::read(&out.join("best.toml")).unwrap();
    assert!((machine.get("spring.mount.damping").unwrap() / exact - 1.0).abs() < SHOWN, "{best}");
    // Every evaluated design has its amplitude.
    let table = std::fs::read_to_string(out.join("design.csv")).unwrap();
    let mut rows = table.lines();
    let header = "evaluation,stage,spring.mount.damping,amplitude.engine.s,amplitude.engine.s.low";
    assert!(rows.next().unwrap().starts_with(header), "{table}");
    let mut stages = Vec::new();
    for row in rows {
        let cells: Vec<&str> = row.split(',').collect();
        let [c, found] = [2, 3].map(|i| cells[i].parse::<f64>().unwrap());
        assert!((found * (k - w * w).hypot(c * w) - 1.0).abs() < 1e-6, "{row}");
        stages.push(cells[1]);
    }
    assert!(
        ["own", "sobol", "evolution", "gradient"].iter().all(|stage| stages.contains(stage)),
        "{stages:?}"
    );
    assert!(out.join("design.svg").exists() && out.join("design.png").exists());
}

#[test]
fn what_cannot_be_sought_is_refused_with_what_is_expected() {
    let (home, out) = (folder("design-refused-machine"), folder("design-refused"));
    let file = written(&home);
    for (options, words) in [
        (
            &["--minimize", "class", "--vary", "spring.mount.damping=1:9"][..],
            "class: cannot be the goal, because it has no error bar",
        ),
        (&["--minimize", "amplitude.engin.s", "--vary", "spring.mount.damping=1:9"], "`engine.s`"),
        (&["--minimize", "rms.engine.a", "--vary", "spring.mount.damping=1:9:3"], "LOW:HIGH without a count"),
        (&["--minimize", "rms.engine.a", "--vary", "spring.mount.dampin=1:9"], "spring.mount.damping"),
        (
            &["--minimize", "rms.engine.a", "--vary", "body.engine.start.v=1:9"],
            "start values cannot be varied; expected a parameter of the machine",
        ),
        (&["--minimize", "rms.engine.a"], "--vary"),
        (&["--vary", "spring.mount.damping=1:9"], "--minimize"),
        (&[&GOAL[..], &["--subject-to", "impacts=3"]].concat(), "OUTPUT<=VALUE"),
        (&[&GOAL[..], &["--subject-to", "amplitude.mount.f<=3 m"]].concat(), "a unit of the output"),
        (&[&GOAL[..], &["--robust", "60%"]].concat(), "0% to 50%"),
        (
            &[&GOAL[..], &["--over", "spring.mount.damping=1:9"]].concat(),
            "spring.mount.damping: is varied twice",
        ),
    ] {
        let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
        let output = vibro.args(["design", &file]).args(options).arg("--out").arg(&out).output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && error.contains(words), "{options:?}: {error}");
        assert!(!out.exists(), "{options:?}");
    }
}
