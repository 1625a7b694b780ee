//! Interrupted and continued growths.

use super::*;
use std::collections::HashMap;
use std::sync::Mutex;

/// Paths in memory, with the numbers of paths found and stored.
#[derive(Default)]
struct Memory(Mutex<(Paths, [usize; 2])>);

type Paths = HashMap<u64, Vec<u8>>;

impl KeptPaths for Memory {
    fn find(&self, key: u64) -> Option<Vec<u8>> {
        let mut own = self.0.lock().unwrap();
        let bytes = own.0.get(&key).cloned();
        own.1[0] += usize::from(bytes.is_some());
        bytes
    }

    fn keep(&self, key: u64, bytes: &[u8]) {
        let mut own = self.0.lock().unwrap();
        own.1[1] += 1;
        own.0.insert(key, bytes.into());
    }
}

/// A rattle whose symmetric orbit folds, breaks its symmetry and doubles.
fn rattle() -> Family {
    let m = machine(
        "name = \"Rattle\"\nbody.joint = { motion = { amplitude = 1e-3, frequency = 25.0 } }\n\
         body.part = { mass = 0.1, start = { v = 0.5 } }\n\
         stop.left = { between = [\"part\", \"joint\"], gap = 1.5e-3, restitution = 0.6 }\n\
         stop.right = { between = [\"joint\", \"part\"], gap = 1.5e-3, restitution = 0.6 }\n",
    );
    Family::new(&m, "body.joint.motion.amplitude", (0.5e-3, 4e-3)).unwrap()
}

#[test]
fn invariant_a_growth_that_goes_on_has_the_branches_of_one_without_a_break() {
    let (family, options) = (rattle(), TreeOptions { seeds: 6, depth: 2, ..TreeOptions::default() });
    let told = |branches: &[Branch]| -> Vec<String> {
        branches.iter().map(|branch| format!("{:?} {:?}", branch.parent, branch.points)).collect()
    };
    let whole = tree(&family, &options, &mut |_, _| true).unwrap();
    assert!(whole.len() > 4, "{}", whole.len());
    let memory = Memory::default();
    let broken = tree_on(&family, &options, &memory, &mut |_, _| false).unwrap();
    let first = memory.0.lock().unwrap().1;
    assert!(broken.len() < whole.len() && first[0] == 0 && first[1] > 0, "{} {first:?}", broken.len());
    let on = tree_on(&family, &options, &memory, &mut |_, _| true).unwrap();
    assert_eq!(told(&on), told(&whole));
    // Each path was followed once.
    let second = memory.0.lock().unwrap().1;
    assert_eq!(second[0], first[1], "{second:?}");
    let again = tree_on(&family, &options, &memory, &mut |_, _| true).unwrap();
    assert_eq!((told(&again), memory.0.lock().unwrap().1[1]), (told(&whole), second[1]));
}

#[test]
fn refused_damaged_paths_are_followed_anew() {
    struct Damaged;
    impl KeptPaths for Damaged {
        fn find(&self, key: u64) -> Option<Vec<u8>> {
            // No bytes, no points, one point without its values, more points than bytes.
            [&b""[..], &[0, 0], &[1, 0, 0], &[200, 1, 7]].get(key as usize % 4).map(|x| x.to_vec())
        }

        fn keep(&self, _: u64, _: &[u8]) {}
    }
    let (family, options) = (rattle(), TreeOptions { seeds: 2, depth: 0, ..TreeOptions::default() });
    let [whole, damaged] = [
        tree(&family, &options, &mut |_, _| true).unwrap(),
        tree_on(&family, &options, &Damaged, &mut |_, _| true).unwrap(),
    ];
    assert_eq!(format!("{:?}", whole[0].points), format!("{:?}", damaged[0].points));
}
