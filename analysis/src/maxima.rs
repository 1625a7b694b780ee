//! Local maxima of X2 = x2/L, found from the flow and not from samples.
//!
//! X2 is continuous, its rate jumps at impacts. A maximum lies where the rate v2 passes from above to below zero: at a
//! root within a smooth piece, isolated by the same proof as the events, or at an impact that turns v2 round (in the
//! motion with two impacts a period every maximum is such a corner).

use super::walk::{Break, Piece, TERMS, along, augmented, walk};
use serde::{Deserialize, Serialize};
use vibro_impact::error::Result;
use vibro_impact::events::first_crossing;
use vibro_impact::flow::Series;
use vibro_impact::model::Model;
use vibro_impact::numerics::simd::value;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Simulator, State};

/// v2 changes sign at most this often in a series' piece; each change costs at least one of its twenty degrees.
const MOST_TURNS: usize = TERMS;

/// A local maximum of x2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Maximum {
    /// When, s.
    pub time: f64,
    /// x2, m.
    pub value: f64,
    /// Whether it is a corner: at an impact.
    pub corner: bool,
}

/// What happened in a drive period.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Period {
    /// The state at its end.
    pub state: State,
    /// Local maxima of x2, in order.
    pub maxima: Vec<Maximum>,
    /// Impacts in order: whether at the upper stop.
    pub impacts: Vec<bool>,
    /// Whether the block rested at a stop at any time.
    pub rests: bool,
}

/// Follows the sign of v2 along a motion.
struct Turns {
    rising: bool,
}

impl Turns {
    /// By the best instruction set at hand; no operation is fused, so all give the same bits.
    fn piece(&mut self, model: &Model, piece: &Piece, found: &mut Vec<Maximum>) {
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || self.piece_as(model, piece, found),
        );
    }

    #[inline(always)]
    fn piece_as(&mut self, model: &Model, piece: &Piece, found: &mut Vec<Maximum>) {
        let mut time = piece.time;
        let visit = |series: &Series<TERMS>, radius: f64| {
            let v2: [f64; TERMS] = std::array::from_fn(|k| series.lanes[k][3] + series.lanes[k][4]);
            let spread: f64 = v2[1..].iter().map(|c| c.abs()).sum();
            let steady = v2[0].abs() > spread && (v2[0] > 0.0) == self.rising;
            let mut from = 0.0;
            for _ in 0..if steady { 0 } else { MOST_TURNS } {
                let sought = if self.rising { v2.map(|c| -c) } else { v2 };
                let Some(u) = first_crossing(&sought, from, 1.0, &mut 0) else { break };
                if self.rising {
                    let x2: [f64; TERMS] = std::array::from_fn(|k| series.lanes[k][0] + series.lanes[k][1]);
                    found.push(Maximum { time: time + u * radius, value: value(&x2, u), corner: false });
                }
                self.rising = !self.rising;
                from = u;
            }
            time += radius;
        };
        along(model, piece.mode, &piece.start, piece.span, visit);
        if let Break::Impact { after, .. } = &piece.end {
            let v2 = after[3] + after[4];
            if self.rising && v2 < 0.0 {
                let (time, value) = (piece.time + piece.span, after[0] + after[1]);
                found.push(Maximum { time, value, corner: true });
            }
            // Standing still is decided by what follows.
            self.rising = if v2 == 0.0 { self.rising } else { v2 > 0.0 };
        }
    }
}

