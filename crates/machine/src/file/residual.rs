//! Reading of the residual flexibility of bodies in modal coordinates.

use super::bodies::Names;
use super::matrices;
use super::reading::{FileTable, Reading};
use crate::description::Residual;

/// The form of the key.
const ALLOWED: &str =
    "expected a table such as { nodes = [\"tip.x\", \"tip.y\"], flexibility = [[2e-8, 1e-9], [1e-9, 3e-8]] }";

/// Reads the residual flexibility of a body whose nodes have been read.
pub(super) fn read(reading: &mut Reading, body: &str, table: &FileTable, names: &Names) -> Option<Residual> {
    let entry = reading.optional(table, "residual")?;
    let table = reading.table(&entry, ALLOWED)?;
    reading.known(&table, &["nodes", "flexibility"]);
    let listed = "expected a list of nodes of this body, such as [\"tip.x\", \"tip.y\"]";
    let given = reading.required(&table, "nodes", listed);
    let expected = "expected a list of rows, or a file, with a row and a column for each of `nodes`, in m/N";
    let flexibility = reading.required(&table, "flexibility", expected);
    let (given, flexibility) = (given?, flexibility?);
    let Some(items) = reading.items(&given).filter(|items| !items.is_empty()) else {
        reading.refuse(&given, listed);
        return None;
    };
    let before = format!("{body}.");
    let mut nodes = Vec::new();
    for item in &items {
        let name = reading.string(item, "expected the name of a node of this body")?;
        let own = names.all().filter_map(|name| name.strip_prefix(before.as_str()));
        let own = own.filter(|name| !name.starts_with("q["));
        let Some((node, _)) = names.find(&format!("{before}{name}")) else {
            reading.refuse_name(item, &name, "the body has no such node", own);
            return None;
        };
        if nodes.contains(&node) {
            reading.refuse(item, "the node is named twice");
            return None;
        }
        nodes.push(node);
    }
    let found = matrices::read(reading, &flexibility)?;
    if found.shape() != (nodes.len(), nodes.len()) {
        let text = format!(
            "has {} rows and {} columns; expected {} of both, one for each of `nodes`",
            found.nrows(),
            found.ncols(),
            nodes.len()
        );
        reading.refuse(&flexibility, text);
        return None;
    }
    Some(Residual { nodes, flexibility: found })
}
