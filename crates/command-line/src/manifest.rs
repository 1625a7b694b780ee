//! Manifests: program, command and parameters of a finished result, or of a folder of finished
//! parts. A manifest shows whether two results have the same parameters.

use crate::long_study::{FORMAT, LongStudy};
use crate::subject::Subject;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use vibro_numerics::digest::fnv1a;

/// The program in every manifest.
const PROGRAM: &str = "vibro";

/// A command with its options, as given.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Invocation {
    /// The command, e.g. `basin`.
    pub command: String,
    /// Command line without the options that do not affect results: folder, threads and shard.
    pub command_line: String,
    /// The options of the command that affect its results, with their values or defaults.
    pub options: BTreeMap<String, String>,
}

/// Program, command and parameters of a result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// `vibro`.
    pub program: String,
    /// Version of the program.
    pub version: String,
    /// Stem of the result's files.
    pub study: String,
    /// Name of the file with the caption of the picture; `None` without a picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub caption: Option<String>,
    /// The command that computes it.
    pub invocation: Invocation,
    /// The physical parameters in SI, by their structured names.
    pub si: BTreeMap<String, f64>,
    /// The dimensionless groups.
    pub groups: BTreeMap<String, f64>,
    /// The study whose parts are in the folder; `None` in the manifest of a finished result.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub long_study: Option<LongStudy>,
}

impl Manifest {
    /// The manifest of a finished result.
    pub fn of_result(study: &str, invocation: &Invocation, subject: &dyn Subject) -> Self {
        let (si, groups) = subject.numbers();
        let mut invocation = invocation.clone();
        invocation.options.extend(subject.structure());
        Self {
            program: PROGRAM.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            study: study.into(),
            caption: None,
            invocation,
            si,
            groups,
            long_study: None,
        }
    }

    /// The manifest of a folder of parts.
    pub fn of_parts(study: &LongStudy, invocation: &Invocation) -> Self {
        let long_study = Some(study.clone());
        Self { long_study, ..Self::of_result(&study.name, invocation, study.work.subject()) }
    }

    /// Reads a manifest.
    ///
    /// # Errors
    /// [`Error::File`] if the file cannot be read; [`Error::Config`] if it is not a manifest of
    /// this program.
    pub fn read(path: &Path) -> Result<Self> {
        let problem = |problem: String| Error::Config { path: path.into(), problem };
        let text = std::fs::read(path).map_err(Error::file("reading", path))?;
        let text = String::from_utf8(text)
            .map_err(|_| problem("is not a manifest of vibro: it is not UTF-8 text".into()))?;
        let found: Self = toml::from_str(&text).map_err(|e| {
            problem(match other_form(&text) {
                Some(form) => format!(
                    "describes parts in form {form}, but this version of vibro reads and writes \
                     form {FORMAT}; it was not changed\n  use another --out, or finish that run \
                     with the version of vibro that began it"
                ),
                None => format!(
                    "is not a manifest of vibro, or is damaged, and was not changed: {}",
                    e.to_string().trim_end()
                ),
            })
        })?;
        if found.program == PROGRAM {
            Ok(found)
        } else {
            Err(problem(format!("is a manifest of `{}`, not of vibro, and was not changed", found.program)))
        }
    }

    /// As TOML.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub fn text(&self) -> Result<String> {
        toml::to_string(self).map_err(Error::output("a manifest"))
    }

    /// Whether both describe the same result: study, options and parameters are equal. Version and
    /// command line may differ; for parts the version must be equal, since parts are combined.
    pub fn describes_same(&self, other: &Self) -> bool {
        self.long_study == other.long_study && self.differences(other).is_empty()
    }

    /// Descriptions of the differences; `self` is on disk and `other` is requested.
    pub fn differences(&self, other: &Self) -> Vec<String> {
        let (there, here) = (self.values(), other.values());
        let names: std::collections::BTreeSet<_> = there.keys().chain(here.keys()).collect();
        let mut found = Vec::new();
        for name in names {
            let (a, b) = (there.get(name), here.get(name));
            if a != b {
                let [a, b] = [a, b].map(|x| x.map_or("not given", String::as_str));
                match a.contains('\n') || b.contains('\n') {
                    // If the texts differ in numbers alone, the differences of `si` name the
                    // numbers.
                    true if self.si != other.si && without_numbers(a) == without_numbers(b) => {}
                    true => found.extend(lines_apart(name, a, b)),
                    false => found.push(format!("{name}: {a} there, {b} here")),
                }
            }
        }
        found
    }

    /// [`Self::differences`] in one line.
    pub fn differences_in_words(&self, other: &Self) -> String {
        match self.differences(other).as_slice() {
            // Only the captions differ: they name the parameters that were given.
            [] => "which parameters were given and which are defaults".into(),
            all => all.join("; "),
        }
    }

    /// [`Self::differences`], one line for each, for error messages.
    pub fn differences_in_lines(&self, other: &Self) -> String {
        match self.differences(other).as_slice() {
            [] => format!("    {}", self.differences_in_words(other)),
            all => all.iter().map(|line| format!("    {line}")).collect::<Vec<_>>().join("\n"),
        }
    }

    /// Everything that distinguishes results, by name.
    fn values(&self) -> BTreeMap<String, String> {
        let mut values: BTreeMap<String, String> = BTreeMap::new();
        values.insert("command".into(), self.invocation.command.clone());
        values.insert("study".into(), self.study.clone());
        // The times of a run follow from --until, too.
        let named = |k: &str| if k == "times" { k.into() } else { format!("--{k}") };
        values.extend(self.invocation.options.iter().map(|(k, v)| (named(k), v.clone())));
        values.extend(self.si.iter().chain(&self.groups).map(|(k, v)| (k.clone(), v.to_string())));
        if let Some(study) = &self.long_study {
            values.insert("version".into(), study.version.clone());
            values.insert("form of the parts".into(), study.format.to_string());
        }
        values
    }

    /// Digest of command, options and parameters, eight hexadecimal digits, for the name of a
    /// folder.
    pub fn digest(&self) -> String {
        let mut values = self.values();
        // The studies of one command belong in one folder.
        values.remove("study");
        values.remove("version");
        values.remove("form of the parts");
        let text: String = values.iter().map(|(k, v)| format!("{k}={v}\n")).collect();
        let hash = fnv1a(text.as_bytes());
        format!("{:08x}", (hash ^ (hash >> 32)) as u32)
    }
}

