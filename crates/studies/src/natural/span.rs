//! The lowest and highest oscillations of a large part of a machine with symmetric matrices M, C
//! and K, by sparse factors.
//!
//! The undamped frequencies are the square roots of the eigenvalues of K - ω² M. The number of
//! eigenvalues below a limit is the number of negative pivots of K - limit · M (Sylvester's law of
//! inertia), so bisection cannot miss one. Each damped eigenvalue follows from the undamped one by
//! inverse iteration with the quadratic λ² M + λ C + K.

use nalgebra::Complex;
use vibro_machine::linear::Linear;
use vibro_machine::sparse_factor::{Number, Pattern, SymmetricSparse};
use vibro_machine::system::System;
use vibro_numerics::sorting::sort_by_key;

/// Cap on the computed oscillations at either end of the spectrum: the lowest and the highest.
pub const SHOWN: usize = 10;
/// Tolerance for the rounding of a difference, relative to its terms.
const ROUNDING: f64 = 1e-12;
/// Width of a bracket of ω², relative to its upper end, at which bisection ends. Frequencies
/// closer than this count as equal.
const WIDTH: f64 = 1e-9;
/// Frequency relative to the highest one below which a coordinate counts as still.
const STILL: f64 = 1e-7;
/// Largest number of inverse iterations per eigenvalue; each about doubles the correct digits.
const ITERATIONS: usize = 30;
/// Relative tolerance of the iteration for an eigenvalue.
const SETTLED: f64 = 1e-12;

/// The lowest and highest oscillations of a part.
#[derive(Debug)]
pub struct Span {
    /// Number of coordinates of the part.
    pub coordinates: usize,
    /// Number of coordinates without an undamped oscillation, because no spring pulls them back.
    pub still: usize,
    /// The lowest and the highest oscillations, ascending.
    pub shown: [Vec<Oscillation>; 2],
}

/// An oscillation.
#[derive(Clone, Copy, Debug)]
pub struct Oscillation {
    /// Undamped frequency, rad/s.
    pub undamped: f64,
    /// Damped eigenvalue. `None` if it is undecided: two frequencies are equal, or damping changes
    /// the oscillation so much that its eigenvalue does not follow from the undamped one.
    pub damped: Option<Complex<f64>>,
}

/// M, C and K of a part, by rows.
struct Matrices {
    pattern: Pattern,
    rows: Vec<Vec<Entry>>,
    is_damped: bool,
}

/// An entry of the three matrices at a column.
#[derive(Clone, Copy, Default)]
struct Entry {
    column: usize,
    mass: f64,
    damping: f64,
    stiffness: f64,
}

#[derive(Clone, Copy)]
struct Wide(Complex<f64>);

impl Number for Wide {
    const ZERO: Self = Self(Complex { re: 0.0, im: 0.0 });

    fn less_product(self, a: Self, b: Self) -> Self {
        Self(self.0 - a.0 * b.0)
    }

    fn over(self, by: Self) -> Self {
        Self(self.0 / by.0)
    }
}

impl Span {
    /// The span of a part given by its states. `None` if these are not just coordinates and their
    /// rates, if the matrices are not symmetric, or if a stiffness is negative.
    pub(super) fn of(system: &System, linear: &Linear, part: &[usize]) -> Option<Self> {
        let own = Matrices::of(system, linear, part)?;
        let n = own.rows.len();
        let mut top = own.rows.iter().enumerate().fold(f64::MIN_POSITIVE, |most, (i, row)| {
            let own = row.iter().find(|entry| entry.column == i);
            own.map_or(most, |entry| most.max(entry.stiffness / entry.mass))
        });
        while own.below(top) < n {
            top *= 2.0;
            if !top.is_finite() {
                return None;
            }
        }
        // Limits, each with the number of eigenvalues below it.
        let mut known = vec![(-top, own.below(-top)), (top, n)];
        if known[0].1 > 0 {
            return None;
        }
        let highest = own.eigenvalue(n - 1, &mut known);
        let zero = highest * STILL * STILL;
        if own.below(-zero) > 0 {
            return None;
        }
        let still = own.below(zero);
        let split = n.min(still + SHOWN);
        let ranges = [still..split, split.max(n.saturating_sub(SHOWN))..n];
        let shown = ranges.map(|range| own.oscillations(range, &mut known));
        Some(Self { coordinates: n, still, shown })
    }

    /// Number of oscillations left out of the list.
    pub fn between(&self) -> usize {
        let [low, high] = &self.shown;
        self.coordinates - self.still - low.len() - high.len()
    }
}

