//! Reading of springs, dampers, stops, frictions, freewheels, links and loads.

use super::blocks;
use super::bodies::Names;
use super::curve;
use super::follows;
use super::formula;
use super::numbers::number;
use super::points;
use super::powers;
use super::reading::{Entry, FileTable, Reading};
use super::series;
use super::signals::{self, Values};
use super::stepped;
use super::stribeck;
use crate::description::{
    Arms, ContactLaw, Damper, DampingLimit, Description, Dimension, Freewheel, Friction, Link, Load, Signal,
    Spring, Stop, StopLaw,
};
use crate::kinds;
use crate::parameters::has_unit;
use vibro_numerics::quantities::symbols;
use vibro_numerics::sorting::sort_by_key;

/// Message for a name that no body has.
pub(super) const NO_BODY: &str = "no body has this name";
/// Message for the ground where a body is expected.
const GROUND: &str = "the ground does not move";

/// Reads the elements. An element with problems is left out: the file is refused anyway.
pub(super) fn read(reading: &mut Reading, root: &FileTable, names: &Names, machine: &mut Description) {
    for (name, table) in reading.section(root, "spring") {
        machine.springs.extend(spring(reading, name, &table, names));
    }
    for (name, table) in reading.section(root, "damper") {
        machine.dampers.extend(damper(reading, name, &table, names));
    }
    for (name, table) in reading.section(root, "stop") {
        machine.stops.extend(stop(reading, name, &table, names));
    }
    for (name, table) in reading.section(root, "friction") {
        machine.frictions.extend(friction(reading, name, &table, names, &machine.stops));
    }
    for (name, table) in reading.section(root, "freewheel") {
        reading.known(&table, &["between", "arms"]);
        machine.freewheels.extend(arms(reading, &table, names).map(|arms| Freewheel { name, arms }));
    }
    for (name, table) in reading.section(root, "link") {
        reading.known(&table, &["between", "arms"]);
        machine.links.extend(arms(reading, &table, names).map(|arms| Link { name, arms }));
    }
    for (name, table) in reading.section(root, "load") {
        machine.loads.extend(load(reading, name, &table, names));
    }
}

/// Reads the arms of an element, and with `read` its other keys in the arms' dimension. If the
/// arms are refused, the other keys are read in the dimension with fewer problems, so that all
/// problems are reported at once.
fn with_arms<T>(
    reading: &mut Reading,
    table: &FileTable,
    names: &Names,
    read: impl Fn(&mut Reading, Dimension) -> Option<T>,
) -> Option<(Arms, T)> {
    if let Some(arms) = arms(reading, table, names) {
        let rest = read(reading, arms.dimension)?;
        return Some((arms, rest));
    }
    let before = reading.problems.len();
    let mut problems_in = |dimension| {
        read(reading, dimension);
        reading.problems.split_off(before)
    };
    let (line, turn) = (problems_in(Dimension::Translation), problems_in(Dimension::Rotation));
    reading.problems.extend(if turn.len() < line.len() { turn } else { line });
    None
}

