//! Frequency and force response curves (figures 10, 11), and the response along any other
//! parameter.

use super::lengths::Lengths;
use crate::Result;
use crate::studies::{PANEL, Study};
use crate::table::{TextTable, exact};
use rayon::prelude::*;
use vibro_figures::canvas::palette::{FAMILY, GREY, HERE};
use vibro_figures::chart::{Dash, Figure, Layer, Panel, Path, THIN};
use vibro_studies::paper::maxima::Displacement;
use vibro_studies::paper::plane::Method;
use vibro_studies::paper::response::{Response, ResponsePoint, response};
use vibro_studies::paper::{Name, ParameterSet};

/// Number of nodes on each sheet in each interval of solutions.
const NODES: usize = 400;
/// Stroke of the curves of multiple scales; the curves of the exact orbit are drawn over them.
const WIDE: u32 = 14;

const METHODS: [Method; 2] = [Method::MultipleScales, Method::ExactOrbit];

const HEADER: [&str; 16] = [
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
    "W",
    "stable",
    "clear",
    "right_branch",
    "special",
];

/// A family of curves: a parameter and its values, one for each curve.
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

fn table(along: Name, families: &[Family]) -> TextTable {
    let mut table = TextTable::new(&HEADER);
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
                            exact(p.w),
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

/// Visible pieces of a response: stable ones, then others.
fn pieces(response: &Response, y: impl Fn(&ResponsePoint) -> Option<f64>) -> [Vec<Path>; 2] {
    let mut parts: [Vec<Path>; 2] = [Vec::new(), Vec::new()];
    for curve in &response.curves {
        let mut state = None;
        for pair in curve.windows(2) {
            // As in the paper, only the right branch is shown. A solution in which the block
            // passes through a stop is not a motion.
            let shown = |p: &ResponsePoint| if p.right && p.clear { y(p) } else { None };
            let (Some(from), Some(to)) = (shown(&pair[0]), shown(&pair[1])) else {
                state = None;
                continue;
            };
            let part = &mut parts[usize::from(!pair[0].stable)];
            if state != Some(pair[0].stable) {
                part.push(vec![(pair[0].value, from)]);
                state = Some(pair[0].stable);
            }
            part.last_mut().into_iter().for_each(|p| p.push((pair[1].value, to)));
        }
    }
    parts
}

/// The amplitude that a panel shows.
#[derive(Clone, Copy)]
enum ShownAmplitude {
    C,
    A3,
    /// The amplitude of a coordinate.
    Of(Displacement),
}

impl ShownAmplitude {
    /// Amplitudes of a figure: the paper's C and A3, or the requested one.
    fn of(asked: Option<Displacement>) -> Vec<Self> {
        asked.map_or_else(|| vec![Self::C, Self::A3], |of| vec![Self::Of(of)])
    }

    /// The amplitude at a point in units of L; `None` if the point does not have it.
    fn value(self, p: &ResponsePoint) -> Option<f64> {
        match self {
            Self::C => Some(p.c),
            Self::A3 => Some(p.a[2]),
            Self::Of(of) => p.amplitude(of),
        }
    }

    fn name(self, lengths: &Lengths) -> String {
        match self {
            Self::C => lengths.amplitude("C"),
            Self::A3 => lengths.amplitude("A₃"),
            Self::Of(of) => format!("amplitude of {}", lengths.displacement(of.symbol())),
        }
    }
}

/// Data that all panels of a figure use.
struct Panels<'a> {
    set: &'a ParameterSet,
    lengths: Lengths,
    along: Name,
    range: (f64, f64),
}

