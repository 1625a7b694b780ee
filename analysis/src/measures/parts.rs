//! A window in parts of equal length, by which the spread of its numbers is found.
//!
//! Of a motion that repeats after n returns every part is a whole number of n returns, so that its
//! numbers have no spread but rounding. n is found from what the first returns show, each by
//! itself.

use super::PARTS;
use crate::attractor::{LONGEST, least_period};

/// Returns that are kept one by one.
const LOOKED: usize = 4 * LONGEST as usize;
/// Most blocks that are kept after them; then two and two are joined.
const BLOCKS: usize = 3 * LOOKED;
/// What two returns show is the same to this part: the numbers repeat.
const NEAR: f64 = 1e-6;
/// It is so to the end of the transient, so that nothing more comes.
const STEADY: f64 = 1e-9;
/// What is this part of the largest and less is rounding.
const NOTHING: f64 = 1e-12;

/// What was seen over some returns.
pub(crate) trait Seen: Clone {
    /// What tells one return from another: numbers of several kinds, those of a kind comparable.
    fn numbers(&self) -> [Vec<f64>; 3];
    /// Takes in what was seen after it.
    fn join(&mut self, later: &Self);
}

/// A window while it grows.
#[derive(Debug)]
pub(crate) struct Parts<W> {
    blocks: Vec<W>,
    /// Returns in a block, and in the one that is not full.
    size: usize,
    begun: Option<(W, usize)>,
    /// After how many returns the numbers repeat; nothing before that is known.
    period: Option<usize>,
}

impl<W: Seen> Parts<W> {
    pub fn new() -> Self {
        Self { blocks: Vec::new(), size: 1, begun: None, period: None }
    }

    /// Takes in the next return; says whether it is certain that the motion repeats.
    pub fn push(&mut self, seen: W) -> bool {
        if self.period.is_some() {
            self.put(seen);
            return false;
        }
        self.blocks.push(seen);
        self.blocks.len() == LOOKED && {
            let is_steady = period(&self.blocks, STEADY).is_some();
            self.divide();
            is_steady
        }
    }

    /// Finds the period and joins what there is to blocks of it, the last returns first.
    fn divide(&mut self) {
        let period = period(&self.blocks, NEAR).unwrap_or(1);
        let all = std::mem::take(&mut self.blocks);
        (self.size, self.period) = (period, Some(period));
        let first = all.len() % period;
        all.into_iter().skip(first).for_each(|seen| self.put(seen));
    }

    fn put(&mut self, seen: W) {
        let (block, count) = match self.begun.take() {
            Some((mut block, count)) => {
                block.join(&seen);
                (block, count + 1)
            }
            None => (seen, 1),
        };
        if count < self.size {
            self.begun = Some((block, count));
            return;
        }
        self.blocks.push(block);
        if self.blocks.len() == BLOCKS {
            self.blocks = joined(&self.blocks, BLOCKS / 2);
            self.size *= 2;
        }
    }

    /// Up to six parts. What is over of a motion that repeats is left out.
    pub fn finish(mut self) -> Vec<W> {
        if self.period.is_none() {
            self.divide();
        }
        if let (Some((rest, _)), Some(1)) = (&self.begun, self.period) {
            match self.blocks.last_mut() {
                Some(last) => last.join(rest),
                None => self.blocks.push(rest.clone()),
            }
        }
        joined(&self.blocks, (PARTS as usize).min(self.blocks.len()))
    }
}

/// Parts joined to some longer ones, of as nearly equal length as may be.
fn joined<W: Seen>(parts: &[W], count: usize) -> Vec<W> {
    let group = |k: usize| {
        let (from, to) = (parts.len() * k / count, parts.len() * (k + 1) / count);
        let mut whole = parts[from].clone();
        parts[from + 1..to].iter().for_each(|part| whole.join(part));
        whole
    };
    (0..count).map(group).collect()
}

/// The parts of a window as one; there is one at least.
pub(crate) fn whole<W: Seen>(parts: &[W]) -> W {
    let mut whole = parts[0].clone();
    parts[1..].iter().for_each(|part| whole.join(part));
    whole
}

/// After how many returns all numbers repeat to a part of their sizes.
fn period<W: Seen>(returns: &[W], near: f64) -> Option<usize> {
    let all: Vec<[Vec<f64>; 3]> = returns.iter().map(Seen::numbers).collect();
    let mut sizes = all.first()?.clone();
    for numbers in &all {
        for (size, x) in sizes.iter_mut().flatten().zip(numbers.iter().flatten()) {
            *size = size.abs().max(x.abs());
        }
    }
    for kind in &mut sizes {
        let largest = kind.iter().copied().fold(0.0, f64::max);
        kind.iter_mut().for_each(|size| *size = near * size.max(NOTHING / near * largest));
    }
    let same = |a: &[Vec<f64>; 3], b: &[Vec<f64>; 3]| {
        let pairs = a.iter().flatten().zip(b.iter().flatten());
        pairs.zip(sizes.iter().flatten()).all(|((a, b), bound)| (a - b).abs() <= *bound)
    };
    least_period(&all, same).map(|n| n as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A largest value and the number of returns.
    #[derive(Clone)]
    struct Largest(f64, usize);

    impl Seen for Largest {
        fn numbers(&self) -> [Vec<f64>; 3] {
            [vec![self.0], Vec::new(), Vec::new()]
        }

        fn join(&mut self, later: &Self) {
            *self = Self(self.0.max(later.0), self.1 + later.1);
        }
    }

    fn of(returns: usize, number: &dyn Fn(usize) -> f64) -> (Vec<Largest>, bool) {
        let mut parts = Parts::new();
        let mut is_steady = false;
        for i in 0..returns {
            is_steady |= parts.push(Largest(number(i), 1));
        }
        (parts.finish(), is_steady)
    }

    #[test]
    fn invariant_parts_of_a_motion_that_repeats_are_alike_whatever_its_period() {
        for n in [1, 2, 3, 5, 7, 11, 12, 31, 32] {
            for returns in [60, 128, 500, 4001] {
                let (parts, is_steady) = of(returns, &|i| (i % n) as f64);
                let is_found = 4 * n <= returns;
                assert_eq!(is_steady, returns >= LOOKED);
                if is_found {
                    assert!(parts.len() >= 4.min(returns / n) && parts.len() <= 6, "{n} {returns}");
                    assert!(
                        parts.iter().all(|part| part.0 == (n - 1) as f64 && part.1 % n == 0),
                        "{n} {returns}"
                    );
                }
            }
        }
    }

    #[test]
    fn invariant_every_return_of_a_motion_without_a_period_is_in_a_part() {
        for returns in [1, 5, 6, 59, 60, 128, 129, 384, 385, 1000, 4001] {
            // Multiples of the golden ratio never come back.
            let (parts, is_steady) = of(returns, &|i| (i as f64 * 0.618_033_988_749_895).fract());
            assert!(!is_steady);
            assert_eq!(parts.iter().map(|part| part.1).sum::<usize>(), returns);
            assert_eq!(parts.len(), returns.min(6));
            let (least, most) = (parts.iter().map(|p| p.1).min(), parts.iter().map(|p| p.1).max());
            assert!(most.unwrap() - least.unwrap() <= 1 + returns / 64, "{returns}");
        }
    }
}
