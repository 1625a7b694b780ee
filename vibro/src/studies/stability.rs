//! Stability regions of the periodic motion (figure 5) and Masri's plane (figure 6).

use super::lengths::Lengths;
use super::{PANEL, Study};
use crate::Result;
use crate::figures::canvas::palette::{BLACK, FAMILY, SKY};
use crate::figures::chart::{Axis, Dash, Figure, Layer, Mark, Panel, Path};
use crate::table::{Table, exact};
use rayon::prelude::*;
use vibro_analysis::plane::Method;
use vibro_analysis::response::response;
use vibro_analysis::{ParameterSet, find_group, short};
use vibro_impact::parameters::Groups;
use vibro_impact::steady::continuation;
use vibro_impact::steady::multiple_scales::{Manifold, MultipleScales};

const POINTS: u32 = 200;
/// Values at which the exact orbit's limits are found, and nodes of each search.
const EXACT_POINTS: u32 = 16;
const NODES: usize = 200;
/// Largest ε of figure 5b.
const LARGEST_EPSILON: f64 = 0.1;
/// Force range in which the exact orbit's limits are sought.
const FORCES: (f64, f64) = (0.01, 12.0);
/// Masri's mass ratio and damping ratio (paper 3.3).
const MASRI_EPSILON: f64 = 0.05;
const MASRI_ZETA: f64 = 0.01;

fn steps(from: f64, to: f64, count: u32) -> Vec<f64> {
    (0..=count).map(|i| from + (to - from) * f64::from(i) / f64::from(count)).collect()
}

/// The least and largest C (A2 in its units) of stable exact orbits along the force. `None` where there is none.
fn exact_limits(set: &ParameterSet) -> Result<Option<[f64; 2]>> {
    let along = find_group("f10")?;
    let found = response(set, along, FORCES, Method::ExactOrbit, NODES)?;
    let pairs = found.curves.iter().flat_map(|c| c.windows(2)).filter(|w| w[0].stable);
    let sizes = pairs.flat_map(|w| [w[0].c, w[1].c]);
    let (least, most) = sizes.fold((f64::INFINITY, 0.0_f64), |(a, b), c| (a.min(c), b.max(c)));
    Ok((least < most).then_some([least, most]))
}

/// What figure 5 shows.
struct Regions {
    /// Multiple scales over κ, from 0 to 1.
    manifolds: Vec<Manifold>,
    /// Multiple scales at the set's own κ.
    own: Manifold,
    /// On the planes (κ, C) and (ε, C): the value, and the least and largest stable C of the exact orbit.
    exact: [Vec<(f64, [f64; 2])>; 2],
}

impl Regions {
    fn new(set: &ParameterSet) -> Result<Self> {
        let over_kappa = steps(0.0, 1.0, POINTS).into_iter().map(Manifold::new);
        let limits = |name: &str, values: Vec<f64>| -> Result<Vec<(f64, [f64; 2])>> {
            let group = find_group(name)?;
            let limit = |&v: &f64| Ok(exact_limits(&set.with(group, v)?)?.map(|limits| (v, limits)));
            let found = values.par_iter().map(limit).collect::<Result<Vec<_>>>()?;
            Ok(found.into_iter().flatten().collect())
        };
        Ok(Self {
            manifolds: over_kappa.collect::<vibro_impact::Result<_>>()?,
            own: Manifold::new(set.groups().kappa)?,
            exact: [
                limits("kappa", steps(0.05, 0.95, EXACT_POINTS))?,
                limits("epsilon", steps(0.005, LARGEST_EPSILON, EXACT_POINTS))?,
            ],
        })
    }

    fn table(&self) -> Table {
        let mut table = Table::new(&["plane", "value", "theory", "C_from", "C_to", "C_Gmax"]);
        let mut scales = |plane: &str, value: f64, m: &Manifold| {
            let limits = [m.c_smin(), m.c_smax(), m.c_gmax()];
            table.rows.push(row(plane, value, "multiple scales", &limits));
        };
        self.manifolds.iter().for_each(|m| scales("kappa", m.kappa(), m));
        steps(0.0, LARGEST_EPSILON, 10).into_iter().for_each(|value| scales("epsilon", value, &self.own));
        for (plane, found) in ["kappa", "epsilon"].into_iter().zip(&self.exact) {
            table.rows.extend(found.iter().map(|(value, limits)| row(plane, *value, "exact orbit", limits)));
        }
        table
    }

