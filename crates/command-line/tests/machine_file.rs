//! Runs the real `vibro` with a machine's file and for the paper's machine: what help says, which
//! options are refused, and spellings of older versions.

#[path = "common/mod.rs"]
mod command;

use command::{OF_BOTH, OF_PAPER, drawn, folder, refused};
use std::path::Path;
use std::process::Command;

fn machine(name: &str) -> String {
    format!("{}/../../examples/assembly/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// Words of help texts on the paper's machine, which the help of a command with a FILE has not.
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
        // One motion of a file needs no threads, and no run leaves unfinished parts.
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

/// What `vibro` prints, and its notes.
fn told(out: &Path, words: &[&str]) -> (bool, String, String) {
    let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
    let done = vibro.args(words).current_dir(out).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (done.status.success(), text(done.stdout), text(done.stderr))
}

#[test]
fn second_method_old_spellings_do_what_the_new_ones_do_and_say_them() {
    let out = folder("machine-file-spellings");
    std::fs::create_dir_all(&out).unwrap();
    for command in OF_PAPER.into_iter().chain(OF_BOTH) {
        // Each is refused after the note, but for the template.
        let wrong = if command == "template" { &["--si"][..] } else { &["--set", "speed=1"] };
        let needed: &[&str] = match command {
            "locus" => &["--from", "no.csv", "--vary", "f10=1:2", "--vary", "kappa=0.5:0.6"],
            _ => &[],
        };
        let old = told(&out, &[&[command], needed, wrong].concat());
        let new = told(&out, &[&["paper", command], needed, wrong].concat());
        let note = format!(
            "note: `vibro {command}` is now `vibro paper {command}`; the old spelling works until 0.5\n"
        );
        assert_eq!(old, (new.0, new.1, note + &new.2), "{command}");
        assert!(old.0 == (command == "template"), "{command}");
    }
    let line = ["steady", "--set", "kappa=0.7", "--out"];
    assert!(told(&out, &[&line[..], &["old"]].concat()).0);
    assert!(told(&out, &[&["paper"], &line[..], &["new"]].concat()).0);
    let table = |folder: &str| std::fs::read(out.join(folder).join("steady.csv")).unwrap();
    assert!(table("old") == table("new"));
    // Both write one result, so that neither folder refuses the other's command.
    assert!(told(&out, &[&line[..], &["new"]].concat()).0);
}

#[test]
fn an_option_of_the_other_machine_is_refused_by_name_with_what_is_allowed() {
    let cradle = machine("cradle.toml");
    for (line, words) in [
        ("check FILE --config x.toml", "--config: `vibro check` has no use for it"),
        ("check FILE --threads 2", "of the options of all commands it takes --set\n"),
        ("--out here check FILE", "--out: `vibro check` has no use for it"),
        ("draw FILE --replace", "of the options of all commands it takes --set, --out\n"),
        ("run FILE --until 2s --threads 2", "--threads: is an option of the paper's machine, and "),
        ("template --set kappa=0.6", "of the options of all commands it takes none\n"),
        ("merge here --set kappa=0.6", "--set: `vibro merge` has no use for it"),
        ("steady --discard-unfinished", "--discard-unfinished: `vibro paper steady` has no use for it"),
        ("run FILE --until 2s --periods 1", "--periods: is an option of the paper's machine, and "),
        ("run FILE --discard 1", "of such options allowed here: --until, --times, --columns, --knots"),
        ("run --start v2=1 --start x1=1", "allowed is one start, with commas between its numbers"),
        (
            "bifurcation FILE --load block=1N --vary body.a.mass=1:2",
            "--load: is an option of the paper's machine",
        ),
        ("sweep FILE --design rows.csv", "--design: is an option of the paper's machine"),
        ("run --until 2s", "--until: is an option of a machine's file: `vibro run FILE --until …`"),
        (
            "run --knots",
            "of such options allowed here: --periods, --duration, --discard, --load, --interpolation, --config",
        ),
        ("lyapunov --section upper", "`vibro lyapunov FILE --section …`"),
        ("bifurcation FILE", "no --vary: allowed is one parameter"),
        ("bifurcation --vary f10=1:2 --vary kappa=0.5:0.6", "`vibro paper isoperiodic`"),
        ("lyapunov FILE --periods 7", "--periods 7: allowed are 8 to 1000000"),
        ("run --samples 10001", "--samples 10001: allowed are 1 to 10000"),
        ("run FILE", "needs the end of the motion, --until TIME, or --times FILE"),
        ("paper run FILE --until 2s", "`vibro paper` takes no machine's file: use `vibro run "),
        ("basin FILE", "0 ranges of --start: allowed are two"),
        ("isoperiodic FILE", "unexpected argument"),
        ("assembly run FILE", "unrecognized subcommand"),
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
    assert!(error.contains("after --config"), "{error}");
    let (code, error) = refused(&["steady", "--config", &machine("cradle.toml")]);
    assert!(code == 2 && error.contains("`vibro run FILE`"), "{error}");
}
