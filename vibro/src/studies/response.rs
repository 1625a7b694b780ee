//! Frequency and force response curves (figures 10, 11), and the response along any other parameter.

use super::{PANEL, Study};
use crate::Result;
use crate::figures::canvas::palette::{FAMILY, GREY, VERMILLION};
use crate::figures::chart::{Axis, Dash, Figure, Layer, Panel, Path, THIN};
use crate::table::{Table, exact};
use rayon::prelude::*;
use vibro_analysis::plane::Method;
use vibro_analysis::response::{Response, ResponsePoint, response};
use vibro_analysis::{Name, ParameterSet};

/// Nodes per sheet and interval of solutions.
const NODES: usize = 400;
/// Stroke of the curves of multiple scales, over which those of the exact orbit are drawn.
const WIDE: u32 = 14;

const METHODS: [Method; 2] = [Method::MultipleScales, Method::ExactOrbit];

/// What is drawn over the parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ordinate {
    /// C, in units of L.
    C,
    /// The amplitude of x1, x2 or x3: the index and whether it is in m; in units of L otherwise.
    Amplitude(usize, bool),
}

impl Ordinate {
    /// Those of the paper's figures.
    pub const PAPER: [Self; 2] = [Self::C, Self::Amplitude(2, false)];

    fn symbol(self) -> &'static str {
        match self {
            Self::C => "C",
            Self::Amplitude(body, _) => ["A₁", "A₂", "A₃"][body],
        }
    }

    fn label(self) -> String {
        let unit = if matches!(self, Self::Amplitude(_, true)) { "m" } else { "units of L" };
        format!("{} ({unit})", self.symbol())
    }

    /// Its value at a point of a machine with this gap.
    fn value(self, p: &ResponsePoint, gap: f64) -> f64 {
        match self {
            Self::C => p.c,
            Self::Amplitude(body, true) => p.a[body] * gap,
            Self::Amplitude(body, false) => p.a[body],
        }
    }
}

const HEADER: [&str; 15] = [
    "along",
    "value",
    "member",
    "member_value",
    "theory",
    "curve",
    "C",
    "B",
    "A1",
    "A2",
    "A3",
    "stable",
    "clear",
    "right_branch",
    "special",
];

/// One family of curves: a parameter that differs between them.
struct Family {
    name: Name,
    members: Vec<(f64, Vec<Response>)>,
}

fn family(
    set: &ParameterSet,
    along: Name,
    range: (f64, f64),
    (name, values): (Name, &[f64]),
) -> Result<Family> {
    let member = |&value: &f64| {
        let set = set.with(name, value)?;
        let curves = METHODS.iter().map(|&m| Ok(response(&set, along, range, m, NODES)?));
        Ok((value, curves.collect::<Result<Vec<_>>>()?))
    };
    Ok(Family { name, members: values.par_iter().map(member).collect::<Result<_>>()? })
}

fn table(along: Name, families: &[Family]) -> Table {
    let mut table = Table::new(&HEADER);
    for family in families {
        for (value, responses) in &family.members {
            for response in responses {
                for (index, curve) in response.curves.iter().enumerate() {
                    for p in curve {
                        table.rows.push(vec![
                            along.name().into(),
                            exact(p.value),
                            family.name.name().into(),
                            exact(*value),
                            response.method.name().into(),
                            index.to_string(),
                            exact(p.c),
                            exact(p.b),
                            exact(p.a[0]),
                            exact(p.a[1]),
                            exact(p.a[2]),
                            p.stable.to_string(),
                            p.clear.to_string(),
                            p.right.to_string(),
                            p.special.map_or(String::new(), |s| s.to_string()),
                        ]);
                    }
                }
            }
        }
    }
    table
}

/// Pieces of the curves that are shown, stable ones and others.
fn pieces(response: &Response, y: impl Fn(&ResponsePoint) -> f64) -> [Vec<Path>; 2] {
    let mut parts: [Vec<Path>; 2] = [Vec::new(), Vec::new()];
    for curve in &response.curves {
        let mut state = None;
        for pair in curve.windows(2) {
            // As in the paper only the right branch is shown. A solution that passes a stop is no motion.
            let shown = pair.iter().all(|p| p.right && p.clear);
            if !shown {
                state = None;
                continue;
            }
            let part = &mut parts[usize::from(!pair[0].stable)];
            if state != Some(pair[0].stable) {
                part.push(vec![(pair[0].value, y(&pair[0]))]);
                state = Some(pair[0].stable);
            }
            part.last_mut().into_iter().for_each(|p| p.push((pair[1].value, y(&pair[1]))));
        }
    }
    parts
}