fn spring(reading: &mut Reading, name: String, table: &FileTable, names: &Names) -> Option<Spring> {
    let own = ["between", "arms", "stiffness", "damping", "preload", "points"];
    let curve = kinds::CURVE.map(|own| own.0);
    let known = [&own[..], &curve, &powers::KEYS, &["force"], &formula::ACROSS, &series::KEYS].concat();
    reading.known(table, &known);
    // Outside of the closure, which may read twice: a formula has no dimension.
    let force = formula::of_spring(reading, table);
    let (arms, ((stiffness, stepped), damping, preload, points, series, curve, power, across)) =
        with_arms(reading, table, names, |reading, dimension| {
            let across = formula::across(reading, table, dimension)?;
            if across.is_some() {
                let stiffness =
                    reading.required_number(table, "stiffness", kinds::ACROSS_STIFFNESS, dimension);
                let damping = reading.number_or(table, "damping", kinds::DAMPING, dimension, 0.0);
                let (stiffness, curve) = ((stiffness?, None), Default::default());
                return Some((stiffness, damping?, 0.0, Vec::new(), None, curve, None, across));
            }
            let points = points::read(reading, table, dimension);
            let series = series::read(reading, table, dimension);
            let damping = reading.number_or(table, "damping", kinds::DAMPING, dimension, 0.0);
            let curve = curve::read(reading, table, dimension);
            let power = powers::read(reading, table, dimension, (false, &curve::EXCLUDED));
            if table.has("points") {
                return Some(((0.0, None), damping?, 0.0, points?, series?, curve?, power?, None));
            }
            if curve::is_given(table) || table.has("force") {
                let stiffness = curve::stiffness(reading, table, dimension);
                let preload = reading.number_or(table, "preload", kinds::PRELOAD, dimension, 0.0);
                return Some((
                    (stiffness?, None),
                    damping?,
                    preload?,
                    points?,
                    series?,
                    curve?,
                    power?,
                    None,
                ));
            }
            let is_in_series = series::is_given(table);
            let kind = if is_in_series { kinds::SERIES_STIFFNESS } else { kinds::SPRING_STIFFNESS };
            let stiffness = stepped::read(reading, table, kind, dimension);
            let preload = match is_in_series {
                true => Some(0.0),
                false => reading.number_or(table, "preload", kinds::PRELOAD, dimension, 0.0),
            };
            Some((stiffness?, damping?, preload?, points?, series?, curve?, power?, None))
        })?;
    let force = force?;
    Some(Spring {
        name,
        arms,
        stiffness,
        stepped,
        damping,
        preload,
        curve,
        power,
        force,
        across,
        points,
        series,
    })
}

fn damper(reading: &mut Reading, name: String, table: &FileTable, names: &Names) -> Option<Damper> {
    let own = ["between", "arms", "damping", "quadratic", "cubic", "force"];
    reading.known(table, &[&own[..], &powers::KEYS].concat());
    let force = formula::of_damper(reading, table);
    let (arms, (damping, [quadratic, cubic], power)) =
        with_arms(reading, table, names, |reading, dimension| {
            let power = powers::read(reading, table, dimension, (true, &[]));
            let keys = ["quadratic", "cubic", "force"];
            if !keys.iter().any(|key| table.has(key)) && !powers::is_given(table) {
                let allowed = kinds::DASHPOT.allowed(dimension);
                let allowed =
                    format!("{allowed}; a curve, such as `quadratic` or `cubic`, or `force` may replace it");
                let damping = reading.required(table, "damping", &allowed);
                let damping = damping.and_then(|own| reading.number(&own, kinds::DASHPOT, dimension));
                return Some((damping?, [None; 2], power?));
            }
            let damping = reading.number_or(table, "damping", kinds::CURVED_DAMPING, dimension, 0.0);
            let mut coefficient = |key: &str, kind| match reading.optional(table, key) {
                Some(entry) => reading.number(&entry, kind, dimension).map(Some),
                None => Some(None),
            };
            let quadratic = coefficient("quadratic", kinds::QUADRATIC_DAMPING);
            let cubic = coefficient("cubic", kinds::CUBIC_DAMPING);
            Some((damping?, [quadratic?, cubic?], power?))
        })?;
    Some(Damper { name, arms, damping, quadratic, cubic, power, force: force? })
}

fn stop(reading: &mut Reading, name: String, table: &FileTable, names: &Names) -> Option<Stop> {
    let own = ["between", "arms", "gap", "restitution", "stiffness", "damping", "law"];
    reading.known(table, &[&own[..], &powers::CONTACT_KEYS].concat());
    let (arms, (gap, (law, stepped, contact))) = with_arms(reading, table, names, |reading, dimension| {
        let gap = reading.required_number(table, "gap", kinds::GAP, dimension);
        let law = law(reading, table, dimension);
        Some((gap?, law?))
    })?;
    Some(Stop { name, arms, gap, law, stepped, contact })
}

/// A stop's law, its stiffness if that steps in time, and its exponent and dissipation.
type Law = (StopLaw, Option<Signal>, Option<ContactLaw>);

