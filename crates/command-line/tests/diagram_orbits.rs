//! Runs the real `vibro bifurcation --orbits`: the branches over a diagram compared with the
//! diagram's simulated motions.

#[path = "common/mod.rs"]
mod command;

use command::{drawn, folder, refused, table};
use std::collections::HashMap;

type Row = HashMap<String, String>;

/// Tolerance for the distance of a maximum from the chords of a curve, units of L. The points of a
/// branch are up to 0.05 apart in phases (rad) and parameter.
const CHORD: f64 = 3e-3;
/// Tolerance for a period doubling in the table, units of f10. It is located to rounding and
/// written with 15 digits.
const LOCATION: f64 = 1e-11;

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} of {row:?}"))
}

/// Maxima of X2 on the stable curves with the given period, interpolated at a value of f10.
fn stable_maxima(curves: &[Row], period: &str, value: f64) -> Vec<f64> {
    let pieces = curves.windows(2).filter(|pair| pair[0]["curve"] == pair[1]["curve"]);
    let stable = pieces.filter(|pair| pair[0]["stable"] == "true" && pair[0]["period"] == period);
    let crossed = stable.filter_map(|pair| {
        let [a, b] = [0, 1].map(|i| (number(&pair[i], "f10"), number(&pair[i], "X2_maximum")));
        let part = (value - a.0) / (b.0 - a.0);
        (0.0..=1.0).contains(&part).then_some(a.1 + part * (b.1 - a.1))
    });
    crossed.collect()
}

#[test]
fn invariant_every_settled_periodic_row_lies_on_a_drawn_stable_branch() {
    let out = folder("diagram-orbits");
    // No value of f10 is closer than 0.006 to a period doubling, so that transients decay. The
    // last values lie on another family of orbits.
    let range = ["--range", "f10=2.2:2.56", "--resolution", "19", "--discard", "400", "--keep", "100"];
    let said = drawn(&out, &[&["bifurcation", "--orbits"][..], &range].concat());
    assert!(
        said.contains("periodic rows of both directions whose transient has ended lie on a stable branch")
    );
    assert!(said.contains("PD of 1T at 2.3730753708, PD of 2T at 2.4930216604"), "{said}");
    assert!(out.join("bifurcation.png").exists() && out.join("bifurcation-orbits.png").exists());
    let (curves, rows) = (table(&out, "bifurcation-orbits.csv"), table(&out, "bifurcation-orbits-rows.csv"));
    let (points, maxima) = (table(&out, "bifurcation-points.csv"), table(&out, "bifurcation.csv"));
    let periodic: Vec<&Row> = points.iter().filter(|row| !row["period"].is_empty()).collect();
    assert!(periodic.len() > 30 && rows.len() == periodic.len());
    for (point, row) in periodic.iter().zip(&rows) {
        assert_eq!(row["not_covered"], "", "{row:?}");
        let (value, direction) = (number(point, "f10"), &point["direction"]);
        let drawn = stable_maxima(&curves, &point["period"], value);
        let simulated = maxima.iter().filter(|m| number(m, "f10") == value && m["direction"] == *direction);
        for maximum in simulated.map(|m| number(m, "X2_maximum")) {
            let apart = drawn.iter().map(|x| (x - maximum).abs()).fold(f64::INFINITY, f64::min);
            assert!(apart < CHORD, "{value} {direction}: {maximum} is {apart} from every curve");
        }
    }
    // Each 2T window of the grid lies within a stable range that begins less than one grid step
    // before the window.
    let step = 0.02;
    for window in table(&out, "bifurcation-orbits-windows.csv").iter().filter(|w| w["class"] == "2T") {
        let [from, to, first, last] =
            ["stable_from", "stable_to", "f10_from", "f10_to"].map(|c| number(window, c));
        assert!(from <= first && last <= to && first - from < step, "{window:?}");
        assert!((from - 2.373_075_370_806_15).abs() < LOCATION && window["label_from"] == "PD", "{window:?}");
    }
}

#[test]
fn invariant_settled_rows_of_a_block_without_a_spring_lie_on_stable_branches() {
    let out = folder("diagram-orbits-free");
    // The symmetric motion, and the next one, which has lost its symmetry.
    let range = [
        "--range",
        "f10=1.5:2.3",
        "--resolution",
        "9",
        "--discard",
        "400",
        "--keep",
        "20",
        "--set",
        "alpha23=0",
    ];
    drawn(&out, &[&["bifurcation", "--orbits"][..], &range].concat());
    let rows = table(&out, "bifurcation-orbits-rows.csv");
    let covered = rows.iter().filter(|row| row["not_covered"].is_empty()).count();
    assert!(rows.len() >= 9 && covered * 10 >= rows.len() * 9, "{covered} of {}", rows.len());
}

#[test]
fn what_orbits_cannot_vary_is_refused_by_name_before_work_begins() {
    for (arguments, words) in [
        (&["bifurcation", "--orbits", "--range", "kappa=0.5:1.5"][..], "kappa = 1.5"),
        (&["lyapunov", "--orbits", "--range", "kappa=0.5:1.5"], "kappa = 1.5"),
    ] {
        let (code, message) = refused(arguments);
        assert!(code == 2 && message.contains(words), "{arguments:?}: {code} {message}");
    }
}
