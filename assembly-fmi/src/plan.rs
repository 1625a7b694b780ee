//! What is known of a machine before it moves: its file, its variables, and what tells it apart
//! from others.

use crate::problem::MachineProblem;
use crate::table::VariableTable;
use fmi_doors::identifier::identifier;
use fmi_doors::{Instantiation, Version};
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use vibro_assembly::file::{no_records, parse};
use vibro_assembly::{Assembly, Description};

/// The machine's file in the folder of the FMU's resources. It has its records within itself: no
/// other file is read.
pub const FILE: &str = "machine.toml";

/// Bytes of the file, at most.
const MOST_BYTES: u64 = 64 << 20;

/// A machine and its variables.
#[derive(Debug)]
pub struct Plan {
    /// Its variables.
    pub table: VariableTable,
    /// The machine with all parameters at their start values.
    pub assembly: Arc<Assembly>,
    /// Usual sizes of the continuous states.
    pub nominals: Vec<f64>,
    token: String,
    text: String,
}

impl Plan {
    /// The plan of the machine in the text of a [`FILE`]. `file` is what messages call it.
    ///
    /// # Errors
    /// [`MachineProblem::Machine`] with everything that is wrong; [`MachineProblem::Motion`] for a
    /// machine that has no start.
    pub fn new(text: String, file: &str) -> Result<Self, MachineProblem> {
        let machine = parse(&text, file, &no_records)?;
        let assembly = Arc::new(Assembly::new(machine)?);
        let token = token(&text);
        let table = VariableTable::new(&assembly.description);
        let nominals = assembly.nominals();
        Ok(Self { table, assembly, nominals, token, text })
    }

    /// The plan of a machine whatever its file looks like: records are taken into the text.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of(machine: &Description) -> Result<Self, MachineProblem> {
        Self::new(machine.to_toml(), FILE)
    }

    /// The same machine with matrices of derivatives over a step, for a description of FMI 3.0 of
    /// its own: several importers cannot read arrays.
    #[must_use]
    pub fn with_arrays(mut self) -> Self {
        self.token = token_with_arrays(&self.text);
        self.table.add_matrices(2 * self.assembly.states().len());
        self
    }

    /// The plan that an instance is asked for: of the file in its resources, if it bears the token
    /// of the description.
    ///
    /// # Errors
    /// [`MachineProblem::File`] where there is no such file, neither where the host says nor beside
    /// the library; [`MachineProblem::Door`] where the host says nothing; [`MachineProblem::Text`]
    /// where it gives the token of another text; else as [`new`](Self::new).
    pub(crate) fn asked_for(request: &Instantiation<'_>) -> Result<Self, MachineProblem> {
        let places = request.resource_folders();
        let mut read = places.iter().map(|folder| folder.join(FILE)).map(|file| (read(&file), file));
        let found = read.by_ref().find_map(|(read, file)| Some((read.ok()?, file.display().to_string())));
        let Some((text, name)) = found else {
            // What is wrong with the place that the host has named, or that it has named none.
            let file = request.resource_folder()?.join(FILE);
            let problem = self::read(&file).err().unwrap_or_default();
            return Err(MachineProblem::File { file: file.display().to_string(), problem });
        };
        if request.version == Version::Fmi3 && request.token == token_with_arrays(&text) {
            return Ok(Self::new(text, &name)?.with_arrays());
        }
        request.check_token(&token(&text)).map_err(|token| {
            // A damaged file shows where; one of another machine is sound.
            let damage = parse(&text, &name, &no_records).err().map(|refusal| refusal.to_string());
            MachineProblem::Text { place: damage.unwrap_or(name.clone()), token }
        })?;
        Self::new(text, &name)
    }

    /// The token of the machine whose [`FILE`] has this text.
    pub fn token_of(text: &str) -> String {
        token(text)
    }

    /// What tells this machine's description and file apart from others.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// What tells the machine apart from others, whichever of its descriptions was chosen.
    pub(crate) fn machine_token(&self) -> String {
        token(&self.text)
    }

    /// The text of the [`FILE`].
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The machine's name: that of the model, and of the library's file.
    pub fn name(&self) -> &str {
        &self.assembly.description.name
    }

    /// The machine with these values of all parameters, in their order; of a machine under way the
    /// starts do not matter.
    ///
    /// # Errors
    /// A refusal of what the values together are.
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

/// Hash of a file and of this version of the library, whose numbering of variables it goes with.
fn token(text: &str) -> String {
    identifier(&format!("{} {}\n{text}", env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")))
}

/// That of the description with arrays.
fn token_with_arrays(text: &str) -> String {
    identifier(&format!("{} with arrays {}\n{text}", env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION")))
}

fn read(file: &Path) -> Result<String, String> {
    let mut text = String::new();
    let opened = std::fs::File::open(file);
    let read = opened.and_then(|file| file.take(MOST_BYTES + 1).read_to_string(&mut text));
    match read {
        Ok(_) if text.len() as u64 > MOST_BYTES => Err(format!("it has more than {MOST_BYTES} bytes")),
        Ok(_) => Ok(text),
        Err(error) => Err(error.to_string()),
    }
}
