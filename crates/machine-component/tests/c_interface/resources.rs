//! The machine's file in the resources: another machine's file, damaged files and hostile files.

use crate::host::*;
use crate::*;
use std::ffi::CString;
use std::path::Path;
use std::ptr::{null, null_mut};
use vibro_machine_component::{FILE, Plan};

#[test]
fn another_machines_file_or_description_is_refused_at_instantiation() {
    let (ball, paper) = (plan("bouncing_ball.toml", unchanged), plan("paper_machine.toml", unchanged));
    let heavier = plan("bouncing_ball.toml", |text| text.replace("0.02", "0.03"));
    let folder = resources("swapped", &ball);
    for other in [&paper, &heavier] {
        let refused = Instance::new(&folder, &ball, other.token(), false);
        assert!(refused.c.is_null());
        assert!(refused.messages[0].contains("instantiationToken"), "{:?}", refused.messages);
        assert!(refused.messages[0].contains(ball.token()), "{:?}", refused.messages);
        let file = folder.join(FILE);
        let said =
            format!("{}: this is not the text from which the model description was made", file.display());
        assert!(refused.messages[0].contains(&said), "{:?}", refused.messages);
    }
    let nowhere = Instance::new(Path::new("/nowhere"), &ball, ball.token(), false);
    assert!(nowhere.c.is_null());
    assert!(nowhere.messages[0].contains("machine.toml: "), "{:?}", nowhere.messages);
}

#[test]
fn a_damaged_file_is_named_with_the_line_that_is_no_machines() {
    let ball = plan("bouncing_ball.toml", unchanged);
    let lines: Vec<&str> = ball.text().lines().collect();
    let place = lines.iter().position(|line| line.starts_with("gap")).unwrap();
    let broken = |line: &str| [&lines[..place], &[line], &lines[place + 1..]].concat().join("\n");
    for (name, text, line, said) in [
        ("half a line", broken("gap = "), place + 1, ""),
        ("a letter", broken("gop = 1.0"), place + 1, "gop"),
        ("no number", broken("gap = \"x\""), place + 1, "stop.floor.gap"),
        ("cut off", lines[..place].join("\n"), place - 1, "stop.floor"),
    ] {
        let folder = resources(&format!("damaged {name}"), &ball);
        std::fs::write(folder.join(FILE), text).unwrap();
        let refused = Instance::new(&folder, &ball, ball.token(), false);
        assert!(refused.c.is_null());
        let (message, file) = (refused.messages.join("\n"), folder.join(FILE));
        assert!(message.contains(&format!("{}:{line}: ", file.display())), "{name}: {message}");
        assert!(
            message.contains(said) && message.contains("this is not the text from which"),
            "{name}: {message}"
        );
        assert!(message.contains(ball.token()), "{name}: {message}");
    }
}

/// Writes a folder of resources whose file has these bytes; returns it with the token.
fn hostile(folder: &str, bytes: &[u8]) -> (std::path::PathBuf, String) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(folder);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(FILE), bytes).unwrap();
    (folder, Plan::token_of(&String::from_utf8_lossy(bytes)))
}

