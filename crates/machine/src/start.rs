//! Starts: a time, and coordinates and rates of bodies by name, as the initial state of a motion
//! in place of the machine's own start.

mod derivatives;

use crate::assembly::Assembly;
use crate::description::{Body, BodyKind, Description, Dimension};
use crate::elements::Element;
use crate::error::Error;
use crate::kinds::{self, NumberKind};
use crate::motion::{Event, Motion};
use crate::parameters::read;
use crate::refusal::{Problem, Refusal, advice};
use crate::system::{InSeries, in_series};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::{self, Write};
use std::sync::Arc;

/// Start of a motion. Numbers that are not given are taken from the machine's own start.
///
/// Its numbers have names: `time`, `box.s` and `box.v` for a body `box` with mass or inertia,
/// `mount.slider` for a spring `mount` in series, and `pid.x[0]` for a state of a block `pid`.
/// Stops and friction have no values of their own: the law finds which are closed and which stick.
///
/// ```
/// use std::sync::Arc;
/// use vibro_machine::{Assembly, Motion, Start, file};
///
/// let text = r#"
///     name = "Pendulum"
///     [body.bob]
///     mass = 2.0
///     [spring.k]
///     between = ["ground", "bob"]
///     stiffness = 800.0
///     [load.f]
///     on = "bob"
///     amplitude = 1.0
///     frequency = 2.0
/// "#;
/// let assembly = Arc::new(Assembly::new(file::parse(text, "p.toml", &file::no_records)?)?);
/// let mut motion = Motion::new(assembly.clone())?;
/// motion.advance_to(0.3)?;
///
/// let start = Start::of(&motion);
/// let written = start.to_toml();
/// let read = Start::parse(&written, "start.toml", &assembly.description)?;
/// assert_eq!(read, start);
/// let mut on = read.motion(assembly)?;
/// on.advance_to(1.0)?;
/// motion.advance_to(1.0)?;
/// assert!((on.body(0)[0] - motion.body(0)[0]).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Start {
    /// Time, s.
    pub time: f64,
    /// Given coordinates and rates, by the body's name.
    pub bodies: BTreeMap<String, BodyStart>,
    /// Given inner displacements of springs in series, m or rad, by the spring's name.
    pub sliders: BTreeMap<String, f64>,
    /// Given places of the sliders of contacts, m, by the contact's name; for one of two tangents
    /// with the tangent's index: `tip[0]`.
    pub contacts: BTreeMap<String, f64>,
    /// Given states of blocks, by names such as `pid.x[0]`.
    pub blocks: BTreeMap<String, f64>,
}

/// Coordinate and rate of a body at the start, if they are given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyStart {
    /// Coordinate, m or rad.
    pub s: Option<f64>,
    /// Rate, m/s or rad/s.
    pub v: Option<f64>,
}

/// A number of a start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Time,
    /// Coordinate of the body with this index.
    Coordinate(usize),
    /// Rate of the body with this index.
    Rate(usize),
    /// Inner displacement of a spring in series or of a contact, by its index among all of them.
    Slider(usize),
    /// State of a block, by its index among all states of blocks.
    Kept(usize),
}

impl Place {
    fn kind(self, d: &Description) -> (NumberKind, Dimension) {
        match self {
            Self::Time => (kinds::TIME, Dimension::Translation),
            Self::Coordinate(body) => (kinds::START, d.bodies[body].dimension),
            Self::Rate(body) => (kinds::START_RATE, d.bodies[body].dimension),
            Self::Slider(k) => {
                let dimension = in_series(d).nth(k).map(|own| own.arms.dimension);
                (kinds::SLIDER, dimension.unwrap_or(Dimension::Translation))
            }
            Self::Kept(_) => (kinds::BLOCK_START, Dimension::Translation),
        }
    }
}

impl Start {
    /// The present state of a motion.
    pub fn of(motion: &Motion) -> Self {
        let assembly = motion.assembly();
        let body = |&i: &usize| {
            let [s, v] = [motion.coordinate(i), motion.body(i)[1]].map(|x| Some(x + 0.0));
            (assembly.description.bodies[i].name.clone(), BodyStart { s, v })
        };
        let bodies = assembly.system.bodies_of.iter().map(body).collect();
        let places = (0..assembly.system.branches.len()).map(|i| motion.inner_place(i) + 0.0);
        let system = &assembly.system;
        let (mut sliders, mut contacts) = (BTreeMap::new(), BTreeMap::new());
        for (own, place) in in_series(&assembly.description).zip(places) {
            let all = if own.law.is_of_contact() { &mut contacts } else { &mut sliders };
            all.insert(own.key(), place);
        }
        let kept = motion.state().as_slice()[2 * system.coordinates + system.branches.len()..].iter();
        let blocks = assembly.names_of_blocks().into_iter().zip(kept.map(|x| x + 0.0)).collect();
        Self { time: motion.time(), bodies, sliders, contacts, blocks }
    }

