//! The error statement: how far the reduced body is right at its interface nodes.

use crate::damping::Projected;
use crate::dofs::Direction;
use crate::eigen::Modes;
use crate::interface::Interface;
use crate::model::{Model, STANDARD_GRAVITY};
use crate::reduction::{Method, Reduced};
use std::f64::consts::PI;
use std::fmt::Write;

/// Numbers that the engineer gives for the statement.
#[derive(Clone, Copy, Debug, Default)]
pub struct Given {
    /// Stiffness of the contacts, N/m; without it a contact is as stiff as the residual.
    pub contact_stiffness: Option<f64>,
    /// Highest frequency of the loads, Hz.
    pub load_frequency: Option<f64>,
}

/// The three numbers of an interface dof.
#[derive(Clone, Debug, PartialEq)]
pub struct AtDof {
    /// `tip.x`.
    pub label: String,
    /// Static flexibility that the coordinates lack, over the whole.
    pub residual_share: f64,
    /// Stiffness of the residual flexibility, N/m; infinite if there is none.
    pub residual_stiffness: f64,
    /// Frequency of a contact at this dof, Hz: its stiffness against the mass of the modes there.
    pub contact_frequency: f64,
}

/// The numbers of all interface dofs.
pub fn at_dofs(reduced: &Reduced, interfaces: &[Interface], given: &Given) -> Vec<AtDof> {
    labels(interfaces).into_iter().enumerate().map(|(i, label)| at_dof(reduced, i, label, given)).collect()
}

fn at_dof(reduced: &Reduced, i: usize, label: String, given: &Given) -> AtDof {
    let (g, f) = (reduced.residual[(i, i)].max(0.0), reduced.flexibility[(i, i)]);
    // Rounding of the whole is not a residual.
    let g = if g < 1e-12 * f { 0.0 } else { g };
    let compliance = g + given.contact_stiffness.map_or(0.0, f64::recip);
    let mobility: f64 = reduced.rows.row(i).iter().map(|b| b * b).sum();
    AtDof {
        label,
        residual_share: if f > 0.0 { g / f } else { 0.0 },
        residual_stiffness: g.recip(),
        contact_frequency: (mobility / compliance).sqrt() / (2.0 * PI),
    }
}

/// Names of the interface dofs: of a node with one dof its own name.
pub fn labels(interfaces: &[Interface]) -> Vec<String> {
    let of = |own: &Interface| -> Vec<String> {
        match own.dofs[..] {
            [_] => vec![own.name.clone()],
            _ => own.dofs.iter().map(|(direction, _)| own.label(*direction)).collect(),
        }
    };
    interfaces.iter().flat_map(of).collect()
}

/// Line about the damping ratios of a damping matrix and the damping between modes, which is left out.
pub fn damping(of: &Projected) -> String {
    let elastic = of.ratios.iter().copied().filter(|ratio| *ratio > 0.0);
    let [least, most] = [elastic.clone().fold(f64::INFINITY, f64::min), elastic.fold(0.0, f64::max)];
    format!(
        "damping ratios: {:.5} to {:.5}; left out is the damping between different modes, at most {:.3} % of the \
         geometric mean of their own",
        Short(least.min(most)),
        Short(most),
        Short(100.0 * of.left_out)
    )
}

/// Lines about mass, first frequency and sag, which show a wrong unit.
pub fn sizes(model: &Model, reduced: &Reduced) -> Vec<String> {
    let mut said = Vec::new();
    let masses = model.directions().into_iter().map(|direction| {
        let along =
            if direction == Direction::None { String::new() } else { format!(" along {}", direction.name()) };
        format!("{:.6} kg{along}", Short(model.total_mass(direction)))
    });
    said.push(format!("mass that moves: {}", masses.collect::<Vec<_>>().join(", ")));
    if let Some((row, share)) = model.largest_mass() {
        said.push(format!(
            "largest share of a single dof: {:.3} % at {}",
            Short(100.0 * share),
            model.name(row)
        ));
    }
    let first =
        reduced.modes.values.iter().find(|value| **value > 0.0).map(|value| value.sqrt() / (2.0 * PI));
    if let Some(first) = first {
        let elastic = if reduced.rigid > 0 { "first elastic frequency" } else { "first frequency" };
        said.push(format!("{elastic}: {:.6} Hz", Short(first)));
    }
    match reduced.rigid {
        0 => said.extend(sag(model, reduced)),
        count => said.push(format!(
            "rigid-body modes: {count}; the body is not held, so that it has no sag under 1 g"
        )),
    }
    said
}

fn sag(model: &Model, reduced: &Reduced) -> Vec<String> {
    let line = |(direction, shape): (Direction, &nalgebra::DVector<f64>)| {
        let is_length = |row: &usize| !model.dofs.list()[*row].direction.is_rotation();
        let largest =
            (0..shape.len()).filter(is_length).max_by(|a, b| shape[*a].abs().total_cmp(&shape[*b].abs()));
        let row = largest.unwrap_or(0);
        let along =
            if direction == Direction::None { String::new() } else { format!(" along {}", direction.name()) };
        format!(
            "sag under 1 g ({STANDARD_GRAVITY} m/s²){along}: {:.4} m at {}",
            Short(shape[row].abs()),
            model.name(row)
        )
    };
    model.directions().into_iter().zip(&reduced.sag).map(line).collect()
}

