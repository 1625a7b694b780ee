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
const WORDS: [[&str; 3]; 26] = [
    [
        ", from the settled motion or from the orbit of a given word (--word)",
        ", from the settled motion",
        ", from the settled motion or from the orbit of a given word (--word)",
    ],
    [". Without FILE, the paper's machine", "", ""],
    [
        "Parameter and its range, with FILE e.g. stop.steel.gap=1mm:8mm",
        "Parameter and its range, e.g. stop.steel.gap=1mm:8mm",
        "Parameter and its range",
    ],
    [" [default without FILE: f10=0.5:5]", "", " [default: f10=0.5:5]"],
    ["f10=0.5:5 or, with FILE, stop.steel.gap=1mm:8mm:200", "stop.steel.gap=1mm:8mm:200", "f10=0.5:5"],
    [
        "Rows of the table: per drive period, at most 10000; with FILE in total, evenly spaced from the start to --until",
        "Number of rows of states.csv after the row of the start, evenly spaced up to --until",
        "Rows of the table: per drive period, at most 10000",
    ],
    ["; with FILE fewer if the motion settles earlier", ", fewer if the motion settles earlier", ""],
    [
        ". For a FILE: 8 to 1000000; 32 further periods come first, in which the perturbation aligns \
         with the direction of fastest growth",
        ": 8 to 1000000; 32 further periods come first, in which the perturbation aligns with the \
         direction of fastest growth",
        "",
    ],
    [
        "Coordinate whose local maxima are drawn: x1, x2, x3 or w; with FILE any quantity, e.g. box.s, box.a or steel.f",
        "Quantity whose local maxima are drawn, e.g. box.s, box.a or steel.f",
        "Coordinate whose local maxima are drawn: x1, x2, x3 or w",
    ],
    [
        ". With FILE also the time (time=0.2s), or a start file such as end.toml of a run, \
         followed by values that replace its values (end.toml,block.v=0); all other values are \
         those of the machine file. Without FILE also x1 x2 x3 in L, v1 v2 v3 in L omega10; all \
         other values are zero; \"orbit\" starts on the exact orbit if it is stable",
        ", the time (time=0.2s), or a start file such as end.toml of a run, followed by values \
         that replace its values (end.toml,block.v=0); all other values are those of the machine \
         file",
        ", or x1 x2 x3 in L, v1 v2 v3 in L omega10; all other values are zero; \"orbit\" starts on \
         the exact orbit if it is stable",
    ],
    [" (figure 14)", "", " (figure 14)"],
    [
        " (figure 14, table 2); for a FILE without --vary, compute the largest exponent of the \
         machine as given",
        "; without --vary, compute the largest exponent of the machine as given",
        " (figure 14, table 2)",
    ],
    [
        "The diagram shows all exponents of the paper's machine, or the largest exponent for a \
         FILE. For a FILE one variation is carried exactly through flights and events (saltation \
         matrices); --spectrum computes all exponents of the machine as given.",
        "The diagram shows the largest exponent. One variation is carried exactly through flights \
         and events (saltation matrices); --spectrum computes all exponents of the machine as given.",
        "The diagram shows all exponents.",
    ],
    [
        "The motion of a FILE is sampled once per common period of its drives; --period and \
         --section change this.",
        "The motion is sampled once per common period of the drives; --period and --section change this.",
        "",
    ],
    [
        ": of a FILE over any parameter; of the paper's machine by theory (figures 10, 11)",
        ", over any parameter",
        ", by theory (figures 10, 11)",
    ],
    [
        "For a FILE, motions are simulated until they settle, while the parameter rises and falls. \
         Each orbit on which a motion settles is followed over the whole range, stable or not.",
        "Motions are simulated until they settle, while the parameter rises and falls. Each orbit \
         on which a motion settles is followed over the whole range, stable or not.",
        "",
    ],
    [
        "For a FILE, attractors are distinguished by class, period and states at the section, and \
         named by the events of their orbits. All motions of one class without a period count as \
         one attractor.",
        "Attractors are distinguished by class, period and states at the section, and named by the \
         events of their orbits. All motions of one class without a period count as one attractor.",
        "",
    ],
    [
        ": with FILE any parameter, e.g. load.shaker.frequency=8Hz:12Hz; without FILE sigma1 \
         (frequency response), f10 (force response) or another parameter",
        ", e.g. load.shaker.frequency=8Hz:12Hz",
        ": sigma1 (frequency response), f10 (force response) or another parameter",
    ],
    [
        "Output to draw. With FILE an output of `vibro sweep`, e.g. amplitude.box.s or \
         maximum.buffer.f, or a quantity, whose largest value is drawn; without FILE the amplitude \
         of x1 (the box), x2 (the block), x3, w = x2 - x1 [default: with FILE the amplitude of the \
         first free body; without FILE the paper's C and A3]",
        "Output to draw: an output of `vibro sweep`, e.g. amplitude.box.s or maximum.buffer.f, or \
         a quantity, whose largest value is drawn [default: the amplitude of the first free body]",
        "Output to draw: the amplitude of x1 (the box), x2 (the block), x3, w = x2 - x1 [default: \
         the paper's C and A3]",
    ],
    [
        ". With FILE kinds and elements, \"impact steel, press buffer\"; kinds that the word does \
         not mention are left out, except impact, chatter and press. Without FILE impacts \
         as U (upper stop) and L (lower stop); a word that ends in \"-\" is half of a symmetric \
         orbit: U- is the motion with two symmetric impacts a period",
        ": kinds and elements, \"impact steel, press buffer\"; kinds that the word does not mention are left out, except \
         impact, chatter and press",
        ": impacts as U (upper stop) and L (lower stop); a word that ends in \"-\" is half of a symmetric orbit: U- is the \
         motion with two symmetric impacts a period",
    ],
    [
        ": with FILE in common periods of the drive, 2T, or a time, 0.1s; without FILE the number of drive periods, with \
         --word [default without FILE: 1]",
        ": 2T for two common periods of the drive, or a time such as 0.1s",
        ": the number of drive periods, with --word [default: 1]",
    ],
    [", with FILE also ST, CC, SA", ", ST, CC, SA", ""],
    ["With FILE two ranges", "Two ranges", ""],
    [
        " Without FILE initial values that are not on an axis, e.g. block.s=5mm,v1=1; zero unless given",
        "",
        "",
    ],
    [
        " For a FILE also ST one more sticking phase or slip, CC another order of two events, SA a limit of a block's output. \
         `vibro locus` follows all kinds but EP and MX over two parameters.",
        " ST one more sticking phase or slip, CC another order of two events, SA a limit of a block's output. `vibro \
         locus` follows all kinds but EP and MX over two parameters.",
        " `vibro locus` follows the first six over two parameters.",
    ],
    ["(--over), and from several starts", "(--over)", "(--over), and from several starts"],
];

/// Help of `--set` for a machine's file, and for the paper's machine.
const SET: [&str; 2] = [
    "Set one parameter, e.g. stop.steel.gap=5mm. May be repeated",
    "Set one parameter, e.g. kappa=0.6, box.k=48kN/m. May be repeated",
];

/// Help of `basin --start` for the paper's machine; it shares nothing with the help for a file.
const BASIN_START: [&str; 2] = [
    "With FILE two ranges of initial values",
    "Initial values that are not on an axis, e.g. block.s=5mm,v1=1; zero unless given",
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
