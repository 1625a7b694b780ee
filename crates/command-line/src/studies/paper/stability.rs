//! Stability regions of the periodic motion (figure 5) and Masri's plane (figure 6).

use super::lengths::Lengths;
use crate::Result;
use crate::studies::{PANEL, Study};
use crate::table::{TextTable, exact};
use rayon::prelude::*;
use vibro_figures::canvas::palette::{BLACK, FAMILY, HERE, SKY};
use vibro_figures::chart::{Axis, Dash, Figure, Layer, Mark, Panel, Path};
use vibro_impact::parameters::Groups;
use vibro_impact::steady::continuation;
use vibro_impact::steady::multiple_scales::{FixedPoint, Manifold, MultipleScales};
use vibro_studies::paper::plane::Method;
use vibro_studies::paper::response::response;
use vibro_studies::paper::{ParameterSet, find_group, short};

/// Text of the legend for the machine's own values.
const OWN: &str = "this set of parameters";
const POINTS: u32 = 200;
/// Number of values for the exact orbit's limits.
const EXACT_POINTS: u32 = 16;
/// Nodes of each search for the exact orbit's limits.
const NODES: usize = 200;
/// Largest ε of figure 5b, unless the machine's own is larger.
const LARGEST_EPSILON: f64 = 0.1;
/// Force range searched for the exact orbit's limits.
const FORCES: (f64, f64) = (0.01, 12.0);
/// Masri's mass ratio and damping ratio (paper 3.3).
const MASRI_EPSILON: f64 = 0.05;
const MASRI_ZETA: f64 = 0.01;

fn steps(from: f64, to: f64, count: u32) -> Vec<f64> {
    (0..=count).map(|i| from + (to - from) * f64::from(i) / f64::from(count)).collect()
}

/// The smallest and largest C, here A2/(1-ε+ε²), of stable exact orbits along the force. `None`
/// without such an orbit.
fn exact_limits(set: &ParameterSet) -> Result<Option<[f64; 2]>> {
    let along = find_group("f10")?;
    let found = response(set, along, FORCES, Method::ExactOrbit, NODES)?;
    let pairs = found.curves.iter().flat_map(|c| c.windows(2)).filter(|w| w[0].stable);
    let sizes = pairs.flat_map(|w| [w[0].c, w[1].c]);
    let (least, most) = sizes.fold((f64::INFINITY, 0.0_f64), |(a, b), c| (a.min(c), b.max(c)));
    Ok((least < most).then_some([least, most]))
}

/// Motions of multiple scales for the force that was set. Empty if no force was set, since the
/// regions hold for all forces.
fn own_motions(set: &ParameterSet) -> Result<Vec<FixedPoint>> {
    if !set.is_set(find_group("f10")?.into()) {
        return Ok(Vec::new());
    }
    let roots =
        MultipleScales::new(set.groups())?.fixed_points().into_iter().flat_map(|r| [r.upper, r.lower]);
    Ok(roots.filter(|p| p.admissibility.geometric).collect())
}

