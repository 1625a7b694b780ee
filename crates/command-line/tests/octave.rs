//! The functions of matlab/ in GNU Octave, compared with the command line: digits of all tables,
//! words of errors, points of drawn lines, blocks of docs/matlab.md. Asked for by name, since
//! Octave is a package of its own.

#[path = "common/mod.rs"]
mod command;

use command::{DAMPER, folder};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A machine with two short branches of orbits.
const RATTLE: &str = r#"
name = "Rattle"
body.part = { mass = "200 g", start = { v = "0.2 m/s" } }
body.joint = { motion = { amplitude = "1 mm", frequency = "25 Hz" } }
stop.right = { between = ["joint", "part"], gap = "1.5 mm", restitution = 0.6 }
stop.left = { between = ["part", "joint"], gap = "1.5 mm", restitution = 0.6 }
"#;

/// A slide on a spring with friction, without its record.
const DRIVE: &str = r#"
name = "Drive"
body.slide = { mass = "1 kg", start = { s = "0.85 mm" } }
spring.mount = { between = ["ground", "slide"], stiffness = "8 kN/m" }
friction.guide = { between = ["ground", "slide"], force = "1.2 N" }
"#;

/// A call: its command, the arguments of the command line, and the same arguments in Octave.
const CALLS: [(&str, &str, &str); 12] = [
    (
        "run",
        "damper.toml --until=0.5s --samples=50 --derivatives=stop.steel.gap --set=stop.steel.gap=3mm \
         --set=body.box.mass=13kg --knots",
        "'damper.toml', 'until', '0.5s', 'samples', 50, 'derivatives', 'stop.steel.gap', \
         'set', {'stop.steel.gap=3mm', 'body.box.mass=13kg'}, 'knots', true",
    ),
    (
        "sweep",
        "rattle.toml --vary=stop.right.gap=1mm:3mm:3",
        "'rattle.toml', 'vary', 'stop.right.gap=1mm:3mm:3'",
    ),
    (
        "design",
        "rattle.toml --maximize=impact.speed.right --vary=stop.right.gap=1mm:3mm --evaluations=10",
        "'rattle.toml', 'maximize', 'impact.speed.right', 'vary', 'stop.right.gap=1mm:3mm', 'evaluations', 10",
    ),
    (
        "bifurcation",
        "rattle.toml --vary=stop.right.gap=1mm:3mm:5 --of=part.s",
        "'rattle.toml', 'vary', 'stop.right.gap=1mm:3mm:5', 'of', 'part.s'",
    ),
    ("lyapunov", "rattle.toml --spectrum", "'rattle.toml', 'spectrum', true"),
    ("orbit", "rattle.toml --period=1T", "'rattle.toml', 'period', '1T'"),
    (
        "orbits",
        "rattle.toml --vary=body.joint.motion.amplitude=0.2mm:2mm --of=impact.speed.right --tree --depth=1 --seeds=3",
        "'rattle.toml', 'vary', 'body.joint.motion.amplitude=0.2mm:2mm', 'of', 'impact.speed.right', \
         'tree', true, 'depth', 1, 'seeds', 3",
    ),
    (
        "response",
        "rattle.toml --vary=body.joint.motion.frequency=20Hz:40Hz --of=peak_to_peak.part.s",
        "'rattle.toml', 'vary', 'body.joint.motion.frequency=20Hz:40Hz', 'of', 'peak_to_peak.part.s'",
    ),
    (
        "locus",
        "rattle.toml --from=orbits/special-points.csv:LP --vary=body.joint.motion.amplitude=0.2mm:2mm \
         --vary=body.joint.motion.frequency=15Hz:40Hz",
        "'rattle.toml', 'from', 'orbits/special-points.csv:LP', \
         'vary', {'body.joint.motion.amplitude=0.2mm:2mm', 'body.joint.motion.frequency=15Hz:40Hz'}",
    ),
    (
        "fit",
        "drive.toml --data=record.csv --free=spring.mount.stiffness --free=friction.guide.force",
        "'drive.toml', 'data', 'record.csv', 'free', {'spring.mount.stiffness', 'friction.guide.force'}",
    ),
    (
        "basin",
        "rattle.toml --start=part.s=-1.4mm:1.4mm:4 --start=part.v=-0.5:0.5:3",
        "'rattle.toml', 'start', {'part.s=-1.4mm:1.4mm:4', 'part.v=-0.5:0.5:3'}",
    ),
    ("section", "rattle.toml --section=right --keep=20", "'rattle.toml', 'section', 'right', 'keep', 20"),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace")
}

