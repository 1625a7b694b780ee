//! The table of a sweep, as CSV and as Parquet, written row by row.

use super::words::Labelled;
use crate::subject::Subject;
use crate::table::{column_in, exact, shown};
use crate::whole_file::write_whole_by;
use crate::{Error, Result};
use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use vibro_studies::design_sweep::{Again, Choice, DesignRow, SweepRequest, choice, each_final_row};
use vibro_studies::paper::Unit;
use vibro_studies::parts::Task;

/// Number of rows of a Parquet row group. These rows are in memory at the same time.
const ROW_GROUP: usize = 65_536;

/// Column of the table.
struct SweepColumn {
    name: String,
    /// SI unit; `None` for text.
    unit: Option<String>,
}

/// Cell of the table.
enum Cell {
    Number(f64),
    Text(String),
    Empty,
}

impl Cell {
    fn number(value: Option<f64>) -> Self {
        // -inf is a valid value of an exponent; NaN means a missing value.
        value.filter(|v| !v.is_nan()).map_or(Self::Empty, Self::Number)
    }

    fn text(words: String) -> Self {
        if words.is_empty() { Self::Empty } else { Self::Text(words) }
    }
}

/// Columns: parameters; outputs; reason; spreads of the outputs; periods of the window; number of
/// values between the values of `over`. If a design has several motions, an output has its
/// smallest, mean and largest value, and the motion with the largest.
fn columns<M: Labelled>(set: &M, request: &SweepRequest<M>) -> Vec<SweepColumn> {
    let number = |name: String, unit: &str| SweepColumn { name, unit: Some(unit.into()) };
    let text = |name: String| SweepColumn { name, unit: None };
    let names = request.designs.names();
    let mut all: Vec<SweepColumn> = names.iter().map(|n| number(M::name(n), &set.si_unit(n))).collect();
    for measure in &request.measures {
        let (name, unit) = (measure.to_string(), set.measure_unit(measure));
        match (M::is_class(measure), request.motions()) {
            (true, _) => all.push(text(name)),
            (_, 1) => all.push(number(name, unit)),
            _ => {
                all.extend(["min", "mean", "max"].map(|what| number(format!("{name}.{what}"), unit)));
                let axes = request.over.iter().map(|a| &a.name);
                all.extend(axes.map(|n| number(format!("{name}.max.{}", M::name(n)), &set.si_unit(n))));
                if request.starts.len() > 1 {
                    all.push(text(format!("{name}.max.start")));
                }
            }
        }
    }
    all.push(text("reason".into()));
    for measure in request.measures.iter().filter(|m| M::is_of_window(m)) {
        all.push(number(format!("{measure}.spread"), set.measure_unit(measure)));
    }
    all.extend(["periods", "between"].map(|name| number(name.into(), "1")));
    for (_, unit, name) in written(set, &all) {
        all.push(number(name, unit.plain()));
    }
    all
}

/// The columns of parameters that were written in a unit other than SI: index, unit, name of the
/// column in that unit.
fn written(set: &dyn Subject, columns: &[SweepColumn]) -> Vec<(usize, &'static Unit, String)> {
    let unit = |(i, c): (usize, &SweepColumn)| {
        let unit = set.unit_of_column(&c.name)?;
        Some((i, unit, column_in(&c.name, unit)))
    };
    columns.iter().enumerate().filter_map(unit).collect()
}

