use super::*;

/// Pseudorandom numbers in [-1, 1], bit-identical on all machines.
fn noise(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// A window of x = shift + y with y' = memory y + noise, equal in all coordinates.
fn window(seed: u64, periods: u32, memory: f64, shift: f64) -> Blocks {
    let (mut next, mut blocks, mut y) = (noise(seed), Blocks::default(), 0.0);
    for _ in 0..periods {
        y = memory * y + next();
        blocks.add(&[shift + y; 6], &[y - shift; 6]);
    }
    blocks
}

#[test]
fn closed_form_standard_error_of_correlated_numbers() {
    // The mean of an autoregressive process: the noise has variance 1/3, the mean an error of
    // 1/(1 - memory) √(1/3N).
    const PERIODS: u32 = 16_384;
    /// Limits of the ratio of estimated to true error: blocks of an eighth of the window give
    /// their scatter to a quarter, and the largest of several is used.
    const LEAST: f64 = 0.8;
    const MOST: f64 = 2.0;
    for memory in [0.0, 0.9, 0.98] {
        let closed = (1.0 / (3.0 * f64::from(PERIODS))).sqrt() / (1.0 - memory);
        for seed in 1..=8 {
            let found = window(seed, PERIODS, memory, 0.0).statistics().means[0][0];
            let ratio = found.error / closed;
            assert!((LEAST..MOST).contains(&ratio), "{memory} {seed}: {ratio}");
            assert!(found.value.abs() < CONFIDENCE * found.error, "{memory} {seed}: {found:?}");
        }
    }
}

#[test]
fn closed_form_windows_of_one_process_are_alike_and_of_two_are_not() {
    let found = |seed, periods, shift| window(seed, periods, 0.8, shift).statistics();
    let long = found(1, 32_768, 0.5);
    for seed in 2..40 {
        // Never different, however short the window; certainly the same when it is long.
        assert_ne!(found(seed, 128, 0.5).likeness(&long), Likeness::Different, "{seed}");
        assert_eq!(found(seed, 16_384, 0.5).likeness(&long), Likeness::Same, "{seed}");
        // The mirror image has the opposite shift.
        assert_ne!(found(seed, 128, -0.5).likeness(&long), Likeness::Same, "{seed}");
        assert_eq!(found(seed, 4096, -0.5).likeness(&long), Likeness::Different, "{seed}");
        assert_eq!(found(seed, 16_384, -0.5).likeness(&long.mirrored()), Likeness::Same, "{seed}");
    }
    // Too few blocks for a scatter.
    assert_eq!(found(1, 48, 0.5).likeness(&long), Likeness::Undecided);
}

#[test]
fn invariant_windows_put_together_are_the_whole() {
    let mut first = Blocks::default();
    let mut whole = Blocks::default();
    let (mut next, mut second) = (noise(3), Blocks::default());
    for k in 0..400 {
        let (a, b) = ([next(); 6], [next(); 6]);
        whole.add(&a, &b);
        if k < 256 { first.add(&a, &b) } else { second.add(&a, &b) }
    }
    let pooled = first.statistics().pooled(&second.statistics());
    for (p, w) in pooled.means.iter().flatten().zip(whole.statistics().means.iter().flatten()) {
        assert!((p.value - w.value).abs() < 1e-14 && (p.deviation - w.deviation).abs() < 1e-14);
    }
    first.append(second);
    for (a, w) in first.statistics().means.iter().flatten().zip(whole.statistics().means.iter().flatten()) {
        assert!((a.value - w.value).abs() < 1e-14 && (a.error / w.error - 1.0).abs() < 1e-12);
    }
    assert_eq!(first.periods(), 400);
}