    fn panels(&self, lengths: &Lengths) -> Vec<Panel> {
        let curve = |pick: fn(&Manifold) -> f64| -> Path {
            self.manifolds.iter().map(|m| (m.kappa(), pick(m))).collect()
        };
        let flat = |c: f64| vec![(0.0, c), (LARGEST_EPSILON, c)];
        let stable = |m: &Manifold| (m.c_smin(), m.c_smax().min(m.c_gmax()));
        let band = |x: f64, m: &Manifold| (x, stable(m).0, stable(m).1);
        let [over_kappa, over_epsilon] = &self.exact;
        let own = &self.own;
        vec![
            Panel {
                title: "(a) Plane (κ, C)".into(),
                x: Axis::over("κ (–)", 0.0, 1.0),
                y: lengths.axis_over(&lengths.amplitude("C"), 0.4, 2.4),
                layers: region_layers(
                    self.manifolds.iter().map(|m| band(m.kappa(), m)).collect(),
                    [curve(Manifold::c_smin), curve(Manifold::c_smax), curve(Manifold::c_gmax)],
                    over_kappa,
                ),
            },
            Panel {
                title: format!("(b) Plane (ε, C), κ = {}", short(own.kappa())),
                x: Axis::over("ε (–)", 0.0, LARGEST_EPSILON),
                y: lengths.axis_over(&lengths.amplitude("C"), 0.4, 2.4),
                layers: region_layers(
                    vec![band(0.0, own), band(LARGEST_EPSILON, own)],
                    [own.c_smin(), own.c_smax(), own.c_gmax()].map(flat),
                    over_epsilon,
                ),
            },
        ]
    }
}

/// The layers of a panel of figure 5, each with its entry in the legend.
fn region_layers(
    band: Vec<(f64, f64, f64)>,
    [low, high, geometric]: [Path; 3],
    exact: &[(f64, [f64; 2])],
) -> Vec<Layer> {
    let marks = |end: usize| exact.iter().map(|(value, limits)| (*value, limits[end])).collect::<Path>();
    vec![
        Layer::band("stable periodic motion", SKY, 0.45, band),
        Layer::line("", FAMILY[0], Dash::Solid, low).labelled("C_Smin = 1/(1 + ρ²)"),
        Layer::line("", FAMILY[2], Dash::Solid, high).labelled("C_Smax = π²/(π² − 4)"),
        Layer::line("", FAMILY[3], Dash::Dashed, geometric).labelled("C_Gmax"),
        Layer::marks("exact orbit, least stable A₂/(1 − ε + ε²)", BLACK, Mark::Ring, marks(0)).stroke(10),
        Layer::marks("exact orbit, largest stable A₂/(1 − ε + ε²)", BLACK, Mark::Triangle, marks(1))
            .stroke(10),
    ]
}

/// Figure 5: the region of stable periodic motions on the planes (κ, C) and (ε, C), with the limits of the exact orbit.
///
/// # Errors
/// What the theories refuse.
pub fn regions(set: &ParameterSet) -> Result<Study> {
    let regions = Regions::new(set)?;
    let figure = Figure {
        title: "Stability of the periodic motion (cf. figure 5)".into(),
        caption: vec![
            "Multiple scales to leading order: the limits do not depend on ε. The exact orbit is followed along f̂₁₀.".into(),
            set.caption(),
        ],
        panels: regions.panels(&Lengths::of(set)),
        columns: 2,
        panel: PANEL,
        shared_legend: true,
    };
    let what =
        "stability regions on the planes (κ, C) and (ε, C) as in figure 5, with the exact orbit's limits";
    let own = &regions.own;
    let remark = format!(
        "kappa = {}: C_Smin = {:.5}, C_Smax = {:.5}, C_Gmax = {:.5}",
        short(own.kappa()),
        own.c_smin(),
        own.c_smax(),
        own.c_gmax()
    );
    Ok(Study::of("stability-5", what, &regions.table(), figure)?.with_remarks(vec![remark]))
}

fn row(plane: &str, value: f64, theory: &str, numbers: &[f64]) -> Vec<String> {
    let mut row = vec![plane.into(), exact(value), theory.into()];
    row.extend((0..3).map(|i| numbers.get(i).copied().map_or(String::new(), exact)));
    row
}

/// A value of κ with the least and largest ξ of stable motions.
type MasriLimits = (f64, f64, f64);

