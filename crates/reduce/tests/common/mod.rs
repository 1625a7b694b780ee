//! Models of the tests: a chain, and a box of brick elements.
#![allow(dead_code, reason = "each test file uses some of the models")]

use nalgebra::{DMatrix, Matrix3, SMatrix, Vector3};
use vibro_reduce::dofs::{Direction, Dof, Dofs};
use vibro_reduce::model::Model;
use vibro_reduce::sparse::{Entry, Listed, Symmetric};

pub type Triplets = Vec<(usize, usize, f64)>;

/// A model of entries on and below the diagonal.
pub fn model(count: usize, k: &Triplets, m: &Triplets, dofs: Dofs) -> Model {
    let matrix = |list: &Triplets| {
        let entries: Vec<Entry> =
            list.iter().map(|&(row, column, value)| Entry { row, column, value }).collect();
        Symmetric::assemble(count, &entries, Listed::Once, &|i| i.to_string()).unwrap()
    };
    Model::new(matrix(k), matrix(m), dofs).unwrap()
}

/// A chain of masses between springs; the first spring is on ground, if its stiffness is not 0.
pub fn chain(masses: &[f64], springs: &[f64]) -> Model {
    let count = masses.len();
    let after = |i: usize| springs.get(i + 1).copied().unwrap_or(0.0);
    let mut k: Triplets = (0..count).map(|i| (i, i, springs[i] + after(i))).collect();
    k.extend((1..count).map(|i| (i, i - 1, -springs[i])));
    let m = masses.iter().enumerate().map(|(i, m)| (i, i, *m)).collect();
    model(count, &k, &m, Dofs::numbered(count))
}

/// A box of brick elements with eight nodes.
pub struct Solid {
    /// Numbers of elements along x, y, z.
    pub elements: [usize; 3],
    /// Edges of the box, m.
    pub size: [f64; 3],
    /// Young's modulus, Pa; Poisson's ratio; density, kg/m³.
    pub material: [f64; 3],
}

/// Corners of an element.
pub const CORNERS: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];

impl Solid {
    /// Steel.
    pub fn steel(elements: [usize; 3], size: [f64; 3]) -> Self {
        Self { elements, size, material: [210e9, 0.3, 7850.0] }
    }

    /// Place of a node in the list of nodes; x runs fastest.
    pub fn node(&self, at: [usize; 3]) -> usize {
        let [nx, ny, _] = self.elements;
        at[0] + (nx + 1) * (at[1] + (ny + 1) * at[2])
    }

    pub fn nodes(&self) -> usize {
        self.elements.iter().map(|n| n + 1).product()
    }

