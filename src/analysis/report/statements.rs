//! The paper's statements of sections 3 to 5, each with a rule by which agreement is decided.
//!
//! The paper's data set is lost (model.md section 8), so agreement means: the same kind of thing at about the same place.

use super::super::attractor::{Class, ZERO_EXPONENT};
use super::super::bifurcation::{Diagram, Point};
use super::super::error::{Error, Result};
use super::super::settings::{Settings, find_group, short};
use super::super::studies::{Modulation, periodic_ranges};
use crate::steady::multiple_scales::{FixedPoint, Manifold, fixed_points};

/// Ends of windows agree when they are this near in f10: the paper gives them to 0.1.
const END: f64 = 0.1;
/// A window of the paper counts as found when this part of its values is regular.
const MOSTLY: f64 = 0.85;
/// A modulation is strong when the least amplitude is under this part of the largest.
const STRONG: f64 = 0.6;

/// How a statement compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is found again.
    Agrees,
    /// Part of it is.
    Partly,
    /// It is not.
    Differs,
}

impl Verdict {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Partly => "agrees in part",
            Self::Differs => "does not agree",
        }
    }

    fn of(agrees: bool, partly: bool) -> Self {
        match (agrees, partly) {
            (true, _) => Self::Agrees,
            (_, true) => Self::Partly,
            _ => Self::Differs,
        }
    }
}

/// A statement and what was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// Where the paper makes it.
    pub place: &'static str,
    /// What it says.
    pub paper: &'static str,
    /// What was found, in numbers.
    pub found: String,
    /// How the two compare.
    pub verdict: Verdict,
}

/// What the statements are compared with.
pub(super) struct Found<'a> {
    pub(super) settings: &'a Settings,
    pub(super) coarse: &'a Diagram,
    pub(super) fine: &'a Diagram,
    pub(super) modulation: Modulation,
    /// The CSV of figure 17.
    pub(super) errors: &'a [u8],
}

pub(super) fn all(found: &Found) -> Result<Vec<Statement>> {
    let mut list = limits(found)?;
    list.push(figure_nine(found)?);
    list.extend(figure_thirteen(found)?);
    list.extend(windows(found));
    list.extend(exponents(found));
    list.extend(route(found));
    list.extend(overlay(found)?);
    list.extend(accuracy(found)?);
    Ok(list)
}

fn limits(found: &Found) -> Result<Vec<Statement>> {
    let m = Manifold::new(found.settings.groups().kappa)?;
    let b = m.c_gmax().is_finite().then(|| {
        let (c, rho) = (m.c_gmax(), m.rho());
        ((c - 1.0) * (c - 1.0) + rho * rho * c * c).sqrt()
    });
    let b = b.unwrap_or(f64::INFINITY);
    let near = |x: f64, y: f64| (x - y).abs() < 0.006;
    Ok(vec![
        Statement {
            place: "section 3.2, figure 3",
            paper: "For κ = 0.75 the geometric limit is C_Gmax ≈ 6.07, where B ≈ 5.1.",
            found: format!("C_Gmax = {:.3}, B = {b:.3}", m.c_gmax()),
            verdict: Verdict::of(near(m.c_gmax(), 6.07) && (b - 5.1).abs() < 0.05, false),
        },
        Statement {
            place: "section 3.3, figure 5",
            paper: "For κ = 0.75, ε = 0.1 the critical values are C_Smin ≈ 0.99 and C_Smax ≈ 1.68.",
            found: format!("C_Smin = {:.4}, C_Smax = {:.4}", m.c_smin(), m.c_smax()),
            verdict: Verdict::of(near(m.c_smin(), 0.99) && near(m.c_smax(), 1.68), false),
        },
    ])
}

fn upper(settings: &Settings, f10: f64) -> Result<Option<FixedPoint>> {
    let groups = settings.vary(find_group("f10")?, f10);
    Ok(fixed_points(&groups)?.map(|r| r.upper).filter(|p| p.c > 0.0))
}

