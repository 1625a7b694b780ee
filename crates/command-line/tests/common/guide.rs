//! Runs the commands of a page of docs/.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A page.
pub struct Guide {
    text: String,
}

/// The folder of a page's commands and their files.
fn home(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// The numbers of a table that a command has written; NaN for a cell that is not a number.
#[allow(dead_code)] // Each test program uses its share of these.
pub fn rows(name: &str, table: &str) -> Vec<Vec<f64>> {
    let mut reader = csv::Reader::from_path(home(name).join(table)).expect("a table");
    let number = |cell: &str| cell.parse().unwrap_or(f64::NAN);
    reader.records().map(|row| row.expect("a row").iter().map(number).collect()).collect()
}

/// The cells of a table that a command has written.
#[allow(dead_code)] // Each test program uses its share of these.
pub fn texts(name: &str, table: &str) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(home(name).join(table)).expect("a table");
    reader.records().map(|row| row.expect("a row").iter().map(str::to_owned).collect()).collect()
}

impl Guide {
    /// Reads a page of docs/.
    #[allow(dead_code)] // Each test program uses its share of these.
    pub fn read(name: &str) -> Self {
        Self::at(&format!("../../docs/{name}"))
    }

    /// Reads a page by its path from the package.
    pub fn at(path: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
        Self { text: std::fs::read_to_string(path).expect("the page can be read") }
    }

    /// The page.
    #[allow(dead_code)] // Each test program uses its share of these.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Fenced blocks as (info string, text).
    fn blocks(&self) -> Vec<(&str, String)> {
        let mut found = Vec::new();
        let mut lines = self.text.lines();
        while let Some(line) = lines.next() {
            if let Some(info) = line.strip_prefix("```") {
                let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
                found.push((info, block.join("\n") + "\n"));
            }
        }
        found
    }

    /// Writes the page's files (blocks with a name after the language) and runs its `vibro`
    /// commands, in the order of the page, in a fresh folder. `shortened` are words of commands
    /// and their replacements, which make the test quick; each must occur. Returns the commands'
    /// standard output.
    pub fn perform(&self, name: &str, shortened: &[(&str, &str)]) -> Vec<String> {
        let home = home(name);
        // Absent on the first run.
        let _ = std::fs::remove_dir_all(&home);
        std::fs::create_dir_all(&home).expect("target can be written");
        let mut said = Vec::new();
        let mut used = vec![false; shortened.len()];
        for (info, block) in self.blocks() {
            match info.split_once(' ') {
                Some((_, file)) => std::fs::write(home.join(file), &block).expect("target can be written"),
                None if info == "sh" => {
                    for line in
                        block.replace("\\\n", " ").lines().filter_map(|line| line.strip_prefix("vibro "))
                    {
                        let mut line = line.to_owned();
                        for ((long, short), used) in shortened.iter().zip(&mut used) {
                            *used |= line.contains(long);
                            line = line.replace(long, short);
                        }
                        said.push(vibro(&home, &line));
                    }
                }
                None => {}
            }
        }
        assert!(!said.is_empty() && used.iter().all(|used| *used), "{used:?}: a command was rewritten");
        said
    }
}

/// The words of a command; double quotes keep several together.
fn words(line: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    for (k, part) in line.split('"').enumerate() {
        match k % 2 {
            0 => words.extend(part.split_whitespace().map(str::to_owned)),
            _ => words.push(part.to_owned()),
        }
    }
    words
}

/// Standard output of a command that must succeed; `> file` writes it to a file.
fn vibro(home: &Path, line: &str) -> String {
    let (line, file) = line.split_once(" > ").map_or((line, None), |(line, file)| (line, Some(file)));
    let mut command = Command::new(env!("CARGO_BIN_EXE_vibro"));
    let output = command.args(words(line)).current_dir(home).output().expect("vibro runs");
    let notes = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && !notes.contains("the old "), "vibro {line}: {notes}");
    let said = String::from_utf8(output.stdout).expect("text");
    if let Some(file) = file {
        std::fs::write(home.join(file.trim()), &said).expect("target can be written");
    }
    said
}
