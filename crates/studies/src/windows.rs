//! Division of a window into parts of equal length, to find the spread of its values.
//!
//! If a motion repeats after n returns, the length of every part is a multiple of n returns. The
//! values of the parts then differ only by rounding. n is found from the first returns, which are
//! stored individually.

use crate::class::{LONGEST, least_period};

/// Number of parts of a window for the spread of its values, if it has at least that many drive
/// periods.
const PARTS: u32 = 6;
/// Number of first returns stored individually.
const LOOKED: usize = 4 * LONGEST as usize;
/// Cap on the number of blocks; at the cap they are joined in pairs.
const BLOCKS: usize = 3 * LOOKED;
/// Relative tolerance for equal values of two returns.
const NEAR: f64 = 1e-6;
/// Relative tolerance of repeated values for the end of the transient. Further returns add
/// nothing.
const STEADY: f64 = 1e-9;
/// Values up to this fraction of the largest value of their kind are rounding.
const NOTHING: f64 = 1e-12;

/// Observation over some returns.
pub(crate) trait Observation: Clone {
    /// Values that distinguish returns: three kinds, comparable within a kind.
    fn numbers(&self) -> [Vec<f64>; 3];
    /// Joins a later observation.
    fn join(&mut self, later: &Self);
}

/// Parts of a growing window.
#[derive(Debug)]
pub(crate) struct Parts<W> {
    blocks: Vec<W>,
    /// Number of returns in a complete block.
    size: usize,
    /// The incomplete block with its number of returns.
    begun: Option<(W, usize)>,
    /// Period of the values, in returns; `None` until it is known.
    period: Option<usize>,
}

impl<W: Observation> Parts<W> {
    pub fn new() -> Self {
        Self { blocks: Vec::new(), size: 1, begun: None, period: None }
    }

    /// Adds the next return. Returns whether this return shows that the motion repeats.
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

    /// Finds the period and joins the returns to blocks of one period each. The last block ends
    /// with the last return.
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

    /// At most six parts. An incomplete period of a motion that repeats is left out.
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

/// Joins parts to `count` longer parts of nearly equal length.
fn joined<W: Observation>(parts: &[W], count: usize) -> Vec<W> {
    let group = |k: usize| {
        let (from, to) = (parts.len() * k / count, parts.len() * (k + 1) / count);
        let mut whole = parts[from].clone();
        parts[from + 1..to].iter().for_each(|part| whole.join(part));
        whole
    };
    (0..count).map(group).collect()
}

/// Joins all parts of a window; there must be at least one.
pub(crate) fn whole<W: Observation>(parts: &[W]) -> W {
    let mut whole = parts[0].clone();
    parts[1..].iter().for_each(|part| whole.join(part));
    whole
}

/// Period of all values, in returns, with a tolerance relative to their sizes.
fn period<W: Observation>(returns: &[W], near: f64) -> Option<usize> {
    let all: Vec<[Vec<f64>; 3]> = returns.iter().map(Observation::numbers).collect();
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

    /// Largest value, and number of returns.
    #[derive(Clone)]
    struct Largest(f64, usize);

    impl Observation for Largest {
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
            // Multiples of the golden ratio never repeat modulo 1.
            let (parts, is_steady) = of(returns, &|i| (i as f64 * 0.618_033_988_749_895).fract());
            assert!(!is_steady);
            assert_eq!(parts.iter().map(|part| part.1).sum::<usize>(), returns);
            assert_eq!(parts.len(), returns.min(6));
            let (least, most) = (parts.iter().map(|p| p.1).min(), parts.iter().map(|p| p.1).max());
            assert!(most.unwrap() - least.unwrap() <= 1 + returns / 64, "{returns}");
        }
    }
}