fn figure_nine(found: &Found) -> Result<Statement> {
    let expected = [(0.6, false), (1.2, true), (1.5, true), (2.5, false)];
    let mut words = Vec::new();
    let mut right = 0;
    for (f10, stable) in expected {
        let is = upper(found.settings, f10)?.is_some_and(|p| p.admissibility.all());
        right += usize::from(is == stable);
        words.push(format!("{f10}: {}", if is { "stable" } else { "not stable" }));
    }
    Ok(Statement {
        place: "section 4, figure 9",
        paper: "P₂ is stable for f̂₁₀ = 1.2 and 1.5, unstable for 0.6 and 2.5.",
        found: words.join(", "),
        verdict: Verdict::of(right == 4, right > 1),
    })
}

/// Relative errors of multiple scales at ε = 0.1: B, A1, A2, A3; and at the two smallest ε the slopes.
fn errors(csv: &[u8]) -> Result<Option<([f64; 4], [f64; 4])>> {
    let mut rows: Vec<(f64, String, f64)> = Vec::new();
    for row in csv::Reader::from_reader(csv).records() {
        let row = row.map_err(Error::output("figure 17's table"))?;
        let number = |i: usize| row.get(i).and_then(|t| t.parse().ok()).unwrap_or(f64::NAN);
        rows.push((number(0), row.get(1).unwrap_or_default().into(), number(4)));
    }
    let of = |epsilon: f64, name: &str| {
        rows.iter().find(|r| r.1 == name && (r.0 - epsilon).abs() < 1e-9).map(|r| r.2)
    };
    let four = |epsilon: f64| -> Option<[f64; 4]> {
        Some([of(epsilon, "B")?, of(epsilon, "A1")?, of(epsilon, "A2")?, of(epsilon, "A3")?])
    };
    let (Some(large), Some(a), Some(b)) = (four(0.1), four(0.01), four(0.005)) else { return Ok(None) };
    let slopes = std::array::from_fn(|i| (a[i] / b[i]).abs().log2());
    Ok(Some((large, slopes)))
}

fn figure_thirteen(found: &Found) -> Result<Vec<Statement>> {
    let mut list = Vec::new();
    if let Some((e, _)) = errors(found.errors)? {
        list.push(Statement {
            place: "section 4, figure 13",
            paper: "For the basic set the simulated amplitudes of X₁ and X₃ are very close to the analytical ones.",
            found: format!(
                "multiple scales against simulation: A₁ {:+.0} %, A₃ {:+.0} % (section 5 of the paper itself gives about 20 % for A₁ and up to 8 % for A₃)",
                100.0 * e[1], 100.0 * e[3]
            ),
            verdict: Verdict::of(e[1].abs() < 0.05 && e[3].abs() < 0.05, e[1].abs().min(e[3].abs()) < 0.1),
        });
    }
    let m = &found.modulation;
    let (most, least) = m.box_amplitude;
    let (third_most, third_least) = m.secondary_amplitude;
    let mixed = (0.05..0.95).contains(&m.resonant);
    let strong = least < STRONG * most;
    list.push(Statement {
        place: "section 4, figure 13",
        paper: "For f̂₁₀ = 0.6 W consists of resonant subintervals (two-impact motion) and shorter irregular episodes; the main oscillator's response is strongly modulated.",
        found: format!(
            "{:.0} % of the periods have one impact at each stop; the amplitude of X₁ goes from {least:.3} to {most:.3}",
            100.0 * m.resonant
        ),
        verdict: Verdict::of(mixed && strong && m.resonant > 0.5, mixed && strong),
    });
    let slighter = third_least / third_most > least / most;
    list.push(Statement {
        place: "section 4, figure 13",
        paper: "There the secondary oscillator undergoes a similar beating motion, with a slighter modulation.",
        found: format!(
            "least over largest amplitude: {:.2} for X₃, {:.2} for X₁",
            third_least / third_most, least / most
        ),
        verdict: Verdict::of(slighter && third_least < 0.95 * third_most, slighter),
    });
    Ok(list)
}