/// Figure 6: Masri's plane, ξ = k1 L/F10 over κ (docs/theory.md (57)), at σ̂1 = 0, ε = 0.05, ζ = 0.01. The scale of ξ is
/// this program's choice.
///
/// # Errors
/// What the theories refuse.
pub fn masri(set: &ParameterSet) -> Result<Study> {
    let masri = Groups { gamma1: 2.0 * MASRI_ZETA / MASRI_EPSILON, sigma1: 0.0, ..*set.groups() };
    let groups = |kappa| Groups {
        kappa,
        epsilon: MASRI_EPSILON,
        beta2: MASRI_EPSILON * masri.alpha23,
        mu13: 1.0 / MASRI_EPSILON,
        ..masri
    };
    let xi = |f10: f64| 1.0 / (MASRI_EPSILON * f10);
    let mut scales = Vec::new();
    for kappa in steps(0.0, 1.0, POINTS) {
        // κ = 1 itself is only neutrally stable: its limits are those from below.
        let system = MultipleScales::new(&groups(kappa.min(1.0 - 1e-9)))?;
        scales.extend(system.force_range()?.admissible.map(|(low, high)| (kappa, xi(high), xi(low))));
    }
    let exact_orbit = exact_masri(set, groups, xi)?;
    let mut table = Table::new(&["kappa", "theory", "xi_from", "xi_to"]);
    for (theory, limits) in [("multiple scales", &scales), ("exact orbit", &exact_orbit)] {
        let row = |l: &MasriLimits| vec![exact(l.0), theory.into(), exact(l.1), exact(l.2)];
        table.rows.extend(limits.iter().map(row));
    }
    let figure = Figure {
        title: "Stability region on Masri's plane (cf. figure 6)".into(),
        caption: vec![
            "The scale of ξ is ours: the copy of the paper this work was built from lacks the factor [67]."
                .into(),
            format!("α̂₂₃, σ̂₃₀ and γ̂₃, which move the exact orbit's limits only: {}", set.origin()),
        ],
        panels: vec![masri_panel(scales, &exact_orbit)],
        columns: 1,
        panel: (2000, 1300),
        shared_legend: false,
    };
    let what = "stability region on Masri's plane (κ, ξ = k₁L/F₁₀) as in figure 6; the scale of ξ is ours";
    Study::of("stability-6", what, &table, figure)
}

fn masri_panel(scales: Vec<MasriLimits>, exact_orbit: &[MasriLimits]) -> Panel {
    let least = |limits: &[MasriLimits]| limits.iter().map(|l| (l.0, l.1)).collect::<Path>();
    let largest = |limits: &[MasriLimits]| limits.iter().map(|l| (l.0, l.2)).collect::<Path>();
    let top = scales.iter().map(|l| l.2).fold(0.0, f64::max);
    Panel {
        title: format!("ε = {MASRI_EPSILON}, ζ = {MASRI_ZETA}, σ̂₁ = 0"),
        x: Axis::over("κ (–)", 0.0, 1.0),
        y: Axis::over("ξ = k₁L/F₁₀ (–)", 0.0, 1.15 * top),
        layers: vec![
            Layer::band("stable, multiple scales", SKY, 0.45, scales.clone()),
            Layer::line("", FAMILY[2], Dash::Solid, least(&scales)).labelled("highest f̂₁₀"),
            Layer::line("", FAMILY[0], Dash::Solid, largest(&scales)).labelled("lowest f̂₁₀"),
            Layer::marks("exact orbit, lowest f̂₁₀", BLACK, Mark::Ring, largest(exact_orbit)).stroke(10),
            Layer::marks("exact orbit, highest f̂₁₀", BLACK, Mark::Triangle, least(exact_orbit)).stroke(10),
        ],
    }
}

/// κ and the least and largest ξ of stable exact orbits.
fn exact_masri(
    set: &ParameterSet,
    groups: impl Fn(f64) -> Groups + Sync,
    xi: impl Fn(f64) -> f64 + Sync,
) -> Result<Vec<MasriLimits>> {
    let kappas = steps(0.05, 0.95, EXACT_POINTS);
    let limit = |&kappa: &f64| -> Result<Option<MasriLimits>> {
        let path = |f10| set.parameters_of(&Groups { f10, ..groups(kappa) });
        let branch = continuation::exact_orbit(path, FORCES, NODES)?;
        let stable: Vec<f64> = branch
            .curves
            .iter()
            .flat_map(|c| c.points.windows(2))
            .filter(|w| w[0].stable)
            .flat_map(|w| [w[0].value, w[1].value])
            .collect();
        let (low, high) = stable.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(*v), b.max(*v)));
        Ok((low < high).then(|| (kappa, xi(high), xi(low))))
    };
    let found = kappas.par_iter().map(limit).collect::<Result<Vec<_>>>()?;
    Ok(found.into_iter().flatten().collect())
}
