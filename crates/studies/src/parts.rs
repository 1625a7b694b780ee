//! Long studies in parts: the parts that are computed here, and the store of finished ones.
//!
//! A study in parts is a function from the index of a part to its result. The parts are
//! independent of each other, so threads and computers can share them, and an interrupted study
//! continues with the missing parts. The caller decides through [`PartStore`] how parts outlive
//! the program; this module touches no disk.

use super::error::{Error, Result};
use rayon::prelude::*;
use serde::{Serialize, de::DeserializeOwned};

/// Share of the parts computed here: parts whose index has the remainder `index` when divided by
/// `count`.
///
/// ```
/// use vibro_studies::parts::Shard;
///
/// let second_of_four: Shard = "2/4".parse()?;
/// assert_eq!(second_of_four, Shard { index: 1, count: 4 });
/// # Ok::<(), vibro_studies::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// 0 … count - 1.
    pub index: usize,
    /// Number of shards.
    pub count: usize,
}

impl Shard {
    /// All parts.
    pub const ALL: Self = Self { index: 0, count: 1 };
}

impl std::str::FromStr for Shard {
    type Err = Error;

    /// Parses `i/n` with i from 1 to n.
    fn from_str(text: &str) -> Result<Self> {
        let form = || Error::Form { text: text.into(), expected: "I/N with I from 1 to N, e.g. 2/4" };
        let (i, n) = text.split_once('/').ok_or_else(form)?;
        match (i.trim().parse::<usize>(), n.trim().parse::<usize>()) {
            (Ok(i), Ok(n)) if i >= 1 && i <= n => Ok(Self { index: i - 1, count: n }),
            _ => Err(form()),
        }
    }
}

/// Storage of the bytes of finished parts, used by several threads at the same time.
pub trait PartStore: Sync {
    /// The bytes of a finished part. `None` where it is missing or cannot be read; it is then
    /// computed again.
    fn load(&self, index: usize) -> Option<Vec<u8>>;

    /// Stores the bytes of a finished part, completely or not at all.
    ///
    /// # Errors
    /// [`Error::Store`] with the reason.
    fn save(&self, index: usize, bytes: &[u8]) -> Result<()>;

    /// Checks, from time to time in long work before the parts, whether the study is still wanted.
    ///
    /// # Errors
    /// [`Error::Store`] ends the study.
    fn go_on(&self) -> Result<()> {
        Ok(())
    }

    /// Whether a part is stored.
    fn contains(&self, index: usize) -> bool {
        self.load(index).is_some()
    }

    /// Number of parts 0 … `count` - 1 still to be computed.
    fn missing(&self, count: usize) -> usize {
        (0..count).filter(|&index| !self.contains(index)).count()
    }
}

/// Store that keeps nothing, for results that are not needed after the program ends.
#[derive(Clone, Copy, Debug)]
pub struct NoStore;

impl PartStore for NoStore {
    fn load(&self, _index: usize) -> Option<Vec<u8>> {
        None
    }

    fn save(&self, _index: usize, _bytes: &[u8]) -> Result<()> {
        Ok(())
    }
}

/// Share of one computer in a long study.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// Store of finished parts.
    pub store: &'a dyn PartStore,
    /// Parts that are computed here.
    pub shard: Shard,
    /// Called once for each finished part; the argument is whether it was stored before.
    pub done: &'a (dyn Fn(bool) + Sync),
}

impl Task<'static> {
    /// All parts, without a store and without reports.
    pub const ALL: Self = Self { store: &NoStore, shard: Shard::ALL, done: &|_| () };
}

