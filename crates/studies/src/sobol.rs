//! The Sobol sequence: points that fill a box evenly at any number of points.
//!
//! The direction numbers come from S. Joe and F. Y. Kuo, "Constructing Sobol sequences with better
//! two-dimensional projections", SIAM J. Sci. Comput. 30 (2008) 2635–2654, file
//! `new-joe-kuo-6.21201`, one dimension for each parameter of the machine. The points are in the
//! order of the Gray code (I. A. Antonov, V. M. Saleev, 1979). The table is written here, since
//! the available crates scramble in single precision or are no longer maintained.

/// Largest number of dimensions.
pub const DIMENSIONS: usize = 13;

/// Binary digits of a coordinate.
const DIGITS: usize = 32;

/// For each dimension after the first: the inner coefficients of its primitive polynomial as bits,
/// and its first direction numbers. Their count is the polynomial's degree.
const POLYNOMIALS: [(u32, &[u32]); DIMENSIONS - 1] = [
    (0, &[1]),
    (1, &[1, 3]),
    (1, &[1, 3, 1]),
    (2, &[1, 1, 1]),
    (1, &[1, 1, 3, 3]),
    (4, &[1, 3, 5, 13]),
    (2, &[1, 1, 5, 5, 17]),
    (4, &[1, 1, 5, 5, 5]),
    (7, &[1, 1, 7, 11, 19]),
    (11, &[1, 1, 5, 1, 1]),
    (13, &[1, 1, 1, 3, 11]),
    (14, &[1, 3, 5, 5, 31]),
];

/// Direction numbers of a dimension as binary fractions: number k has its last digit at position k
/// + 1.
fn directions(dimension: usize) -> [u32; DIGITS] {
    let fraction = |number: u32, k: usize| number << (DIGITS - 1 - k);
    let Some((coefficients, first)) = dimension.checked_sub(1).map(|d| POLYNOMIALS[d]) else {
        return std::array::from_fn(|k| fraction(1, k));
    };
    let degree = first.len();
    let mut all = [0; DIGITS];
    for k in 0..DIGITS {
        all[k] = match first.get(k) {
            Some(number) => fraction(*number, k),
            None => {
                // Bratley and Fox, ACM Algorithm 659, equation (2).
                let inner = (1..degree).filter(|i| coefficients >> (degree - 1 - i) & 1 == 1);
                inner.fold(all[k - degree] ^ (all[k - degree] >> degree), |sum, i| sum ^ all[k - i])
            }
        };
    }
    all
}

/// Coordinate of a point in a dimension below [`DIMENSIONS`], in [0, 1). The point of index 0 is
/// the origin.
///
/// ```
/// use vibro_studies::sobol::coordinate;
///
/// let points: Vec<[f64; 2]> = (0..4).map(|i| [coordinate(i, 0), coordinate(i, 1)]).collect();
/// assert_eq!(points, [[0.0, 0.0], [0.5, 0.5], [0.75, 0.25], [0.25, 0.75]]);
/// ```
///
/// # Panics
/// If `dimension` is [`DIMENSIONS`] or more.
pub fn coordinate(index: u32, dimension: usize) -> f64 {
    let gray = index ^ (index >> 1);
    let directions = directions(dimension);
    let bits = (0..DIGITS).filter(|k| gray >> k & 1 == 1).fold(0, |sum, k| sum ^ directions[k]);
    f64::from(bits) / (1u64 << DIGITS) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_file_the_points_of_scipy() {
        // scipy.stats.qmc.Sobol(13, scramble=False) of SciPy 1.17.1: the first 64 points, and
        // three beyond a million.
        let mut rows = include_str!("sobol.scipy.csv").lines();
        assert!(rows.next().is_some_and(|header| header.starts_with("index")));
        let mut count = 0;
        for row in rows {
            let mut cells = row.split(',');
            let index = cells.next().unwrap().parse().unwrap();
            for (dimension, cell) in cells.enumerate() {
                let expected: f64 = cell.parse().unwrap();
                assert_eq!(coordinate(index, dimension), expected, "{index}, {dimension}");
                count += 1;
            }
        }
        assert_eq!(count, 67 * DIMENSIONS);
    }
}
