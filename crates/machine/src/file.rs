//! The file of a machine: from TOML text to a checked [`Description`], and back.
//!
//! `docs/machine-file.md` is the reference of the format. All problems of a file are reported at
//! once, each with line, dotted name, value, the allowed values and, for an unknown name, the
//! nearest known name:
//!
//! ```
//! use vibro_machine::file::{no_records, parse};
//!
//! let text = r#"
//! name = "Bouncer"
//! [body.ball]
//! mass = "20 g"
//! [stop.floor]
//! between = ["ground", "bal"]
//! gap = "1 N"
//! restitution = 0.9
//! "#;
//! let refused = parse(text, "ball.toml", &no_records).unwrap_err();
//! assert_eq!(
//!     refused.to_string(),
//!     "ball.toml:6: stop.floor.between[1] = \"bal\": no body has this name; \
//!      did you mean `ball`?\n\
//!      ball.toml:7: stop.floor.gap = \"1 N\": cannot be in `N`; \
//!      expected one of m, cm, mm, um, in"
//! );
//! ```

mod any_unit;
mod blocks;
mod bodies;
mod completion;
mod contacts;
mod curve;
mod edit;
mod elements;
mod flexible;
mod follows;
mod formula;
mod matrices;
mod matrix;
mod named;
mod numbers;
mod points;
mod powers;
mod reading;
mod records;
mod residual;
mod series;
mod signals;
mod start;
mod stepped;
mod stribeck;
mod syntax;
mod write;

pub use completion::{Completion, completion};
pub use edit::with_numbers;
pub use records::{no_records, records_beside};

use crate::check::{check, check_structure};
use crate::description::{Description, Dimension};
use crate::elements::SECTIONS;
use crate::kinds;
use crate::refusal::{Problem, Refusal};
use reading::{FileTable, Reading};
use std::io::{self, Read};
use std::path::Path;

/// Reads the text of a record. The path is as in the machine's file: relative, and not above its
/// folder.
///
/// A program can keep records in memory:
///
/// ```
/// use vibro_machine::file::parse;
///
/// let records = |path: &str| match path {
///     "push.csv" => Ok("t/ms, f [kN]\n0, 0\n500, 2\n".to_owned()),
///     _ => Err(std::io::ErrorKind::NotFound.into()),
/// };
/// let text = "name = \"Pushed\"\nbody.a = { mass = 1.0 }\n\
///     load.push = { on = \"a\", table = \"push.csv\" }\n";
/// let machine = parse(text, "pushed.toml", &records)?;
/// let table = machine.loads[0].force.table.as_ref().unwrap();
/// assert_eq!(table.knots, [(0.0, 0.0), (0.5, 2000.0)]);
/// # Ok::<(), vibro_machine::Refusal>(())
/// ```
pub type Records<'a> = &'a dyn Fn(&str) -> io::Result<String>;

/// Largest size of a file or record, bytes.
const MOST_BYTES: u64 = 64 << 20;

/// Reads a machine from a file, and its records from the file's folder.
///
/// # Errors
/// A [`Refusal`] with every problem found, or with the reason why the file cannot be read.
///
/// # Examples
/// The bounces of this ball follow each other ever faster and end at (1 + ε)/(1 - ε) √(2h/g):
///
/// ```
/// use std::path::Path;
/// use vibro_machine::motion::EventKind;
/// use vibro_machine::{Assembly, Motion, file};
///
/// let machine = file::read(Path::new("../../examples/assembly/bouncing_ball.toml"))?;
/// let mut ball = Motion::new(Assembly::new(machine)?.into())?;
/// let mut ends = Vec::new();
/// ball.advance_observed(10.0, &mut |event| match event.kind {
///     EventKind::Close { .. } => ends.push(event.time),
///     _ => {}
/// })?;
/// let exact = 1.9 / 0.1 * (2.0 / 9.81f64).sqrt();
/// assert!(ends.len() == 1 && (ends[0] - exact).abs() < 1e-11 * exact);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read(path: &Path) -> Result<Description, Refusal> {
    read_by(path, check)
}

/// Reads a file like [`read`], for a machine whose numbers are changed before it is used.
/// Conditions on several numbers, such as a start within the gaps of rigid stops, are not checked;
/// [`Description::with`] checks them.
///
/// # Errors
/// As [`read`].
pub fn read_draft(path: &Path) -> Result<Description, Refusal> {
    read_by(path, check_structure)
}

fn read_by(path: &Path, check: Check) -> Result<Description, Refusal> {
    let (name, text) = (path.display().to_string(), text_of(path)?);
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    parse_by(&text, (&name, &records_beside(&folder)), check)
}

/// The fault of a file without keys.
const EMPTY: &str = "is empty; expected a machine: `name`, bodies such as [body.box] and elements such as \
                     [spring.mount]";

/// The checks of a machine that a text describes.
type Check = fn(&Description) -> Vec<Problem>;

/// The text of a file.
pub(crate) fn text_of(path: &Path) -> Result<String, Refusal> {
    let name = path.display();
    let unread = |e: io::Error| unread(&e, "save it with the encoding UTF-8");
    let cannot = |e: io::Error| Refusal::one(Problem::new("", None, format!("{name}: {}", unread(e))));
    read_text(path).map_err(cannot)
}

