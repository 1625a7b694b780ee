//! Steady-state values by all theories, and the motion they describe (figure 8).

use super::lengths::Lengths;
use super::steady_motion::{MotionSample, SteadyMotion};
use crate::Result;
use crate::studies::{PANEL, Study};
use crate::table::{TextTable, exact};
use nalgebra::Complex;
use vibro_figures::canvas::palette::{BLACK, BLOCK, BOX, CENTRE, GREY, RELATIVE, SECONDARY};
use vibro_figures::chart::{Axis, Colour, Dash, Figure, Layer, Panel, THIN};
use vibro_impact::steady::continuation::Special;
use vibro_impact::steady::multiple_scales::MultipleScales;
use vibro_impact::steady::{Bifurcation, Sheet, exact_orbit, strong_coupling};
use vibro_studies::paper::ParameterSet;

/// Periods of the drive that histories show.
const PERIODS: f64 = 2.0;
/// Stroke of a curve under another.
const WIDE: u32 = 14;

/// Names and colours of U, W, X1, X2, X3.
pub(super) const CURVES: [(&str, Colour); 5] =
    [("U", CENTRE), ("W", RELATIVE), ("X₁", BOX), ("X₂", BLOCK), ("X₃", SECONDARY)];

/// The quantity that names a bifurcation.
const HEADS_FOR: &str = "largest multiplier heads for";

/// Rows of the table: quantity, unit, theory, root, value.
struct SteadyRows(TextTable);

impl SteadyRows {
    fn put(&mut self, column: (&str, &str), quantity: &str, unit: &str, value: String) {
        self.0.rows.push([quantity, unit, column.0, column.1, &value].map(String::from).to_vec());
    }

    fn number(&mut self, column: (&str, &str), quantity: &str, unit: &str, value: f64) {
        self.put(column, quantity, unit, exact(value));
    }

    fn flag(&mut self, column: (&str, &str), quantity: &str, value: bool) {
        self.put(column, quantity, "", if value { "yes" } else { "no" }.into());
    }

    fn complex(&mut self, column: (&str, &str), name: &str, values: &[Complex<f64>]) {
        for (i, z) in values.iter().enumerate() {
            self.number(column, &format!("Re {name} {}", i + 1), "1", z.re);
            self.number(column, &format!("Im {name} {}", i + 1), "1", z.im);
        }
    }

    fn stability(&mut self, column: (&str, &str), stable: bool, radius: f64, next: Bifurcation) {
        self.flag(column, "stable and admissible", stable);
        self.number(column, "spectral radius", "1", radius);
        self.put(column, HEADS_FOR, "", format!("{next:?}"));
    }
}

/// The table for the screen. It has the names of bifurcations; the file has their identifiers,
/// which programs read.
fn readable(mut table: TextTable) -> TextTable {
    use Bifurcation::{NeimarkSacker, PeriodDoubling, SaddleNode, SymmetryBreaking};
    for row in table.rows.iter_mut().filter(|row| row[0] == HEADS_FOR) {
        let all = [SaddleNode, SymmetryBreaking, PeriodDoubling, NeimarkSacker];
        if let Some(found) = all.into_iter().find(|b| format!("{b:?}") == row[4]) {
            row[4] = Special::Bifurcation(found).to_string();
        }
    }
    table
}

fn root_name(sheet: Sheet) -> &'static str {
    match sheet {
        Sheet::Lower => "lower",
        Sheet::Upper => "upper",
    }
}

/// All steady-state values; a picture of the admissible motion of multiple scales with the exact
/// orbit over it.
///
/// # Errors
/// The errors of multiple scales and of the exact orbit. If strong coupling is singular, it is
/// left out with a remark.
pub fn steady(set: &ParameterSet) -> Result<Study> {
    let mut rows = SteadyRows(TextTable::new(&["quantity", "unit", "theory", "root", "value"]));
    let mut remarks = Vec::new();
    let motions = multiple_scales(set, &mut rows)?;
    let strong = match strong_rows(set, &mut rows) {
        Ok(count) => count,
        Err(e) => {
            remarks.push(format!("strong coupling left out: {e}"));
            0
        }
    };
    let orbits = exact_rows(set, &mut rows)?;
    remarks.push(format!(
        "motions with two symmetric impacts: {motions} by multiple scales, {strong} by strong coupling, {orbits} exact"
    ));
    let (what, figure) = picture(set)?;
    let tables = vec![("steady".into(), rows.0.csv()?)];
    Ok(Study {
        tables,
        shown: Some(readable(rows.0)),
        figure,
        ..Study::without_figure("steady", what).with_remarks(remarks)
    })
}

