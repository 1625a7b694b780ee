//! The variables and descriptions of all example machines, and of a machine with every kind of
//! element and input.

use fmi_doors::Version;
use fmi_doors::description::{Kind, Variability};
use std::collections::HashSet;
use std::path::Path;
use vibro_machine::file;
use vibro_machine_component::{Plan, Quantity, Role};

fn plans() -> Vec<Plan> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly");
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let paths = paths.filter(|path| path.extension().is_some_and(|ending| ending == "toml"));
    let mut plans: Vec<_> = paths.map(|path| Plan::of(&file::read(&path).unwrap()).unwrap()).collect();
    plans.push(Plan::new(include_str!("common/everything.toml").into(), "everything.toml").unwrap());
    plans.push(Plan::new(include_str!("../../machine/tests/data/laws.toml").into(), "laws.toml").unwrap());
    plans.push(Plan::new(include_str!("common/joint.toml").into(), "joint.toml").unwrap());
    plans.push(Plan::new(include_str!("common/contacts.toml").into(), "contacts.toml").unwrap());
    plans.push(Plan::new(include_str!("common/box.toml").into(), "box.toml").unwrap());
    plans.push(Plan::new(include_str!("common/residual.toml").into(), "residual.toml").unwrap());
    plans.push(Plan::new(include_str!("common/freewheels.toml").into(), "freewheels.toml").unwrap());
    plans.push(Plan::new(include_str!("common/signals.toml").into(), "signals.toml").unwrap());
    plans.push(Plan::new(include_str!("common/stepped.toml").into(), "stepped.toml").unwrap());
    plans.push(Plan::new(include_str!("common/blocks.toml").into(), "blocks.toml").unwrap());
    assert!(plans.len() > 20, "{}", plans.len());
    plans
}

/// A named parameter is a parameter of the FMU: tunable if every number that follows from it is
/// tunable, otherwise fixed. Numbers that follow from one are calculated.
#[test]
fn golden_named_parameters_are_parameters_and_what_follows_is_calculated() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly/play_by_one_number.toml");
    let plan = Plan::of(&file::read(&path).unwrap()).unwrap();
    let role = |name: &str| Some(plan.table.rows[plan.table.reference(name)? as usize - 1].role);
    for (name, expected) in [
        ("backlash", Some(Role::Tunable)),
        ("radius", Some(Role::Parameter)),
        ("ratio", Some(Role::Parameter)),
        ("speed", Some(Role::Parameter)),
        ("stop.drive_flank.gap", Some(Role::Calculated)),
        ("stop.drive_flank.arms.wheel", Some(Role::Calculated)),
        ("body.engine.motion.frequency", Some(Role::Calculated)),
        ("body.engine.motion.phase", Some(Role::Tunable)),
    ] {
        assert_eq!(role(name), expected, "{name}");
    }
    // The force of a flank depends on the play, as it would depend on its gap.
    let description = plan.description();
    let force = plan.table.reference("drive_flank.f").unwrap();
    let known = description.outputs.iter().find(|unknown| unknown.reference == force).unwrap();
    let backlash = plan.table.reference("backlash").unwrap();
    let listed = known.dependencies.as_ref().unwrap().iter().filter(|own| own.0 == backlash);
    assert_eq!(listed.count(), 1);
}

/// Numbers that determine times or where a body begins are fixed. Inputs have the unit of the
/// signal to which they are added.
#[test]
fn golden_numbers_of_signals_that_are_fixed_and_units_of_inputs() {
    let plan = Plan::new(include_str!("common/signals.toml").into(), "signals.toml").unwrap();
    let row = |name: &str| &plan.table.rows[plan.table.reference(name).unwrap() as usize - 1];
    for (name, role) in [
        ("load.push.repeat", Role::Parameter),
        ("load.push.table.scale", Role::Tunable),
        ("load.wave.sweep.amplitude", Role::Tunable),
        ("load.wave.sweep.from", Role::Parameter),
        ("load.wave.sweep.duration", Role::Parameter),
        ("body.belt.motion.rate.constant", Role::Tunable),
        ("body.belt.motion.rate.steps[1].time", Role::Tunable),
        ("body.belt.motion.s", Role::Parameter),
        ("body.table.motion.v", Role::Parameter),
    ] {
        assert_eq!(row(name).role, role, "{name}");
    }
    assert_eq!(row("body.belt.motion.rate.input").unit, "m/s");
    assert_eq!(row("body.table.motion.acceleration.input").unit, "m/s2");
}

