//! Runs the real `vibro` with a machine's file and for the paper's machine: help texts, refused
//! options, and spellings of older versions.

#[path = "common/mod.rs"]
mod command;

use command::{DAMPER, OF_BOTH, OF_PAPER, drawn, folder, refused};
use std::path::Path;
use std::process::Command;
use vibro_studies::{Machine, Measure, QuantityName};

fn machine(name: &str) -> String {
    format!("{}/../../examples/assembly/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// Words of help on the paper's machine, which help of commands with a FILE must not contain.
const PAPERS_WORDS: [&str; 11] = [
    "with FILE",
    "With FILE",
    "paper",
    "LIMITS",
    "f10",
    "kappa",
    "box.k",
    "x1",
    "figure",
    "--config",
    "exact orbit",
];

#[test]
fn help_of_a_command_is_of_its_own_machine_alone() {
    let out = folder("assembly-help");
    let help = |words: &[&str]| drawn(&out, &[words, &["--help"]].concat());
    for (command, with, without) in [
        ("run", ["--until", "--knots"], ["--config", "--duration"]),
        ("sweep", ["--period ", "--section"], ["--config", "--design"]),
        ("bifurcation", ["--at-section", "--pair"], ["--config", "--load"]),
        ("lyapunov", ["--section", "--anew"], ["--threshold", "--at <"]),
    ] {
        let (of_file, of_paper) = (help(&[command]), help(&["paper", command]));
        for (own, other, options) in [(&of_file, &of_paper, with), (&of_paper, &of_file, without)] {
            for option in options {
                assert!(own.contains(option) && !other.contains(option), "{command} {option}: {own}{other}");
            }
            assert!(own.contains("--set") && own.contains("--out"), "{command}: {own}");
        }
        assert!(of_file.contains(&format!("Usage: vibro {command} [OPTIONS] <FILE>\n")), "{of_file}");
        assert!(of_file.contains("NUMBERS") && of_paper.contains("LIMITS of the paper's"));
        // A single motion of a file needs no threads, and no run leaves unfinished parts.
        let is_run = command == "run";
        assert!(of_paper.contains("--threads") && of_file.contains("--threads") != is_run, "{of_file}");
        assert!(of_file.contains("--discard-unfinished") != is_run, "{of_file}");
        assert!(of_file.contains("--shard") != is_run && of_paper.contains("--shard") != is_run);
    }
    for command in OF_BOTH {
        let (of_file, of_paper) = (help(&[command]), help(&["paper", command]));
        assert!(of_file.contains("<FILE>\n") && of_file.contains("NUMBERS"), "{of_file}");
        for word in PAPERS_WORDS {
            assert!(!of_file.contains(word), "{command} {word}: {of_file}");
        }
        for word in ["with FILE", "With FILE", "ithout FILE", "[FILE]", "] <FILE>"] {
            assert!(!of_paper.contains(word), "{command} {word}: {of_paper}");
        }
        assert!(!of_file.contains("[FILE]") && of_file.contains("Arguments:\n  <FILE>\n"), "{of_file}");
        for name in OF_BOTH.into_iter().chain(OF_PAPER) {
            assert!(!of_paper.contains(&format!("`vibro {name}")), "{command} {name}: {of_paper}");
        }
        assert!(!of_file.contains("--range <") && !of_paper.contains("--range <"), "{command}");
    }
    for command in OF_PAPER {
        let old = told(Path::new("."), &[command, "--help"]).1;
        assert!(old.contains(&format!("Usage: vibro paper {command}")) && old.contains("until 0.5"), "{old}");
    }
    for command in ["check", "draw"] {
        let text = help(&[command]);
        assert!(!text.contains("--config") && !text.contains("LIMITS") && text.contains("NUMBERS"), "{text}");
    }
    assert!(!help(&["check"]).contains("--out") && help(&["draw"]).contains("--out"));
    assert!(!help(&["paper", "template"]).contains("--config") && !help(&["merge"]).contains("--set"));
    let text = help(&["paper", "steady"]);
    assert!(text.contains("--config") && text.contains("LIMITS of the paper's machine"), "{text}");
    assert!(help(&["run"]).contains("[default: 1000]") && help(&["paper", "run"]).contains("[default: 100]"));
    assert!(help(&["sweep"]).contains("[default: 300000]"));
    assert!(help(&["paper", "sweep"]).contains("[default: 5000000]"));
}

#[test]
fn help_lists_commands_with_a_file_and_an_example_of_each_before_the_papers_machine() {
    let out = folder("machine-file-help");
    let (text, of_paper) = (drawn(&out, &["--help"]), drawn(&out, &["paper", "--help"]));
    let commands = text.split("Commands:").nth(1).and_then(|rest| rest.split("\n\n").next()).expect("a list");
    let listed: Vec<&str> = commands.lines().filter_map(|line| line.split_whitespace().next()).collect();
    let with_file = ["check", "draw", "fmu", "fit", "section"].into_iter().chain(OF_BOTH);
    for command in with_file {
        assert!(listed.contains(&command), "{command}: {commands}");
        assert!(
            text.contains(&format!("\n  vibro {command} machine.toml")),
            "no example of {command}: {text}"
        );
    }
    assert!(OF_PAPER.iter().all(|command| !listed.contains(command)), "{commands}");
    let of_group = |line: &&str| line.starts_with("  vibro paper ");
    assert!((1..=3).contains(&text.lines().filter(of_group).count()), "{text}");
    for command in OF_PAPER.into_iter().chain(OF_BOTH) {
        assert!(of_paper.lines().any(|line| line.trim_start().starts_with(command)), "{command}: {of_paper}");
    }
}

/// The output of `vibro`, and its notes.
fn told(out: &Path, words: &[&str]) -> (bool, String, String) {
    let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
    let done = vibro.args(words).current_dir(out).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (done.status.success(), text(done.stdout), text(done.stderr))
}

/// A refusal of an option names the option, its value once, and a remedy that the command has.
#[test]
fn golden_refusals_of_options_name_what_the_command_takes() {
    let out = folder("machine-file-options");
    std::fs::create_dir_all(&out).unwrap();
    let write = |name: &str, text: &str| std::fs::write(out.join(name), text).unwrap();
    let body = "[body.b]\nmass = 1.0\n";
    let spring = "[spring.k]\nbetween = [\"ground\", \"b\"]\nstiffness = 1.0\n";
    write("free.toml", &format!("name = \"Free\"\n{body}{spring}"));
    write(
        "falls.toml",
        &format!(
            "name = \"Falls\"\ngravity = 9.81\nstart = \"rest\"\n{body}gravity = 1.0\n[load.f]\non = \"b\"\nconstant = 0.0\n"
        ),
    );
    write("empty.toml", "# nothing\n");
    write("empty.csv", "");
    let floor = "[stop.floor]\nbetween = [\"ground\", \"b\"]\ngap = 1.0\nrestitution = 0.5\n";
    write("rests.toml", &format!("name = \"Rests\"\ngravity = 9.81\n{body}gravity = 1.0\n{floor}"));
    let none = "the machine has no harmonics, stops or friction";
    for (line, said) in [
        ("check empty.toml", "empty.toml: is empty; expected a machine: `name`, bodies such as [body.box]"),
        (
            "orbits free.toml --vary body.b.mass=0.5:2",
            &format!("{none}; orbits require harmonics with a common period, a stop or a friction"),
        ),
        (
            "sweep free.toml --vary body.b.mass=0.5:2",
            &format!("{none}; give a period (--period), or add a stop without effect as section"),
        ),
        ("run DAMPER --until 1s --step 1ms", "motions need no step size, solver or tolerance; '--samples N'"),
        ("simulate DAMPER", "vibro has no command `simulate`: expected `vibro run "),
        (
            "orbits rests.toml --vary stop.floor.gap=1m:2m",
            "the motion has probably come to rest: drive the machine, begin elsewhere (--start)\n",
        ),
        (
            "check falls.toml",
            "falls.toml:3: start = \"rest\": no equilibrium; body.b keeps the acceleration 9.81 m/s2",
        ),
        (
            "run DAMPER --until 1s --threads 2",
            "--threads: is not an option of `vibro run` for a machine file, but of `vibro sweep`",
        ),
        (
            "design DAMPER --minimize amplitude.box.s --vary stop.steel.gap",
            "`stop.steel.gap`: expected NAME=LOW:HIGH without a count, e.g. stop.steel.gap=1mm:8mm\n",
        ),
        (
            "response DAMPER --vary load.shaker.frequency=11Hz",
            "`load.shaker.frequency=11Hz`: expected NAME=FROM:TO, e.g. stop.steel.gap=1mm:8mm\n",
        ),
        (
            "design DAMPER --minimize amplitude.bx.s --vary stop.steel.gap=1mm:8mm",
            "--minimize: the machine has no `bx.s`; did you mean `box.s`?",
        ),
        (
            "sweep DAMPER --output amplitude.bx.s",
            "--output: the machine has no `bx.s`; did you mean `box.s`?",
        ),
        ("check DAMPER --until 1s", "tip: '--until' is an option of 'vibro reduce', 'vibro run'\n"),
        (
            "sweep DAMPER --vary stop.steel.gap=1mm:8mm:4 --shard 3/2",
            "invalid value '3/2' for '--shard <I/N>': expected I/N with I from 1 to N, e.g. 2/4\n",
        ),
        (
            "check DAMPER --set stop.steel.gap",
            "--set stop.steel.gap: expected NAME=VALUE, e.g. stop.steel.gap=5mm",
        ),
        ("check DAMPER --set stop.steel.gap=5N", "--set: stop.steel.gap = \"5N\": cannot be in `N`"),
        (
            "check DAMPER --set speed=5",
            "expected one of gravity, body.box.mass, body.box.gravity, body.block.mass",
        ),
        ("run free.toml --until 1s --out /dev/null/x", "/dev/null/x: is a file; expected a folder"),
        ("new damper_with_buffer none/x.toml", "none/x.toml: cannot be written: there is no folder none\n"),
        ("new nothing_like_it", "expected one of damper_with_buffer, gear_backlash"),
        (
            "fit DAMPER --data empty.csv --free stop.steel.gap",
            "empty.csv: is empty; expected a first line that names the columns, such as time,box.s",
        ),
    ] {
        let line = line.replace("DAMPER", DAMPER);
        let (done, _, error) = told(&out, &line.split(' ').collect::<Vec<_>>());
        assert!(!done && error.contains(said), "{line}: {error}");
    }
}

#[test]
fn second_method_old_spellings_do_what_the_new_ones_do_and_say_them() {
    let out = folder("machine-file-spellings");
    std::fs::create_dir_all(&out).unwrap();
    for command in OF_PAPER.into_iter().chain(OF_BOTH) {
        // Each command is refused after the note, except the template.
        let wrong = if command == "template" { &["--si"][..] } else { &["--set", "speed=1"] };
        let needed: &[&str] = match command {
            "locus" => &["--from", "no.csv", "--vary", "f10=1:2", "--vary", "kappa=0.5:0.6"],
            _ => &[],
        };
        let old = told(&out, &[&[command], needed, wrong].concat());
        let new = told(&out, &[&["paper", command], needed, wrong].concat());
        let without = if OF_BOTH.contains(&command) { " without a machine's FILE" } else { "" };
        let note = format!(
            "note: `vibro {command}`{without} is now `vibro paper {command}`; the old spelling works until 0.5\n"
        );
        assert_eq!(old, (new.0, new.1, note + &new.2), "{command}");
        assert!(old.0 == (command == "template"), "{command}");
    }
    let line = ["steady", "--set", "kappa=0.7", "--out"];
    assert!(told(&out, &[&line[..], &["old"]].concat()).0);
    assert!(told(&out, &[&["paper"], &line[..], &["new"]].concat()).0);
    let table = |folder: &str| std::fs::read(out.join(folder).join("steady.csv")).unwrap();
    assert!(table("old") == table("new"));
    // Both write the same result, so that neither folder refuses the other's command.
    assert!(told(&out, &[&line[..], &["new"]].concat()).0);
}

#[test]
fn an_option_of_the_other_machine_is_refused_by_name_with_what_is_allowed() {
    let cradle = machine("cradle.toml");
    for (line, words) in [
        ("check FILE --config x.toml", "--config: `vibro check` does not use this option"),
        ("check FILE --threads 2", "of the common options it accepts only --set\n"),
        ("--out here check FILE", "--out: `vibro check` does not use this option"),
        ("draw FILE --replace", "of the common options it accepts only --set, --out, --width\n"),
        (
            "run FILE --until 2s --threads 2",
            "--threads: is not an option of `vibro run` for a machine file, but of `vibro sweep`",
        ),
        ("template --set kappa=0.6", "of the common options it accepts none\n"),
        ("merge here --set kappa=0.6", "--set: `vibro merge` does not use this option"),
        (
            "steady --discard-unfinished",
            "--discard-unfinished: `vibro paper steady` does not use this option",
        ),
        (
            "run FILE --until 2s --periods 1",
            "--periods: is not an option of `vibro run` for a machine file, but of `vibro sweep`",
        ),
        ("run FILE --discard 1", "`vibro run --help` lists the options"),
        ("run --start v2=1 --start x1=1", "expected one start, with commas between its values"),
        (
            "bifurcation FILE --load block=1N --vary body.a.mass=1:2",
            "--load: is an option of the paper's machine",
        ),
        ("sweep FILE --design rows.csv", "--design: is an option of the paper's machine"),
        ("run --until 2s", "--until: is an option of a machine's file: `vibro run FILE --until …`"),
        ("run --knots", "`vibro paper run --help` lists the options"),
        ("lyapunov --section upper", "`vibro lyapunov FILE --section …`"),
        ("bifurcation FILE", "--vary: expected one parameter"),
        ("bifurcation --vary f10=1:2 --vary kappa=0.5:0.6", "`vibro paper isoperiodic`"),
        ("lyapunov FILE --periods 7", "--periods 7: expected 8 to 1000000"),
        ("run --samples 10001", "--samples 10001: expected 1 to 10000"),
        ("run FILE", "requires the end of the motion (--until TIME) or a file of times (--times FILE)"),
        ("paper run FILE --until 2s", "`vibro paper` does not take a machine file: use `vibro run "),
        ("basin FILE", "--start: expected two ranges"),
        ("isoperiodic FILE", "unexpected argument"),
        ("assembly run FILE", "`vibro assembly` is not a group of commands: expected `vibro run "),
        ("paper check FILE", "`vibro paper` has no command `check`: expected `vibro check "),
        ("paper merge one two", "expected `vibro merge one two"),
        ("check FILE --set =5", "--set =5: expected NAME=VALUE"),
        ("steady --set =5", "`=5`: expected NAME=VALUE"),
        ("sweep FILE --vary =1:2", "`=1:2`: expected NAME=FROM:TO"),
        ("sweep FILE --vary gravity=1:1:3", "`gravity=1:1:3`: expected NAME=FROM:TO with FROM < TO"),
        ("sweep FILE --vary gravity=1:2:0", "`gravity=1:2:0`: expected a count of 2 or more values"),
        ("basin FILE --start ball1.s=1:1 --start ball1.v=0:1", "`ball1.s=1:1`: expected NAME=FROM:TO"),
        ("sweep FILE --vary gravity=1:2.0:3 --sobol 4", "`gravity=1:2.0:3`: expected NAME=FROM:TO"),
        (
            "design FILE --minimize amplitude.ball1.s --vary gravity=1:2.0:3",
            "`gravity=1:2.0:3`: expected NAME=LOW:HIGH without a count",
        ),
        ("orbit FILE --period 2X", "--period 2X: expected 1T to 32T, or a finite time > 0"),
        ("orbit --word U --period 2X", "--period 2X: expected a whole number from 1 to 32"),
    ] {
        let line = line.replace("FILE", &cradle);
        let (code, error) = refused(&line.split(' ').collect::<Vec<_>>());
        assert!(code == 2 && error.contains(words), "{line}: {error}");
    }
}

#[test]
fn a_file_of_the_other_machine_is_refused_with_the_way_to_name_it() {
    let parameters = Path::new(env!("CARGO_TARGET_TMPDIR")).join("machine-file-parameters.toml");
    std::fs::write(&parameters, "[si]\nbox.m = 2.0\n").unwrap();
    let (code, error) = refused(&["check", &parameters.display().to_string()]);
    assert!(code == 2 && error.contains("is a parameter file of the paper's machine"), "{error}");
    assert!(error.contains("`vibro paper run --config FILE`"), "{error}");
    let (code, error) = refused(&["steady", "--config", &machine("cradle.toml")]);
    assert!(code == 2 && error.contains("`vibro run FILE`"), "{error}");
}

/// Words of a text that look like names of numbers, elements, quantities or outputs of a machine.
fn dotted(text: &str) -> impl Iterator<Item = &str> {
    let words = text.split(|c: char| !(c.is_alphanumeric() || "._".contains(c)));
    words.map(|word| word.trim_matches('.')).filter(|word| word.contains('.'))
}

#[test]
fn second_method_help_names_what_the_machine_of_its_first_example_has() {
    let (out, machine) =
        (folder("machine-file-names"), Machine::read(Path::new(DAMPER)).unwrap().description);
    let parameters: Vec<String> = machine.parameters().into_iter().map(|p| p.name).collect();
    let is_of_quantity = |word: &str| word.parse::<QuantityName>().is_ok_and(|q| q.find(&machine).is_ok());
    let mut count = 0;
    let commands = ["", "check", "draw", "fmu", "fit", "section", "design"].into_iter().chain(OF_BOTH);
    for command in commands {
        let words = [command, "--help"].into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>();
        let help = drawn(&out, &words);
        // The rest of the help of all commands is about the paper's machine.
        let help = help.split("Examples for the paper's machine").next().unwrap().replace("box.k=", "");
        for word in dotted(&help) {
            let is_known = match word.split('.').collect::<Vec<_>>()[..] {
                ["body", _, "start", ..] => continue,
                ["body" | "spring" | "stop" | "friction" | "load", ..] => {
                    parameters.iter().any(|own| own == word || own.starts_with(&format!("{word}.")))
                }
                ["amplitude" | "maximum" | "impact" | "power", _, ..] => {
                    word.parse::<Measure>().is_ok_and(|measure| measure.check(&machine).is_ok())
                }
                [_, "s" | "v" | "a" | "e" | "f" | "rate"] => is_of_quantity(word),
                _ => continue,
            };
            assert!(is_known, "`vibro {command} --help` names {word}, which is not in {DAMPER}");
            count += 1;
        }
    }
    assert!(count > 60, "{count}");
}

/// The examples of help texts, line by line, with the machine of the first example. The results
/// folder contains damaged manifests, so that a study is refused after all of its arguments are
/// read, before it begins.
#[test]
fn examples_of_help_are_read_to_the_end() {
    let home = folder("machine-file-examples");
    let broken = home.join("broken");
    std::fs::create_dir_all(&broken).unwrap();
    std::fs::copy(DAMPER, home.join("machine.toml")).unwrap();
    let text = [&[][..], &["sweep"], &["design"]].map(|words| told(&home, &[words, &["--help"]].concat()).1);
    let text = text.concat().replace("\\\n", " ");
    let lines = text.lines().filter_map(|line| line.trim().strip_prefix("vibro "));
    let mut count = 0;
    for line in lines.filter(|line| line.contains(" machine.toml ")) {
        let line =
            line.split("    (").next().unwrap().replace("--out my-machine", "").replace("--out one", "");
        let words: Vec<&str> = line.split_whitespace().map(|word| word.trim_matches('\'')).collect();
        // These need a record, a table of special points, or no results folder; a quoted limit
        // with a space is two words here.
        if ["new", "fit", "locus"].contains(&words[0]) || line.contains("--list") || line.contains('\'') {
            continue;
        }
        std::fs::write(broken.join(format!("{}.manifest.toml", words[0])), "half a manif").unwrap();
        let (done, _, error) = told(&home, &[&words[..], &["--out", "broken"]].concat());
        assert!(!done && error.contains("or is damaged"), "vibro {line}: {error}");
        count += 1;
    }
    assert!(count >= 12, "{count}");
    // An orbit search knows only at its end whether there is an orbit.
    let orbit = text.lines().find(|line| line.starts_with("  vibro orbit ")).expect("an example");
    let words: Vec<&str> = orbit.split_whitespace().skip(1).collect();
    let (done, _, error) = told(&home, &words);
    assert!(done, "{orbit}: {error}");
}

#[test]
fn a_command_without_its_file_says_that_file_is_missing_and_where_it_stands() {
    let here = folder("machine-file-missing");
    std::fs::create_dir_all(&here).unwrap();
    for (line, given) in [
        ("run --until 2s", "--until"),
        ("run --set body.box.mass=2", "--set body.box.mass=2"),
        ("run --start end.toml", "--start end.toml"),
        ("bifurcation --vary stop.steel.gap=1mm:8mm", "--vary stop.steel.gap=1mm:8mm"),
        ("bifurcation --of box.s", "--of box.s"),
        ("lyapunov --vary stop.steel.gap=1mm:8mm --config x.toml", "--vary stop.steel.gap=1mm:8mm"),
        ("response --vary load.shaker.frequency=8Hz:9Hz", "--vary load.shaker.frequency=8Hz:9Hz"),
        ("basin --start block.s=-4mm:4mm --start block.v=-1:1", "--start block.s=-4mm:4mm"),
        ("orbit --period 2T", "--period 2T"),
        ("orbits --vary stop.steel.gap=1mm:8mm", "--vary stop.steel.gap=1mm:8mm"),
        ("sweep --output amplitude.box.s", "--output amplitude.box.s"),
        ("sweep --vary body.block.mass=1:2", "--vary body.block.mass=1:2"),
        ("paper sweep --vary body.block.mass=1:2", "--vary body.block.mass=1:2"),
    ] {
        let words: Vec<&str> = line.split(' ').collect();
        let command = if words[0] == "paper" { words[1] } else { words[0] };
        let (done, said, error) = told(&here, &words);
        let expected =
            format!("error: {given}: requires a machine's FILE: use `vibro {command} FILE {given} …`\n");
        assert!(!done && said.is_empty() && error == expected, "{line}: {error}");
    }
}

#[test]
fn results_of_a_machines_file_have_the_names_of_their_commands() {
    let here = folder("machine-file-results");
    std::fs::create_dir_all(here.join("old")).unwrap();
    let run = ["run", DAMPER, "--until", "20ms", "--samples", "2"];
    for set in ["stop.steel.gap=4mm", "stop.steel.gap=5mm"] {
        let (done, _, error) = told(&here, &[&run[..], &["--set", set]].concat());
        assert!(done, "{error}");
    }
    let names = std::fs::read_dir(here.join("vibro-out")).unwrap();
    let names: Vec<String> = names.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    assert!(names.iter().any(|name| name == "run.manifest.toml"), "{names:?}");
    assert!(names.iter().filter(|name| name.starts_with("run-")).count() == 1, "{names:?}");
    // The manifest of a motion had another name in version 0.3: it must not be overwritten.
    std::fs::write(here.join("old/states.csv"), "time\n").unwrap();
    let (done, _, error) = told(&here, &[&run[..], &["--out", "old"]].concat());
    assert!(!done && error.contains("holds states.csv without run.manifest.toml"), "{error}");
}
