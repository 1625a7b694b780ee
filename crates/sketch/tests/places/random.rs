//! Random machines.

use std::fmt::Write;
use vibro_machine::Description;
use vibro_machine::file::{no_records, parse};

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

/// A machine of one to nine bodies with up to fourteen elements of all kinds: a third without
/// gravity, a third with coordinates downwards, and a third with coordinates upwards.
pub fn machine(seed: u64) -> Description {
    let random = &mut Random(seed);
    let count = 1 + random.below(9);
    let names: Vec<String> = (0..count).map(|i| format!("{}{i}", random.one_of(&WORDS))).collect();
    let mut text = String::from("name = \"Random\"\ngravity = 9.81\n");
    let falling =
        ["mass = 1.0", "mass = 1.0\ngravity = 0.5", "mass = 1.0\ngravity = -1.0"][(seed % 3) as usize];
    for (i, name) in names.iter().enumerate() {
        let kind = [falling, "mass = 2.0", "motion = { rate = 1.0 }"];
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
        let third = (0..count).find(|i| *i != a && *i != b).filter(|_| a != b && random.below(5) == 0);
        let ends = match third {
            Some(c) if a < count && b < count => {
                format!("arms = {{ {} = 0.5, {} = 0.25, {} = -1.0 }}", name(a), name(b), name(c))
            }
            _ => ends,
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
