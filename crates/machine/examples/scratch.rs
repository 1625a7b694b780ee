use std::sync::Arc;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::Motion;
use vibro_machine::{Assembly, Differentiated, Quantity, What};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let rows = std::fs::read_to_string(&args[1]).unwrap();
    if args.len() > 2 && args[2] == "by" {
        for row in rows.lines() {
            let f: Vec<&str> = row.split(';').collect();
            let text = f[0].replace('|', "\n");
            let end: f64 = f[1].parse().unwrap();
            let truth: Vec<f64> = f[3].split(',').map(|x| x.parse().unwrap()).collect();
            let a = Arc::new(Assembly::new(parse(&text, "m", &no_records).unwrap()).unwrap());
            let mut m = Differentiated::new(a, &[f[2]]).unwrap();
            m.advance_to(end).unwrap();
            let n = truth.len() / 2;
            for (k, x) in truth.iter().enumerate() {
                let q = Quantity::of_body(k % n, if k < n { What::S } else { What::V });
                let own = m.derivative(q, 0);
                println!(
                    "{} {k}: {own:?} {x} rel {:e}",
                    f[2],
                    own.map_or(f64::NAN, |o| (o - x).abs() / x.abs())
                );
            }
        }
        return;
    }
    for row in rows.lines() {
        let f: Vec<&str> = row.split(';').collect();
        let text = f[0].replace('|', "\n");
        let end: f64 = f[1].parse().unwrap();
        let times: Vec<f64> = f[3].split(',').filter(|x| !x.is_empty()).map(|x| x.parse().unwrap()).collect();
        let truth: Vec<f64> = f[4].split(',').map(|x| x.parse().unwrap()).collect();
        println!("{}", f[2]);
        let a = Arc::new(Assembly::new(parse(&text, "m", &no_records).unwrap()).unwrap());
        let begun = std::time::Instant::now();
        let mut m = Motion::new(a).unwrap();
        let e0 = m.kinetic_and_stored();
        let mut own = Vec::new();
        let r = m.advance_observed(end, &mut |e| own.push((e.time, format!("{:?}", e.kind))));
        if let Err(e) = r {
            println!("ERROR {e}");
        }
        let spent = begun.elapsed();
        let worst = own.iter().zip(&times).map(|(a, b)| (a.0 - b).abs()).fold(0.0, f64::max);
        println!("{} events of {}, worst time {worst:e}, {spent:?}", own.len(), times.len());
        if own.len() != times.len() {
            for e in &own {
                println!("   {e:?}");
            }
        }
        let n = truth.len() / 2;
        for (k, x) in truth.iter().enumerate() {
            let o = m.body(k % n)[k / n];
            println!("  {o} {x} off {:e}", o - x);
        }
        let e1 = m.kinetic_and_stored();
        println!("  balance {:e}", e1.0 + e1.1 - e0.0 - e0.1 - m.energy().balance());
    }
}
