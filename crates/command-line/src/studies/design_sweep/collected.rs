//! Summary of a sweep, collected row by row: values for the picture, extremes and counts for the
//! remarks.

use super::words::Labelled;
use vibro_studies::design_sweep::{DesignRow, Summary, SweepRequest};
use vibro_studies::significant;

/// Largest number of designs in a picture.
const MOST_DRAWN: usize = 100_000;

/// Smallest and largest value of a measure over a design's motions; `None` without a value.
pub(super) type Reach = Option<(f64, f64)>;

/// One measure of all designs.
pub(super) struct MeasureRecord<M: Labelled> {
    pub measure: M::Measure,
    /// Index among the request's measures.
    index: usize,
    /// Values for the picture, by design.
    pub reaches: Vec<Reach>,
    /// Designs with the smallest and the largest value.
    least: Option<Extremum>,
    largest: Option<Extremum>,
}

impl<M: Labelled> MeasureRecord<M> {
    /// The smallest value in a unit, rounded to its spread.
    pub fn least_in(&self, factor: f64) -> Option<String> {
        let least = self.least.as_ref()?;
        Some(with_spread(factor * least.value, factor * least.spread))
    }
}

/// A value with its spread, and the parameters of its design.
#[derive(Clone)]
struct Extremum {
    value: f64,
    spread: f64,
    design: Vec<f64>,
}

/// Relative spread of rounding; a value with a smaller spread is shown without it.
const REGULAR: f64 = 1e-6;

/// Summary of a sweep.
pub(super) struct Collected<M: Labelled> {
    /// The machine, for the units of parameters.
    set: M,
    names: Vec<M::Name>,
    motions: usize,
    /// Values of the parameters by design, for the picture.
    pub values: Vec<Vec<f64>>,
    /// Measures with numeric values.
    pub records: Vec<MeasureRecord<M>>,
    draws: bool,
    count: usize,
    /// Number of designs without a value.
    bad: usize,
    /// Number of designs without any value.
    empty: usize,
    /// Number of designs with all values that had not settled.
    unsettled: usize,
    /// First reason why a design lacks a value, and first reason why one had not settled.
    reasons: [Option<String>; 2],
    /// Whether the class was requested.
    has_class: bool,
}

impl<M: Labelled> Collected<M> {
    pub fn new(set: &M, request: &SweepRequest<M>) -> Self {
        let numbers = request.measures.iter().enumerate().filter(|(_, m)| !M::is_class(m));
        let record = |(index, measure): (usize, &M::Measure)| MeasureRecord {
            measure: measure.clone(),
            index,
            reaches: Vec::new(),
            least: None,
            largest: None,
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
            empty: 0,
            unsettled: 0,
            reasons: [None, None],
            has_class: request.measures.iter().any(M::is_class),
        }
    }

    /// Whether there are few enough designs for a picture.
    pub fn draws(&self) -> bool {
        self.draws
    }

