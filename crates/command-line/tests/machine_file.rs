//! Runs the real `vibro` with a machine's file and without: what help says, which options are
//! refused, and the alias of older versions.

#[path = "common/mod.rs"]
mod command;

use command::{drawn, folder, refused};
use std::path::Path;

fn machine(name: &str) -> String {
    format!("{}/../../examples/assembly/{name}", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn help_names_what_a_command_takes_with_a_file_and_without() {
    let out = folder("assembly-help");
    let help = |words: &[&str]| drawn(&out, &[words, &["--help"]].concat());
    for (command, with, without) in [
        ("run", ["--until", "--knots"], ["--config", "--duration"]),
        ("sweep", ["--period ", "--section"], ["--config", "--design"]),
        ("bifurcation", ["--at-section", "--pair"], ["--config", "--load"]),
        ("lyapunov", ["--section", "--anew"], ["--threshold", "--at <"]),
    ] {
        let text = help(&[command]);
        let (of_both, rest) = text.split_once("Options with FILE:").expect("a heading");
        let (of_file, of_paper) = rest.split_once("Options without FILE:").expect("a heading");
        let of_paper =
            of_paper.split("\n\nEXAMPLES").next().and_then(|text| text.split("\n\nNUMBERS").next());
        let of_paper = of_paper.expect("options");
        assert!(
            of_both.contains("[FILE]") && text.contains("NUMBERS") && text.contains("LIMITS of the paper's")
        );
        for common in ["--set", "--out"] {
            assert!(of_both.contains(common), "{command} {common}: {text}");
        }
        // One motion of a file needs no threads, and no run leaves unfinished parts.
        let is_run = command == "run";
        assert!(
            of_both.contains("--threads") != is_run && of_paper.contains("--threads") == is_run,
            "{text}"
        );
        assert!(text.contains("--discard-unfinished") != is_run, "{text}");
        for (own, others) in [(with, [of_both, of_paper]), (without, [of_both, of_file])] {
            for option in own {
                assert!(
                    text.contains(option) && !others.iter().any(|o| o.contains(option)),
                    "{option}: {text}"
                );
            }
        }
        // `--periods` of a sweep and of exponents, and shares, are of both machines.
        if command != "run" {
            assert!(of_both.contains("--shard") && !of_paper.contains("--shard"), "{text}");
        }
        if ["sweep", "lyapunov"].contains(&command) {
            assert!(of_both.contains("--periods") && !of_paper.contains("--periods"), "{text}");
        }
    }
    for command in ["check", "draw"] {
        let text = help(&[command]);
        assert!(!text.contains("--config") && !text.contains("LIMITS") && text.contains("NUMBERS"), "{text}");
    }
    assert!(!help(&["check"]).contains("--out") && help(&["draw"]).contains("--out"));
    assert!(!help(&["template"]).contains("--config") && !help(&["merge"]).contains("--set"));
    let text = help(&["steady"]);
    assert!(text.contains("--config") && text.contains("LIMITS of the paper's machine"), "{text}");
    // The alias is not in the main help, and its own help is of machines' files alone.
    for command in ["check", "draw", "run", "sweep", "bifurcation", "lyapunov"] {
        let text = help(&["assembly", command]);
        assert!(text.contains("<FILE>") && text.contains("NUMBERS"), "{text}");
        for word in [
            "with FILE",
            "paper",
            "LIMITS",
            "f10",
            "kappa",
            "box.k",
            "x1",
            "figure",
            "--config",
            "exact orbit",
        ] {
            assert!(!text.contains(word), "{command} {word}: {text}");
        }
    }
    assert!(help(&["assembly", "run"]).contains("[default: 1000]"));
    assert!(help(&["assembly", "sweep"]).contains("[default: 300000]"));
    assert!(!help(&[]).lines().any(|line| line.starts_with("  assembly")));
}

#[test]
fn an_option_of_the_other_machine_is_refused_by_name_with_what_is_allowed() {
    let cradle = machine("cradle.toml");
    for (line, words) in [
        ("check FILE --config x.toml", "--config: `vibro check` has no use for it"),
        ("check FILE --threads 2", "of the options of all commands it takes --set\n"),
        ("--out here assembly check FILE", "--out: `vibro check` has no use for it"),
        ("draw FILE --replace", "of the options of all commands it takes --set, --out\n"),
        ("run FILE --until 2s --threads 2", "--threads: is an option of the paper's machine, and "),
        ("template --set kappa=0.6", "of the options of all commands it takes none\n"),
        ("merge here --set kappa=0.6", "--set: `vibro merge` has no use for it"),
        ("steady --discard-unfinished", "--discard-unfinished: `vibro steady` has no use for it"),
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
        ("bifurcation --vary f10=1:2 --vary kappa=0.5:0.6", "`vibro isoperiodic`"),
        ("lyapunov FILE --periods 7", "--periods 7: allowed are 8 to 1000000"),
        ("run --samples 10001", "--samples 10001: allowed are 1 to 10000"),
        ("run FILE", "needs the end of the motion, --until TIME, or --times FILE"),
        ("assembly run", "required arguments were not provided"),
        ("basin FILE", "0 ranges of --start: allowed are two"),
        ("isoperiodic FILE", "unexpected argument"),
    ] {
        let line = line.replace("FILE", &cradle);
        let (code, error) = refused(&line.split(' ').collect::<Vec<_>>());
        assert!(code == 2 && error.contains(words), "{line}: {error}");
    }
}

#[test]
fn second_method_the_alias_of_older_versions_writes_the_same_files() {
    let damper = machine("damper_with_buffer.toml");
    let line = ["run", &damper, "--until", "0.2s", "--samples", "20"];
    let (new, old) = (folder("assembly-new-words"), folder("assembly-alias"));
    drawn(&new, &line);
    drawn(&old, &[&["assembly"][..], &line].concat());
    let names = |out: &Path| {
        let mut all: Vec<_> = std::fs::read_dir(out).unwrap().map(|f| f.unwrap().file_name()).collect();
        all.sort();
        all
    };
    assert!(names(&new) == names(&old) && names(&new).len() > 5);
    for name in names(&new).iter().filter(|name| !name.to_string_lossy().ends_with(".manifest.toml")) {
        assert!(std::fs::read(new.join(name)).unwrap() == std::fs::read(old.join(name)).unwrap(), "{name:?}");
    }
    // Both write one result, so that neither folder refuses the other's command.
    drawn(&new, &[&["assembly"][..], &line].concat());
    drawn(&old, &line);
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
