//! Pictures of motions of the gallery's machines: words, equal curves, loops.

use std::path::Path;
use std::sync::Arc;
use vibro_studies::Start;

/// The picture of a motion of an example.
fn pictured(name: &str, until: f64, samples: usize) -> vibro_figures::chart::Figure {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly").join(name);
    drawn(vibro_machine::file::read(&path).unwrap(), until, samples)
}

fn drawn(
    description: vibro_machine::Description,
    until: f64,
    samples: usize,
) -> vibro_figures::chart::Figure {
    let times = vibro::machine::even_times((0.0, until), samples).unwrap();
    let record =
        vibro::machine::record(description, &Start::default(), &times, &Arc::default(), &mut |_| ()).unwrap();
    vibro::machine::figure(&record, Vec::new()).unwrap()
}

/// Title, axes and curves of clutches in words. Where no stop is, the picture shows the sliding.
#[test]
fn golden_words_of_a_picture() {
    let picture = pictured("msl_coupled_clutches.toml", 0.1, 50);
    assert_eq!(picture.title, "Msl coupled clutches");
    let panels: Vec<_> =
        picture.panels.iter().map(|own| (own.title.as_str(), own.y.label.as_str())).collect();
    let expected = [
        ("(a)", "angle, rad"),
        ("(b)", "relative angular velocity, rad/s"),
        ("(c)", "torque of clutch 1, N·m"),
    ];
    assert_eq!(panels, expected);
    assert_eq!((picture.panels[0].x.label.as_str(), picture.panels[0].x.factor), ("time, s", Some(1.0)));
    // J3 and J4, and clutches 2 and 3, do not move yet: equal curves are one.
    let names = |panel: usize| -> Vec<_> {
        picture.panels[panel].layers.iter().filter_map(|layer| layer.name.as_deref()).collect()
    };
    assert_eq!(names(0), ["J1", "J2", "J3 = J4"]);
    assert_eq!(names(1), ["clutch 1", "clutch 2", "clutch 3"]);
}

/// The area of the loop of Iwan's joint is the loss of its sliders, 4 slip (X - slip/k) each.
#[test]
fn closed_form_area_of_the_loop_of_a_joint() {
    // 720 chords cut off the loop's ten corners by up to a chord each.
    const CORNERS: f64 = 1e-3;
    let picture = pictured("iwan_joint.toml", 1.0, 10);
    let panel = picture.panels.iter().find(|own| own.x.label == "relative displacement, mm").unwrap();
    assert_eq!(panel.title, "(b) the next period: slip 1 + slip 2 + slip 3 + slip 4");
    let points = panel.layers[0].extent();
    let area: f64 = points.windows(2).map(|p| 0.5 * (p[0].0 * p[1].1 - p[1].0 * p[0].1)).sum();
    let largest = points.iter().fold(0.0, |most: f64, p| most.max(p.0.abs()));
    let lost: f64 = [2.0, 5.0, 9.0, 14.0].iter().map(|slip| 4.0 * slip * (largest - slip / 2e4)).sum();
    assert!((area.abs() / lost - 1.0).abs() < CORNERS, "{area} {lost}");
}

/// A contact with two tangents under a constant normal force has a force and a loop of each
/// tangent. The loop's area is 4 μ N (X - μ N/k).
#[test]
fn closed_form_areas_of_the_loops_of_two_tangents() {
    // 720 chords cut off each loop's four corners by up to a chord each.
    const CORNERS: f64 = 1e-3;
    let text = "name = \"Face\"\nbody.seat = { motion = { constant = 0.25 } }\n\
        body.x = { motion = { amplitude = 0.3, frequency = 2.0 } }\n\
        body.y = { motion = { amplitude = 0.2, frequency = 2.0, phase = 1.0 } }\n\
        body.box = { mass = 1.0 }\nspring.k = { between = [\"ground\", \"box\"], stiffness = 1.0 }\n\
        contact.pad = { normal = [\"ground\", \"seat\"], tangent = [\"ground\", \"x\"], second_tangent = [\"ground\", \"y\"], \
        cone = \"box\", gap = 0.0, stiffness = 128.0, tangential_stiffness = [256.0, 160.0], friction = 0.5 }\n";
    let machine = vibro_machine::file::parse(text, "face.toml", &vibro_machine::file::no_records).unwrap();
    let picture = drawn(machine, 1.0, 10);
    let names = |label: &str| -> Vec<String> {
        let panel = picture.panels.iter().find(|own| own.y.label == label).unwrap();
        panel.layers.iter().filter_map(|layer| layer.name.clone()).collect()
    };
    assert_eq!(names("force, N"), ["pad", "pad, first tangential", "pad, second tangential"]);
    let panel = picture.panels.iter().find(|own| own.x.label.starts_with("relative displacement")).unwrap();
    for (layer, (name, amplitude, stiffness)) in
        panel.layers.iter().zip([("first", 0.3, 256.0), ("second", 0.2, 160.0)])
    {
        assert_eq!(layer.name.as_deref(), Some(format!("pad, {name} tangent").as_str()));
        let points = layer.extent();
        let area: f64 = points.windows(2).map(|p| 0.5 * (p[0].0 * p[1].1 - p[1].0 * p[0].1)).sum();
        let lost = 4.0 * 16.0 * (amplitude - 16.0 / stiffness);
        assert!((area.abs() / lost - 1.0).abs() < CORNERS, "{area} {lost}");
    }
}
