//! Static and residual flexibility, and what Rubin's and Craig and Bampton's bodies keep, against
//! dense matrices.

mod common;

use common::{Solid, chain};
use nalgebra::DMatrix;
use vibro_reduce::interface::Interface;
use vibro_reduce::model::Model;
use vibro_reduce::reduction::{Method, Reduced, reduce};
use vibro_reduce::sparse::Symmetric;

/// Flexibilities: the dense inverse rounds by the condition of K, some 1e6.
const DENSE: f64 = 1e-8;

fn dense(a: &Symmetric) -> DMatrix<f64> {
    a.times(&DMatrix::identity(a.count(), a.count()))
}

/// A cantilever with two interface nodes.
fn cantilever() -> (Model, Vec<Interface>) {
    let solid = Solid::steel([10, 2, 2], [0.2, 0.03, 0.02]);
    let root = solid.rows(&[0, 1, 2], |at| at[0] == 0);
    let model = solid.model().clamp(&root).unwrap();
    let tip = solid.node([10, 2, 2]) + 1;
    let side = solid.node([5, 0, 1]) + 1;
    let nodes = [format!("tip={tip}"), format!("side={side}.zx")];
    let read = |text: &String| Interface::read(text, &model.dofs, &model.clamped).unwrap();
    let interfaces = nodes.iter().map(read).collect();
    (model, interfaces)
}

fn rows(interfaces: &[Interface]) -> Vec<usize> {
    interfaces.iter().flat_map(|own| own.dofs.iter().map(|(_, row)| *row)).collect()
}

fn near(one: &DMatrix<f64>, other: &DMatrix<f64>, tolerance: f64) {
    let error = (one - other).amax() / other.amax();
    assert!(error < tolerance, "{error:.2e}");
}

/// Φ Ω⁻² Φᵀ at the rows.
fn kept(reduced: &Reduced) -> DMatrix<f64> {
    let terms =
        DMatrix::from_fn(reduced.rows.nrows(), reduced.values.len(), |i, j| match reduced.values[j] {
            0.0 => 0.0,
            value => reduced.rows[(i, j)] / value,
        });
    terms * reduced.rows.transpose()
}

#[test]
fn second_method_flexibilities_are_those_of_the_dense_inverse() {
    let (model, interfaces) = cantilever();
    let at = rows(&interfaces);
    let inverse = dense(&model.stiffness).try_inverse().unwrap();
    let full = DMatrix::from_fn(at.len(), at.len(), |i, j| inverse[(at[i], at[j])]);
    let reduced = reduce(&model, &interfaces, Method::MacNeal, 12).unwrap();
    near(&reduced.flexibility, &full, DENSE);
    near(&reduced.residual, &(&full - kept(&reduced)), DENSE);
    assert!(reduced.residual.clone().symmetric_eigenvalues().min() > 0.0);
}

#[test]
fn second_method_the_flexibility_of_a_free_body_is_that_of_its_elastic_modes() {
    let solid = Solid::steel([6, 2, 1], [0.2, 0.05, 0.02]);
    let model = solid.model();
    let read = |text: &str| Interface::read(text, &model.dofs, &model.clamped).unwrap();
    let interfaces = vec![read("a=1"), read(&format!("b={}", solid.nodes()))];
    let at = rows(&interfaces);
    // All modes by a dense solver: those that are not rigid, summed.
    let root = dense(&model.mass).cholesky().unwrap().l().try_inverse().unwrap();
    let all = (&root * dense(&model.stiffness) * root.transpose()).symmetric_eigen();
    let shapes = root.transpose() * all.eigenvectors;
    let largest = all.eigenvalues.amax();
    let mut full = DMatrix::zeros(at.len(), at.len());
    for (k, value) in all.eigenvalues.iter().enumerate().filter(|(_, value)| **value > 1e-10 * largest) {
        let row = DMatrix::from_fn(at.len(), 1, |i, _| shapes[(at[i], k)]);
        full += &row * row.transpose() / *value;
    }
    let reduced = reduce(&model, &interfaces, Method::MacNeal, 10).unwrap();
    assert_eq!(reduced.rigid, 6);
    near(&reduced.flexibility, &full, DENSE);
    near(&reduced.residual, &(&full - kept(&reduced)), DENSE);
}

