//! Neutral directions: changes of the coordinates on which no force depends, such as the angle of
//! a free shaft or the position of a train (docs/assembly-law.md (A30)).
//!
//! A direction u of the coordinates is neutral if no elongation that determines a force changes
//! along it: w · u = 0 for every spring with stiffness and every stop. If no dashpot and no
//! friction acts along u either, only loads change the momentum along u, and the direction u of
//! the velocities is neutral, too. A motion from a state shifted along neutral directions is the
//! original motion, shifted by a known amount: these directions have the exponent 0, and no return
//! depends on them.

use crate::description::Description;
use crate::functional::Functional;
use crate::kernel::Sparse;
use crate::system::{Elongation, System};
use nalgebra::DVector;

/// Tolerance for a zero entry of a unit row: arms and links are given to more digits.
const ZERO: f64 = 1e-10;

/// The neutral directions of a machine.
///
///
/// Nothing holds a train to the ground:
///
/// ```
/// use vibro_machine::neutral::Neutral;
/// use vibro_machine::{Assembly, file};
///
/// let text = r#"
///     name = "Train"
///     body.engine = { mass = 3.0 }
///     body.wagon = { mass = 1.0 }
///     spring.coupling = { between = ["engine", "wagon"], stiffness = 100.0 }
/// "#;
/// let train = Assembly::new(file::parse(text, "train.toml", &file::no_records)?)?;
/// let words = Neutral::of(train.system()).in_words(&train.description, train.system());
/// assert_eq!(words[0], "no force depends on engine.s, wagon.s together, as 1 : 1");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Neutral {
    /// Number of coordinates.
    coordinates: usize,
    /// Number of springs in series.
    inner: usize,
    /// Directions of the coordinates, a sparse basis found by elimination.
    places: Vec<DVector<f64>>,
    /// Directions of the velocities.
    rates: Vec<DVector<f64>>,
}

/// The rows of G v, on which gyroscopic forces depend.
fn gyroscopic(system: &System) -> impl Iterator<Item = Terms> {
    let n = system.coordinates;
    system.gyroscopic_forces().map(move |(_, force)| Sparse::of(force.rows(n, n).as_slice()).terms().to_vec())
}

/// Rows that blocks read, restricted to the coordinates or velocities that begin at `first`.
fn read(system: &System, first: usize) -> impl Iterator<Item = Terms> {
    let inputs = system.blocks.iter().flat_map(|block| &block.inputs);
    inputs.map(move |input| Sparse::of(input.row.rows(first, system.coordinates).as_slice()).terms().to_vec())
}

impl Neutral {
    /// The directions of a machine.
    pub fn of(system: &System) -> Self {
        let along = |own: &Elongation| own.w.terms().to_vec();
        let springs = |acts: &dyn Fn(&crate::system::SpringRows) -> bool| {
            let all = system.springs.iter().filter(|s| acts(s));
            all.map(|s| along(&s.elongation)).collect::<Vec<_>>()
        };
        let is_curved = |s: &crate::system::SpringRows, of_rate: bool| {
            let of_formula = s.formula.as_ref().is_some_and(|own| own.acts(of_rate));
            s.curves.iter().any(|own| system.curved[own.0].is_of_rate == of_rate) || of_formula
        };
        let mut rows = springs(&|s| s.stiffness != 0.0 || is_curved(s, false));
        rows.extend(system.stops[..system.first_freewheel].iter().map(|s| along(&s.elongation)));
        rows.extend(read(system, 0));
        let places = null_space(rows.clone(), system.coordinates);
        rows.extend(springs(&|s| s.damping != 0.0 || is_curved(s, true)));
        rows.extend(gyroscopic(system));
        rows.extend(read(system, system.coordinates));
        rows.extend(system.stops[system.freewheels()].iter().map(|s| along(&s.elongation)));
        rows.extend(system.frictions.iter().map(|f| along(&f.elongation)));
        rows.extend(system.branches.iter().map(|b| along(&b.elongation)));
        let rates = null_space(rows, system.coordinates);
        let inner = system.branches.len();
        Self { coordinates: system.coordinates, inner, places, rates }
    }

    /// Directions of the coordinates q on which no force depends, each of length N.
    pub fn places(&self) -> &[DVector<f64>] {
        &self.places
    }

    /// Directions of the velocities q' on which no force depends, each in the span of
    /// [`places`](Self::places).
    pub fn rates(&self) -> &[DVector<f64>] {
        &self.rates
    }

