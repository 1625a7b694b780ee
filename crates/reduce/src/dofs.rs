//! Names of degrees of freedom: `node.direction`.

use crate::{Error, Result};
use std::collections::HashMap;
use std::fmt;

/// Direction of a dof at its node.
#[derive(Clone, Copy, Debug, Eq, Hash, Ord, PartialEq, PartialOrd)]
pub enum Direction {
    /// No direction: a scalar point, or a row of a matrix without names.
    None,
    /// Displacement along x.
    X,
    /// Displacement along y.
    Y,
    /// Displacement along z.
    Z,
    /// Rotation about x.
    Rx,
    /// Rotation about y.
    Ry,
    /// Rotation about z.
    Rz,
}

use Direction::{Rx, Ry, Rz, X, Y, Z};

impl Direction {
    /// The six directions in the order of their numbers, 1 to 6.
    pub const ALL: [Self; 6] = [X, Y, Z, Rx, Ry, Rz];

    /// Whether the dof is an angle.
    pub fn is_rotation(self) -> bool {
        matches!(self, Rx | Ry | Rz)
    }

    /// Name of the direction; empty for a dof without one.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "",
            X => "x",
            Y => "y",
            Z => "z",
            Rx => "rx",
            Ry => "ry",
            Rz => "rz",
        }
    }

    /// The direction with the number 1 to 6; 0 is a dof without one.
    pub fn of_number(number: u32) -> Option<Self> {
        if number == 0 { Some(Self::None) } else { Self::ALL.get(number as usize - 1).copied() }
    }

    /// The direction with a name (`x`, `rx`, `UX`, `ROTX`) or a number (`1`).
    pub fn of_name(text: &str) -> Option<Self> {
        let text = text.to_ascii_lowercase();
        let short = text.strip_prefix("rot").map(|axis| format!("r{axis}"));
        let short = short.or_else(|| text.strip_prefix('u').map(str::to_owned)).unwrap_or(text);
        let named = Self::ALL.into_iter().find(|direction| direction.name() == short);
        named.or_else(|| short.parse().ok().filter(|k| *k > 0).and_then(Self::of_number))
    }
}

/// A degree of freedom.
#[derive(Clone, Debug, Eq, Hash, Ord, PartialEq, PartialOrd)]
pub struct Dof {
    /// Name of the node, in most programs a number.
    pub node: String,
    /// Direction of the displacement or rotation.
    pub direction: Direction,
}

impl Dof {
    /// The dof of a node in a direction.
    pub fn new(node: impl Into<String>, direction: Direction) -> Self {
        Self { node: node.into(), direction }
    }

    /// Reads `428.x`, `428.1`, `428.ux`, or a name without a direction.
    pub fn read(text: &str) -> Option<Self> {
        let text = text.trim();
        let (node, direction) = match text.rsplit_once('.') {
            Some((node, direction)) => (node, Direction::of_name(direction)?),
            None => (text, Direction::None),
        };
        let is_name = !node.is_empty() && node.chars().all(|c| c.is_alphanumeric() || "_-".contains(c));
        is_name.then(|| Self::new(node, direction))
    }
}

impl fmt::Display for Dof {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.direction {
            Direction::None => f.write_str(&self.node),
            direction => write!(f, "{}.{}", self.node, direction.name()),
        }
    }
}

/// The dofs of a model in the order of the rows of its matrices.
#[derive(Clone, Debug, Default)]
pub struct Dofs {
    list: Vec<Dof>,
    places: HashMap<Dof, usize>,
}

impl Dofs {
    /// The dofs of a list.
    ///
    /// # Errors
    /// An error if a dof is in the list twice.
    pub fn new(list: Vec<Dof>) -> Result<Self> {
        let mut places = HashMap::with_capacity(list.len());
        for (i, dof) in list.iter().enumerate() {
            if let Some(first) = places.insert(dof.clone(), i) {
                let problem =
                    format!("rows {} and {} have this name; expected one row for each dof", first + 1, i + 1);
                return Err(Error::new(format!("dof {dof}"), problem));
            }
        }
        Ok(Self { list, places })
    }

    /// Dofs without names: the numbers of their rows, counted from 1.
    pub fn numbered(count: usize) -> Self {
        let list: Vec<Dof> = (1..=count).map(|k| Dof::new(k.to_string(), Direction::None)).collect();
        let places = list.iter().cloned().zip(0..).collect();
        Self { list, places }
    }

    /// Number of dofs.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The dofs in the order of the rows.
    pub fn list(&self) -> &[Dof] {
        &self.list
    }

    /// Row of a dof.
    pub fn place(&self, dof: &Dof) -> Option<usize> {
        self.places.get(dof).copied()
    }

    /// The directions that a node has, in rising order, with their rows.
    pub fn of_node(&self, node: &str) -> Vec<(Direction, usize)> {
        let of = |direction| Some((direction, self.place(&Dof::new(node, direction))?));
        std::iter::once(Direction::None).chain(Direction::ALL).filter_map(of).collect()
    }

    /// Message about an unknown node, with the nearest name.
    pub fn nearest_node(&self, node: &str) -> String {
        let close = |own: &&Dof| strsim::damerau_levenshtein(&own.node, node);
        match self.list.iter().min_by_key(close) {
            Some(own) => format!("no such node; did you mean {}?", own.node),
            None => "no such node".into(),
        }
    }

    /// The dofs at these rows.
    pub fn kept(&self, rows: &[usize]) -> Self {
        let list: Vec<Dof> = rows.iter().map(|&row| self.list[row].clone()).collect();
        let places = list.iter().cloned().zip(0..).collect();
        Self { list, places }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_names_of_dofs_are_read_in_each_spelling() {
        for text in ["428.x", "428.1", "428.UX", "428.ux"] {
            assert_eq!(Dof::read(text), Some(Dof::new("428", X)), "{text}");
        }
        for text in ["7.rz", "7.6", "7.ROTZ"] {
            assert_eq!(Dof::read(text), Some(Dof::new("7", Rz)), "{text}");
        }
        assert_eq!(Dof::read("17"), Some(Dof::new("17", Direction::None)));
        for text in ["", ".x", "7.w", "7.0", "7.7", "a b.x"] {
            assert_eq!(Dof::read(text), None, "{text}");
        }
        assert_eq!(Dof::new("7", Rz).to_string(), "7.rz");
    }

    #[test]
    fn invariant_a_dof_has_one_row() {
        let twice = Dofs::new(vec![Dof::new("1", X), Dof::new("1", Y), Dof::new("1", X)]).unwrap_err();
        assert_eq!(twice.to_string(), "dof 1.x: rows 1 and 3 have this name; expected one row for each dof");
    }
}
