//! Chromium without a window, for the tests that look at pages.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Where Chromium is, by `CHROMIUM` or on the path.
pub fn chromium() -> PathBuf {
    let named = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let usual = ["chromium", "chromium-browser", "google-chrome"].map(PathBuf::from);
    let candidates = named.map_or_else(|| usual.to_vec(), |path| vec![path]);
    let works = |path: &&PathBuf| Command::new(path).arg("--version").output().is_ok();
    candidates.iter().find(works).cloned().unwrap_or_else(|| {
        panic!("none of {candidates:?} runs: install Chromium (Debian: apt install chromium) or name it in CHROMIUM")
    })
}

/// Opens a page in a headless window; what is printed, and the log.
pub fn browse(arguments: &[&str], page: &Path, profile: &Path) -> (String, String) {
    let output = Command::new(chromium())
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            "--force-device-scale-factor=1",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
        ])
        .args(["--enable-logging=stderr", "--virtual-time-budget=5000"])
        .arg(format!("--user-data-dir={}", profile.display()))
        .args(arguments)
        .arg(format!("file://{}", page.display()))
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(output.status.success(), "{}", text(&output.stderr));
    (text(&output.stdout), text(&output.stderr))
}
