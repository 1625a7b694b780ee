//! The gallery's blade tip compared with matrix exponentials of its states.

use crate::common::{near, times};
use crate::gallery::{HALVINGS, example, flow, followed, value};
use nalgebra::{DMatrix, DVector, Matrix2, RowDVector, Vector2};
use std::f64::consts::TAU;
use vibro_machine::motion::EventKind;

/// Rounding of 12,000 steps and the ends of halvings, s and m, magnified by 42 events.
const NEAR: f64 = 1e-9;
/// z = (q, v, slider, sine and cosine of the load, 1).
const MODES: usize = 8;
const SLIDER: usize = 2 * MODES;
const SINE: usize = SLIDER + 1;
const ONE: usize = SLIDER + 3;
const SIZE: usize = SLIDER + 4;

/// Numbers of blade_tip.toml that are not written here.
struct Blade {
    frequencies: Vec<f64>,
    /// Rows of the tip along y and x, and of the load.
    rows: [Vec<f64>; 3],
    flexibility: Vec<Vec<f64>>,
}

impl Blade {
    fn read() -> Self {
        let text = include_str!("../../../examples/assembly/blade_tip.toml");
        let file: toml::Table = text.parse().unwrap();
        let blade = &file["modal"]["blade"];
        let number = |x: &toml::Value| match x.as_str() {
            Some(text) => text.strip_suffix(" Hz").unwrap().parse().unwrap(),
            None => x.as_float().unwrap(),
        };
        let list = |x: &toml::Value| x.as_array().unwrap().iter().map(number).collect::<Vec<f64>>();
        let nodes = &blade["nodes"];
        Self {
            frequencies: list(&blade["frequencies"]),
            rows: [&nodes["tip"]["y"], &nodes["tip"]["x"], &nodes["middle"]].map(list),
            flexibility: blade["residual"]["flexibility"].as_array().unwrap().iter().map(list).collect(),
        }
    }
}

/// A state of the contact: its matrix in z' = A z with the rows of N, T, the normal elongation
/// beyond the gap without the contact's forces, and the slider's rate.
struct Piece {
    /// Direction of slip, 0 for a stuck contact; `None` for an open one.
    slip: Option<f64>,
    rows: [RowDVector<f64>; 4],
    flows: Vec<DMatrix<f64>>,
}

impl Piece {
    fn new(blade: &Blade, slip: Option<f64>, step: f64) -> Self {
        let (gap, normal, tangential, friction) = (0.3e-3, 1e6, 0.7e6, 0.3);
        let (load, omega) = (4.0, TAU * 84.0);
        // The file's order of the residual nodes is x, y, load.
        let g = |i: usize, j: usize| blade.flexibility[i][j];
        let place = |row: &[f64], by_load: f64, constant: f64| {
            let mut all = RowDVector::zeros(SIZE);
            all.as_mut_slice()[..MODES].copy_from_slice(row);
            (all[SINE], all[ONE]) = (by_load * load, constant);
            all
        };
        let [y, x, middle] = &blade.rows;
        let (beyond, along) = (place(y, g(1, 2), -gap), place(x, g(0, 2), 0.0));
        let mut slider = RowDVector::zeros(SIZE);
        slider[SLIDER] = 1.0;
        let zero = RowDVector::zeros(SIZE);
        let [n, t] = match slip {
            None => [zero.clone(), zero.clone()],
            Some(0.0) => {
                let both = Matrix2::new(1.0 / normal + g(1, 1), g(0, 1), g(0, 1), 1.0 / tangential + g(0, 0));
                let inverse = both.try_inverse().unwrap();
                let right = Vector2::new(beyond.clone(), &along - &slider);
                [0, 1].map(|i| &right[0] * inverse[(i, 0)] + &right[1] * inverse[(i, 1)])
            }
            Some(sign) => {
                let n = &beyond / (1.0 / normal + g(1, 1) + sign * friction * g(0, 1));
                [n.clone(), n * (sign * friction)]
            }
        };
        let mut a = DMatrix::zeros(SIZE, SIZE);
        for k in 0..MODES {
            let w = TAU * blade.frequencies[k];
            a[(k, MODES + k)] = 1.0;
            (a[(MODES + k, k)], a[(MODES + k, MODES + k)]) = (-w * w, -2.0 * 0.005 * w);
            a[(MODES + k, SINE)] = middle[k] * load;
            for j in 0..SIZE {
                a[(MODES + k, j)] -= y[k] * n[j] + x[k] * t[j];
            }
        }
        (a[(SINE, SINE + 1)], a[(SINE + 1, SINE)]) = (omega, -omega);
        // The slider is at the tip's true place, less the stretch.
        let rate = match slip {
            Some(0.0) => zero,
            _ => (&along - &n * g(0, 1) - &t * (g(0, 0) + 1.0 / tangential)) * &a,
        };
        a.row_mut(SLIDER).copy_from(&rate);
        Self { slip, flows: flow(&a, step), rows: [n, t, beyond, rate] }
    }