    /// Text of a file that reads back as an equal start: SI units, numbers with all digits.
    pub fn to_toml(&self) -> String {
        let mut text = format!("time = {:?}\n", self.time);
        for (name, BodyStart { s, v }) in &self.bodies {
            // A coordinate of a body with several coordinates has a dot in its name.
            let quoted = if name.contains('.') { format!("{name:?}") } else { name.clone() };
            let _ = writeln!(text, "\n[body.{quoted}]");
            for (key, value) in [("s", s), ("v", v)] {
                let _ = value.map_or(Ok(()), |x| writeln!(text, "{key} = {x:?}"));
            }
        }
        for (section, all) in [("spring", &self.sliders), ("contact", &self.contacts)] {
            let mut last = None;
            for (key, slider) in all {
                let [name, word] = named_slider(key);
                if last.replace(name.clone()).as_ref() != Some(&name) {
                    let _ = writeln!(text, "\n[{section}.{name}]");
                }
                let quoted = if word.contains('[') { format!("{word:?}") } else { word };
                let _ = writeln!(text, "{quoted} = {slider:?}");
            }
        }
        if !self.blocks.is_empty() {
            text.push_str("\n[block]\n");
        }
        for (name, x) in &self.blocks {
            let _ = writeln!(text, "{name:?} = {x:?}");
        }
        text
    }

    /// Sets a number by its name, SI.
    ///
    /// # Errors
    /// As [`set_text`](Self::set_text).
    pub fn set(&mut self, d: &Description, name: &str, value: f64) -> Result<(), Refusal> {
        let place = place(d, name)?;
        let (kind, dimension) = place.kind(d);
        if !kind.contains(value) {
            let text = kind.fault(value, dimension);
            return Err(Refusal::one(Problem::new(name, Some(format!("{value:?}")), text)));
        }
        self.put(d, place, value);
        Ok(())
    }

    /// Sets a number by its name from a text, with or without a unit.
    ///
    /// # Errors
    /// A [`Refusal`] for an unknown name, with the nearest known name; for a body with a
    /// prescribed motion; for a value out of range.
    pub fn set_text(&mut self, d: &Description, name: &str, text: &str) -> Result<(), Refusal> {
        let place = place(d, name)?;
        let (kind, dimension) = place.kind(d);
        let value = read(kind, dimension, text).map_err(|fault| {
            let quoted = Some(format!("{:?}", text.trim()));
            Refusal::one(Problem::new(name, quoted, fault))
        })?;
        self.put(d, place, value);
        Ok(())
    }

    fn put(&mut self, d: &Description, place: Place, value: f64) {
        let name = |i: usize| d.bodies[i].name.clone();
        match place {
            Place::Time => self.time = value,
            Place::Coordinate(i) => self.bodies.entry(name(i)).or_default().s = Some(value),
            Place::Rate(i) => self.bodies.entry(name(i)).or_default().v = Some(value),
            Place::Slider(k) => {
                let Some(own) = in_series(d).nth(k) else { return };
                let all = if own.law.is_of_contact() { &mut self.contacts } else { &mut self.sliders };
                all.insert(own.key(), value);
            }
            Place::Kept(k) => {
                let name = d.names_of_blocks().swap_remove(k);
                self.blocks.insert(name, value);
            }
        }
    }

    /// The numbers with their names, as [`set`](Self::set) takes them.
    pub fn numbers(&self) -> Vec<(String, f64)> {
        let of = |(name, body): (&String, &BodyStart)| {
            [("s", body.s), ("v", body.v)].map(|(key, x)| Some((format!("{name}.{key}"), x?)))
        };
        let bodies = self.bodies.iter().flat_map(of).flatten();
        let sliders = self.sliders.iter().chain(&self.contacts);
        let sliders = sliders.map(|(key, x)| (named_slider(key).join("."), *x));
        std::iter::once(("time".into(), self.time))
            .chain(bodies)
            .chain(sliders)
            .chain(self.blocks.clone())
            .collect()
    }

    /// Whether it is the machine's own start, at time 0.
    pub fn is_own(&self) -> bool {
        *self == Self::default()
    }