fn multiple_scales(set: &ParameterSet, rows: &mut SteadyRows) -> Result<usize> {
    const NAME: &str = "multiple scales";
    let system = MultipleScales::new(set.groups())?;
    let (m, all) = (system.manifold(), (NAME, "both"));
    let limits = [
        ("rho", m.rho()),
        ("C_min", m.c_min()),
        ("B_min", m.b_min()),
        ("C_Smin", m.c_smin()),
        ("C_Smax", m.c_smax()),
        ("C_Gmax", m.c_gmax()),
    ];
    for (quantity, value) in limits {
        rows.number(all, quantity, "1", value);
    }
    if let Ok(range) = system.force_range() {
        rows.number(all, "f10 of the fold", "1", range.real_from);
        rows.number(all, "f10 of the first motion", "1", range.positive_from);
        if let Some((from, to)) = range.admissible {
            rows.number(all, "f10 admissible from", "1", from);
            rows.number(all, "f10 admissible to", "1", to);
        }
    }
    let Some(roots) = system.fixed_points() else { return Ok(0) };
    for (sheet, p) in roots.each() {
        let column = (NAME, root_name(sheet));
        let amplitudes = [("C", p.c), ("B", p.b), ("A1", p.a1()), ("A2", p.a2()), ("A3", p.a3)];
        for (quantity, value) in amplitudes {
            rows.number(column, quantity, "L", value);
        }
        let phases = [
            ("drive phase at impact", p.drive_phase),
            ("Phi", p.impact_phase),
            ("psi", p.psi),
            ("psi3", p.psi3),
        ];
        for (quantity, value) in phases {
            rows.number(column, quantity, "rad", value);
        }
        rows.put(column, "branch", "", format!("{:?}", p.branch).to_lowercase());
        admissibility(rows, column, p.admissibility);
        rows.stability(column, p.admissibility.all(), p.spectral_radius(), p.bifurcation());
        rows.complex(column, "multiplier", &p.multipliers);
        rows.complex(column, "eigenvalue", &p.eigenvalues);
    }
    Ok(roots.each().iter().filter(|r| r.1.c > 0.0 && r.1.admissibility.geometric).count())
}

fn admissibility(rows: &mut SteadyRows, column: (&str, &str), tests: vibro_impact::steady::Admissibility) {
    rows.flag(column, "geometric test", tests.geometric);
    rows.flag(column, "stable fixed point", tests.fixed_point);
    rows.flag(column, "stable periodic motion", tests.periodic_motion);
}

fn strong_rows(set: &ParameterSet, rows: &mut SteadyRows) -> vibro_impact::Result<usize> {
    const NAME: &str = "strong coupling";
    let Some(roots) = strong_coupling::solve(set.groups())? else { return Ok(0) };
    for (sheet, p) in roots.each() {
        let column = (NAME, root_name(sheet));
        let amplitudes = [("C", p.c), ("B", p.b), ("A1", p.a1()), ("A2", p.a2()), ("A3", p.a3)];
        for (quantity, value) in amplitudes {
            rows.number(column, quantity, "L", value);
        }
        rows.number(column, "drive phase at impact", "rad", p.drive_phase);
        admissibility(rows, column, p.admissibility);
        rows.stability(column, p.admissibility.all(), p.spectral_radius(), p.bifurcation());
        rows.complex(column, "multiplier", &p.multipliers);
        rows.complex(column, "eigenvalue", &p.eigenvalues);
    }
    Ok(roots.each().iter().filter(|r| r.1.admissibility.geometric).count())
}

fn exact_rows(set: &ParameterSet, rows: &mut SteadyRows) -> Result<usize> {
    const NAME: &str = "exact orbit";
    let p = set.parameters();
    let mut count = 0;
    for (sheet, orbit) in exact_orbit::solve(p)?.each() {
        let Some(orbit) = orbit else { continue };
        let column = (NAME, root_name(sheet));
        let values = SteadyMotion::Exact(orbit).amplitudes(p);
        for (quantity, value) in ["B", "A1", "A2", "A3"].into_iter().zip(values) {
            rows.number(column, quantity, "L", value);
        }
        rows.number(column, "drive phase at impact", "rad", orbit.drive_phase());
        rows.number(column, "impulse p", "N.s", orbit.impulse());
        rows.number(column, "p/m2", "m/s", orbit.impulse() / p.block_mass);
        rows.flag(column, "geometric test", orbit.is_clear());
        rows.stability(column, orbit.is_stable(), orbit.spectral_radius(), orbit.bifurcation());
        rows.complex(column, "multiplier", &orbit.multipliers());
        let start = orbit.initial_state();
        for (body, i) in ["box", "block", "secondary"].into_iter().zip(0..3) {
            rows.number(column, &format!("{body}.s at t = 0"), "m", start.x[i]);
            rows.number(column, &format!("{body}.v at t = 0"), "m/s", start.v[i]);
        }
        count += usize::from(orbit.is_clear());
    }
    Ok(count)
}

