//! Numbers that follow from named parameters by the expressions of a machine's file.

use crate::description::Description;
use crate::named::{Named, NamedParameters};
use crate::refusal::Problem;
use crate::slots::{Slot, slots};
use vibro_numerics::Range;

/// A number that follows from named parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Following {
    /// Name, as in [`Description::parameters`], or the name of a named parameter.
    pub name: String,
    /// SI unit; `1` for a named parameter.
    pub unit: &'static str,
    /// Value in the SI unit.
    pub value: f64,
    /// Meaning in words; for a named parameter the comment after it in the file.
    pub meaning: String,
    /// Range of valid values.
    pub range: Range,
    /// The expression, as the file writes it: `= backlash / 2`.
    pub expression: String,
}

impl Description {
    /// Numbers that follow from named parameters: parameters with expressions, then numbers of the
    /// machine in the order of [`parameters`](Self::parameters).
    ///
    ///
    /// ```
    /// use vibro_machine::file::{no_records, parse};
    ///
    /// let text = r#"
    ///     name = "Gear"
    ///     parameters = { backlash = "0.1 mm", half = "= backlash / 2" }
    ///     body.wheel = { mass = 1.0 }
    ///     stop.flank = { between = ["ground", "wheel"], gap = "= half", restitution = 0.4 }
    /// "#;
    /// let machine = parse(text, "gear.toml", &no_records)?.with([("backlash", 2e-4)])?;
    /// let found = machine.following();
    /// assert_eq!((found[0].name.as_str(), found[0].value), ("half", 1e-4));
    /// assert_eq!((found[1].name.as_str(), found[1].value), ("stop.flank.gap", 1e-4));
    /// # Ok::<(), vibro_machine::Refusal>(())
    /// ```
    pub fn following(&self) -> Vec<Following> {
        let of_expression = |own: &Named| {
            let expression = format!("= {}", own.expression.as_ref()?.text);
            let (name, meaning, range) = (own.name.clone(), own.meaning(), Range::FINITE);
            Some(Following { name, unit: own.unit, value: own.value, meaning, range, expression })
        };
        let mut all: Vec<_> = self.named.all().iter().filter_map(of_expression).collect();
        if !self.named.has_numbers() {
            return all;
        }
        let mut copy = self.clone();
        all.extend(slots(&mut copy).into_iter().filter_map(|slot| {
            let expression = format!("= {}", self.named.of_number(&slot.name)?.text);
            let (unit, value) = (slot.kind.unit(slot.dimension), *slot.value);
            let (meaning, range) = (slot.kind.meaning.to_owned(), slot.kind.range);
            Some(Following { name: slot.name, unit, value, meaning, range, expression })
        }));
        all
    }

    /// Sets the numbers that follow from named parameters; returns the problems.
    pub(crate) fn follow(&mut self) -> Vec<Problem> {
        // Values that are not finite are refused under the parameters' own names.
        if self.named.all().iter().any(|own| !own.value.is_finite()) || self.named.all().is_empty() {
            return Vec::new();
        }
        // The machine keeps them: which exponents are numbers of the machine follows from them.
        let mut named = self.named.clone();
        let mut problems = Vec::new();
        if let Err((place, text)) = named.evaluate() {
            problems.push(Problem::new(&named.all()[place].name, None, text));
        } else {
            problems = self.put_numbers(&named);
        }
        self.named = named;
        problems
    }

    fn put_numbers(&mut self, named: &NamedParameters) -> Vec<Problem> {
        let (values, mut problems) = (named.values(), Vec::new());
        for Slot { name, value, .. } in slots(self) {
            match named.of_number(&name).map(|expression| expression.value(&values)) {
                Some(Ok(found)) => *value = found,
                Some(Err(text)) => problems.push(Problem::new(name, None, text)),
                None => {}
            }
        }
        problems
    }
}