#[test]
fn hostile_files_are_refused_by_name_and_quickly() {
    let ball = plan("bouncing_ball.toml", unchanged);
    let text = ball.text();
    let mut many = String::from("name = \"Many\"\n");
    (0..10_001).for_each(|i| {
        many += &format!("[body.b{i}]\nmass = 1.0\n[load.l{i}]\non = \"b{i}\"\nconstant = 1.0\n")
    });
    let nested = format!("name = \"Deep\"\nx = {}{}\n", "[".repeat(200_000), "]".repeat(200_000));
    let dotted = format!("name = \"Deep\"\n{} = 1\n", vec!["a"; 100_000].join("."));
    let sled = |load: &str| format!("name = \"A\"\n[body.b]\nmass = 1.0\n[load.l]\non = \"b\"\n{load}\n");
    for (name, text, said) in [
        ("truncated", text[..text.len() / 2].to_owned(), ""),
        ("empty", String::new(), "name"),
        ("nested", nested, ""),
        ("dotted", dotted, ""),
        ("many", many, "10000"),
        ("nan", text.replace("0.02", "nan"), "body.ball.mass = nan"),
        ("infinite", text.replace("0.02", "inf"), "body.ball.mass = inf"),
        ("traversal", sled("table = \"../../../etc/passwd\""), "load.l.table"),
        ("absolute", sled("table = \"/etc/passwd\""), "load.l.table"),
        ("huge harmonics", sled("harmonics = 1e9"), "load.l.harmonics"),
        ("control", text.replace("name = \"", "name = \"\u{1}\u{7f}"), ""),
    ] {
        let (folder, token) = hostile(&format!("hostile {name}"), text.as_bytes());
        let before = std::time::Instant::now();
        let refused = Instance::new(&folder, &ball, &token, false);
        assert!(refused.c.is_null(), "{name}");
        let message = refused.messages.join("\n");
        assert!(message.contains(FILE) && message.contains(said), "{name}: {message}");
        assert!(message.len() < 100_000, "{name}: {} bytes", message.len());
        assert!(before.elapsed().as_secs() < 20, "{name}: {:?}", before.elapsed());
    }
    // Bytes that are not UTF-8.
    let (folder, token) = hostile("hostile bytes", &[0xff, 0xfe, 0x00, 0x80]);
    let refused = Instance::new(&folder, &ball, &token, false);
    assert!(refused.c.is_null() && refused.messages[0].contains(FILE), "{:?}", refused.messages);
    // A folder where the file should be.
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("hostile folder");
    std::fs::create_dir_all(folder.join(FILE)).unwrap();
    let refused = Instance::new(&folder, &ball, ball.token(), false);
    assert!(refused.c.is_null() && refused.messages[0].contains(FILE), "{:?}", refused.messages);
}

#[test]
fn resources_are_found_in_folders_of_any_name_and_beside_the_library() {
    let ball = plan("bouncing_ball.toml", unchanged);
    let folder = resources("r\u{e9}sources 100% \u{2603}", &ball);
    let slashed = format!("{}/", folder.display());
    for path in [folder.to_str().unwrap(), &slashed] {
        let instance = Instance::new(Path::new(path), &ball, ball.token(), false);
        assert!(!instance.c.is_null(), "{path}: {:?}", instance.messages);
    }
    let token = CString::new(ball.token()).unwrap();
    let coded =
        folder.display().to_string().replace('%', "%25").replace(' ', "%20").replace('\u{2603}', "%E2%98%83");
    for uri in [format!("file://{coded}"), format!("file:{coded}/"), format!("file://localhost{coded}")] {
        let uri = CString::new(uri).unwrap();
        unsafe {
            let c = fmi2Instantiate(c"a".as_ptr(), 1, token.as_ptr(), uri.as_ptr(), null(), 0, 0);
            assert!(!c.is_null(), "{uri:?}");
            fmi2FreeInstance(c);
        }
    }
    // An unpacked FMU has the library in binaries/PLATFORM/; this program is
    // target/debug/deps/NAME.
    let beside = std::env::current_exe().unwrap().ancestors().nth(3).unwrap().join("resources");
    std::fs::create_dir_all(&beside).unwrap();
    std::fs::write(beside.join(FILE), ball.text()).unwrap();
    let wrong = CString::new("file:///nowhere").unwrap();
    for location in [null(), wrong.as_ptr()] {
        unsafe {
            let (name, token) = (c"a".as_ptr(), token.as_ptr());
            let c = fmi2Instantiate(name, 1, token, location, null(), 0, 0);
            assert!(!c.is_null());
            fmi2FreeInstance(c);
            let c = fmi3InstantiateModelExchange(name, token, location, 0, 0, null_mut(), None);
            assert!(!c.is_null());
            fmi3FreeInstance(c);
        }
    }
    std::fs::remove_dir_all(&beside).unwrap();
}