/// Records the next drive periods of a motion without loads, one by one.
///
/// # Errors
/// As [`Simulator::advance_until`].
pub fn record(simulator: &mut Simulator, periods: u32, visit: &mut dyn FnMut(&Period)) -> Result<()> {
    let parameters: Parameters = *simulator.parameters();
    let model = Model::new(&parameters)?;
    let (begin, length) = (simulator.time(), parameters.period());
    let z = augmented(simulator);
    let mut turns = Turns { rising: z[3] + z[4] > 0.0 };
    let mut period = Period::default();
    for i in 1..=periods {
        period.maxima.clear();
        period.impacts.clear();
        period.rests = false;
        walk(simulator, &model, begin + length * f64::from(i), &mut |piece| {
            turns.piece(&model, piece, &mut period.maxima);
            period.rests |= piece.mode == vibro_impact::model::SmoothMode::Rest;
            if let Break::Impact { side, .. } = piece.end {
                period.impacts.push(side > 0.0);
            }
        })?;
        period.state = simulator.state();
        visit(&period);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::settled;
    use crate::section::kicked;
    use vibro_impact::steady::exact_orbit;

    /// The transient has died out to this part of L.
    const SETTLED: f64 = 1e-9;
    /// Cubic interpolation between 128 samples a period (see `motion`).
    const INTERPOLATION: f64 = 1e-7;

    fn at(f10: f64, kappa: f64) -> Parameters {
        let groups = vibro_impact::Groups { f10, kappa, ..vibro_impact::Groups::basic() };
        groups.to_parameters(vibro_impact::Scales::default()).unwrap()
    }

    #[test]
    fn second_method_the_exact_orbits_amplitude_at_a_corner() {
        let p = Parameters::default();
        let orbit = exact_orbit::solve(&p).unwrap().upper.unwrap();
        let mut simulator = settled(&p, &kicked(&p), 600.0).unwrap();
        record(&mut simulator, 3, &mut |period| {
            assert_eq!(period.impacts.len(), 2);
            let [top] = period.maxima[..] else { panic!("{:?}", period.maxima) };
            assert!(top.corner && (top.value - orbit.amplitudes()[1]).abs() < SETTLED, "{top:?}");
        })
        .unwrap();
    }

    #[test]
    fn second_method_maxima_by_interpolated_samples() {
        // In chaos, with many impacts, and with rest; few periods, since chaos multiplies the rounding of the samples' steps.
        const PERIODS: u32 = 6;
        for (f10, kappa) in [(0.6, 0.75), (3.6, 0.75), (4.5, 0.9), (3.0, 0.0), (2.0, 0.3)] {
            let p = at(f10, kappa);
            let mut simulator = settled(&p, &kicked(&p), 50.0).unwrap();
            let mut other = simulator.clone();
            let mut exact = Vec::new();
            record(&mut simulator, PERIODS, &mut |period| exact.extend(period.maxima.clone())).unwrap();
            let flights = super::super::motion::record(&mut other, PERIODS).unwrap();
            let sampled = super::super::motion::maxima(&flights, &p, [0.0, 1.0, 0.0]);
            assert_eq!(exact.len(), sampled.len(), "f10 = {f10}, kappa = {kappa}");
            for (top, sample) in exact.iter().zip(sampled) {
                assert!((top.value - sample).abs() < INTERPOLATION, "f10 = {f10}: {top:?} {sample}");
            }
        }
    }

    #[test]
    fn closed_form_of_a_free_block() {
        // Without spring the block's speed is constant in flight: every maximum is a corner at the upper stop, where
        // the box carries it.
        let groups = vibro_impact::Groups { beta2: 0.0, alpha23: 0.0, ..vibro_impact::Groups::basic() };
        let p = groups.to_parameters(vibro_impact::Scales::default()).unwrap();
        let mut simulator = settled(&p, &kicked(&p), 40.0).unwrap();
        let mut count = 0;
        record(&mut simulator, 20, &mut |period| {
            count += period.maxima.len();
            assert!(period.maxima.iter().all(|m| m.corner), "{:?}", period.maxima);
        })
        .unwrap();
        assert!(count >= 20);
    }

    #[test]
    fn closed_form_of_a_small_swing_between_the_stops() {
        // Not driven and never at a stop: x2 is the sum of two undamped modes; here one alone, at the symmetric pair of
        // block and secondary oscillator held together by k3 = 0.
        let groups = vibro_impact::Groups { f10: 0.0, gamma3: 0.0, ..vibro_impact::Groups::basic() };
        let mut p = groups.to_parameters(vibro_impact::Scales::default()).unwrap();
        p.secondary_stiffness = 0.0;
        let rate = (2.0 * p.coupling_stiffness / p.block_mass).sqrt();
        let start = State { x: [0.0, 0.3, -0.3], v: [0.0; 3] };
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap().without_energy_accounts();
        let mut tops = Vec::new();
        record(&mut simulator, 20, &mut |period| tops.extend(period.maxima.clone())).unwrap();
        assert!(tops.len() >= 5);
        // The first one may be the start itself.
        for top in &tops[1..] {
            let turns = top.time * rate / std::f64::consts::TAU;
            assert!((turns - turns.round()).abs() < 1e-9 && (top.value - 0.3).abs() < 1e-12, "{top:?}");
        }
    }
}