/// Heights and times of a stepped stiffness are tunable, but its period is fixed. Only such a
/// machine has a variable for the energy that the steps add.
#[test]
fn golden_stiffness_that_steps_and_what_it_puts_in() {
    let plan = Plan::new(include_str!("common/stepped.toml").into(), "stepped.toml").unwrap();
    let row =
        |name: &str| plan.table.reference(name).map(|reference| &plan.table.rows[reference as usize - 1]);
    for (name, role) in [
        ("spring.mesh.stiffness.constant", Some(Role::Tunable)),
        ("spring.mesh.stiffness.steps[0].height", Some(Role::Tunable)),
        ("spring.mesh.stiffness.steps[1].time", Some(Role::Tunable)),
        ("spring.mesh.stiffness.repeat", Some(Role::Parameter)),
        ("spring.mesh.stiffness", None),
        ("stop.pad.stiffness.table.scale", Some(Role::Tunable)),
        ("energy.switched", Some(Role::Output)),
    ] {
        assert_eq!(row(name).map(|row| row.role), role, "{name}");
    }
    assert_eq!(row("spring.mesh.stiffness.steps[0].height").unwrap().unit, "N/m");
    let other = Plan::new(include_str!("common/signals.toml").into(), "signals.toml").unwrap();
    assert_eq!(other.table.reference("energy.switched"), None);
}

#[test]
fn invariant_names_are_unique_and_inputs_are_the_engines() {
    for plan in plans() {
        let names: HashSet<_> = plan.table.rows.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names.len(), plan.table.rows.len(), "{}", plan.name());
        assert_eq!(plan.table.inputs.len(), plan.assembly.system().signals.inputs, "{}", plan.name());
    }
}

#[test]
fn invariant_both_descriptions_have_every_variable_with_a_unit_that_is_defined() {
    for plan in plans() {
        let description = plan.description();
        for row in &plan.table.rows {
            // FMI has no units with exponents that are not integers.
            let is_defined = description.units.iter().any(|unit| unit.name == row.unit);
            assert!(is_defined || row.unit.ends_with(".5"), "{} {}", row.name, row.unit);
        }
        for version in [Version::Fmi2, Version::Fmi3] {
            let text = plan.xml(version, None);
            let count = plan.table.rows.iter().filter(|row| text.contains(&format!("name=\"{}\"", row.name)));
            assert_eq!(count.count(), plan.table.rows.len(), "{}", plan.name());
        }
    }
}

/// Every type that a variable declares is defined, also of numbers whose units FMI cannot write.
#[test]
fn invariant_declared_types_are_defined() {
    let text = "name = \"P\"\nbody.b = { mass = 1.0 }\n\
                spring.k = { between = [\"ground\", \"b\"], coefficient = 5.0, exponent = 1.7 }\n\
                stop.h = { between = [\"ground\", \"b\"], gap = 0.1, stiffness = 3e9, exponent = 1.5 }\n";
    let powers = Plan::new(text.into(), "p.toml").unwrap();
    assert!(powers.xml(Version::Fmi3, None).contains("declaredType=\"PowerCoefficient\""));
    for plan in plans().into_iter().chain([powers]) {
        for version in [Version::Fmi2, Version::Fmi3] {
            let xml = plan.xml(version, None);
            let uses = xml.split("declaredType=\"").skip(1).filter_map(|rest| rest.split('"').next());
            for name in uses.collect::<HashSet<_>>() {
                assert!(xml.contains(&format!("Type name=\"{name}\"")), "{name} in {}", plan.name());
            }
        }
    }
}

/// fmi-sim 0.7 does not open archives in which a variable itself has one of these attributes.
#[test]
fn invariant_units_and_nominal_values_are_those_of_declared_types_in_fmi_3() {
    let mut nominals = 0;
    for plan in plans() {
        let text = plan.xml(Version::Fmi3, None);
        let tags: Vec<&str> = text.split('<').collect();
        let value = |tag: &str, name: &str| -> Option<String> {
            let from = tag.find(&format!(" {name}=\""))? + name.len() + 3;
            Some(tag[from..from + tag[from..].find('"')?].to_string())
        };
        for variable in plan.description().variables {
            let Kind::Real { nominal: Some(nominal), .. } = variable.kind else { continue };
            let is_own = |tag: &&&str| {
                tag.starts_with("Float64 ") && value(tag, "name").as_deref() == Some(&variable.name)
            };
            let tag = tags.iter().find(is_own).unwrap();
            for attribute in ["unit", "displayUnit", "nominal"] {
                assert_eq!(value(tag, attribute), None, "{tag}");
            }
            let own = value(tag, "declaredType").unwrap();
            let declared =
                |tag: &&&str| tag.starts_with("Float64Type ") && value(tag, "name").as_deref() == Some(&own);
            let all: Vec<_> = tags.iter().filter(declared).collect();
            let found = value(all[0], "nominal").map_or(1.0, |text| text.parse().unwrap());
            assert!(all.len() == 1 && found == nominal, "{tag}: {all:?}");
            nominals += usize::from(nominal != 1.0);
        }
    }
    assert!(nominals > 50, "{nominals}");
}