/// A fresh folder with the machines and the record of the calls.
fn home(name: &str) -> PathBuf {
    let home = folder(&format!("octave-{name}"));
    fs::create_dir_all(&home).expect("target can be written");
    fs::copy(DAMPER, home.join("damper.toml")).expect("target can be written");
    let page = fs::read_to_string(root().join("docs/fit.md")).expect("docs/fit.md");
    let record = page.split("```csv record.csv\n").nth(1).and_then(|rest| rest.split("```").next());
    for (file, text) in [
        ("rattle.toml", RATTLE),
        ("drive.toml", DRIVE),
        ("record.csv", record.expect("the record of docs/fit.md")),
    ] {
        fs::write(home.join(file), text).expect("target can be written");
    }
    home
}

/// Standard output of Octave for this code, in a folder, with the functions of matlab/ on its path.
fn octave_with(program: &str, home: &Path, code: &str) -> String {
    let [functions, own] =
        ["matlab", "crates/command-line/tests/octave"].map(|place| root().join(place).display().to_string());
    let code = format!(
        "addpath('{functions}', '{own}'); warning('off', 'Octave:gnuplot-graphics'); \
         graphics_toolkit('gnuplot'); set(0, 'defaultfigurevisible', 'off');\n{code}"
    );
    let temporary = home.join("temporary");
    fs::create_dir_all(&temporary).expect("target can be written");
    let mut octave = Command::new("octave-cli");
    octave.args(["--quiet", "--norc", "--no-history", "--eval", &code]).current_dir(home);
    octave.env("VIBRO_PROGRAM", program).env("TMPDIR", &temporary);
    let output = octave.output().expect("octave-cli: apt install octave");
    let [said, notes] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).expect("UTF-8"));
    assert!(output.status.success(), "{notes}\n{said}\n{code}");
    let left: Vec<_> = fs::read_dir(&temporary).expect("a folder").map(|e| e.unwrap().path()).collect();
    assert!(left.is_empty(), "temporary files are left: {left:?}");
    said
}

fn octave(home: &Path, code: &str) -> String {
    octave_with(env!("CARGO_BIN_EXE_vibro"), home, code)
}

/// Exit code, standard output and standard error of the command line in a folder.
fn vibro(home: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_vibro")).args(arguments).current_dir(home).output();
    let output = output.expect("vibro runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8").trim().to_owned();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

fn bits(number: f64) -> String {
    format!("{:016x}", number.to_bits())
}

/// Every column of the tables of a folder by "table column". Numbers are given by their bits.
fn columns(folder: &Path) -> BTreeMap<String, Vec<String>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("a folder of results") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|ending| ending != "csv") {
            continue;
        }
        let table = path.file_stem().unwrap().to_str().unwrap().replace('-', "_");
        let mut reader = csv::Reader::from_path(&path).expect("a table");
        let header = reader.headers().expect("a header").clone();
        let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.expect("a row")).collect();
        for (k, name) in header.iter().enumerate() {
            let cells = rows.iter().map(|row| &row[k]);
            let number = |cell: &str| if cell.is_empty() { Some(f64::NAN) } else { cell.parse::<f64>().ok() };
            let numbers: Option<Vec<String>> = cells.clone().map(|cell| number(cell).map(bits)).collect();
            found.insert(
                format!("{table} {name}"),
                numbers.unwrap_or_else(|| cells.map(str::to_owned).collect()),
            );
        }
    }
    found
}

/// Columns that Octave has written with `dump`.
fn dumped(path: &Path) -> BTreeMap<String, Vec<String>> {
    let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let text = fs::read_to_string(path).expect("columns of Octave");
    let mut name = String::new();
    for line in text.lines() {
        match line.strip_prefix('@') {
            Some(next) => {
                name = next.to_owned();
                found.insert(name.clone(), Vec::new());
            }
            None => found.get_mut(&name).expect("a name first").push(line.to_owned()),
        }
    }
    found
}

