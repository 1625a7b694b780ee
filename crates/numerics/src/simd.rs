//! Small products and polynomials in vectors, with the instruction set chosen at run time by
//! `pulp`. Multiply-add is fused if the machine has the instruction, so the last digits may differ
//! between machines.

use pulp::Simd;

/// Number of lanes of the widest products.
const WIDE: usize = 16;

/// Number of orders of the polynomial of w in flight, padded to whole vectors.
pub const PADDED: usize = 16;

/// p(u). Even and odd orders are summed separately, in two chains of dependent operations.
#[inline(always)]
pub fn value<const N: usize>(c: &[f64; N], u: f64) -> f64 {
    let square = u * u;
    let (mut even, mut odd) = (0.0, 0.0);
    for k in (0..N).rev() {
        let sum = if k % 2 == 0 { &mut even } else { &mut odd };
        *sum = *sum * square + c[k];
    }
    even + u * odd
}

/// a b + c, rounded once if the machine has the instruction. WebAssembly does not: `f64::mul_add`
/// would call a function of about a hundred operations there.
#[inline(always)]
pub fn multiply_add<S: Simd>(a: f64, b: f64, c: f64) -> f64 {
    if S::IS_SCALAR || cfg!(target_family = "wasm") { a * b + c } else { a.mul_add(b, c) }
}

/// `Σ_j columns[j] x_j` in V vectors; only the first `W/F64_LANES` are used. Even and odd columns
/// are summed separately, which halves the chain of dependent operations.
#[inline(always)]
fn combine<S: Simd, const W: usize, const V: usize>(
    simd: S,
    columns: &[[f64; W]; 8],
    x: &[f64; 8],
) -> [S::f64s; V] {
    let vectors = W / S::F64_LANES;
    let zero = simd.splat_f64s(0.0);
    let (mut first, mut second) = ([zero; V], [zero; V]);
    if cfg!(target_family = "wasm") {
        // WebAssembly has vectors of two numbers and few registers. The two sums of one vector fit
        // into registers; the sums of all vectors do not.
        let x = x.map(|x| simd.splat_f64s(x));
        for (v, sum) in first.iter_mut().enumerate().take(vectors) {
            let at = |j: usize| S::as_simd_f64s(&columns[j]).0[v];
            let (mut even, mut odd) = (simd.mul_f64s(at(0), x[0]), simd.mul_f64s(at(1), x[1]));
            for j in 1..4 {
                even = simd.mul_add_e_f64s(at(2 * j), x[2 * j], even);
                odd = simd.mul_add_e_f64s(at(2 * j + 1), x[2 * j + 1], odd);
            }
            *sum = simd.add_f64s(even, odd);
        }
        return first;
    }
    for j in 0..4 {
        let (even, _) = S::as_simd_f64s(&columns[2 * j]);
        let (odd, _) = S::as_simd_f64s(&columns[2 * j + 1]);
        let (x0, x1) = (simd.splat_f64s(x[2 * j]), simd.splat_f64s(x[2 * j + 1]));
        for v in 0..vectors {
            if j == 0 {
                first[v] = simd.mul_f64s(even[v], x0);
                second[v] = simd.mul_f64s(odd[v], x1);
            } else {
                first[v] = simd.mul_add_e_f64s(even[v], x0, first[v]);
                second[v] = simd.mul_add_e_f64s(odd[v], x1, second[v]);
            }
        }
    }
    for v in 0..vectors {
        first[v] = simd.add_f64s(first[v], second[v]);
    }
    first
}

/// `Σ_j columns[j] x_j` for columns of 8 or 16 lanes.
#[inline(always)]
pub fn product<S: Simd, const W: usize>(simd: S, columns: &[[f64; W]; 8], x: &[f64; 8]) -> [f64; W] {
    let mut out = [0.0; W];
    let sums = combine::<S, W, WIDE>(simd, columns, x);
    let (vectors, _) = S::as_mut_simd_f64s(&mut out);
    for (vector, sum) in vectors.iter_mut().zip(sums) {
        *vector = sum;
    }
    out
}