#[test]
fn invariant_the_token_follows_every_byte_of_the_file() {
    let text =
        "name = \"A\"\n[body.b]\nmass = 1.0\n[spring.s]\nbetween = [\"ground\", \"b\"]\nstiffness = 1.0\n";
    let token = |text: &str| Plan::new(text.into(), "a.toml").unwrap().token().to_owned();
    assert_eq!(token(text), token(text));
    assert_ne!(token(text), token(&text.replace("stiffness = 1.0", "stiffness = 2.0")));
    assert_ne!(token(text), token(&format!("{text}\n")));
}

#[test]
fn a_file_reaches_no_other_file() {
    let text = "name = \"A\"\n[body.b]\nmass = 1.0\n[load.l]\non = \"b\"\ntable = \"../../secret.csv\"\n";
    let refused = Plan::new(text.into(), "machine.toml").unwrap_err().to_string();
    assert!(refused.starts_with("machine.toml:6: load.l.table = "), "{refused}");
}

#[test]
fn closed_form_the_default_experiment_follows_from_the_slowest_and_the_fastest_time() {
    // A mass of 1 kg on 1e4 N/m: 0.0628 s; a bumper of 1e6 N/m: a contact of 3.14 ms.
    let own = "[body.b]\nmass = 1.0\n[spring.s]\nbetween = [\"ground\", \"b\"]\nstiffness = 1e4\n";
    let bumper = "[stop.p]\nbetween = [\"ground\", \"b\"]\ngap = 0.1\nstiffness = 1e6\n";
    let drive = "[load.l]\non = \"b\"\namplitude = 1.0\nfrequency = 1000.0\n";
    let slow = "[load.l]\non = \"b\"\namplitude = 1.0\nfrequency = 0.5\n";
    let record = "[load.l]\non = \"b\"\nsteps = [[12.0, 1.0], [30.0, 1.0]]\n";
    // Thrown over 40 cm at 20 m/s: 20 ms.
    let thrown = "[body.b]\nmass = 1.0\nstart = { v = 20.0 }\n[stop.wall]\nbetween = [\"ground\", \"b\"]\ngap = 0.4\nrestitution = 0.5\n";
    let alone = "[body.b]\nmass = 1.0\n";
    let falling = "gravity = 9.81\n[body.b]\nmass = 1.0\ngravity = 1.0\n";
    let floor = "[stop.floor]\nbetween = [\"ground\", \"b\"]\ngap = 1.0\nrestitution = 0.5\n";
    let friction = "[friction.f]\nbetween = [\"ground\", \"b\"]\n";
    let held = "[spring.h]\nbetween = [\"p\", \"b\"]\nstiffness = 1e-3\n";
    let (swing, step) = ("amplitude = 0.1, frequency = 0.5", "steps = [[12.0, 0.1]]");
    // Rotating freely with a second body: the pair has no period.
    let pair =
        "[body.b]\nmass = 1.0\n[body.c]\nmass = 1.0\n[spring.s]\nbetween = [\"b\", \"c\"]\nstiffness = 5e3\n";
    for (text, stop, steps) in [
        (own.to_owned(), 1.3, 1000..=1024),
        (pair.to_owned(), 1.3, 1000..=1024),
        (format!("{own}{bumper}"), 1.3, 4000..=4096),
        (format!("{own}{drive}"), 1.3, 4000..=4096),
        (format!("{own}{slow}"), 40.0, 4000..=4096),
        (format!("{own}{record}"), 30.0, 4000..=4096),
        (format!("{alone}{bumper}"), 0.063, 1000..=1024),
        (thrown.to_owned(), 0.4, 1000..=1024),
        (format!("{alone}[load.l]\non = \"b\"\nconstant = 1.0\n"), 10.0, 1000..=1024),
        // Ten steps in each 10 ms of 1.3 s.
        (format!("{own}{}", drive.replace("1000.0", "100.0")), 1.3, 2000..=2048),
        // Four times the mass doubles the time.
        (format!("{}{bumper}", alone.replace("1.0", "4.0")), 0.13, 1000..=1024),
        // A fall of one metre: √(2/9.81) s; with 1 m/s: (√(1 + 2 · 9.81) - 1)/9.81 s.
        (format!("{falling}{floor}"), 9.1, 1000..=1024),
        (format!("{falling}start = {{ v = 1.0 }}\n{floor}"), 7.3, 1000..=1024),
        // Signals of every kind count through their harmonics and their last change.
        (format!("{own}{}force = {{ constant = 1.0, {swing} }}\n", friction), 40.0, 4000..=4096),
        (
            format!("{own}{}force = 1.0\nstatic = {{ constant = 2.0, {swing} }}\n", friction),
            40.0,
            4000..=4096,
        ),
        (format!("{own}[body.p]\nmotion = {{ {swing} }}\n{held}"), 40.0, 4000..=4096),
        (format!("{own}{}force = {{ constant = 1.0, {step} }}\n", friction), 12.0, 2000..=2048),
        (format!("{own}{}force = 1.0\nstatic = {{ constant = 2.0, {step} }}\n", friction), 12.0, 2000..=2048),
        (format!("{own}[body.p]\nmotion = {{ {step} }}\n{held}"), 12.0, 2000..=2048),
    ] {
        let experiment =
            Plan::new(format!("name = \"A\"\n{text}"), "a.toml").unwrap().description().experiment;
        assert_eq!((experiment.start_time, experiment.stop_time), (0.0, stop), "{text}");
        assert_eq!(experiment.tolerance, 1e-6);
        let count = experiment.stop_time / experiment.step_size;
        assert!(count.fract() == 0.0 && steps.contains(&(count as u32)), "{text}: {count}");
    }
}

