//! The plan of a machine: its file, its checked assembly, its variables and its instantiation
//! token.

use crate::problem::MachineProblem;
use crate::table::VariableTable;
use fmi_doors::identifier::identifier;
use fmi_doors::{Instantiation, Version};
use std::io::Read;
use std::path::Path;
use std::sync::{Arc, OnceLock};
use vibro_machine::file::{no_records, parse};
use vibro_machine::{Assembly, Description};

/// Name of the machine's file in the FMU's `resources` folder. Records are included in it: no
/// other file is read.
pub const FILE: &str = "machine.toml";

/// Largest size of the file, bytes.
const MOST_BYTES: u64 = 64 << 20;

/// A machine that is ready to be instantiated, with its variables.
///
///
/// ```
/// use vibro_machine_component::{Plan, Role};
///
/// let text = r#"
///     name = "Ball"
///     gravity = 9.81
///     body.ball = { mass = "20 g", gravity = 1.0 }
///     stop.floor = { between = ["ground", "ball"], gap = "1 m", restitution = 0.9 }
/// "#;
/// let plan = Plan::new(text.to_owned(), "ball.toml")?;
/// let row = |name: &str| &plan.table.rows[plan.table.reference(name).unwrap() as usize - 1];
/// assert_eq!((row("ball.v").role, row("ball.v").unit), (Role::Output, "m/s"));
/// assert_eq!(row("stop.floor.gap").role, Role::Tunable);
/// assert_eq!(plan.table.reference("floor.gap"), None);
/// assert_eq!(plan.token(), Plan::token_of(text));
/// # Ok::<(), vibro_machine_component::MachineProblem>(())
/// ```
#[derive(Debug)]
pub struct Plan {
    /// The variables.
    pub table: VariableTable,
    /// The machine with all parameters at their start values.
    pub assembly: Arc<Assembly>,
    /// Nominal values of the continuous states.
    pub nominals: Vec<f64>,
    /// The continuous states with their rates, in order. States and outputs of sampled blocks
    /// belong to the assembly's state, but are not continuous.
    pub states: Vec<[vibro_machine::Quantity; 2]>,
    /// The index of each continuous state among the assembly's states.
    pub(crate) places: Vec<usize>,
    /// The number of the assembly's states.
    pub(crate) size: usize,
    /// Whether derivatives have tunable parameters and time as knowns, as in FMI 3.0 (FMI 3.0.2,
    /// 2.4.8).
    pub(crate) knows_parameters: bool,
    token: String,
    text: String,
}

impl Plan {
    /// Creates the plan of the machine in the text of a [`FILE`]; messages call the file `file`.
    ///
    /// # Errors
    /// [`MachineProblem::Machine`] with every problem found; [`MachineProblem::Motion`] for a
    /// machine that cannot start.
    pub fn new(text: String, file: &str) -> Result<Self, MachineProblem> {
        let machine = parse(&text, file, &no_records)?;
        let assembly = Arc::new(Assembly::new(machine)?);
        let token = token(&text);
        let table = VariableTable::new(&assembly.description);
        let (nominals, states) = (assembly.nominals(), assembly.state_quantities());
        let size = states.len();
        let moves = |place: &usize| assembly.description.sampled_block(states[*place][0]).is_none();
        let places: Vec<usize> = (0..size).filter(moves).collect();
        let nominals = places.iter().map(|&place| nominals[place]).collect();
        let states = places.iter().map(|&place| states[place]).collect();
        Ok(Self { table, assembly, nominals, states, places, size, knows_parameters: true, token, text })
    }

