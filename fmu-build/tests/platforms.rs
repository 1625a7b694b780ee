//! The archive of all platforms. Building it takes minutes and uncommon tools, so it runs only on
//! request: `cargo test -p fmu-build --test platforms -- --ignored --nocapture`. Checks that
//! cannot be done here are printed.

mod common;

use fmu_build::compile::PLATFORM;
use fmu_build::platforms::{PLATFORMS, Platform};
use fmu_build::version::Version;
use fmu_build::{archive, inspect, package};
use std::path::Path;
use std::process::Command;
use vibro_impact::{Parameters, Simulator, State};
use vibro_paper_component::component::variables;
use vibro_paper_component::fmi2::description;
use vibro_paper_component::fmi3::description as fmi3;

const NAMES: [&str; 6] = ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"];

/// The default motion is stable: different roundings (another libm's sine, fused operations) are
/// not amplified.
const SAME: f64 = 1e-10;

const PERIODS: u32 = 50;
const PER_PERIOD: u32 = 20;

#[test]
#[ignore = "builds every platform: needs minutes, rustup targets and fmu-build/requirements.txt"]
fn every_platform_that_can_be_built_is_packed_and_runs_where_it_can() {
    let folder = tempfile::tempdir().unwrap();
    let fmu = folder.path().join("x.fmu");
    let left_out = package::build_all(&fmu, &Version::USUAL, None).unwrap();
    for platform in &left_out {
        println!("{platform}");
    }
    let expected = native();
    for platform in PLATFORMS {
        let missing = left_out.iter().any(|l| l.folder == platform.place.folder);
        if missing {
            continue;
        }
        let bytes = archive::read(&fmu, &platform.path(Version::Fmi2)).unwrap();
        let same = archive::read(&Version::Fmi3.beside(&fmu), &platform.path(Version::Fmi3)).unwrap();
        assert!(same == bytes, "{}: the archives hold different libraries", platform.place.folder);
        check_binary(&platform, &bytes);
        let library = folder.path().join(platform.place.folder).join(format!("x{}", platform.place.ending));
        archive::write_file(&library, &bytes).unwrap();
        for version in [Version::Fmi2, Version::Fmi3] {
            let folder = platform.place.folder;
            match run(&platform, &library, version) {
                Ok(got) => {
                    let difference = difference(&got, &expected);
                    println!(
                        "{folder}: runs by {}, largest difference from the native run {difference:.1e}",
                        version.name()
                    );
                    assert!(difference < SAME, "{folder} by {}: {difference:e}", version.name());
                }
                Err(reason) => println!("{folder}: not run: {reason}"),
            }
        }
    }
}

/// Format, processor, exports and needs, slice by slice.
fn check_binary(platform: &Platform, bytes: &[u8]) {
    let folder = platform.place.folder;
    let slices = inspect::slices(bytes).unwrap();
    assert_eq!(slices.len(), platform.targets.len(), "{folder}");
    for (slice, target) in slices.into_iter().zip(platform.targets) {
        assert_eq!(inspect::kind(slice), Ok(inspect::kind_of_target(target)), "{folder}");
        let mut exported = inspect::exports(slice).unwrap();
        if platform.place.ending == ".dylib" {
            // zig's linker ignores the list of exports: two names of Rust's runtime remain.
            exported.retain(|name| !RUN_TIME.iter().any(|part| name.contains(part)));
        }
        assert_eq!(exported, common::functions(), "{folder}");
        let needs = inspect::needs(slice).unwrap();
        assert!(needs.iter().all(|name| inspect::is_system(name)), "{folder}: {needs:?}");
        assert_eq!(inspect::later_glibc(&needs), None, "{folder}");
        println!("{folder}: {target} needs {}", needs.into_iter().collect::<Vec<_>>().join(", "));
    }
}

/// Symbols of Rust, and of every Mach-O library.
const RUN_TIME: [&str; 4] = ["rust_eh_personality", "std9panicking", "dso_handle", "mh_dylib_header"];

type Path6 = Vec<[f64; 6]>;