    fn row(&self, i: usize, z: &DVector<f64>) -> f64 {
        self.rows[i].iter().zip(z.iter()).map(|(row, z)| row * z).sum()
    }

    /// Whether the slider moves on in the direction of slip.
    fn slides(&self, z: &DVector<f64>) -> bool {
        self.slip.is_some_and(|sign| sign * self.row(3, z) > 0.0)
    }
}

/// The state that follows in z: 0 open, 1 stuck, 2 and 3 slip. At the limit of friction the
/// slider's rate decides, since the force there is only right to rounding.
fn following(all: &[Piece], now: usize, z: &DVector<f64>) -> usize {
    let [n, t, beyond] = [0, 1, 2].map(|i| all[now].row(i, z));
    let slip = if t > 0.0 { 2 } else { 3 };
    match now {
        0 => usize::from(beyond > 0.0),
        _ if n < 0.0 => 0,
        1 if t.abs() > 0.3 * n && all[slip].slides(z) => slip,
        2 | 3 if all[now].slides(z) => now,
        _ => 1,
    }
}

/// A step, halved at each change of the state `now`; `begun` has the times of changes.
fn step(
    all: &[Piece],
    z: &mut DVector<f64>,
    now: &mut usize,
    [time, length]: [f64; 2],
    halved: usize,
    begun: &mut Vec<(f64, usize)>,
) {
    let next = &*z + &all[*now].flows[halved] * &*z;
    let after = following(all, *now, &next);
    if after != *now && halved < HALVINGS {
        for part in [0.0, 0.5] {
            step(all, z, now, [time + part * length, 0.5 * length], halved + 1, begun);
        }
        return;
    }
    if after != *now {
        begun.push((time + length, after));
    }
    (*z, *now) = (next, after);
}

/// Whether a change from one state to another is of a kind.
type Change = dyn Fn(usize, usize) -> bool;
type Kind = fn(&EventKind) -> bool;

/// Touches, slips, sticks and lift-offs of the tip, and its place at the end.
#[test]
fn second_method_a_blade_tip_by_exponentials_of_its_states() {
    let (blade, h, steps) = (Blade::read(), 1e-5, 12_000);
    let all = [None, Some(0.0), Some(1.0), Some(-1.0)].map(|slip| Piece::new(&blade, slip, h));
    let mut z = DVector::zeros(SIZE);
    (z[SINE + 1], z[ONE]) = (1.0, 1.0);
    let (mut now, mut begun) = (0, Vec::new());
    (0..steps).for_each(|k| step(&all, &mut z, &mut now, [k as f64 * h, h], 0, &mut begun));
    let mut motion = example("blade_tip");
    let events = followed(&mut motion, steps as f64 * h);
    // A contact that closes with a slip is stuck here until the end of the shortest step.
    let later = |k: usize| begun[k].1 < 2 || begun[k - 1].1 != 1 || begun[k].0 - begun[k - 1].0 > NEAR;
    let own = |is: &Change| {
        let changes = (0..begun.len())
            .filter(|&k| later(k) && is(k.checked_sub(1).map_or(0, |k| begun[k].1), begun[k].1));
        changes.map(|k| begun[k].0).collect::<Vec<_>>()
    };
    let kinds: [(Kind, &Change); 4] = [
        (|kind| matches!(kind, EventKind::Press { .. }), &|before, _| before == 0),
        (|kind| matches!(kind, EventKind::Free { .. }), &|_, after| after == 0),
        (|kind| matches!(kind, EventKind::Yield { .. }), &|_, after| after > 1),
        (|kind| matches!(kind, EventKind::Hold { .. }), &|before, after| before > 1 && after == 1),
    ];
    for ((kind, is), count) in kinds.into_iter().zip([9, 9, 12, 12]) {
        let (found, exact) = (times(&events, kind), own(is));
        assert_eq!([found.len(), exact.len()], [count; 2]);
        found.iter().zip(&exact).for_each(|(found, exact)| near(*found, *exact, NEAR));
    }
    let tip = blade.rows[1].iter().zip(z.iter()).map(|(row, q)| row * q).sum::<f64>();
    let residual = blade.flexibility[0][2] * 4.0 * z[SINE];
    let forces = [0, 1].map(|i| all[now].row(i, &z));
    let contact = blade.flexibility[0][1] * forces[0] + blade.flexibility[0][0] * forces[1];
    near(value(&motion, "blade.tip.x.s"), tip + residual - contact, NEAR);
}
