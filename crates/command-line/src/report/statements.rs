//! The paper's statements of sections 3 to 5, each with a rule that decides agreement.
//!
//! The parameters are not the paper's own data set (docs/theory.md, end of section 4), so
//! agreement means: the same kind of motion at about the same place.

use super::analytical::{accuracy, errors, figure_nine, limits, upper};
use super::statement::{Findings, Statement, Verdict};
use crate::Result;
use crate::studies::paper::{doublings_in_words, end_in_words, periodic_ranges};
use vibro_orbits::paper::{Doubling, Label, doubling_sequences};
use vibro_studies::paper::bifurcation::{Diagram, SweepPoint};
use vibro_studies::paper::short;
use vibro_studies::{MotionClass, ZERO_EXPONENT};

/// Tolerance of the ends of windows in f10: the paper gives them to 0.1.
const END: f64 = 0.1;
/// A window of the paper counts as found if at least this share of its values is regular.
const MOSTLY: f64 = 0.85;
/// Ratio of smallest to largest amplitude below which a modulation is strong.
const STRONG: f64 = 0.6;

pub(super) fn all(found: &Findings) -> Result<Vec<Statement>> {
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

fn figure_thirteen(found: &Findings) -> Result<Vec<Statement>> {
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

fn within(points: &[Option<SweepPoint>], from: f64, to: f64) -> impl Iterator<Item = &SweepPoint> {
    points.iter().flatten().filter(move |p| p.value > from - 1e-9 && p.value < to + 1e-9)
}

/// Values of both sweeps at which `holds` is true, ascending.
fn listed(found: &Findings, holds: impl Fn(&SweepPoint) -> bool) -> Vec<String> {
    let all = found.coarse.up.iter().chain(&found.fine.up).flatten().filter(|p| holds(p));
    let mut values: Vec<f64> = all.map(|p| p.value).collect();
    values.sort_by(f64::total_cmp);
    let mut words: Vec<String> = values.into_iter().map(short).collect();
    words.dedup();
    words
}

/// Whether the block hits the stops: at small forces a motion without impacts coexists with the
/// paper's motions.
fn meets(p: &SweepPoint) -> bool {
    p.attractor.impacts.iter().sum::<f64>() > 0.0
}

/// Windows of periodic motion in the paper's figure 14a.
const WINDOWS: [(f64, f64); 3] = [(0.9, 2.8), (2.9, 3.4), (3.8, 4.0)];
/// Ranges of f10 around and between them.
const CHAOTIC_RANGES: [(f64, f64); 4] = [(0.5, 0.9), (2.8, 2.95), (3.4, 3.8), (4.0, 5.0)];

fn windows(found: &Findings) -> Vec<Statement> {
    vec![periodic_windows(found), chaos_around(found), quasi_periodic(found)]
}

fn periodic_windows(found: &Findings) -> Statement {
    let points = &found.coarse.up;
    let mut wide = periodic_ranges(points);
    wide.retain(|r| r.1 - r.0 >= END);
    let rising = ranges_in_words(found, 0, &wide);
    let mut other = periodic_ranges(&found.coarse.down);
    other.retain(|r| r.1 - r.0 >= END);
    let falling = ranges_in_words(found, 1, &other);
    let mut quiet = points.iter().flatten().filter(|p| !meets(p)).map(|p| p.value);
    let still = match (quiet.next(), quiet.next_back()) {
        (Some(first), Some(last)) => {
            format!("; from {} to {} a motion without impacts, which coexists", short(first), short(last))
        }
        _ => String::new(),
    };
    let near = |x: f64, y: f64| (x - y).abs() <= END + 1e-9;
    let matched = WINDOWS.iter().filter(|w| wide.iter().any(|r| near(r.0, w.0) && near(r.1, w.1))).count();
    let covered = WINDOWS.iter().filter(|w| {
        let all: Vec<_> = within(points, w.0, w.1).collect();
        let regular = all.iter().filter(|p| p.class != MotionClass::Chaotic).count();
        regular as f64 >= MOSTLY * all.len() as f64
    });
    Statement {
        place: "section 4, figure 14a",
        paper: "The motion is mostly periodic for 0.9 ≤ f̂₁₀ ≤ 2.8, 2.9 ≤ f̂₁₀ ≤ 3.4 and 3.8 ≤ f̂₁₀ ≤ 4.",
        found: format!(
            "regular ranges wider than {END}, value rising: {rising}{still}; value falling: {falling}. In brackets the located \
             ends of the stable branches on which their first and last periodic motions lie"
        ),
        verdict: Verdict::of(matched == WINDOWS.len(), matched + covered.count() >= WINDOWS.len()),
    }
}

/// Ranges of values with the located ends of their stable orbits, in words.
fn ranges_in_words(found: &Findings, direction: usize, ranges: &[(f64, f64)]) -> String {
    let words = ranges.iter().map(|range| {
        let located = found.orbits.and_then(|orbits| {
            let (from, to) = orbits.bounds(direction, *range)?;
            let [from, to] = [from, to].map(|end| end_in_words(found.set, orbits.family.span().name, end));
            Some(format!(" ({from} – {to})"))
        });
        format!("{}–{}{}", short(range.0), short(range.1), located.unwrap_or_default())
    });
    words.collect::<Vec<_>>().join(", ")
}

fn chaos_around(found: &Findings) -> Statement {
    let chaotic = |points: &[Option<SweepPoint>], range: &(f64, f64)| {
        within(points, range.0, range.1).any(|p| p.class == MotionClass::Chaotic)
    };
    let has_chaos = |range: &&(f64, f64)| chaotic(&found.fine.up, range) || chaotic(&found.coarse.up, range);
    let separated = CHAOTIC_RANGES.iter().filter(has_chaos).count();
    Statement {
        place: "section 4, figure 14a",
        paper: "The periodic windows are surrounded and separated by regions of chaotic behavior.",
        found: format!("chaos in {separated} of the {} ranges around and between them", CHAOTIC_RANGES.len()),
        verdict: Verdict::of(separated == CHAOTIC_RANGES.len(), separated > 1),
    }
}

fn quasi_periodic(found: &Findings) -> Statement {
    let is_quasi = |p: &SweepPoint| p.class == MotionClass::QuasiPeriodic;
    // A torus exists on a range of values. A single value is a bifurcation.
    let range = [&found.coarse.up, &found.fine.up].into_iter().any(|points| {
        let quasi: Vec<bool> = points.iter().flatten().map(is_quasi).collect();
        quasi.windows(2).any(|pair| pair[0] && pair[1])
    });
    let values = listed(found, is_quasi);
    Statement {
        place: "section 4, figure 14a",
        paper: "Narrow smears of points at the transition may indicate quasi-periodic motion.",
        found: match (values.is_empty(), range) {
            (true, _) => "no motion with two zero exponents that does not come nearer to a return".into(),
            (_, true) => format!("λ₁ ≈ λ₂ ≈ 0 without a period at f̂₁₀ = {}", values.join(", ")),
            _ => format!(
                "λ₁ ≈ λ₂ ≈ 0 without a period at f̂₁₀ = {}: single values, so bifurcations rather than tori",
                values.join(", ")
            ),
        },
        verdict: Verdict::of(range, !values.is_empty()),
    }
}

fn exponents(found: &Findings) -> Vec<Statement> {
    let points: Vec<&SweepPoint> = found.coarse.up.iter().chain(&found.fine.up).flatten().collect();
    let of = |p: &SweepPoint, i: usize| p.spectrum.as_ref().map_or(f64::NAN, |s| s.exponents[i]);
    let share = |list: &[&SweepPoint], holds: &dyn Fn(&SweepPoint) -> bool| {
        let count = list.iter().filter(|p| holds(p)).count();
        (count, list.len(), count as f64 / list.len().max(1) as f64)
    };
    let pick = |chaotic: bool| -> Vec<&SweepPoint> {
        points.iter().filter(|p| (p.class == MotionClass::Chaotic) == chaotic).copied().collect()
    };
    let (regular, chaotic) = (pick(false), pick(true));
    let zero = share(&regular, &|p| of(p, 0).abs() <= ZERO_EXPONENT);
    let second = share(&chaotic, &|p| of(p, 1).abs() <= ZERO_EXPONENT);
    let third = points.iter().map(|p| of(p, 2)).fold(f64::NEG_INFINITY, f64::max);
    let negative = share(&points, &|p| of(p, 2) < 0.0);
    let double = listed(found, |p| p.class != MotionClass::Chaotic && of(p, 1) > -ZERO_EXPONENT && meets(p));
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

/// Classes between two values in order, each with its first value.
fn order(points: &[Option<SweepPoint>], from: f64, to: f64) -> Vec<(f64, MotionClass)> {
    let mut met: Vec<(f64, MotionClass)> = Vec::new();
    for p in within(points, from, to) {
        if met.last().is_none_or(|l| l.1 != p.class) {
            met.push((p.value, p.class));
        }
    }
    met
}

/// The period doublings at the end of the symmetric motion with two impacts per period.
fn doublings(found: &Findings) -> Vec<Doubling> {
    let Some(orbits) = found.orbits else { return Vec::new() };
    let branches = &orbits.tree.branches;
    let of_symmetric = |s: &Vec<Doubling>| {
        let first = &s[0];
        first.label == Label::BranchPoint && branches[first.branch].word().len() == 1
    };
    doubling_sequences(branches).into_iter().find(of_symmetric).unwrap_or_default()
}

fn route(found: &Findings) -> Vec<Statement> {
    let met = order(&found.fine.up, 2.0, 2.95);
    let words: Vec<_> = met.iter().map(|m| format!("{} from {}", m.1.name(), short(m.0))).collect();
    let has = |n: u32| met.iter().any(|m| m.1 == MotionClass::Periodic(n));
    let located = doublings(found);
    let doubled = |n: u32| located.iter().any(|d| d.label == Label::PeriodDoubling && d.period == n);
    let sequence = [1, 2, 4].iter().all(|n| has(*n)) || (doubled(1) && doubled(2));
    let places = found.orbits.filter(|_| !located.is_empty()).map_or(String::new(), |orbits| {
        let told = doublings_in_words(found.set, orbits.family.span().name, &located);
        format!(". Located on the branches: {told}")
    });
    let band: Vec<_> = Diagram::windows(&found.fine.up)
        .into_iter()
        .filter(|w| w.class == MotionClass::Chaotic && w.from > 2.0 && w.from < 2.95)
        .map(|w| (w.from, w.to))
        .collect();
    let words_of = |band: &[(f64, f64)]| {
        let list = band
            .iter()
            .map(|b| if b.0 == b.1 { short(b.0) } else { format!("{}–{}", short(b.0), short(b.1)) });
        format!("chaotic at {}", list.collect::<Vec<_>>().join(", "))
    };
    let share = |from: f64, to: f64| {
        let periodic: Vec<_> = within(&found.fine.up, from, to).filter(|p| p.class.is_periodic()).collect();
        let two_or_four = periodic
            .iter()
            .filter(|p| [MotionClass::Periodic(2), MotionClass::Periodic(4)].contains(&p.class));
        two_or_four.count() as f64 / periodic.len().max(1) as f64
    };
    let (first, second) = (share(2.9, 3.4), share(3.8, 4.0));
    vec![
        Statement {
            place: "section 4, table 2",
            paper: "With growing f̂₁₀ the symmetric two-impact motion loses its stability and a sequence of period doublings follows.",
            found: words.join(", ") + &places,
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

fn overlay(found: &Findings) -> Result<Vec<Statement>> {
    let mut gaps = Vec::new();
    let symmetric =
        |p: &&SweepPoint| p.class == MotionClass::Periodic(1) && p.attractor.is_symmetric() && meets(p);
    for p in within(&found.coarse.up, 0.9, 2.3).filter(symmetric) {
        let Some(theory) = upper(found.set, p.value)?.filter(|t| t.admissibility.all()) else {
            continue;
        };
        let top = p.maxima.iter().map(|m| m.0).fold(0.0, f64::max);
        gaps.push(theory.a2() / top - 1.0);
    }
    let mean = gaps.iter().sum::<f64>() / gaps.len().max(1) as f64;
    let below = gaps.iter().filter(|g| **g < 0.0).count();
    let class = |value: f64| found.coarse.nearest(value).map(|p| p.class);
    let ends = [1.0, 2.1].map(class);
    let single = ends.iter().filter(|c| **c == Some(MotionClass::Periodic(1))).count();
    let name = |c: &Option<MotionClass>| c.map_or("nothing".into(), MotionClass::name);
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
