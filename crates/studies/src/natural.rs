//! Eigenvalues of a machine's modes, computed separately for uncoupled parts.

mod span;

pub use span::{Oscillation, SHOWN, Span};

use super::eigenvalues::eigenvalues;
use nalgebra::{Complex, DMatrix};
use vibro_machine::components::components;
use vibro_machine::linear::Linear;
use vibro_machine::system::System;

/// Largest number of states of a part whose eigenvalues are all computed from a dense matrix. The
/// time grows with the third power of the states; at this size it is under a second.
const DENSE: usize = 600;

/// Eigenvalues of a machine's mode.
#[derive(Debug)]
pub struct Natural {
    /// All eigenvalues, 1/s, of parts of up to 600 states, and of larger parts without a [`Span`].
    pub values: Vec<Complex<f64>>,
    /// The lowest and highest oscillations of each larger part, where they could be computed.
    pub spans: Vec<Span>,
}

/// The eigenvalues of a mode's system for some of its states.
///
/// Two equal bodies on three equal springs oscillate at √(k/m) and √(3k/m):
///
/// ```
/// use vibro_machine::{Assembly, Motion, file};
/// use vibro_studies::natural::natural;
///
/// let text = r#"
///     name = "Chain"
///     body.a = { mass = 1.0 }
///     body.b = { mass = 1.0 }
///     spring.left = { between = ["ground", "a"], stiffness = 4.0 }
///     spring.middle = { between = ["a", "b"], stiffness = 4.0 }
///     spring.right = { between = ["b", "ground"], stiffness = 4.0 }
/// "#;
/// let machine = file::parse(text, "chain.toml", &file::no_records)?;
/// let motion = Motion::new(Assembly::new(machine)?.into())?;
/// let system = motion.assembly().system();
/// let found = natural(system, &system.linear(motion.mode()), &[0, 1, 2, 3]);
/// let mut rates: Vec<f64> = found.values.iter().map(|x| x.im).filter(|x| *x > 0.0).collect();
/// rates.sort_by(f64::total_cmp);
/// assert!((rates[0] - 2.0).abs() < 1e-14 && (rates[1] - 12f64.sqrt()).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn natural(system: &System, linear: &Linear, places: &[usize]) -> Natural {
    natural_above(system, linear, places, DENSE)
}

/// [`natural`] with a limit on the number of states of a dense part. A larger part is dense, too,
/// if it has forces other than springs and dashpots between bodies.
pub(super) fn natural_above(system: &System, linear: &Linear, places: &[usize], dense: usize) -> Natural {
    let mut index = vec![usize::MAX; system.states()];
    places.iter().enumerate().for_each(|(k, &place)| index[place] = k);
    let rows = places.iter().enumerate().flat_map(|(k, &place)| {
        let entries = linear.a.row(place).iter().filter(|entry| entry.0 < index.len());
        entries.map(move |entry| (k, entry.0)).collect::<Vec<_>>()
    });
    let pairs = rows.map(|(k, j)| (k, index[j])).filter(|pair| pair.1 != usize::MAX);
    let mut found = Natural { values: Vec::new(), spans: Vec::new() };
    for part in components(places.len(), pairs) {
        let part: Vec<usize> = part.into_iter().map(|k| places[k]).collect();
        let span = (part.len() > dense).then(|| Span::of(system, linear, &part)).flatten();
        match span {
            Some(span) => found.spans.push(span),
            None => {
                let own = |i: usize, j: usize| linear.a.entry(part[i], part[j]);
                let a = DMatrix::from_fn(part.len(), part.len(), own);
                found.values.extend(eigenvalues(a));
            }
        }
    }
    found
}
