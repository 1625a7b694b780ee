//! Stability regions of the periodic motion (figure 5) and Masri's plane (figure 6).

use super::{PANEL, Study};
use crate::Result;
use crate::figures::canvas::palette::{BLACK, BLUE, GREEN, SKY, VERMILLION};
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

/// Figure 5: the region of stable periodic motions on the planes (κ, C) and (ε, C), with the limits of the exact orbit.
///
/// # Errors
/// What the theories refuse.
pub fn regions(set: &ParameterSet) -> Result<Study> {
    let mut table = Table::new(&["plane", "value", "theory", "C_from", "C_to", "C_Gmax"]);
    let kappas = steps(0.0, 1.0, POINTS);
    let manifolds = kappas.iter().map(|&k| Manifold::new(k)).collect::<vibro_impact::Result<Vec<_>>>()?;
    let limits = |m: &Manifold| (m.c_smin(), m.c_smax(), m.c_gmax());
    let band: Vec<_> =
        manifolds.iter().map(|m| (m.kappa(), m.c_smin(), m.c_smax().min(m.c_gmax()))).collect();
    for m in &manifolds {
        let (from, to, geometric) = limits(m);
        table.rows.push(row("kappa", m.kappa(), "multiple scales", &[from, to, geometric]));
    }
    let own = Manifold::new(set.groups().kappa)?;
    let (from, to, geometric) = limits(&own);
    for epsilon in steps(0.0, LARGEST_EPSILON, 10) {
        table.rows.push(row("epsilon", epsilon, "multiple scales", &[from, to, geometric]));
    }
    let mut marks: [[Path; 2]; 2] = Default::default();
    let ranges = [
        ("kappa", steps(0.05, 0.95, EXACT_POINTS)),
        ("epsilon", steps(0.005, LARGEST_EPSILON, EXACT_POINTS)),
    ];
    for (plane, (name, values)) in ranges.into_iter().enumerate() {
        let group = find_group(name)?;
        let limit = |&v: &f64| Ok((v, exact_limits(&set.with(group, v)?)?));
        for (value, found) in values.par_iter().map(limit).collect::<Result<Vec<_>>>()? {
            let Some([low, high]) = found else { continue };
            marks[plane][0].push((value, low));
            marks[plane][1].push((value, high));
            table.rows.push(row(name, value, "exact orbit", &[low, high]));
        }
    }
    let curve = |pick: fn(&Manifold) -> f64| manifolds.iter().map(|m| (m.kappa(), pick(m))).collect::<Path>();
    let flat = |c: f64| vec![(0.0, c), (LARGEST_EPSILON, c)];
    let [kappa_marks, epsilon_marks] = marks;
    let layers = |band, low, high, gmax: Path, [least, most]: [Path; 2]| {
        vec![
            Layer::band("stable periodic motion", SKY, 0.45, band),
            Layer::line("C_Smin = 1/(1 + ρ²)", BLUE, Dash::Solid, low),
            Layer::line("C_Smax = π²/(π² − 4)", VERMILLION, Dash::Solid, high),
            Layer::line("C_Gmax", GREEN, Dash::Dashed, gmax),
            Layer::marks("exact orbit, least stable A₂/(1 − ε + ε²)", BLACK, Mark::Ring, least).stroke(10),
            Layer::marks("exact orbit, largest stable A₂/(1 − ε + ε²)", BLACK, Mark::Triangle, most)
                .stroke(10),
        ]
    };
    let panels = vec![
        Panel {
            title: "(a) Plane (κ, C)".into(),
            x: Axis::over("κ (–)", 0.0, 1.0),
            y: Axis::over("C (units of L)", 0.4, 2.4),
            layers: layers(
                band,
                curve(Manifold::c_smin),
                curve(Manifold::c_smax),
                curve(Manifold::c_gmax),
                kappa_marks,
            ),
        },
        Panel {
            title: format!("(b) Plane (ε, C), κ = {}", short(own.kappa())),
            x: Axis::over("ε (–)", 0.0, LARGEST_EPSILON),
            y: Axis::over("C (units of L)", 0.4, 2.4),
            layers: layers(
                vec![(0.0, from, to.min(geometric)), (LARGEST_EPSILON, from, to.min(geometric))],
                flat(from),
                flat(to),
                flat(geometric),
                epsilon_marks,
            ),
        },
    ];
    let figure = Figure {
        title: "Stability of the periodic motion (cf. figure 5)".into(),
        caption: vec![
            "Multiple scales to leading order: the limits do not depend on ε. The exact orbit is followed along f̂₁₀.".into(),
            set.caption(),
        ],
        panels,
        columns: 2,
        panel: PANEL,
        shared_legend: true,
    };
    Ok(Study {
        name: "stability-5".into(),
        what:
            "stability regions on the planes (κ, C) and (ε, C) as in figure 5, with the exact orbit's limits"
                .into(),
        tables: vec![("stability-5".into(), table.csv()?)],
        shown: None,
        figure: Some(figure),
        remarks: vec![format!(
            "kappa = {}: C_Smin = {from:.5}, C_Smax = {to:.5}, C_Gmax = {geometric:.5}",
            short(own.kappa())
        )],
    })
}

