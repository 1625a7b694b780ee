//! A search for the best design: verdict, table of all designs, picture.

mod picture;
mod words;

use super::Study;
use crate::Result;
use crate::table::{CsvRows, exact};
use vibro_design::{DesignRequest, Designed, Value, Verdict};
use vibro_studies::Machine;

/// The study of a search: `design.csv` with all evaluated designs, and a picture.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn designed(request: &DesignRequest, found: &Designed) -> Result<Study> {
    let count = found.evaluations.len();
    let what = format!(
        "{} {} of {count} designs over {}",
        if request.goal.maximize { "largest" } else { "least" },
        request.goal.measure,
        request.names().join(", ")
    );
    let failure = match (&found.verdict, &found.best) {
        (Verdict::NoneFound(why), None) => Some(why.clone()),
        _ => None,
    };
    Ok(Study {
        tables: vec![("design".into(), table(request, found)?)],
        figure: picture::figure(request, found),
        failure,
        ..Study::without_figure("design", what).with_remarks(words::remarks(request, found))
    })
}

/// The machine with the parameters of the best design; `None` if none was found.
///
/// # Errors
/// An error if the machine refuses the parameters.
pub fn best_machine(request: &DesignRequest, found: &Designed) -> Result<Option<Machine>> {
    let Some(best) = found.best.as_ref().filter(|_| !matches!(found.verdict, Verdict::NoneFound(_))) else {
        return Ok(None);
    };
    let names = request.names();
    Ok(Some(request.machine.with(names.iter().map(String::as_str).zip(best.values.iter().copied()))?))
}

/// Table with one row per design.
fn table(request: &DesignRequest, found: &Designed) -> Result<Vec<u8>> {
    let measures =
        || std::iter::once(&request.goal.measure).chain(request.limits.iter().map(|own| &own.measure));
    let mut names: Vec<String> = Vec::new();
    for measure in measures() {
        // Two limits of the same measure have separate columns.
        let count = names.iter().filter(|own| **own == measure.to_string()).count();
        names.push(if count == 0 { measure.to_string() } else { format!("{measure}.{}", count + 1) });
    }
    let columns = names.iter().flat_map(|name| [name.clone(), format!("{name}.low"), format!("{name}.high")]);
    let header: Vec<String> = ["evaluation", "stage"]
        .map(str::to_owned)
        .into_iter()
        .chain(request.names())
        .chain(columns)
        .chain(["within_limits", "worst", "reason"].map(str::to_owned))
        .collect();
    let mut rows = CsvRows::new(&header)?;
    let cells = |value: &Option<Value>| match value {
        Some(own) => [own.value, own.bar.0, own.bar.1].map(exact),
        None => [String::new(), String::new(), String::new()],
    };
    for (index, own) in found.evaluations.iter().enumerate() {
        let mut row = vec![(index + 1).to_string(), own.stage.name().to_owned()];
        row.extend(own.values.iter().copied().map(exact));
        row.extend(std::iter::once(&own.goal).chain(&own.limits).flat_map(cells));
        let reason = own.reason.clone().unwrap_or_default();
        row.extend([own.is_feasible().to_string(), own.place.clone(), reason]);
        rows.push(row)?;
    }
    rows.text()
}
