//! Names of machines, quantities, measures and parameters in words, and units of display, for
//! titles and axes of pictures.

use vibro_figures::chart::Axis;
use vibro_machine::description::{Description, Dimension};
use vibro_machine::{Element, Owner, What};
use vibro_studies::{Measure, QuantityName};

/// Units that take a prefix.
const PREFIXED: [&str; 8] = ["m", "rad", "s", "N", "N.m", "m/s", "J", "W"];
/// Sizes below which values are shown with the prefix milli, and below which with micro.
const MILLI: f64 = 0.1;
const MICRO: f64 = 1e-4;
/// Forces and torques of this size and larger ones are shown with the prefix kilo.
const KILO: f64 = 1e4;

/// Unit of display of SI values up to `largest` in size: its factor from SI and its symbol, `1` for
/// a plain number.
pub fn shown_unit(unit: &str, largest: f64) -> (f64, String) {
    let (factor, prefix) = match largest {
        _ if !PREFIXED.contains(&unit) || largest <= 0.0 => (1.0, ""),
        size if size < MICRO => (1e6, "µ"),
        size if size < MILLI => (1e3, "m"),
        size if size >= KILO && unit.starts_with('N') => (1e-3, "k"),
        _ => (1.0, ""),
    };
    (factor, format!("{prefix}{}", symbol(unit)))
}

/// An SI unit as it is printed.
pub fn symbol(unit: &str) -> String {
    unit.replace('.', "·").replace("s2", "s²")
}

/// Label of an axis: words and unit.
pub fn with_unit(words: &str, unit: &str) -> String {
    if unit.is_empty() || unit == "1" { words.to_owned() } else { format!("{words}, {unit}") }
}

/// Axis of values up to `largest` in size, SI, in their unit of display.
pub fn axis(words: &str, unit: &str, largest: f64) -> Axis {
    let (factor, unit) = shown_unit(unit, largest);
    Axis::new(with_unit(words, &unit)).times(factor)
}

/// The parts of a name between underscores, and at each change from a small to a capital letter,
/// from a letter to a digit, and before the last of several capitals.
fn parts(name: &str) -> Vec<String> {
    let letters: Vec<char> = name.chars().collect();
    let mut parts = vec![String::new()];
    for (i, &letter) in letters.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| letters[i]);
        let next = letters.get(i + 1);
        let begins = before.is_some_and(|before| {
            letter.is_uppercase() && before.is_lowercase()
                || letter.is_uppercase() && before.is_uppercase() && next.is_some_and(|n| n.is_lowercase())
                || letter.is_numeric() && before.is_lowercase()
        });
        if begins || letter == '_' {
            parts.push(String::new());
        }
        if letter != '_' {
            parts.last_mut().into_iter().for_each(|part| part.push(letter));
        }
    }
    parts.retain(|part| !part.is_empty());
    parts
}

/// A name of an element in words: `snubber_left` is `snubber left`, `blade.tip.x` is `tip x of
/// blade`.
pub fn spoken(name: &str) -> String {
    let words = |name: &str| {
        let is_word = |part: &str| part.chars().nth(1).is_some_and(char::is_lowercase);
        let small = |part: String| if is_word(&part) { part.to_lowercase() } else { part };
        name.split('.').flat_map(parts).map(small).collect::<Vec<_>>().join(" ")
    };
    match name.split_once('.') {
        Some((of, node)) => format!("{} of {}", words(node), words(of)),
        None => words(name),
    }
}

/// A machine's name as a title: `GearMesh` is `Gear mesh`.
///
/// ```
/// assert_eq!(vibro::wording::title("GearMesh"), "Gear mesh");
/// assert_eq!(vibro::wording::title("MSLCoupledClutches"), "MSL coupled clutches");
/// ```
pub fn title(name: &str) -> String {
    with_capital(&spoken(name))
}

/// Words that begin with a capital.
pub fn with_capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Words for the two tangents of a contact.
pub(crate) const ORDINALS: [&str; 2] = ["first", "second"];

/// The noun for a quantity.
fn noun(what: What, element: Option<Element>, dimension: Dimension) -> &'static str {
    let turns = dimension == Dimension::Rotation;
    let of = |along: &'static str, around: &'static str| if turns { around } else { along };
    let slides = matches!(element, Some(Element::Friction(_) | Element::Contact(_)));
    match (what, element) {
        (What::S, _) => of("displacement", "angle"),
        (What::V, _) => of("velocity", "angular velocity"),
        (What::A, _) => of("acceleration", "angular acceleration"),
        (What::E, Some(Element::Contact(_))) => "normal elongation",
        (What::E, _) if slides => of("relative displacement", "relative angle"),
        (What::E, _) => of("elongation", "twist"),
        (What::Rate, Some(Element::Contact(_))) => "normal velocity",
        (What::Rate, _) => of("relative velocity", "relative angular velocity"),
        (What::F, Some(Element::Stop(_))) => of("contact force", "contact torque"),
        (What::F, Some(Element::Contact(_))) => "normal force",
        (What::F, Some(Element::Friction(_))) => of("friction force", "friction torque"),
        (What::F, Some(Element::Spring(_))) => of("spring force", "spring torque"),
        (What::F, _) => of("force", "torque"),
        (What::TangentE(None), _) => "tangential displacement",
        (What::TangentE(Some(0)), _) => "first tangential displacement",
        (What::TangentE(Some(_)), _) => "second tangential displacement",
        (What::TangentF(None), _) => "tangential force",
        (What::TangentF(Some(0)), _) => "first tangential force",
        (What::TangentF(Some(_)), _) => "second tangential force",
        (What::Slider(Some(0)), _) => "first slider displacement",
        (What::Slider(Some(_)), _) => "second slider displacement",
        (What::Slider(None), _) => of("inner displacement", "inner angle"),
        _ => "",
    }
}