    /// Adds the next row.
    pub fn take(&mut self, row: &DesignRow) {
        self.count += 1;
        let has_class = !row.classes.is_empty();
        let numbers =
            self.records.iter().filter(|r| row.outputs.get(r.index).is_some_and(Option::is_some)).count();
        if let Some(reason) = &row.reason {
            let lacks = numbers < self.records.len() || (self.has_class && !has_class);
            *(if lacks { &mut self.bad } else { &mut self.unsettled }) += 1;
            let first = &mut self.reasons[usize::from(!lacks)];
            if first.is_none() {
                *first = Some(format!("{}: {reason}", design_in_words(&self.set, &self.names, &row.values)));
            }
        }
        self.empty += usize::from(numbers == 0 && !has_class);
        for record in &mut self.records {
            let output = row.outputs.get(record.index).copied().flatten();
            if let Some(found) = output {
                let here =
                    || Extremum { value: found.largest, spread: found.spread, design: row.values.clone() };
                if record.least.as_ref().is_none_or(|other| found.largest < other.value) {
                    record.least = Some(here());
                }
                if record.largest.as_ref().is_none_or(|other| found.largest > other.value) {
                    record.largest = Some(here());
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

    /// Remarks, line by line.
    pub fn remarks(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let [lacking, unsettled] = &self.reasons;
        if let Some(reason) = lacking {
            let which = design_or_none(reason);
            lines.push(format!("{} of {} designs lack values; first: {which}", self.bad, self.count));
        }
        if let Some(reason) = unsettled {
            let (which, what) = (design_or_none(reason), "were measured before they had settled");
            lines.push(format!("{} of {} designs {what}; first: {which}", self.unsettled, self.count));
        }
        for record in &self.records {
            let (Some(least), Some(largest)) = (&record.least, &record.largest) else { continue };
            let unit = unit_of(self.set.measure_unit(&record.measure));
            let told = |found: &Extremum| {
                let at = if self.count > 1 {
                    design_in_words(&self.set, &self.names, &found.design)
                } else {
                    String::new()
                };
                let at = if at.is_empty() { at } else { format!(" at {at}") };
                format!("{}{unit}{at}", with_spread(found.value, found.spread))
            };
            let what = match self.motions {
                1 => record.measure.to_string(),
                n => format!("{}, largest of {n} motions", record.measure),
            };
            // The values are equal apart from rounding.
            if significant(least.value) == significant(largest.value) {
                lines.push(format!("{what}: {}", told(least)));
            } else {
                lines.push(format!("{what}: smallest {}; largest {}", told(least), told(largest)));
            }
        }
        if !self.draws {
            lines.push(format!("no picture: {} designs, but at most {MOST_DRAWN} are drawn", self.count));
        }
        lines
    }
}

impl<M: Labelled> Collected<M> {
    /// If no design has a value, the first reason.
    pub fn nothing(&self) -> Option<String> {
        let [lacking, _] = &self.reasons;
        let all_of = |reason: &String| match self.count {
            1 => design_or_none(reason).to_owned(),
            count => format!("all {count} designs failed; first: {}", design_or_none(reason)),
        };
        (self.empty == self.count).then(|| lacking.as_ref().map(all_of)).flatten()
    }
}

/// A measure of a row, rounded to its spread, with unit and design.
pub(super) fn value_in_words<M: Labelled>(
    set: &M,
    measure: &M::Measure,
    found: Summary,
    row: &DesignRow,
    names: &[M::Name],
) -> String {
    let unit = unit_of(set.measure_unit(measure));
    let value = with_spread(found.largest, found.spread);
    format!("{value}{unit} at {}", design_in_words(set, names, &row.values))
}

/// Unit of a measure with a space before it.
fn unit_of(unit: &str) -> String {
    match unit {
        "1" => String::new(),
        unit => format!(" {}", unit.replace('.', "·")),
    }
}

/// A number rounded to its spread: `0.0248 ± 0.0003`.
pub(in crate::studies) fn with_spread(value: f64, spread: f64) -> String {
    if spread <= REGULAR * value.abs() {
        return significant(value);
    }
    // The spread has one digit, or two digits if it begins with 1.
    let power = spread.log10().floor();
    let digits = if spread / 10f64.powf(power) < 2.0 { 1 } else { 0 };
    let decimals = (digits - power as i32).max(0) as usize;
    format!("{value:.decimals$} ± {spread:.decimals$}").replace('-', "−")
}

/// Removes the `: ` in front of a reason whose design has an empty name.
fn design_or_none(reason: &str) -> &str {
    reason.strip_prefix(": ").unwrap_or(reason)
}

/// A design in words, in the written units of the machine: `block.m = 1.2 kg, stop.gap = 10 mm`.
fn design_in_words<M: Labelled>(set: &M, names: &[M::Name], values: &[f64]) -> String {
    let told =
        |(name, value): (&M::Name, &f64)| format!("{} = {}", M::name(name), set.with_unit(name, *value));
    names.iter().zip(values).map(told).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::with_spread;

    #[test]
    fn closed_form_of_digits_by_their_spread() {
        for (value, spread, words) in [
            (0.024_795_81, 0.000_31, "0.0248 ± 0.0003"),
            (0.024_795_81, 0.000_131, "0.02480 ± 0.00013"),
            (1.234_567, 0.0, "1.234567"),
            (1.234_567, 1e-9, "1.234567"),
            (-12.345, 0.5, "−12.3 ± 0.5"),
            (1234.5, 31.0, "1234 ± 31"),
        ] {
            assert_eq!(with_spread(value, spread), words);
        }
    }
}
