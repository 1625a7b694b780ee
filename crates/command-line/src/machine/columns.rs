//! Columns of `states.csv` by name (`--columns`).

use crate::{Error, Result};
use vibro_machine::Description;
use vibro_machine::quantity::NamedQuantity;
use vibro_studies::unknown;

/// The requested columns.
#[derive(Clone, Debug, Default)]
pub struct Chosen {
    /// Their names in order; empty for all default columns of a record.
    pub names: Vec<String>,
    /// The requested columns that a record does not have by default: coordinates of bodies with
    /// many, states of blocks.
    pub further: Vec<NamedQuantity>,
}

impl Chosen {
    /// The columns of a machine that names refer to: a column (`box.s`, `tube.q[3].v`,
    /// `pid.x[0]`), or a body or an element (`box`, `stop.steel`) for all its columns.
    ///
    /// # Errors
    /// [`Error::Refused`] for an unknown name, with the nearest one, and for a column named twice.
    pub fn of(d: &Description, names: &[String]) -> Result<Self> {
        let own = d.named_quantities();
        let mut inner: Vec<_> = (0..d.bodies.len()).flat_map(|body| d.inner_quantities(body)).collect();
        let states: Vec<_> = (0..d.blocks.len()).flat_map(|i| d.quantities_of_block(i, false)).collect();
        inner.extend(states.iter().cloned());
        let mut chosen = Self::default();
        for name in names {
            let plain = d.elements().find(|element| element.dotted() == *name);
            let plain = plain.map_or(name.as_str(), |element| element.name());
            let is_meant = |column: &&NamedQuantity| {
                let of = column.name.rsplit_once('.').map_or("", |(of, _)| of);
                // A block has many states, so each is named individually.
                column.name == plain || (of == plain && !states.contains(column))
            };
            let found: Vec<_> = own.iter().chain(&inner).filter(is_meant).collect();
            if name.is_empty() {
                let problem = "a name is missing at a comma; expected names such as box.s,steel.f".into();
                return Err(Error::Refused { what: "--columns".into(), problem });
            }
            if found.is_empty() {
                let all = own.iter().chain(&inner).map(|column| column.name.clone());
                let all: Vec<String> = all.chain(d.elements().map(|element| element.dotted())).collect();
                let problem = unknown(name, &all).to_string();
                return Err(Error::Refused { what: format!("--columns {name}"), problem });
            }
            for column in found {
                if chosen.names.contains(&column.name) {
                    let problem = format!("names {} twice; list each column once", column.name);
                    return Err(Error::Refused { what: format!("--columns {name}"), problem });
                }
                chosen.names.push(column.name.clone());
                if inner.contains(column) {
                    chosen.further.push(column.clone());
                }
            }
        }
        Ok(chosen)
    }
}
