//! Modes against closed forms: none is missed, none is wrong.

mod common;

use common::{Solid, chain, grid};
use std::f64::consts::PI;
use vibro_reduce::eigen::{Check, lowest};
use vibro_reduce::reduction::{Method, reduce};
use vibro_reduce::shift::factorise;

/// Eigenvalues of solids: rounding of K by its condition, some 1e5.
const EXACT: f64 = 1e-10;
/// Eigenvalues of a beam of 40 elements or more: its discretisation, and for 600 elements rounding
/// by the condition of K, some 1e11.
const BEAM: f64 = 2e-5;

#[test]
fn closed_form_all_modes_of_a_chain() {
    let count = 60;
    let model = chain(&vec![2.0; count], &vec![800.0; count]);
    let reduced = reduce(&model, &[], Method::MacNeal, count).unwrap();
    assert_eq!(reduced.values.len(), count);
    for (k, value) in reduced.values.iter().enumerate() {
        let angle = PI * (2 * k + 1) as f64 / (2 * count + 1) as f64;
        let exact = 800.0 / 2.0 * (2.0 - 2.0 * angle.cos());
        assert!((value / exact - 1.0).abs() < EXACT, "{k} {value} {exact}");
    }
}

#[test]
fn closed_form_a_free_chain_has_one_rigid_mode() {
    let count = 50;
    let springs: Vec<f64> = (0..count).map(|i| if i == 0 { 0.0 } else { 800.0 }).collect();
    let model = chain(&vec![2.0; count], &springs);
    let reduced = reduce(&model, &[], Method::MacNeal, 20).unwrap();
    assert_eq!((reduced.rigid, reduced.values[0]), (1, 0.0));
    for (k, value) in reduced.values.iter().enumerate().skip(1) {
        let exact = 800.0 / 2.0 * (2.0 - 2.0 * (PI * k as f64 / count as f64).cos());
        assert!((value / exact - 1.0).abs() < EXACT, "{k} {value} {exact}");
    }
}

#[test]
fn closed_form_a_solid_between_mirrors_has_every_mode() {
    let solid = Solid::steel([9, 7, 5], [0.09, 0.08, 0.07]);
    let model = solid.between_mirrors();
    let exact = solid.mirrored_values();
    assert_eq!(exact.len(), model.dofs.len());
    let reduced = reduce(&model, &[], Method::MacNeal, 60).unwrap();
    for (k, (value, exact)) in reduced.values.iter().zip(&exact).enumerate() {
        assert!((value / exact - 1.0).abs() < EXACT, "{k} {value} {exact}");
    }
    let (_, counted) = reduced.modes.counted.expect("not all modes");
    assert!(counted >= 60);
}

#[test]
fn closed_form_a_cube_between_mirrors_has_its_multiple_modes() {
    let solid = Solid::steel([5, 5, 5], [0.1, 0.1, 0.1]);
    let model = solid.between_mirrors();
    let exact = solid.mirrored_values();
    let problem = factorise(&model.stiffness, &model.mass, &|i| i.to_string()).unwrap();
    for wanted in [1, 5, 17, 64] {
        let modes = lowest(&problem, wanted, Check::Inertia).unwrap();
        for (value, exact) in modes.values.iter().zip(&exact) {
            assert!((value / exact - 1.0).abs() < EXACT, "{wanted} {value} {exact}");
        }
    }
}

#[test]
fn invariant_a_free_solid_has_six_rigid_modes() {
    let model = Solid::steel([8, 3, 2], [0.2, 0.06, 0.03]).model();
    let reduced = reduce(&model, &[], Method::MacNeal, 14).unwrap();
    assert_eq!(reduced.rigid, 6);
    assert!(reduced.values[6] > 0.0 && reduced.values[..6].iter().all(|value| *value == 0.0));
    // Of mass 1, and orthogonal.
    let unit = reduced.basis.tr_mul(&model.mass.times(&reduced.basis));
    assert!((unit - nalgebra::DMatrix::identity(14, 14)).amax() < EXACT);
}

/// Beam elements of unit length, stiffness and mass per length; `clamped` holds the first node.
fn beam(elements: usize, clamped: bool) -> vibro_reduce::model::Model {
    let k =
        [[12.0, 6.0, -12.0, 6.0], [6.0, 4.0, -6.0, 2.0], [-12.0, -6.0, 12.0, -6.0], [6.0, 2.0, -6.0, 4.0]];
    let m = [
        [156.0, 22.0, 54.0, -13.0],
        [22.0, 4.0, 13.0, -3.0],
        [54.0, 13.0, 156.0, -22.0],
        [-13.0, -3.0, -22.0, 4.0],
    ];
    let matrix = |block: &[[f64; 4]; 4], factor: f64| -> common::Triplets {
        let mut sums = std::collections::BTreeMap::new();
        for e in 0..elements {
            for (i, row) in block.iter().enumerate() {
                for (j, x) in row[..=i].iter().enumerate() {
                    *sums.entry((2 * e + i, 2 * e + j)).or_insert(0.0) += factor * x;
                }
            }
        }
        sums.into_iter().map(|((i, j), x)| (i, j, x)).collect()
    };
    let count = 2 * elements + 2;
    let dofs = vibro_reduce::dofs::Dofs::numbered(count);
    let model = common::model(count, &matrix(&k, 1.0), &matrix(&m, 1.0 / 420.0), dofs);
    model.clamp(if clamped { &[0, 1] } else { &[] }).unwrap()
}

#[test]
fn closed_form_long_beams_are_held_or_free() {
    // Roots of cos x cosh x = -1 and 1.
    for (clamped, roots, rigid) in
        [(true, [1.875_104_068_7, 4.694_091_133], 0), (false, [4.730_040_744_9, 7.853_204_624_1], 2)]
    {
        for elements in [40, 200, 600] {
            let reduced = reduce(&beam(elements, clamped), &[], Method::MacNeal, 4).unwrap();
            assert_eq!(reduced.rigid, rigid, "{elements}");
            let length = elements as f64;
            for (value, root) in reduced.values[rigid..].iter().zip(roots) {
                let exact = (root / length).powi(4);
                assert!((value / exact - 1.0).abs() < BEAM, "{elements} {clamped} {value} {exact}");
            }
        }
    }
}

#[test]
fn closed_form_a_grid_of_masses_has_its_multiple_modes() {
    let (model, exact) = grid(9);
    for wanted in [1, 2, 3, 20, 150] {
        let reduced = reduce(&model, &[], Method::MacNeal, wanted).unwrap();
        assert_eq!(reduced.values.len(), wanted);
        for (value, exact) in reduced.values.iter().zip(&exact) {
            assert!((value / exact - 1.0).abs() < EXACT, "{wanted} {value} {exact}");
        }
    }
}
