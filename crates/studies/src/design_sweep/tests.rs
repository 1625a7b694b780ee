use super::*;
use crate::paper::ParameterSet;
use crate::paper::design_sweep::spread_starts;
use crate::paper::measures::{Measure, measure};
use crate::paper::motion::settled_simulator;
use crate::paper::parameter_set::Name;
use crate::paper::start::StartRule;
use crate::parts::{PartStore, Shard};
use std::collections::BTreeMap;
use std::sync::Mutex;
use vibro_impact::Parameters;

fn name(text: &str) -> Name {
    Name::find(text).unwrap()
}

fn axis(text: &str, values: &[f64]) -> SampledAxis<Name> {
    SampledAxis { name: name(text), values: values.into() }
}

fn measures(names: &[&str]) -> Vec<Measure> {
    names.iter().map(|n| n.parse().unwrap()).collect()
}

/// A grid of 6 designs with 6 motions each.
fn request() -> SweepRequest<ParameterSet> {
    SweepRequest {
        designs: Designs::Grid(vec![axis("stop.gap", &[0.8, 1.0]), axis("kappa", &[0.3, 0.5, 0.7])]),
        over: vec![axis("drive.frequency", &[0.95, 1.0, 1.04])],
        starts: vec![StartRule::default(), "x1=0.5,v3=-1".parse().unwrap()],
        discard: 40,
        periods: 12,
        measures: measures(&["amplitude.x1", "class", "power.impact"]),
        ..SweepRequest::default()
    }
}

#[test]
fn designs_of_each_kind_in_order() {
    let grid = request().designs;
    let values: Vec<_> = (0..grid.count()).map(|i| grid.values(i)).collect();
    let expected = [[0.8, 0.3], [0.8, 0.5], [0.8, 0.7], [1.0, 0.3], [1.0, 0.5], [1.0, 0.7]];
    assert_eq!(values, expected);
    let intervals = ["f10", "kappa"].map(|n| ParameterInterval { name: name(n), from: 0.0, to: 2.0 });
    let sobol = Designs::Sobol { intervals: intervals.into(), count: 4 };
    let values: Vec<_> = (0..4).map(|i| sobol.values(i)).collect();
    assert_eq!(values, [[0.0, 0.0], [1.0, 1.0], [1.5, 0.5], [0.5, 1.5]]);
    let mut more = request();
    assert_eq!((more.count(), more.motions()), (1, 6));
    assert_eq!(
        more.motion_in_words(&ParameterSet::basic(), 3),
        "drive.frequency = 1 rad/s, start x1=0.5,v3=-1"
    );
    // Starts are inside the stops, and none is at rest.
    more.starts.extend(spread_starts(200));
    for start in &more.starts {
        // The default machine has L = 1 m and ω10 = 1 rad/s.
        let vibro_impact::State { x: [x1, x2, _], v: [_, v2, _] } =
            start.state(&Parameters::default()).unwrap();
        assert!((x2 - x1).abs() < 1.0 && (v2 != 0.0 || x1 != x2), "{start}");
    }
}

#[test]
fn second_method_a_row_is_what_its_motions_are_one_by_one() {
    let (set, request) = (ParameterSet::basic(), request());
    let found = row(&set, &request, 4);
    let mut all: Vec<Measured> = Vec::new();
    for frequency in [0.95, 1.0, 1.04] {
        for start in &request.starts {
            let mut own = set.clone();
            let values = [("stop.gap", 1.0), ("kappa", 0.5), ("drive.frequency", frequency)];
            own.assign(&values.map(|(n, v)| (name(n), v))).unwrap();
            let p = own.parameters();
            let mut simulator = settled_simulator(p, &start.state(p).unwrap(), 40.0).unwrap();
            all.push(measure(&mut simulator, &request.measures, 12).unwrap());
        }
    }
    assert_eq!((found.values.as_slice(), &found.reason), ([1.0, 0.5].as_slice(), &None));
    for m in [0, 2] {
        let values: Vec<f64> = all.iter().map(|found| found.numbers[m].unwrap()).collect();
        let summary = found.outputs[m].unwrap();
        assert_eq!(summary.least, values.iter().copied().fold(f64::INFINITY, f64::min));
        assert_eq!(summary.largest, values.iter().copied().fold(0.0, f64::max));
        assert_eq!(summary.largest, values[summary.at]);
        assert!((summary.mean - values.iter().sum::<f64>() / 6.0).abs() < 1e-15);
    }
    assert!(found.outputs[1].is_none() && !found.classes.is_empty());
    assert!(all.iter().all(|m| found.classes.contains(&m.class.unwrap())));
}

