//! Recurrences for the power series of operations other than polynomials.
//!
//! Each operation w(a) fulfils w' = g a' with a series g = dw/da of its own.

use super::Operation;

/// Cap on the coefficients of a series. For straight laws and rate times length 4, the first
/// omitted term is below 4⁴⁰/40! < 2e-24 of the largest coordinate.
pub const TERMS: usize = 40;

/// Coefficients of an operation by order. In the majorant's series all are sizes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coefficients<'a> {
    /// First argument.
    pub a: &'a [f64; TERMS],
    /// Second argument.
    pub b: &'a [f64; TERMS],
}

/// Σ aⱼ bₖ₋ⱼ over j from `first` to k.
#[inline(always)]
fn product(a: &[f64; TERMS], b: &[f64; TERMS], (first, k): (usize, usize)) -> f64 {
    a[first..=k].iter().zip(b[..=k - first].iter().rev()).map(|(a, b)| a * b).sum()
}

/// Σ j aⱼ gₖ₋ⱼ / k over j from 1 to k: the coefficient of order k of w, if w' = g a'.
#[inline(always)]
fn integral(a: &[f64; TERMS], g: &[f64; TERMS], k: usize) -> f64 {
    let terms = a[1..=k].iter().zip(g[..k].iter().rev()).enumerate();
    terms.map(|(i, (a, g))| (i + 1) as f64 * a * g).sum::<f64>() / k as f64
}

/// The coefficient of order k of a^p. The sizes of all factors are used if `is_majorant` is true.
#[inline(always)]
fn power(a: &[f64; TERMS], w: &[f64; TERMS], (p, is_majorant): (f64, bool), k: usize) -> f64 {
    let weight = |j: usize| {
        let weight = p * j as f64 + j as f64 - k as f64;
        if is_majorant { weight.abs() } else { weight }
    };
    let sum: f64 = (1..=k).map(|j| weight(j) * a[j] * w[k - j]).sum();
    sum / (k as f64 * if is_majorant { a[0].abs() } else { a[0] })
}

/// Coefficients of order k of the operation's value w, of its slope g, and of a helper q. All
/// lower orders are set. If `is_majorant` is true, the coefficients of order 1 and above are
/// sizes, and no terms cancel.
#[inline(always)]
pub(super) fn next(
    (operation, is_majorant): (&Operation, bool),
    Coefficients { a, b }: Coefficients,
    [w, g, q]: [&mut [f64; TERMS]; 3],
    k: usize,
) {
    let minus = if is_majorant { 1.0 } else { -1.0 };
    if k == 0 {
        let arguments = [a[0], b[0]];
        (w[0], g[0]) = (operation.value(arguments), operation.slopes(arguments)[0]);
        q[0] = 1.0 + a[0] * a[0];
        if is_majorant {
            (w[0], g[0]) = (w[0].abs(), g[0].abs());
        }
        return;
    }
    match operation {
        // Each of these is another operation on a side of 0.
        Operation::Polynomial(_) | Operation::OneSided(_) | Operation::TwoSided(_) | Operation::Decay => {}
        Operation::Product => w[k] = product(a, b, (0, k)),
        Operation::Power(p) => {
            w[k] = power(a, w, (*p, is_majorant), k);
            g[k] = power(a, g, (p - 1.0, is_majorant), k);
        }
        Operation::Exponential => {
            w[k] = integral(a, w, k);
            g[k] = w[k];
        }
        Operation::Logarithm => {
            w[k] = integral(a, g, k);
            g[k] = minus * product(a, g, (1, k)) / a[0];
        }
        Operation::Sine | Operation::Cosine => {
            let slope = minus * integral(a, w, k);
            w[k] = integral(a, g, k);
            g[k] = slope;
        }
        Operation::HyperbolicTangent => {
            w[k] = integral(a, g, k);
            g[k] = minus * product(w, w, (0, k));
        }
        Operation::Arctangent => {
            q[k] = match is_majorant {
                true => product(a, a, (1, k)) + (2.0 * a[0].abs() - a[0]) * a[k],
                false => product(a, a, (0, k)),
            };
            w[k] = integral(a, g, k);
            g[k] = minus * product(q, g, (1, k)) / q[0];
        }
    }
}