/// Noun of a quantity, and its body or element in words.
fn noun_and_owner(d: &Description, name: &QuantityName) -> (&'static str, String) {
    let Ok(found) = name.find(d) else { return ("", name.to_string()) };
    let own = found.quantity;
    let (element, dimension) = match own.owner {
        Owner::Body(i) => (None, d.bodies[i].dimension),
        Owner::Element(i) => {
            let element = d.elements().nth(i);
            (element, element.map_or(Dimension::Translation, |element| element.dimension(d)))
        }
    };
    (noun(own.what, element, dimension), spoken(&name.of))
}

/// A quantity in words: `box.s` is `displacement of box`.
pub fn quantity(d: &Description, name: &QuantityName) -> String {
    match noun_and_owner(d, name) {
        ("", owner) => owner,
        (noun, owner) => format!("{noun} of {owner}"),
    }
}

/// A measure in words: `amplitude.box.s` is `displacement amplitude of box`.
pub fn measure(d: &Description, measure: &Measure) -> String {
    let with = |before: &str, name: &QuantityName, after: &str| {
        let (noun, owner) = noun_and_owner(d, name);
        let noun = if noun.is_empty() { "value" } else { noun };
        format!("{before}{noun}{after} of {owner}")
    };
    match measure {
        Measure::Amplitude(name) => with("", name, " amplitude"),
        Measure::Rms(name) => with("rms ", name, ""),
        Measure::PeakToPeak(name) => with("peak-to-peak ", name, ""),
        Measure::Maximum(name) => with("largest ", name, ""),
        Measure::Impacts(Some(stop)) => format!("impacts of {} per period", spoken(stop)),
        Measure::Impacts(None) => "impacts per period".into(),
        Measure::ImpactRate(Some(stop)) => format!("impacts of {} per second", spoken(stop)),
        Measure::ImpactRate(None) => "impacts per second".into(),
        Measure::ImpactSpeed(stop) => format!("largest closing speed of {}", spoken(stop)),
        Measure::ImpactImpulse(stop) => format!("largest impulse of {}", spoken(stop)),
        Measure::Power(name) => format!("mean power of {}", spoken(name)),
        Measure::PowerLost => "mean power lost".into(),
        Measure::Class | Measure::Exponent => measure.description(),
    }
}

/// Kinds of elements that are part of a parameter's words, since names such as `upper` need them.
const KINDS: [&str; 4] = ["stop", "spring", "damper", "friction"];

/// A parameter in words: `stop.steel.gap` is `gap of steel stop`.
pub fn parameter(name: &str) -> String {
    let mut all = name.split('.');
    let (kind, of) = (all.next().unwrap_or_default(), all.next());
    let Some(of) = of else { return spoken(kind) };
    let keys: Vec<String> = all.map(spoken).collect();
    let owner = spoken(of);
    let owner = match KINDS.contains(&kind) && !owner.ends_with(kind) {
        true => format!("{owner} {kind}"),
        false => owner,
    };
    if keys.is_empty() { owner } else { format!("{} of {owner}", keys.join(" ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_names_in_words() {
        let titles = ["SDND106", "Servo", "PullIn", "PlayByOneNumber", "gear_mesh"].map(title);
        assert_eq!(titles, ["SDND106", "Servo", "Pull in", "Play by one number", "Gear mesh"]);
        let names = ["snubber_left", "elastoGap2", "beads10", "blade1.tip.x", "x"].map(spoken);
        assert_eq!(names, ["snubber left", "elasto gap 2", "beads 10", "tip x of blade 1", "x"]);
        let parameters = ["stop.steel.gap", "body.disc.motion.rate", "spring.valve_spring.preload", "gap"];
        let told = ["gap of steel stop", "motion rate of disc", "preload of valve spring", "gap"];
        assert_eq!(parameters.map(parameter), told);
    }

    #[test]
    fn golden_quantities_and_measures_in_words() {
        let text = include_str!("../../../examples/assembly/damper_with_buffer.toml");
        let d = vibro_machine::file::parse(text, "machine", &vibro_machine::file::no_records).unwrap();
        for (name, told) in [
            ("box.s", "displacement of box"),
            ("block.v", "velocity of block"),
            ("steel.f", "contact force of steel"),
            ("guide.rate", "relative velocity of guide"),
            ("guide.f", "friction force of guide"),
            ("mount.f", "spring force of mount"),
            ("shaker.f", "force of shaker"),
        ] {
            assert_eq!(quantity(&d, &name.parse().unwrap()), told, "{name}");
        }
        for (name, told) in [
            ("amplitude.box.s", "displacement amplitude of box"),
            ("maximum.buffer.f", "largest contact force of buffer"),
            ("impact.speed.steel", "largest closing speed of steel"),
        ] {
            assert_eq!(measure(&d, &name.parse().unwrap()), told, "{name}");
        }
    }

    #[test]
    fn golden_prefixes_of_units() {
        for (unit, largest, factor, symbol) in [
            ("m", 0.05, 1e3, "mm"),
            ("m", 5e-5, 1e6, "µm"),
            ("m", 3.0, 1.0, "m"),
            ("m", 0.0, 1.0, "m"),
            ("N", 2.5e4, 1e-3, "kN"),
            ("N.m", 0.02, 1e3, "mN·m"),
            ("m/s2", 1e-3, 1.0, "m/s²"),
            ("s", 0.006, 1e3, "ms"),
        ] {
            assert_eq!(shown_unit(unit, largest), (factor, symbol.to_owned()), "{unit} {largest}");
        }
        assert_eq!([with_unit("gap", "mm"), with_unit("ratio", "1")], ["gap, mm", "ratio"]);
    }
}
