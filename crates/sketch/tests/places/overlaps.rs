//! In the sketches of all example machines and of random machines nothing lies over another thing
//! or outside the picture.

use crate::marks::{Marks, Rectangle};
use crate::random;
use std::path::Path;
use vibro_figures::canvas;
use vibro_machine::{Description, file};
use vibro_sketch::Sketch;

/// Number of random machines.
const MACHINES: u64 = 200;
/// Number of random machines whose pictures are written to `target/tmp/sketches/`, for inspection.
const PICTURES: u64 = 20;
/// Largest displacement of a body in the workbench (`REACH` in scene.js), in units of the drawing.
const REACH: f64 = 85.0;
/// Width of the border of a body, into which a symbol may reach, in units of the drawing.
const BORDER: f64 = 7.0;

/// All example machines, and random machines, each with its name.
fn machines() -> Vec<(String, Description)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/assembly");
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let paths = paths.filter(|path| path.extension().is_some_and(|ending| ending == "toml"));
    let read = |path: std::path::PathBuf| (path.display().to_string(), file::read(&path).unwrap());
    let examples = paths.map(read);
    examples.chain((0..MACHINES).map(|seed| (format!("random{seed}"), random::machine(seed)))).collect()
}

/// Everything that lies over another thing, or outside the picture.
fn faults(marks: &Marks, items: usize) -> Vec<String> {
    let mut faults = Vec::new();
    let mut fault = |words: String| faults.push(words);
    let picture = Rectangle([0.0, 0.0, marks.size.0, marks.size.1]);
    let strokes: Vec<_> =
        marks.lines.iter().map(|line| (line.0, Rectangle::around(&line.1).grown(0.5 * line.2))).collect();
    for (item, rectangle) in strokes.iter().chain(&marks.fills) {
        if !picture.holds(*rectangle) {
            fault(format!("a mark of {item:?} at {rectangle:?} is outside"));
        }
    }
    for (i, (item, label, words)) in marks.labels.iter().enumerate() {
        if !picture.holds(*label) {
            fault(format!("{words} at {label:?} is outside {picture:?}"));
        }
        for (_, other, text) in marks.labels[i + 1..].iter().filter(|other| label.meets(other.1)) {
            fault(format!("{words} at {label:?} is over {text} at {other:?}"));
        }
        for (of, line, width) in marks.lines.iter().filter(|line| label.is_crossed(line.1, line.2)) {
            fault(format!("{words} at {label:?} is over a line of {of:?}: {line:?}, {width} wide"));
        }
        for (of, fill) in &marks.fills {
            // The name of a body is inside its box, that of a block, too.
            let own = of == item && marks.boxes.iter().any(|own| Some(own.0) == *of && own.1.holds(*label));
            if label.meets(*fill) && !own {
                fault(format!("{words} at {label:?} is over a fill of {of:?}: {fill:?}"));
            }
        }
    }
    for &(own, rectangle) in &marks.boxes {
        let inside = rectangle.grown(-BORDER);
        for (of, line, width) in marks.lines.iter().filter(|line| line.0 != Some(own)) {
            if inside.is_crossed(*line, *width) {
                fault(format!("a line of {of:?} is in the box of {own}: {line:?}"));
            }
        }
    }
    // Symbols of two elements touch at most at the ends of their lines.
    let elements: Vec<usize> =
        (0..items).filter(|item| marks.boxes.iter().all(|own| own.0 != *item)).collect();
    for (k, &one) in elements.iter().enumerate() {
        for &two in &elements[k + 1..] {
            if marks.around(one).grown(-BORDER).meets(marks.around(two).grown(-BORDER)) {
                fault(format!("the symbols {one} and {two} overlap"));
            }
        }
    }
    faults
}

#[test]
fn invariant_nothing_lies_over_another_thing_or_outside() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sketches");
    std::fs::create_dir_all(&folder).unwrap();
    let (mut all, mut pictures) = (Vec::new(), 0);
    for (name, machine) in machines() {
        let sketch = Sketch::new(&machine);
        let marks = Marks::of(&sketch);
        if name.starts_with("random") && pictures < PICTURES {
            pictures += 1;
            std::fs::write(folder.join(&name).with_extension("png"), canvas::png(&sketch).unwrap()).unwrap();
        }
        let names: Vec<&str> = sketch.names().collect();
        assert!(marks.labels.len() >= names.iter().filter(|name| !name.is_empty()).count(), "{name}");
        all.extend(faults(&marks, names.len()).into_iter().map(|fault| format!("{name}: {fault}")));
    }
    assert!(all.is_empty(), "{} faults:\n{}", all.len(), all.join("\n"));
}

#[test]
fn invariant_names_of_loads_stay_off_the_ground_in_motion() {
    let mut loads = 0;
    for (name, machine) in machines() {
        let sketch = Sketch::new(&machine);
        for shift in [-REACH, REACH] {
            let marks = Marks::of(&sketch.moved(&|_| shift, &|_| None));
            let names = sketch.names().collect::<Vec<_>>();
            let load = |item: &Option<usize>| {
                item.is_some_and(|item| machine.loads.iter().any(|load| load.name == names[item]))
            };
            for (_, label, words) in marks.labels.iter().filter(|label| load(&label.0)) {
                loads += 1;
                let over =
                    marks.lines.iter().find(|line| line.0.is_none() && label.is_crossed(line.1, line.2));
                assert!(
                    over.is_none(),
                    "{name}: {words} at {label:?}, bodies moved by {shift}, is over {over:?}"
                );
            }
        }
    }
    assert!(loads > 100, "{loads}");
}