fn within<'a>(points: &'a [Option<Point>], from: f64, to: f64) -> impl Iterator<Item = &'a Point> {
    points.iter().flatten().filter(move |p| p.value > from - 1e-9 && p.value < to + 1e-9)
}

fn windows(found: &Found) -> Vec<Statement> {
    let ranges = periodic_ranges(&found.coarse.up);
    let wide: Vec<_> = ranges.iter().filter(|r| r.1 - r.0 >= END).collect();
    let words: Vec<_> = wide.iter().map(|r| format!("{}–{}", short(r.0), short(r.1))).collect();
    let paper = [(0.9, 2.8), (2.9, 3.4), (3.8, 4.0)];
    let matched = paper
        .iter()
        .filter(|(a, b)| wide.iter().any(|r| (r.0 - a).abs() <= END + 1e-9 && (r.1 - b).abs() <= END + 1e-9));
    let matched = matched.count();
    let covered = paper.iter().filter(|(a, b)| {
        let all: Vec<_> = within(&found.coarse.up, *a, *b).collect();
        let regular = all.iter().filter(|p| p.class != Class::Chaotic).count();
        regular as f64 >= MOSTLY * all.len() as f64
    });
    let covered = covered.count();
    let chaotic = |a: f64, b: f64| within(&found.fine.up, a, b).filter(|p| p.class == Class::Chaotic).count();
    let bands = [(0.5, 0.9), (2.8, 2.95), (3.4, 3.8), (4.0, 5.0)];
    let both =
        |a, b| chaotic(a, b) + within(&found.coarse.up, a, b).filter(|p| p.class == Class::Chaotic).count();
    let separated = bands.iter().filter(|(a, b)| both(*a, *b) > 0).count();
    let quasi =
        found.coarse.up.iter().chain(&found.fine.up).flatten().filter(|p| p.class == Class::QuasiPeriodic);
    let quasi: Vec<_> = quasi.map(|p| short(p.value)).collect();
    vec![
        Statement {
            place: "section 4, figure 14a",
            paper: "The motion is mostly periodic for 0.9 ≤ f̂₁₀ ≤ 2.8, 2.9 ≤ f̂₁₀ ≤ 3.4 and 3.8 ≤ f̂₁₀ ≤ 4.",
            found: format!("regular ranges wider than {END}, value rising: {}", words.join(", ")),
            verdict: Verdict::of(matched == 3, matched + covered > 2),
        },
        Statement {
            place: "section 4, figure 14a",
            paper: "The periodic windows are surrounded and separated by regions of chaotic behavior.",
            found: format!("chaos in {separated} of the {} ranges around and between them", bands.len()),
            verdict: Verdict::of(separated == bands.len(), separated > 1),
        },
        Statement {
            place: "section 4, figure 14a",
            paper: "Narrow smears of points at the transition may indicate quasi-periodic motion.",
            found: if quasi.is_empty() {
                "no motion with two zero exponents that does not come nearer to a return".into()
            } else {
                format!("λ₁ ≈ λ₂ ≈ 0 without a period at f̂₁₀ = {}", quasi.join(", "))
            },
            verdict: Verdict::of(!quasi.is_empty(), false),
        },
    ]
}