/// The cells of a row, in the order of the [`columns`].
fn cells<M: Labelled>(
    request: &SweepRequest<M>,
    written: &[(usize, &'static Unit, String)],
    row: DesignRow,
) -> Vec<Cell> {
    let mut all: Vec<Cell> = row.values.iter().map(|v| Cell::number(Some(*v))).collect();
    for (measure, output) in request.measures.iter().zip(&row.outputs) {
        match (M::is_class(measure), request.motions()) {
            (true, _) => {
                let classes: Vec<String> = row.classes.iter().map(|c| c.name()).collect();
                all.push(Cell::text(classes.join("; ")));
            }
            (_, 1) => all.push(Cell::number(output.map(|o| o.largest))),
            _ => {
                let parts = output.map(|o| [o.least, o.mean, o.largest]);
                all.extend((0..3).map(|k| Cell::number(parts.map(|p| p[k]))));
                let motion = output.map(|o| row.motion(request, o.at));
                for axis in 0..request.over.len() {
                    all.push(Cell::number(motion.as_ref().and_then(|m| m.0.get(axis).copied())));
                }
                if request.starts.len() > 1 {
                    all.push(Cell::text(motion.map_or(String::new(), |m| m.1.to_string())));
                }
            }
        }
    }
    all.push(Cell::text(row.reason.unwrap_or_default()));
    let measured = request.measures.iter().zip(&row.outputs).filter(|(m, _)| M::is_of_window(m));
    all.extend(measured.map(|(_, output)| Cell::number(output.map(|o| o.spread))));
    let again = row.again.unwrap_or(Again { periods: request.periods, between: Vec::new() });
    all.extend([f64::from(again.periods), again.between.len() as f64].map(|x| Cell::number(Some(x))));
    for (place, unit, _) in written {
        let cell = match all[*place] {
            Cell::Number(value) => Cell::Number(shown(unit, value)),
            _ => Cell::Empty,
        };
        all.push(cell);
    }
    all
}

/// Writes the tables of a sweep whose parts are all in the task's store: `stem.csv` and
/// `stem.parquet`.
///
/// # Errors
/// [`Error::File`], [`Error::Output`].
pub fn write_tables<M: Labelled>(set: &M, request: &SweepRequest<M>, task: &Task, stem: &Path) -> Result<()> {
    // Endings are appended, since a stem may contain a point.
    let path = |ending: &str| {
        let name = stem.file_name().unwrap_or_default().to_string_lossy();
        stem.with_file_name(format!("{name}.{ending}"))
    };
    let choice = choice(set, request, task)?;
    let rows = (task, choice.as_ref());
    write_whole_by(&path("csv"), |file| write_csv(set, request, rows, file))?;
    write_whole_by(&path("parquet"), |file| write_parquet(set, request, rows, file))
}

/// The store with the rows' parts, and the choice with the rows measured again.
type MeasuredRows<'a> = (&'a Task<'a>, Option<&'a Choice>);

fn write_csv<M: Labelled>(
    set: &M,
    request: &SweepRequest<M>,
    rows: MeasuredRows<'_>,
    file: &mut impl Write,
) -> Result<()> {
    let mut csv = csv::Writer::from_writer(file);
    let problem = Error::output("a table");
    let columns = columns(set, request);
    let written = written(set, &columns);
    csv.write_record(columns.iter().map(|c| &c.name)).map_err(&problem)?;
    each_final_row(set, request, rows, |row| {
        let text = |cell: Cell| match cell {
            Cell::Number(value) => exact(value),
            Cell::Text(words) => words,
            Cell::Empty => String::new(),
        };
        csv.write_record(cells(request, &written, row).into_iter().map(text)).map_err(&problem)
    })?;
    csv.flush().map_err(Error::output("a table"))
}

/// Rows of the next row group, by columns.
struct Waiting {
    columns: Vec<Vec<Cell>>,
}

impl Waiting {
    fn new(count: usize) -> Self {
        Self { columns: (0..count).map(|_| Vec::new()).collect() }
    }

    fn len(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    fn push(&mut self, row: Vec<Cell>) {
        self.columns.iter_mut().zip(row).for_each(|(column, cell)| column.push(cell));
    }

    /// Writes the rows as a row group and clears them.
    fn write<W: Write + Send>(
        &mut self,
        about: &[SweepColumn],
        writer: &mut SerializedFileWriter<W>,
    ) -> parquet::errors::Result<()> {
        let mut group = writer.next_row_group()?;
        for (column, cells) in about.iter().zip(&mut self.columns) {
            let Some(mut into) = group.next_column()? else { break };
            let levels: Vec<i16> = cells.iter().map(|c| i16::from(!matches!(c, Cell::Empty))).collect();
            if column.unit.is_some() {
                let values: Vec<f64> = cells
                    .iter()
                    .filter_map(|c| if let Cell::Number(v) = c { Some(*v) } else { None })
                    .collect();
                into.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?;
            } else {
                let word = |c: &Cell| match c {
                    Cell::Text(words) => Some(ByteArray::from(words.as_str())),
                    _ => None,
                };
                let values: Vec<ByteArray> = cells.iter().filter_map(word).collect();
                into.typed::<ByteArrayType>().write_batch(&values, Some(&levels), None)?;
            }
            into.close()?;
            cells.clear();
        }
        group.close()?;
        Ok(())
    }
}

/// Parquet schema of the columns; every cell may be null.
fn schema(columns: &[SweepColumn]) -> parquet::errors::Result<Type> {
    let field = |column: &SweepColumn| {
        let (physical, logical) = match column.unit {
            Some(_) => (PhysicalType::DOUBLE, None),
            None => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let builder = Type::primitive_type_builder(&column.name, physical).with_logical_type(logical);
        Ok(Arc::new(builder.with_repetition(Repetition::OPTIONAL).build()?))
    };
    let fields = columns.iter().map(field).collect::<parquet::errors::Result<Vec<_>>>()?;
    Type::group_type_builder("sweep").with_fields(fields).build()
}

fn write_parquet<M: Labelled>(
    set: &M,
    request: &SweepRequest<M>,
    rows: MeasuredRows<'_>,
    file: &mut (impl Write + Send),
) -> Result<()> {
    let problem = Error::output("a Parquet file");
    let columns = columns(set, request);
    let written = written(set, &columns);
    let units = columns.iter().filter_map(|c| Some((format!("unit.{}", c.name), c.unit.clone()?)));
    let units = units.map(|(key, unit)| KeyValue { key, value: Some(unit) }).collect();
    let properties = WriterProperties::builder().set_key_value_metadata(Some(units)).build();
    let schema = Arc::new(schema(&columns).map_err(&problem)?);
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties)).map_err(&problem)?;
    let mut waiting = Waiting::new(columns.len());
    each_final_row(set, request, rows, |row| {
        waiting.push(cells(request, &written, row));
        if waiting.len() < ROW_GROUP {
            return Ok(());
        }
        waiting.write(&columns, &mut writer).map_err(&problem)
    })?;
    if waiting.len() > 0 {
        waiting.write(&columns, &mut writer).map_err(&problem)?;
    }
    writer.close().map(|_| ()).map_err(&problem)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An impact with restitution 0 ends every variation: the exponent is -inf.
    #[test]
    fn an_exponent_of_minus_infinity_is_no_empty_cell() {
        assert!(matches!(Cell::number(Some(f64::NEG_INFINITY)), Cell::Number(v) if v == f64::NEG_INFINITY));
        assert!(matches!(Cell::number(Some(f64::NAN)), Cell::Empty));
        assert!(matches!(Cell::number(None), Cell::Empty));
    }
}
