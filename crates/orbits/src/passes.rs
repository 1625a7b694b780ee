//! Orbits that repeat a shorter word, in the equations of either word.

use super::place::Place;
use super::problem::{Numbers, Problem};
use super::word::Word;
use crate::obstacle::Obstacle;
use nalgebra::DVector;

/// Largest difference of the times of repetitions of one orbit, rad.
const REPETITION: f64 = 1e-6;

impl Problem {
    /// The point of the same orbit in the equations of the word repeated `times` times. The given
    /// point must be on an orbit.
    pub(super) fn repeated(
        &self,
        place: &Place,
        u: &DVector<f64>,
        times: u32,
    ) -> Result<(Self, DVector<f64>), Obstacle> {
        let Numbers { states, times: events, period, drifts } = self.numbers(place, u);
        let cycle = self.cycle(place, u)?;
        let turns = |k: usize| (k / events.len(), k % events.len());
        let problem = Self { word: self.word.repeated(times), ..self.clone() };
        // Each repetition starts from the drifted end of the previous one.
        let drift = |i: usize| cycle.back[i] - states[0][i];
        let state = |&k: &usize| {
            let (turn, k) = turns(k);
            let entered = cycle.legs[k].entered().iter().take(states[0].len()).enumerate();
            entered.map(|(i, x)| x + turn as f64 * drift(i)).collect()
        };
        let all = (0..times).flat_map(|turn| events.iter().map(move |t| t + f64::from(turn) * period));
        let longer = Numbers {
            states: problem.word.nodes().iter().map(state).collect(),
            times: all.collect(),
            period: f64::from(times) * period,
            drifts: drifts.iter().map(|x| x * f64::from(times)).collect(),
        };
        let u = problem.point(place, &longer, self.value(u));
        Ok((problem, u))
    }

    /// The equations of half the word, if its halves have the same events.
    pub(super) fn half(&self) -> Option<Self> {
        self.part(2)
    }

    /// The equations of a part of the word, if the word repeats it `times` times.
    pub(super) fn part(&self, times: u32) -> Option<Self> {
        Some(Self { word: self.word.part(times)?, ..self.clone() })
    }

    /// The difference of an orbit's halves: the event times of the second half minus the times of
    /// the first half, half a period later, in radians.
    pub(super) fn halves(&self, u: &DVector<f64>) -> Result<DVector<f64>, Obstacle> {
        let place = self.place(u)?;
        let Numbers { times, period, .. } = self.numbers(&place, u);
        let (half, radian) = (times.len() / 2, self.radian(&place));
        Ok(DVector::from_fn(half, |k, _| (times[half + k] - times[k] - 0.5 * period) / radian))
    }

    /// The point of half the word at the mean of both halves.
    pub(super) fn halved(&self, half: &Self, u: &DVector<f64>) -> Result<DVector<f64>, Obstacle> {
        let place = self.place(u)?;
        let numbers = self.numbers(&place, u);
        let cycle = self.cycle(&place, u)?;
        let (count, period) = (half.word.len(), 0.5 * numbers.period);
        let mean = |&k: &usize| {
            let pair = cycle.legs[k].entered().iter().zip(cycle.legs[count + k].entered());
            pair.take(self.units.state.len()).map(|(a, b)| 0.5 * (a + b)).collect()
        };
        let states = half.word.nodes().iter().map(mean).collect();
        let time = |k: usize| 0.5 * (numbers.times[k] + numbers.times[count + k] - period);
        let times = (0..count).map(time).collect();
        let drifts = numbers.drifts.iter().map(|x| 0.5 * x).collect();
        Ok(half.point(&place, &Numbers { states, times, period, drifts }, self.value(u)))
    }

    /// The equations of the shortest word of an orbit, with its point: the orbit may repeat a
    /// shorter word.
    pub(super) fn reduced(&self, u: &DVector<f64>) -> Result<(Self, DVector<f64>), Obstacle> {
        if let Some(once) = self.once(u)? {
            return Ok(once);
        }
        let most = self.word.len() as u32;
        for times in (2..=most).rev() {
            let Some(part) = self.part(times) else { continue };
            let place = self.place(u)?;
            let numbers = self.numbers(&place, u);
            let count = part.word.len();
            let period = numbers.period / f64::from(times);
            let is_same = (count..numbers.times.len()).all(|k| {
                let apart = numbers.times[k] - numbers.times[k - count] - period;
                (apart / self.radian(&place)).abs() < REPETITION
            });
            if is_same {
                let Numbers { mut states, times: all, drifts, .. } = numbers;
                let drifts = drifts.iter().map(|x| x / f64::from(times)).collect();
                states.truncate(part.word.nodes().len());
                let own = Numbers { states, times: all[..count].to_vec(), period, drifts };
                let at = part.point(&place, &own, self.value(u));
                // Fixed times alone do not show whether the state returns earlier.
                let returns =
                    !part.word.is_timed() || part.residual(&place, &at, false)?.value.amax() < REPETITION;
                if returns {
                    return Ok((part, at));
                }
            }
        }
        Ok((self.clone(), u.clone()))
    }

    /// An orbit without events that returns after each of several drive periods, in the equations
    /// of one period.
    fn once(&self, u: &DVector<f64>) -> Result<Option<(Self, DVector<f64>)>, Obstacle> {
        let Some(times) = self.word.periods.filter(|n| self.word.is_empty() && *n > 1) else {
            return Ok(None);
        };
        let place = self.place(u)?;
        let mut numbers = self.numbers(&place, u);
        numbers.period /= f64::from(times);
        numbers.drifts.iter_mut().for_each(|drift| *drift /= f64::from(times));
        let word = Word::new(self.word.letters.clone(), self.word.mode.clone(), Some(1));
        let once = Self { word, ..self.clone() };
        let at = once.point(&place, &numbers, self.value(u));
        let returns = once.residual(&place, &at, false)?.value.amax() < REPETITION;
        Ok(returns.then_some((once, at)))
    }
}
