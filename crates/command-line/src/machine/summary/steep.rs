//! Curved forces so steep that a motion takes many series.

use super::short;
use vibro_machine::Assembly;

/// Number of series a second above which a force is reported: about a second of computing for each
/// second of motion.
const MANY: f64 = 250_000.0;

/// A note on the steepest curved force at zero displacements and rates, if it makes series short.
#[must_use]
pub fn steep(assembly: &Assembly) -> Option<String> {
    let found = assembly.steepest_at_zero().filter(|own| own.series() > MANY)?;
    Some(format!(
        "{}: near e = 0 and rate = 0 its force changes as fast as {} 1/s; a second of motion there takes {} \
         series: use a flatter curve, or a [friction.NAME] for dry friction",
        found.element,
        short(found.rate),
        short(found.series())
    ))
}

#[cfg(test)]
mod tests {
    use super::steep;
    use vibro_machine::Assembly;
    use vibro_machine::file::{no_records, parse};

    /// The slope 3/10⁻⁷ N s/m of a force on 2 kg, and of one that is a thousand times flatter.
    #[test]
    fn closed_form_a_steep_force_is_named() {
        let line = |width: &str| {
            let text = format!(
                "name = \"Steep\"\nbody.m = {{ mass = 2.0 }}\n\
                 damper.d = {{ between = [\"ground\", \"m\"], force = \"= 3 * tanh(rate / {width})\" }}\n"
            );
            steep(&Assembly::new(parse(&text, "steep.toml", &no_records).unwrap()).unwrap())
        };
        let exact = "damper.d: near e = 0 and rate = 0 its force changes as fast as 1.50000e7 1/s; a second of motion \
                     there takes 3.75000e6 series: use a flatter curve, or a [friction.NAME] for dry friction";
        assert_eq!(line("1e-7").as_deref(), Some(exact));
        assert_eq!(line("1e-4"), None);
    }
}