#[test]
#[ignore = "needs GNU Octave"]
fn second_method_octave_has_every_digit_of_the_command_line() {
    let home = home("digits");
    let mut code = String::new();
    for (name, arguments, _) in CALLS {
        let out = format!("--out={name}");
        let words: Vec<&str> =
            [name].into_iter().chain(arguments.split_whitespace()).chain([&*out]).collect();
        let (status, _, notes) = vibro(&home, &words);
        assert_eq!((status, &*notes), (Some(0), ""), "{name}");
    }
    for (name, _, arguments) in CALLS {
        code += &format!("dump(vibro.{name}({arguments}), '{name}.txt');\n");
    }
    code += "fitted = vibro.fit('drive.toml', 'data', 'record.csv', 'free', \
             {'spring.mount.stiffness', 'friction.guide.force'}); fit = fitted.fit;\n\
             for one = {fit.parameters.spring_mount_stiffness, fit.parameters.friction_guide_force}\n\
             printf('%s\\n', num2hex(one{1}.value), num2hex(one{1}.error)); end\n\
             printf('%s\\n', num2hex(fit.correlation.matrix(1, 2)), num2hex(fit.rms.slide_s), fit.verdict);";
    let said = octave(&home, &code);
    let mut tables = 0;
    for (name, ..) in CALLS {
        let (expected, found) = (columns(&home.join(name)), dumped(&home.join(format!("{name}.txt"))));
        assert!(expected.keys().eq(found.keys()), "{name}: {:?} {:?}", expected.keys(), found.keys());
        for (column, cells) in &expected {
            assert_eq!(cells, &found[column], "{name}: {column}");
        }
        tables += expected.keys().filter_map(|key| key.split(' ').next()).collect::<BTreeSet<_>>().len();
    }
    assert!(tables >= 20, "{tables} tables were compared");
    // The numbers of fit.json: value and error of both parameters, a correlation, a residual.
    let json = fs::read_to_string(home.join("fit/fit.json")).expect("fit.json");
    let numbers = |mark: &str| -> Vec<String> {
        let ends = json.split(mark).skip(1).map(|rest| rest.split([',', '}', ']']).next().unwrap_or(""));
        ends.map(|number| bits(number.trim().parse().expect("a number"))).collect()
    };
    let (values, errors) = (numbers("\"value\": "), numbers("\"error\": "));
    let correlation = &numbers("\"matrix\": [[1.0, ")[0];
    let rms = &numbers("\"rms\": {\"slide.s\": ")[0];
    let expected = [&values[0], &errors[0], &values[1], &errors[1], correlation, rms];
    let lines: Vec<&str> = said.trim().lines().collect();
    assert!(lines[..6] == expected && lines[6] == "fits", "{lines:?} {expected:?}");
}

/// The lines of the example and of `vibro.show` pass through the rows of `response.csv`.
#[test]
#[ignore = "needs GNU Octave"]
fn second_method_drawn_lines_have_the_points_of_the_table() {
    let home = home("lines");
    let said = octave(
        &home,
        "response_curve; drawn_points('example.txt');\n\
         vibro.new('duffing_stop', 'plate.toml');\n\
         figure(); found = vibro.response('plate.toml', 'vary', 'load.coil.frequency=25Hz:60Hz', 'of', 'plate.s');\n\
         vibro.show(found); drawn_points('shown.txt'); disp(found.said);\n\
         figure(); found.response.('label') = NaN(size(found.response.('branch')));\n\
         vibro.show(found); drawn_points('unlabelled.txt');",
    );
    let arguments =
        ["response", "plate.toml", "--vary=load.coil.frequency=25Hz:60Hz", "--of=plate.s", "--out=plate"];
    let (_, printed, _) = vibro(&home, &arguments);
    assert_eq!(said.trim().lines().nth(1), printed.lines().nth(1), "the words of the program");
    let table = columns(&home.join("plate"));
    let [x, y] = ["load.coil.frequency", "maximum.plate.s"].map(|name| &table[&format!("response {name}")]);
    let number = |bits: &str| f64::from_bits(u64::from_str_radix(bits, 16).expect("bits"));
    for (file, scale) in [("example.txt", 1e3), ("shown.txt", 1.0), ("unlabelled.txt", 1.0)] {
        let scaled = y.iter().map(|y| bits(scale * number(y)));
        let expected: BTreeSet<String> = x.iter().zip(scaled).map(|(x, y)| format!("{x} {y}")).collect();
        let drawn = fs::read_to_string(home.join(file)).expect("points");
        let drawn: BTreeSet<String> = drawn.lines().map(str::to_owned).collect();
        assert!(expected.len() > 200 && drawn == expected, "{file}: {} of {}", drawn.len(), expected.len());
    }
}

