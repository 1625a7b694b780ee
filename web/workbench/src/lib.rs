//! Described machines for the workbench, a page in a browser: text and numbers in, numbers and JSON
//! out.
//!
//! The libraries do all computations; this crate has doors only. The page calls it in workers, so
//! that a call that takes long never stops the page.
//!
//! | module | what the page does with it |
//! |---|---|
//! | `file` | reads a machine, tells its problems by line, and edits its numbers in place |
//! | `completion` | what may stand where one types |
//! | `motion` | advances the motion, with rows of all columns, events and energies, and the sketch of any instant |
//! | `diagram` | one direction of a bifurcation diagram, value by value |
//! | `plane` | classes of motions over two parameters, row by row |
//! | `fit` | numbers of a machine fitted to a record |
//! | `orbits` | branches of periodic orbits over a parameter, unstable ones too |
//! | `archive` | FMU archives around the libraries of a kit |
//!
//! A refused file is a JavaScript `Error` whose message is JSON: a list of problems, each with
//! `line` (or null) and `words`. Other errors have the library's words.
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
    /// The page's function that is told a panic's words; the worker is thrown away after it.
    #[wasm_bindgen(js_namespace = globalThis, js_name = panicked, catch)]
    fn panicked(words: &str) -> Result<(), JsValue>;
}

/// Tells the page the words of every panic, which ends the module.
#[wasm_bindgen(start)]
pub fn begin() {
    std::panic::set_hook(Box::new(|panic| {
        // Where no such function is there, nobody is to be told.
        let _ = panicked(&panic.to_string());
    }));
}
