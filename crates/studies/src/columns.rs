//! A described machine's motion as columns: the quantities of its bodies and elements. The command
//! line, FMUs and Python use these names.

use vibro_machine::description::Description;
use vibro_machine::motion::EventKind;
use vibro_machine::{Assembly, Motion};

/// Names of the columns, without the time column.
pub fn columns(d: &Description) -> Vec<String> {
    d.named_quantities().into_iter().map(|quantity| quantity.name).collect()
}

/// Present values of the columns.
///
/// ```
/// use vibro_machine::{Assembly, Motion, file};
/// use vibro_studies::{columns, values};
///
/// let text = r#"
///     name = "Oscillator"
///     body.a = { mass = 2.0, start = { s = 0.5, v = 3.0 } }
///     spring.k = { between = ["ground", "a"], stiffness = 4.0 }
/// "#;
/// let machine = file::parse(text, "oscillator.toml", &file::no_records)?;
/// assert_eq!(columns(&machine), ["a.s", "a.v", "a.a", "k.e", "k.rate", "k.f"]);
/// let motion = Motion::new(Assembly::new(machine)?.into())?;
/// assert_eq!(values(&motion), [0.5, 3.0, -1.0, 0.5, 3.0, 2.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn values(m: &Motion) -> Vec<f64> {
    // Adding 0.0 removes the sign of zero.
    m.assembly().description.quantities().map(|quantity| m.value(quantity) + 0.0).collect()
}

/// Event with the names of its elements.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedEvent {
    /// `impact`, `close`, `open`, `press`, `free`, `cap`, `corner`, `stick`, `slip`, `level`,
    /// `knot`, `limit`, or `sample`, which tables leave out.
    pub kind: &'static str,
    /// `stop.NAME`, `spring.NAME`, `friction.NAME`, `block.NAME`, or empty for a knot.
    pub element: String,
    /// Closing speed, rate, force of friction or of a slider, value of a block's output, or
    /// whether a friction element or a cap acts (1 or 0).
    pub value: Option<f64>,
    /// Number of stops with an impact.
    pub stops: Option<usize>,
}

/// Converts an event to the names of its elements.
///
/// ```
/// use vibro_machine::{Assembly, Motion, file};
/// use vibro_studies::named;
///
/// # let text = r#"
/// #     name = "Wall"
/// #     body.a = { mass = 1.0, start = { v = 2.0 } }
/// #     stop.wall = { between = ["ground", "a"], gap = 1.0, restitution = 0.25 }
/// # "#;
/// let machine = file::parse(text, "wall.toml", &file::no_records)?;
/// let mut motion = Motion::new(Assembly::new(machine)?.into())?;
/// let assembly = motion.assembly().clone();
/// let mut events = Vec::new();
/// motion.advance_observed(1.0, &mut |event| events.push(named(&assembly, &event.kind)))?;
/// assert_eq!((events[0].kind, events[0].element.as_str()), ("impact", "stop.wall"));
/// assert_eq!(events[0].value, Some(2.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn named(assembly: &Assembly, kind: &EventKind) -> NamedEvent {
    let stop = |i: usize| assembly.name_of_stop(i);
    let friction = |i: usize| assembly.name_of_friction(i);
    let event = |kind, element, value, stops| NamedEvent { kind, element, value, stops };
    match *kind {
        EventKind::Impact { stop: i, speed, stops, .. } => event("impact", stop(i), Some(speed), Some(stops)),
        EventKind::Close { stop: i } => event("close", stop(i), None, None),
        EventKind::Open { stop: i } => event("open", stop(i), None, None),
        EventKind::Press { stop: i, speed } => event("press", stop(i), Some(speed), None),
        EventKind::Free { stop: i, rate } => event("free", stop(i), Some(rate), None),
        EventKind::Cap { stop: i, acts } => event("cap", stop(i), Some(f64::from(u8::from(acts))), None),
        EventKind::Corner { corner, rate } => event("corner", stop(corner), Some(rate), None),
        EventKind::Stick { friction: i } => event("stick", friction(i), None, None),
        EventKind::Slip { friction: i, force, .. } => event("slip", friction(i), Some(force), None),
        EventKind::Level { friction: i, acts } => {
            event("level", friction(i), Some(f64::from(u8::from(acts))), None)
        }
        EventKind::Yield { slider: i, force, .. } => {
            event("slip", assembly.name_of_branch(i), Some(force), None)
        }
        EventKind::Hold { slider: i, force } => event("stick", assembly.name_of_branch(i), Some(force), None),
        EventKind::Knot => event("knot", String::new(), None, None),
        EventKind::Limit { block, output, value, .. } => {
            let name = format!("block.{}", assembly.description.name_of_output((block, output)));
            event("limit", name, Some(value), None)
        }
        EventKind::Sample { action } => {
            event("sample", format!("block.{}", assembly.description.blocks[action.block].name), None, None)
        }
    }
}