/// Errors have the program's own words; names with spaces and quotation marks reach it unchanged.
#[test]
#[ignore = "needs GNU Octave"]
fn errors_are_the_words_of_the_program() {
    let home = home("words");
    let odd = "it's a \"machine\"; $HOME `x` 100%.toml";
    for name in [odd, "-h"] {
        fs::copy(DAMPER, home.join(name)).expect("target can be written");
    }
    fs::write(home.join("broken.toml"), "name = \"Broken\"\nbody.box.mas = 1\n")
        .expect("target can be written");
    let quoted = odd.replace('\'', "''");
    let calls: [(&[&str], &str, &str); 7] = [
        (&["run", "damper.toml", "--until=-2s"], "'damper.toml', 'until', '-2s'", "refused"),
        (&["run", "not here.toml", "--until=2"], "'not here.toml', 'until', 2", "refused"),
        (&["run", "broken.toml", "--until=2"], "'broken.toml', 'until', 2", "refused"),
        (&["run", "damper.toml", "--untl=2"], "'damper.toml', 'untl', 2", "refused"),
        (
            &["run", "damper.toml", "--until=1", "--set=stop.steel.gap="],
            "'damper.toml', 'until', 1, 'set', 'stop.steel.gap='",
            "refused",
        ),
        (
            &["run", "damper.toml", "--until=1", "--out=damper.toml/x"],
            "'damper.toml', 'until', 1, 'out', 'damper.toml/x'",
            "failed",
        ),
        (
            &["run", odd, "--until=1", "--columns=nothing"],
            &format!("'{quoted}', 'until', 1, 'columns', 'nothing'"),
            "refused",
        ),
    ];
    for (arguments, call, kind) in calls {
        let (status, _, words) = vibro(&home, arguments);
        assert!(status == Some(if kind == "refused" { 2 } else { 1 }), "{arguments:?}: {words}");
        let said = octave(&home, &format!("refusal(@() vibro.run({call}));"));
        let words = words.strip_prefix("error: ").expect("an error");
        assert_eq!(said.trim(), format!("vibro:{kind}\n{words}"), "{call}");
    }
    let said = octave(
        &home,
        &format!(
            "one = vibro.run('{quoted}', 'until', 0.1, 'out', 'results of ''one'' run');\n\
             two = vibro.run('-h', 'until', 0.1);\n\
             disp(isequaln(one.states, two.states) && isfolder(one.folder) && ~isfield(two, 'folder'));\n\
             refusal(@() vibro.run('damper.toml', 'until', 0.2, 'out', one.folder));\n\
             again = vibro.run('damper.toml', 'until', 0.2, 'out', one.folder, 'replace', true);\n\
             disp(again.states.('time')(end));"
        ),
    );
    let lines: Vec<&str> = said.trim().lines().collect();
    let (first, last) = (lines[0], lines[lines.len() - 1]);
    assert!(first == "1" && last == "0.2000" && lines[1] == "vibro:refused", "{said}");
    assert!(said.contains("results of 'one' run") && said.contains("--replace"), "{said}");
}