#[test]
fn invariant_rubin_and_craig_bampton_keep_the_whole_static_flexibility() {
    let (model, interfaces) = cantilever();
    let exact = reduce(&model, &[], Method::MacNeal, 20).unwrap();
    for method in [Method::Rubin, Method::CraigBampton] {
        let reduced = reduce(&model, &interfaces, method, 12).unwrap();
        assert_eq!(reduced.values.len(), 12 + rows(&interfaces).len());
        near(&kept(&reduced), &reduced.flexibility, DENSE);
        assert!(reduced.residual.amax() < DENSE * reduced.flexibility.amax());
        // Coordinates of mass 1 that are orthogonal in K, too.
        let m = reduced.basis.tr_mul(&model.mass.times(&reduced.basis));
        near(&m, &DMatrix::identity(m.nrows(), m.nrows()), DENSE);
        let k = reduced.basis.tr_mul(&model.stiffness.times(&reduced.basis));
        near(&k, &DMatrix::from_diagonal(&reduced.values.clone().into()), DENSE);
        // By Rayleigh and Ritz no frequency is below the exact one.
        for (own, exact) in reduced.values.iter().zip(&exact.values) {
            assert!(own / exact > 1.0 - DENSE, "{method:?} {own} {exact}");
        }
    }
}

#[test]
fn second_method_errors_of_craig_bamptons_frequencies() {
    let (model, interfaces) = cantilever();
    let exact = reduce(&model, &[], Method::MacNeal, 10).unwrap().values;
    let reduced = reduce(&model, &interfaces, Method::CraigBampton, 20).unwrap().values;
    let error = |k: usize| reduced[k] / exact[k] - 1.0;
    // The error rises with the mode, and falls with the number of fixed-interface modes.
    let fewer = reduce(&model, &interfaces, Method::CraigBampton, 8).unwrap().values;
    assert!(error(0).abs() < 1e-4 && error(4).abs() < 1e-2, "{} {}", error(0), error(4));
    assert!((0..8).all(|k| fewer[k] > reduced[k] * (1.0 - DENSE)));
}

#[test]
fn second_method_craig_bampton_of_a_free_chain_has_its_rigid_mode() {
    let springs: Vec<f64> = (0..12).map(|i| if i == 0 { 0.0 } else { 500.0 }).collect();
    let model = chain(&[1.5; 12], &springs);
    let read = |text: &str| Interface::read(text, &model.dofs, &model.clamped).unwrap();
    let interfaces = vec![read("left=1"), read("right=12")];
    // All ten inner modes and two constraint modes: the exact body.
    let reduced = reduce(&model, &interfaces, Method::CraigBampton, 10).unwrap();
    let exact = reduce(&model, &interfaces, Method::MacNeal, 12).unwrap();
    assert_eq!((reduced.values[0], reduced.values.len()), (0.0, 12));
    for (own, exact) in reduced.values.iter().zip(&exact.values).skip(1) {
        assert!((own / exact - 1.0).abs() < DENSE, "{own} {exact}");
    }
    let held = reduce(&model, &interfaces[..1], Method::CraigBampton, 3).unwrap();
    assert_eq!(held.rigid, 1);
    assert!(exact.residual.amax() < DENSE * exact.flexibility.amax());
}

#[test]
fn invariant_bodies_that_cannot_be_reduced_are_refused_by_words() {
    let said = |model: &Model, method, modes| {
        let end = Interface::read("end=4", &model.dofs, &model.clamped).unwrap();
        reduce(model, &[end], method, modes).unwrap_err().to_string()
    };
    let good = chain(&[1.0; 4], &[100.0; 4]);
    let negative = chain(&[1.0; 4], &[100.0, 100.0, -30.0, 100.0]);
    let text = said(&negative, Method::MacNeal, 2);
    assert!(text.starts_with("dof ") && text.contains("negative eigenvalue"), "{text}");
    let text = said(&chain(&[1.0, -1.0, 1.0, 1.0], &[100.0; 4]), Method::MacNeal, 2);
    assert!(text.starts_with("dof 2: the mass matrix"), "{text}");
    let text = said(&chain(&[1.0, 1.0, 1.0, 0.0], &[100.0, 100.0, 100.0, 0.0]), Method::MacNeal, 2);
    assert!(text.starts_with("dof 4: neither stiffness nor mass"), "{text}");
    let text = said(&good, Method::MacNeal, 0);
    assert!(text.contains("expected 1 to 500"), "{text}");
    let text = said(&good, Method::Rubin, 500);
    assert!(text.contains("501 coordinates"), "{text}");
    let text = reduce(&good, &[], Method::CraigBampton, 2).unwrap_err().to_string();
    assert!(text.contains("requires --interface"), "{text}");
}

#[test]
fn invariant_massless_dofs_are_condensed() {
    // The third mass of three is 0: two modes, and the static flexibility is that of the springs.
    let model = chain(&[1.0, 1.0, 0.0], &[100.0; 3]);
    let end = Interface::read("end=3", &model.dofs, &model.clamped).unwrap();
    let reduced = reduce(&model, &[end], Method::MacNeal, 3).unwrap();
    assert_eq!(reduced.values.len(), 2);
    assert!((reduced.flexibility[(0, 0)] - 0.03).abs() < DENSE);
    // Only the last spring is beside the modes.
    assert!((reduced.residual[(0, 0)] - 0.01).abs() < DENSE, "{}", reduced.residual);
}
