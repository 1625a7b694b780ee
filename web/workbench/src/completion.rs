//! Completion of text while it is written.

use serde_json::json;
use vibro_machine::file;
use wasm_bindgen::prelude::*;

/// Completions between two parts of the text, as JSON: `before` and `after`, the numbers of
/// letters (UTF-16) there that an offer replaces; `offers`, each with name and text; and
/// `allowed`, a parameter's range and units in words.
#[wasm_bindgen]
pub fn completion(head: &str, tail: &str) -> String {
    let found = file::completion(head, tail);
    let [before, after] = found.replaced;
    let letters = |text: &str| text.encode_utf16().count();
    json!({
        "before": letters(&head[head.len() - before..]), "after": letters(&tail[..after]),
        "offers": found.offers, "allowed": found.allowed,
    })
    .to_string()
}
