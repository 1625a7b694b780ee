//! What a settled motion is: its period, its impacts, a fingerprint by which it is known again, its class.
//!
//! The system is symmetric: with x(t), also -x(t + T/2) is a motion. Attractors that are each other's mirror image are told
//! from different ones.

use super::error::Result;
use super::lyapunov::Spectrum;
use super::section::{Section, section};
use serde::{Deserialize, Serialize};
use vibro_impact::simulator::{Event, Simulator};

/// Drive periods over which a motion is observed.
pub const OBSERVED: u32 = 128;
/// The longest period told from none: four of them fit into what is observed.
pub const LONGEST: u32 = 32;
/// A state returns when it comes this near (units of L and L ω10). What is left of a transient after hundreds of periods is
/// less, except next to a bifurcation.
pub const RETURN: f64 = 1e-5;
/// Points of one attractor, reached in different ways, agree to this; those of two differ by more.
const SAME: f64 = 1e-3;
/// Statistics of one aperiodic attractor over what is observed agree to this part.
const STATISTICS: f64 = 0.15;
/// An exponent (per 1/ω10) over this is positive, under its negative is negative: over 1500 periods the zero ones keep to
/// a few 1e-4.
pub const ZERO_EXPONENT: f64 = 1e-3;

/// One drive period of an observed motion.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stroke {
    section: Section,
    /// The order of its impacts, as a number.
    pattern: u64,
    /// Impacts at the upper and at the lower stop.
    impacts: [u32; 2],
    /// Whether the block rests.
    rests: bool,
}

/// A settled motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Attractor {
    /// Its period in drive periods, where it has one up to [`LONGEST`].
    pub period: Option<u32>,
    /// Whether its states come nearer to their return all the time: a transient that has not died out.
    pub approaching: bool,
    /// Impacts per drive period at the upper and at the lower stop.
    pub impacts: [f64; 2],
    /// Whether the block rests at a stop in the course of it.
    pub rests: bool,
    /// States at whole drive periods, one for each period (one in all where it has none).
    pub sections: Vec<Section>,
    /// The same of its mirror image.
    pub mirrored: Vec<Section>,
    /// Root mean squares of x1, x2, x3 at whole and half drive periods, units of L.
    pub sizes: [f64; 3],
}

/// What two attractors are to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// The same.
    Same,
    /// Mirror images.
    Mirror,
    /// Neither.
    Different,
}

/// The kind of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Class {
    /// Returns after so many drive periods.
    Periodic(u32),
    /// Never returns, two exponents are zero.
    QuasiPeriodic,
    /// λ1 > 0.
    Chaotic,
    /// Has no period up to [`LONGEST`], and without exponents no more is known.
    Aperiodic,
    /// Comes nearer to its return from period to period, or has negative exponents, so it is periodic, but it has not yet
    /// come to its period or has one over [`LONGEST`].
    Settling,
}

impl Class {
    /// In a word, for tables: `1T`, `2T`, `quasi-periodic`, `chaotic`.
    pub fn name(self) -> String {
        match self {
            Self::Periodic(n) => format!("{n}T"),
            Self::QuasiPeriodic => "quasi-periodic".into(),
            Self::Chaotic => "chaotic".into(),
            Self::Aperiodic => "aperiodic".into(),
            Self::Settling => "periodic, settling".into(),
        }
    }

    /// Whether it is periodic.
    pub fn is_periodic(self) -> bool {
        matches!(self, Self::Periodic(_) | Self::Settling)
    }

    /// The class of an attractor, with its spectrum in units of ω10 where there is one.
    pub fn of(attractor: &Attractor, spectrum: Option<&Spectrum>) -> Self {
        match (attractor.period, spectrum) {
            (Some(n), _) => Self::Periodic(n),
            (None, None) => Self::Aperiodic,
            (None, Some(s)) => {
                let [first, second, ..] = s.exponents;
                if first > ZERO_EXPONENT {
                    Self::Chaotic
                } else if second > -ZERO_EXPONENT && !attractor.approaching {
                    Self::QuasiPeriodic
                } else {
                    Self::Settling
                }
            }
        }
    }
}

