//! Every `vibro` command of README.md works.

use std::path::Path;
use std::process::Command;

/// How the README calls the program.
const CALL: &str = "cargo run --release -p vibro -- ";

#[test]
fn every_vibro_command_of_the_readme_works() {
    let readme = concat!(env!("CARGO_MANIFEST_DIR"), "/../README.md");
    let readme = std::fs::read_to_string(readme).expect("README.md can be read");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("readme");
    std::fs::create_dir_all(&folder).expect("target can be written");
    let mut count = 0;
    for line in readme.lines().filter_map(|line| line.strip_prefix(CALL)) {
        let arguments = line.split('#').next().unwrap_or("").split_whitespace();
        let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
        let output = vibro.args(arguments).current_dir(&folder).output().expect("vibro runs");
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        count += 1;
    }
    assert!(count >= 10, "README.md shows {count} commands");
}
