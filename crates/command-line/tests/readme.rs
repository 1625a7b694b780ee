//! Every `vibro` command of README.md and of the pages in docs/ works.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The pages' call of the program. The recipes of `docs/paper-machine.md` and
/// `docs/design-a-damper.md` call it `vibro`; `guides.rs` and `tutorial.rs` run their commands.
const CALL: &str = "cargo run --release -p vibro -- ";
/// Command that `studies.rs` runs.
const ELSEWHERE: &str = "paper reproduce --quick";
/// The pages show the program's 17 commands, some of them twice.
const AT_LEAST: usize = 17;

/// README.md and the pages in docs/.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace");
    let docs = std::fs::read_dir(root.join("docs")).expect("docs can be read");
    let docs = docs.map(|entry| entry.expect("an entry").path());
    let mut pages: Vec<PathBuf> = docs.filter(|path| path.extension().is_some_and(|e| e == "md")).collect();
    pages.push(root.join("README.md"));
    pages.sort();
    pages
}

/// The files of a page: blocks with a name after the language.
fn files(text: &str) -> impl Iterator<Item = (&str, &str)> {
    let blocks = text.split("\n```").skip(1).step_by(2);
    blocks.filter_map(|block| {
        let (info, block) = block.split_once('\n')?;
        Some((info.split_once(' ')?.1, block))
    })
}

#[test]
fn every_vibro_command_of_the_pages_works() {
    let mut count = 0;
    for page in pages() {
        let text = std::fs::read_to_string(&page).expect("the page can be read");
        // Later commands of a page read the files of earlier ones.
        let name = page.file_stem().expect("a page has a name");
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pages").join(name);
        // Absent on the first run.
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("target can be written");
        for (name, block) in files(&text) {
            std::fs::write(folder.join(name), block).expect("target can be written");
        }
        for line in text.lines().filter_map(|line| line.strip_prefix(CALL)) {
            count += 1;
            let arguments = line.split('#').next().unwrap_or("").trim();
            if arguments == ELSEWHERE {
                continue;
            }
            let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
            let output =
                vibro.args(arguments.split_whitespace()).current_dir(&folder).output().expect("vibro runs");
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{}: {line}: {said}", page.display());
            assert!(!said.contains("the old spelling"), "{}: {line}: {said}", page.display());
        }
    }
    assert!(count >= AT_LEAST, "the pages show {count} commands");
}
