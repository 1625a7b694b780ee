//! Hosts load and unload the library many times: its memory is released, and nothing that it
//! leaves behind keeps it loaded.
#![cfg(target_os = "linux")] // looks into /proc
#![allow(unsafe_code)] // calls one function by name

mod common;

use fmu_build::compile::{self, Product};
use fmu_build::host;
use std::path::{Path, PathBuf};
use std::process::Command;
use vibro_paper_component::component::variables::reference;
use vibro_paper_component::fmi2::description;

/// Measured cycles, after warm-up cycles for the allocator's growth.
const CYCLES: u32 = 200;
const WARM_UP: u32 = 20;

/// Memory that a long-lived process may still take for itself, bytes; std's hook with backtraces
/// takes tens of MB, a leaked instance 200 times 2 KiB.
const GROWTH: u64 = 256 << 10;

/// Variable that gives the child process the library to load and the action.
const LIBRARY: &str = "VIBRO_IMPACT_LOADING";
const PANIC: &str = "VIBRO_IMPACT_PANIC";
/// Variable with the component's token and the reference of its time, separated by a blank.
const COMPONENT: &str = "VIBRO_IMPACT_COMPONENT";

/// Resident memory of this process in bytes.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").trim().parse::<u64>().unwrap() << 10
}

fn is_mapped(library: &Path) -> bool {
    let name = library.file_name().unwrap().to_str().unwrap();
    std::fs::read_to_string("/proc/self/maps").unwrap().contains(name)
}

/// Loads, instantiates, steps, causes an error, frees, unloads.
fn simulate(library: &Path) {
    let component = std::env::var(COMPONENT).unwrap();
    let (token, time) = component.split_once(' ').unwrap();
    let binary = host::Binary::load(library).unwrap();
    let mut instance = binary.instantiate(token).unwrap();
    instance.initialize(0.0).unwrap();
    instance.step(0.0, 30.0).unwrap();
    assert_eq!(instance.real(&[time.parse().unwrap()]).unwrap(), [30.0]);
    assert!(instance.step(0.0, 1.0).is_err());
    assert!(is_mapped(library));
}

/// Loads, panics inside an FMI call, unloads.
fn panic(library: &Path) {
    // SAFETY: our own library; the function takes nothing and returns a status.
    unsafe {
        let library = libloading::Library::new(library).unwrap();
        let provoke = library.get::<unsafe extern "C" fn() -> i32>("provoke_panic\0").unwrap();
        assert_eq!(provoke(), 4); // fmi2Fatal
    }
}

/// Runs in a separate process, started by the two tests below.
#[test]
fn cycles() {
    let Some(library) = std::env::var_os(LIBRARY).map(PathBuf::from) else { return };
    let once = if std::env::var_os(PANIC).is_some() { panic } else { simulate };
    for _ in 0..WARM_UP {
        once(&library);
    }
    let before = resident();
    for _ in 0..CYCLES {
        once(&library);
        assert!(!is_mapped(&library), "the library stays in memory after it was unloaded");
    }
    let growth = resident().saturating_sub(before);
    assert!(growth <= GROWTH, "{growth} bytes more after {CYCLES} cycles");
    println!("{growth} bytes more after {CYCLES} cycles");
}

/// Loads the library repeatedly with a component's token and the reference of its time; without a
/// component, it panics.
fn in_its_own_process(library: &Path, component: Option<(&str, u32)>) {
    let mut child = Command::new(std::env::current_exe().unwrap());
    child.args(["--exact", "cycles", "--nocapture"]).env(LIBRARY, library).env("RUST_BACKTRACE", "1");
    match component {
        Some((token, time)) => child.env(COMPONENT, format!("{token} {time}")),
        None => child.env(PANIC, "1"),
    };
    let output = child.output().unwrap();
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && out.contains("cycles"), "{out}{err}");
    // FMUs print nothing, even if they panic and the host wants backtraces.
    assert_eq!(err, "");
}

#[test]
fn two_hundred_load_unload_cycles_leave_nothing_behind() {
    let component = (&*description::guid(), reference("time"));
    in_its_own_process(&compile::at_hand(Product::Vibro).unwrap(), Some(component));
}

#[test]
fn nor_do_those_of_the_second_component() {
    let (folder, library) = common::ball::described("loaded-ball");
    let text = std::fs::read_to_string(folder.join("fmi2/modelDescription.xml")).unwrap();
    let token = text.split("guid=\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
    in_its_own_process(&library, Some((token, 1)));
}

#[test]
fn nor_do_two_hundred_with_a_panic() {
    in_its_own_process(&panicking(), None);
}

/// The library of `tests/panicking/`, which cargo compiled for this test, next to the test.
fn panicking() -> PathBuf {
    std::env::current_exe().unwrap().with_file_name("libpanicking.so")
}