/// `N.m.s/rad` is kg m² s⁻¹ rad⁻¹.
#[test]
fn closed_form_units_have_the_exponents_that_their_names_say() {
    let base = |name: &str| -> [i32; 4] {
        match name {
            "1" => [0, 0, 0, 0],
            "kg" => [1, 0, 0, 0],
            "m" => [0, 1, 0, 0],
            "m2" => [0, 2, 0, 0],
            "m3" => [0, 3, 0, 0],
            "s" => [0, 0, 1, 0],
            "s2" => [0, 0, 2, 0],
            "rad" => [0, 0, 0, 1],
            "N" => [1, 1, -2, 0],
            "J" => [1, 2, -2, 0],
            "Hz" => [0, 0, -1, 0],
            other => panic!("{other}"),
        }
    };
    let mut units = HashSet::new();
    for unit in plans().iter().flat_map(|plan| plan.description().units) {
        let mut sum = [0; 4];
        for (k, part) in unit.name.split('/').enumerate() {
            for own in part.split('.').map(base) {
                (0..4).for_each(|i| sum[i] += if k == 0 { own[i] } else { -own[i] });
            }
        }
        let [kg, m, s, rad] = sum;
        assert_eq!(unit.exponents, [kg, m, s, 0, 0, 0, 0, rad], "{}", unit.name);
        // Display units: milli and kilo by their first letters.
        for (name, factor) in &unit.display {
            let rest = name.strip_suffix(&*unit.name).unwrap_or_default();
            let expected = match rest {
                "m" => 1e3,
                "k" => 1e-3,
                _ => continue,
            };
            assert_eq!(*factor, expected, "{name}");
        }
        units.insert(unit.name);
    }
    assert!(units.len() > 15, "{units:?}");
}

#[test]
fn invariant_states_are_described_with_their_nominals_and_derivatives() {
    for plan in plans() {
        let (states, nominals) = (&plan.states, &plan.nominals);
        for variable in plan.description().variables {
            let quantity = plan.table.rows[variable.reference as usize - 1].quantity;
            let Kind::Real { nominal, derivative_of, reinit, .. } = variable.kind else { continue };
            let place = |which: usize| states.iter().position(|own| quantity == Quantity::Column(own[which]));
            let expected = place(0).map(|k| nominals[k]);
            assert_eq!(nominal, expected, "{} {}", plan.name(), variable.name);
            assert_eq!(reinit, expected.is_some());
            // A rate follows its state in the list; the sliders of two tangents follow each other.
            let name = variable.name.strip_suffix("].rate").map(|name| format!("{name}]"));
            let of_slider = name.map(|name| plan.table.reference(&name).unwrap());
            let before = place(1).map(|_| of_slider.unwrap_or(variable.reference - 1));
            assert_eq!(derivative_of, before, "{}", variable.name);
        }
    }
}

