//! The gallery's record of a shaken box, from initial values that are off by a quarter.

use super::{FAR, command::folder, number_after};
use std::path::Path;
use std::process::Command;

/// Parameters that made `examples/assembly/shaken_box.csv`, SI.
const TRUTHS: [(&str, f64); 5] = [
    ("stop.steel.gap", 5e-3),
    ("stop.steel.restitution", 0.65),
    ("stop.buffer.stiffness", 300e3),
    ("stop.buffer.damping", 60.0),
    ("friction.guide.force", 1.5),
];

#[test]
fn made_record_of_the_box_of_the_gallery() {
    let (out, examples) =
        (folder("fit-box"), Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly"));
    let free = TRUTHS.map(|(name, _)| name).join(",");
    let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
    let vibro =
        vibro.current_dir(examples).args(["fit", "shaken_box.toml", "--data", "shaken_box.csv", "--free"]);
    let output = vibro.arg(free).arg("--out").arg(&out).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(out.join("fit.json")).unwrap();
    assert!(text.contains("\"verdict\": \"fits\""), "{text}");
    for (name, truth) in TRUTHS {
        let place = format!("\"{name}\"");
        let [value, error] = ["value", "error"].map(|key| number_after(&text, &place, key));
        assert!((value - truth).abs() < FAR * error && error < 0.02 * truth, "{name} {value} ± {error}");
    }
}
