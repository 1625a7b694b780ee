//! Records as tables of text: values over time, and times of contacts.

use super::Measured;
use crate::QuantityName;
use crate::error::{Error, Result};
use vibro_machine::description::Description;
use vibro_machine::table::{Heading, Table, in_unit};

/// The place of a column.
fn place(names: &[Heading], name: &str) -> Result<usize> {
    names.iter().position(|own| own.name == name).ok_or_else(|| {
        let known: Vec<&str> = names.iter().map(|own| own.name).collect();
        let known = known.join(", ");
        if known.is_empty() {
            return wrong(format!(
                "is empty; expected a first line that names the columns, such as {name},box.s"
            ));
        }
        wrong(format!("no column is called `{name}` (found {known}); the first line must name the columns"))
    })
}

fn wrong(problem: String) -> Error {
    Error::Described { problem }
}

impl Measured {
    /// Adds the columns of a table whose first line names `time` and quantities such as `box.s`.
    /// A unit in the heading must be a unit of the machine's quantity. Without a machine the
    /// columns other than `time` are as in the table.
    ///
    /// # Errors
    /// [`Error::Described`] for a column without a meaning, a unit that is not a unit of its
    /// column, and a cell that is not a number.
    pub fn add_columns(&mut self, table: &Table, d: Option<&Description>) -> Result<()> {
        let time = place(&table.names(), "time")?;
        let mut names: Vec<QuantityName> = Vec::new();
        for (i, own) in table.names().iter().enumerate().filter(|(i, _)| *i != time) {
            names.push(own.name.parse().map_err(|error| wrong(format!("column {}: {error}", i + 1)))?);
        }
        let unit = |name: &str| match name {
            "time" => Some("s"),
            name => d.and_then(|d| Some(name.parse::<QuantityName>().ok()?.find(d).ok()?.unit)),
        };
        let mut columns = table.columns(&unit).map_err(wrong)?;
        self.times = columns.remove(time).1;
        self.columns.extend(names.into_iter().zip(columns.into_iter().map(|(_, values)| values)));
        Ok(())
    }

    /// Adds the times of contacts of a table with the columns `element` and `time`.
    ///
    /// # Errors
    /// [`Error::Described`] for a table without these columns, and for a time that is not a number.
    pub fn add_contacts(&mut self, table: &Table) -> Result<()> {
        let names = table.names();
        let (element, time) = (place(&names, "element")?, place(&names, "time")?);
        let refused = |text: String| wrong(table.rows[0].refused(&text));
        let unit = names[time].unit("s").map_err(refused)?;
        for row in &table.rows[1..] {
            table.check(row, names.len()).map_err(wrong)?;
            let at = in_unit(unit, table.number(row, row.cells[time]).map_err(wrong)?);
            match self.contacts.iter_mut().find(|(own, _)| own == row.cells[element]) {
                Some((_, times)) => times.push(at),
                None => self.contacts.push((row.cells[element].to_owned(), vec![at])),
            }
        }
        Ok(())
    }
}