fn law(reading: &mut Reading, table: &FileTable, dimension: Dimension) -> Option<Law> {
    let others = ["damping", "law", "exponent", "dissipation"];
    if !table.has("restitution") && !table.has("stiffness") {
        if reading.has_residual() && !others.iter().any(|key| table.has(key)) {
            let (stiffness, damping, limit) = (f64::INFINITY, 0.0, DampingLimit::NoPull);
            return Some((StopLaw::Compliant { stiffness, damping, limit }, None, None));
        }
        let text = "requires `restitution` (rigid stop) or `stiffness` (compliant stop)";
        reading.refuse_table(table, text);
        return None;
    }
    if let Some(restitution) = reading.optional(table, "restitution") {
        let mut alone = true;
        for key in ["stiffness", "damping", "law", "exponent", "dissipation"] {
            if let Some(entry) = reading.optional(table, key) {
                alone = false;
                let text = "cannot be combined with `restitution`: use `restitution` for a rigid stop, \
                            or `stiffness` for a compliant one";
                reading.refuse(&entry, text);
            }
        }
        let restitution = reading.number(&restitution, kinds::RESTITUTION, dimension)?;
        return alone.then_some((StopLaw::Rigid { restitution }, None, None));
    }
    powers::compliant(reading, table, dimension)
}

fn friction(
    reading: &mut Reading,
    name: String,
    table: &FileTable,
    names: &Names,
    stops: &[Stop],
) -> Option<Friction> {
    reading.known(
        table,
        &[
            "between",
            "arms",
            "force",
            "static",
            "follows",
            "coefficient",
            "static_coefficient",
            "stribeck",
            "stribeck_exponent",
            "viscous",
        ],
    );
    if table.has("follows") || table.has("coefficient") || table.has("static_coefficient") {
        let (arms, follows) =
            with_arms(reading, table, names, |reading, _| follows::read(reading, table, stops))?;
        let (force, follows) = (Signal::default(), Some(follows));
        let (static_force, stribeck, viscous) = (None, None, None);
        return stribeck::none(reading, table).then_some(Friction {
            name,
            arms,
            force,
            static_force,
            follows,
            stribeck,
            viscous,
        });
    }
    let (arms, (force, static_force, curve)) = with_arms(reading, table, names, |reading, dimension| {
        let curve = stribeck::read(reading, table, dimension);
        let values = Values { kind: kinds::FORCE, alone: kinds::LEVEL, dimension };
        let allowed = format!("{}, or a signal", kinds::LEVEL.allowed(dimension));
        let force = reading.required(table, "force", &allowed);
        let force = force.and_then(|entry| signals::value(reading, &entry, values));
        let static_force = match reading.optional(table, "static") {
            None => Some(None),
            Some(entry) => signals::value(reading, &entry, values).map(Some),
        };
        Some((force?, static_force?, curve?))
    })?;
    let (stribeck, viscous) = curve;
    Some(Friction { name, arms, force, static_force, follows: None, stribeck, viscous })
}

fn load(reading: &mut Reading, name: String, table: &FileTable, names: &Names) -> Option<Load> {
    reading.known(table, &[&["on", "from", "factor"], &signals::KEYS[..]].concat());
    let on = reading.required(table, "on", "expected the name of a body")?;
    let (body, dimension) = body(reading, &on, names)?;
    if table.has("from") {
        return Some(Load { name, body, force: Signal::default() });
    }
    if let Some(factor) = reading.optional(table, "factor") {
        reading.refuse(&factor, "requires `from = \"BLOCK.OUTPUT\"`");
        return None;
    }
    let values = Values { kind: kinds::FORCE, alone: kinds::FORCE, dimension: dimension? };
    let force: Signal = signals::flat(reading, table, values, &["from"])?;
    Some(Load { name, body, force })
}

/// Reads the outputs that loads follow, after the blocks have been read.
pub(super) fn follow(reading: &mut Reading, root: &FileTable, machine: &mut Description) {
    for (name, table) in reading.section(root, "load") {
        let Some(from) = reading.optional(&table, "from") else { continue };
        for key in signals::KEYS {
            if let Some(entry) = reading.optional(&table, key) {
                let text = "cannot be combined with `from`: use `from` for an output of a block, \
                            or the keys of a signal for a given force";
                reading.refuse(&entry, text);
            }
        }
        let Some(load) = machine.loads.iter().position(|load| load.name == name) else { continue };
        let dimension =
            machine.bodies.get(machine.loads[load].body).map_or(Dimension::Translation, |b| b.dimension);
        let factor = reading.number_or(&table, "factor", kinds::FACTOR, dimension, 1.0);
        let feed = factor.and_then(|factor| blocks::follow(reading, &from, (load, factor), machine));
        machine.feeds.extend(feed);
    }
    // Feeds of refused loads are missing.
    sort_by_key(&mut machine.feeds, |feed| feed.load);
}

