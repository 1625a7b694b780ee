//! Measures over any number of parameters: tables, pictures, remarks.

mod best;
mod collected;
mod map;
mod picture;
mod table;
mod words;

pub use table::write_tables;

use super::Study;
use crate::Result;
use collected::Collected;
pub(in crate::studies) use collected::with_spread;
pub(in crate::studies) use map::{limits, map};
use vibro_studies::design_sweep::{
    Choice, DesignRow, Designs, SampledAxis, SweepRequest, choice, each_final_row,
};
use vibro_studies::parts::Task;
pub use words::{Labelled, MeasureUnit};

/// The study of a sweep whose parts are all in the task's store. [`write_tables`] writes its
/// tables.
///
/// # Errors
/// The errors of the store.
pub fn design_sweep<M: Labelled>(
    set: &M,
    request: &SweepRequest<M>,
    task: &Task,
    name: &str,
) -> Result<Study> {
    let mut found = Collected::new(set, request);
    let quiet = Task { done: &|_| (), ..*task };
    let choice = choice(set, request, &quiet)?;
    let told = choice.as_ref().map_or(&[][..], best::told);
    let mut best: Vec<(usize, DesignRow)> = Vec::new();
    let mut index = 0;
    each_final_row(set, request, (&quiet, choice.as_ref()), |row| -> Result<()> {
        found.take(&row);
        if let Some(place) = told.iter().position(|&i| i == index) {
            best.push((place, row));
        }
        index += 1;
        Ok(())
    })?;
    // Rows arrive in the order of the designs; the remarks list them by rank.
    best.sort_by_key(|(place, _)| *place);
    let figure = picture::figure(set, request, &found, choice.as_ref());
    let what = format!("{} of {}", outputs_in_words(request), designs_in_words(request));
    let chosen = choice.map_or(Vec::new(), |choice| best::best_in_words(set, request, &choice, &best));
    Ok(Study {
        files: ["csv", "parquet"].map(|ending| format!("{name}.{ending}")).into(),
        figure,
        subject: set.caption_of_all(&varied(request)),
        failure: found.nothing(),
        ..Study::without_figure(name, what).with_remarks([found.remarks(), chosen].concat())
    })
}

fn outputs_in_words<M: Labelled>(request: &SweepRequest<M>) -> String {
    match &request.measures[..] {
        [one] => one.to_string(),
        several => format!("{} outputs", several.len()),
    }
}

fn designs_in_words<M: Labelled>(request: &SweepRequest<M>) -> String {
    let count = request.designs.count();
    let names: Vec<_> = request.designs.names().iter().map(M::name).collect();
    let over = if names.is_empty() { String::new() } else { format!(" over {}", names.join(", ")) };
    match count {
        1 => format!("one design{over}"),
        _ => format!("{count} designs{over}"),
    }
}

/// Method of the measurements, for captions.
fn method<M: Labelled>(set: &M, request: &SweepRequest<M>, choice: Option<&Choice>) -> String {
    let kind = match &request.designs {
        Designs::Grid(_) => "a grid",
        Designs::Rows { .. } => "as listed",
        Designs::Sobol { .. } => "points of the Sobol sequence",
    };
    let mut words = format!("{} designs ({kind})", request.designs.count());
    let starts: Vec<String> = request.starts.iter().take(3).map(ToString::to_string).collect();
    let more = if request.starts.len() > 3 { " …" } else { "" };
    match &request.starts[..] {
        [_] => words.push_str(&format!(", start {}", starts.join(""))),
        all => words.push_str(&format!(", {} starts ({}{more})", all.len(), starts.join("; "))),
    }
    for axis in &request.over {
        words.push_str(&format!(", over {}", axis_in_words(set, axis)));
    }
    words.push_str(&format!(
        "; {} {} discarded and {} measured of each motion.",
        request.discard,
        M::periods(),
        request.periods
    ));
    let again = choice.map_or(0, |choice| choice.rows.len());
    if again > 0 {
        words.push_str(&format!(
            " Of {again} that might be the best the numbers are those of longer motions."
        ));
    }
    words
}

/// Description of an axis of [`SweepRequest::over`].
fn axis_in_words<M: Labelled>(set: &M, axis: &SampledAxis<M::Name>) -> String {
    let ends = (axis.values.iter().copied().reduce(f64::min), axis.values.iter().copied().reduce(f64::max));
    match ends {
        (Some(a), Some(b)) if a < b => {
            let (symbol, count) = (set.symbol(&axis.name), axis.values.len());
            let [from, to] = [a, b].map(|value| set.with_unit(&axis.name, value));
            format!("{symbol} from {from} to {to} in {count} values")
        }
        (Some(a), _) => set.symbol_is(&axis.name, a),
        _ => String::new(),
    }
}

/// The parameters that vary, which a caption leaves out.
fn varied<M: Labelled>(request: &SweepRequest<M>) -> Vec<M::Name> {
    request.designs.names().into_iter().chain(request.over.iter().map(|a| a.name.clone())).collect()
}