#[test]
fn what_makes_no_machine_or_no_motion_is_a_row_with_its_reason() {
    let set = ParameterSet::basic();
    let names = vec![name("stop.restitution"), name("stop.gap"), name("drive.frequency")];
    let rows = vec![
        vec![0.5, 1.0, 1.0],
        vec![1.2, 1.0, 1.0],
        vec![0.5, -0.1, 1.0],
        vec![0.5, 1.0, 0.0],
        vec![0.6, 1.0, 1.0],
    ];
    let designs = Designs::Rows { names, rows };
    let measures = measures(&["amplitude.x1", "amplitude.without_block", "class"]);
    let all = SweepRequest { designs, measures, discard: 200, periods: 5, ..SweepRequest::default() };
    let reasons: Vec<Option<String>> = (0..5).map(|i| row(&set, &all, i).reason).collect();
    assert_eq!((&reasons[0], &reasons[4]), (&None, &None));
    for (index, word) in
        [(1, "stop.restitution = 1.2: expected 0 <="), (2, "stop.gap = -0.1"), (3, "drive.frequency")]
    {
        let found = row(&set, &all, index);
        assert!(found.reason.as_ref().is_some_and(|r| r.contains(word)), "{found:?}");
        assert!(found.outputs[0].is_none() && found.classes.is_empty());
    }
    // Motions outside the stops do not exist; the box's amplitude without the block is defined.
    let starts = vec!["x2=0.5".parse().unwrap(), "x2=1.5".parse().unwrap()];
    let outside = row(&set, &SweepRequest { starts, ..all.clone() }, 0);
    let reason = outside.reason.unwrap();
    assert!(reason.starts_with("1 of 2 motions, the first at start x2=1.5: "), "{reason}");
    assert!(outside.outputs[0].is_none() && outside.outputs[1].is_some() && outside.classes.is_empty());
    // Each value is valid alone, but not both together.
    let pair = Designs::Grid(vec![axis("epsilon", &[0.1, 0.9]), axis("sigma1", &[-2.0])]);
    let found = row(&set, &SweepRequest { designs: pair, ..all }, 1);
    assert!(found.reason.is_some_and(|r| r.contains("sigma1 = -2")));
}

#[test]
fn what_every_row_depends_on_is_checked_first() {
    let good = request();
    assert!(good.check().is_ok());
    let refused = |change: &dyn Fn(&mut SweepRequest<ParameterSet>)| {
        let mut request = good.clone();
        change(&mut request);
        request.check().unwrap_err().to_string()
    };
    let twice = refused(&|r| r.over.push(axis("stop.restitution", &[0.5])));
    assert!(twice.contains("kappa and stop.restitution: determine the same quantity"), "{twice}");
    assert!(refused(&|r| r.measures.clear()).contains("0 outputs"));
    assert!(refused(&|r| r.designs = Designs::Rows { names: vec![], rows: vec![] }).contains("0 designs"));
    assert!(refused(&|r| r.over[0].values = vec![1.0; 60_000]).contains("120000 motions"));
    let many = SampledAxis { name: name("f10"), values: vec![1.0; 2000] };
    let wide = Designs::Grid(vec![many, axis("epsilon", &[0.1; 2000])]);
    assert!(refused(&|r| r.designs = wide.clone()).contains("4000000 designs"));
}

/// Keeps the parts in memory.
#[derive(Default)]
struct MemoryStore(Mutex<BTreeMap<usize, Vec<u8>>>);

impl PartStore for MemoryStore {
    fn load(&self, index: usize) -> Option<Vec<u8>> {
        self.0.lock().unwrap().get(&index).cloned()
    }

    fn save(&self, index: usize, bytes: &[u8]) -> Result<()> {
        self.0.lock().unwrap().insert(index, bytes.to_vec());
        Ok(())
    }
}

