//! Refusals of a changed machine under the names of the parameters that were set.

use super::NamedParameters;
use crate::refusal::Problem;

/// Whether a problem with the name `problem` concerns the number `number`: the number itself, the
/// element that has it, or a part of it.
fn concerns(problem: &str, number: &str) -> bool {
    let is_part = |whole: &str, part: &str| {
        part.strip_prefix(whole).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
    };
    is_part(problem, number) || is_part(number, problem)
}

impl NamedParameters {
    /// A problem of a changed machine, under the names of the set parameters that cause it, as
    /// `ratio = 0.5: then stop.hard.restitution = 1 / ratio = 2.0: …`. `set` holds all numbers
    /// that were set, with their values.
    pub(crate) fn blame(&self, problem: Problem, set: &[(String, f64)]) -> Problem {
        if set.iter().any(|own| own.0 == problem.name) {
            return problem;
        }
        let is_named = |own: &&(String, f64)| self.all.iter().any(|named| named.name == own.0);
        let is_source = |own: &&(String, f64)| {
            self.names_that_follow()
                .any(|name| concerns(&problem.name, name) && self.sources_of(name).contains(&own.0.as_str()))
        };
        let mut causes: Vec<_> = set.iter().filter(is_source).collect();
        // The machine was valid before the change.
        if causes.is_empty() && set.iter().all(|own| is_named(&own)) {
            causes = set.iter().collect();
        }
        let Some((last, before)) = causes.split_last() else { return problem };
        let before: String = before.iter().map(|(name, value)| format!("{name} = {value:?}, ")).collect();
        let expression = self.expression_of(&problem.name);
        let expression = expression.map_or_else(String::new, |own| format!(" = {}", own.text));
        let value = problem.value.map_or_else(String::new, |value| format!(" = {value}"));
        let text = format!("then {}{expression}{value}: {}", problem.name, problem.text);
        Problem::new(format!("{before}{}", last.0), Some(format!("{:?}", last.1)), text)
    }

    /// The names of parameters with expressions and of the machine's numbers that follow.
    fn names_that_follow(&self) -> impl Iterator<Item = &str> {
        let own = self.all.iter().filter(|named| named.expression.is_some());
        own.map(|named| named.name.as_str()).chain(self.numbers.keys().map(String::as_str))
    }
}