fn exponents(found: &Found) -> Vec<Statement> {
    let points: Vec<&Point> = found.coarse.up.iter().chain(&found.fine.up).flatten().collect();
    let of = |p: &Point, i: usize| p.spectrum.as_ref().map_or(f64::NAN, |s| s.exponents[i]);
    let share = |list: &[&Point], holds: &dyn Fn(&Point) -> bool| {
        let count = list.iter().filter(|p| holds(p)).count();
        (count, list.len(), count as f64 / list.len().max(1) as f64)
    };
    let pick = |chaotic: bool| -> Vec<&Point> {
        points.iter().filter(|p| (p.class == Class::Chaotic) == chaotic).copied().collect()
    };
    let (regular, chaotic) = (pick(false), pick(true));
    let zero = share(&regular, &|p| of(p, 0).abs() <= ZERO_EXPONENT);
    let second = share(&chaotic, &|p| of(p, 1).abs() <= ZERO_EXPONENT);
    let third = points.iter().map(|p| of(p, 2)).fold(f64::NEG_INFINITY, f64::max);
    let negative = share(&points, &|p| of(p, 2) < 0.0);
    let double = regular.iter().filter(|p| of(p, 1) > -ZERO_EXPONENT);
    let double: Vec<_> = double.map(|p| short(p.value)).collect();
    vec![
        Statement {
            place: "section 4, figure 14b",
            paper: "The maximal exponent is zero in the periodic windows.",
            found: format!("|λ₁| ≤ {ZERO_EXPONENT} at {} of {} values that are not chaotic", zero.0, zero.1),
            verdict: Verdict::of(zero.2 > 0.98, zero.2 > 0.8),
        },
        Statement {
            place: "section 4, figure 14b",
            paper: "In chaos λ₁ is positive and λ₂ = 0.",
            found: format!("|λ₂| ≤ {ZERO_EXPONENT} at {} of {} chaotic values", second.0, second.1),
            verdict: Verdict::of(second.2 > 0.98, second.2 > 0.8),
        },
        Statement {
            place: "section 4, figure 14b",
            paper: "The third exponent is always negative.",
            found: format!("negative at {} of {} values; the largest is {third:.5}", negative.0, negative.1),
            verdict: Verdict::of(negative.0 == negative.1, negative.2 > 0.95),
        },
        Statement {
            place: "section 4, figure 14b",
            paper: "At some single points λ₁ = λ₂ = 0.",
            found: format!(
                "λ₁ ≈ λ₂ ≈ 0 without chaos at f̂₁₀ = {}",
                if double.is_empty() { "none".into() } else { double.join(", ") }
            ),
            verdict: Verdict::of(!double.is_empty(), false),
        },
    ]
}

/// Classes met between two values, in order, each with its first value.
fn order(points: &[Option<Point>], from: f64, to: f64) -> Vec<(f64, Class)> {
    let mut met: Vec<(f64, Class)> = Vec::new();
    for p in within(points, from, to) {
        if met.last().is_none_or(|l| l.1 != p.class) {
            met.push((p.value, p.class));
        }
    }
    met
}

fn route(found: &Found) -> Vec<Statement> {
    let met = order(&found.fine.up, 2.0, 2.95);
    let words: Vec<_> = met.iter().map(|m| format!("{} from {}", m.1.name(), short(m.0))).collect();
    let has = |n: u32| met.iter().any(|m| m.1 == Class::Periodic(n));
    let sequence = [1, 2, 4].iter().all(|n| has(*n));
    let band: Vec<_> = Diagram::windows(&found.fine.up)
        .into_iter()
        .filter(|w| w.2 == Class::Chaotic && w.0 > 2.0 && w.0 < 2.95)
        .map(|w| (w.0, w.1))
        .collect();
    let words_of = |band: &[(f64, f64)]| {
        let list = band
            .iter()
            .map(|b| if b.0 == b.1 { short(b.0) } else { format!("{}–{}", short(b.0), short(b.1)) });
        format!("chaotic at {}", list.collect::<Vec<_>>().join(", "))
    };
    let share = |from: f64, to: f64| {
        let periodic: Vec<_> = within(&found.fine.up, from, to).filter(|p| p.class.is_periodic()).collect();
        let two_or_four =
            periodic.iter().filter(|p| [Class::Periodic(2), Class::Periodic(4)].contains(&p.class));
        two_or_four.count() as f64 / periodic.len().max(1) as f64
    };
    let (first, second) = (share(2.9, 3.4), share(3.8, 4.0));
    vec![
        Statement {
            place: "section 4, table 2",
            paper: "With growing f̂₁₀ the symmetric two-impact motion loses its stability and a sequence of period doublings follows.",
            found: words.join(", "),
            verdict: Verdict::of(sequence, has(2)),
        },
        Statement {
            place: "section 4, table 2",
            paper: "Next, a relatively narrow range of chaotic motion arises.",
            found: if band.is_empty() { "no chaos before 2.95".into() } else { words_of(&band) },
            verdict: Verdict::of(!band.is_empty() && band.iter().all(|b| b.1 - b.0 < 0.15), !band.is_empty()),
        },
        Statement {
            place: "section 4, table 2",
            paper: "Within the next two periodic windows 2T- and 4T-periodic motions predominate.",
            found: format!(
                "{:.0} % of the periodic values in 2.9–3.4 and {:.0} % in 3.8–4 are 2T or 4T",
                100.0 * first,
                100.0 * second
            ),
            verdict: Verdict::of(first > 0.5 && second > 0.5, first > 0.5 || second > 0.5),
        },
    ]
}