#[test]
fn invariant_rows_depend_neither_on_threads_nor_on_shards() {
    // With 384 motions per design, a part has two of the six designs.
    let set = ParameterSet::basic();
    let mut request =
        SweepRequest { discard: 3, periods: 1, measures: measures(&["amplitude.x2"]), ..request() };
    request.starts.extend(spread_starts(126));
    assert_eq!((request.motions(), request.count()), (3 * 128, 3));
    let of_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let store = MemoryStore::default();
        let task = Task { store: &store, ..Task::ALL };
        assert!(pool.install(|| fill(&set, &request, &task)).unwrap());
        store.0.into_inner().unwrap()
    };
    let one = of_threads(1);
    assert_eq!(one, of_threads(3));
    let store = MemoryStore::default();
    for (index, complete) in [(1, false), (0, true)] {
        let task = Task { store: &store, shard: Shard { index, count: 2 }, ..Task::ALL };
        assert_eq!(fill(&set, &request, &task).unwrap(), complete);
    }
    assert_eq!(*store.0.lock().unwrap(), one);
    let mut rows = Vec::new();
    let task = Task { store: &store, ..Task::ALL };
    each_row(&set, &request, &task, |row| -> Result<()> {
        rows.push(row.values);
        Ok(())
    })
    .unwrap();
    assert_eq!(rows, (0..6).map(|i| request.designs.values(i)).collect::<Vec<_>>());
}

/// Tolerance for an amplitude of a settled linear oscillator.
const SETTLED: f64 = 1e-6;

/// A box on a spring with a damping ratio of one percent. Its natural frequency near 9.25 Hz is
/// not among 9, 10, 11 Hz.
const RESONATOR: &str = "name = \"R\"\n[body.a]\nmass = 1.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 3377.6\n\
    damping = 1.16\n[load.f]\non = \"a\"\namplitude = 10.0\nfrequency = \"9 Hz\"\n";

fn described(text: &str) -> crate::Machine {
    crate::Machine::new(vibro_machine::file::parse(text, "m.toml", &vibro_machine::file::no_records).unwrap())
}

fn described_axis(name: &str, values: &[f64]) -> SampledAxis<String> {
    SampledAxis { name: name.into(), values: values.into() }
}

#[test]
fn closed_form_a_resonance_between_the_values_of_a_band_is_met() {
    // The first design resonates within the band, the second above it. At the three values the
    // first looks better.
    let machine = described(RESONATOR);
    let request = SweepRequest::<crate::Machine> {
        designs: Designs::Grid(vec![described_axis("spring.k.stiffness", &[3377.6, 2600.0])]),
        over: vec![described_axis("load.f.frequency", &[9.0, 10.0, 11.0])],
        between: vec!["load.f.frequency".into()],
        measures: vec!["amplitude.a.s".parse().unwrap()],
        ..SweepRequest::default()
    };
    let amplitude = |k: f64, f: f64| {
        let w = std::f64::consts::TAU * f;
        10.0 / (k - w * w).hypot(1.16 * w)
    };
    let peak = |k: f64| (0..=2000).map(|i| amplitude(k, 9.0 + 1e-3 * f64::from(i))).fold(0.0, f64::max);
    let sampled = |k: f64| [9.0, 10.0, 11.0].map(|f| amplitude(k, f)).into_iter().fold(0.0, f64::max);
    assert!(peak(3377.6) > 2.0 * sampled(3377.6));
    let rows: Vec<DesignRow> = (0..2).map(|i| row(&machine, &request, i)).collect();
    let largest = |row: &DesignRow| row.outputs[0].unwrap().largest;
    assert!((largest(&rows[0]) - sampled(3377.6)).abs() < SETTLED, "{rows:?}");
    let task = Task { ..Task::ALL };
    let found = choice(&machine, &request, &task).unwrap().unwrap();
    assert_eq!((&found.possible[..], found.left), (&[1][..], 0), "{found:?}");
    // The best design was searched between its values, and its number is the largest in the band.
    let best = &found.rows[&1];
    assert!(!best.again.as_ref().unwrap().between.is_empty());
    assert!((largest(best) - peak(2600.0)).abs() < 0.01 * peak(2600.0), "{best:?}");
    let alone = SweepRequest {
        designs: Designs::Grid(vec![described_axis("spring.k.stiffness", &[3377.6, 3377.7])]),
        ..request
    };
    let found = choice(&machine, &alone, &task).unwrap().unwrap();
    let first = found.rows.values().next().unwrap();
    assert!((largest(first) - peak(3377.6)).abs() < 0.01 * peak(3377.6), "{first:?}");
    let (place, _) = first.motion(&alone, first.outputs[0].unwrap().at);
    assert!((place[0] - 9.25).abs() < 0.05, "{place:?}");
}