    /// Creates the plan of a description, written as a file with its records included.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of(machine: &Description) -> Result<Self, MachineProblem> {
        Self::new(machine.to_toml(), FILE)
    }

    /// Adds the matrices of derivatives over a step. These need a separate model description, for
    /// FMI 3.0 only, since several importers cannot read arrays.
    ///
    ///
    /// ```
    /// use vibro_machine_component::{Plan, Role};
    ///
    /// # let text = r#"
    /// #     name = "Ball"
    /// #     gravity = 9.81
    /// #     body.ball = { mass = "20 g", gravity = 1.0 }
    /// #     stop.floor = { between = ["ground", "ball"], gap = "1 m", restitution = 0.9 }
    /// # "#;
    /// let plan = Plan::new(text.to_owned(), "ball.toml")?.with_arrays();
    /// let matrices = plan.table.rows.iter().filter(|row| row.role == Role::Sensitivity);
    /// let sizes: Vec<_> = matrices.map(|row| row.dimensions.clone()).collect();
    /// assert!(sizes.contains(&vec![2, 2])); // the state after a step by the state before it
    /// assert_ne!(plan.token(), Plan::token_of(text));
    /// # Ok::<(), vibro_machine_component::MachineProblem>(())
    /// ```
    #[must_use]
    pub fn with_arrays(mut self) -> Self {
        self.token = token_with_arrays(&self.text);
        self.table.add_matrices(self.size);
        self
    }

    /// Creates the plan for an instantiation from the file in its resources. The token must match.
    ///
    /// # Errors
    /// [`MachineProblem::File`] if the file is neither in the host's folder nor next to the
    /// library. [`MachineProblem::Door`] if the host names no folder. [`MachineProblem::Text`] if
    /// the token belongs to another text. Otherwise as [`new`](Self::new).
    pub(crate) fn asked_for(request: &Instantiation<'_>) -> Result<Self, MachineProblem> {
        let places = request.resource_folders();
        let mut read = places.iter().map(|folder| folder.join(FILE)).map(|file| (read(&file), file));
        let found = read.by_ref().find_map(|(read, file)| Some((read.ok()?, file.display().to_string())));
        let Some((text, name)) = found else {
            // Report the problem of the host's folder, or that the host named none.
            let file = request.resource_folder()?.join(FILE);
            let problem = self::read(&file).err().unwrap_or_default();
            return Err(MachineProblem::File { file: file.display().to_string(), problem });
        };
        if request.version == Version::Fmi3 && request.token == token_with_arrays(&text) {
            return Ok(Self::new(text, &name)?.with_arrays());
        }
        request.check_token(&token(&text)).map_err(|token| {
            // The refusal of a damaged file names its faulty line; the file of another machine
            // parses.
            let damage = parse(&text, &name, &no_records).err().map(|refusal| refusal.to_string());
            MachineProblem::Text { place: damage.unwrap_or(name.clone()), token }
        })?;
        Ok(Self { knows_parameters: request.version == Version::Fmi3, ..Self::new(text, &name)? })
    }

    /// Returns the instantiation token of the machine whose [`FILE`] has this text.
    pub fn token_of(text: &str) -> String {
        token(text)
    }

    /// The instantiation token, which depends on the file, the library's version and the arrays.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// The token without arrays, common to both model descriptions of a machine.
    pub(crate) fn machine_token(&self) -> String {
        token(&self.text)
    }

    /// Selects the continuous states, or their derivatives, from all states of an assembly.
    pub(crate) fn continuous(&self, all: &[f64]) -> Vec<f64> {
        self.places.iter().map(|&place| all[place]).collect()
    }

    /// The text of the [`FILE`].
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the name of the machine, of the model and of the library's file.
    pub fn name(&self) -> &str {
        &self.assembly.description.name
    }

    /// Returns the machine with these values of all parameters, in the table's order. `under_way`
    /// leaves the start values unchecked, since the motion has begun.
    ///
    /// # Errors
    /// [`MachineProblem::Machine`] and [`MachineProblem::Motion`] if the values together give no
    /// machine.
    pub(crate) fn machine(&self, values: &[f64], under_way: bool) -> Result<Arc<Assembly>, MachineProblem> {
        let start = self.table.parameters.iter().map(|parameter| parameter.value);
        if start.eq(values.iter().copied()) {
            return Ok(self.assembly.clone());
        }
        let parameters = self.table.parameters.iter().zip(values);
        let changed = parameters.filter(|(parameter, value)| parameter.value != **value);
        let changed = changed.map(|(parameter, value)| (parameter.name.as_str(), *value));
        let own = &self.assembly.description;
        let machine = if under_way { own.under_way(changed) } else { own.with(changed) };
        Ok(Arc::new(Assembly::new(machine?)?))
    }
}

/// Hash of a file's text and of the library's version, which determine the numbering of variables.
fn token(text: &str) -> String {
    identifier(&format!("{} {}\n{text}", env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")))
}

/// Returns the token of the model description with arrays.
fn token_with_arrays(text: &str) -> String {
    identifier(&format!("{} with arrays {}\n{text}", env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")))
}

/// Reads a file of the archive's resources by its path in their folder.
pub type ResourceReader = fn(&str) -> Result<Vec<u8>, String>;

static READER: OnceLock<ResourceReader> = OnceLock::new();

/// Reads resources by a function of the host from now on, for libraries without a file system.
/// Only the first call has an effect.
pub fn read_resources_by(reader: ResourceReader) {
    let _ = READER.set(reader);
}

fn read(file: &Path) -> Result<String, String> {
    let long = || format!("it has more than {MOST_BYTES} bytes");
    if let Some(reader) = READER.get() {
        let bytes = reader(FILE)?;
        let text = if bytes.len() as u64 > MOST_BYTES { Err(long()) } else { Ok(bytes) }?;
        return String::from_utf8(text).map_err(|error| error.to_string());
    }
    let mut text = String::new();
    let opened = std::fs::File::open(file);
    let read = opened.and_then(|file| file.take(MOST_BYTES + 1).read_to_string(&mut text));
    match read {
        Ok(_) if text.len() as u64 > MOST_BYTES => Err(long()),
        Ok(_) => Ok(text),
        Err(error) => Err(error.to_string()),
    }
}
