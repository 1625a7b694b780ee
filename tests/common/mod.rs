//! Reads the golden files of `tests/data` (their columns: the headers of the scripts there).
#![allow(dead_code, missing_docs)] // every test binary uses its own part

use std::collections::HashMap;
use std::sync::Arc;
use vibro_impact::{Parameters, State};

/// One row of a golden file.
#[derive(Clone, Debug)]
pub struct Row {
    columns: Arc<HashMap<String, usize>>,
    fields: Vec<String>,
}

/// All rows of `tests/data/<name>`.
pub fn table(name: &str) -> Vec<Row> {
    let path = format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let mut lines = text.lines();
    let header = lines.next().expect("a header");
    let columns = Arc::new(header.split(',').enumerate().map(|(i, c)| (c.to_owned(), i)).collect());
    lines
        .map(|line| Row {
            columns: Arc::clone(&columns),
            fields: line.split(',').map(str::to_owned).collect(),
        })
        .collect()
}

impl Row {
    pub fn text(&self, column: &str) -> &str {
        &self.fields[*self.columns.get(column).unwrap_or_else(|| panic!("no column {column}"))]
    }

    /// The number in a column; `None` where the field is empty.
    pub fn maybe(&self, column: &str) -> Option<f64> {
        let text = self.text(column);
        (!text.is_empty()).then(|| text.parse().unwrap_or_else(|e| panic!("{column} = {text}: {e}")))
    }

    pub fn get(&self, column: &str) -> f64 {
        self.maybe(column).unwrap_or_else(|| panic!("{column} is empty"))
    }

    pub fn parameters(&self) -> Parameters {
        Parameters {
            box_mass: self.get("box_mass"),
            box_stiffness: self.get("box_stiffness"),
            box_damping: self.get("box_damping"),
            block_mass: self.get("block_mass"),
            secondary_mass: self.get("secondary_mass"),
            secondary_stiffness: self.get("secondary_stiffness"),
            secondary_damping: self.get("secondary_damping"),
            coupling_stiffness: self.get("coupling_stiffness"),
            stop_gap: self.get("stop_gap"),
            stop_restitution: self.get("stop_restitution"),
            drive_amplitude: self.get("drive_amplitude"),
            drive_frequency: self.get("drive_frequency"),
            drive_phase: self.get("drive_phase"),
        }
    }

    /// The state in columns `<prefix>x1` … `<prefix>v3`.
    pub fn state(&self, prefix: &str) -> State {
        let get = |kind: &str| [1, 2, 3].map(|i| self.get(&format!("{prefix}{kind}{i}")));
        State { x: get("x"), v: get("v") }
    }
}

/// Largest difference of two states, displacements in units of `length`, velocities of `speed`.
pub fn distance(a: &State, b: &State, length: f64, speed: f64) -> f64 {
    (0..3).fold(0.0, |most: f64, i| {
        most.max((a.x[i] - b.x[i]).abs() / length).max((a.v[i] - b.v[i]).abs() / speed)
    })
}
