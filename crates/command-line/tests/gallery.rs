//! The pages of docs/gallery: commands work, pictures equal the commands' output, quoted lines are
//! in the files. `VIBRO_IMPACT_UPDATE=1` rewrites the pictures.

#[path = "common/mod.rs"]
mod command;
#[path = "gallery/figures.rs"]
mod figures;

use command::{folder, numbers};
use std::path::{Path, PathBuf};
use std::process::Command;
use vibro::gallery::EXAMPLES;

/// Tolerance of a picture's coordinates, which have few digits: another mathematical library
/// changes them by less.
const MOVED: f64 = 2.0;
/// Share of a picture's numbers that may differ by more than [`MOVED`], because chaotic motion
/// amplifies last digits.
const CHAOTIC: f64 = 0.3;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Pictures of chaos, where the last bit of a sine decides how many points there are; only the
/// distribution of the numbers is compared.
const CHAOS: [&str; 1] = ["paper_machine"];

/// Pictures whose commands follow branches, for 7 s to 17 s of processor time each.
const LONG: [&str; 3] = ["damper_with_buffer_response", "gear_backlash_response", "valve_train_response"];

/// The text from a fence with this info string to the next fence.
fn block<'a>(page: &'a str, info: &str) -> &'a str {
    let (_, rest) = page.split_once(&format!("```{info}\n")).expect("a block");
    rest.split_once("\n```").expect("its end").0
}

/// The output of `vibro draw` for an example.
fn sketched(name: &str) -> String {
    let (out, file) = (folder(&format!("gallery-sketch-{name}")), format!("examples/assembly/{name}.toml"));
    let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
    let vibro = vibro.args(["draw", &file, "--out"]).arg(&out).current_dir(root());
    let output = vibro.output().expect("vibro runs");
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    let mut drawn = std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path());
    let svg = drawn.find(|path| path.extension().is_some_and(|e| e == "svg")).expect("a sketch");
    std::fs::read_to_string(svg).unwrap()
}

/// Compares a page's picture with the output of its command, or rewrites the picture. Returns what
/// the command says.
fn compare(gallery: &Path, name: &str, command: &str, update: bool) -> String {
    let line = command.strip_prefix("vibro ").expect("a command of vibro");
    let (line, _) = line.split_once(" --out ").expect("a folder");
    let out = folder(&format!("gallery-{name}"));
    let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
    let vibro = vibro.args(line.split_whitespace()).arg("--out").arg(&out).current_dir(root());
    let output = vibro.output().expect("vibro runs");
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    let drawn = ["motion", "bifurcation", "response", "sweep", "design", "fit"]
        .map(|n| out.join(n).with_extension("svg"));
    let drawn = drawn.iter().find(|p| p.exists()).expect("a picture");
    let now = std::fs::read_to_string(drawn).unwrap();
    let kept = gallery.join(format!("{name}.svg"));
    if update {
        std::fs::write(&kept, &now).unwrap();
    }
    let before = std::fs::read_to_string(&kept).expect("a picture; VIBRO_IMPACT_UPDATE=1 writes it");
    let (mut old, mut new) = (numbers(&before), numbers(&now));
    // Rounding also decides the number of points of a followed branch.
    if CHAOS.contains(&name) || name.ends_with("_response") {
        old.sort_by(f64::total_cmp);
        new.sort_by(f64::total_cmp);
    }
    let far = old.iter().zip(&new).filter(|(a, b)| (*a - *b).abs() > MOVED).count();
    let apart = far as f64 + old.len().abs_diff(new.len()) as f64;
    let stale = "is stale; VIBRO_IMPACT_UPDATE=1 writes it anew";
    assert!(apart <= CHAOTIC * old.len() as f64, "{name}.svg {stale}");
    String::from_utf8(output.stdout).unwrap()
}

/// The commands of a page.
fn commands(page: &str) -> Vec<&str> {
    page.split("```sh\n").skip(1).filter_map(|rest| rest.lines().next()).collect()
}

