//! Columns that a sensor records through its low-pass filter, for example the acceleration of an
//! accelerometer.
//!
//! A filter is a linear block of the machine without effect on its motion. Its states are the
//! low-pass filtered quantity u and its derivatives over powers of the corner frequency ω: x_k' =
//! ω x_(k+1), and for the last one x_(n-1)' = ω (u - Σ a_k x_k) with Butterworth's a_k. A filtered
//! acceleration is the rate ω x_1 of the filtered velocity. An impact is a jump of u: the filter
//! responds to the momentum without an impulse.

use super::{FitRequest, Fitted};
use crate::error::{Error, Result};
use crate::{Machine, QuantityName};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use vibro_machine::derivative::By;
use vibro_machine::description::{Block, BlockInput, Description};
use vibro_machine::{Assembly, Differentiated, Quantity, Start, What};

/// Largest order: sensors have 1 to 8, and coefficients of higher orders lose digits.
const MOST: u32 = 8;

/// Butterworth low-pass filter of a column.
#[derive(Clone, Debug, PartialEq)]
pub struct Filter {
    /// The column: `a`, `v` or `s` of a body, `e` or `rate` of an element.
    pub column: QuantityName,
    /// Order, 1 to 8.
    pub order: u32,
    /// Corner frequency, Hz, at which half of the power passes.
    pub frequency: f64,
}

/// Filter of a column as a block of the machine.
pub(super) struct Sensor {
    block: usize,
    /// Unfiltered quantity, the input of the filter.
    input: Quantity,
    /// Index of the first state among the start parameters.
    place: usize,
    /// Quantity of the column, and its rate if the filter provides one.
    pub output: Quantity,
    pub rate: Option<Quantity>,
}

/// Coefficients of the Butterworth polynomial, beginning with s⁰.
fn butterworth(order: u32) -> Vec<f64> {
    let times = |own: Vec<f64>, factor: &[f64]| {
        let mut product = vec![0.0; own.len() + factor.len() - 1];
        for (i, a) in own.iter().enumerate() {
            factor.iter().enumerate().for_each(|(j, b)| product[i + j] += a * b);
        }
        product
    };
    let odd = if order % 2 == 1 { vec![1.0, 1.0] } else { vec![1.0] };
    (0..order / 2).fold(odd, |own, k| {
        let angle = PI * f64::from(2 * k + 1) / f64::from(2 * order);
        times(own, &[1.0, 2.0 * angle.sin(), 1.0])
    })
}

impl Filter {
    fn check(&self, request: &FitRequest) -> Result<()> {
        let Self { column, order, frequency } = self;
        let refused = |problem: String| Err(Error::Described { problem });
        if !request.measured.columns.iter().any(|(own, _)| own == column) {
            let known: Vec<String> = request.measured.columns.iter().map(|own| own.0.to_string()).collect();
            let known = known.join(", ");
            return refused(format!(
                "filter of {column}: the record has no such column; expected one of {known}"
            ));
        }
        if request.filters.iter().filter(|own| own.column == *column).count() > 1 {
            return refused(format!("{column} has two filters; expected one"));
        }
        if !((1..=MOST).contains(order) && *frequency > 0.0 && frequency.is_finite()) {
            return refused(format!(
                "filter of {column}: order {order}, {frequency:?} Hz; expected an order from 1 to {MOST} and a frequency above 0 Hz"
            ));
        }
        Ok(())
    }

    /// Input of the filter; for an acceleration it is the velocity.
    fn input(&self, d: &Description) -> Result<(BlockInput, QuantityName)> {
        let QuantityName { of, what } = &self.column;
        let body = d.bodies.iter().position(|own| own.name == *of);
        let element = d.elements().position(|own| own.name() == of);
        let (input, what) = match (what, body, element) {
            (What::A | What::V, Some(body), _) => (BlockInput::Rate(body), What::V),
            (What::S, Some(body), _) => (BlockInput::Place(body), What::S),
            (What::E, _, Some(element)) => (BlockInput::Elongation(element), What::E),
            (What::Rate, _, Some(element)) => (BlockInput::ElongationRate(element), What::Rate),
            _ => {
                let column = &self.column;
                let problem = format!(
                    "{column} cannot be filtered; expected a, v or s of a body, or e or rate of an element"
                );
                return Err(Error::Described { problem });
            }
        };
        Ok((input, QuantityName { of: of.clone(), what }))
    }