/// A number in as few characters as possible.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = f.precision().unwrap_or(4);
        let size = self.0.abs();
        if self.0 == 0.0 || (1e-3..1e6).contains(&size) {
            let before = if size > 0.0 { size.log10().floor() as i32 + 1 } else { 1 };
            let after = (digits as i32 - before).max(0) as usize;
            write!(f, "{:.after$}", self.0)
        } else {
            write!(f, "{:.*e}", digits - 1, self.0)
        }
    }
}

/// The text `OUT.txt`.
pub fn text(model: &Model, reduced: &Reduced, interfaces: &[Interface], given: &Given) -> String {
    let count = reduced.values.len();
    let (dofs, clamped) = (model.dofs.len(), model.clamped.len());
    let mut lines = vec![format!(
        "{dofs} dofs, {clamped} clamped, reduced to {count} coordinates by {}",
        reduced.method.name()
    )];
    lines.extend(model.remarks.iter().cloned());
    lines.extend(sizes(model, reduced));
    lines.push(String::new());
    lines.extend(checks(reduced));
    lines.push(String::new());
    lines.join("\n") + "\n" + &table(reduced, interfaces, given) + &closing(reduced, interfaces)
}

/// Residual norm and count of some modes.
fn counted(what: &str, modes: &Modes) -> [String; 2] {
    let worst = modes.residuals.iter().copied().fold(0.0, f64::max);
    let count = modes.values.len();
    let first = format!("{what}: {count}, largest residual |K x - w² M x|/(|K| |x|) = {worst:.1e}");
    let second = match modes.counted {
        Some((value, count)) => format!(
            "  by inertia of K - s M there are {count} eigenvalues below {:.6} Hz, and {count} were found: no mode is missed",
            Short(value.max(0.0).sqrt() / (2.0 * PI))
        ),
        None => "  these are all modes of the model".into(),
    };
    [first, second]
}

/// Residual norms, counts and frequencies.
fn checks(reduced: &Reduced) -> Vec<String> {
    let mut said = vec!["Modes".to_owned()];
    said.extend(counted("free-interface modes", &reduced.modes));
    if let Some(fixed) = &reduced.fixed {
        said.extend(counted("fixed-interface modes", fixed));
    }
    said.push("  coordinate  frequency/Hz".into());
    let frequencies = reduced.frequencies();
    said.extend(frequencies.iter().enumerate().map(|(k, f)| format!("  {k:10}  {f:.6}")));
    said
}

fn table(reduced: &Reduced, interfaces: &[Interface], given: &Given) -> String {
    if interfaces.is_empty() {
        return "No interface node was named: no error statement.\n".into();
    }
    let highest = reduced.frequencies().last().copied().unwrap_or(0.0);
    let contact = match given.contact_stiffness {
        Some(k) => format!("a contact of {:.4} N/m in series with the residual", Short(k)),
        None => "a rigid contact, as stiff as the residual".into(),
    };
    let mut out = format!(
        "Error statement at the interface\n\
         1  share of the static flexibility that the coordinates lack\n\
         2  stiffness of the lacking flexibility, N/m: contacts much softer than this are right\n\
         3  highest frequency {:.6} Hz over the frequency of {contact}: motions with contacts need it well above 1\n",
        Short(highest)
    );
    let _ = writeln!(out, "  {:20} {:>12} {:>14} {:>12}", "node", "1", "2", "3");
    for own in at_dofs(reduced, interfaces, given) {
        let share = format!("{:.3} %", Short(100.0 * own.residual_share));
        let stiffness = match own.residual_stiffness {
            k if k.is_finite() => format!("{:.5}", Short(k)),
            _ => "none lacks".into(),
        };
        let ratio = highest / own.contact_frequency;
        let ratio = if ratio > 0.0 { format!("{:.4}", Short(ratio)) } else { "-".into() };
        let _ = writeln!(out, "  {:20} {share:>12} {stiffness:>14} {ratio:>12}", own.label);
    }
    match given.load_frequency {
        Some(f) => {
            let ratio = Short(highest / f);
            let _ = writeln!(
                out,
                "highest frequency over the load frequency {f} Hz: {ratio:.4}; expected 2 or more"
            );
        }
        None => out.push_str("highest frequency over the load frequency: not known; give --load-frequency\n"),
    }
    out
}

fn closing(reduced: &Reduced, interfaces: &[Interface]) -> String {
    let mut out = String::new();
    if reduced.method == Method::MacNeal && !interfaces.is_empty() {
        out.push_str(
            "\nMotions use the residual flexibility in the file: contacts, stops, springs and loads at the nodes above have\n\
             the whole static flexibility. It has no mass, so that dashpots, rigid stops with restitution, friction\n\
             elements and links are refused at these nodes; --method rubin keeps it as further modes.\n",
        );
    }
    out.push_str(
        "\nNo bound is claimed for motions with events, which amplify each error of the body as they amplify a\n\
         difference of the start. Compare with a reduction to 1.5 times as many modes.\n",
    );
    out
}
