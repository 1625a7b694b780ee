//! Clamped nodes: a list, or a file with one a line.

use crate::dofs::Dofs;
use crate::interface::rows;
use crate::{Error, Result};

/// Rows of the nodes of a list such as `1,2,7.xz`.
///
/// # Errors
/// An error for an unknown node or direction.
pub fn of_list(text: &str, dofs: &Dofs) -> Result<Vec<usize>> {
    let what = format!("--clamp {text}");
    let words = text.split(',').map(str::trim).filter(|word| !word.is_empty());
    of_words(words.map(|word| (what.clone(), word)), dofs)
}

/// Rows of the nodes of a file: one or more on a line, such as `7` or `7.xz`; a heading without
/// digits is passed over, and so are comments after `#`.
///
/// # Errors
/// An error with the line for an unknown node or direction, or if the file has no node.
pub fn of_file(text: &str, file: &str, dofs: &Dofs) -> Result<Vec<usize>> {
    let lines =
        text.lines().enumerate().filter(|(i, line)| *i > 0 || line.chars().any(|c| c.is_ascii_digit()));
    let words = lines.flat_map(|(i, line)| {
        let line = line.split('#').next().unwrap_or("");
        let words = line.split([',', ' ', '\t', ';']).map(str::trim).filter(|word| !word.is_empty());
        words.map(move |word| (format!("{file}:{}", i + 1), word))
    });
    let found = of_words(words, dofs)?;
    if found.is_empty() {
        Err(Error::new(file, "it names no node; expected one or more nodes"))
    } else {
        Ok(found)
    }
}

fn of_words<'t>(words: impl Iterator<Item = (String, &'t str)>, dofs: &Dofs) -> Result<Vec<usize>> {
    let none = Dofs::default();
    let mut found = Vec::new();
    for (what, word) in words {
        found.extend(rows(word, dofs, &none, &what)?.into_iter().map(|(_, row)| row));
    }
    found.sort_unstable();
    found.dedup();
    Ok(found)
}