/// The body named by an entry.
fn body(reading: &mut Reading, entry: &Entry, names: &Names) -> Option<(usize, Option<Dimension>)> {
    let name = reading.string(entry, "expected the name of a body")?;
    let found = names.find(&name);
    if found.is_none() {
        let said = if name == "ground" { GROUND } else { NO_BODY };
        reading.refuse_body(entry, &name, said, names.all());
    }
    found
}

/// Reads the elongation of an element, given by `between` or `arms`. Returns `None` without a new
/// problem if a body of it was refused.
fn arms(reading: &mut Reading, table: &FileTable, names: &Names) -> Option<Arms> {
    match (reading.optional(table, "between"), reading.optional(table, "arms")) {
        (Some(ends), None) => between(reading, &ends, names),
        (None, Some(arms)) => levers(reading, &arms, names),
        (None, None) => {
            reading.refuse_table(table, "requires `between = [A, B]` or `arms = { A = 1.0, B = -1.0 }`");
            None
        }
        (Some(_), Some(arms)) => {
            let text = "cannot be combined with `between`: use `between` for two ends, \
                        or `arms` for bodies with lever arms";
            reading.refuse(&arms, text);
            None
        }
    }
}

/// End of an element: a body with its dimension, or `None` for ground.
pub(super) type End = Option<(usize, Option<Dimension>)>;

pub(super) fn between(reading: &mut Reading, entry: &Entry, names: &Names) -> Option<Arms> {
    let items = reading.items(entry);
    let Some([a, b]) = items.as_deref() else {
        reading.refuse(entry, "expected two names, such as [\"ground\", \"box\"]");
        return None;
    };
    let (a, b): (Option<End>, Option<End>) = (end(reading, a, names), end(reading, b, names));
    let same = "both ends are the same; expected two bodies, or ground and a body";
    let mixed = "cannot connect a translating and a rotating body directly; use `arms` with a lever such as \
                 \"50 mm\"";
    joined(reading, [a?, b?], [(entry, same), (entry, mixed)])
}

/// Returns the elongation between two ends. An entry with its message is refused if both ends are
/// the same, and the second one if one end translates and the other rotates.
pub(super) fn joined(
    reading: &mut Reading,
    [a, b]: [End; 2],
    [same, mixed]: [(&Entry, &str); 2],
) -> Option<Arms> {
    if a.map(|a| a.0) == b.map(|b| b.0) {
        reading.refuse(same.0, same.1);
        return None;
    }
    let known = |end: End| end.map(|(_, dimension)| dimension);
    let dimension = match (known(a), known(b)) {
        // The dimension of a refused body is unknown.
        (Some(None), _) | (_, Some(None)) | (None, None) => return None,
        (Some(Some(a)), Some(Some(b))) if a != b => {
            reading.refuse(mixed.0, mixed.1);
            return None;
        }
        (Some(Some(dimension)), _) | (_, Some(Some(dimension))) => dimension,
    };
    Some(Arms::between(a.map(|a| a.0), b.map(|b| b.0), dimension))
}

fn end(reading: &mut Reading, entry: &Entry, names: &Names) -> Option<End> {
    if entry.value.as_str() == Some("ground") {
        return Some(None);
    }
    let name = reading.string(entry, "expected \"ground\" or the name of a body")?;
    let found = names.find(&name);
    if found.is_none() {
        reading.refuse_body(entry, &name, NO_BODY, names.all().chain(["ground"]));
    }
    found.map(Some)
}

