//! Ranges, lists and pairs of parameters, and shares of a study, as arguments:
//! `drive.frequency=9Hz:11Hz:200`, `f10=0.6,1.2`, `block.m,stop.gap`.

use clap::Args;
use std::cmp::Ordering;
use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;
pub use vibro::machine::note_of_unit;
use vibro::{Error, Result};
use vibro_studies::paper::{Name, ParameterSet, Unit, numbers};
use vibro_studies::parts::Shard;
use vibro_studies::{AxisName, ParameterAxis};

/// A share of a long study.
#[derive(Args, Debug)]
pub struct Share {
    /// Compute only share I of N, e.g. 2/4; `vibro merge` combines the shares and draws the study
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
}

/// A parameter of either form and a range of it, as `name=from:to` or `name=from:to:count`.
#[derive(Clone, Copy, Debug)]
pub struct ParameterRange<N = Name> {
    /// The parameter.
    pub name: N,
    /// Its ends in its SI unit, the lower one first; both are valid values. Ends without a unit
    /// are as typed until [`read_in_written_unit`](InWrittenUnit::read_in_written_unit) converts
    /// them.
    pub ends: (f64, f64),
    /// The number of values, if it was given.
    pub count: Option<usize>,
    /// Unit of the ends, if they were given with one.
    pub unit: Option<&'static Unit>,
}

/// A parameter of either form and some of its values, as `name=value,value,…`.
#[derive(Clone, Debug)]
pub struct ParameterValues<N = Name> {
    /// The parameter.
    pub name: N,
    /// The values in its SI unit, as given; all are valid. Values without a unit are as typed
    /// until [`read_in_written_unit`](InWrittenUnit::read_in_written_unit) converts them.
    pub values: Vec<f64>,
    /// Unit of the values, if they were given with one.
    pub unit: Option<&'static Unit>,
}

/// Two parameters, as `name,name`.
#[derive(Clone, Copy, Debug)]
pub struct ParameterPair {
    /// The parameter on the horizontal axis.
    pub x: Name,
    /// The parameter on the vertical axis.
    pub y: Name,
}

/// Parser of a whole number in a range; errors state the range.
pub fn whole<T>(
    allowed: RangeInclusive<T>,
) -> impl Fn(&str) -> std::result::Result<T, String> + Clone + Send + Sync + 'static
where
    T: FromStr + PartialOrd + fmt::Debug + Clone + Send + Sync + 'static,
{
    let words = format!("a whole number from {:?} to {:?}", allowed.start(), allowed.end());
    whole_of(allowed, words)
}

/// Parser of a whole number in a range; errors state `words`.
pub fn whole_of<T>(
    allowed: RangeInclusive<T>,
    words: impl Into<String>,
) -> impl Fn(&str) -> std::result::Result<T, String> + Clone + Send + Sync + 'static
where
    T: FromStr + PartialOrd + Clone + Send + Sync + 'static,
{
    let words = words.into();
    move |text| match text.parse::<T>() {
        Ok(number) if allowed.contains(&number) => Ok(number),
        _ => Err(format!("expected {words}")),
    }
}

/// Adds the option's name to the error of a value that is parsed after the command line, for
/// `map_err`.
pub fn in_option<E: fmt::Display>(option: &'static str) -> impl FnOnce(E) -> Error {
    move |error| Error::Refused { what: option.into(), problem: error.to_string() }
}

/// Error for an option that is given another number of times than expected.
pub fn other_number(option: &'static str, expected: &str, found: usize) -> Error {
    Error::Refused { what: option.into(), problem: format!("{expected}; found {found}") }
}

/// Parses the texts of an option whose form depends on the machine.
///
/// # Errors
/// [`Error::Refused`] with the option if a text cannot be parsed.
pub fn texts<T: FromStr<Err: fmt::Display>>(option: &'static str, given: &[String]) -> Result<Vec<T>> {
    given.iter().map(|text| text.parse().map_err(in_option(option))).collect()
}