impl Matrices {
    fn of(system: &System, linear: &Linear, part: &[usize]) -> Option<Self> {
        let n = system.coordinates;
        let coordinates: Vec<usize> = part.iter().copied().take_while(|&place| place < n).collect();
        let rates = part[coordinates.len()..].iter().map(|&place| place.wrapping_sub(n));
        if !coordinates.iter().copied().eq(rates) || !linear.lambda.is_empty() {
            return None;
        }
        let mut index = vec![usize::MAX; n];
        coordinates.iter().enumerate().for_each(|(k, &place)| index[place] = k);
        let (mut rows, mut sizes) = (Vec::new(), Vec::new());
        for &i in &coordinates {
            let (mut row, mut size): (Vec<Entry>, _) = (Vec::new(), [0.0f64; 2]);
            for &(m, inertia) in system.mass.entries(i) {
                row.push(Entry { column: index[m], mass: inertia, ..Entry::default() });
                for &(j, x) in linear.a.row(n + m) {
                    let force = -inertia * x;
                    if j < n {
                        size[0] = size[0].max(force.abs());
                        row.push(Entry { column: index[j], stiffness: force, ..Entry::default() });
                    } else if j < 2 * n {
                        size[1] = size[1].max(force.abs());
                        row.push(Entry { column: index[j - n], damping: force, ..Entry::default() });
                    }
                }
            }
            if row.iter().any(|entry| entry.column == usize::MAX) {
                return None;
            }
            sort_by_key(&mut row, |entry| entry.column);
            row.dedup_by(|next, sum| {
                let is_same = next.column == sum.column;
                if is_same {
                    sum.mass += next.mass;
                    sum.damping += next.damping;
                    sum.stiffness += next.stiffness;
                }
                is_same
            });
            rows.push(row);
            sizes.push(size);
        }
        let pairs = rows.iter().enumerate().flat_map(|(i, row)| row.iter().map(move |own| (i, own.column)));
        let pattern = Pattern::of(rows.len(), pairs);
        let is_damped = rows.iter().flatten().any(|entry| entry.damping != 0.0);
        let own = Self { pattern, rows, is_damped };
        own.is_symmetric(&sizes).then_some(own)
    }

    /// Whether the matrices are symmetric up to rounding of the sizes of the rows.
    fn is_symmetric(&self, sizes: &[[f64; 2]]) -> bool {
        self.rows.iter().enumerate().all(|(i, row)| {
            row.iter().all(|own| {
                let other = self.rows[own.column].iter().find(|entry| entry.column == i);
                let other = other.copied().unwrap_or_default();
                let near = |a: f64, b: f64, k: usize| {
                    (a - b).abs() <= ROUNDING * sizes[i][k].max(sizes[own.column][k])
                };
                near(own.stiffness, other.stiffness, 0) && near(own.damping, other.damping, 1)
            })
        })
    }

