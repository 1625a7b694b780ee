//! Columns of a described machine's motion: s, v, a of each body; e, rate, f of each spring, stop
//! and friction; f of each load. The command line, the FMUs and Python use these names.

use vibro_assembly::Motion;
use vibro_assembly::description::Description;
use vibro_assembly::motion::EventKind;

/// Names of the columns, without the time.
pub fn columns(d: &Description) -> Vec<String> {
    super::NamedQuantity::all(d).into_iter().map(|quantity| quantity.to_string()).collect()
}

/// Present values of the columns.
pub fn values(m: &Motion) -> Vec<f64> {
    let d = &m.assembly().description;
    let bodies = (0..d.bodies.len()).flat_map(|i| m.body(i));
    let springs = (0..d.springs.len()).flat_map(|i| m.spring(i));
    let stops = (0..d.stops.len()).flat_map(|i| m.stop(i));
    let frictions = (0..d.frictions.len()).flat_map(|i| m.friction(i));
    let loads = (0..d.loads.len()).map(|i| m.load(i));
    // Adding zero turns -0 into 0.
    bodies.chain(springs).chain(stops).chain(frictions).chain(loads).map(|x| x + 0.0).collect()
}

/// Event by the names of elements.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedEvent {
    /// `impact`, `close`, `open`, `press`, `free`, `cap`, `stick`, `slip`, `level`, `knot`.
    pub kind: &'static str,
    /// `stop.NAME`, `friction.NAME`, or empty.
    pub element: String,
    /// Closing speed, rate, force while slipping, or whether a friction or a cap acts (1 or 0).
    pub value: Option<f64>,
    /// Number of stops that took part in an impact.
    pub stops: Option<usize>,
}

/// The event by the names of elements.
pub fn named(d: &Description, kind: &EventKind) -> NamedEvent {
    let stop = |i: usize| format!("stop.{}", d.stops[i].name);
    let friction = |i: usize| format!("friction.{}", d.frictions[i].name);
    let event = |kind, element, value, stops| NamedEvent { kind, element, value, stops };
    match *kind {
        EventKind::Impact { stop: i, speed, stops, .. } => event("impact", stop(i), Some(speed), Some(stops)),
        EventKind::Close { stop: i } => event("close", stop(i), None, None),
        EventKind::Open { stop: i } => event("open", stop(i), None, None),
        EventKind::Press { stop: i, speed } => event("press", stop(i), Some(speed), None),
        EventKind::Free { stop: i } => event("free", stop(i), None, None),
        EventKind::Cap { stop: i, acts } => event("cap", stop(i), Some(f64::from(u8::from(acts))), None),
        EventKind::Stick { friction: i } => event("stick", friction(i), None, None),
        EventKind::Slip { friction: i, force, .. } => event("slip", friction(i), Some(force), None),
        EventKind::Level { friction: i, acts } => {
            event("level", friction(i), Some(f64::from(u8::from(acts))), None)
        }
        EventKind::Knot => event("knot", String::new(), None, None),
    }
}
