//! The exports of the library; code blocks of pages.
#![allow(dead_code, missing_docs)] // every test binary uses its own part

pub mod ball;
pub mod python;

use std::collections::BTreeSet;

/// Fenced blocks of a page as (info string, text).
pub fn blocks(markdown: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut lines = markdown.lines();
    while let Some(line) = lines.next() {
        if let Some(language) = line.strip_prefix("```") {
            let text: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            found.push((language.to_owned(), text.join("\n")));
        }
    }
    found
}

pub fn functions() -> BTreeSet<String> {
    fmu_build::compile::exported().collect()
}