fn overlay(found: &Found) -> Result<Vec<Statement>> {
    let mut gaps = Vec::new();
    let symmetric = |p: &&Point| p.class == Class::Periodic(1) && p.attractor.is_symmetric();
    for p in within(&found.coarse.up, 0.9, 2.3).filter(symmetric) {
        let Some(theory) = upper(found.settings, p.value)?.filter(|t| t.admissibility.all()) else {
            continue;
        };
        let top = p.maxima.iter().map(|m| m.0).fold(0.0, f64::max);
        gaps.push(theory.a2() / top - 1.0);
    }
    let mean = gaps.iter().sum::<f64>() / gaps.len().max(1) as f64;
    let below = gaps.iter().filter(|g| **g < 0.0).count();
    let class = |value: f64| {
        let near = |a: &&Point, b: &&Point| (a.value - value).abs().total_cmp(&(b.value - value).abs());
        found.coarse.up.iter().flatten().min_by(near).map(|p| p.class)
    };
    let ends = [1.0, 2.1].map(class);
    let single = ends.iter().filter(|c| **c == Some(Class::Periodic(1))).count();
    let name = |c: &Option<Class>| c.map_or("nothing".into(), Class::name);
    Ok(vec![
        Statement {
            place: "section 4, figure 16",
            paper: "The analytical amplitude A₂ agrees well with the maxima of X₂ and is slightly lower.",
            found: format!(
                "lower at {below} of {} values of symmetric 1T motion, by {:.1} % in the mean",
                gaps.len(),
                -100.0 * mean
            ),
            verdict: Verdict::of(
                !gaps.is_empty() && below == gaps.len() && mean.abs() < 0.1,
                mean.abs() < 0.1,
            ),
        },
        Statement {
            place: "section 4, figure 16",
            paper: "At f̂₁₀ ≈ 1 and 2.1, the ends of the analytical range, the motion is mostly 1T.",
            found: format!("at 1: {}, at 2.1: {}", name(&ends[0]), name(&ends[1])),
            verdict: Verdict::of(single == 2, single == 1),
        },
    ])
}

fn accuracy(found: &Found) -> Result<Vec<Statement>> {
    let Some((large, slopes)) = errors(found.errors)? else { return Ok(Vec::new()) };
    let percent = large.map(|e| 100.0 * e.abs());
    Ok(vec![
        Statement {
            place: "section 5, figure 17",
            paper: "At ε = 0.1 the errors of B and A₁ are about 20 %, those of A₂ and A₃ at most 8 %.",
            found: format!(
                "B {:.1} %, A₁ {:.1} %, A₂ {:.1} %, A₃ {:.1} %",
                percent[0], percent[1], percent[2], percent[3]
            ),
            verdict: Verdict::of(
                percent[..2].iter().all(|p| (15.0..26.0).contains(p))
                    && percent[2..].iter().all(|p| *p <= 8.0),
                percent[2..].iter().all(|p| *p <= 10.0),
            ),
        },
        Statement {
            place: "section 5, figure 17",
            paper: "The errors grow linearly with ε.",
            found: format!(
                "slopes in the logarithms between ε = 0.005 and 0.01: {}",
                slopes.map(|s| format!("{s:.3}")).join(", ")
            ),
            verdict: Verdict::of(slopes.iter().all(|s| (s - 1.0).abs() < 0.05), false),
        },
    ])
}
