//! The complete lists of dependencies of a machine with one element of each kind. Differences of
//! values cannot show that a dependency is superfluous, or declared weaker than it is; this test
//! can.

use fmi_doors::description::Unknown;
use vibro_machine_component::{FILE, Plan};

/// A machine with one element of each kind, whose lists were derived from the laws by hand.
const EACH: &str = "name = \"Each\"\ngravity = 9.81\n[body.table]\nmotion = { amplitude = 0.01, frequency = 3.0, input = true }\n\
    [body.box]\nmass = 3.0\ngravity = 1.0\nstart = { s = 0.01, v = 0.1 }\n[body.wheel]\ninertia = 0.2\n[body.drum]\ninertia = 0.1\n\
    [spring.mount]\nbetween = [\"table\", \"box\"]\nstiffness = 40.0\n[stop.wall]\nbetween = [\"ground\", \"box\"]\ngap = 0.4\n\
    restitution = 0.6\n[stop.rubber]\nbetween = [\"box\", \"ground\"]\ngap = 0.2\nstiffness = 1e3\n[friction.brake]\n\
    between = [\"ground\", \"wheel\"]\nforce = { constant = 0.2, input = true }\n[link.gear]\narms = { wheel = 1.0, drum = -3.0 }\n\
    [load.torque]\non = \"drum\"\nconstant = 1.0\nsteps = [[0.3, 2.0]]\n";

/// The lists by name: the unknown, and after each kind the knowns of that kind.
fn written(plan: &Plan, list: &[Unknown]) -> Vec<String> {
    let name = |reference: u32| plan.table.rows[reference as usize - 1].name.as_str();
    let line = |unknown: &Unknown| {
        let mut line = format!("{}:", name(unknown.reference));
        for kind in ["constant", "fixed", "tunable", "discrete", "dependent"] {
            let of = unknown.dependencies.iter().flatten().filter(|known| known.1.name() == kind);
            let names: Vec<&str> = of.map(|known| name(known.0)).collect();
            if !names.is_empty() {
                line += &format!(" {kind} {}", names.join(" "));
            }
        }
        line
    };
    list.iter().map(line).collect()
}

/// Groups of names in `lists.txt`.
const GROUPS: [(&str, &str); 8] = [
    (
        "TABLE",
        "body.table.motion.constant body.table.motion.amplitude body.table.motion.frequency body.table.motion.phase \
         body.table.motion.rate",
    ),
    ("BOX", "body.box.mass body.box.gravity"),
    ("MOUNT", "spring.mount.stiffness spring.mount.damping spring.mount.preload"),
    ("WALL", "stop.wall.gap stop.wall.restitution"),
    ("RUBBER", "stop.rubber.gap stop.rubber.stiffness stop.rubber.damping"),
    ("GEAR", "link.gear.arms.wheel link.gear.arms.drum"),
    ("TORQUE", "load.torque.constant load.torque.steps[0].time load.torque.steps[0].height"),
    ("BRAKE", "friction.brake.force.constant"),
];

#[test]
fn golden_lists_of_a_machine_with_an_element_of_each_kind() {
    let plan = Plan::new(EACH.into(), FILE).unwrap();
    let description = plan.description();
    let lists = [
        &description.outputs,
        &description.derivatives,
        &description.initial_unknowns,
        &description.event_indicators,
    ];
    let expected: Vec<Vec<String>> = include_str!("lists.txt")
        .split("\n\n")
        .map(|list| {
            let line = |line: &str| {
                let word = |word: &str| {
                    GROUPS
                        .iter()
                        .find(|group| group.0 == word)
                        .map_or(word.to_owned(), |group| group.1.to_owned())
                };
                line.split(' ').map(word).collect::<Vec<_>>().join(" ")
            };
            list.lines().map(line).collect()
        })
        .collect();
    assert_eq!(expected.len(), lists.len());
    for (list, expected) in lists.into_iter().zip(expected) {
        let found = written(&plan, list);
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            assert_eq!(found, expected);
        }
    }
}

/// f = c e' for a damper: neither its list nor the lists of its bodies have a coordinate.
#[test]
fn closed_form_no_force_depends_on_the_elongation_of_a_damper() {
    let text = "name = \"D\"\n[body.a]\nmass = 1.0\n[body.b]\nmass = 2.0\n[damper.d]\nbetween = [\"a\", \"b\"]\n\
        damping = 3.0\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let outputs = written(&plan, &plan.description().outputs);
    let of = |name: &str| outputs.iter().find(|line| line.starts_with(name)).unwrap();
    for name in ["d.f:", "a.a:", "b.a:"] {
        assert!(of(name).contains("a.v") && !of(name).contains("a.s"), "{}", of(name));
    }
    assert!(of("d.e:").contains("a.s"));
}