#[test]
fn two_machines_and_two_instances_in_one_process() {
    let (ball, damper) = (plan("bouncing_ball.toml", unchanged), plan("damper_with_buffer.toml", unchanged));
    let instances = [
        Instance::of("both ball", &ball, false),
        Instance::of("both damper", &damper, false),
        Instance::of("both ball", &ball, false),
        Instance::of("both damper", &damper, false),
    ];
    instances.iter().for_each(Instance::begin);
    for k in 0..20 {
        for instance in &instances {
            instance.step(0.05 * f64::from(k), 0.05);
        }
    }
    let (mut one, mut two) = (native(&ball), native(&damper));
    for k in 0..20 {
        let to = 0.05 * f64::from(k) + 0.05;
        one.advance_to(to).unwrap();
        two.advance_to(to).unwrap();
    }
    for pair in [&instances[..2], &instances[2..]] {
        assert_eq!(pair[0].get("ball.s"), one.body(0)[0] + 0.0);
        assert_eq!(pair[1].get("block.v"), two.body(1)[1] + 0.0);
    }
}

#[test]
fn a_machine_of_two_hundred_bodies_moves() {
    let mut text = String::from("name = \"Chain\"\n[body.b0]\nmass = 1.0\nstart = { v = 1.0 }\n");
    for i in 1..200 {
        let before = i - 1;
        text += &format!(
            "[body.b{i}]\nmass = 1.0\n[spring.s{i}]\nbetween = [\"b{before}\", \"b{i}\"]\nstiffness = 100.0\n"
        );
    }
    let plan = Plan::new(text, FILE).unwrap();
    let chain = Instance::of("chain", &plan, false);
    chain.begin();
    chain.step(0.0, 0.1);
    // Momentum is conserved.
    let momentum: f64 = (0..200).map(|i| chain.get(&format!("b{i}.v"))).sum();
    assert!((momentum - 1.0).abs() < 1e-13, "{momentum}");
}

#[test]
fn jams_and_limits_of_work_are_errors_in_the_engines_words_and_the_state_stays() {
    // A prescribed piston drives a block onto a wall.
    let text = "name = \"Press\"\n[body.piston]\nmotion = { rate = 1.0 }\n[body.wall]\nmotion = { constant = 0.0 }\n\
                [stop.face]\nbetween = [\"wall\", \"piston\"]\ngap = 0.5\nrestitution = 0.5\n\
                [body.weight]\nmass = 1.0\n[spring.s]\nbetween = [\"ground\", \"weight\"]\nstiffness = 1.0\n";
    let press = Plan::new(text.into(), FILE).unwrap();
    // A light elastic ball under a constant force, which never comes to rest.
    let text = "name = \"Elastic\"\ngravity = 9.81\n[body.ball]\nmass = 1e-3\ngravity = 1.0\nstart = { s = -1e-9 }\n\
                [stop.floor]\nbetween = [\"ground\", \"ball\"]\ngap = 0.0\nrestitution = 1.0\n";
    let elastic = Plan::new(text.into(), FILE).unwrap();
    for (name, plan, good, bad, said) in [
        ("jam", &press, 0.25, 1.0, "jammed at t = 0.5 s: stop.face"),
        ("work", &elastic, 1e-3, 100.0, "stop.floor"),
    ] {
        let press = Instance::of(name, plan, false);
        press.begin();
        let mut state = null_mut();
        let (mut event, mut end, mut early, mut time) = (0, 0, 0, 0.0);
        unsafe {
            assert_eq!(fmi3GetFMUState(press.c, &mut state), OK);
            let status = fmi3DoStep(press.c, 0.0, bad, 1, &mut event, &mut end, &mut early, &mut time);
            assert!(status > 1, "{name}");
            assert!(press.messages.last().unwrap().contains(said), "{name}: {:?}", press.messages);
            // The state is unchanged, and the motion can continue.
            assert_eq!(press.get("time"), 0.0);
            assert_eq!(fmi3SetFMUState(press.c, state), OK);
            press.step(0.0, good);
            assert_eq!(press.get("time"), good);
            assert_eq!(fmi3FreeFMUState(press.c, &mut state), OK);
        }
    }
}
