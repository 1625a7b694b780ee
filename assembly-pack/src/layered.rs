//! What the files of the layered standard FMI-LS-REF 1.0.0-alpha.1 (modelica/fmi-ls-ref) have in common in all archives.

use fmi_doors::description::Experiment;
use std::fmt::Write;
use vibro_figures::html::escape;

/// Folder of the files in an archive.
pub const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";

/// Version of the layered standard.
const VERSION: &str = "1.0.0-alpha.1";

/// A file that the manifest names: media type, place, role, what it is.
pub type Related<'a> = (&'a str, &'a str, &'a str, &'a str);

/// What stands in every such folder: the explanation, and the default experiment.
pub const ALWAYS: [Related<'_>; 2] = [
    (
        "application/xml",
        "smoke-test.xml",
        "experiment/smoke-test",
        "The default experiment with its result: does an importer run this FMU right?",
    ),
    ("text/plain", "../../documentation/fmi-ls-ref.txt", "document", "What these files are"),
];

/// `fmi-ls-manifest.xml`.
pub fn manifest<'a>(files: impl IntoIterator<Item = Related<'a>>) -> String {
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiReferences xmlns:fmi-ls=\"http://fmi-standard.org/fmi-ls-manifest\" \
         fmi-ls:fmi-ls-name=\"org.fmi-standard.fmi-ls-ref\" fmi-ls:fmi-ls-version=\"{VERSION}\" \
         fmi-ls:fmi-ls-description=\"Layered Standard providing information on related files included in an FMU.\">\n"
    );
    for (kind, source, role, description) in files {
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "  <Related type=\"{kind}\" source=\"{source}\" role=\"{role}\" description=\"{}\"/>",
            escape(description)
        );
    }
    text + "</fmiReferences>\n"
}

/// `smoke-test.xml`: an experiment whose result is in `default.csv`, by the draft's schema of experiments. `agreement` says how well it
/// is to be reproduced.
pub fn smoke_test(experiment: Experiment, agreement: &str) -> String {
    let Experiment { start_time, stop_time, tolerance, step_size } = experiment;
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Experiments>\n  <Experiment name=\"default\" description=\"The default experiment from \
         the start values, to be reproduced to {agreement}\" startTime=\"{start_time}\" stopTime=\"{stop_time}\" stepSize=\"{step_size}\" \
         tolerance=\"{tolerance}\">\n    <References source=\"default.csv\"/>\n  </Experiment>\n</Experiments>\n"
    )
}
