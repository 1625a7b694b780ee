//! Help texts of commands that take either machine, for one of the two.

use clap::builder::{Resettable, StyledStr};

/// Machine that a help text describes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// The machine of a FILE.
    File,
    /// The paper's machine.
    Paper,
}

/// Parts of help texts that describe both machines, and their replacements for a machine's file
/// and for the paper's machine. A default is written `[default: A; with FILE B]`.
const WORDS: [[&str; 3]; 25] = [
    [". Without it the paper's machine", "", ""],
    [" [default without FILE: f10=0.5:5]", "", " [default: f10=0.5:5]"],
    ["f10=0.5:5 or, with FILE, stop.steel.gap=1mm:8mm:200", "stop.steel.gap=1mm:8mm:200", "f10=0.5:5"],
    [
        "in each drive period, at most 10000; with FILE in all, after that of time 0",
        "in all, after that of time 0",
        "in each drive period, at most 10000",
    ],
    ["; with FILE, unless the motion has settled before", ", unless the motion has settled before", ""],
    ["; with FILE, unless it has settled before", ", unless it has settled before", ""],
    [
        "; with FILE 8 to 1000000, after 32 in which the variation turns into its direction",
        ", 8 to 1000000, after 32 in which the variation turns into its direction",
        "",
    ],
    [
        "Coordinate whose local maxima are drawn: x1, x2, x3 or w; with FILE any quantity: box.s, box.v, box.a, steel.e, \
         steel.rate, steel.f",
        "Quantity whose local maxima are drawn: box.s, box.v, box.a, steel.e, steel.rate, steel.f",
        "Coordinate whose local maxima are drawn: x1, x2, x3 or w",
    ],
    [
        ". With FILE also the time (time=0.2s), or a start's file, such as the end.toml of a run, with numbers behind it that \
         replace its own (end.toml,block.v=0); what is not named is as the machine's file says. Without FILE also x1 x2 x3 in \
         L, v1 v2 v3 in L omega10; what is not named is zero; \"orbit\" starts on the exact orbit where it is stable",
        ", the time (time=0.2s), or a start's file, such as the end.toml of a run, with numbers behind it that replace its own \
         (end.toml,block.v=0); what is not named is as the machine's file says",
        ", or x1 x2 x3 in L, v1 v2 v3 in L omega10; what is not named is zero; \"orbit\" starts on the exact orbit where it is \
         stable",
    ],
    [" (figure 14)", "", " (figure 14)"],
    [
        " (figure 14, table 2): all of them, or with FILE the largest (--spectrum: all), and without --vary of the machine as \
         it is",
        ": the largest (--spectrum: all), and without --vary of the machine as it is",
        " (figure 14, table 2): all of them",
    ],
    [
        "With FILE one variation is carried exactly through flights and events (saltation matrices).",
        "One variation is carried exactly through flights and events (saltation matrices).",
        "",
    ],
    [
        "The motion of a FILE is looked at after each common period of what drives the machine; --period and --section say \
         otherwise.",
        "The motion is looked at after each common period of what drives the machine; --period and --section say otherwise.",
        "",
    ],
    [
        ": of a FILE over any of its numbers; of the paper's machine by theory (figures 10, 11)",
        ", over any number of the machine",
        " by theory (figures 10, 11)",
    ],
    [
        "With FILE motions are followed until they settle, rising and falling over the range, and each orbit on which one \
         settles is followed over the whole range, stable or not.",
        "Motions are followed until they settle, rising and falling over the range, and each orbit on which one settles is \
         followed over the whole range, stable or not.",
        "",
    ],
    [": of a FILE over any two numbers of its starts", ", any two numbers of the starts", ""],
    [
        "With FILE attractors are told apart by class, period and states at the section, and named by the events of their \
         orbits. Motions without a period count as one attractor of their class.",
        "Attractors are distinguished by class, period and states at the section, and named by the events of their orbits. \
         Motions without a period count as one attractor of their class.",
        "",
    ],
    [
        ": with FILE any of its numbers, such as load.shaker.frequency=8Hz:12Hz; without, sigma1 (frequency response), f10 \
         (force response) or another parameter",
        ", such as load.shaker.frequency=8Hz:12Hz",
        ": sigma1 (frequency response), f10 (force response) or another parameter",
    ],
    [
        "What is drawn. With FILE an output of `vibro sweep`, such as amplitude.box.s or maximum.buffer.f, or a quantity, of \
         which the largest value is drawn; without, the amplitude of x1 (the box), x2 (the block), x3, w = x2 - x1 [default: \
         with FILE the amplitude of the first free body; without, the paper's C and A3]",
        "What is drawn: an output of `vibro sweep`, such as amplitude.box.s or maximum.buffer.f, or a quantity, of which the \
         largest value is drawn [default: the amplitude of the first free body]",
        "What is drawn: the amplitude of x1 (the box), x2 (the block), x3, w = x2 - x1 [default: the paper's C and A3]",
    ],
    [
        ". With FILE kinds and elements, \"impact steel, press buffer\"; kinds of events other than impact, chatter and press \
         that are not mentioned are left out. Without FILE impacts as U (upper stop) and L (lower stop); a word that ends in \
         \"-\" is half of a symmetric orbit: U- is the motion with two symmetric impacts a period",
        ": kinds and elements, \"impact steel, press buffer\"; kinds of events other than impact, chatter and press that are \
         not mentioned are left out",
        ": impacts as U (upper stop) and L (lower stop); a word that ends in \"-\" is half of a symmetric orbit: U- is the \
         motion with two symmetric impacts a period",
    ],
    [
        ": with FILE in common periods of the drive, 2T, or a time, 0.1s; without FILE the number of drive periods, with \
         --word [default without FILE: 1]",
        " in common periods of the drive, 2T, or a time, 0.1s",
        ": the number of drive periods, with --word [default: 1]",
    ],
    [", with FILE also ST, CC or SA", ", ST, CC or SA", ""],
    ["With FILE two ranges", "Two ranges", ""],
    [" Without FILE initial values that are on no axis, e.g. block.s=5mm,v1=1; zero unless named", "", ""],
    ["(--over), and from several starts", "(--over)", "(--over), and from several starts"],
];