/// Coefficients of 8 polynomials, one row per order; only the first `8/F64_LANES` vectors are
/// used.
pub type StateRows<S, const N: usize> = [[<S as Simd>::f64s; 8]; N];

/// `Σ_j columns[j] x_j` as a row of [`StateRows`].
#[inline(always)]
pub fn row<S: Simd>(simd: S, columns: &[[f64; 8]; 8], x: &[f64; 8]) -> [S::f64s; 8] {
    combine::<S, 8, 8>(simd, columns, x)
}

/// `Σ_k rows[k] u^k` lane by lane. Even and odd orders are summed separately: two chains of
/// dependent operations instead of one.
#[inline(always)]
fn evaluate<S: Simd, const N: usize>(simd: S, rows: &StateRows<S, N>, u: f64) -> [S::f64s; 8] {
    let zero = simd.splat_f64s(0.0);
    let (at, square) = (simd.splat_f64s(u), simd.splat_f64s(u * u));
    let (mut even, mut odd) = ([zero; 8], [zero; 8]);
    for k in (0..N).rev() {
        let sum = if k % 2 == 0 { &mut even } else { &mut odd };
        for v in 0..8 / S::F64_LANES {
            sum[v] = if k + 2 >= N { rows[k][v] } else { simd.mul_add_e_f64s(sum[v], square, rows[k][v]) };
        }
    }
    for v in 0..8 / S::F64_LANES {
        even[v] = simd.mul_add_e_f64s(odd[v], at, even[v]);
    }
    even
}

/// Values of the polynomials `rows` at u.
#[inline(always)]
pub fn polynomial<S: Simd, const N: usize>(simd: S, rows: &StateRows<S, N>, u: f64) -> [f64; 8] {
    let mut out = [0.0; 8];
    let values = evaluate(simd, rows, u);
    let (lanes, _) = S::as_mut_simd_f64s(&mut out);
    for (lane, value) in lanes.iter_mut().zip(values) {
        *lane = value;
    }
    out
}

/// Quadratic form xᵀ columns x.
#[inline(always)]
pub fn form<S: Simd>(simd: S, columns: &[[f64; 8]; 8], x: &[f64; 8]) -> f64 {
    let sums = combine::<S, 8, 8>(simd, columns, x);
    let (x, _) = S::as_simd_f64s(x);
    let mut sum = simd.mul_f64s(sums[0], x[0]);
    for v in 1..x.len() {
        sum = simd.mul_add_e_f64s(sums[v], x[v], sum);
    }
    simd.reduce_sum_f64s(sum)
}

/// Adds to `total`, lane by lane, the terms of two sums: the quadratic form, if given, and the
/// integral of `Σ_lane weights · p²` over an interval of length `length`. Over the interval, the
/// argument of the polynomials p in `rows` goes from 0 to u; `end` is p(u). The integral uses the
/// four-node Lobatto rule.
#[inline(always)]
pub fn form_and_squares<S: Simd, const N: usize>(
    simd: S,
    form: Option<(&[[f64; 8]; 8], &[f64; 8])>,
    rows: &StateRows<S, N>,
    (u, end): (f64, &[f64; 8]),
    length: f64,
    weights: &[f64; 8],
    total: &mut [f64; 8],
) {
    /// First inner node of the Lobatto rule, (1 - 1/√5)/2.
    const NODE: f64 = 0.276_393_202_250_021;
    /// Weight at the ends.
    const ENDS: f64 = 1.0 / 12.0;
    /// Weight at the inner nodes.
    const INSIDE: f64 = 5.0 / 12.0;
    // The form comes first, as it does not depend on a pending result.
    let mut before = [simd.splat_f64s(0.0); 8];
    if let Some((columns, x)) = form {
        let sums = combine::<S, 8, 8>(simd, columns, x);
        let (x, _) = S::as_simd_f64s(x);
        for v in 0..x.len() {
            before[v] = simd.mul_f64s(sums[v], x[v]);
        }
    }
    let near = evaluate(simd, rows, u * NODE);
    let far = evaluate(simd, rows, u * (1.0 - NODE));
    let ((weights, _), (end, _)) = (S::as_simd_f64s(weights), S::as_simd_f64s(end));
    let (at_ends, inside) = (simd.splat_f64s(ENDS * length), simd.splat_f64s(INSIDE * length));
    let (total, _) = S::as_mut_simd_f64s(total);
    for v in 0..weights.len() {
        let start = rows[0][v];
        let ends = simd.mul_add_e_f64s(end[v], end[v], simd.mul_f64s(start, start));
        let middle = simd.mul_add_e_f64s(near[v], near[v], simd.mul_f64s(far[v], far[v]));
        let squares = simd.mul_add_e_f64s(middle, inside, simd.mul_f64s(ends, at_ends));
        total[v] = simd.add_f64s(total[v], simd.mul_add_e_f64s(squares, weights[v], before[v]));
    }
}

