use vibro_impact::*;
fn main() {
    let p = Groups::weak(0.1, 0.75, 1.5, 0.0, 0.4, 0.2, 0.0, 0.4).to_parameters(Scales::default()).unwrap();
    let s = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
    let mut sim = Simulator::new(&p, &s, 0.0).unwrap().without_ledger();
    sim.advance_to(2000.0 * p.period()).unwrap();
    println!("{:?}", sim.state());
}
