
use crate::orbits::*;
use crate::{ParameterSet, find_group};
#[test]
fn scratch_tree() {
    let env = |n: &str, d: f64| std::env::var(n).ok().and_then(|s| s.parse().ok()).unwrap_or(d);
    let set = ParameterSet::basic();
    let span = Span::new(find_group("f10").unwrap(), env("FROM", 0.5), env("TO", 5.0)).unwrap();
    let family = Family::new(&set, ConstantLoads::NONE, span).unwrap();
    let options = TreeOptions { seeds: env("SEEDS", 10.0) as usize, depth: env("DEPTH", 3.0) as u32, most_letters: env("LETTERS", 64.0) as usize, longest_step: env("STEP", 0.05), ..TreeOptions::default() };
    let t = std::time::Instant::now();
    let tree = tree(&family, &options, &|_, _| ()).unwrap();
    println!("{:?} branches {} points {} failures {}", t.elapsed(), tree.branches.len(), tree.branches.iter().map(|b| b.points.len()).sum::<usize>(), tree.failures);
    let mut counts = std::collections::BTreeMap::new();
    for b in &tree.branches {
        for p in &b.points { if let Some(l) = p.label() { *counts.entry(l.name()).or_insert(0) += 1; } }
    }
    println!("{counts:?}");
    if env("SHOW", 0.0) > 0.0 {
    for b in &tree.branches {
        println!("{} parent {:?} depth {} {} closing {} half {} points {} closed {}", b.id, b.parent, b.depth, b.word, b.word.closing(), b.word.half_periods(), b.points.len(), b.closed);
        for (i, p) in b.points.iter().enumerate() { if let Some(s) = &p.special {
            println!("    {i} {} {:.12} {} {:?} stable {} mu {:.4e}", s.label, p.value, s.longer.as_ref().map_or(String::new(), |w| w.to_string()), s.fold, p.stable, p.multipliers[0].norm());
            if std::env::var("PH").is_ok() && b.word.len() <= 14 { println!("      ORBIT {} {} {} {} {:.17e} {:?}", s.label, b.word, b.word.closing(), b.word.half_periods(), p.value, p.phases); }
        } }
    } }
}
