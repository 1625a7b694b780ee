//! The slow invariant manifold: its shape (figure 2), its admissible part (figure 7), its fixed
//! points (figure 9).

use super::lengths::Lengths;
use crate::Result;
use crate::studies::Study;
use crate::table::{TextTable, exact};
use std::f64::consts::{PI, TAU};
use vibro_figures::canvas::palette::{BLACK, FAMILY, GREY, HERE};
use vibro_figures::chart::{Axis, Dash, Figure, LINE, Layer, Mark, Panel, Path};
use vibro_impact::steady::Roots;
use vibro_impact::steady::multiple_scales::{FixedPoint, Manifold, MultipleScales, sawtooth};
use vibro_studies::paper::{Name, ParameterSet, short};

/// Points of a curve.
const POINTS: u32 = 600;
const PANEL: (u32, u32) = (1500, 1150);

fn grid(from: f64, to: f64, count: u32) -> impl Iterator<Item = f64> {
    (0..=count).map(move |i| from + (to - from) * f64::from(i) / f64::from(count))
}

fn curve(m: &Manifold, from: f64, to: f64) -> Path {
    if from >= to {
        return Vec::new();
    }
    grid(from, to, POINTS).map(|c| (c, m.b(c))).collect()
}

fn both(roots: Option<Roots<FixedPoint>>) -> Vec<(&'static str, FixedPoint)> {
    roots.into_iter().flat_map(|r| [("P₁", r.lower), ("P₂", r.upper)]).collect()
}

