//! The largest and all Lyapunov exponents of a described machine's motion.

use super::design_sweep::{Labelled, with_spread};
use super::{PANEL, Study};
use crate::Result;
use crate::table::{TextTable, exact};
use crate::wording::{self, axis};
use vibro_figures::canvas::palette::FAMILY;
use vibro_figures::chart::{Axis, Dash, Figure, Layer, Panel, Path, THIN};
use vibro_studies::significant;
use vibro_studies::{Machine, Spectrum, Start, runs_on, settle, settled};

/// Largest number of points of a curve in the picture.
const POINTS: usize = 2000;

/// Table of the largest exponent of a machine's motion from a start, over `periods` returns after
/// `discard` discarded returns.
///
/// # Errors
/// The errors of the machine and of its motion.
pub fn exponent(
    machine: &Machine,
    start: &Start,
    (discard, periods): (u32, u32),
    name: &str,
) -> Result<Study> {
    let (motion, section) = machine.motion(start)?;
    let mut motion = motion.without_energy_accounts();
    settle(&mut motion, &section, discard)?;
    if let Some(why) = runs_on(&machine.description, motion.time()) {
        let problem = "an exponent exists only while all loads repeat; increase --discard until \
                       the change lies in the discarded periods";
        return Err(crate::Error::Refused { what: why, problem: problem.into() });
    }
    let found = settled(&mut motion, &section, Some(periods))?;
    let mut table =
        TextTable::new(&["exponent", "error", "periods", "interval", "contacts", "rests", "class"]);
    let exponent = found.exponent;
    let number = |x: Option<f64>| x.map_or(String::new(), exact);
    table.rows.push(vec![
        number(exponent.map(|e| e.value)),
        number(exponent.map(|e| e.error)),
        exponent.map_or(String::new(), |e| e.periods.to_string()),
        exact(found.interval),
        exact(found.contacts),
        found.rests.to_string(),
        found.class.name(),
    ]);
    let told =
        exponent.map_or("undecided: the motion has not settled".into(), |e| match (e.value, found.period) {
            (f64::NEG_INFINITY, _) => {
                "-inf: contacts remove every direction, or all directions are neutral".into()
            }
            (value, Some(period)) => {
                format!(
                    "{} 1/s, by the multipliers of {period}T to {}",
                    significant(value),
                    significant(e.error)
                )
            }
            (value, None) => format!(
                "{} 1/s, standard error {}, over {} returns",
                significant(value),
                significant(e.error),
                e.periods
            ),
        });
    let what = format!("largest Lyapunov exponent {told}");
    let remarks = vec![format!("class: {}", found.class.name())];
    Ok(Study {
        tables: vec![(name.into(), table.csv()?)],
        ..Study::without_figure(name, what).with_remarks(remarks)
    })
}

/// Tables and picture of all exponents of a machine's motion from a start, over `periods` returns
/// after `discard` discarded ones.
///
/// # Errors
/// The errors of the machine and of its motion; a machine that does not repeat.
pub fn spectrum(
    machine: &Machine,
    start: &Start,
    (discard, periods): (u32, u32),
    done: &mut dyn FnMut(),
    name: &str,
) -> Result<Study> {
    if let Some(why) = runs_on(&machine.description, 0.0) {
        let problem = "exponents require loads and motions that are harmonic, constant or uniform";
        return Err(crate::Error::Refused { what: why, problem: problem.into() });
    }
    let found = vibro_studies::spectrum(machine, start, (discard, periods), &mut || {
        done();
        true
    })?;
    let mut table = TextTable::new(&["number", "exponent", "error", "periods"]);
    for (k, e) in (1..).zip(&found.exponents) {
        table.rows.push(vec![format!("{k}"), exact(e.value), exact(e.error), e.periods.to_string()]);
    }
    let in_words = |value: f64, error: f64| {
        if error.is_finite() && value.is_finite() { with_spread(value, error) } else { significant(value) }
    };
    let words: Vec<String> = found.exponents.iter().map(|e| in_words(e.value, e.error)).collect();
    let held = found.exponents.iter().filter(|e| e.value == f64::NEG_INFINITY).count();
    let how = match found.period {
        Some(period) => format!("by the multipliers of the periodic orbit (period in returns: {period})"),
        None => format!("over {periods} returns"),
    };
    let mut remarks = vec![format!("exponents: {} 1/s, {how}", words.join(", "))];
    remarks.push(match held {
        0 => format!(
            "sum: {} 1/s, the mean growth rate of volumes",
            significant(found.exponents.iter().map(|e| e.value).sum())
        ),
        _ => format!("{held} are -inf: contacts or samples of blocks remove these directions"),
    });
    let figure = Figure {
        title: format!(
            "{}: Lyapunov exponents over the counted time",
            wording::title(&machine.description.name)
        ),
        caption: vec![machine.caption_but(&[])],
        panels: vec![panel(&found)],
        columns: 1,
        panel: PANEL,
        shared_legend: false,
    };
    let what = format!("spectrum of {} Lyapunov exponents", found.exponents.len());
    Ok(Study {
        tables: vec![(name.into(), table.csv()?)],
        figure: Some(figure),
        ..Study::without_figure(name, what).with_remarks(remarks)
    })
}

fn panel(found: &Spectrum) -> Panel {
    let step = found.running.len().div_ceil(POINTS).max(1);
    let path = |k: usize| -> Path {
        let all = found.running.iter().step_by(step).map(|(time, all)| (*time, all[k]));
        all.filter(|point| point.1.is_finite()).collect()
    };
    let curve = |(k, colour)| {
        let dash = if k < FAMILY.len() { Dash::Solid } else { Dash::Dashed };
        Layer::line("", colour, dash, path(k)).stroke(THIN).labelled(format!("λ{}", k + 1))
    };
    let curves = (0..found.exponents.len()).zip(FAMILY.into_iter().cycle()).map(curve);
    Panel {
        title: String::new(),
        x: axis("counted time", "s", found.running.last().map_or(0.0, |own| own.0)),
        y: Axis::new("Lyapunov exponent λ, 1/s"),
        layers: curves.filter(|layer| !layer.extent().is_empty()).collect(),
    }
}
