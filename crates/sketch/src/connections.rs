//! Elements as connections between bodies, with their symbols.

use vibro_machine::description::{Arms, SeriesLaw, Spring, StopLaw};
use vibro_machine::{Description, Element};

/// The symbol of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Symbol {
    /// A zigzag, a dashpot, or both in parallel; `curved`: with an arrow across, as its law is no
    /// straight line.
    Spring { zigzag: bool, dashpot: bool, curved: bool },
    /// A zigzag in series with a dashpot or a slider; `dashpot`: one in parallel to both.
    Series { slides: bool, dashpot: bool },
    /// A nose before a plate, or two hooks; a zigzag behind the plate or a hook if it is
    /// compliant, with an arrow across if it is `curved`.
    Stop { compliant: bool, curved: bool },
    /// Two bars in sliding contact.
    Friction,
    /// A pawl on a rack.
    Freewheel,
    /// A rigid bar.
    Link,
}

/// The ends of an element. Between two ends, the elongation e is the second minus the first, each
/// with its arm; `None` is ground. Otherwise e is a sum over three or more bodies.
#[derive(Clone, Debug)]
pub(crate) enum Ends {
    Two([Option<usize>; 2]),
    Many(Vec<usize>),
}

/// An element that acts between bodies.
#[derive(Clone, Debug)]
pub(crate) struct Connection {
    pub name: String,
    pub symbol: Symbol,
    pub ends: Ends,
    /// Texts of the lever arms, by body.
    pub arms: Vec<(usize, String)>,
}

impl Connection {
    fn new(name: &str, symbol: Symbol, of: &Arms) -> Self {
        let ends = match *of.terms {
            [(body, arm)] if arm > 0.0 => Ends::Two([None, Some(body)]),
            [(body, _)] => Ends::Two([Some(body), None]),
            [(one, arm), (two, other)] if arm <= other => Ends::Two([Some(one), Some(two)]),
            [(one, _), (two, _)] => Ends::Two([Some(two), Some(one)]),
            _ => Ends::Many(of.terms.iter().map(|term| term.0).collect()),
        };
        let arms = of.terms.iter().filter(|_| of.levers).map(|&(body, arm)| (body, number(arm))).collect();
        Self { name: name.into(), symbol, ends, arms }
    }
}

/// The text of a number such as a lever arm, with at most three decimals.
pub(crate) fn number(x: f64) -> String {
    let text = format!("{x:.3}");
    let short = text.trim_end_matches('0').trim_end_matches('.').replace('-', "\u{2212}");
    if matches!(short.as_str(), "0" | "\u{2212}0") || x.abs() >= 1e5 { format!("{x:.2e}") } else { short }
}

/// Connections of all elements except loads.
pub(crate) fn connections(machine: &Description) -> Vec<Connection> {
    let symbol = |element: Element| match element {
        Element::Spring(Spring { damping, series: Some(series), .. }) => {
            let slides = matches!(series.law, SeriesLaw::Slider { .. });
            Symbol::Series { slides, dashpot: *damping > 0.0 }
        }
        Element::Spring(spring) => {
            let dashpot = spring.damping > 0.0;
            let curved = spring.is_curved();
            let acts =
                curved || spring.stiffness > 0.0 || !spring.points.is_empty() || spring.stepped.is_some();
            Symbol::Spring { zigzag: acts || !dashpot, dashpot, curved }
        }
        Element::Damper(_) => Symbol::Spring { zigzag: false, dashpot: true, curved: element.is_curved() },
        Element::Stop(stop) => {
            let compliant = matches!(stop.law, StopLaw::Compliant { .. });
            Symbol::Stop { compliant, curved: element.is_curved() }
        }
        Element::Friction(_) => Symbol::Friction,
        Element::Contact(_) => Symbol::Stop { compliant: true, curved: false },
        Element::Freewheel(_) => Symbol::Freewheel,
        Element::Modal(_) | Element::Matrix(_) | Element::Link(_) | Element::Load(_) => Symbol::Link,
        Element::Source(_) | Element::Block(_) => Symbol::Link,
    };
    // A contact with friction has a second connection along its tangent, without a name.
    let along = |i: usize| if i == 0 { None } else { Some(Symbol::Series { slides: true, dashpot: false }) };
    let connection = |(i, (e, arms)): (usize, (Element, &Arms))| {
        Connection::new(if i == 0 { e.name() } else { "" }, along(i).unwrap_or_else(|| symbol(e)), arms)
    };
    let all = machine.elements().map(|e| e.all_arms().map(move |arms| (e, arms)).enumerate());
    all.flatten().map(connection).collect()
}