/// Cap on the listed lines of a text.
const LINES: usize = 10;

/// Text without digits, signs and exponents.
fn without_numbers(text: &str) -> String {
    text.chars().filter(|c| !(c.is_ascii_digit() || "+-.e".contains(*c))).collect()
}

/// Lines that occur in only one of two texts.
fn lines_apart(name: &str, there: &str, here: &str) -> Vec<String> {
    let alone = |a: &str, b: &str, whose: &str| {
        let lines: Vec<String> = a
            .lines()
            .filter(|line| !b.lines().any(|other| other == *line))
            .map(|line| format!("{name} {whose}: {}", line.trim()))
            .collect();
        let more = lines.len().saturating_sub(LINES);
        let more = (more > 0).then(|| format!("{name} {whose}: {more} lines more"));
        lines.into_iter().take(LINES).chain(more).collect::<Vec<_>>()
    };
    [alone(there, here, "there"), alone(here, there, "here")].concat()
}

/// Form of parts named by a manifest that this program cannot read; `None` if it is this program's
/// form, or if the text is not a manifest of parts.
fn other_form(text: &str) -> Option<i64> {
    let manifest: toml::Table = toml::from_str(text).ok()?;
    let study = manifest.get("long_study")?.as_table()?;
    let form = study.get("format").map_or(Some(1), toml::Value::as_integer)?;
    (form != i64::from(FORMAT)).then_some(form)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibro_studies::paper::ParameterSet;

    fn manifest(assignment: &str) -> Manifest {
        let mut set = ParameterSet::basic();
        set.apply(&[assignment]).unwrap();
        Manifest::of_result("steady", &Invocation { command: "steady".into(), ..Invocation::default() }, &set)
    }

    #[test]
    fn second_method_a_manifest_reads_back_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.toml");
        let written = manifest("kappa=0.6180339887498949");
        std::fs::write(&path, written.text().unwrap()).unwrap();
        assert_eq!(Manifest::read(&path).unwrap(), written);
    }

    #[test]
    fn other_parameters_are_named_and_have_another_digest() {
        let (one, two) = (manifest("kappa=0.5"), manifest("kappa=0.6"));
        assert_eq!(
            one.differences(&two),
            ["kappa: 0.5 there, 0.6 here", "stop.restitution: 0.5 there, 0.6 here"]
        );
        assert!(one.digest() != two.digest() && one.digest().len() == 8);
        let newer = Manifest { version: "9.9.9".into(), ..one.clone() };
        assert!(one.describes_same(&newer) && one.digest() == newer.digest());
    }

    #[test]
    fn of_two_machines_the_lines_that_differ_are_told_alone() {
        let machine = |text: &str, mass: f64| {
            let mut found = manifest("kappa=0.5");
            found.invocation.options.insert("machine".into(), text.into());
            found.si.insert("body.box.mass".into(), mass);
            found
        };
        let one = machine("name = \"M\"\n[body.box]\nmass = 12.0\n", 12.0);
        let heavier = machine("name = \"M\"\n[body.box]\nmass = 13.0\n", 13.0);
        assert_eq!(one.differences(&heavier), ["body.box.mass: 12 there, 13 here"]);
        let other = machine("name = \"M\"\n[body.box]\nmass = 12.0\ngravity = 1.0\n", 12.0);
        assert_eq!(one.differences(&other), ["--machine here: gravity = 1.0"]);
        assert_eq!(other.differences_in_lines(&one), "    --machine there: gravity = 1.0");
    }

    #[test]
    fn what_is_no_manifest_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.toml");
        let other = Manifest { program: "cargo".into(), ..manifest("kappa=0.5") }.text().unwrap();
        for (bytes, word) in
            [(&b"\xff\xfe"[..], "not UTF-8 text"), (b"study = 1", "damaged"), (other.as_bytes(), "`cargo`")]
        {
            std::fs::write(&path, bytes).unwrap();
            let error = Manifest::read(&path).unwrap_err();
            let text = error.to_string();
            assert!(error.is_usage() && text.contains("m.toml") && text.contains(word), "{text}");
        }
    }
}
