//! Gradients, computed backwards over a motion, compared with columns of derivatives.

use std::sync::Arc;
use vibro_machine::derivative::{By, Gradient};
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Assembly, Description, Differentiated, file};

/// Machines with known motions in 50 digits (tests/second_method.rs).
const MACHINES: &str = include_str!("data/motions.txt");
/// A machine with elements whose force has further pieces.
const LAWS: &str = include_str!("data/laws.toml");
/// Examples with links, prescribed bodies and static levels, each with its end time.
const EXAMPLES: [(&str, f64); 5] = [
    ("msl_coupled_clutches", 1.3),
    ("rack_and_pinion", 0.3),
    ("belt_friction", 0.7),
    ("impact_on_spring", 0.2),
    ("paper_machine", 3.0),
];
/// Rounding relative to the sum of the absolute values of all terms.
const ROUNDING: f64 = 1e-12;
/// Largest share of machines decided by columns, because several events share one instant.
const MOST_BY_COLUMNS: f64 = 0.2;

fn machines() -> impl Iterator<Item = (String, Description, f64)> {
    let random = MACHINES.split("## machine ").skip(1).map(|block| {
        let (name, text) = block.split_once('\n').unwrap();
        let toml: String = text.lines().filter(|l| !l.starts_with("##")).flat_map(|l| [l, "\n"]).collect();
        (name.to_owned(), file::parse(&toml, name, &file::no_records).unwrap(), 0.6)
    });
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly");
    let laws = file::parse(LAWS, "laws.toml", &file::no_records).unwrap();
    let random = random.chain([("laws".to_owned(), laws, 0.7)]);
    random.chain(EXAMPLES.into_iter().map(move |(name, end)| {
        (name.to_owned(), file::read(&folder.join(name).with_extension("toml")).unwrap(), end)
    }))
}

#[test]
fn second_method_gradients_are_sums_of_columns() {
    let (mut compared, mut by_columns, mut count, mut worst) = (0, 0, 0, 0.0f64);
    for (name, machine, end) in machines() {
        let assembly = Arc::new(Assembly::new(machine.clone()).unwrap());
        let mut columns: Vec<By> = machine.parameters().into_iter().map(|p| p.name.into()).collect();
        columns.extend([By::Start(0), By::Time]);
        let quantities: Vec<_> = machine.quantities().collect();
        let mut sum = Gradient::new(assembly.clone(), &columns).unwrap();
        let mut times = Vec::new();
        let mut note = |event: &Event, by: &[Option<f64>]| times.push((event.kind, by.to_vec()));
        let mut motion = Differentiated::new_observed(assembly, &columns, &mut note).unwrap();
        let mut exact = vec![Some((0.0, 0.0)); columns.len()];
        let mut add = |factor: f64, by: &dyn Fn(usize) -> Option<f64>| {
            for (p, sum) in exact.iter_mut().enumerate() {
                *sum = sum.zip(by(p)).map(|((sum, size), x)| (sum + factor * x, size + (factor * x).abs()));
            }
        };
        for k in 1..=4 {
            let time = end * f64::from(k) / 4.0;
            sum.advance_to(time).unwrap();
            motion.advance_observed(time, &mut |event, by| times.push((event.kind, by.to_vec()))).unwrap();
            for (i, &quantity) in quantities.iter().enumerate() {
                let factor = f64::from(k) - 0.3 * i as f64;
                sum.add(quantity, factor);
                add(factor, &|p| motion.derivative(quantity, p));
            }
        }
        // Columns differentiate the time at which a stop closes.
        let own = times.iter().enumerate().filter(|(_, time)| !matches!(time.0, EventKind::Close { .. }));
        for (event, (_, by)) in own {
            let factor = 1.0 + 0.1 * event as f64;
            sum.add_time(event, factor);
            add(factor, &|p| by[p]);
        }
        count += 1;
        by_columns += usize::from(sum.is_by_columns());
        for ((found, exact), by) in sum.gradient().unwrap().iter().zip(&exact).zip(&columns) {
            match exact {
                Some((exact, size)) => {
                    let found = found.as_ref().unwrap_or_else(|lost| panic!("{name}, {by}: {lost}"));
                    let error = (found - exact).abs() / size.max(f64::MIN_POSITIVE);
                    assert!(error < ROUNDING, "{name}, {by}: {found} {exact}, {error:e}");
                    worst = worst.max(error);
                    compared += 1;
                }
                None => assert!(
                    found.is_err(),
                    "{name}, {by}: {found:?} {:?}",
                    motion.lost(columns.iter().position(|c| c == by).unwrap())
                ),
            }
        }
    }
    println!("{compared} compared, {worst:e} at most; by columns {by_columns} of {count} machines");
    assert!(compared > 2000 && (by_columns as f64) < MOST_BY_COLUMNS * count as f64);
}
