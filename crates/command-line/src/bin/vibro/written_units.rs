//! Numbers without a unit on a command's axes. Such a number is in the machine's written unit of
//! the parameter.

use crate::arguments::Command;
use crate::ranges::{self, InWrittenUnit, ParameterRange};
use vibro::Result;
use vibro_studies::paper::{Name, ParameterSet, number, typed_unit};

/// An option whose numbers were converted.
pub struct Words {
    /// The option's name in manifests.
    pub name: &'static str,
    /// Its values in SI.
    pub words: String,
    /// A note for the user.
    pub remark: Option<String>,
}

/// Converts the numbers without a unit on a command's axes from the machine's written units.
///
/// # Errors
/// An error if a value is outside its parameter's range.
pub fn read_in(command: &mut Command, set: &ParameterSet) -> Result<Vec<Words>> {
    let mut found = Vec::new();
    let axes: Vec<(&'static str, Vec<&mut dyn InWrittenUnit>)> = match command {
        Command::Response(a) => {
            vec![("range", dynamic(&mut a.of_paper.range)), ("values", dynamic(&mut a.of_paper.values))]
        }
        Command::Manifold(a) => vec![("values", dynamic(&mut a.values))],
        Command::Plane(a) => vec![("range", dynamic(&mut a.planes.range))],
        Command::Isoperiodic(a) => vec![("range", dynamic(&mut a.planes.range))],
        Command::Compare(a) => vec![("range", dynamic(&mut a.range)), ("values", dynamic(&mut a.values))],
        Command::Bifurcation(a) => vec![("range", dynamic(&mut a.of_paper.range))],
        Command::Lyapunov(a) => vec![("range", dynamic(&mut a.sweep.of_paper.range))],
        Command::Sweep(a) => {
            vec![("vary", dynamic(&mut a.of_paper.vary)), ("over", dynamic(&mut a.of_paper.over))]
        }
        Command::Orbits(a) => vec![("vary", dynamic(&mut a.range))],
        Command::Locus(a) => vec![("vary", dynamic(&mut a.ranges))],
        _ => Vec::new(),
    };
    for (name, axes) in axes {
        for axis in axes {
            let remark = axis
                .read_in_written_unit(set)?
                .map(|words| format!("--{} {words}", if name == "range" { "vary" } else { name }));
            match found.last_mut().filter(|last: &&mut Words| last.name == name) {
                Some(last) => {
                    last.words = format!("{} {axis}", last.words);
                    last.remark =
                        last.remark.take().into_iter().chain(remark).reduce(|a, b| format!("{a}; {b}"));
                }
                None => found.push(Words { name, words: axis.to_string(), remark }),
            }
        }
    }
    let (option, range, texts) = match command {
        Command::Lyapunov(a) => ("at", a.sweep.of_paper.range, &mut a.at),
        Command::Orbits(a) => ("mark", a.range, &mut a.of_paper.mark),
        _ => return Ok(found),
    };
    if let Some(ParameterRange { name, unit, .. }) = range {
        found.extend(read_list(option, name, unit.or_else(|| set.unit(name)), texts));
    }
    Ok(found)
}

fn dynamic<'a, T: InWrittenUnit + 'a>(
    axes: impl IntoIterator<Item = &'a mut T>,
) -> Vec<&'a mut dyn InWrittenUnit> {
    axes.into_iter().map(|axis| axis as &mut dyn InWrittenUnit).collect()
}

/// Appends the axis' unit to the numbers of a list that is parsed later, if none of them has a
/// unit.
fn read_list(
    option: &'static str,
    name: Name,
    unit: Option<&'static vibro_studies::paper::Unit>,
    texts: &mut [String],
) -> Option<Words> {
    let unit = unit.filter(|unit| !unit.is_si())?;
    let bare = |text: &String| number(name, text).is_ok() && typed_unit(name, text).is_none();
    if texts.is_empty() || !texts.iter().all(bare) {
        return None;
    }
    let typed = texts.join(",");
    texts.iter_mut().for_each(|text| text.push_str(unit.plain()));
    let words: Vec<String> =
        texts.iter().filter_map(|text| number(name, text).ok()).map(|v| v.to_string()).collect();
    let remark = Some(ranges::note_of_unit(&format!("--{option} {typed}"), unit));
    Some(Words { name: option, words: words.join(" "), remark })
}