/// Help of `--set` for a machine's file, and for the paper's machine.
const SET: [&str; 2] = [
    "Set one parameter, e.g. stop.steel.gap=5mm. May be repeated",
    "Set one parameter, e.g. kappa=0.6, box.k=48kN/m. May be repeated",
];

/// Help of `basin --start` for the paper's machine; it shares nothing with the help for a file.
const BASIN_START: [&str; 2] = [
    "With FILE two ranges of numbers of the starts",
    "Initial values that are on no axis, e.g. block.s=5mm,v1=1; zero unless named",
];

/// A help text that describes one of the two machines.
pub fn words(text: Option<&StyledStr>, of: Of) -> Resettable<StyledStr> {
    let Some(text) = text else { return Resettable::Reset };
    let mut text = text.to_string();
    if text.starts_with("Set one parameter") {
        return Resettable::Value(SET[usize::from(of == Of::Paper)].into());
    }
    if of == Of::Paper && text.starts_with(BASIN_START[0]) {
        return Resettable::Value(BASIN_START[1].into());
    }
    for [of_both, of_file, of_paper] in WORDS {
        text = text.replace(of_both, if of == Of::File { of_file } else { of_paper });
    }
    const DEFAULT: &str = "[default: ";
    const OF_FILE: &str = "; with FILE ";
    if let (Some(default), Some(own)) = (text.find(DEFAULT), text.find(OF_FILE)) {
        match of {
            Of::File => text.replace_range(default + DEFAULT.len()..own + OF_FILE.len(), ""),
            Of::Paper => {
                let end = text[own..].find(']').map_or(text.len(), |end| own + end);
                text.replace_range(own..end, "");
            }
        }
    }
    if of == Of::Paper {
        text = text.replace("`vibro ", "`vibro paper ");
        for shared in ["paper", "merge"] {
            text = text.replace(&format!("`vibro paper {shared}"), &format!("`vibro {shared}"));
        }
    }
    Resettable::Value(text.trim_end().to_owned().into())
}