/// Bits of the lanes with |x| ≥ limit, the first lane's the lowest.
#[inline(always)]
pub fn at_least<S: Simd>(simd: S, x: &[f64; 16], limit: f64) -> u64 {
    const BITS: [u64; 16] = {
        let mut bits = [0; 16];
        let mut lane = 0;
        while lane < 16 {
            bits[lane] = 1 << lane;
            lane += 1;
        }
        bits
    };
    let (x, _) = S::as_simd_f64s(x);
    let (bits, _) = S::as_simd_u64s(&BITS);
    let (limit, none) = (simd.splat_f64s(limit), simd.splat_u64s(0));
    let mut found = none;
    for (x, bit) in x.iter().zip(bits) {
        let near = simd.greater_than_or_equal_f64s(simd.abs_f64s(*x), limit);
        found = simd.or_u64s(found, simd.select_u64s(near, *bit, none));
    }
    let mut lanes = [0; 8];
    let (first, _) = S::as_mut_simd_u64s(&mut lanes);
    first[0] = found;
    (lanes[0] | lanes[1] | lanes[2] | lanes[3]) | (lanes[4] | lanes[5] | lanes[6] | lanes[7])
}

/// side · x, with `gap` subtracted in the first lane.
#[inline(always)]
pub fn excess_over<S: Simd>(simd: S, x: &[f64; 16], side: f64, gap: f64) -> [f64; 16] {
    let mut out = [0.0; 16];
    let (by, (x, _)) = (simd.splat_f64s(side), S::as_simd_f64s(x));
    let (y, _) = S::as_mut_simd_f64s(&mut out);
    for v in 0..x.len() {
        y[v] = simd.mul_f64s(x[v], by);
    }
    out[0] -= gap;
    out
}

/// Products x y lane by lane, and the sums Σ |x y| and Σ |x y| weight.
#[inline(always)]
pub fn weighted<S: Simd>(
    simd: S,
    x: &[f64; 16],
    y: &[f64; 16],
    weights: &[f64; 16],
) -> ([f64; 16], f64, f64) {
    let mut out = [0.0; 16];
    let ((x, _), (y, _), (w, _)) = (S::as_simd_f64s(x), S::as_simd_f64s(y), S::as_simd_f64s(weights));
    let (z, _) = S::as_mut_simd_f64s(&mut out);
    let (mut sum, mut weighted) = (simd.splat_f64s(0.0), simd.splat_f64s(0.0));
    for v in 0..x.len() {
        z[v] = simd.mul_f64s(x[v], y[v]);
        let size = simd.abs_f64s(z[v]);
        sum = simd.add_f64s(sum, size);
        weighted = simd.mul_add_e_f64s(size, w[v], weighted);
    }
    (out, simd.reduce_sum_f64s(sum), simd.reduce_sum_f64s(weighted))
}

/// Σ_j |x_j| weight_j, without vectors: x has just been written lane by lane, and loading whole
/// vectors would wait for it.
#[inline(always)]
pub fn weigh<S: Simd>(x: &[f64; 8], weights: &[f64; 8]) -> f64 {
    let (mut even, mut odd) = (x[0].abs() * weights[0], x[1].abs() * weights[1]);
    for j in 1..4 {
        even = multiply_add::<S>(x[2 * j].abs(), weights[2 * j], even);
        odd = multiply_add::<S>(x[2 * j + 1].abs(), weights[2 * j + 1], odd);
    }
    even + odd
}
