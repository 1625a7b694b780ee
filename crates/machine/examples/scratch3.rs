use std::sync::Arc;
use vibro_machine::Assembly;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::Motion;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string(&args[1]).unwrap();
    let end: f64 = args[2].parse().unwrap();
    let a = Arc::new(Assembly::new(parse(&text, "m", &no_records).unwrap()).unwrap());
    let mut m = Motion::new(a).unwrap().with_most_work(args.get(3).map_or(2000, |x| x.parse().unwrap()));
    let r = m.advance_observed(end, &mut |e| println!("{:?} {:?}", e.time, e.kind));
    println!("{r:?} t {} state {:?}", m.time(), m.body(0));
}