#[test]
fn golden_pictures_of_the_gallery_are_what_its_commands_draw() {
    let gallery = root().join("docs/gallery");
    let index = std::fs::read_to_string(gallery.join("README.md")).unwrap();
    let update = std::env::var("VIBRO_IMPACT_UPDATE").is_ok_and(|v| v == "1");
    let mut count = 0;
    for entry in std::fs::read_dir(&gallery).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if path.extension().is_none_or(|e| e != "md") || name == "README" {
            continue;
        }
        count += 1;
        assert!(index.contains(&format!("({name}.md)")), "{name} is not in the gallery's index");
        let page = std::fs::read_to_string(&path).unwrap();
        let file = std::fs::read_to_string(root().join(format!("examples/assembly/{name}.toml"))).unwrap();
        let own = EXAMPLES.iter().find(|example| example.text == file).expect("one of `vibro new`");
        assert!(page.contains(&format!("`vibro new {}`", own.name)), "{name} does not say how to begin");
        let lines: Vec<&str> = file.lines().collect();
        for line in block(&page, "toml").lines() {
            assert!(lines.contains(&line), "{name}: the file has no line `{line}`");
        }
        let sketch = sketched(&name);
        let kept = gallery.join("sketches").join(&name).with_extension("svg");
        if update {
            std::fs::write(&kept, &sketch).unwrap();
        }
        assert!(page.contains(&format!("](sketches/{name}.svg)")), "{name} shows no sketch");
        let before = std::fs::read_to_string(&kept).expect("a sketch; VIBRO_IMPACT_UPDATE=1 writes it");
        assert!(before == sketch, "sketches/{name}.svg is stale; VIBRO_IMPACT_UPDATE=1 writes it anew");
        let commands = commands(&page);
        // A third command makes a table; `figures` runs it.
        assert!((1..=3).contains(&commands.len()), "{name}: {commands:?}");
        let mut said = String::new();
        for (command, further) in commands.iter().zip(["", "_response"]) {
            let name = format!("{name}{further}");
            if !LONG.contains(&name.as_str()) {
                said += &compare(&gallery, &name, command, update);
            }
        }
        let shown = page.split("```text\n").skip(1).filter_map(|rest| rest.split("```").next());
        for line in shown.flat_map(str::lines).filter(|line| !line.starts_with("vibro ")) {
            assert!(said.lines().any(|own| own == line), "{name}: the commands do not say `{line}`:\n{said}");
        }
    }
    assert!(count >= 17, "{count} pages");
}

#[test]
#[ignore = "45 s of processor time: cargo test -p vibro --test gallery -- --ignored"]
fn golden_pictures_of_long_commands_are_what_they_draw() {
    let gallery = root().join("docs/gallery");
    let update = std::env::var("VIBRO_IMPACT_UPDATE").is_ok_and(|v| v == "1");
    for name in LONG {
        let page = gallery.join(name.strip_suffix("_response").unwrap()).with_extension("md");
        let page = std::fs::read_to_string(page).unwrap();
        compare(&gallery, name, commands(&page)[1], update);
    }
}

/// Words of the tutorial's commands and their replacements, which make the test quick.
const SHORTENED: [(&str, &str); 3] =
    [("130mm:200", "130mm:4 --discard 20 --keep 4"), ("130mm:40", "130mm:2"), ("130mm:25", "130mm:2")];

#[test]
fn the_tutorial_from_file_to_choice_works() {
    let page = std::fs::read_to_string(root().join("docs/assemblies.md")).unwrap();
    let file = "examples/assembly/damper_with_buffer.toml";
    let machine = vibro_machine::file::read(&root().join(file)).unwrap();
    let own = page.split("```toml\n").filter_map(|rest| rest.split("```").next());
    let own: Vec<_> = own.filter(|text| text.contains("body.box = {")).collect();
    let read = vibro_machine::file::parse(own[0], "docs/assemblies.md", &vibro_machine::file::no_records);
    assert_eq!((read.as_ref(), own.len()), (Ok(&machine), 1), "the page's machine is that of its commands");
    let mut used = [false; SHORTENED.len()];
    let mut commands = 0;
    let blocks = page.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next());
    for line in blocks.flat_map(str::lines).filter_map(|line| line.strip_prefix("vibro ")) {
        let mut line = line.to_owned();
        for ((long, short), used) in SHORTENED.iter().zip(&mut used) {
            *used |= line.contains(long);
            line = line.replace(long, short);
        }
        let (line, _) = line.split_once(" --out ").unwrap_or((&line, ""));
        let out = folder(&format!("from-file-to-choice-{commands}"));
        let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
        vibro.args(line.split_whitespace()).current_dir(root());
        if !line.starts_with("check ") {
            vibro.arg("--out").arg(&out);
        }
        let output = vibro.output().expect("vibro runs");
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        commands += 1;
    }
    assert!(commands >= 5 && used.iter().all(|used| *used), "{commands} {used:?}");
}
