//! Ranges, lists and pairs of dimensionless groups as arguments: `sigma1=-2:2`, `f10=0.6,1.2`, `sigma1,f10`.

use std::str::FromStr;
use vibro::{Error, Result};
use vibro_analysis::{Group, Name, find_group, number};

/// A group and a range of it, as `name=from:to`.
#[derive(Clone, Copy, Debug)]
pub struct GroupRange {
    /// The group.
    pub group: &'static Group,
    /// Its ends, the lower one first; both are allowed values.
    pub ends: (f64, f64),
}

/// A group and some of its values, as `name=value,value,…`.
#[derive(Clone, Debug)]
pub struct GroupValues {
    /// The group.
    pub group: &'static Group,
    /// The values, as given; all are allowed.
    pub values: Vec<f64>,
}

/// Two groups, as `name,name`.
#[derive(Clone, Copy, Debug)]
pub struct GroupPair {
    /// The group on the horizontal axis.
    pub x: &'static Group,
    /// The group on the vertical axis.
    pub y: &'static Group,
}

impl FromStr for GroupRange {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let form = || Error::form(text, "name=from:to with from < to, e.g. sigma1=-2:2");
        let (name, ends) = text.split_once('=').ok_or_else(form)?;
        let group = find_group(name.trim())?;
        let (from, to) = ends.split_once(':').ok_or_else(form)?;
        let ends = (allowed(group, from)?, allowed(group, to)?);
        if ends.0 < ends.1 { Ok(Self { group, ends }) } else { Err(form()) }
    }
}

impl FromStr for GroupValues {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let form = || Error::form(text, "name=value,value,…, e.g. f10=0.6,1.2,1.5");
        let (name, list) = text.split_once('=').ok_or_else(form)?;
        let group = find_group(name.trim())?;
        let values = list.split(',').map(|value| allowed(group, value)).collect::<Result<_>>()?;
        Ok(Self { group, values })
    }
}

impl FromStr for GroupPair {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let form = || Error::form(text, "two names with a comma between, e.g. sigma1,f10");
        let (x, y) = text.split_once(',').ok_or_else(form)?;
        Ok(Self { x: find_group(x.trim())?, y: find_group(y.trim())? })
    }
}

/// A number in the group's range.
fn allowed(group: &'static Group, text: &str) -> Result<f64> {
    let value = number(Name::Group(group), text)?;
    group.check(value).map_err(vibro_analysis::Error::from)?;
    Ok(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_each_form_are_read() {
        let range: GroupRange = "sigma1 = -2:2".parse().unwrap();
        assert_eq!((range.group.name, range.ends), ("sigma1", (-2.0, 2.0)));
        let list: GroupValues = "f10=0.6, 1.2".parse().unwrap();
        assert_eq!((list.group.name, list.values), ("f10", vec![0.6, 1.2]));
        let pair: GroupPair = "kappa,gamma1".parse().unwrap();
        assert_eq!((pair.x.name, pair.y.name), ("kappa", "gamma1"));
    }

    #[test]
    fn texts_of_another_form_are_refused_with_the_right_one() {
        fn error<T: FromStr<Err = Error>>(text: &str) -> String {
            text.parse::<T>().err().expect("an error").to_string()
        }
        assert_eq!(
            error::<GroupRange>("sigma=-2:2"),
            "no parameter is named `sigma`; the nearest is `sigma1`: detuning of the excitation, \
             omega1/omega10 = 1 + epsilon sigma1, a finite number > -1/epsilon"
        );
        assert!(error::<GroupRange>("sigma1=2:-2").contains("from < to"));
        assert_eq!(error::<GroupValues>("kappa=0.5,1.5"), "kappa = 1.5: allowed is 0 <= kappa <= 1");
        assert_eq!(
            error::<GroupValues>("kappa=0.5,high"),
            "kappa = `high` is not a number: allowed is 0 <= kappa <= 1"
        );
        assert!(error::<GroupPair>("kappa").contains("sigma1,f10"));
    }
}
