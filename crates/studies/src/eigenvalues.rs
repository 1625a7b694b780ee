//! Eigenvalues of a real matrix, such as the linear system of a contact mode. A real part within
//! rounding error is set to zero.

use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, DMatrix};

/// Tolerance for a real part that counts as zero, in units of machine epsilon times the Frobenius
/// norm of the balanced matrix. The largest error found was 1.1, for two bars of 121 elements.
const ROUNDINGS: f64 = 8.0;

/// The eigenvalues of a matrix, 1/s. A real part within rounding is 0, so that an oscillation
/// without damping has a damping ratio of 0.
///
/// The matrix is first balanced by powers of 2. A rate is larger than its position by a factor of
/// the frequency. Without balancing the error would be relative to the largest squared frequency.
///
/// An oscillator with ω = 2 rad/s and a damping ratio of 0.6:
///
/// ```
/// use nalgebra::DMatrix;
/// use vibro_studies::eigenvalues;
///
/// let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -4.0, -2.4]);
/// let found = eigenvalues(a);
/// assert!(found.iter().all(|x| (x.re + 1.2).abs() < 1e-15));
/// assert!(found.iter().all(|x| (x.im.abs() - 1.6).abs() < 1e-15));
/// ```
pub fn eigenvalues(mut a: DMatrix<f64>) -> Vec<Complex<f64>> {
    balance_parlett_reinsch(&mut a);
    let rounding = ROUNDINGS * f64::EPSILON * a.norm();
    let of = |c: &Complex<f64>| Complex::new(if c.re.abs() <= rounding { 0.0 } else { c.re }, c.im);
    a.complex_eigenvalues().iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of masses of 1 kg on springs of 1 N/m, the first one of `stiff` N/m. Each spring of
    /// stiffness k has a parallel dashpot of `damping` k (`damping` in s).
    fn chain(count: usize, stiff: f64, damping: f64) -> DMatrix<f64> {
        let k = |i: usize| if i == 0 { stiff } else { 1.0 };
        DMatrix::from_fn(2 * count, 2 * count, |row, column| {
            if row < count {
                return f64::from(u8::from(column == row + count));
            }
            let (i, j) = (row - count, column % count);
            let scale = if column < count { 1.0 } else { damping };
            let next = if i + 1 < count { k(i + 1) } else { 0.0 };
            scale
                * match (i, j) {
                    _ if i == j => -k(i) - next,
                    _ if i == j + 1 => k(i),
                    _ if j == i + 1 => k(j),
                    _ => 0.0,
                }
        })
    }

    #[test]
    fn closed_form_a_chain_without_damping_has_no_real_part_and_one_with_has_its_own() {
        for stiff in [1.0, 1e11] {
            assert!(eigenvalues(chain(60, stiff, 0.0)).iter().all(|c| c.re == 0.0), "{stiff}");
        }
        // Rayleigh damping β K gives the real part -β ω²/2.
        let beta = 1e-9;
        for value in eigenvalues(chain(20, 1.0, beta)) {
            let exact = -0.5 * beta * value.norm_sqr();
            // Eight roundings of the norm, which is about 10. The smallest real part is 3e-12.
            assert!((value.re - exact).abs() < 2e-14, "{value} {exact:e}");
        }
    }
}
