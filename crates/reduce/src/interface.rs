//! Interface nodes: where the body meets others.

use crate::dofs::{Direction, Dof, Dofs};
use crate::{Error, Result};

/// A named node with some of its dofs.
#[derive(Clone, Debug, PartialEq)]
pub struct Interface {
    /// Name of the node in the machine's file.
    pub name: String,
    /// Directions with their rows.
    pub dofs: Vec<(Direction, usize)>,
}

/// Reads the directions of `428.xz`, `428.rx` or `428.13`; `None` for other letters.
fn directions(text: &str) -> Option<Vec<Direction>> {
    let mut rest = text;
    let mut found = Vec::new();
    while let Some(first) = rest.chars().next() {
        let length = if first.eq_ignore_ascii_case(&'r') { 2 } else { 1 };
        let direction = Direction::of_name(rest.get(..length)?)?;
        if found.contains(&direction) {
            return None;
        }
        found.push(direction);
        rest = &rest[length..];
    }
    (!found.is_empty()).then_some(found)
}

/// The dofs of `428` or `428.xz`. `what` names the option in messages.
///
/// # Errors
/// An error if the node or a direction does not exist, with the nearest node or the directions.
pub fn rows(text: &str, dofs: &Dofs, clamped: &Dofs, what: &str) -> Result<Vec<(Direction, usize)>> {
    let refused = |problem: String| Error::new(what, problem);
    let (node, wanted) = match text.rsplit_once('.') {
        None => (text, None),
        Some((node, last)) => {
            let expected = || refused(format!("{last}: expected directions such as x, xz or rx"));
            (node, Some(directions(last).ok_or_else(expected)?))
        }
    };
    let (own, held) = (dofs.of_node(node), clamped.of_node(node));
    if own.is_empty() && !held.is_empty() {
        return Err(refused(format!("all dofs of node {node} are clamped; expected a node with a free dof")));
    }
    if own.is_empty() {
        return Err(refused(format!("{node}: {}", dofs.nearest_node(node))));
    }
    let Some(wanted) = wanted else { return Ok(own) };
    let of = |direction: Direction| {
        if let Some(row) = dofs.place(&Dof::new(node, direction)) {
            return Ok((direction, row));
        }
        let named: Vec<&str> = own.iter().map(|(direction, _)| direction.name()).collect();
        Err(refused(match clamped.place(&Dof::new(node, direction)) {
            Some(_) => format!("dof {node}.{} is clamped; expected a free dof", direction.name()),
            None => format!(
                "node {node} has no dof in {}; expected some of {}",
                direction.name(),
                named.join(", ")
            ),
        }))
    };
    wanted.into_iter().map(of).collect()
}

impl Interface {
    /// Reads `tip=428` or `tip=428.xz`.
    ///
    /// # Errors
    /// An error for another form, an unknown node, and a clamped dof.
    pub fn read(text: &str, dofs: &Dofs, clamped: &Dofs) -> Result<Self> {
        let what = format!("--interface {text}");
        let Some((name, node)) = text.split_once('=') else {
            return Err(Error::new(what, "expected NAME=NODE or NAME=NODE.DIRECTIONS, such as tip=428.xz"));
        };
        let (name, node) = (name.trim(), node.trim());
        let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic())
            && name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
        if !is_name {
            let problem = "expected a name of letters, digits, _ and -, that begins with a letter";
            return Err(Error::new(what, problem));
        }
        Ok(Self { name: name.into(), dofs: rows(node, dofs, clamped, &what)? })
    }

    /// Name of one of its dofs: `tip.x`, or `tip` for a node without directions.
    pub fn label(&self, direction: Direction) -> String {
        match direction {
            Direction::None => self.name.clone(),
            direction => format!("{}.{}", self.name, direction.name()),
        }
    }
}

/// Refuses two nodes of one name, and a dof of two nodes.
///
/// # Errors
/// An error with the name or the dof.
pub fn check(interfaces: &[Interface], dofs: &Dofs) -> Result<()> {
    let mut rows = Vec::new();
    for (i, one) in interfaces.iter().enumerate() {
        let what = format!("--interface {}", one.name);
        if interfaces[..i].iter().any(|other| other.name == one.name) {
            return Err(Error::new(what, "given twice; expected different names"));
        }
        for (_, row) in &one.dofs {
            if rows.contains(row) {
                let problem = format!(
                    "dof {} also belongs to another interface node; expected each dof once",
                    dofs.list()[*row]
                );
                return Err(Error::new(what, problem));
            }
            rows.push(*row);
        }
    }
    Ok(())
}