impl Task<'_> {
    /// Computes, on all threads, the parts 0 … `count` - 1 that are not stored and belong to the
    /// shard. Returns all parts in order, or `None` if some belong to other shards and are not
    /// stored.
    ///
    /// # Errors
    /// Errors of `compute`; [`Error::Store`].
    pub fn complete<T: Serialize + DeserializeOwned + Send>(
        &self,
        count: usize,
        compute: impl Fn(usize) -> Result<T> + Sync,
    ) -> Result<Option<Vec<T>>> {
        self.complete_with(count, |&mut (), index| compute(index))
    }

    /// [`complete`](Self::complete) with a workspace `W` that is reused for one part after
    /// another. It must not change the result of `compute`.
    ///
    /// # Errors
    /// As [`complete`](Self::complete).
    pub fn complete_with<W: Default, T: Serialize + DeserializeOwned + Send>(
        &self,
        count: usize,
        compute: impl Fn(&mut W, usize) -> Result<T> + Sync,
    ) -> Result<Option<Vec<T>>> {
        let part = |workspace: &mut W, index| self.part(index, |index| compute(workspace, index));
        let parts: Vec<Option<T>> =
            (0..count).into_par_iter().map_init(W::default, part).collect::<Result<_>>()?;
        Ok(parts.into_iter().collect())
    }

    /// [`complete`](Self::complete) for a study whose parts do not fit into memory together: they
    /// stay in the store, where [`part`](Self::part) finds them. Returns whether all are stored.
    ///
    /// # Errors
    /// As [`Self::complete`].
    pub fn fill<T: Serialize + DeserializeOwned + Send>(
        &self,
        count: usize,
        compute: impl Fn(usize) -> Result<T> + Sync,
    ) -> Result<bool> {
        let is_there = |index| Ok(self.part(index, &compute)?.is_some());
        let there: Vec<bool> = (0..count).into_par_iter().map(is_there).collect::<Result<_>>()?;
        Ok(there.into_iter().all(|is| is))
    }

    /// A part from the store. If it is missing and belongs to the shard, it is computed.
    ///
    /// # Errors
    /// As [`Self::complete`].
    pub fn part<T: Serialize + DeserializeOwned>(
        &self,
        index: usize,
        compute: impl FnOnce(usize) -> Result<T>,
    ) -> Result<Option<T>> {
        let Self { store, shard, done } = self;
        if let Some(part) = store.load(index).and_then(|bytes| postcard::from_bytes(&bytes).ok()) {
            done(true);
            return Ok(Some(part));
        }
        if index % shard.count != shard.index {
            return Ok(None);
        }
        let part = compute(index)?;
        store.save(index, &postcard::to_stdvec(&part).map_err(Error::store)?)?;
        done(false);
        Ok(Some(part))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Keeps the parts in memory.
    #[derive(Default)]
    struct MemoryStore(Mutex<BTreeMap<usize, Vec<u8>>>);

    impl PartStore for MemoryStore {
        fn load(&self, index: usize) -> Option<Vec<u8>> {
            self.0.lock().unwrap().get(&index).cloned()
        }

        fn save(&self, index: usize, bytes: &[u8]) -> Result<()> {
            self.0.lock().unwrap().insert(index, bytes.to_vec());
            Ok(())
        }
    }

    fn square(index: usize) -> Result<Vec<f64>> {
        Ok(vec![(index * index) as f64, f64::NEG_INFINITY])
    }

    fn squares(count: usize) -> Vec<Vec<f64>> {
        (0..count).map(|i| square(i).unwrap()).collect()
    }

    #[test]
    fn invariant_interrupted_work_continues_with_the_missing_parts() {
        let store = MemoryStore::default();
        let failing = |i: usize| {
            if i == 5 { Err(Error::Form { text: "5".into(), expected: "none" }) } else { square(i) }
        };
        assert!(Task { store: &store, ..Task::ALL }.complete(8, failing).is_err());
        // Part 3 is damaged: it is shorter than the length of a vector.
        store.save(3, &[255; 3]).unwrap();
        let (made, found) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let count = |was: bool| {
            (if was { &found } else { &made }).fetch_add(1, Ordering::Relaxed);
        };
        let all = Task { store: &store, done: &count, ..Task::ALL }.complete(8, square).unwrap().unwrap();
        assert_eq!(all, squares(8));
        assert!(found.load(Ordering::Relaxed) >= 1 && made.load(Ordering::Relaxed) >= 2);
        assert_eq!(found.into_inner() + made.into_inner(), 8);
    }

    #[test]
    fn invariant_shards_together_make_the_whole() {
        let all = MemoryStore::default();
        for text in ["1/3", "2/3", "3/3"] {
            let before = all.missing(10);
            let store = MemoryStore::default();
            let task = Task { store: &store, shard: text.parse().unwrap(), ..Task::ALL };
            assert_eq!(task.complete(10, square).unwrap(), None);
            all.0.lock().unwrap().extend(store.0.into_inner().unwrap());
            assert!(all.missing(10) < before);
        }
        assert_eq!(all.missing(10), 0);
        let nothing = |_| -> Result<Vec<f64>> { panic!("all parts are there") };
        let whole = Task { store: &all, ..Task::ALL }.complete(10, nothing).unwrap().unwrap();
        assert_eq!(whole, squares(10));
    }

    #[test]
    fn shards_of_another_form_are_refused() {
        for wrong in ["0/2", "3/2", "1", "a/b", ""] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