fn picture(set: &ParameterSet) -> Result<(String, Option<Figure>)> {
    let approximate = SteadyMotion::multiple_scales(set.groups())?;
    let exact = SteadyMotion::exact(set.parameters())?;
    let stability = |t: &SteadyMotion| if t.is_stable() { "stable" } else { "unstable or not admissible" };
    let named =
        |t: &Option<SteadyMotion>, name: &str| t.as_ref().map(|t| format!("{name} ({})", stability(t)));
    let parts: Vec<_> = [named(&approximate, "multiple scales"), named(&exact, "exact orbit")]
        .into_iter()
        .flatten()
        .collect();
    if parts.is_empty() {
        return Ok(("no picture, because there is no motion with two symmetric impacts".into(), None));
    }
    let what = format!("time histories and phase portraits as in figure 8, by {}", parts.join(" and "));
    let p = set.parameters();
    let of = |t: &Option<SteadyMotion>| t.as_ref().map_or(Vec::new(), |t| t.history(p, PERIODS));
    let (first, second) = (of(&approximate), of(&exact));
    let figure = four_panels(
        "Steady motion with two symmetric impacts (cf. the paper's figure 8)",
        set,
        (&first, "multiple scales"),
        (&second, "exact orbit"),
    );
    Ok((what, Some(figure)))
}

/// Panels of histories and portraits of two named motions over each other.
pub(super) fn four_panels(
    title: &str,
    set: &ParameterSet,
    first: (&[MotionSample], &str),
    second: (&[MotionSample], &str),
) -> Figure {
    let lengths = Lengths::of(set);
    let panel = |title: &str, quantities: &[usize], portrait: bool| {
        comparison_panel(title, &lengths, (quantities, portrait), first, second)
    };
    let [x1, x2, x3] = [2, 3, 4].map(|i| lengths.displacement(CURVES[i].0));
    let [u, w] = [0, 1].map(|i| lengths.displacement(CURVES[i].0));
    Figure {
        title: title.into(),
        caption: vec![set.caption()],
        panels: vec![
            panel("(a) Centre of mass and relative displacement", &[0, 1], false),
            panel(&format!("(b) Phase portraits of {u} and {w}"), &[0, 1], true),
            panel("(c) Box, block and secondary oscillator", &[2, 3, 4], false),
            panel(&format!("(d) Phase portraits of {x1}, {x2}, {x3}"), &[2, 3, 4], true),
        ],
        columns: 2,
        panel: PANEL,
        shared_legend: true,
    }
}

/// Panel of one motion in wide pale strokes and another in thin dashes over it, both in the
/// colours of their bodies, with symbols next to the curves.
pub(super) fn comparison_panel(
    title: &str,
    lengths: &Lengths,
    (quantities, portrait): (&[usize], bool),
    (first, first_name): (&[MotionSample], &str),
    (second, second_name): (&[MotionSample], &str),
) -> Panel {
    let mut layers = Vec::new();
    if quantities.contains(&1) && !portrait {
        let end = first.iter().chain(second).map(|p| p.time).fold(0.0, f64::max);
        let stops = vec![vec![(0.0, 1.0), (end, 1.0)], vec![(0.0, -1.0), (end, -1.0)]];
        layers.push(Layer::lines("stops ±L", BLACK, Dash::Dotted, stops).stroke(THIN).labelled("stop"));
    }
    let path = |points: &[MotionSample], q: usize| {
        // A portrait closes after one period. A second period would fill the gaps between the
        // dashes.
        let shown = points.iter().filter(|p| !portrait || p.time <= 1.0 + 1e-9);
        shown.map(|p| if portrait { (p.x[q], p.v[q]) } else { (p.time, p.x[q]) }).collect::<Vec<_>>()
    };
    for &q in quantities {
        let (name, colour) = CURVES[q];
        if !first.is_empty() {
            let curve = Layer::line("", colour, Dash::Solid, path(first, q)).stroke(WIDE).pale();
            layers.push(curve.labelled(lengths.displacement(name)));
        }
    }
    for &q in quantities {
        let (name, colour) = CURVES[q];
        if !second.is_empty() {
            let curve = Layer::line("", colour, Dash::Dashed, path(second, q)).stroke(THIN);
            layers.push(if first.is_empty() { curve.labelled(lengths.displacement(name)) } else { curve });
        }
    }
    // Entries of the legend for the two motions.
    if !first.is_empty() {
        layers.push(Layer::lines(first_name, GREY, Dash::Solid, Vec::new()).stroke(WIDE).pale());
    }
    if !second.is_empty() {
        layers.push(Layer::lines(second_name, GREY, Dash::Dashed, Vec::new()).stroke(THIN));
    }
    let symbols: Vec<&str> = quantities.iter().map(|&q| CURVES[q].0).collect();
    let displacements = lengths.axis(&lengths.displacements(&symbols));
    let (x, y) = if portrait {
        (displacements, lengths.rates(&symbols))
    } else {
        (
            Axis::over(
                "time Ω₁τ/2π (drive periods)",
                0.0,
                first.iter().chain(second).map(|p| p.time).fold(0.0, f64::max),
            ),
            displacements,
        )
    };
    Panel { title: title.into(), x, y, layers }
}