/// Data of figure 5.
struct Regions {
    /// Manifolds of multiple scales for κ from 0 to 1.
    manifolds: Vec<Manifold>,
    /// Manifold of multiple scales at the set's own κ.
    own: Manifold,
    /// On the planes (κ, C) and (ε, C): the value of κ or ε, and the smallest and largest stable C
    /// of the exact orbit.
    exact: [Vec<(f64, [f64; 2])>; 2],
    /// The set's own ε and motions.
    epsilon: f64,
    motions: Vec<FixedPoint>,
    /// Largest ε shown.
    largest: f64,
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
        let (epsilon, motions) = (set.groups().epsilon, own_motions(set)?);
        // The range is extended, so that marks are not at the panel's edge.
        let largest =
            if motions.is_empty() { LARGEST_EPSILON } else { LARGEST_EPSILON.max((1.2 * epsilon).min(1.0)) };
        Ok(Self {
            epsilon,
            motions,
            largest,
            manifolds: over_kappa.collect::<vibro_impact::Result<_>>()?,
            own: Manifold::new(set.groups().kappa)?,
            exact: [
                limits("kappa", steps(0.05, 0.95, EXACT_POINTS))?,
                limits("epsilon", steps(0.005, largest, EXACT_POINTS))?,
            ],
        })
    }

    fn table(&self) -> TextTable {
        let mut table = TextTable::new(&["plane", "value", "theory", "C_from", "C_to", "C_Gmax"]);
        let mut scales = |plane: &str, value: f64, m: &Manifold| {
            let limits = [m.c_smin(), m.c_smax(), m.c_gmax()];
            table.rows.push(row(plane, value, "multiple scales", &limits));
        };
        self.manifolds.iter().for_each(|m| scales("kappa", m.kappa(), m));
        steps(0.0, self.largest, 10).into_iter().for_each(|value| scales("epsilon", value, &self.own));
        for (plane, found) in ["kappa", "epsilon"].into_iter().zip(&self.exact) {
            table.rows.extend(found.iter().map(|(value, limits)| row(plane, *value, "exact orbit", limits)));
        }
        table
    }

    fn panels(&self, lengths: &Lengths) -> Vec<Panel> {
        let curve = |pick: fn(&Manifold) -> f64| -> Path {
            self.manifolds.iter().map(|m| (m.kappa(), pick(m))).collect()
        };
        let flat = |c: f64| vec![(0.0, c), (self.largest, c)];
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
                    self.marks(own.kappa()),
                ),
            },
            Panel {
                title: format!("(b) Plane (ε, C), κ = {}", short(own.kappa())),
                x: Axis::over("ε (–)", 0.0, self.largest),
                y: lengths.axis_over(&lengths.amplitude("C"), 0.4, 2.4),
                layers: region_layers(
                    vec![band(0.0, own), band(self.largest, own)],
                    [own.c_smin(), own.c_smax(), own.c_gmax()].map(flat),
                    over_epsilon,
                    self.marks(self.epsilon),
                ),
            },
        ]
    }

    /// Marks of the set's own motions at a value of the horizontal axis.
    fn marks(&self, x: f64) -> Path {
        self.motions.iter().map(|p| (x, p.c)).collect()
    }

    /// The set's own motions in words.
    fn motions_in_words(&self) -> Vec<String> {
        let word = |p: &FixedPoint| {
            let kind = if p.admissibility.all() { "stable" } else { "unstable" };
            format!("this set's own force: C = {:.5}, {kind}", p.c)
        };
        self.motions.iter().map(word).collect()
    }
}

/// Layers of a panel of figure 5, each with its entry in the legend.
fn region_layers(
    band: Vec<(f64, f64, f64)>,
    [low, high, geometric]: [Path; 3],
    exact: &[(f64, [f64; 2])],
    own: Path,
) -> Vec<Layer> {
    let marks = |end: usize| exact.iter().map(|(value, limits)| (*value, limits[end])).collect::<Path>();
    let mut layers = vec![
        Layer::band("stable periodic motion", SKY, 0.45, band),
        Layer::line("", FAMILY[0], Dash::Solid, low).labelled("C_Smin = 1/(1 + ρ²)"),
        Layer::line("", FAMILY[2], Dash::Solid, high).labelled("C_Smax = π²/(π² − 4)"),
        Layer::line("", FAMILY[3], Dash::Dashed, geometric).labelled("C_Gmax"),
        Layer::marks("exact orbit, least stable A₂/(1 − ε + ε²)", BLACK, Mark::Ring, marks(0)).stroke(10),
        Layer::marks("exact orbit, largest stable A₂/(1 − ε + ε²)", BLACK, Mark::Triangle, marks(1))
            .stroke(10),
    ];
    if !own.is_empty() {
        layers.push(Layer::marks(OWN, HERE, Mark::Disc, own));
    }
    layers
}