    /// The filter as a block with outputs `y`, the column's quantity, and `rate`, the rate of `y`.
    fn block(&self, d: &Description) -> Result<Block> {
        let (n, corner) = (self.order as usize, TAU * self.frequency);
        let polynomial = butterworth(self.order);
        let row = |k: usize| -> Vec<f64> {
            let below = |j: usize| if k + 1 < n { f64::from(u8::from(j == k + 1)) } else { -polynomial[j] };
            (0..n).map(|j| corner * below(j)).collect()
        };
        let feed = |k: usize| vec![if k + 1 < n { 0.0 } else { corner }];
        let unit = |k: usize| (0..n).map(|j| f64::from(u8::from(j == k))).collect::<Vec<f64>>();
        // The derivatives of the first state are rows of `a` and `b`.
        let derivative = |order: usize| match order {
            0 => (unit(0), vec![0.0]),
            order => {
                let scale = corner.powi(order as i32 - 1);
                let scaled = |own: Vec<f64>| own.into_iter().map(|x| scale * x).collect::<Vec<f64>>();
                (scaled(row(order - 1)), scaled(feed(order - 1)))
            }
        };
        let first = usize::from(self.column.what == What::A);
        // A derivative beyond the order would need the derivative of the input.
        let outputs = (first..=n.min(first + 1)).map(derivative);
        let (c, d_rows): (Vec<_>, Vec<_>) = outputs.unzip();
        let is_taken = |name: &String| {
            d.bodies.iter().any(|own| own.name == *name) || d.elements().any(|own| own.name() == name)
        };
        let mut name = format!("{}_{}_sensor", self.column.of, self.column.what.word());
        while is_taken(&name) {
            name.push('_');
        }
        Ok(Block {
            name,
            inputs: vec![self.input(d)?.0],
            start: vec![0.0; n],
            a: (0..n).map(row).collect(),
            b: (0..n).map(feed).collect(),
            limits: vec![None; c.len()],
            outputs: ["y", "rate"].into_iter().take(c.len()).map(String::from).collect(),
            c,
            d: d_rows,
            sampling: None,
        })
    }
}

/// Request whose machine contains the filters; `None` without filters.
///
/// # Errors
/// [`Error::Described`] for an invalid filter, and for an acceleration without one.
pub(super) fn carrying(request: &FitRequest) -> Result<Option<FitRequest>> {
    request.filters.iter().try_for_each(|filter| filter.check(request))?;
    let is_filtered = |name: &QuantityName| request.filters.iter().any(|own| own.column == *name);
    if let Some((name, _)) =
        request.measured.columns.iter().find(|(own, _)| own.what == What::A && !is_filtered(own))
    {
        let problem = format!(
            "{name} has no filter; an acceleration requires the filter of its sensor, because it \
             is not finite at an impact: --filter {name}=ORDER,FREQUENCY, e.g. {name}=2,400Hz"
        );
        return Err(Error::Described { problem });
    }
    if request.filters.is_empty() {
        return Ok(None);
    }
    let mut carrying = request.clone();
    for filter in &request.filters {
        let block = filter.block(&carrying.machine.description)?;
        carrying.machine.description.blocks.push(block);
    }
    Ok(Some(carrying))
}

/// Fitted machine with its filters removed.
pub(super) fn without(fitted: Fitted, filters: usize) -> Fitted {
    let mut fitted = fitted;
    let blocks = &mut fitted.machine.description.blocks;
    blocks.truncate(blocks.len() - filters);
    fitted
}

