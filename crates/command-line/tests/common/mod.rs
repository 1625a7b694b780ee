//! Runs the real `vibro`.

// Each test program uses only a part of this module.
#![allow(dead_code)]

use std::collections::{BTreeMap, HashMap};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A machine's file.
pub const DAMPER: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/assembly/damper_with_buffer.toml");

/// Much longer than a part takes on a busy computer.
const PATIENCE: Duration = Duration::from_secs(120);

/// A fresh folder for one test.
pub fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    // Absent on the first run.
    let _ = std::fs::remove_dir_all(&path);
    path
}

/// Commands for the paper's machine alone.
pub const OF_PAPER: [&str; 8] =
    ["steady", "manifold", "stability", "plane", "compare", "isoperiodic", "template", "reproduce"];
/// Commands for the machine of a FILE, their first argument, or for the paper's machine.
pub const OF_BOTH: [&str; 9] =
    ["run", "sweep", "bifurcation", "lyapunov", "response", "basin", "orbits", "orbit", "locus"];

/// Whether arguments name a command of the paper's machine, called `vibro paper COMMAND`.
fn is_of_paper(arguments: &[&str]) -> bool {
    let Some((name, options)) = arguments.split_first() else { return false };
    let has_file = options.first().is_some_and(|word| !word.starts_with('-'));
    OF_PAPER.contains(name) || OF_BOTH.contains(name) && !has_file && options != ["--help"]
}

/// `vibro` with its output in a folder, if the command writes any. Commands for the paper's
/// machine are called by their names alone here.
pub fn command(out: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_vibro"));
    command.args(is_of_paper(arguments).then_some("paper")).args(arguments);
    if !arguments.iter().any(|word| ["check", "template", "new"].contains(word)) {
        command.arg("--out").arg(out);
    }
    command
}

/// Standard output of a run that must succeed without output to standard error.
pub fn drawn(out: &Path, arguments: &[&str]) -> String {
    let output = command(out, arguments).output().expect("vibro runs");
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("text");
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    // No progress bar without a terminal.
    assert_eq!(text(&output.stderr), "", "{arguments:?}");
    text(&output.stdout)
}

/// Starts a long study and waits for `count` of its parts.
pub fn begun(out: &Path, arguments: &[&str], study: &str, count: usize) -> Child {
    let mut vibro = command(out, arguments);
    let mut child = vibro.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("vibro starts");
    let begin = Instant::now();
    while parts(out, study).len() < count {
        assert!(begin.elapsed() < PATIENCE, "no parts in {PATIENCE:?}");
        assert!(child.try_wait().unwrap().is_none(), "it has ended already");
        std::thread::sleep(Duration::from_millis(2));
    }
    child
}

/// Kills a program at once.
pub fn killed(mut child: Child) {
    child.kill().unwrap();
    child.wait().unwrap();
}

/// The finished parts of a study, with their bytes.
pub fn parts(out: &Path, study: &str) -> BTreeMap<String, Vec<u8>> {
    let home = out.join(format!("{study}.parts"));
    let mut found = if home.exists() { files(&home) } else { BTreeMap::new() };
    found.retain(|name, _| name.ends_with(".part"));
    found
}

/// All files of a folder and its subfolders by relative name, with their bytes; a file that a
/// program renames meanwhile is omitted.
pub fn files(home: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(home).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
            continue;
        }
        match std::fs::read(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => {}
            bytes => drop(found.insert(name, bytes.expect("a file"))),
        }
    }
    found
}

/// The pixels of a PNG file as (width, height, RGB bytes).
pub fn pixels(path: &Path) -> (u32, u32, Vec<u8>) {
    let file = std::fs::File::open(path).expect("a PNG file");
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a PNG header");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut pixels).expect("PNG data");
    (info.width, info.height, pixels)
}

/// Exit code and standard error of a run that must fail.
pub fn refused(arguments: &[&str]) -> (i32, String) {
    // Each test has a separate folder, since tests run in parallel.
    let home = tempfile::tempdir().expect("a folder");
    let output = command(&home.path().join("out"), arguments).output().expect("vibro runs");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    (output.status.code().expect("a code"), String::from_utf8(output.stderr).expect("text"))
}

/// The rows of a table by their columns.
pub fn table(out: &Path, name: &str) -> Vec<HashMap<String, String>> {
    let mut reader = csv::Reader::from_path(out.join(name)).expect("a table");
    reader.deserialize().collect::<Result<_, _>>().expect("rows")
}

/// A value of the table of `steady`.
pub fn number(rows: &[HashMap<String, String>], quantity: &str, theory: &str, root: &str) -> f64 {
    let found = rows.iter().find(|r| r["quantity"] == quantity && r["theory"] == theory && r["root"] == root);
    found.unwrap_or_else(|| panic!("{quantity}, {theory}, {root}"))["value"].parse().expect("a number")
}

/// The numbers of a drawing, without those of its description.
pub fn numbers(svg: &str) -> Vec<f64> {
    let drawn = svg.split_once("</desc>").map_or(svg, |(_, drawn)| drawn);
    drawn
        .split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-'))
        .filter_map(|n| n.parse().ok())
        .collect()
}