/// Figure 5: the region of stable periodic motions on the planes (κ, C) and (ε, C), with the
/// limits of the exact orbit. It holds for all forces; the motions for the set force are marked.
///
/// # Errors
/// The errors of the theories.
pub fn regions(set: &ParameterSet) -> Result<Study> {
    let regions = Regions::new(set)?;
    let figure = Figure {
        title: "Stability of the periodic motion (cf. the paper's figure 5)".into(),
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
    let remarks = std::iter::once(remark).chain(regions.motions_in_words()).collect();
    Ok(Study::of("stability-5", what, &regions.table(), figure)?.with_remarks(remarks))
}

fn row(plane: &str, value: f64, theory: &str, numbers: &[f64]) -> Vec<String> {
    let mut row = vec![plane.into(), exact(value), theory.into()];
    row.extend((0..3).map(|i| numbers.get(i).copied().map_or(String::new(), exact)));
    row
}

/// A value of κ with the smallest and largest ξ of stable motions.
type MasriLimits = (f64, f64, f64);

/// The set of figure 6: ε, ζ, σ̂1 and m3 have the paper's values unless they were set.
fn masri_set(set: &ParameterSet) -> Result<ParameterSet> {
    let paper =
        [("epsilon", MASRI_EPSILON), ("sigma1", 0.0), ("gamma1", 2.0 * MASRI_ZETA / own_epsilon(set)?)];
    let mut found = set.clone();
    for (name, value) in paper {
        let group = find_group(name)?;
        if !set.is_set(group.into()) {
            found = found.with(group, value)?;
        }
    }
    if !set.is_set(find_group("mu13")?.into()) {
        found = found.with(find_group("mu13")?, 1.0 / found.groups().epsilon)?;
    }
    Ok(found)
}

/// ε of figure 6: the set's own if it was set.
fn own_epsilon(set: &ParameterSet) -> Result<f64> {
    Ok(if set.is_set(find_group("epsilon")?.into()) { set.groups().epsilon } else { MASRI_EPSILON })
}

/// Figure 6: Masri's plane, ξ = k1 L/F10 over κ (docs/theory.md (57)), at σ̂1 = 0, ε = 0.05, ζ =
/// 0.01 and m3 = m2, unless these were set. The scale of ξ is this program's choice.
///
/// # Errors
/// The errors of the theories.
pub fn masri(set: &ParameterSet) -> Result<Study> {
    let given = masri_set(set)?;
    let base = *given.groups();
    let groups = |kappa| Groups { kappa, ..base };
    let xi = |f10: f64| 1.0 / (base.epsilon * f10);
    let mut scales = Vec::new();
    for kappa in steps(0.0, 1.0, POINTS) {
        // At κ = 1 motions are only neutrally stable. The limits there are the limits for κ → 1
        // from below.
        let system = MultipleScales::new(&groups(kappa.min(1.0 - 1e-9)))?;
        scales.extend(system.force_range()?.admissible.map(|(low, high)| (kappa, xi(high), xi(low))));
    }
    let exact_orbit = exact_masri(&given, groups, xi)?;
    let mut table = TextTable::new(&["kappa", "theory", "xi_from", "xi_to"]);
    for (theory, limits) in [("multiple scales", &scales), ("exact orbit", &exact_orbit)] {
        let row = |l: &MasriLimits| vec![exact(l.0), theory.into(), exact(l.1), exact(l.2)];
        table.rows.extend(limits.iter().map(row));
    }
    let set_force = set.is_set(find_group("f10")?.into()) && base.f10 > 0.0;
    let own = set_force.then(|| (base.kappa, xi(base.f10)));
    let figure = Figure {
        title: "Stability region on Masri's plane (cf. the paper's figure 6)".into(),
        caption: vec![
            "The scale of ξ = k₁L/F₁₀ is this program's choice; the paper's may differ by a factor.".into(),
            format!("α̂₂₃, σ̂₃₀ and γ̂₃, which move the exact orbit's limits only: {}", set.origin()),
        ],
        panels: vec![masri_panel(&base, scales, &exact_orbit, own)],
        columns: 1,
        panel: (2000, 1300),
        shared_legend: false,
    };
    let what = "stability region on Masri's plane (κ, ξ = k₁L/F₁₀) as in figure 6; the scale of ξ is this program's choice";
    let remarks = own.map(|(kappa, xi)| format!("this set: kappa = {}, xi = {xi:.5}", short(kappa)));
    Ok(Study::of("stability-6", what, &table, figure)?.with_remarks(remarks.into_iter().collect()))
}

fn masri_panel(
    g: &Groups,
    scales: Vec<MasriLimits>,
    exact_orbit: &[MasriLimits],
    own: Option<(f64, f64)>,
) -> Panel {
    let least = |limits: &[MasriLimits]| limits.iter().map(|l| (l.0, l.1)).collect::<Path>();
    let largest = |limits: &[MasriLimits]| limits.iter().map(|l| (l.0, l.2)).collect::<Path>();
    let top = scales.iter().map(|l| l.2).chain(own.map(|own| own.1)).fold(0.0, f64::max);
    let mark = own.map(|own| Layer::marks(OWN, HERE, Mark::Disc, vec![own]));
    Panel {
        title: format!(
            "ε = {}, ζ = {}, σ̂₁ = {}",
            short(g.epsilon),
            short(0.5 * g.gamma1 * g.epsilon),
            short(g.sigma1)
        ),
        x: Axis::over("κ (–)", 0.0, 1.0),
        y: Axis::over("ξ = k₁L/F₁₀ (–)", 0.0, 1.15 * top),
        layers: [
            Layer::band("stable, multiple scales", SKY, 0.45, scales.clone()),
            Layer::line("", FAMILY[2], Dash::Solid, least(&scales)).labelled("highest f̂₁₀"),
            Layer::line("", FAMILY[0], Dash::Solid, largest(&scales)).labelled("lowest f̂₁₀"),
            Layer::marks("exact orbit, lowest f̂₁₀", BLACK, Mark::Ring, largest(exact_orbit)).stroke(10),
            Layer::marks("exact orbit, highest f̂₁₀", BLACK, Mark::Triangle, least(exact_orbit)).stroke(10),
        ]
        .into_iter()
        .chain(mark)
        .collect(),
    }
}

/// κ and the smallest and largest ξ of stable exact orbits.
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
