//! Sketches of random machines: names do not overlap, leave the picture or lie under a line.

use std::fmt::Write;
use std::path::Path;
use vibro_figures::canvas::{self, text_width};
use vibro_machine::Description;
use vibro_machine::file::{no_records, parse};
use vibro_sketch::Sketch;

/// Number of machines.
const MACHINES: u64 = 200;
/// Number of machines whose pictures are written to `target/tmp/sketches/`, for inspection.
const PICTURES: u64 = 20;
/// SplitMix64.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % limit as u64) as usize
    }

    fn one_of<'a>(&mut self, list: &[&'a str]) -> &'a str {
        list[self.below(list.len())]
    }
}

/// Parts of names, short and long.
const WORDS: [&str; 8] =
    ["a", "box", "lever", "wheel", "secondary_mass", "K2", "transmission", "upper_limit"];

/// A machine of one to nine bodies with up to fourteen elements of all kinds.
fn machine(seed: u64) -> Description {
    let random = &mut Random(seed);
    let count = 1 + random.below(9);
    let names: Vec<String> = (0..count).map(|i| format!("{}{i}", random.one_of(&WORDS))).collect();
    let mut text = String::from("name = \"Random\"\ngravity = 9.81\n");
    for (i, name) in names.iter().enumerate() {
        let kind = ["mass = 1.0\ngravity = 0.5", "mass = 2.0", "motion = { rate = 1.0 }"];
        let kind = if i == 0 { kind[1] } else { kind[random.below(3)] };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "[body.{name}]\n{kind}");
        // Each body has an element.
        let _ = writeln!(text, "[spring.g{i}]\nbetween = [\"ground\", \"{name}\"]\nstiffness = 1.0");
    }
    for k in 0..random.below(15) {
        let (a, b) = (random.below(count + 1), random.below(count + 1));
        let name = |i: usize| names.get(i).map_or("ground", String::as_str);
        let ends = if a == b {
            format!("between = [\"ground\", \"{}\"]", name(a % count))
        } else if a < count && b < count && random.below(3) == 0 {
            let arm = random.one_of(&["0.05", "-1.25", "3.0", "1234.5"]);
            format!("arms = {{ {} = {arm}, {} = 0.125 }}", name(a), name(b))
        } else {
            format!("between = [\"{}\", \"{}\"]", name(a), name(b))
        };
        let keys = [
            "[spring.NAME]\nENDS\nstiffness = 1.0\ndamping = 2.0",
            "[spring.NAME]\nENDS\nstiffness = 0.0\ndamping = 2.0",
            "[stop.NAME]\nENDS\ngap = 1.0\nrestitution = 0.5",
            "[stop.NAME]\nENDS\ngap = 1.0\nstiffness = 9.0",
            "[friction.NAME]\nENDS\nforce = 1.0",
            "[freewheel.NAME]\nENDS",
            "[load.NAME]\non = \"FIRST\"\nconstant = 1.0",
        ];
        let element = keys[random.below(keys.len())].replace("ENDS", &ends).replace("FIRST", &names[0]);
        text += &element.replace("NAME", &format!("{}_{k}", random.one_of(&WORDS)));
        text.push('\n');
    }
    for k in 0..random.below(4) {
        let (inputs, outputs) = (1 + random.below(3), 1 + random.below(3));
        let inputs: Vec<String> = (0..inputs)
            .map(|i| format!("\"{}.{}\"", names[random.below(count)], ["s", "v"][i % 2]))
            .collect();
        let rows = format!("[{}]", vec!["1.0"; inputs.len()].join(", "));
        let named: Vec<String> = (0..outputs).map(|i| format!("\"{}{i}\"", random.one_of(&WORDS))).collect();
        let sample = ["", "sample = 1e-3\n"][random.below(2)];
        let _ = writeln!(
            text,
            "[block.block_{k}]\ninputs = [{}]\nd = [{}]\noutputs = [{}]\n{sample}",
            inputs.join(", "),
            vec![rows; outputs].join(", "),
            named.join(", ")
        );
        let output = named[0].trim_matches('"');
        let _ = writeln!(text, "[load.of_{k}]\non = \"{}\"\nfrom = \"block_{k}.{output}\"", names[0]);
    }
    parse(&text, "random.toml", &no_records).unwrap_or_else(|problem| panic!("{problem}\n{text}"))
}