impl Panels<'_> {
    /// The set's own value along the curves, if it was set and is in the range.
    fn own(&self) -> Option<f64> {
        let own = self.along.value(self.set);
        (self.set.is_set(self.along) && (self.range.0..=self.range.1).contains(&own)).then_some(own)
    }

    fn panel(&self, title: String, family: &Family, shown: ShownAmplitude) -> Panel {
        let mut layers = Vec::new();
        let mut highest = 0.0_f64;
        let mut over = Vec::new();
        for ((value, responses), colour) in family.members.iter().zip(FAMILY.into_iter().cycle()) {
            let name = self.set.told(family.name, *value);
            // Lengths are in units of their point's own gap.
            let member = self.lengths.ratio(family.name, *value);
            let y = |p: &ResponsePoint| {
                shown.value(p).map(|value| member * self.lengths.ratio(self.along, p.value) * value)
            };
            for r in responses {
                let [stable, unstable] = pieces(r, y);
                let points = stable.iter().chain(&unstable).flatten();
                highest = points.fold(highest, |h, p| h.max(p.1));
                let lines = |dash, pieces| Layer::lines("", colour, dash, pieces);
                if r.method == Method::ExactOrbit {
                    over.push(lines(Dash::Solid, stable).stroke(THIN));
                    over.push(lines(Dash::Dotted, unstable).stroke(THIN));
                } else {
                    // The name is next to the part with more points, which has more room.
                    let mut curves = [lines(Dash::Solid, stable), lines(Dash::Dotted, unstable)];
                    let more = curves[1].extent().len() > curves[0].extent().len();
                    let named = &mut curves[usize::from(more)];
                    *named = named.clone().labelled(&name);
                    layers.extend(curves.map(|curve| curve.stroke(WIDE).pale()));
                }
            }
        }
        layers.extend(over);
        layers.extend(samples());
        let top = if highest > 0.0 { 1.05 * highest } else { 1.0 };
        if let Some(own) = self.own() {
            let line = Layer::line("", HERE, Dash::Dotted, vec![(own, 0.0), (own, top)]).stroke(THIN);
            layers.push(line.labelled(format!("this set: {}", self.set.told(self.along, own))));
        }
        Panel {
            title,
            x: crate::studies::parameter_axis(self.set, self.along, self.range),
            y: self.lengths.axis_over(&shown.name(&self.lengths), 0.0, top),
            layers,
        }
    }
}

/// Entries of the legend for theories and stability.
fn samples() -> impl Iterator<Item = Layer> {
    let all = [
        ("multiple scales, stable", Dash::Solid, WIDE),
        ("multiple scales, unstable", Dash::Dotted, WIDE),
        ("exact orbit, stable", Dash::Solid, THIN),
        ("exact orbit, unstable", Dash::Dotted, THIN),
    ];
    all.into_iter().map(|(name, dash, width)| {
        let sample = Layer::lines(name, GREY, dash, Vec::new()).stroke(width);
        if width == WIDE { sample.pale() } else { sample }
    })
}

fn caption(set: &ParameterSet, varied: &[Name], of: Option<Displacement>) -> Vec<String> {
    let exact = match of {
        None => "Thin: exact orbit; for it C is A₂/(1 − ε + ε²).",
        Some(Displacement::W) => {
            "Thin: exact orbit. In this motion the block goes from stop to stop: the amplitude of w is L."
        }
        Some(_) => "Thin: exact orbit.",
    };
    let text =
        format!("Pale and wide: multiple scales. {exact} Shown for C > C_Smin, where motions can be stable.");
    vec![text, set.caption_but(varied)]
}

/// A response figure.
struct ResponseFigure<'a> {
    /// Stem of the files.
    stem: &'a str,
    title: &'a str,
    what: &'a str,
    /// The parameter along the curves and its range.
    along: Name,
    range: (f64, f64),
    /// The families of curves: the parameter that differs, its description, its values.
    families: &'a [(Name, &'a str, &'a [f64])],
    /// The coordinate whose amplitude is shown; the paper's C and A3 if it is `None`.
    of: Option<Displacement>,
}