    /// Names of the numbers of a machine's [`state`](Self::state): `box.s`, …, `box.v`, …,
    /// `mount.slider`, …, `pid.x[0]`, ….
    pub fn names(assembly: &Assembly) -> Vec<String> {
        let bodies = || assembly.system.bodies_of.iter().map(|&i| &assembly.description.bodies[i].name);
        let sliders = in_series(&assembly.description).map(|own| own.name_of_slider());
        let rates = bodies().map(|name| format!("{name}.v"));
        let own = bodies().map(|name| format!("{name}.s")).chain(rates).chain(sliders);
        own.chain(assembly.names_of_blocks()).collect()
    }

    /// Coordinates and rates of the machine, inner displacements of its springs in series and
    /// states of its blocks, as [`Motion::from_state`] takes them.
    ///
    /// # Errors
    /// A [`Refusal`] for an unknown body, and for a body whose coordinate follows from other
    /// bodies.
    pub fn state(&self, assembly: &Assembly) -> Result<Vec<f64>, Refusal> {
        let (d, of) = (&assembly.description, &assembly.system.bodies_of);
        let mut state = crate::motion::start_of(assembly);
        let mut problems = Vec::new();
        for (name, value) in self.numbers() {
            let (body, order) = match place(d, &name) {
                Ok(Place::Coordinate(body)) => (body, 0),
                Ok(Place::Rate(body)) => (body, 1),
                Ok(Place::Slider(k)) => {
                    state[2 * of.len() + k] = value;
                    continue;
                }
                Ok(Place::Kept(k)) => {
                    state[2 * of.len() + assembly.system.branches.len() + k] = value;
                    continue;
                }
                Ok(Place::Time) => continue,
                Err(refusal) => {
                    problems.extend(refusal.problems);
                    continue;
                }
            };
            match of.iter().position(|&own| own == body) {
                Some(k) => state[order * of.len() + k] = value,
                None => {
                    let value = Some(format!("{value:?}"));
                    problems.push(Problem::new(name, value, determined(assembly, body)));
                }
            }
        }
        if problems.is_empty() { Ok(state) } else { Err(Refusal { file: String::new(), problems }) }
    }

    /// The motion from this start.
    ///
    /// # Errors
    /// [`Error::Refused`] as for [`state`](Self::state), and for a rigid stop that the start
    /// violates; other errors as for [`Motion::from_state`].
    pub fn motion(&self, assembly: Arc<Assembly>) -> Result<Motion, Error> {
        self.motion_observed(assembly, &mut |_| ())
    }

    /// As [`motion`](Self::motion), with the events at the start reported to `observer`.
    ///
    /// # Errors
    /// As [`motion`](Self::motion).
    pub fn motion_observed(
        &self,
        assembly: Arc<Assembly>,
        observer: &mut dyn FnMut(&Event),
    ) -> Result<Motion, Error> {
        if self.is_own() {
            return Motion::new_observed(assembly, observer);
        }
        let state = self.state(&assembly)?;
        let begun = Motion::from_state_observed(assembly.clone(), self.time, &state, observer);
        begun.map_err(|error| in_words(&assembly, self.time, error))
    }
}

/// Turns a rigid stop that the start violates into a refusal; keeps all other errors.
fn in_words(assembly: &Assembly, begin: f64, error: Error) -> Error {
    let Error::Violated { stop, time, excess } = &error else { return error };
    if *time != begin {
        return error;
    }
    let element = assembly.description.elements().find(|element| element.dotted() == *stop);
    let dimension = element.and_then(Element::arms).map(|arms| arms.dimension);
    let unit = if dimension == Some(Dimension::Rotation) { "rad" } else { "m" };
    let gap = format!("{stop}.gap");
    let value = assembly.description.get(&gap).ok().map(|gap| format!("{gap:?} {unit}"));
    let text = format!(
        "e - gap = {excess:?} {unit} at the start, t = {time:?} s; a rigid stop requires e <= gap: change the \
         start, or increase the gap"
    );
    Refusal::one(Problem::new(gap, value, text)).into()
}

/// Name of an element and word of its inner place, by the inner place's key: `tip` and `slider`,
/// or of `tip[0]`, for one of two tangents, `tip` and `slider[0]`.
fn named_slider(key: &str) -> [String; 2] {
    let (name, index) = key.split_at(key.find('[').unwrap_or(key.len()));
    [name.into(), format!("slider{index}")]
}

/// The word for the machine's own start in serialized form.
const OWN: &str = "File";

impl From<Start> for String {
    fn from(start: Start) -> Self {
        if start.is_own() { OWN.into() } else { start.to_string() }
    }
}

