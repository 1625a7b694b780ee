//! Described machines for the workbench, a page in a browser: text and numbers in, numbers and
//! JSON out.
//!
//! The libraries do all computations; this crate only provides the interface. The page calls it in
//! workers, so that a long call never blocks the page.
//!
//! | module | use in the page |
//! |---|---|
//! | `file` | reads a machine, reports its problems by line, and edits its parameters in place |
//! | `completion` | completions at the cursor |
//! | `motion` | advances the motion: rows of all columns, events, energies, and sketches |
//! | `diagram` | one direction of a bifurcation diagram, value by value |
//! | `plane` | classes of motions over two parameters, row by row |
//! | `fit` | parameters of a machine fitted to a record |
//! | `orbits` | branches of periodic orbits over a parameter, unstable ones too |
//! | `archive` | FMU archives around the libraries of a kit |
//!
//! A refused file is a JavaScript `Error` whose message is JSON: a list of problems, each with
//! `line` (or null) and `words`. Other errors have the library's message.
#![allow(unsafe_code)] // written by the macro `wasm_bindgen` around each function; none is written by hand

pub mod archive;
pub mod completion;
pub mod diagram;
pub mod file;
pub mod fit;
pub mod motion;
pub mod orbits;
pub mod plane;

use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    /// The page's function that receives a panic's message; the worker is discarded afterwards.
    #[wasm_bindgen(js_namespace = globalThis, js_name = panicked, catch)]
    fn panicked(words: &str) -> Result<(), JsValue>;
}

/// Sends the message of every panic to the page; a panic ends the module.
#[wasm_bindgen(start)]
pub fn begin() {
    std::panic::set_hook(Box::new(|panic| {
        // If the page has no such function, the message is dropped.
        let _ = panicked(&panic.to_string());
    }));
}
