//! Parts of a study after a first index, and paths of branches among them, so that the branches
//! over a diagram survive an interruption as the diagram's parts do.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use vibro_orbits::KeptPaths;
use vibro_studies::parts::PartStore;

/// The last parts of a store, numbered from 0 at a first index.
#[derive(Clone, Copy)]
pub struct Behind<'a> {
    /// The store of the whole study.
    pub store: &'a dyn PartStore,
    /// Index of the first of these parts.
    pub first: usize,
}

impl PartStore for Behind<'_> {
    fn load(&self, index: usize) -> Option<Vec<u8>> {
        self.store.load(self.first + index)
    }

    fn save(&self, index: usize, bytes: &[u8]) -> vibro_studies::Result<()> {
        self.store.save(self.first + index, bytes)
    }

    fn go_on(&self) -> vibro_studies::Result<()> {
        self.store.go_on()
    }

    fn contains(&self, index: usize) -> bool {
        self.store.contains(self.first + index)
    }
}

/// Paths of branches as parts: eight bytes with the path's number, then its bytes.
pub struct PathsInParts<'a> {
    parts: Behind<'a>,
    there: HashMap<u64, Vec<u8>>,
    next: AtomicUsize,
}

impl<'a> PathsInParts<'a> {
    /// Reads the paths stored as parts, from 0 to the first missing one.
    pub fn new(parts: Behind<'a>) -> Self {
        let stored: Vec<Vec<u8>> = (0..).map_while(|index| parts.load(index)).collect();
        let path = |bytes: &Vec<u8>| {
            let (key, path) = bytes.split_first_chunk()?;
            Some((u64::from_le_bytes(*key), path.to_vec()))
        };
        let next = AtomicUsize::new(stored.len());
        Self { parts, there: stored.iter().filter_map(path).collect(), next }
    }
}

impl KeptPaths for PathsInParts<'_> {
    fn find(&self, key: u64) -> Option<Vec<u8>> {
        self.there.get(&key).cloned()
    }

    fn keep(&self, key: u64, bytes: &[u8]) {
        let index = self.next.fetch_add(1, Ordering::Relaxed);
        // A path that cannot be stored is followed again.
        let _ = self.parts.save(index, &[&key.to_le_bytes()[..], bytes].concat());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;
    use std::sync::Mutex;

    #[derive(Default)]
    struct InMemory(Mutex<BTreeMap<usize, Vec<u8>>>);

    impl PartStore for InMemory {
        fn load(&self, index: usize) -> Option<Vec<u8>> {
            self.0.lock().unwrap().get(&index).cloned()
        }

        fn save(&self, index: usize, bytes: &[u8]) -> vibro_studies::Result<()> {
            self.0.lock().unwrap().insert(index, bytes.to_vec());
            Ok(())
        }
    }

    #[test]
    fn invariant_what_is_kept_is_found_by_a_later_run_behind_the_other_parts() {
        let store = InMemory::default();
        store.save(1, b"a part of the diagram").unwrap();
        let parts = Behind { store: &store, first: 2 };
        let first = PathsInParts::new(parts);
        first.keep(u64::MAX, b"plain");
        let second = PathsInParts::new(parts);
        assert_eq!((second.find(u64::MAX).as_deref(), second.find(1)), (Some(&b"plain"[..]), None));
        second.keep(1, b"closed");
        let third = PathsInParts::new(parts);
        let found = [u64::MAX, 1].map(|key| third.find(key));
        assert_eq!(found, ["plain", "closed"].map(|path| Some(path.into())));
        assert_eq!(store.0.lock().unwrap().keys().copied().collect::<Vec<_>>(), [1, 2, 3]);
    }
}