/// Parser of a finite number in a range; errors state `words`.
pub fn real(
    allowed: RangeInclusive<f64>,
    words: &'static str,
) -> impl Fn(&str) -> std::result::Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse::<f64>().ok().filter(|number| number.is_finite() && allowed.contains(number));
        number.ok_or_else(|| format!("expected {words}"))
    }
}

impl FromStr for ParameterRange {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        const FORM: &str = "name=from:to or name=from:to:count with from < to, e.g. sigma1=-2:2 or drive.frequency=9Hz:11Hz:200";
        let form = || Error::form(text, FORM);
        let (name, ends) = text.split_once('=').ok_or_else(form)?;
        let name = Name::find(name.trim())?;
        let (from, to, count) = match ends.split(':').collect::<Vec<_>>()[..] {
            [from, to] => (from, to, None),
            [from, to, count] => (from, to, Some(count.trim().parse().map_err(|_| form())?)),
            _ => return Err(form()),
        };
        let (ends, unit) = numbers(name, &[from, to])?;
        let ends = (ends[0], ends[1]);
        if ends.0.partial_cmp(&ends.1) != Some(Ordering::Less) {
            return Err(form());
        }
        check_if_certain(name, unit, &[ends.0, ends.1])?;
        Ok(Self { name, ends, count, unit })
    }
}

impl FromStr for ParameterValues {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let form = || Error::form(text, "name=value,value,…, e.g. f10=0.6,1.2,1.5");
        let (name, list) = text.split_once('=').ok_or_else(form)?;
        let name = Name::find(name.trim())?;
        let (values, unit) = numbers(name, &list.split(',').collect::<Vec<_>>())?;
        check_if_certain(name, unit, &values)?;
        Ok(Self { name, values, unit })
    }
}

impl FromStr for ParameterPair {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let form =
            || Error::form(text, "two names separated by a comma, e.g. sigma1,f10 or block.m,stop.gap");
        let (x, y) = text.split_once(',').ok_or_else(form)?;
        Ok(Self { x: Name::find(x.trim())?, y: Name::find(y.trim())? })
    }
}

// The text is in SI and has the parameter's own name, so that equal ranges have equal texts even
// if they were typed in different forms.
impl<N: AxisName> fmt::Display for ParameterRange<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}:{}", self.name.text(), self.ends.0, self.ends.1)?;
        self.count.map_or(Ok(()), |count| write!(f, ":{count}"))
    }
}

impl<N: AxisName> fmt::Display for ParameterValues<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let values: Vec<String> = self.values.iter().map(f64::to_string).collect();
        write!(f, "{}={}", self.name.text(), values.join(","))
    }
}

impl fmt::Display for ParameterPair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{}", self.x.name(), self.y.name())
    }
}

/// Default range of pictures, widened to contain the value that was set.
pub fn shown(set: &ParameterSet, name: Name, default: (f64, f64)) -> ParameterRange {
    let own = if set.is_set(name) { name.value(set) } else { default.0 };
    ParameterRange { name, ends: (default.0.min(own), default.1.max(own)), count: None, unit: None }
}

/// Values of a parameter on an axis. A number without a unit is in the unit that the machine's
/// file or `--set` used for that parameter. This unit is known only after these are read.
pub trait InWrittenUnit: fmt::Display {
    /// The parameter.
    fn name(&self) -> Name;

    /// Unit of the typed values, if they have one.
    fn unit(&mut self) -> &mut Option<&'static Unit>;

    /// The values.
    fn values(&mut self) -> Vec<&mut f64>;

    /// Converts values without a unit from the parameter's written unit; returns a note if this
    /// unit is not SI.
    ///
    /// # Errors
    /// An error if a value is outside its parameter's range.
    fn read_in_written_unit(&mut self, set: &ParameterSet) -> Result<Option<String>> {
        let (name, typed) = (self.name(), self.to_string());
        let written = set.unit(name).filter(|unit| self.unit().is_none() && !unit.is_si());
        if let Some(unit) = written {
            *self.unit() = Some(unit);
            self.values().into_iter().for_each(|value| *value = unit.si(*value));
        }
        for value in self.values() {
            name.check(*value).map_err(vibro_studies::Error::from)?;
        }
        Ok(written.map(|unit| note_of_unit(&typed, unit)))
    }
}

