//! Frequency and force response curves (figures 10, 11).

use super::{PANEL, Study};
use crate::Result;
use crate::figures::canvas::palette::{FAMILY, GREY};
use crate::figures::chart::{Axis, Dash, Figure, Layer, Panel, Path, THIN};
use crate::table::{Table, exact};
use rayon::prelude::*;
use vibro_analysis::Group;
use vibro_analysis::plane::Method;
use vibro_analysis::response::{Response, ResponsePoint, response};
use vibro_analysis::{ParameterSet, find_group, short};

/// Nodes per sheet and interval of solutions.
const NODES: usize = 400;
/// Stroke of the curves of multiple scales, over which those of the exact orbit are drawn.
const WIDE: u32 = 14;

const METHODS: [Method; 2] = [Method::MultipleScales, Method::ExactOrbit];

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

/// One family of curves: a group that differs between them.
struct Family {
    group: &'static Group,
    members: Vec<(f64, Vec<Response>)>,
}

fn family(
    set: &ParameterSet,
    along: &'static Group,
    range: (f64, f64),
    name: &str,
    values: &[f64],
) -> Result<Family> {
    let group = find_group(name)?;
    let member = |&value: &f64| {
        let set = set.with(group, value)?;
        let curves = METHODS.iter().map(|&m| Ok(response(&set, along, range, m, NODES)?));
        Ok((value, curves.collect::<Result<Vec<_>>>()?))
    };
    Ok(Family { group, members: values.par_iter().map(member).collect::<Result<_>>()? })
}

fn table(along: &Group, families: &[Family]) -> Table {
    let mut table = Table::new(&HEADER);
    for family in families {
        for (value, responses) in &family.members {
            for response in responses {
                for (index, curve) in response.curves.iter().enumerate() {
                    for p in curve {
                        table.rows.push(vec![
                            along.name.into(),
                            exact(p.value),
                            family.group.name.into(),
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

fn panel(title: String, along: &Group, range: (f64, f64), family: &Family, third: bool) -> Panel {
    let y = |p: &ResponsePoint| if third { p.a[2] } else { p.c };
    let mut layers = Vec::new();
    let mut highest = 0.0_f64;
    let mut over = Vec::new();
    for ((value, responses), colour) in family.members.iter().zip(FAMILY) {
        let name = format!("{} = {}", family.group.symbol, short(*value));
        for r in responses {
            let [stable, unstable] = pieces(r, y);
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
    let label = if third { "A₃ (units of L)" } else { "C (units of L)" };
    Panel {
        title,
        x: Axis::over(along.label(), range.0, range.1),
        y: Axis::over(label, 0.0, if highest > 0.0 { 1.05 * highest } else { 1.0 }),
        layers,
    }
}

fn caption(set: &ParameterSet) -> Vec<String> {
    let exact = "Pale and wide: multiple scales. Thin: exact orbit; for it C is A₂/(1 − ε + ε²). Shown where C > C_Smin (right branch).";
    vec![exact.into(), set.caption()]
}

/// What figures 10 and 11 differ in.
struct ResponseFigure {
    /// Stem of the files.
    name: &'static str,
    title: &'static str,
    what: &'static str,
    /// The group along the curves.
    along: &'static str,
    /// The two families of curves: the group that differs between the members, and what they are.
    families: [(&'static str, &'static str); 2],
}

/// Figure 10: C and A3 over the detuning σ̂1, for some f̂10 and for some γ̂1.
const FREQUENCY: ResponseFigure = ResponseFigure {
    name: "response-frequency",
    title: "Frequency response (cf. figure 10)",
    what: "frequency response C(σ̂₁), A₃(σ̂₁) as in figure 10, multiple scales and exact orbit",
    along: "sigma1",
    families: [("f10", "for some excitation amplitudes"), ("gamma1", "for some dampings")],
};

/// Figure 11: C and A3 over the excitation amplitude f̂10, for detunings σ̂1 of either sign.
const FORCE: ResponseFigure = ResponseFigure {
    name: "response-force",
    title: "Force response (cf. figure 11)",
    what: "force response C(f̂₁₀), A₃(f̂₁₀) as in figure 11, multiple scales and exact orbit",
    along: "f10",
    families: [("sigma1", "above resonance"), ("sigma1", "below resonance")],
};

impl ResponseFigure {
    /// C and A3 of both families, each for some values of its group.
    fn study(&self, set: &ParameterSet, range: (f64, f64), values: [&[f64]; 2]) -> Result<Study> {
        let along = find_group(self.along)?;
        let family = |i: usize| family(set, along, range, self.families[i].0, values[i]);
        let families = [family(0)?, family(1)?];
        let pairs = families.iter().zip(self.families).flat_map(|(f, w)| [(f, "C", w.1), (f, "A₃", w.1)]);
        let panels = ('a'..).zip(pairs).map(|(letter, (family, symbol, words))| {
            panel(format!("({letter}) {symbol} {words}"), along, range, family, symbol != "C")
        });
        let figure = Figure {
            title: self.title.into(),
            caption: caption(set),
            panels: panels.collect(),
            columns: 2,
            panel: PANEL,
            shared_legend: true,
        };
        Study::of(self.name, self.what, &table(along, &families), figure)
    }
}

/// Figure 10: C and A3 over the detuning σ̂1, for some f̂10 and for some γ̂1.
///
/// # Errors
/// Ranges and values that are not allowed.
pub fn frequency(set: &ParameterSet, range: (f64, f64), f10: &[f64], gamma1: &[f64]) -> Result<Study> {
    FREQUENCY.study(set, range, [f10, gamma1])
}

/// Figure 11: C and A3 over the excitation amplitude f̂10, for some detunings σ̂1.
///
/// # Errors
/// Ranges and values that are not allowed.
pub fn force(set: &ParameterSet, range: (f64, f64), positive: &[f64], negative: &[f64]) -> Result<Study> {
    FORCE.study(set, range, [positive, negative])
}
