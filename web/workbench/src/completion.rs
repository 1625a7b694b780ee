//! Completion of the text that is being written.

use serde_json::json;
use vibro_machine::file;
use wasm_bindgen::prelude::*;

/// What may stand between two parts of the text, as JSON: `before` and `after`, numbers of letters
/// (UTF-16) there that an offer replaces, `offers`, each with its name and its text, and `allowed`,
/// a number's range and units in words.
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