impl ResponseFigure<'_> {
    /// The study. A family without a value is left out, and so is a family whose only curve is the
    /// set's own if an earlier family also has only that curve.
    fn study(&self, set: &ParameterSet) -> Result<Study> {
        let (along, range) = (self.along, self.range);
        let own = |family: &(Name, &str, &[f64])| family.2 == [family.0.value(set)];
        let with_values = || self.families.iter().filter(|f| !f.2.is_empty());
        let first_own = with_values().position(own);
        let once = |(index, f): &(usize, &_)| Some(*index) == first_own || !own(f);
        let shown: Vec<_> = with_values().enumerate().filter(once).map(|(_, f)| f).collect();
        let families =
            shown.iter().map(|f| family(set, along, range, (f.0, f.2))).collect::<Result<Vec<_>>>()?;
        let panels = Panels { set, lengths: Lengths::of(set), along, range };
        // Each panel states the parameters of the other families.
        let elsewhere = |name: Name| {
            let others = shown.iter().map(|f| f.0).filter(|other| *other != name);
            others.map(|o| format!("; {}", set.told(o, o.value(set)))).collect::<String>()
        };
        let amplitudes = ShownAmplitude::of(self.of);
        let pairs =
            families.iter().zip(&shown).flat_map(|(f, w)| amplitudes.iter().map(move |a| (f, *a, w.1)));
        let drawn = ('a'..).zip(pairs).map(|(letter, (family, amplitude, words))| {
            let name = amplitude.name(&panels.lengths);
            let title = format!("({letter}) {name} {words}{}", elsewhere(family.name));
            panels.panel(title, family, amplitude)
        });
        let varied: Vec<Name> = std::iter::once(along).chain(shown.iter().map(|f| f.0)).collect();
        let panels: Vec<_> = drawn.collect();
        let figure = Figure {
            title: self.title.into(),
            caption: caption(set, &varied, self.of),
            columns: panels.len().min(2),
            panels,
            panel: PANEL,
            shared_legend: true,
        };
        let (stem, what) = match self.of {
            None => (self.stem.into(), format!("{}, multiple scales and exact orbit", self.what)),
            Some(of) => (
                format!("{}-{of}", self.stem),
                format!(
                    "response, the amplitude of {of} along {}, multiple scales and exact orbit",
                    along.name()
                ),
            ),
        };
        Study::of(&stem, what, &table(along, &families), figure)
    }
}

/// Figure 10: C and A3, or the amplitude of a coordinate, over the detuning σ̂1, for some f̂10 and
/// for some γ̂1.
///
/// # Errors
/// Error for ranges and values that are not valid.
pub fn frequency(
    set: &ParameterSet,
    range: (f64, f64),
    (f10, gamma1): (&[f64], &[f64]),
    of: Option<Displacement>,
) -> Result<Study> {
    ResponseFigure {
        stem: "response-frequency",
        title: "Frequency response (cf. the paper's figure 10)",
        what: "frequency response C(σ̂₁), A₃(σ̂₁) as in figure 10",
        along: Name::find("sigma1")?,
        range,
        families: &[
            (Name::find("f10")?, "for some excitation amplitudes", f10),
            (Name::find("gamma1")?, "for some dampings", gamma1),
        ],
        of,
    }
    .study(set)
}

/// Figure 11: C and A3, or the amplitude of a coordinate, over the excitation amplitude f̂10, for
/// some detunings σ̂1, first the ones above resonance.
///
/// # Errors
/// Error for ranges and values that are not valid.
pub fn force(
    set: &ParameterSet,
    range: (f64, f64),
    (positive, negative): (&[f64], &[f64]),
    of: Option<Displacement>,
) -> Result<Study> {
    let sigma1 = Name::find("sigma1")?;
    ResponseFigure {
        stem: "response-force",
        title: "Force response (cf. the paper's figure 11)",
        what: "force response C(f̂₁₀), A₃(f̂₁₀) as in figure 11",
        along: Name::find("f10")?,
        range,
        families: &[(sigma1, "above resonance", positive), (sigma1, "below resonance", negative)],
        of,
    }
    .study(set)
}

/// C and A3, or the amplitude of a coordinate, along one parameter for some values of another.
///
/// # Errors
/// Error for ranges and values that are not valid.
pub fn along(
    set: &ParameterSet,
    along: Name,
    range: (f64, f64),
    (member, values): (Name, &[f64]),
    of: Option<Displacement>,
) -> Result<Study> {
    ResponseFigure {
        stem: &format!("response-{}", along.name()),
        title: &format!("Response along {}", set.symbol(along)),
        what: &format!("response C, A₃ along {}", along.name()),
        along,
        range,
        families: &[(member, &format!("along {}", set.symbol(along)), values)],
        of,
    }
    .study(set)
}

#[cfg(test)]
mod tests;