/// The value of an attribute.
fn attribute<'a>(element: &'a str, name: &str) -> Option<&'a str> {
    element.split_once(&format!(" {name}=\""))?.1.split('"').next()
}

/// The bounding box of a text, from widths of letters and the height of capitals, in units of the
/// drawing.
#[derive(Debug)]
struct Label {
    words: String,
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Label {
    fn meets(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    /// Whether a vertical or horizontal line crosses it.
    fn is_crossed(&self, [(x0, y0), (x1, y1)]: [(f64, f64); 2]) -> bool {
        x0.min(x1) < self.right && x0.max(x1) > self.left && y0.min(y1) < self.bottom && y0.max(y1) > self.top
    }
}

/// The labels of an SVG.
fn labels(svg: &str) -> Vec<Label> {
    let number = |element: &str, name: &str| attribute(element, name).and_then(|x| x.parse::<f64>().ok());
    let texts = svg.split("<text").skip(1);
    let label = |text: &str| {
        let (element, rest) = text.split_once('>').unwrap();
        let words = rest.split('<').next().unwrap().replace("&lt;", "<").replace("&amp;", "&");
        let [x, y] = ["x", "y"].map(|name| number(element, name).unwrap_or_else(|| panic!("{text}")));
        let size = number(element, "font-size").unwrap_or_else(|| panic!("{text}"));
        let width = text_width(&words, size);
        let left = match attribute(element, "text-anchor") {
            Some("middle") => x - 0.5 * width,
            Some("end") => x - width,
            _ => x,
        };
        // The baseline is at y; capitals have 0.7 of the font's size.
        Label { words, left, right: left + width, top: y - 0.7 * size, bottom: y }
    };
    texts.map(label).collect()
}

/// The vertical and horizontal parts of all lines of an SVG.
fn lines(svg: &str) -> Vec<[(f64, f64); 2]> {
    let mut found = Vec::new();
    for element in svg.split("<path").skip(1).map(|rest| rest.split('>').next().unwrap()) {
        for piece in attribute(element, "d").unwrap_or("").split('M').skip(1) {
            let words = piece.split(|c: char| !(c.is_ascii_digit() || "-.".contains(c)));
            let numbers: Vec<f64> = words.filter_map(|word| word.parse().ok()).collect();
            let places: Vec<(f64, f64)> = numbers.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
            let straight = |pair: &&[(f64, f64)]| pair[0].0 == pair[1].0 || pair[0].1 == pair[1].1;
            found.extend(places.windows(2).filter(straight).map(|pair| [pair[0], pair[1]]));
        }
    }
    found
}

#[test]
fn invariant_no_names_meet_and_none_lies_outside() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sketches");
    std::fs::create_dir_all(&folder).unwrap();
    for seed in 0..MACHINES {
        let machine = machine(seed);
        let sketch = Sketch::new(&machine);
        let (svg, png) = canvas::svg_and_png(&sketch).unwrap();
        if seed < PICTURES {
            std::fs::write(folder.join(format!("random{seed}.png")), png).unwrap();
        }
        let (width, height) = canvas::Drawing::size(&sketch);
        let labels = labels(&svg);
        let named =
            machine.bodies.len() + machine.springs.len() + machine.stops.len() + machine.frictions.len();
        assert!(labels.len() >= named + machine.loads.len(), "{seed}");
        for (i, label) in labels.iter().enumerate() {
            let inside = label.left >= 0.0 && label.right <= f64::from(width) && label.top >= 0.0;
            assert!(inside && label.bottom <= f64::from(height), "{seed}: {label:?} of {width} x {height}");
            let met = labels[i + 1..].iter().find(|other| label.meets(other)).map(|other| &other.words);
            assert!(met.is_none(), "{seed}: {} meets {met:?}", label.words);
        }
        for line in lines(&svg) {
            let crossed = labels.iter().find(|label| label.is_crossed(line));
            assert!(crossed.is_none(), "{seed}: {line:?} crosses {crossed:?}");
        }
    }
}