/// `gap` is L at a value of the family and a value along the curves.
fn panel(
    title: String,
    x: Axis,
    own: Option<(f64, &str)>,
    family: &Family,
    ordinate: Ordinate,
    gap: &dyn Fn(f64, f64) -> f64,
) -> Panel {
    let mut layers = Vec::new();
    let mut highest = 0.0_f64;
    let mut over = Vec::new();
    for ((value, responses), colour) in family.members.iter().zip(FAMILY.into_iter().cycle()) {
        let name = format!("{} = {}", family.name.symbol(), family.name.with_unit(*value));
        for r in responses {
            let [stable, unstable] = pieces(r, |p| ordinate.value(p, gap(*value, p.value)));
            let points = stable.iter().chain(&unstable).flatten();
            highest = points.fold(highest, |h, p| h.max(p.1));
            let lines = |dash, pieces| Layer::lines("", colour, dash, pieces);
            if r.method == Method::ExactOrbit {
                over.push(lines(Dash::Solid, stable).stroke(THIN));
                over.push(lines(Dash::Dotted, unstable).stroke(THIN));
            } else {
                // The name stands beside the stable part, or the other where there is none.
                let mut curves = [lines(Dash::Solid, stable), lines(Dash::Dotted, unstable)];
                let none = curves[0].extent().is_empty();
                let named = &mut curves[usize::from(none)];
                *named = named.clone().labelled(&name);
                layers.extend(curves.map(|curve| curve.stroke(WIDE).pale()));
            }
        }
    }
    layers.extend(over);
    for (name, dash, width) in [
        ("multiple scales, stable", Dash::Solid, WIDE),
        ("multiple scales, unstable", Dash::Dotted, WIDE),
        ("exact orbit, stable", Dash::Solid, THIN),
        ("exact orbit, unstable", Dash::Dotted, THIN),
    ] {
        let sample = Layer::lines(name, GREY, dash, Vec::new()).stroke(width);
        layers.push(if width == WIDE { sample.pale() } else { sample });
    }
    let top = if highest > 0.0 { 1.05 * highest } else { 1.0 };
    if let Some((value, name)) = own {
        layers
            .push(Layer::line(name, VERMILLION, Dash::Dotted, vec![(value, 0.0), (value, top)]).stroke(THIN));
    }
    Panel { title, x, y: Axis::over(ordinate.label(), 0.0, top), layers }
}

fn caption(set: &ParameterSet, varied: &[Name]) -> Vec<String> {
    let exact = "Pale and wide: multiple scales. Thin: exact orbit; for it C is A₂/(1 − ε + ε²). Shown where C > C_Smin (right branch).";
    vec![exact.into(), set.caption_but(varied)]
}

/// What the response figures differ in.
struct ResponseFigure<'a> {
    /// Stem of the files.
    stem: &'a str,
    title: &'a str,
    what: &'a str,
    /// The parameter along the curves, and its range.
    along: Name,
    range: (f64, f64),
    /// The families of curves: the parameter that differs between the members, what they are, and its values.
    families: &'a [(Name, &'a str, &'a [f64])],
    /// What is drawn, a panel each.
    ordinates: &'a [Ordinate],
}