/// Returns all entries of a table of bodies; `tube = { tip = 1.0 }` means `"tube.tip" = 1.0`, and
/// `tube = { tip = { x = 1.0 } }` means `"tube.tip.x" = 1.0`.
fn of_nodes<'t>(reading: &mut Reading, table: &FileTable<'t>, names: &Names) -> Vec<Entry<'t>> {
    let mut all = Vec::new();
    for entry in reading.all(table) {
        let Some(entries) = entry.value.as_table().filter(|_| names.find(&entry.key).is_none()) else {
            all.push(entry);
            continue;
        };
        let inner = FileTable { name: entry.name.clone(), line: entry.line, entries };
        for node in reading.all(&inner).into_iter().map(|node| node.below(&entry.key)) {
            let Some(entries) = node.value.as_table().filter(|_| names.find(&node.key).is_none()) else {
                all.push(node);
                continue;
            };
            let inner = FileTable { name: node.name.clone(), line: node.line, entries };
            all.extend(reading.all(&inner).into_iter().map(|own| own.below(&node.key)));
        }
    }
    all
}

/// Reads lever arms. The unit of an arm determines the dimension of its term, and all terms must
/// have the same dimension.
pub(super) fn levers(reading: &mut Reading, entry: &Entry, names: &Names) -> Option<Arms> {
    let table =
        reading.table(entry, "expected a table of bodies and arms, such as { wheel = 1.0, drum = -3.0 }")?;
    let mut terms = Vec::new();
    let mut first: Option<(Dimension, String)> = None;
    let mut sound = true;
    for entry in of_nodes(reading, &table, names) {
        let Some((body, dimension)) = names.find(&entry.key) else {
            reading.refuse_body(&entry, &entry.key, NO_BODY, names.all());
            sound = false;
            continue;
        };
        let Some((arm, measured)) = dimension.and_then(|dimension| lever(reading, &entry, dimension)) else {
            sound = false;
            continue;
        };
        let (common, other) = first.get_or_insert_with(|| (measured, entry.key.clone()));
        if *common != measured {
            let text = format!(
                "its term is {}, but the term of `{other}` is {}; all terms must be lengths, or all angles: \
                 use an arm in m for a rotating body in a translating element, in 1/m for a translating body \
                 in a rotating element, and without a unit otherwise",
                called(measured),
                called(*common)
            );
            reading.refuse(&entry, text);
            sound = false;
        }
        terms.push((body, arm));
    }
    if terms.is_empty() && sound {
        reading.refuse(entry, "names no body; expected one or more bodies");
    }
    let (dimension, _) = first.filter(|_| sound)?;
    Some(Arms { terms, dimension, levers: true })
}

fn called(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::Translation => "a length",
        Dimension::Rotation => "an angle",
    }
}

/// Reads an arm of a body with a dimension; returns the arm and the dimension of its term.
fn lever(reading: &mut Reading, entry: &Entry, body: Dimension) -> Option<(f64, Dimension)> {
    let other = match body {
        Dimension::Translation => Dimension::Rotation,
        Dimension::Rotation => Dimension::Translation,
    };
    let (plain, with_unit) = (kinds::arm_of(body, body), kinds::arm_of(body, other));
    if let Some(expression) = reading.expression(entry) {
        // The units of its parameters show whether an arm is in m or 1/m.
        let power = expression.as_ref()?.length_power(&reading.named.length_powers());
        let changes = power == if body == Dimension::Rotation { 1 } else { -1 };
        let (kind, measured) = if changes { (with_unit, other) } else { (plain, body) };
        return Some((reading.following(entry, expression?, kind, measured)?, measured));
    }
    let units = || symbols(with_unit.unit(other)).filter(|unit| *unit != "1");
    let without = || format!("{}, without a unit", plain.allowed(body));
    reading.note_number(entry, units(), without);
    let changes = entry.value.as_str().is_some_and(|text| has_unit(with_unit.unit(other), text));
    let (kind, measured) = if changes { (with_unit, other) } else { (plain, body) };
    let is_number = !entry.value.is_str() || changes;
    let arm = number(entry.value, kind, measured).map_err(|fault| match is_number {
        true => fault,
        false => {
            let units = kinds::one_of(&units().collect::<Vec<_>>());
            format!("{}, or in {units} for an element whose e is {}", without(), called(other))
        }
    });
    Some((arm.map_err(|text| reading.refuse(entry, text)).ok()?, measured))
}
