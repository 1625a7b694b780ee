//! A trial of the wheel: it is installed in a clean virtual environment and run.

use super::contents::archive_of;
use super::sum;
use crate::compile::target;
use crate::error::{Error, Result};
use crate::version::Version;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use vibro_impact::{Parameters, Simulator, State};

static SCRIPT: &str = include_str!("try_wheel.py");

/// Duration of the script, in half seconds.
const HALF_SECONDS: u32 = 600;

/// Installs a wheel of a folder and compares its results with the native library. Returns the
/// interpreter's version, or the reason why an environment for the installation is missing.
///
/// # Errors
/// [`Error::Release`] if the package cannot be imported or has other results.
pub fn installed(dist: &Path, wheel: &str, version: &str) -> Result<std::result::Result<String, String>> {
    let environment = target().join("dist/venv");
    let mut venv = Command::new("python3");
    venv.args(["-m", "venv", "--clear"]).arg(&environment);
    let python = environment.join("bin/python");
    let mut pip = Command::new(&python);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]).arg(dist.join(wheel));
    for command in [&mut venv, &mut pip] {
        if let Err(reason) = printed(command) {
            return Ok(Err(reason));
        }
    }
    let asked = printed(Command::new(&python).arg("--version"));
    let found = printed(Command::new(&python).args(["-I", "-c", SCRIPT]).stdin(Stdio::null()));
    let found = found.map_err(|reason| Error::Release(vec![format!("{wheel}: {reason}")]))?;
    let expected = expected(dist, version)?;
    match found.lines().zip(expected.lines()).find(|(found, expected)| found != expected) {
        Some((found, expected)) => Err(Error::Release(vec![format!(
            "{wheel}: installed, it gives {found} where the release and the native library have {expected}"
        )])),
        None if found.len() == expected.len() => Ok(Ok(asked.unwrap_or_default().trim().to_owned())),
        None => Err(Error::Release(vec![format!("{wheel}: installed, it gives too few lines")])),
    }
}

/// Expected output of the script.
fn expected(dist: &Path, version: &str) -> Result<String> {
    let mut text = format!("{version}\n");
    for edition in Version::USUAL {
        let path = archive_of(dist, edition);
        text += &format!("{}\n", sum(&fs::read(&path).map_err(Error::file("reading", &path))?));
    }
    let mut simulator = Simulator::new(&Parameters::default(), &State::default(), 0.0)?;
    for i in 0..=HALF_SECONDS {
        simulator.advance_to(0.5 * f64::from(i))?;
        let State { x, v } = simulator.state();
        text.extend(x.iter().chain(&v).map(|value| format!("{:016x}", value.to_bits())));
        text.push('\n');
    }
    Ok(text)
}

/// Standard output of a program, or its standard error if it fails.
fn printed(command: &mut Command) -> std::result::Result<String, String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|e| format!("{name} cannot be run: {e}"))?;
    match output.status.success() {
        true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        false => Err(format!("{name} failed: {}", String::from_utf8_lossy(&output.stderr).trim())),
    }
}
