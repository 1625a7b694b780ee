//! Reading of bodies with mass and stiffness matrices.

use super::bodies::Names;
use super::flexible::{named_nodes, node, of_modes, start};
use super::matrices;
use super::reading::{Entry, FileTable, Reading};
use crate::description::{Description, Dimension, Given, GivenNode, MatrixDamping};
use crate::kinds;
use nalgebra::{DMatrix, DVector};

/// Reads the bodies with matrices. The nodes of a body with problems keep their names, so that
/// elements that refer to them can be read.
pub(super) fn read(reading: &mut Reading, root: &FileTable, names: &mut Names, machine: &mut Description) {
    for (name, table) in reading.section(root, "matrix") {
        let given = given(reading, &table, machine.starts_at_rest);
        let (nodes, sound) = nodes(reading, &table, given.as_ref().map(|own| own.mass.nrows()));
        let count = given.as_ref().map_or(0, |own| own.mass.nrows());
        for i in 0..count {
            names.add(Description::name_of_coordinate(&name, i), Some(Dimension::Translation));
        }
        nodes.iter().for_each(|node| names.add(format!("{name}.{}", node.name), Some(node.dimension)));
        let Some(given) = given.filter(|_| sound) else { continue };
        if let Err(problems) = machine.add_matrix(&name, Given { nodes, ..given }) {
            problems.into_iter().for_each(|problem| reading.place(problem));
        }
    }
}

fn given(reading: &mut Reading, table: &FileTable, at_rest: bool) -> Option<Given> {
    let own = ["mass", "stiffness", "damping", "rayleigh", "damping_ratio", "gyroscopic"];
    reading.known(table, &[&own[..], &["gravity", "start", "nodes"]].concat());
    let mut square = |key: &str, is_required: bool| -> Option<Option<DMatrix<f64>>> {
        let allowed = "expected a matrix: a file such as \"M.mtx\" or \"M.csv\", or a list of rows";
        let entry = match is_required {
            true => Some(reading.required(table, key, allowed)?),
            false => reading.optional(table, key),
        };
        let Some(entry) = entry else { return Some(None) };
        let found = matrices::read(reading, &entry)?;
        if !found.is_square() {
            let (rows, columns) = found.shape();
            let text = format!("has {rows} rows and {columns} columns; must be square");
            reading.refuse(&entry, text);
            return None;
        }
        Some(Some(found))
    };
    let (mass, stiffness) = (square("mass", true), square("stiffness", true));
    let (damping, gyroscopic) = (square("damping", false), square("gyroscopic", false));
    let mass = mass??;
    let n = mass.nrows();
    let damping = of_damping(reading, table, damping, n);
    let gravity = match reading.optional(table, "gravity") {
        None => Some(vec![0.0; n]),
        Some(entry) => of_modes(reading, &entry, kinds::SHARE, n),
    };
    let [q, v] = start(reading, table, n, at_rest)?.map(DVector::from_vec);
    let (stiffness, damping, gyroscopic) = (stiffness??, damping?, gyroscopic?);
    let gravity = DVector::from_vec(gravity?);
    Some(Given { mass, stiffness, damping, gyroscopic, gravity, q, v, nodes: Vec::new() })
}

fn of_damping(
    reading: &mut Reading,
    table: &FileTable,
    matrix: Option<Option<DMatrix<f64>>>,
    n: usize,
) -> Option<MatrixDamping> {
    let given: Vec<Entry> = ["damping", "rayleigh", "damping_ratio"]
        .iter()
        .filter_map(|key| reading.optional(table, key))
        .collect();
    let entry = match &given[..] {
        [] => return Some(MatrixDamping::None),
        [one] => one,
        [first, other, ..] => {
            let text = "use one of `damping`, `rayleigh` and `damping_ratio`";
            reading.refuse(other, format!("cannot be combined with `{}`: {text}", first.key));
            return None;
        }
    };
    match entry.key.as_str() {
        "damping" => matrix?.map(MatrixDamping::Matrix),
        "rayleigh" => {
            let factors =
                of_modes_of(reading, entry, 2, "expected two numbers >= 0, of mass and of stiffness")?;
            Some(MatrixDamping::Rayleigh([factors[0], factors[1]]))
        }
        _ if entry.value.is_array() => of_modes(reading, entry, kinds::RATIO, n).map(MatrixDamping::Ratios),
        _ => {
            Some(MatrixDamping::Ratios(vec![reading.number(entry, kinds::RATIO, Dimension::Translation)?]))
        }
    }
}

fn of_modes_of(reading: &mut Reading, entry: &Entry, count: usize, allowed: &str) -> Option<Vec<f64>> {
    super::flexible::list(reading, entry, kinds::RATIO, Some(count), allowed)
}

/// Reads the nodes; also returns whether all are free of problems.
fn nodes(reading: &mut Reading, table: &FileTable, count: Option<usize>) -> (Vec<GivenNode>, bool) {
    let Some(entry) = reading.optional(table, "nodes") else { return (Vec::new(), true) };
    let Some(table) = reading.table(&entry, "expected a table of nodes, such as { tip = [0, 0, 1.0] }")
    else {
        return (Vec::new(), false);
    };
    let (mut all, mut sound) = (Vec::new(), true);
    for entry in named_nodes(reading, &table) {
        let (dimension, row) = node(reading, &entry, count);
        sound &= row.is_some() && dimension.is_some();
        let mut dense = DVector::zeros(count.unwrap_or(0));
        row.into_iter().flatten().for_each(|(k, factor)| dense[k] = factor);
        let dimension = dimension.unwrap_or(Dimension::Translation);
        all.push(GivenNode { name: entry.key.clone(), dimension, row: dense });
    }
    (all, sound)
}
