//! `RELEASE_NOTES.md`: the files of the folder, the trial of each file, the parts left out, and
//! the changes.

use super::agreement::Agreed;
use std::fmt::Write;

/// A file of the release.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its name.
    pub file: String,
    /// Size, bytes.
    pub size: u64,
    /// Content and audience.
    pub what: String,
    /// How it was tested.
    pub tried: String,
}

/// The table of the files, in Markdown.
pub fn table(parts: &[Part]) -> String {
    let mut text = String::from("| file | MB | what it is | how it was tried |\n|---|---|---|---|\n");
    for Part { file, size, what, tried } in parts {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "| `{file}` | {:.2} | {what} | {tried} |", *size as f64 / 1e6);
    }
    text
}

/// Text of the notes. If the section of changes does not belong to the version, the notes state
/// that this is a preview.
pub fn notes(agreed: &Agreed, parts: &[Part], left_out: &[String]) -> String {
    let Agreed { version, changes } = agreed;
    let mut text = match &changes.date {
        Some(date) if changes.name == *version => format!("# vibro-impact {version}, {date}\n"),
        _ => format!(
            "# vibro-impact, what {version} would be\n\nA preview, not a release: the changes below are those under \"{}\" in \
             CHANGELOG.md.\n",
            changes.name
        ),
    };
    text += &format!("\n## Files\n\n{}", table(parts));
    text += "\n`sha256sum --check SHA256SUMS` compares what was downloaded. The Python package is installed by\n`pip install` and the \
             name of its file for your system; NumPy comes with it.\n";
    if !left_out.is_empty() {
        text += "\n## Left out\n\n";
        text.extend(left_out.iter().map(|part| format!("- {part}\n")));
    }
    text + &format!("\n## Changes\n\n{}\n", changes.text)
}