impl InWrittenUnit for ParameterRange {
    fn name(&self) -> Name {
        self.name
    }

    fn unit(&mut self) -> &mut Option<&'static Unit> {
        &mut self.unit
    }

    fn values(&mut self) -> Vec<&mut f64> {
        vec![&mut self.ends.0, &mut self.ends.1]
    }
}

impl InWrittenUnit for ParameterValues {
    fn name(&self) -> Name {
        self.name
    }

    fn unit(&mut self) -> &mut Option<&'static Unit> {
        &mut self.unit
    }

    fn values(&mut self) -> Vec<&mut f64> {
        self.values.iter_mut().collect()
    }
}

/// Checks values whose unit is final: values with a unit, and groups, which have none.
fn check_if_certain(name: Name, unit: Option<&Unit>, values: &[f64]) -> Result<()> {
    let certain = unit.is_some() || matches!(name, Name::Group(_));
    let check = |value: &f64| name.check(*value).map_err(|e| vibro_studies::Error::from(e).into());
    if certain { values.iter().try_for_each(check) } else { Ok(()) }
}

impl<N: AxisName> ParameterRange<N> {
    /// The axis over this range, with `resolution` values unless the range has its own count.
    ///
    /// # Errors
    /// [`Error::Refused`] if the count is outside `allowed`.
    pub fn axis(&self, resolution: usize, allowed: RangeInclusive<usize>) -> Result<ParameterAxis<N>> {
        let count = self.count.unwrap_or(resolution);
        if !allowed.contains(&count) {
            let text = format!("{}: {count} values", self.name.text());
            let problem = format!("expected {} to {}", allowed.start(), allowed.end());
            return Err(Error::Refused { what: text, problem });
        }
        Ok(ParameterAxis::of(self.name.clone(), self.ends, count)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_each_form_are_read() {
        let range: ParameterRange = "sigma1 = -2:2".parse().unwrap();
        assert_eq!((range.name.name(), range.ends, range.count), ("sigma1", (-2.0, 2.0), None));
        let range: ParameterRange = "stop.gap=1 mm:20mm:40".parse().unwrap();
        assert_eq!((range.name.name(), range.ends, range.count), ("stop.gap", (0.001, 0.02), Some(40)));
        let list: ParameterValues = "f10=0.6, 1.2".parse().unwrap();
        assert_eq!((list.name.name(), list.values), ("f10", vec![0.6, 1.2]));
        let pair: ParameterPair = "m2,stop.gap".parse().unwrap();
        assert_eq!((pair.x.name(), pair.y.name()), ("block.m", "stop.gap"));
    }

    #[test]
    fn texts_of_another_form_are_refused_with_the_right_one() {
        fn error<T: FromStr<Err = Error>>(text: &str) -> String {
            text.parse::<T>().err().expect("an error").to_string()
        }
        assert_eq!(
            error::<ParameterRange>("sigma=-2:2"),
            "no parameter is named `sigma`; did you mean `sigma1`? `sigma1`: detuning of the excitation, \
             omega1/omega10 = 1 + epsilon sigma1, a finite number > -1/epsilon"
        );
        assert!(error::<ParameterRange>("sigma1=2:-2").contains("from < to"));
        assert!(error::<ParameterRange>("sigma1=-2:2:many").contains("from < to"));
        assert!(error::<ParameterRange>("drive.frequency=9:11Hz").contains("a unit on every number"));
        assert_eq!(error::<ParameterValues>("kappa=0.5,1.5"), "kappa = 1.5: expected 0 <= kappa <= 1");
        assert_eq!(
            error::<ParameterValues>("kappa=0.5,high"),
            "kappa = `high` is not a number: expected 0 <= kappa <= 1"
        );
        assert!(error::<ParameterPair>("kappa").contains("sigma1,f10"));
        let range: ParameterRange = "f10=1:2:1".parse().unwrap();
        let refused = range.axis(10, 2..=100).unwrap_err().to_string();
        assert_eq!(refused, "f10: 1 values: expected 2 to 100");
    }
}
