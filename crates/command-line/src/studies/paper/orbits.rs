//! Branches of periodic orbits of the paper's machine over a parameter, with their bifurcations.

use super::lengths::Lengths;
use crate::Result;
use crate::studies::branches::{self, Texts, cell, list, or_empty};
use crate::studies::{Study, parameter_axis};
use crate::table::{CsvRows, exact};
use rayon::prelude::*;
use vibro_figures::chart::Axis;
use vibro_orbits::Stability;
use vibro_orbits::paper::{Branch, Family, OrbitPoint, Searched, Span};
use vibro_studies::paper::ParameterSet;

/// Weights of X1, X2, X3 in the weighted sum that equals X2.
const BLOCK: [f64; 3] = [0.0, 1.0, 0.0];

/// The study of branches over the one parameter of a family: tables of the branches and special
/// points, for a tree a table of the search, and a picture.
///
/// # Errors
/// [`Error::Output`](crate::Error::Output).
pub fn orbits(
    set: &ParameterSet,
    family: &Family,
    all: &[Branch],
    searched: Option<&Searched>,
) -> Result<Study> {
    let span = *family.span();
    let tops: Vec<Vec<f64>> = all.par_iter().map(|b| largest(family, b)).collect();
    let texts = Texts {
        name: "orbits".into(),
        over: span.name.symbol().to_string(),
        title: format!("Periodic orbits over {}", set.symbol(span.name)),
        certain: ", each certified but for the touch at GR",
        elsewhere: set.caption_but(&[span.name]),
        axes: axes(set, &span),
    };
    let mut study =
        branches::study(all, &tops, texts, [point_table(&span, all, &tops)?, special_table(&span, all)?]);
    if let Some(searched) = searched {
        study.remarks.push(search_in_words(searched));
        study.tables.push(("orbits-search".into(), search_table(&span, searched)?));
    }
    Ok(study)
}

/// Description of the search for the orbits of a tree.
pub(in crate::studies) fn search_in_words(searched: &Searched) -> String {
    let Searched { values, periods, followed, islands } = searched;
    let settled = values.iter().flat_map(|v| [v.rising, v.falling]).flatten().count();
    let starts: u32 = values.iter().map(|v| v.starts).sum();
    let ways = format!(
        "searched from motions at {} values, rising and falling, of which {settled} settled on a stable orbit",
        values.len()
    );
    if starts == 0 {
        return ways;
    }
    format!(
        "{ways}, and from {starts} starts in 1.5 times the range of the visited states, for \
         {periods} periods each: these motions passed near orbits of {followed} more branches, of \
         which {islands} are stable somewhere and were kept"
    )
}

/// Table of the search by value; starts lie between the value and the next one.
fn search_table(span: &Span, searched: &Searched) -> Result<Vec<u8>> {
    let mut table =
        CsvRows::new([span.name.name(), "period_rising", "period_falling", "starts", "orbits_passed"])?;
    for v in &searched.values {
        let (rising, falling) = (or_empty(v.rising), or_empty(v.falling));
        table.push([exact(v.value), rising, falling, v.starts.to_string(), v.found.to_string()])?;
    }
    table.text()
}

/// The largest X2 at each point. Without loads, it is the larger one of the orbit and its mirror
/// image, which is an orbit too. NaN if there is none; pictures and tables leave it out.
fn largest(family: &Family, branch: &Branch) -> Vec<f64> {
    let own = branch.maxima(family, BLOCK);
    let mirror = if family.is_symmetric() { BLOCK.map(|w| -w) } else { BLOCK };
    let image = branch.maxima(family, mirror);
    let first = |all: &Vec<f64>| all.first().copied().unwrap_or(f64::NAN);
    own.iter().zip(&image).map(|(a, b)| first(a).max(first(b))).collect()
}

fn point_table(span: &Span, all: &[Branch], tops: &[Vec<f64>]) -> Result<Vec<u8>> {
    let own = ["period", "word", "closing", "stable", "multiplier", "X2_max", "phase", "flights"];
    branches::point_table(span.name.name(), own.map(str::to_owned), all, |k, branch| {
        let word = branch.word();
        let row = |(point, top): (&OrbitPoint, &f64)| {
            let phases = point.phases();
            let last = phases.first().map(|first| first + word.span());
            let ends = phases.iter().skip(1).copied().chain(last);
            vec![
                word.period().to_string(),
                word.to_string(),
                word.sign().into(),
                point.is_stable().to_string(),
                cell(point.multipliers[0].norm()),
                cell(*top),
                or_empty(phases.first().map(|p| exact(*p))),
                list(phases.iter().zip(ends).map(|(a, b)| b - a)),
            ]
        };
        branch.points.iter().zip(&tops[k]).map(row).collect()
    })
}

/// Table of the special points, with the data that another study needs to start from them.
pub(in crate::studies) fn special_table(span: &Span, all: &[Branch]) -> Result<Vec<u8>> {
    let own =
        ["word", "closing", "period", "longer_word", "turns", "stable_before", "stable_after", "phases"];
    branches::special_table(span.name.name(), &own, all, |branch| {
        Box::new(move |i, point, special| {
            let [before, after] = branch.stability_around(i).map(|own| own == Stability::Stable);
            let turns = special.fold.map_or("", |folds| if folds { "fold" } else { "through" });
            vec![
                branch.word().to_string(),
                branch.word().sign().into(),
                branch.word().period().to_string(),
                or_empty(special.longer.as_ref()),
                turns.into(),
                before.to_string(),
                after.to_string(),
                list(point.phases().iter().copied()),
            ]
        })
    })
}

fn axes(set: &ParameterSet, span: &Span) -> [Axis; 2] {
    let (x, lengths) = (parameter_axis(set, span.name, (span.from, span.to)), Lengths::of(set));
    // If the parameter is the gap, the unit of each point is the gap of that point.
    let y = match span.name.name() {
        "stop.gap" => Axis::new("largest X₂ (units of L)"),
        _ => lengths.axis(&format!("largest {}", lengths.displacement("X₂"))),
    };
    [x, y]
}
