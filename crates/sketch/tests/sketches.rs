//! Sketches of all example machines.

use std::collections::BTreeSet;
use std::path::Path;
use vibro_figures::canvas;
use vibro_machine::{Description, file};
use vibro_sketch::Sketch;

fn examples() -> Vec<(String, Description)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly");
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let paths = paths.filter(|path| path.extension().is_some_and(|ending| ending == "toml"));
    let read = |path: std::path::PathBuf| {
        (path.file_stem().unwrap().to_str().unwrap().to_owned(), file::read(&path).unwrap())
    };
    let examples: Vec<_> = paths.map(read).collect();
    assert!(examples.len() > 20, "{}", examples.len());
    examples
}

#[test]
fn invariant_every_body_and_element_is_named_once() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sketches");
    std::fs::create_dir_all(&folder).unwrap();
    for (name, machine) in examples() {
        let (svg, png) = canvas::svg_and_png(&Sketch::new(&machine)).unwrap();
        let elements = machine.springs.iter().map(|x| &x.name).chain(machine.stops.iter().map(|x| &x.name));
        let elements = elements.chain(machine.frictions.iter().map(|x| &x.name));
        let elements = elements
            .chain(machine.links.iter().map(|x| &x.name))
            .chain(machine.loads.iter().map(|x| &x.name));
        let elements = elements.chain(machine.blocks.iter().map(|x| &x.name));
        // A body with several coordinates is drawn once, with its nodes.
        let of = |name: &str| name.split(['.', '[']).next().unwrap_or_default().to_owned();
        let bodies: BTreeSet<String> = machine.bodies.iter().map(|body| of(&body.name)).collect();
        // A body and an element may have the same name.
        let all: Vec<&String> = bodies.iter().chain(elements).collect();
        for text in &all {
            let named = all.iter().filter(|own| *own == text).count();
            assert_eq!(svg.matches(&format!(">{text}<")).count(), named, "{name}: {text}");
        }
        for block in &machine.blocks {
            let inputs = machine.names_of_inputs(block);
            inputs.iter().for_each(|input| assert!(svg.contains(&format!(">{input}<")), "{name}: {input}"));
        }
        for feed in &machine.feeds {
            let output = &machine.blocks[feed.block].outputs[feed.output];
            let fed = format!(">{output} \u{2192} ");
            assert!(svg.contains(&fed), "{name}: {fed}{}", machine.loads[feed.load].name);
        }
        std::fs::write(folder.join(&name).with_extension("png"), png).unwrap();
        let icon = canvas::png(&Sketch::icon(&machine)).unwrap();
        std::fs::write(folder.join(format!("{name}-icon.png")), icon).unwrap();
    }
}

/// A curved spring or dashpot has an arrow across; a spring without stiffness is still a zigzag.
#[test]
fn invariant_curved_elements_have_an_arrow_across() {
    // An arrow is a line and its head.
    let strokes = |element: &str| {
        let text =
            format!("name = \"M\"\nbody.b = {{ mass = 1.0 }}\n{element}, between = [\"ground\", \"b\"] }}\n");
        let machine = file::parse(&text, "m.toml", &file::no_records).unwrap();
        let (svg, _) = canvas::svg_and_png(&Sketch::new(&machine)).unwrap();
        svg.matches("<path").count()
    };
    let straight = strokes("spring.s = { stiffness = 1.0, damping = 1.0");
    for curved in [
        "spring.s = { stiffness = 1.0, cubic = 1.0, damping = 1.0",
        "spring.s = { cubic = 1.0, damping = 1.0",
        "spring.s = { force = \"= sin(e)\", damping = 1.0",
        "spring.s = { stiffness = 1.0, offset = 0.1, free_length = 0.2, damping = 1.0",
    ] {
        assert_eq!(strokes(curved), straight + 2, "{curved}");
    }
    let straight = strokes("damper.s = { damping = 1.0");
    assert_eq!(strokes("damper.s = { damping = 1.0, cubic = 1.0"), straight + 2);
    assert_eq!(strokes("damper.s = { force = \"= tanh(rate)\""), straight + 2);
}