#[test]
fn invariant_parameters_and_inputs_are_described_by_their_start_range_and_role() {
    for plan in plans() {
        for variable in plan.description().variables {
            let row = &plan.table.rows[variable.reference as usize - 1];
            if let Quantity::Input(_) = row.quantity {
                assert_eq!(variable.start, Some(0.0), "{}", row.name);
            }
            let Quantity::Parameter(place) = row.quantity else { continue };
            let parameter = &plan.table.parameters[place];
            let follows = plan.assembly.description.named.numbers_of(&row.name);
            let times =
                [".repeat", ".sample", ".delay", ".from", ".to", ".duration", ".motion.s", ".motion.v"];
            let is_time = times.iter().any(|end| row.name.ends_with(end));
            let fixed = is_time
                || [".start.", ".start[", ".arms.", ".slider", ".sample"]
                    .iter()
                    .any(|part| row.name.contains(part) || follows.iter().any(|name| name.contains(part)));
            let tunable = !fixed && !follows.iter().any(|name| name.ends_with(".frequency"));
            let expected = if tunable { Variability::Tunable } else { Variability::Fixed };
            assert_eq!(
                (variable.variability, variable.start),
                (expected, Some(parameter.value)),
                "{}",
                row.name
            );
            // The range of a named parameter follows from its use (tests/components/named.rs).
            if !follows.is_empty() {
                continue;
            }
            let range = parameter.range();
            assert!(variable.min.is_none_or(|min| min == range.min), "{}", row.name);
            assert!(variable.max.is_none_or(|max| max == range.max), "{}", row.name);
            assert_eq!(variable.min.is_some(), range.min > f64::MIN, "{}", row.name);
            assert_eq!(variable.max.is_some(), range.max < f64::MAX, "{}", row.name);
        }
    }
}

/// Everything that hosts may do with a machine; the tests of the C interface do each of these.
#[test]
fn golden_capabilities_are_those_of_the_component() {
    let plan = Plan::new(include_str!("common/everything.toml").into(), "everything.toml").unwrap();
    let attributes = |version: Version, element: &str| -> Vec<String> {
        let text = plan.xml(version, None);
        let from = text.find(&format!("<{element}")).unwrap();
        let tag = &text[from..from + text[from..].find('>').unwrap()];
        let words = tag.split_whitespace().map(|word| word.trim_end_matches('/').replace('"', ""));
        let mut words: Vec<String> = words.filter(|word| word.contains('=')).collect();
        // The library, not the machine, determines the other attributes.
        words.retain(|word| !["modelI", "canBeI", "canNot", "needsE"].contains(&&word[..6]));
        words.sort();
        words
    };
    for (version, element, expected) in [
        (
            Version::Fmi2,
            "ModelExchange",
            "canGetAndSetFMUstate=true canSerializeFMUstate=true \
             completedIntegratorStepNotNeeded=false providesDirectionalDerivative=true",
        ),
        (
            Version::Fmi2,
            "CoSimulation",
            "canGetAndSetFMUstate=true canHandleVariableCommunicationStepSize=true \
             canInterpolateInputs=true canRunAsynchronuously=false canSerializeFMUstate=true \
             maxOutputDerivativeOrder=3 providesDirectionalDerivative=true",
        ),
        (
            Version::Fmi3,
            "ModelExchange",
            "canGetAndSetFMUState=true canSerializeFMUState=true needsCompletedIntegratorStep=true \
             providesAdjointDerivatives=true providesDirectionalDerivatives=true \
             providesPerElementDependencies=false",
        ),
        (
            Version::Fmi3,
            "CoSimulation",
            "canGetAndSetFMUState=true canHandleVariableCommunicationStepSize=true \
             canReturnEarlyAfterIntermediateUpdate=true canSerializeFMUState=true \
             hasEventMode=true maxOutputDerivativeOrder=3 mightReturnEarlyFromDoStep=true \
             providesAdjointDerivatives=true providesDirectionalDerivatives=true \
             providesIntermediateUpdate=true providesPerElementDependencies=false \
             recommendedIntermediateInputSmoothness=3",
        ),
    ] {
        assert_eq!(attributes(version, element).join(" "), expected, "{version:?} {element}");
    }
}