impl TryFrom<String> for Start {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let mut start = Self::default();
        if text == OWN {
            return Ok(start);
        }
        for part in text.split(',') {
            let number = part.split_once('=').and_then(|(name, x)| Some((name, x.parse::<f64>().ok()?)));
            match number.map(|(name, x)| (name.rsplit_once('.'), x)) {
                Some((Some((body, "s")), x)) => start.bodies.entry(body.into()).or_default().s = Some(x),
                Some((Some((body, "v")), x)) => start.bodies.entry(body.into()).or_default().v = Some(x),
                Some((Some((of, word)), x)) if word.starts_with("slider") => {
                    start.sliders.insert(word.replacen("slider", of, 1), x);
                }
                Some((Some((of, what)), x)) if what.contains(['[', 'h', 'n']) => {
                    start.blocks.insert(format!("{of}.{what}"), x);
                }
                Some((None, time)) => start.time = time,
                _ => return Err(format!("`{part}` is not a start value")),
            }
        }
        Ok(start)
    }
}

/// The numbers in one line, such as `time=0.5,box.s=0.001`.
impl fmt::Display for Start {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_own() {
            return f.write_str("as in the file");
        }
        let words: Vec<String> = self.numbers().iter().map(|(name, x)| format!("{name}={x:?}")).collect();
        f.write_str(&words.join(","))
    }
}

/// The number with a name: `time`, `box.s`, `body.box.v`, `mount.slider`, `spring.mount.slider`.
fn place(d: &Description, name: &str) -> Result<Place, Refusal> {
    if name.trim() == "time" {
        return Ok(Place::Time);
    }
    let is_own = |own: InSeries| {
        let plain = name.trim().strip_prefix(own.section).and_then(|rest| rest.strip_prefix('.'));
        [Some(name.trim()), plain].contains(&Some(own.name_of_slider().as_str()))
    };
    if let Some(k) = in_series(d).position(is_own) {
        return Ok(Place::Slider(k));
    }
    let kept = name.trim().strip_prefix("block.").unwrap_or(name.trim());
    if let Some(k) = d.names_of_blocks().iter().position(|own| own == kept) {
        return Ok(Place::Kept(k));
    }
    let free = |body: &&Body| matches!(body.kind, BodyKind::Free(_));
    let refused = |text: String| Err(Refusal::one(Problem::new(name.trim(), None, text)));
    let of_body = |plain: &str| {
        let (body, key) = plain.rsplit_once('.')?;
        let i = d.bodies.iter().position(|own| own.name == body)?;
        match key {
            "s" => Some((i, Place::Coordinate(i))),
            "v" => Some((i, Place::Rate(i))),
            _ => None,
        }
    };
    let plain = name.trim();
    let plain = plain.strip_prefix("body.").unwrap_or(plain);
    let found = of_body(plain).or_else(|| of_body(name.trim()));
    match found {
        Some((i, place)) if free(&&d.bodies[i]) => Ok(place),
        Some((i, _)) if matches!(d.bodies[i].kind, BodyKind::Node(_)) => {
            refused("it is a node, which moves with the coordinates of its body; use start values of these coordinates".into())
        }
        Some(_) => refused(format!("its motion is prescribed; {}", allowed(d.bodies.iter().filter(free)))),
        None => {
            let names =
                d.bodies.iter().filter(free).flat_map(|b| ["s", "v"].map(|k| format!("{}.{k}", b.name)));
            let sliders = in_series(d).map(|own| own.name_of_slider());
            let names: Vec<String> = std::iter::once("time".into())
                .chain(names)
                .chain(sliders)
                .chain(d.names_of_blocks())
                .collect();
            let near = advice(plain, names.iter().map(String::as_str));
            refused(format!("no start value has this name; {near}"))
        }
    }
}

/// Explains why a body's coordinate cannot be given, and lists bodies whose coordinate can.
fn determined(assembly: &Assembly, body: usize) -> String {
    let (d, system) = (&assembly.description, &assembly.system);
    let name = |&i: &usize| format!("`{}`", d.bodies[i].name);
    let weights = system.bodies[body].s.iter().zip(&system.bodies_of);
    let from: Vec<String> = weights.filter(|(w, _)| **w != 0.0).map(|(_, i)| name(i)).collect();
    let from = if from.is_empty() { "prescribed motions".into() } else { from.join(", ") };
    format!("links determine it from {from}; {}", allowed(system.bodies_of.iter().map(|&i| &d.bodies[i])))
}

fn allowed<'b>(bodies: impl Iterator<Item = &'b Body>) -> String {
    let names: Vec<&str> = bodies.take(crate::refusal::SHOWN).map(|body| body.name.as_str()).collect();
    if names.is_empty() {
        "no body has a start of its own".into()
    } else {
        format!("use start values of {}", names.join(", "))
    }
}
