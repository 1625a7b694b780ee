//! What is kept of a sweep's rows while they pass: values for the picture, and what is worth saying.

use super::words::Told;
use vibro_analysis::design_sweep::{Request, Row, rows};
use vibro_analysis::significant;

/// Most designs of a picture.
const MOST_DRAWN: usize = 100_000;

/// Least and largest of a measure over the motions of a design; `None` where it has no value.
pub(super) type Reach = Option<(f64, f64)>;

/// One measure of all designs.
pub(super) struct MeasureRecord<M: Told> {
    pub measure: M::Measure,
    /// Its place among the request's measures.
    index: usize,
    /// For the picture, design by design.
    pub reaches: Vec<Reach>,
    /// The designs of the least values, from the least up, and that of the largest.
    least: Vec<Found>,
    largest: Option<Found>,
}

/// A value with its spread, and the parameters of its design.
#[derive(Clone)]
struct Found {
    value: f64,
    spread: f64,
    design: Vec<f64>,
}

/// Designs that are measured again before one of them is called the best.
const BEST: usize = 5;
/// What is this part of a value and less is rounding, and no spread.
const REGULAR: f64 = 1e-6;

/// What is kept of a sweep.
pub(super) struct Collected<M: Told> {
    /// For the units in which parameters are told.
    set: M,
    names: Vec<M::Name>,
    motions: usize,
    /// Values of the parameters, design by design, for the picture.
    pub values: Vec<Vec<f64>>,
    /// The measures that are numbers.
    pub records: Vec<MeasureRecord<M>>,
    draws: bool,
    count: usize,
    bad: usize,
    reason: Option<String>,
}

impl<M: Told> Collected<M> {
    pub fn new(set: &M, request: &Request<M>) -> Self {
        let numbers = request.measures.iter().enumerate().filter(|(_, m)| !M::is_class(m));
        let record = |(index, measure): (usize, &M::Measure)| MeasureRecord {
            measure: measure.clone(),
            index,
            reaches: Vec::new(),
            least: Vec::new(),
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
                let here =
                    || Found { value: found.largest, spread: found.spread, design: row.values.clone() };
                let place = record.least.partition_point(|other| other.value <= found.largest);
                if place < BEST {
                    record.least.insert(place, here());
                    record.least.truncate(BEST);
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

    /// What to say, line by line.
    pub fn remarks(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(reason) = &self.reason {
            let which = design_or_none(reason);
            lines.push(format!("{} of {} designs lack values; the first: {which}", self.bad, self.count));
        }
        for record in &self.records {
            let (Some(least), Some(largest)) = (record.least.first(), &record.largest) else { continue };
            let unit = unit_of(self.set.measure_unit(&record.measure));
            let told = |found: &Found| {
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
            // The same but for rounding.
            if significant(least.value) == significant(largest.value) {
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

impl<M: Told> Collected<M> {
    /// The best few designs by the first measure, measured again for longer and from more starts, and what to say of them. Nothing where
    /// there is nothing to choose from, or where the measure does not depend on the motion.
    pub fn measured_again(&self, set: &M, request: &Request<M>) -> Vec<String> {
        let Some(record) = self.records.first() else { return Vec::new() };
        let least: Vec<&Found> = record.least.iter().collect();
        if least.len() < 2 || M::is_closed_form(&record.measure) {
            return Vec::new();
        }
        let again =
            request.again(least.iter().map(|found| found.design.clone()).collect(), record.measure.clone());
        let mut found: Vec<Found> = rows(set, &again)
            .into_iter()
            .filter_map(|row| {
                let output = row.outputs.first().copied().flatten()?;
                Some(Found { value: output.largest, spread: output.spread, design: row.values })
            })
            .collect();
        found.sort_by(|a, b| a.value.total_cmp(&b.value));
        let unit = unit_of(self.set.measure_unit(&record.measure));
        let mut lines = vec![format!(
            "the {} least by {} again, over {} {} from {}:",
            found.len(),
            record.measure,
            again.periods,
            M::periods(),
            if again.starts.len() == 1 {
                "one start".into()
            } else {
                format!("{} starts", again.starts.len())
            }
        )];
        let told = |one: &Found| {
            let value = with_spread(one.value, one.spread);
            format!("  {value}{unit} at {}", design_in_words(&self.set, &self.names, &one.design))
        };
        lines.extend(found.iter().map(told));
        if let [first, second, ..] = &found[..]
            && second.value - first.value < 2.0 * first.spread.hypot(second.spread)
        {
            lines.push(
                "  of these the first two are not told apart: they differ by less than twice their spread"
                    .into(),
            );
        }
        lines
    }
}

/// The unit of a measure, with a space before it.
fn unit_of(unit: &str) -> String {
    match unit {
        "1" => String::new(),
        unit => format!(" {}", unit.replace('.', "·")),
    }
}

/// A number to the digits that its spread leaves: `0.0248 ± 0.0003`.
fn with_spread(value: f64, spread: f64) -> String {
    if spread <= REGULAR * value.abs() {
        return significant(value);
    }
    // One digit of the spread, two where it begins with 1.
    let power = spread.log10().floor();
    let digits = if spread / 10f64.powf(power) < 2.0 { 1 } else { 0 };
    let decimals = (digits - power as i32).max(0) as usize;
    format!("{value:.decimals$} ± {spread:.decimals$}").replace('-', "−")
}

/// A reason without the empty name of the one design there is.
fn design_or_none(reason: &str) -> &str {
    reason.strip_prefix(": ").unwrap_or(reason)
}

/// A design in words, in the units in which the machine was written: `block.m = 1.2 kg, stop.gap = 10 mm`.
fn design_in_words<M: Told>(set: &M, names: &[M::Name], values: &[f64]) -> String {
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