impl ResponseFigure<'_> {
    /// The ordinates of each family. A family without a value is left out, and so is one whose only curve, that of the set
    /// itself, is in another family already.
    fn study(&self, set: &ParameterSet) -> Result<Study> {
        let (along, range) = (self.along, self.range);
        let own = |family: &(Name, &str, &[f64])| family.2 == [family.0.value(set)];
        let mut shown: Vec<_> = self.families.iter().filter(|f| !f.2.is_empty()).collect();
        if let Some(first) = shown.iter().position(|f| own(f)) {
            let mut index = 0;
            shown.retain(|f| {
                index += 1;
                index - 1 <= first || !own(f)
            });
        }
        let families =
            shown.iter().map(|f| family(set, along, range, (f.0, f.2))).collect::<Result<Vec<_>>>()?;
        // Between the families of one figure other parameters differ: each panel tells those of the other families.
        let elsewhere = |name: Name| {
            let others = shown.iter().map(|f| f.0).filter(|other| *other != name);
            let told = others.map(|o| format!("; {} = {}", o.symbol(), o.with_unit(o.value(set))));
            told.collect::<String>()
        };
        let each = |(f, w)| self.ordinates.iter().map(move |ordinate| (f, *ordinate, w));
        let pairs = families.iter().zip(shown.iter().map(|f| f.1)).flat_map(each);
        let here = along.value(set);
        let mark = set.is_set(along) && (range.0..=range.1).contains(&here);
        let label = format!("this set: {} = {}", along.symbol(), along.with_unit(here));
        let panels = ('a'..).zip(pairs).map(|(letter, (family, ordinate, words))| {
            let x = Axis::over(along.label(), range.0, range.1);
            let title = format!("({letter}) {} {words}{}", ordinate.symbol(), elsewhere(family.name));
            let gap = |member: f64, value: f64| match "stop.gap" {
                name if name == along.name() => value,
                name if name == family.name.name() => member,
                _ => set.parameters().stop_gap,
            };
            panel(title, x, mark.then_some((here, &label)), family, ordinate, &gap)
        });
        let varied: Vec<Name> = std::iter::once(along).chain(shown.iter().map(|f| f.0)).collect();
        let figure = Figure {
            title: self.title.into(),
            caption: caption(set, &varied),
            panels: panels.collect(),
            columns: self.ordinates.len().min(2),
            panel: PANEL,
            shared_legend: true,
        };
        Study::of(self.stem, self.what, &table(along, &families), figure)
    }
}

/// "C, A₃".
fn symbols(ordinates: &[Ordinate]) -> String {
    ordinates.iter().map(|o| o.symbol()).collect::<Vec<_>>().join(", ")
}

/// Figure 10: C and A3, or other amplitudes, over the detuning σ̂1, for some f̂10 and for some γ̂1.
///
/// # Errors
/// Ranges and values that are not allowed.
pub fn frequency(
    set: &ParameterSet,
    range: (f64, f64),
    f10: &[f64],
    gamma1: &[f64],
    ordinates: &[Ordinate],
) -> Result<Study> {
    ResponseFigure {
        stem: "response-frequency",
        title: "Frequency response (cf. figure 10)",
        what: &format!(
            "frequency response {} over σ̂₁ as in figure 10, multiple scales and exact orbit",
            symbols(ordinates)
        ),
        along: Name::find("sigma1")?,
        range,
        families: &[
            (Name::find("f10")?, "for some excitation amplitudes", f10),
            (Name::find("gamma1")?, "for some dampings", gamma1),
        ],
        ordinates,
    }
    .study(set)
}

/// Figure 11: C and A3, or other amplitudes, over the excitation amplitude f̂10, for some detunings σ̂1.
///
/// # Errors
/// Ranges and values that are not allowed.
pub fn force(
    set: &ParameterSet,
    range: (f64, f64),
    positive: &[f64],
    negative: &[f64],
    ordinates: &[Ordinate],
) -> Result<Study> {
    let sigma1 = Name::find("sigma1")?;
    ResponseFigure {
        stem: "response-force",
        title: "Force response (cf. figure 11)",
        what: &format!(
            "force response {} over f̂₁₀ as in figure 11, multiple scales and exact orbit",
            symbols(ordinates)
        ),
        along: Name::find("f10")?,
        range,
        families: &[(sigma1, "above resonance", positive), (sigma1, "below resonance", negative)],
        ordinates,
    }
    .study(set)
}

/// C and A3, or other amplitudes, along any parameter, for some values of another.
///
/// # Errors
/// Ranges and values that are not allowed.
pub fn along(
    set: &ParameterSet,
    along: Name,
    range: (f64, f64),
    (member, values): (Name, &[f64]),
    ordinates: &[Ordinate],
) -> Result<Study> {
    ResponseFigure {
        stem: &format!("response-{}", along.name()),
        title: &format!("Response along {}", along.symbol()),
        what: &format!(
            "response {} along {}, multiple scales and exact orbit",
            symbols(ordinates),
            along.name()
        ),
        along,
        range,
        families: &[(member, &format!("along {}", along.symbol()), values)],
        ordinates,
    }
    .study(set)
}
