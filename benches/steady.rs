//! Steady states: one point of each theory, and a plane. Targets: a fixed point with all tests ≤ 2
//! µs, an exact orbit with multipliers ≤ 20 µs, a 1000 × 1000 plane by multiple scales in seconds
//! on two cores.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use vibro_impact::steady::{exact_orbit, multiple_scales, strong_coupling};
use vibro_impact::{Groups, Parameters};
use vibro_studies::paper::plane::{Method, ParameterAxis, plane};
use vibro_studies::paper::{ParameterSet, find_group};

fn points(c: &mut Criterion) {
    let (groups, parameters) = (Groups::basic(), Parameters::default());
    c.bench_function("multiple scales, both fixed points with all tests", |b| {
        b.iter(|| multiple_scales::fixed_points(black_box(&groups)))
    });
    c.bench_function("strong coupling, both states with all tests", |b| {
        b.iter(|| strong_coupling::solve(black_box(&groups)))
    });
    c.bench_function("exact orbit with multipliers and clearance", |b| {
        b.iter(|| exact_orbit::solve(black_box(&parameters)))
    });
}

fn planes(c: &mut Criterion) {
    let axis = |name: &str| {
        let group = find_group(name).expect("a group");
        ParameterAxis::new(group, group.shown, 1000).expect("an axis")
    };
    let (x, y, set) = (axis("sigma1"), axis("f10"), ParameterSet::basic());
    let mut group = c.benchmark_group("plane");
    group.sample_size(10);
    group.bench_function("1000 x 1000 by multiple scales", |b| {
        b.iter(|| plane(&set, x, y, Method::MultipleScales, &|| ()))
    });
    group.finish();
}

criterion_group!(benches, points, planes);
criterion_main!(benches);