fn row(plane: &str, value: f64, theory: &str, numbers: &[f64]) -> Vec<String> {
    let mut row = vec![plane.into(), exact(value), theory.into()];
    row.extend((0..3).map(|i| numbers.get(i).copied().map_or(String::new(), exact)));
    row
}

/// Figure 6: Masri's plane, ξ = k1 L/F10 over κ, at σ̂1 = 0, ε = 0.05, ζ = 0.01. The scale of ξ is ours.
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
    let mut table = Table::new(&["kappa", "theory", "xi_from", "xi_to"]);
    let mut band = Vec::new();
    for kappa in steps(0.0, 1.0, POINTS) {
        // κ = 1 itself is only neutrally stable: its limits are those from below.
        let system = MultipleScales::new(&groups(kappa.min(1.0 - 1e-9)))?;
        if let Some((low, high)) = system.force_range()?.admissible {
            band.push((kappa, xi(high), xi(low)));
            table.rows.push(vec![exact(kappa), "multiple scales".into(), exact(xi(high)), exact(xi(low))]);
        }
    }
    let marks = exact_masri(set, groups, xi)?;
    for (kappa, low, high) in &marks {
        table.rows.push(vec![exact(*kappa), "exact orbit".into(), exact(*low), exact(*high)]);
    }
    let side = |pick: fn(&(f64, f64, f64)) -> f64, of: &[(f64, f64, f64)]| {
        of.iter().map(|p| (p.0, pick(p))).collect::<Path>()
    };
    let top = band.iter().map(|p| p.2).fold(0.0, f64::max);
    let panel = Panel {
        title: format!("ε = {MASRI_EPSILON}, ζ = {MASRI_ZETA}, σ̂₁ = 0"),
        x: Axis::over("κ (–)", 0.0, 1.0),
        y: Axis::over("ξ = k₁L/F₁₀ (–)", 0.0, 1.15 * top),
        layers: vec![
            Layer::band("stable, multiple scales", SKY, 0.45, band.clone()),
            Layer::line("highest f̂₁₀", VERMILLION, Dash::Solid, side(|p| p.1, &band)),
            Layer::line("lowest f̂₁₀", BLUE, Dash::Solid, side(|p| p.2, &band)),
            Layer::marks("exact orbit, lowest f̂₁₀", BLACK, Mark::Ring, side(|p| p.2, &marks)).stroke(10),
            Layer::marks("exact orbit, highest f̂₁₀", BLACK, Mark::Triangle, side(|p| p.1, &marks)).stroke(10),
        ],
    };
    let figure = Figure {
        title: "Stability region on Masri's plane (cf. figure 6)".into(),
        caption: vec![
            "The scale of ξ is ours: the paper's factor [67] cannot be recovered from its text.".into(),
            format!("α̂₂₃, σ̂₃₀ and γ̂₃, which move the exact orbit's limits only: {}", set.origin()),
        ],
        panels: vec![panel],
        columns: 1,
        panel: (2000, 1300),
        shared_legend: false,
    };
    Ok(Study {
        name: "stability-6".into(),
        what: "stability region on Masri's plane (κ, ξ = k₁L/F₁₀) as in figure 6; the scale of ξ is ours"
            .into(),
        tables: vec![("stability-6".into(), table.csv()?)],
        shown: None,
        figure: Some(figure),
        remarks: Vec::new(),
    })
}

/// κ and the least and largest ξ of stable exact orbits.
fn exact_masri(
    set: &ParameterSet,
    groups: impl Fn(f64) -> Groups + Sync,
    xi: impl Fn(f64) -> f64 + Sync,
) -> Result<Vec<(f64, f64, f64)>> {
    let kappas = steps(0.05, 0.95, EXACT_POINTS);
    let limit = |&kappa: &f64| -> Result<Option<(f64, f64, f64)>> {
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