#[test]
#[ignore = "needs GNU Octave"]
fn a_missing_program_and_arguments_of_another_kind_are_refused() {
    let home = home("refused");
    let run = "refusal(@() vibro.run('damper.toml', 'until', 1));";
    let not_a_program = home.join("damper.toml").display().to_string();
    for (program, said) in [
        ("no-such-vibro", "the program no-such-vibro cannot be run ("),
        (
            "/no/such/vibro",
            "the program /no/such/vibro is missing: give its path with vibro.program('/path/to/vibro')",
        ),
        (&not_a_program, "cannot be run ("),
    ] {
        let found = octave_with(program, &home, run);
        assert!(found.starts_with("vibro:program\n") && found.contains(said), "{program}: {found}");
        assert!(found.contains("VIBRO_PROGRAM"), "{program}: {found}");
    }
    fs::write(home.join("ragged.csv"), "a,b\n1,2\n3\n").expect("target can be written");
    fs::write(home.join("open.csv"), "a,b\n1,\"2\n").expect("target can be written");
    fs::write(home.join("cells.csv"), "a,\"b, c\",d\r\n1,\"x \"\"y\"\"\n\",inf\n,z,-inf")
        .expect("target can be written");
    for (call, said) in [
        (
            "vibro.run('damper.toml', 'until')",
            "1 arguments after the file is an odd number; expected pairs of a name and a value, such as 'until', '2s'",
        ),
        (
            "vibro.run('damper.toml', 'until', [1 2])",
            "option \"until\" is a double of size [1 2]; expected a text or a number",
        ),
        (
            "vibro.run('damper.toml', 'until', {struct()})",
            "option \"until\" is a struct of size [1 1]; expected a text or a number",
        ),
        (
            "vibro.run('damper.toml', 'un til', 1)",
            "option \"un til\": expected the name of an option of the command line without its dashes, such as 'until'",
        ),
        (
            "vibro.run('damper.toml', 'until', 1, 'out', '')",
            "option \"out\" is empty; expected the name of a folder",
        ),
        (
            "vibro.run('', 'until', 1)",
            "the machine's file has an empty name; expected a file such as 'damper.toml'",
        ),
        (
            "vibro.run(7i, 'until', 1)",
            "the machine's file is a double of size [1 1]; expected a text or a number",
        ),
        (
            "vibro.show(struct('command', 'basin'))",
            "a result of vibro.basin is not drawn here; expected one of run, response, orbits, bifurcation, sweep, section, fit. With the option 'out' the folder has the picture of the program",
        ),
        ("vibro.show(1)", "expected a result of this package, such as of vibro.run"),
        (
            "vibro.read_table('ragged.csv')",
            "ragged.csv: the rows have different numbers of cells; expected a table (CSV)",
        ),
        (
            "vibro.read_table('open.csv')",
            "open.csv: the rows have different numbers of cells; expected a table (CSV)",
        ),
        ("vibro.read_table('none.csv')", "none.csv: no such file; expected a table (CSV)"),
    ] {
        assert_eq!(
            octave(&home, &format!("refusal(@() {call});")).trim(),
            format!("vibro:refused\n{said}"),
            "{call}"
        );
    }
    let cells = "t = vibro.read_table('cells.csv'); disp(isequaln(t.('d'), [Inf; -Inf]));\n\
                 disp(isequaln(t.('a'), [1; NaN])); disp(isequal(t.('b, c'), {['x \"y\"', 10]; 'z'}));";
    assert_eq!(octave(&home, cells).split_whitespace().collect::<Vec<_>>(), ["1"; 3]);
    // Numbers within strings of JSON stay text; lists of lists are matrices.
    let json = "x = vibro.inner.json('{\"t.u\": \"x, 5\", \"m\": [[1, -0.25], [2, 3e-5]], \"n\": null}');\n\
                disp(strcmp(x.t_u, 'x, 5') && isequal(x.m, [1, -0.25; 2, 3e-5]) && isempty(x.n));";
    assert_eq!(octave(&home, json).trim(), "1");
}

/// The blocks of docs/matlab.md, one after another in one folder.
#[test]
#[ignore = "needs GNU Octave"]
fn the_blocks_of_the_page_run() {
    let page = fs::read_to_string(root().join("docs/matlab.md")).expect("docs/matlab.md");
    let blocks = page.split("```matlab\n").skip(1).filter_map(|rest| rest.split("```").next());
    let blocks: Vec<&str> = blocks.collect();
    assert!(blocks.len() >= 3, "{} blocks", blocks.len());
    let home = folder("octave-page");
    fs::create_dir_all(&home).expect("target can be written");
    let said = octave(&home, &blocks.concat());
    for shown in page.split("```text\n").skip(1).filter_map(|rest| rest.split("```").next()) {
        assert!(said.contains(shown.trim()), "the page shows\n{shown}\nand Octave prints\n{said}");
    }
    // The page shows the example as it is in its file.
    let example = fs::read_to_string(root().join("matlab/response_curve.m")).expect("the example");
    assert_eq!(example.lines().count(), 20);
    assert!(example.lines().skip(2).all(|line| page.contains(line)), "docs/matlab.md shows the example");
}