    /// A combination of the matrices.
    fn combined<T: Number>(&self, of: impl Fn(&Entry) -> T) -> SymmetricSparse<'_, T> {
        let mut sum = SymmetricSparse::zeros(&self.pattern);
        for (i, row) in self.rows.iter().enumerate() {
            for entry in row.iter().filter(|entry| entry.column <= i) {
                if let Some(place) = sum.entry_mut(i, entry.column) {
                    *place = of(entry);
                }
            }
        }
        sum
    }

    /// K - limit · M, factored. A zero pivot is replaced by the rounding of its row.
    fn shifted(&self, limit: f64) -> Option<SymmetricSparse<'_, f64>> {
        let size = |k: usize| {
            let own = self.rows[k].iter();
            own.map(|entry| entry.stiffness.abs() + limit.abs() * entry.mass.abs()).fold(0.0, f64::max)
        };
        let accept = |pivot: f64, k: usize| {
            let pivot = if pivot == 0.0 { f64::EPSILON * size(k) } else { pivot };
            pivot.is_finite().then_some(pivot)
        };
        self.combined(|own| own.stiffness - limit * own.mass).factor(accept)
    }

    /// The number of eigenvalues ω² below a limit.
    fn below(&self, limit: f64) -> usize {
        self.shifted(limit).map_or(0, |own| own.diagonal.iter().filter(|pivot| **pivot < 0.0).count())
    }

    /// The eigenvalue with `count` eigenvalues below it. `known` holds limits with their counts;
    /// new limits are added to it.
    fn eigenvalue(&self, count: usize, known: &mut Vec<(f64, usize)>) -> f64 {
        let bracket = |known: &[(f64, usize)]| {
            let low = known.iter().filter(|own| own.1 <= count).map(|own| own.0).fold(f64::MIN, f64::max);
            let high = known.iter().filter(|own| own.1 > count).map(|own| own.0).fold(f64::MAX, f64::min);
            (low, high)
        };
        let (mut low, mut high) = bracket(known);
        while high - low > WIDTH * high.abs().max(low.abs()) {
            // Positive limits far apart are bisected geometrically, so that low frequencies keep
            // their digits.
            let middle = match (low, high) {
                (low, high) if low > 0.0 && high > 4.0 * low => (low * high).sqrt(),
                (low, high) => low + 0.5 * (high - low),
            };
            if middle <= low || middle >= high {
                break;
            }
            known.push((middle, self.below(middle)));
            (low, high) = bracket(known);
        }
        0.5 * (low + high)
    }

    /// The oscillations whose index, by ascending frequency, is in a range.
    fn oscillations(&self, range: std::ops::Range<usize>, known: &mut Vec<(f64, usize)>) -> Vec<Oscillation> {
        let squares: Vec<f64> = range.map(|count| self.eigenvalue(count, known)).collect();
        let is_near = |a: f64, b: f64| (a - b).abs() <= 4.0 * WIDTH * a.abs();
        let is_single = |k: usize| {
            let others = squares.iter().enumerate().filter(|(other, _)| *other != k);
            others.map(|own| *own.1).all(|other| !is_near(squares[k], other))
        };
        let of = |k: usize| {
            let (square, undamped) = (squares[k], squares[k].max(0.0).sqrt());
            let damped = match self.is_damped {
                false => Some(Complex::new(0.0, undamped)),
                true => is_single(k).then(|| self.damped(square)).flatten(),
            };
            Oscillation { undamped, damped }
        };
        (0..squares.len()).map(of).collect()
    }

    /// The damped eigenvalue that belongs to an undamped one.
    fn damped(&self, square: f64) -> Option<Complex<f64>> {
        let near = self.shifted(square * (1.0 + 0.25 * WIDTH))?;
        // An irregular vector, so that it is not orthogonal to the shape.
        let mut shape: Vec<f64> = (0..self.rows.len()).map(|k| 1.0 + ((k as f64) * 0.7).sin()).collect();
        for _ in 0..3 {
            shape = self.times(&shape, |entry| entry.mass);
            near.solve(&mut shape);
            let most = shape.iter().fold(0.0f64, |most, x| most.max(x.abs()));
            shape.iter_mut().for_each(|x| *x /= most);
        }
        let start = Complex::new(0.0, square.sqrt());
        let mut shape: Vec<Wide> = shape.into_iter().map(|x| Wide(x.into())).collect();
        let mut value = self.root(&shape, start)?;
        for _ in 0..ITERATIONS {
            let quadratic =
                |own: &Entry| Wide(value * value * own.mass + value * own.damping + own.stiffness);
            let right = self.times(&shape, |own| value * (2.0 * own.mass) + own.damping);
            let finite = |pivot: Wide, _| {
                let pivot = if pivot.0.norm() == 0.0 { Wide(f64::MIN_POSITIVE.into()) } else { pivot };
                pivot.0.norm().is_finite().then_some(pivot)
            };
            let factors = self.combined(quadratic).factor(finite)?;
            let mut next: Vec<Wide> = right;
            factors.solve(&mut next);
            let most = next.iter().fold(0.0f64, |most, x| most.max(x.0.norm()));
            if !(most > 0.0 && most.is_finite()) {
                return None;
            }
            shape = next.into_iter().map(|x| Wide(x.0 / most)).collect();
            let refined = self.root(&shape, value)?;
            let change = (refined - value).norm();
            value = refined;
            if change <= SETTLED * value.norm() {
                // The iteration may have reached the eigenvalue of another oscillation.
                return (value.im > 0.0 && (value - start).norm() < 0.5 * start.norm()).then_some(value);
            }
        }
        None
    }

    /// The root of φᵀ(λ² M + λ C + K)φ that is closer to a value.
    fn root(&self, shape: &[Wide], near: Complex<f64>) -> Option<Complex<f64>> {
        let along = |of: fn(&Entry) -> f64| {
            let all = self.times(shape, |own| of(own).into());
            all.iter().zip(shape).map(|(a, b)| a.0 * b.0).sum::<Complex<f64>>()
        };
        let (m, c, k) = (along(|own| own.mass), along(|own| own.damping), along(|own| own.stiffness));
        let half = -c / (m * 2.0);
        let reach = (half * half - k / m).sqrt();
        let [a, b] = [half + reach, half - reach];
        let nearer = if (a - near).norm() < (b - near).norm() { a } else { b };
        nearer.norm().is_finite().then_some(nearer)
    }

    /// The product of a combination of the matrices with a vector.
    fn times<T, F>(&self, vector: &[T], of: impl Fn(&Entry) -> F) -> Vec<T>
    where
        T: Number + std::iter::Sum + Scaled<F>,
    {
        let rows = self.rows.iter();
        rows.map(|row| row.iter().map(|own| vector[own.column].scaled(of(own))).sum()).collect()
    }
}

/// Numbers that can be multiplied by factors of another type.
trait Scaled<F> {
    fn scaled(self, by: F) -> Self;
}

impl Scaled<f64> for f64 {
    fn scaled(self, by: f64) -> Self {
        self * by
    }
}

impl Scaled<Complex<f64>> for Wide {
    fn scaled(self, by: Complex<f64>) -> Self {
        Self(self.0 * by)
    }
}

impl std::iter::Sum for Wide {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        Self(all.map(|x| x.0).sum())
    }
}