#[test]
fn invariant_the_best_is_the_best_when_all_are_measured_as_long_and_depends_on_no_threads() {
    // The motions are chaotic: the maximum over six periods is a rough estimate.
    let set = ParameterSet::basic();
    let request = SweepRequest {
        designs: Designs::Grid(vec![axis("f10", &[3.56, 3.57, 3.58, 3.59, 3.6, 3.61, 3.62, 3.63])]),
        discard: 200,
        periods: 6,
        measures: measures(&["maximum.x1"]),
        again: u64::MAX,
        ..SweepRequest::default()
    };
    let of_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| choice(&set, &request, &Task::ALL)).unwrap().unwrap()
    };
    let found = of_threads(1);
    assert_eq!(found, of_threads(3));
    let long = SweepRequest { periods: 3000, ..request.clone() };
    let all: Vec<Summary> = (0..8).map(|i| row(&set, &long, i).outputs[0].unwrap()).collect();
    let least = (0..8).min_by(|a, b| all[*a].largest.total_cmp(&all[*b].largest)).unwrap();
    assert!(found.possible.contains(&least), "{found:?} {all:?}");
    assert_eq!(found.left, 0);
    // The final rows are the rows of the choice.
    let mut rows = Vec::new();
    each_final_row(&set, &request, (&Task::ALL, Some(&found)), |row| -> Result<()> {
        rows.push(row);
        Ok(())
    })
    .unwrap();
    assert!(found.rows.iter().all(|(i, row)| rows[*i] == *row) && !found.rows.is_empty());
    let spent = SweepRequest { again: 1, ..request.clone() };
    let none = choice(&set, &spent, &Task::ALL).unwrap().unwrap();
    assert!(none.rows.is_empty() && none.left == none.possible.len() && none.left > 0, "{none:?}");
}

/// An absorber with a larger regular motion at 9.4 Hz, over 60 periods, than the chaotic motion at
/// 10.4 Hz.
const ABSORBER: &str = "name = \"A\"\n[body.box]\nmass = 12.0\n[body.block]\nmass = 0.8\nstart = { v = 0.3 }\n[spring.mount]\n\
    between = [\"ground\", \"box\"]\nstiffness = 48e3\ndamping = 40.0\n[stop.up]\nbetween = [\"box\", \"block\"]\ngap = 0.02\n\
    restitution = 0.6\n[stop.down]\nbetween = [\"block\", \"box\"]\ngap = 0.02\nrestitution = 0.6\n[load.shaker]\non = \"box\"\n\
    amplitude = 80.0\nfrequency = 10.0\n";

#[test]
fn second_method_the_best_holds_the_chaotic_motions_of_its_band_over_the_longest_window() {
    let machine = described(ABSORBER);
    let mass = 1.0999999999999999;
    let request = SweepRequest::<crate::Machine> {
        designs: Designs::Grid(vec![described_axis("body.block.mass", &[mass, 0.5])]),
        over: vec![described_axis("load.shaker.frequency", &[9.4, 10.4])],
        discard: 800,
        measures: vec!["amplitude.box.s".parse().unwrap()],
        ..SweepRequest::default()
    };
    let alone = |frequency: f64, periods: u32| {
        let names = ["body.block.mass", "load.shaker.frequency"].map(String::from).into();
        let designs = Designs::Rows { names, rows: vec![vec![mass, frequency]] };
        let request = SweepRequest { designs, over: Vec::new(), periods, ..request.clone() };
        row(&machine, &request, 0).outputs[0].unwrap()
    };
    // In windows of 60 periods the chaotic motion stays below the regular motion by more than its
    // spread.
    let [regular, chaotic] = [9.4, 10.4].map(|frequency| alone(frequency, 60));
    assert!(regular.is_exact && !chaotic.is_exact);
    assert!(chaotic.largest + chaotic.spread < regular.largest, "{regular:?} {chaotic:?}");
    let found = choice(&machine, &request, &Task::ALL).unwrap().unwrap();
    let own = found.rows[&0].outputs[0].unwrap();
    let long = alone(10.4, 64 * 60);
    assert!(long.largest > regular.largest);
    assert_eq!(
        (own.largest, own.is_exact, found.rows[&0].again.as_ref().unwrap().periods),
        (long.largest, false, 3840)
    );
    // The other design, whose motions repeat, may be better.
    assert_eq!((&found.possible[..], found.is_decided(), found.left), (&[1, 0][..], false, 0));
}
