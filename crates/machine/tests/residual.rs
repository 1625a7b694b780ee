//! Residual flexibility of bodies in modal coordinates (docs/assembly-law.md, section 25).

use std::f64::consts::PI;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Assembly, Motion, file};

/// A bar of mass 1 whose wave takes half a second, so that it stays on a wall for 1 s, with its rigid
/// motion and `n` modes.
fn bar(n: usize, residual: bool, v: f64) -> String {
    let (c, l) = (2.0, 1.0);
    let list = |of: &dyn Fn(usize) -> f64| -> String {
        (0..=n).map(|k| format!("{:?}", of(k))).collect::<Vec<_>>().join(", ")
    };
    let frequencies = list(&|k| k as f64 * c / (2.0 * l));
    let tip = list(&|k| if k == 0 { 1.0 } else { 2f64.sqrt() });
    let far = list(&|k| if k == 0 { 1.0 } else { 2f64.sqrt() * (-1f64).powi(k as i32) });
    let kept: f64 = (1..=n).map(|k| 2.0 / (k as f64 * PI * c / l).powi(2)).sum();
    let start = list(&|k| if k == 0 { v } else { 0.0 });
    let zero = list(&|_| 0.0);
    let g = l * l / (3.0 * c * c) - kept;
    let residual =
        if residual { format!("residual = {{ nodes = [\"tip\"], flexibility = [[{g:?}]] }}\n") } else { String::new() };
    format!(
        "name = \"Bar\"\n[modal.bar]\nfrequencies = [{frequencies}]\nnodes = {{ tip = [{tip}], far = [{far}] }}\n\
         start = {{ q = [{zero}], v = [{start}] }}\n{residual}"
    )
}

fn motion(text: &str) -> Motion {
    let machine = file::parse(text, "bar.toml", &file::no_records).unwrap_or_else(|e| panic!("{e}"));
    Motion::new(Assembly::new(machine).unwrap().into()).unwrap()
}

#[test]
fn closed_form_a_bar_leaves_a_wall_after_the_wave_has_returned_without_loss() {
    for n in [5, 10, 20] {
        let text = bar(n, true, 1.0) + "[stop.wall]\nbetween = [\"ground\", \"bar.tip\"]\ngap = 0.0\n";
        let mut motion = motion(&text);
        let mut events: Vec<Event> = Vec::new();
        motion.advance_observed(2.0, &mut |event| events.push(event.clone())).unwrap();
        let (kinetic, stored) = motion.kinetic_and_stored();
        let times: Vec<_> = events.iter().map(|own| (own.time, own.kind.clone())).collect();
        println!("{n}: {times:?} v {} energy {}", motion.state()[n + 1], kinetic + stored - 0.5);
        let leaves = events.iter().rev().find_map(|own| match own.kind {
            EventKind::Free { .. } => Some(own.time),
            _ => None,
        });
        assert!((leaves.unwrap() - 1.0).abs() < 0.05 / n as f64, "{leaves:?}");
        assert!((kinetic + stored - 0.5).abs() < 1e-13);
    }
}
