//! Scratch: the standard work.
use vibro_impact::*;
fn main() {
    let p = Groups::weak(0.1, 0.75, 1.5, 0.0, 0.4, 0.2, 0.0, 0.4).to_parameters(Scales::default()).unwrap();
    let s = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
    for ledger in [false, true] {
        let mut best = f64::INFINITY;
        for _ in 0..20 {
            let mut sim = Simulator::new(&p, &s, 0.0).unwrap();
            if !ledger {
                sim = sim.without_ledger();
            }
            let t = std::time::Instant::now();
            sim.advance_to(20.0 * p.period()).unwrap();
            let i20 = *sim.impacts();
            sim.advance_to(2000.0 * p.period()).unwrap();
            let dt = t.elapsed().as_secs_f64() / 2000.0 * 1e9;
            if dt < best {
                best = dt;
            }
            let _ = i20;
        }
        let mut sim = Simulator::new(&p, &s, 0.0).unwrap();
        if !ledger {
            sim = sim.without_ledger();
        }
        let l0 = sim.ledger();
        sim.advance_to(20.0 * p.period()).unwrap();
        let i20 = *sim.impacts();
        sim.advance_to(2000.0 * p.period()).unwrap();
        let l = sim.ledger();
        println!(
            "ledger {ledger}: {best:.0} ns/period, {} impacts in 20, {} in 2000, {:?}",
            i20.upper + i20.lower,
            sim.impacts().upper + sim.impacts().lower,
            sim.work()
        );
        println!("{:?}", sim.state());
        println!("balance {:e} of {}", l.mechanical - l0.mechanical - l.input + l.damped + l.impact, l.input);
    }
    let t = std::time::Instant::now();
    for _ in 0..1000 {
        std::hint::black_box(Simulator::new(&p, &s, 0.0).unwrap());
    }
    println!("new {} us", t.elapsed().as_secs_f64() * 1e3);
}