/// Observes a settled motion over [`OBSERVED`] periods from a whole drive period on.
///
/// # Errors
/// As [`Simulator::advance_until`].
pub fn observe(simulator: &mut Simulator) -> Result<Attractor> {
    let p = *simulator.parameters();
    let (begin, length) = (simulator.time(), p.period());
    let section = |s: &Simulator| section(&p, &s.state());
    let (mut strokes, mut halves) = (Vec::new(), Vec::new());
    let (mut impacts, mut rests, mut pattern) = ([0u32; 2], false, 1u64);
    for i in 1..=2 * OBSERVED {
        simulator.advance_observed(begin + 0.5 * f64::from(i) * length, &mut |event| match *event {
            Event::Impact { side, .. } => {
                let upper = side > 0;
                impacts[usize::from(!upper)] += 1;
                pattern = pattern.wrapping_mul(3).wrapping_add(1 + u64::from(upper));
            }
            _ => rests = true,
        })?;
        if i % 2 == 1 {
            halves.push(section(simulator).map(|x| -x));
        } else {
            strokes.push(Stroke { section: section(simulator), pattern, impacts, rests });
            (impacts, rests, pattern) = ([0; 2], false, 1);
        }
    }
    let period = period(&strokes);
    let kept = period.unwrap_or(1) as usize;
    // A transient that died out under observation does not count.
    let settled = period.unwrap_or(OBSERVED);
    let last = strokes.len() - settled as usize;
    let mut sizes = [0.0; 3];
    for section in strokes[last..].iter().map(|s| &s.section).chain(&halves[last..]) {
        for (size, x) in sizes.iter_mut().zip(section) {
            *size += x * x / f64::from(2 * settled);
        }
    }
    let counts = [0, 1].map(|side| strokes[last..].iter().map(|s| s.impacts[side]).sum::<u32>());
    let rests = strokes[last..].iter().any(|s| s.rests);
    // Without impacts the flow is linear; where every part of it is damped, which here needs the coupling, it has one limit.
    let damped = [p.box_damping, p.secondary_damping, p.coupling_stiffness].iter().all(|c| *c > 0.0);
    let dies_out = damped && counts == [0; 2] && !rests;
    Ok(Attractor {
        period,
        approaching: period.is_none() && (dies_out || approaches(&strokes)),
        impacts: counts.map(|c| f64::from(c) / f64::from(settled)),
        rests,
        sections: strokes[strokes.len() - kept..].iter().map(|s| s.section).collect(),
        mirrored: halves[halves.len() - kept..].to_vec(),
        sizes: sizes.map(f64::sqrt),
    })
}

/// The least n after which states return and the order of impacts repeats, four times over.
fn period(strokes: &[Stroke]) -> Option<u32> {
    (1..=LONGEST).find(|&n| {
        let lag = n as usize;
        let last = &strokes[strokes.len() - 4 * lag..];
        last[lag..]
            .iter()
            .zip(last)
            .all(|(a, b)| a.pattern == b.pattern && distance(&a.section, &b.section) < RETURN)
    })
}

/// Whether for some lag the largest distance from return falls from one eighth of the record to the next.
fn approaches(strokes: &[Stroke]) -> bool {
    const EIGHTHS: usize = 8;
    (1..=LONGEST as usize).any(|lag| {
        let gaps: Vec<f64> =
            strokes[lag..].iter().zip(strokes).map(|(a, b)| distance(&a.section, &b.section)).collect();
        let most = gaps.chunks(gaps.len().div_ceil(EIGHTHS)).map(|c| c.iter().copied().fold(0.0, f64::max));
        most.collect::<Vec<_>>().windows(2).all(|w| w[1] < w[0])
    })
}

/// The largest difference of two sections.
fn distance(a: &Section, b: &Section) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

impl Attractor {
    /// Whether it passes through a state at a whole drive period.
    pub fn passes(&self, state: &Section) -> bool {
        self.sections.iter().any(|own| distance(own, state) < SAME)
    }

    /// Whether the block never touches a stop.
    pub fn is_free(&self) -> bool {
        self.impacts == [0.0; 2] && !self.rests
    }

    /// What another attractor is to this one. Aperiodic ones are compared by their statistics; those without impacts are
    /// one, for the flow without impacts is linear.
    pub fn relation(&self, other: &Self) -> Relation {
        if self.is_free() && other.is_free() {
            return Relation::Same;
        }
        if self.period != other.period {
            return Relation::Different;
        }
        if self.period.is_none() {
            let alike = |a: f64, b: f64| (a - b).abs() <= STATISTICS * a.abs().max(b.abs());
            let [a, b] = [self, other].map(|x| x.impacts[0] + x.impacts[1]);
            let sizes = self.sizes.iter().zip(&other.sizes).all(|(a, b)| alike(*a, *b));
            return if sizes && alike(a, b) { Relation::Same } else { Relation::Different };
        }
        let covers =
            |points: &[Section]| points.iter().all(|p| self.sections.iter().any(|q| distance(p, q) < SAME));
        if covers(&other.sections) {
            Relation::Same
        } else if covers(&other.mirrored) {
            Relation::Mirror
        } else {
            Relation::Different
        }
    }