/// Why a file cannot be read, with advice for a file that is not UTF-8 text.
pub fn unread(error: &io::Error, advice: &str) -> String {
    match error.kind() {
        // A reader of records may say more, as the page in a browser does.
        io::ErrorKind::NotFound if error.get_ref().is_none() => "no such file".into(),
        io::ErrorKind::InvalidData => format!("is not UTF-8 text; {advice}"),
        io::ErrorKind::IsADirectory => "is a folder; expected a file".into(),
        _ => format!("cannot be read: {error}"),
    }
}

fn read_text(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    std::fs::File::open(path)?.take(MOST_BYTES + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MOST_BYTES {
        return Err(io::Error::other(format!("it has more than {MOST_BYTES} bytes")));
    }
    Ok(text)
}

/// Reads a machine from TOML text; messages call it `file`.
///
/// # Errors
/// A [`Refusal`] with every problem found.
///
/// # Examples
/// Numbers may have any unit of their dimension:
///
/// ```
/// use vibro_machine::file::{no_records, parse};
///
/// let text = r#"
///     name = "Ball"
///     gravity = "9.81 m/s2"
///     body.ball = { mass = "20 g", gravity = 1.0 }
///     stop.floor = { between = ["ground", "ball"], gap = "1 in", restitution = 0.9 }
/// "#;
/// let machine = parse(text, "ball.toml", &no_records)?;
/// assert_eq!((machine.name.as_str(), machine.gravity), ("Ball", 9.81));
/// assert_eq!((machine.bodies.len(), machine.stops[0].gap), (1, 0.0254));
/// # Ok::<(), vibro_machine::Refusal>(())
/// ```
pub fn parse(text: &str, file: &str, records: Records) -> Result<Description, Refusal> {
    parse_by(text, (file, records), check)
}

fn parse_by(text: &str, (file, records): (&str, Records), check: Check) -> Result<Description, Refusal> {
    let refusal = |problems| Refusal { file: file.into(), problems };
    let (root, broken) = syntax::toml(text);
    if !broken.is_empty() {
        return Err(refusal(broken));
    }
    if root.get_ref().is_empty() {
        return Err(refusal(vec![Problem::new("", None, EMPTY)]));
    }
    let mut reading = Reading::new(text, records);
    let machine = machine(&mut reading, &FileTable::root(root.get_ref()));
    if reading.problems.is_empty() {
        let found = check(&machine);
        found.into_iter().for_each(|problem| reading.place(problem));
    }
    match reading.finish() {
        problems if problems.is_empty() => Ok(machine),
        problems => Err(refusal(problems)),
    }
}

/// Top-level keys with a value, and top-level keys with tables other than [`SECTIONS`].
const VALUES: [&str; 3] = ["name", "gravity", "start"];
const TABLES: [&str; 2] = ["parameters", "body"];

fn machine(reading: &mut Reading, root: &FileTable) -> Description {
    let mut keys = [&VALUES[..], &TABLES[..]].concat();
    keys.extend(SECTIONS.iter().map(|(section, _)| section));
    reading.known(root, &keys);
    reading.check_names(root);
    let mut machine = Description::default();
    named::read(reading, root);
    if let Some(entry) = reading.required(root, "name", "expected a name, such as \"Damper\"") {
        machine.name = reading.string(&entry, "expected a name, such as \"Damper\"").unwrap_or_default();
    }
    if let Some(entry) = reading.optional(root, "gravity") {
        machine.gravity = reading.number(&entry, kinds::GRAVITY, Dimension::Translation).unwrap_or(0.0);
    }
    if let Some(entry) = reading.optional(root, "start") {
        machine.starts_at_rest = entry.value.as_str() == Some("rest");
        if !machine.starts_at_rest {
            let text = "expected \"rest\"; give any other start in the table of each body";
            reading.note_names(entry.value.as_str().unwrap_or_default(), ["rest"].into_iter());
            reading.refuse(&entry, text);
        }
    }
    let bodies = reading.section(root, "body");
    let mut names = bodies::read(reading, root, &bodies, &mut machine);
    flexible::read(reading, root, &mut names, &mut machine);
    matrix::read(reading, root, &mut names, &mut machine);
    if !root.has("gravity") {
        bodies::without_gravity(reading, &machine);
    }
    elements::read(reading, root, &names, &mut machine);
    contacts::read(reading, root, &names, &mut machine);
    blocks::read(reading, root, &names, &mut machine);
    elements::follow(reading, root, &mut machine);
    named::put(reading, &mut machine);
    machine
}

impl Description {
    /// The text of a file that reads back to an equal machine: SI units, numbers with all digits,
    /// records within the text. Requires a description that [`check`](Self::check) accepts.
    ///
    /// ```
    /// use vibro_machine::file::{no_records, parse};
    ///
    /// let text = r#"
    ///     name = "A"
    ///     [body.b]
    ///     mass = "3 g"
    ///     [spring.s]
    ///     between = ["ground", "b"]
    ///     stiffness = "1 N/mm"
    /// "#;
    /// let machine = parse(text, "a.toml", &no_records)?;
    /// assert!(machine.to_toml().contains("mass = 0.003\n"));
    /// assert_eq!(parse(&machine.to_toml(), "written.toml", &no_records)?, machine);
    /// # Ok::<(), vibro_machine::Refusal>(())
    /// ```
    pub fn to_toml(&self) -> String {
        write::machine(self)
    }
}
