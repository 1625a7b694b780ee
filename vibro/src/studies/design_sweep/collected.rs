//! What is kept of a sweep's rows while they pass: values for the picture, and what is worth saying.

use vibro_analysis::design_sweep::{Request, Row};
use vibro_analysis::measures::Measure;
use vibro_analysis::{Name, ParameterSet, significant};

/// Most designs of a picture.
const MOST_DRAWN: usize = 100_000;

/// Least and largest of a measure over the motions of a design; `None` where it has no value.
pub(super) type Reach = Option<(f64, f64)>;

/// One measure of all designs.
pub(super) struct MeasureRecord {
    pub measure: Measure,
    /// Its place among the request's measures.
    index: usize,
    /// For the picture, design by design.
    pub reaches: Vec<Reach>,
    /// The designs of the least and of the largest value: the value with the parameters.
    ends: Option<[(f64, Vec<f64>); 2]>,
}

/// What is kept of a sweep.
pub(super) struct Collected {
    /// For the units in which parameters are told.
    set: ParameterSet,
    names: Vec<Name>,
    motions: usize,
    /// Values of the parameters, design by design, for the picture.
    pub values: Vec<Vec<f64>>,
    /// The measures that are numbers.
    pub records: Vec<MeasureRecord>,
    draws: bool,
    count: usize,
    bad: usize,
    reason: Option<String>,
}

impl Collected {
    pub fn new(set: &ParameterSet, request: &Request) -> Self {
        let numbers = request.measures.iter().enumerate().filter(|(_, m)| **m != Measure::Class);
        let record = |(index, measure): (usize, &Measure)| MeasureRecord {
            measure: *measure,
            index,
            reaches: Vec::new(),
            ends: None,
        };
        Self {
            set: set.clone(),
            names: request.designs.names(),
            motions: request.motions(),
            values: Vec::new(),
            records: numbers.map(record).collect(),
            draws: request.designs.count() <= MOST_DRAWN,
            count: 0,
            bad: 0,
            reason: None,
        }
    }

    /// Whether the designs are few enough for a picture.
    pub fn draws(&self) -> bool {
        self.draws
    }

    /// Takes up the next row.
    pub fn take(&mut self, row: &Row) {
        self.count += 1;
        if let Some(reason) = &row.reason {
            self.bad += 1;
            if self.reason.is_none() {
                self.reason =
                    Some(format!("{}: {reason}", design_in_words(&self.set, &self.names, &row.values)));
            }
        }
        for record in &mut self.records {
            let output = row.outputs.get(record.index).copied().flatten();
            if let Some(found) = output {
                let here = || (found.largest, row.values.clone());
                match &mut record.ends {
                    None => record.ends = Some([here(), here()]),
                    Some([least, _]) if found.largest < least.0 => *least = here(),
                    Some([_, largest]) if found.largest > largest.0 => *largest = here(),
                    _ => {}
                }
            }
            if self.draws {
                record.reaches.push(output.map(|o| (o.least, o.largest)));
            }
        }
        if self.draws {
            self.values.push(row.values.clone());
        }
    }

    /// What to say, line by line.
    pub fn remarks(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(reason) = &self.reason {
            let which = design_or_none(reason);
            lines.push(format!("{} of {} designs lack values; the first: {which}", self.bad, self.count));
        }
        for record in &self.records {
            let Some([least, largest]) = &record.ends else { continue };
            let unit = match record.measure.unit() {
                "1" => String::new(),
                unit => format!(" {}", unit.replace('.', "·")),
            };
            let told = |(value, design): &(f64, Vec<f64>)| {
                let at = if self.count > 1 {
                    design_in_words(&self.set, &self.names, design)
                } else {
                    String::new()
                };
                let at = if at.is_empty() { at } else { format!(" at {at}") };
                format!("{}{unit}{at}", significant(*value))
            };
            let what = match self.motions {
                1 => record.measure.name(),
                n => format!("{}, largest of {n} motions", record.measure),
            };
            // The same but for rounding.
            if significant(least.0) == significant(largest.0) {
                lines.push(format!("{what}: {}", told(least)));
            } else {
                lines.push(format!("{what}: least {}; largest {}", told(least), told(largest)));
            }
        }
        if !self.draws {
            lines.push(format!("no picture: {} designs, allowed are up to {MOST_DRAWN}", self.count));
        }
        lines
    }
}

/// A reason without the empty name of the one design there is.
fn design_or_none(reason: &str) -> &str {
    reason.strip_prefix(": ").unwrap_or(reason)
}

/// A design in words, in the units in which the machine was written: `block.m = 1.2 kg, stop.gap = 10 mm`.
fn design_in_words(set: &ParameterSet, names: &[Name], values: &[f64]) -> String {
    let told = |(name, value): (&Name, &f64)| format!("{} = {}", name.name(), set.with_unit(*name, *value));
    names.iter().zip(values).map(told).collect::<Vec<_>>().join(", ")
}