/// Filters in a request's machine.
pub(super) fn sensors(request: &FitRequest) -> Result<Vec<Sensor>> {
    let d = &request.machine.description;
    if request.filters.is_empty() {
        return Ok(Vec::new());
    }
    let names = Start::names(&Assembly::new(d.clone())?);
    let first = d.blocks.len() - request.filters.len();
    let sensor = |(k, filter): (usize, &Filter)| {
        let own = &d.blocks[first + k];
        let quantity = |output: &str| {
            let name: QuantityName = format!("{}.{output}", own.name).parse()?;
            Ok::<_, Error>(name.find(d)?.quantity)
        };
        let state = format!("{}.x[0]", own.name);
        Ok(Sensor {
            block: first + k,
            input: filter.input(d)?.1.find(d)?.quantity,
            place: names.iter().position(|name| *name == state).unwrap_or_default(),
            output: quantity("y")?,
            rate: own.outputs.get(1).map(|name| quantity(name)).transpose()?,
        })
    };
    request.filters.iter().enumerate().map(sensor).collect()
}

/// Starts the filters in the steady state of their input at the start. For an accelerometer, the
/// body has moved at constant velocity.
pub(super) fn begin(sensors: &[Sensor], machine: &mut Machine, start: &Start) -> Result<()> {
    if sensors.is_empty() {
        return Ok(());
    }
    let motion = start.motion(Arc::new(Assembly::new(machine.description.clone())?))?;
    for own in sensors {
        machine.description.blocks[own.block].start[0] = motion.value(own.input);
    }
    Ok(())
}

/// Dependency of the filters' initial states on the fitted parameters, through their inputs.
#[derive(Default)]
pub(super) struct Carried {
    /// For each filter its column of derivatives, and the derivatives of its initial state.
    of: Vec<(usize, Vec<Option<f64>>)>,
}

impl Carried {
    /// Dependencies at the start of a motion; adds a column for each filter.
    pub fn of(
        sensors: &[Sensor],
        (assembly, start): (&Arc<Assembly>, &Start),
        columns: &mut Vec<By>,
    ) -> Result<Self> {
        if sensors.is_empty() {
            return Ok(Self::default());
        }
        let motion: Differentiated = start.differentiated_by(assembly.clone(), columns, &mut |_, _| ())?;
        // Another start time does not change the initial values.
        let by = |own: &Sensor, p: usize| match columns[p] {
            By::Time => Some(0.0),
            _ => motion.derivative(own.input, p),
        };
        let count = columns.len();
        let of = sensors.iter().enumerate();
        let of = of.map(|(k, own)| (count + k, (0..count).map(|p| by(own, p)).collect())).collect();
        columns.extend(sensors.iter().map(|own| By::Start(own.place)));
        Ok(Self { of })
    }

    /// Derivative of a quantity by a column, including the filters' initial states.
    pub fn with(&self, p: usize, by: &dyn Fn(usize) -> Option<f64>) -> Option<f64> {
        let add = |sum: f64, (column, starts): &(usize, Vec<Option<f64>>)| match starts[p]? {
            0.0 => Some(sum),
            start => Some(sum + start * by(*column)?),
        };
        self.of.iter().try_fold(by(p)?, add)
    }
}

#[cfg(test)]
mod tests {
    use super::butterworth;

    #[test]
    fn closed_form_a_half_of_the_power_passes_at_the_corner_and_nearly_all_below() {
        // |B(i w)|² = 1 + w^(2n).
        for order in 1..=8 {
            let polynomial = butterworth(order);
            for w in [0.3f64, 1.0, 1.7] {
                let part = |from: usize| {
                    let terms = polynomial.iter().enumerate().skip(from).step_by(2);
                    terms
                        .map(|(k, a)| a * w.powi(k as i32) * if k / 2 % 2 == 0 { 1.0 } else { -1.0 })
                        .sum::<f64>()
                };
                let square = part(0).powi(2) + part(1).powi(2);
                // Rounding of nine terms of up to 14.
                assert!((square / (1.0 + w.powi(2 * order as i32)) - 1.0).abs() < 1e-13, "{order} {w}");
            }
        }
    }
}