    /// Whether it is its own mirror image.
    pub fn is_symmetric(&self) -> bool {
        let image = Self { sections: self.mirrored.clone(), mirrored: self.sections.clone(), ..self.clone() };
        self.relation(&image) == Relation::Same
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::settled;
    use crate::section::kicked;
    use vibro_impact::parameters::{Groups, Scales};

    /// Strokes of a made-up motion.
    fn strokes(section: impl Fn(f64) -> f64, pattern: impl Fn(u64) -> u64) -> Vec<Stroke> {
        (0..u64::from(OBSERVED))
            .map(|n| Stroke {
                section: [section(n as f64); 6],
                pattern: pattern(n),
                impacts: [1; 2],
                rests: false,
            })
            .collect()
    }

    #[test]
    fn closed_form_periods_of_made_up_motions() {
        use std::f64::consts::TAU;
        assert_eq!(period(&strokes(|_| 0.3, |_| 1)), Some(1));
        assert_eq!(period(&strokes(|n| (TAU * n / 4.0).cos(), |_| 1)), Some(4));
        // The states alone say 1, the order of impacts says 3.
        assert_eq!(period(&strokes(|_| 0.3, |n| n % 3)), Some(3));
        assert_eq!(period(&strokes(|n| (TAU * n / f64::from(LONGEST)).cos(), |_| 1)), Some(LONGEST));
        let torus = strokes(|n| (TAU * n * 0.381_966_011).cos(), |_| 1);
        assert_eq!((period(&torus), approaches(&torus)), (None, false));
        // A transient of half a per cent a period, alternating.
        let slow = strokes(|n| 0.995f64.powf(n) * if n % 2.0 == 0.0 { 1.0 } else { -1.0 }, |_| 1);
        assert_eq!((period(&slow), approaches(&slow)), (None, true));
    }

    #[test]
    fn invariant_the_stable_symmetric_motion_is_its_own_mirror_image() {
        let p = Groups::basic().to_parameters(Scales::default()).unwrap();
        let mut simulator = settled(&p, &kicked(&p), 400.0).unwrap();
        let found = observe(&mut simulator).unwrap();
        assert_eq!((found.period, found.impacts, found.rests), (Some(1), [1.0, 1.0], false));
        assert!(found.is_symmetric() && !found.approaching);
        assert_eq!(Class::of(&found, None), Class::Periodic(1));
    }

    #[test]
    fn second_method_impacts_of_a_motion_that_settles_under_observation() {
        // Three impacts a period later on; the 400 discarded periods are left out here.
        let groups = Groups { f10: 3.9, ..Groups::basic() };
        let p = groups.to_parameters(Scales::default()).unwrap();
        let [early, late] = [5.0, 400.0].map(|n| observe(&mut settled(&p, &kicked(&p), n).unwrap()).unwrap());
        assert_eq!((early.period, late.period), (Some(1), Some(1)));
        assert_eq!(early.impacts.iter().sum::<f64>(), 3.0);
        assert_ne!(early.relation(&late), Relation::Different);
    }

    #[test]
    fn closed_form_motions_without_impacts_have_one_limit() {
        // Block and secondary oscillator: the slow swing loses about a thousandth of itself a period.
        let groups = Groups { f10: 0.4, sigma1: 2.0, ..Groups::basic() };
        let p = groups.to_parameters(Scales::default()).unwrap();
        let start = |v2| vibro_impact::simulator::State { x: [0.0; 3], v: [0.0, v2, 0.0] };
        let [slow, fast] =
            [0.02, 0.1].map(|v2| observe(&mut settled(&p, &start(v2), 300.0).unwrap()).unwrap());
        assert!(slow.is_free() && slow.period.is_none() && slow.approaching, "{slow:?}");
        assert_eq!(slow.relation(&fast), Relation::Same);
        // The limit: x1 = Re((sin - i cos) ...) of the box alone, the other two at rest.
        let late = observe(&mut settled(&p, &start(0.1), 20_000.0).unwrap()).unwrap();
        let (stiffness, damping) =
            (p.box_stiffness - p.box_mass * p.drive_frequency.powi(2), p.box_damping * p.drive_frequency);
        let amplitude = p.drive_amplitude / stiffness.hypot(damping) / p.stop_gap;
        assert_eq!((late.period, late.is_symmetric()), (Some(1), true));
        assert!(
            (late.sections[0][0].hypot(late.sections[0][3] * p.box_frequency() / p.drive_frequency)
                - amplitude)
                .abs()
                < RETURN
        );
        assert!(late.sections[0][1].abs() < RETURN && late.sections[0][2].abs() < RETURN);
        assert_eq!(late.relation(&slow), Relation::Same);
    }

    #[test]
    fn closed_form_classes_by_exponents() {
        let attractor = |approaching| Attractor {
            period: None,
            approaching,
            impacts: [1.0; 2],
            rests: false,
            sections: vec![[0.0; 6]],
            mirrored: vec![[0.0; 6]],
            sizes: [1.0; 3],
        };
        let spectrum = |first: f64, second: f64| Spectrum {
            exponents: [first, second, -1.0, -1.0, -1.0, -1.0, f64::NEG_INFINITY],
            deviation: 0.0,
            periods: 1500,
            settled: false,
            impacts: 3000,
            rests: false,
        };
        let class =
            |approaching, first, second| Class::of(&attractor(approaching), Some(&spectrum(first, second)));
        assert_eq!(class(false, 0.05, 0.0), Class::Chaotic);
        assert_eq!(class(false, 0.95e-3, 0.0), Class::QuasiPeriodic);
        assert_eq!(class(true, 0.0, 0.0), Class::Settling);
        assert_eq!(class(false, 0.0, -0.1), Class::Settling);
        assert_eq!(Class::of(&attractor(false), None), Class::Aperiodic);
    }
}
