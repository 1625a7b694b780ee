//! Reads the golden files of `tests/data`. Their columns are described in the scripts there.

use std::collections::HashMap;
use std::path::Path;
use vibro_impact::parameters::FIELDS;
use vibro_impact::{Groups, Parameters, Scales, State};

/// One row of a golden file, by column name.
#[derive(Clone, Debug)]
pub struct Row(HashMap<String, String>);

/// All rows of `tests/data/<name>`.
pub fn table(name: &str) -> Vec<Row> {
    // The package is the root or, for the benches, a folder below it.
    let mut folders = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let found =
        folders.find_map(|folder| Some(folder.join("tests/data").join(name)).filter(|path| path.exists()));
    let path = found.unwrap_or_else(|| panic!("no {name} in a folder tests/data")).display().to_string();
    let mut reader = csv::Reader::from_path(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    reader.deserialize().map(|row| Row(row.unwrap())).collect()
}

impl Row {
    pub fn text(&self, column: &str) -> &str {
        self.0.get(column).unwrap_or_else(|| panic!("no column {column}"))
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
        let mut p = Parameters::default();
        for field in &FIELDS {
            (field.set)(&mut p, self.get(field.field));
        }
        p
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

/// Machine of the standard work with another restitution coefficient and drive.
pub fn weak(kappa: f64, f10: f64) -> Parameters {
    Groups::weak(0.1, kappa, f10, 0.0, 0.4, 0.2, 0.0, 0.4).to_parameters(Scales::default()).expect("valid")
}

/// Machine and start of the standard work (benches/standard_work.rs), bit-identical to the
/// library's.
pub fn standard() -> (Parameters, State) {
    (weak(0.75, 1.5), State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] })
}