    /// Stiffness and mass of an element by two Gauss points along each axis.
    pub fn element(&self) -> (SMatrix<f64, 24, 24>, SMatrix<f64, 24, 24>) {
        let h: Vec<f64> = (0..3).map(|a| self.size[a] / self.elements[a] as f64).collect();
        let [e, nu, rho] = self.material;
        let (lame, shear) = (e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu)));
        let (mut k, mut m) = (SMatrix::zeros(), SMatrix::zeros());
        let point = 1.0 / 3.0_f64.sqrt();
        let weight = h.iter().product::<f64>() / 8.0;
        for at in CORNERS {
            let x: Vec<f64> = at.iter().map(|&own| if own == 0 { -point } else { point }).collect();
            let factor = |corner: usize, a: usize| {
                let sign = if CORNERS[corner][a] == 0 { -1.0 } else { 1.0 };
                (0.5 * (1.0 + sign * x[a]), sign / h[a])
            };
            let gradient = |corner: usize| {
                Vector3::from_fn(|a, _| {
                    (0..3).map(|b| if a == b { factor(corner, b).1 } else { factor(corner, b).0 }).product()
                })
            };
            let value = |corner: usize| (0..3).map(|a| factor(corner, a).0).product::<f64>();
            for p in 0..8 {
                for q in 0..8 {
                    let (gp, gq): (Vector3<f64>, Vector3<f64>) = (gradient(p), gradient(q));
                    let block = lame * gp * gq.transpose()
                        + shear * gq * gp.transpose()
                        + shear * gp.dot(&gq) * Matrix3::identity();
                    let inertia = rho * value(p) * value(q);
                    for a in 0..3 {
                        m[(3 * p + a, 3 * q + a)] += weight * inertia;
                        for b in 0..3 {
                            k[(3 * p + a, 3 * q + b)] += weight * block[(a, b)];
                        }
                    }
                }
            }
        }
        (k, m)
    }

    /// Entries on and below the diagonal of the whole box: stiffness, mass.
    pub fn triplets(&self) -> (Triplets, Triplets) {
        let (k, m) = self.element();
        let mut sums: std::collections::BTreeMap<(usize, usize), [f64; 2]> = Default::default();
        let [nx, ny, nz] = self.elements;
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let node =
                        |c: usize| self.node([x + CORNERS[c][0], y + CORNERS[c][1], z + CORNERS[c][2]]);
                    for p in 0..24 {
                        for q in 0..24 {
                            let (i, j) = (3 * node(p / 3) + p % 3, 3 * node(q / 3) + q % 3);
                            if i >= j {
                                let sum = sums.entry((i, j)).or_default();
                                sum[0] += k[(p, q)];
                                sum[1] += m[(p, q)];
                            }
                        }
                    }
                }
            }
        }
        let of = |which: usize| {
            let all = sums.iter().map(|(&(i, j), sum)| (i, j, sum[which]));
            all.filter(|term| term.2 != 0.0).collect()
        };
        (of(0), of(1))
    }

    /// Names of the dofs: nodes count from 1.
    pub fn dofs(&self) -> Dofs {
        let directions = [Direction::X, Direction::Y, Direction::Z];
        let node = |k: usize| directions.map(|direction| Dof::new(k.to_string(), direction));
        Dofs::new((1..=self.nodes()).flat_map(node).collect()).unwrap()
    }

    pub fn model(&self) -> Model {
        let (k, m) = self.triplets();
        model(3 * self.nodes(), &k, &m, self.dofs())
    }

    /// Rows of the dofs in a direction of the nodes that pass.
    pub fn rows(&self, directions: &[usize], is_at: impl Fn([usize; 3]) -> bool) -> Vec<usize> {
        let [nx, ny, nz] = self.elements;
        let mut found = Vec::new();
        for z in 0..=nz {
            for y in 0..=ny {
                for x in 0..=nx {
                    if is_at([x, y, z]) {
                        found.extend(directions.iter().map(|a| 3 * self.node([x, y, z]) + a));
                    }
                }
            }
        }
        found.sort_unstable();
        found
    }

    /// The box between six mirrors: no displacement across a face, no force along it.
    pub fn between_mirrors(&self) -> Model {
        let mut rows = Vec::new();
        for a in 0..3 {
            let last = self.elements[a];
            rows.extend(self.rows(&[a], |at| at[a] == 0 || at[a] == last));
        }
        self.model().clamp(&rows).unwrap()
    }

    /// All eigenvalues ω² of the box between mirrors, rising: waves whose numbers are multiples
    /// of half waves solve the discrete equations, so that each comes from a problem of at most
    /// three rows.
    pub fn mirrored_values(&self) -> Vec<f64> {
        let (k, m) = self.element();
        let [nx, ny, nz] = self.elements;
        let mut found = Vec::new();
        for i in 0..=nx {
            for j in 0..=ny {
                for l in 0..=nz {
                    let waves = [i, j, l];
                    let theta: Vec<f64> = (0..3)
                        .map(|a| std::f64::consts::PI * waves[a] as f64 / self.elements[a] as f64)
                        .collect();
                    let present: Vec<usize> =
                        (0..3).filter(|&a| waves[a] != 0 && waves[a] != self.elements[a]).collect();
                    if present.is_empty() {
                        continue;
                    }
                    found.extend(symbol(&k, &m, &theta, &present));
                }
            }
        }
        found.sort_by(f64::total_cmp);
        found
    }
}

/// Eigenvalues of the waves with the phase `theta` from node to node.
fn symbol(k: &SMatrix<f64, 24, 24>, m: &SMatrix<f64, 24, 24>, theta: &[f64], present: &[usize]) -> Vec<f64> {
    // Displacement a of the wave is a sine along a and a cosine along the others: with factors i
    // taken out, entries off the diagonal are real.
    let (mut stiffness, mut mass) = (Matrix3::<f64>::zeros(), 0.0);
    for p in 0..8 {
        for q in 0..8 {
            let phase: f64 = (0..3).map(|a| theta[a] * (CORNERS[q][a] as f64 - CORNERS[p][a] as f64)).sum();
            mass += m[(3 * p, 3 * q)] * phase.cos();
            for a in 0..3 {
                for b in 0..3 {
                    stiffness[(a, b)] += k[(3 * p + a, 3 * q + b)] * phase.cos();
                }
            }
        }
    }
    let own =
        DMatrix::from_fn(present.len(), present.len(), |i, j| stiffness[(present[i], present[j])] / mass);
    own.symmetric_eigenvalues().iter().copied().collect()
}

/// A cube of unit masses on a grid, each on unit springs to its six neighbours, outermost ones to
/// ground, and its eigenvalues: sums of those of three chains, up to sixfold and more.
pub fn grid(edge: usize) -> (Model, Vec<f64>) {
    let place = |x: usize, y: usize, z: usize| x + edge * (y + edge * z);
    let (mut k, mut m) = (Triplets::new(), Triplets::new());
    let own = |i: usize| 2.0 - 2.0 * (std::f64::consts::PI * (i + 1) as f64 / (edge + 1) as f64).cos();
    let mut values = Vec::new();
    for z in 0..edge {
        for y in 0..edge {
            for x in 0..edge {
                let i = place(x, y, z);
                k.push((i, i, 6.0));
                m.push((i, i, 1.0));
                for (is_first, j) in [(x == 0, 1), (y == 0, edge), (z == 0, edge * edge)] {
                    if !is_first {
                        k.push((i, i - j, -1.0));
                    }
                }
                values.push(own(x) + own(y) + own(z));
            }
        }
    }
    values.sort_by(f64::total_cmp);
    (model(edge.pow(3), &k, &m, Dofs::numbered(edge.pow(3))), values)
}
