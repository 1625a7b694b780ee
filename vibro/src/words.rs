//! Ranges and lists of a group as text: `sigma1=-2:2`, `f10=0.6,1.2`, `sigma1,f10`.

use vibro_analysis::Group;
use vibro_analysis::{Error, Result};
use vibro_analysis::{Name, find_group, number};

const RANGE: &str = "name=from:to with from < to, e.g. sigma1=-2:2";
const VALUES: &str = "name=value,value,…, e.g. f10=0.6,1.2,1.5";
const PAIR: &str = "two names with a comma between, e.g. sigma1,f10";

fn form(text: &str, expected: &'static str) -> Error {
    Error::Form { text: text.into(), expected }
}

fn checked(group: &'static Group, text: &str) -> Result<f64> {
    let value = number(Name::Group(group), text)?;
    group.check(value)?;
    Ok(value)
}

/// A group with a range.
///
/// # Errors
/// [`Error::Form`], or the name or value that is not allowed.
pub fn range(text: &str) -> Result<(&'static Group, (f64, f64))> {
    let (name, ends) = text.split_once('=').ok_or_else(|| form(text, RANGE))?;
    let group = find_group(name.trim())?;
    let (from, to) = ends.split_once(':').ok_or_else(|| form(text, RANGE))?;
    let (from, to) = (checked(group, from)?, checked(group, to)?);
    if from < to { Ok((group, (from, to))) } else { Err(form(text, RANGE)) }
}

/// A group with some values.
///
/// # Errors
/// [`Error::Form`], or the name or value that is not allowed.
pub fn values(text: &str) -> Result<(&'static Group, Vec<f64>)> {
    let (name, list) = text.split_once('=').ok_or_else(|| form(text, VALUES))?;
    let group = find_group(name.trim())?;
    Ok((group, list.split(',').map(|v| checked(group, v)).collect::<Result<_>>()?))
}

/// Two groups.
///
/// # Errors
/// [`Error::Form`], or the name that is not known.
pub fn pair(text: &str) -> Result<(&'static Group, &'static Group)> {
    let (x, y) = text.split_once(',').ok_or_else(|| form(text, PAIR))?;
    Ok((find_group(x.trim())?, find_group(y.trim())?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_become_numbers() {
        let (group, ends) = range("sigma1 = -2:2").unwrap();
        assert_eq!((group.name, ends), ("sigma1", (-2.0, 2.0)));
        let (group, list) = values("f10=0.6, 1.2").unwrap();
        assert_eq!((group.name, list), ("f10", vec![0.6, 1.2]));
        let (x, y) = pair("kappa,gamma1").unwrap();
        assert_eq!((x.name, y.name), ("kappa", "gamma1"));
    }

    #[test]
    fn wrong_words_are_told_what_is_right() {
        let error = |e: Error| e.to_string();
        assert_eq!(
            error(range("sigma=-2:2").unwrap_err()),
            "no parameter is named `sigma`; the nearest is `sigma1`: detuning of the excitation, \
             omega1/omega10 = 1 + epsilon sigma1, a finite number > -1/epsilon"
        );
        assert!(error(range("sigma1=2:-2").unwrap_err()).contains("from < to"));
        assert_eq!(error(values("kappa=0.5,1.5").unwrap_err()), "kappa = 1.5: allowed is 0 <= kappa <= 1");
        assert_eq!(
            error(values("kappa=0.5,high").unwrap_err()),
            "kappa = `high` is not a number: allowed is 0 <= kappa <= 1"
        );
        assert!(error(pair("kappa").unwrap_err()).contains("sigma1,f10"));
    }
}