    /// All directions as changes of the state (q, q', states of first order).
    pub fn states(&self) -> Vec<Vec<f64>> {
        let n = self.coordinates;
        let all = self.places.iter().map(|u| (u, 0)).chain(self.rates.iter().map(|u| (u, n)));
        all.map(|(u, first)| {
            let mut state = vec![0.0; 2 * n];
            state[first..first + n].copy_from_slice(u.as_slice());
            // Springs in series keep their stretches, and thus their forces.
            state.resize(2 * n + self.inner, 0.0);
            state
        })
        .collect()
    }

    /// The directions in words by bodies, such as `no force depends on rotor.s`.
    pub fn in_words(&self, d: &Description, system: &System) -> Vec<String> {
        let along = |u: &DVector<f64>, letter: &str| {
            let moved = |row: &Functional| {
                let own = row.terms().iter().take_while(|term| term.0 < u.len());
                own.map(|&(k, x)| x * u[k]).sum::<f64>()
            };
            let shares = system.bodies.iter().map(|body| moved(&body.s));
            let shares: Vec<(usize, f64)> = shares.enumerate().filter(|s| s.1.abs() > ZERO).collect();
            let names: Vec<String> =
                shares.iter().map(|(i, _)| format!("{}.{letter}", d.bodies[*i].name)).collect();
            let numbers: Vec<String> = shares.iter().map(|(_, x)| short(*x / shares[0].1)).collect();
            match &names[..] {
                [one] => one.clone(),
                _ => format!("{} together, as {}", names.join(", "), numbers.join(" : ")),
            }
        };
        let place = |u| format!("no force depends on {}", along(u, "s"));
        let rate = |u| format!("nor on {}: its momentum changes by loads alone", along(u, "v"));
        self.places.iter().map(place).chain(self.rates.iter().map(rate)).collect()
    }
}

/// A ratio rounded to six decimals, unless that gives 0.
fn short(x: f64) -> String {
    let rounded = (x * 1e6).round() / 1e6;
    format!("{}", if rounded == 0.0 { x } else { rounded })
}

/// A row of a system of equations.
type Terms = Vec<(usize, f64)>;

/// A basis of the directions u with w · u = 0 for all rows w. The elimination takes the largest
/// pivots, so that a body on which nothing acts has its own basis vector.
fn null_space(rows: Vec<Terms>, count: usize) -> Vec<DVector<f64>> {
    // The row of a pivot has no entry in the column of another pivot.
    let mut pivots: Vec<(usize, Sparse)> = Vec::new();
    let mut row_of = vec![None; count];
    // For each column, the rows that may have an entry in it.
    let mut having: Vec<Vec<usize>> = vec![Vec::new(); count];
    for row in rows {
        let size = row.iter().fold(0.0f64, |most, term| most.max(term.1.abs()));
        if size == 0.0 {
            continue;
        }
        let mut sum: Terms = row.iter().map(|&(place, x)| (place, x / size)).collect();
        let mut shares: Vec<(usize, f64)> =
            sum.iter().filter_map(|&(place, x)| Some((row_of[place]?, x))).collect();
        shares.sort_unstable_by_key(|share| share.0);
        for (other, share) in shares {
            sum.extend(pivots[other].1.terms().iter().map(|&(place, x)| (place, -share * x)));
        }
        let row = Sparse::summed(sum);
        let larger = |most: (usize, f64), &(place, x): &(usize, f64)| {
            if x.abs() > most.1.abs() { (place, x) } else { most }
        };
        let (pivot, largest) = row.terms().iter().fold((0, 0.0), larger);
        if largest.abs() <= ZERO {
            continue;
        }
        let row = Sparse::from_terms(row.terms().iter().map(|&(place, x)| (place, x / largest)));
        for other in std::mem::take(&mut having[pivot]) {
            let share = pivots[other].1.entry(pivot);
            if share != 0.0 {
                pivots[other].1 = pivots[other].1.less(&row.times(share));
                row.terms().iter().for_each(|&(place, _)| having[place].push(other));
            }
        }
        row_of[pivot] = Some(pivots.len());
        let others = row.terms().iter().filter(|term| term.0 != pivot);
        others.for_each(|&(place, _)| having[place].push(pivots.len()));
        pivots.push((pivot, row));
    }
    let free = (0..count).filter(|&place| row_of[place].is_none());
    free.map(|place| {
        let mut direction = DVector::zeros(count);
        direction[place] = 1.0;
        for &other in &having[place] {
            let (pivot, row) = &pivots[other];
            let share = row.entry(place);
            if share.abs() > ZERO {
                direction[*pivot] = -share;
            }
        }
        direction
    })
    .collect()
}