/// The native motion at the communication points.
fn native() -> Path6 {
    let parameters = Parameters::default();
    let step = parameters.period() / f64::from(PER_PERIOD);
    let mut simulator = Simulator::new(&parameters, &State::default(), 0.0).unwrap();
    let mut path = Vec::new();
    for i in 0..=PERIODS * PER_PERIOD {
        simulator.advance_to(f64::from(i) * step).unwrap();
        let State { x, v } = simulator.state();
        path.push([x[0], x[1], x[2], v[0], v[1], v[2]]);
    }
    path
}

fn difference(a: &Path6, b: &Path6) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Compiles tests/host.c for the platform, runs it with the library and reads its output. With FMI
/// 3.0 it stops at every event.
fn run(platform: &Platform, library: &Path, version: Version) -> Result<Path6, String> {
    let (runner, target): (&[&str], &str) = match platform.place.folder {
        folder if folder == PLATFORM && cfg!(target_arch = "x86_64") => (&[], platform.targets[0]),
        "win64" => (&["wine"], "x86_64-windows-gnu"),
        "win32" => (&["wine"], "x86-windows-gnu"),
        "linux32" => (&["qemu-i386"], "x86-linux-gnu.2.17"),
        "aarch64-linux" => (&["qemu-aarch64"], "aarch64-linux-gnu.2.17"),
        _ => return Err("no emulator is known".into()),
    };
    let target = if runner.is_empty() { "x86_64-linux-gnu.2.17" } else { target };
    if let Some(program) = runner.first()
        && Command::new(program).arg("--version").output().is_err()
    {
        return Err(format!("install {program} (Debian: apt install wine64 qemu-user)"));
    }
    let host = library.with_file_name(if platform.place.ending == ".dll" { "host.exe" } else { "host" });
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/host.c");
    let mut zig = Command::new("cargo-zigbuild");
    zig.args(["zig", "cc", "--", "-target", target, "-O1", "-o"]).arg(&host).arg(&source);
    if platform.place.ending == ".so" {
        zig.arg("-ldl");
    }
    let compiled = zig.output().map_err(|e| format!("cargo-zigbuild: {e}"))?;
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));

    let step = Parameters::default().period() / f64::from(PER_PERIOD);
    let mut command = match runner.first() {
        Some(program) => {
            let mut command = Command::new(program);
            if let Some(libraries) = libraries(platform) {
                command.args(["-L", libraries]);
            }
            command.arg(&host);
            command
        }
        None => Command::new(&host),
    };
    let (number, identifier, numbering) = match version {
        Version::Fmi2 => ("2", description::guid(), description::NUMBERING),
        _ => ("3", fmi3::instantiation_token(fmi3::MAIN), fmi3::numbering(fmi3::MAIN)),
    };
    command.arg(library).arg(number).arg(identifier).arg(step.to_string());
    command.arg((PERIODS * PER_PERIOD).to_string());
    command.args(NAMES.map(|name| numbering.reference(variables::place(name)).unwrap().to_string()));
    command.env("WINEDEBUG", "-all").env("WINEPREFIX", library.with_file_name("wine"));
    let output = command.output().map_err(|e| e.to_string())?;
    let (printed, errors) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    if !output.status.success() && errors.contains("No such file or directory") {
        // An emulator without the C library of that processor.
        return Err(format!("{} (Debian: apt install libc6-arm64-cross libc6-i386-cross)", errors.trim()));
    }
    if platform.place.folder == "win32" && printed.is_empty() && output.status.success() {
        // Wine without its 32-bit part starts nothing and prints nothing.
        return Err(
            "Wine runs no 32-bit programs (Debian: dpkg --add-architecture i386, apt install wine32)".into(),
        );
    }
    assert!(output.status.success(), "{}: {}\n{printed}\n{errors}", platform.place.folder, output.status);
    let row = |line: &str| -> [f64; 6] {
        let values: Vec<f64> = line.split_whitespace().map(|word| word.parse().unwrap()).collect();
        values.try_into().unwrap()
    };
    Ok(printed.lines().map(row).collect())
}

/// Debian's folder for another processor's C library.
fn libraries(platform: &Platform) -> Option<&'static str> {
    let folder = match platform.place.folder {
        "aarch64-linux" => "/usr/aarch64-linux-gnu",
        "linux32" => "/usr/i686-linux-gnu",
        _ => return None,
    };
    Path::new(folder).is_dir().then_some(folder)
}