/// The fixed points as marks, filled if all tests hold.
fn points(points: &[(&'static str, FixedPoint)], colour: vibro_figures::chart::Colour) -> Vec<Layer> {
    let of = |all: bool| {
        points
            .iter()
            .filter(move |p| p.1.admissibility.all() == all)
            .map(|p| (p.1.c, p.1.b))
            .collect::<Path>()
    };
    vec![
        Layer::marks("admissible fixed point", colour, Mark::Disc, of(true)).stroke(16),
        Layer::marks("other fixed point", colour, Mark::Ring, of(false)).stroke(16),
    ]
}

fn labels(points: &[(&'static str, FixedPoint)], shift: f64) -> impl Iterator<Item = Layer> {
    points.iter().map(move |(name, p)| Layer::text((p.c, p.b + shift), *name, BLACK))
}

/// Range of C that a picture shows: it contains the fixed points and the stable periodic motions.
fn shown(system: &MultipleScales, roots: &[(&'static str, FixedPoint)]) -> (f64, f64) {
    let from = roots.iter().map(|p| p.1.c).fold(-0.2, f64::min);
    let to = roots.iter().map(|p| p.1.c).fold(1.2 * system.manifold().c_smax(), f64::max);
    (from - 0.1, to + 0.2)
}

/// Figure 2: the sawtooth, the manifold with its minimum and the fixed points, ρ over κ.
///
/// # Errors
/// The errors of multiple scales.
pub fn shapes(set: &ParameterSet) -> Result<Study> {
    let (system, lengths) = (MultipleScales::new(set.groups())?, Lengths::of(set));
    let m = system.manifold();
    let roots = both(system.fixed_points());
    let (from, to) = shown(&system, &roots);
    let saw: Path = grid(0.0, 2.0 * TAU, POINTS).map(|s| (s / PI, sawtooth(s))).collect();
    let rho = |kappa| Manifold::new(kappa).map(|m| (kappa, m.rho()));
    let rhos = grid(0.0, 1.0, POINTS).map(rho).collect::<vibro_impact::Result<Path>>()?;
    let mut table = TextTable::new(&["curve", "x", "y"]);
    for (name, path) in [("Z(s/pi)", &saw), ("B(C)", &curve(m, from, to)), ("rho(kappa)", &rhos)] {
        table.rows.extend(path.iter().map(|p| vec![name.into(), exact(p.0), exact(p.1)]));
    }
    for (name, p) in [("P1", 0), ("P2", 1)].into_iter().filter_map(|(n, i)| roots.get(i).map(|r| (n, r.1))) {
        table.rows.push(vec![name.into(), exact(p.c), exact(p.b)]);
    }
    let high = system.manifold().b(to).max(m.b(from));
    let mut sim = vec![Layer::line("", FAMILY[1], Dash::Solid, curve(m, from, to)).labelled("manifold")];
    sim.push(Layer::marks("minimum (C_min, B_min)", FAMILY[3], Mark::Square, vec![(m.c_min(), m.b_min())]));
    sim.extend(points(&roots, BLACK));
    sim.extend(labels(&roots, 0.07 * high));
    let panels = vec![
        Panel {
            title: "(a) Sawtooth function".into(),
            x: Axis::over("phase s/π (–)", 0.0, 4.0),
            y: Axis::over("Z (–)", -1.3, 1.3),
            layers: vec![Layer::line("", FAMILY[1], Dash::Solid, saw)],
        },
        Panel {
            title: format!("(b) Manifold, κ = {}", short(m.kappa())),
            x: lengths.axis_over(&lengths.amplitude("C"), from, to),
            y: lengths.axis_over(&lengths.amplitude("B"), 0.0, 1.15 * high),
            layers: sim,
        },
        Panel {
            title: "(c) ρ over the restitution coefficient".into(),
            x: Axis::over("κ (–)", 0.0, 1.0),
            y: Axis::over("ρ (–)", 0.0, 0.7),
            layers: vec![
                Layer::line("", FAMILY[1], Dash::Solid, rhos),
                Layer::marks("this set", HERE, Mark::Disc, vec![(m.kappa(), m.rho())]),
            ],
        },
    ];
    Study::of(
        "manifold-2",
        "sawtooth function, slow invariant manifold and ρ(κ) as in figure 2",
        &table,
        Figure {
            title: "The slow invariant manifold (cf. the paper's figure 2)".into(),
            caption: vec![set.caption()],
            panels,
            columns: 3,
            panel: PANEL,
            shared_legend: false,
        },
    )
}

/// The ranges of C, on the left and on the right branch, at which a fixed point is stable for the
/// force that holds it there, from the closed forms of
/// [`multiple_scales`](vibro_impact::steady::multiple_scales). On the right branch the determinant
/// is positive beyond the quadratic's vertex and the trace is always negative. On the left branch
/// the determinant is positive before the vertex and the trace is negative for C < γ̂1/(γ̂1 (1+ρ²)
/// + (8/π²) ρ).
fn stable_fixed_points(system: &MultipleScales) -> [(f64, f64); 2] {
    let (m, g) = (system.manifold(), system.groups());
    if g.gamma3 == 0.0 {
        return [(0.0, 0.0); 2]; // A3 never settles
    }
    let (a, b, _) = system.quadratic();
    let (vertex, rho) = (-0.5 * b / a, m.rho());
    let turn = g.gamma1 / (g.gamma1 * (1.0 + rho * rho) + 8.0 / (PI * PI) * rho);
    [(f64::NEG_INFINITY, vertex.min(turn)), (m.c_min().max(vertex), f64::INFINITY)]
}

/// Figure 7: the parts of the manifold that pass each of the three tests, and the part that passes
/// all.
///
/// # Errors
/// The errors of multiple scales.
pub fn branches(set: &ParameterSet) -> Result<Study> {
    let (system, lengths) = (MultipleScales::new(set.groups())?, Lengths::of(set));
    let m = system.manifold();
    let roots = both(system.fixed_points());
    let (from, mut to) = shown(&system, &roots);
    to = to.max(1.1 * m.c_gmax());
    let [left, right] = stable_fixed_points(&system);
    let (low, high) = admissible(m, right);
    let wide = |name: &str, colour, width, c0: f64, c1: f64| {
        Layer::line(name, colour, Dash::Solid, curve(m, c0.max(from), c1.min(to))).stroke(width)
    };
    let tests = vec![
        Layer::line("slow invariant manifold", BLACK, Dash::Solid, curve(m, from, to)).stroke(3),
        wide("geometrically allowed (0 < C ≤ C_Gmax)", FAMILY[4], 34, 0.0, m.c_gmax()).pale(),
        wide("stable fixed point (SFP)", FAMILY[3], 20, left.0, left.1),
        wide("", FAMILY[3], 20, right.0, right.1),
        wide("stable periodic motion (SPM)", FAMILY[0], 8, m.c_smin(), m.c_smax()),
    ];
    let (near, top) = (0.5_f64.min(low - 0.3), 2.2_f64.max(high + 0.3));
    let mut all = vec![
        Layer::line("slow invariant manifold", GREY, Dash::Solid, curve(m, near.min(from), top)),
        wide("all three tests hold (S)", FAMILY[4], 18, low, high),
    ];
    all.extend(points(&roots, BLACK));
    all.extend(labels(&roots, 0.1));
    let panels = vec![
        Panel {
            title: "(a) Each test on its own".into(),
            x: lengths.axis_over(&lengths.amplitude("C"), from, to),
            y: lengths.axis_over(&lengths.amplitude("B"), 0.0, 1.05 * m.b(to)),
            layers: tests,
        },
        Panel {
            title: "(b) All tests, and the fixed points".into(),
            x: lengths.axis_over(&lengths.amplitude("C"), from.min(near), top),
            y: lengths.axis_over(&lengths.amplitude("B"), 0.0, 1.1 * m.b(top).max(m.b(from))),
            layers: all,
        },
    ];
    Study::of(
        "manifold-7",
        "parts of the slow invariant manifold by the three tests as in figure 7",
        &part_table(m, [left, right], &roots),
        Figure {
            title: "Admissible part of the slow invariant manifold (cf. the paper's figure 7)".into(),
            caption: vec![set.caption()],
            panels,
            columns: 2,
            panel: crate::studies::PANEL,
            shared_legend: false,
        },
    )
}

/// Range of C that passes all three tests, given the range where fixed points on the right branch
/// are stable; the range is empty if its ends are not in order.
fn admissible(m: &Manifold, right: (f64, f64)) -> (f64, f64) {
    (m.c_smin().max(right.0), m.c_smax().min(m.c_gmax()).min(right.1))
}

/// Table of the ranges of C that pass the tests, with empty cells if there is none, and of the
/// fixed points.
fn part_table(
    m: &Manifold,
    [left, right]: [(f64, f64); 2],
    roots: &[(&'static str, FixedPoint)],
) -> TextTable {
    let parts = [
        ("geometric", (0.0, m.c_gmax())),
        ("stable fixed point, left branch", left),
        ("stable fixed point, right branch", right),
        ("stable periodic motion", (m.c_smin(), m.c_smax())),
        ("all three", admissible(m, right)),
    ];
    let mut table = TextTable::new(&["part", "C_from", "C_to", "B_from", "B_to"]);
    for (name, (c0, c1)) in parts {
        let number = |value: f64| if c0 < c1 { exact(value) } else { String::new() };
        let numbers = [c0, c1, m.b(c0), m.b(c1)].map(number);
        table.rows.push([vec![name.into()], numbers.to_vec()].concat());
    }
    for (name, p) in roots {
        table.rows.push(vec![ascii(name), exact(p.c), exact(p.c), exact(p.b), exact(p.b)]);
    }
    table
}

/// The name of a fixed point in ASCII, for tables.
fn ascii(name: &str) -> String {
    name.replace('₁', "1").replace('₂', "2")
}

/// Figure 9: the fixed points and the admissible part for several values of a parameter (f̂10 in
/// the paper).
///
/// # Errors
/// An error if a value is not allowed; the errors of multiple scales.
pub fn families(set: &ParameterSet, name: Name, values: &[f64]) -> Result<Study> {
    let mut table =
        TextTable::new(&[name.name(), "root", "C", "B", "A3", "geometric", "fixed_point", "periodic_motion"]);
    let mut panels = Vec::new();
    for (index, &value) in values.iter().enumerate() {
        let set = set.with(name, value)?;
        panels.push(member(&set, name, value, index, &mut table)?);
    }
    Study::of(
        "manifold-9",
        format!(
            "fixed points on the slow invariant manifold for {} values of {} as in figure 9",
            values.len(),
            name.symbol()
        ),
        &table,
        Figure {
            title: format!("Fixed points for some {} (cf. the paper's figure 9)", name.symbol()),
            caption: vec![
                format!("{} differs between the panels; else:", set.symbol(name)),
                set.caption_but(&[name]),
            ],
            panels,
            columns: 2,
            panel: crate::studies::PANEL,
            shared_legend: true,
        },
    )
}

fn member(set: &ParameterSet, name: Name, value: f64, index: usize, table: &mut TextTable) -> Result<Panel> {
    let (system, lengths) = (MultipleScales::new(set.groups())?, Lengths::of(set));
    let m = system.manifold();
    let roots = both(system.fixed_points());
    for (root, p) in &roots {
        let a = p.admissibility;
        let mut row = vec![exact(value), ascii(root), exact(p.c), exact(p.b), exact(p.a3)];
        row.extend([a.geometric, a.fixed_point, a.periodic_motion].map(|t| t.to_string()));
        table.rows.push(row);
    }
    let [_, right] = stable_fixed_points(&system);
    let (low, high) = admissible(m, right);
    // All panels share their axes unless a fixed point lies beyond.
    let (from, to) = shown(&system, &roots);
    let (from, to) = (from.min(-1.0), to.max(2.4));
    let mut layers = vec![
        Layer::line("slow invariant manifold", GREY, Dash::Solid, curve(m, from, to)),
        Layer::line("all three tests hold (S)", FAMILY[4], Dash::Solid, curve(m, low, high)).stroke(3 * LINE),
    ];
    layers.extend(points(&roots, BLACK));
    let top = 1.1 * m.b(from).max(m.b(to));
    layers.extend(labels(&roots, 0.08 * top));
    let letter = char::from(b'a' + (index % 26) as u8);
    Ok(Panel {
        title: format!("({letter}) {}", set.told(name, value)),
        x: lengths.axis_over(&lengths.amplitude("C"), from, to),
        y: lengths.axis_over(&lengths.amplitude("B"), 0.0, top),
        layers,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibro_impact::parameters::Groups;

    #[test]
    fn ranges_of_stable_fixed_points_are_the_librarys() {
        for (gamma1, sigma1, kappa) in [(1.0, 0.4, 0.75), (0.3, -0.6, 0.5), (2.0, -1.0, 0.2), (0.0, 0.2, 0.9)]
        {
            let base = Groups { gamma1, sigma1, kappa, ..Groups::basic() };
            let system = MultipleScales::new(&base).unwrap();
            let ranges = stable_fixed_points(&system);
            for c in grid(-1.0, 3.0, 401) {
                let f10 = system.force(c);
                let roots = both(MultipleScales::new(&Groups { f10, ..base }).unwrap().fixed_points());
                let nearest = roots.iter().min_by(|a, b| (a.1.c - c).abs().total_cmp(&(b.1.c - c).abs()));
                let expected = nearest.unwrap().1.admissibility.fixed_point;
                let inside = ranges.iter().any(|r| r.0 < c && c < r.1);
                assert_eq!(inside, expected, "gamma1 {gamma1}, sigma1 {sigma1}, kappa {kappa}, C {c}");
            }
        }
    }
}
