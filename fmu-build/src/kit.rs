//! The kit: the library that serves all described machines, and its licences. Making a kit needs a
//! compiler and takes minutes. The kit is cached under `target/` and reused while its sources and
//! compiler are unchanged.

use crate::archive;
use crate::compile::{Product, target, workspace};
use crate::error::{Error, Result};
use crate::platforms::{self, Binaries, LeftOut};
use crate::{date, licences};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::{fs, io};
use vibro_numerics::digest::{EMPTY, extended};
pub use vibro_pack::{KIT_FILE, Kit};

/// Entry of a cached kit that holds the digest of its inputs.
const ORIGIN: &str = "origin.txt";

/// Sources of the code that makes a kit; the digest in its origin includes them.
const MAKERS: [&[u8]; 4] = [
    include_bytes!("kit.rs"),
    include_bytes!("compile.rs"),
    include_bytes!("platforms.rs"),
    include_bytes!("licences.rs"),
];

/// Kit for this platform, built for distribution. The first call compiles the library; later calls
/// read the cache.
///
/// # Errors
/// [`Error::Cargo`], [`Error::File`].
pub fn own() -> Result<Kit> {
    let make = || Ok((platforms::own(Product::Machine)?, Vec::new()));
    Ok(Shelf::of("own").kit(make)?.0)
}

/// Kit for this platform with the library that was compiled together with the packager.
///
/// # Errors
/// As [`own`].
pub fn at_hand() -> Result<Kit> {
    around(platforms::at_hand_of(Product::Machine)?)
}

/// Kit for every platform that can be built here, and a list of the others. The kit is cached only
/// if no platform is missing.
///
/// # Errors
/// As [`own`].
pub fn all() -> Result<(Kit, Vec<LeftOut>)> {
    Shelf::of("all").kit(|| platforms::all_of(Product::Machine, &[]))
}

/// Kit for the platforms with the given FMI 3.0 tuples; for all platforms if no tuple is given.
/// The kit is not cached.
///
/// # Errors
/// As [`own`].
pub fn of(only: &[String]) -> Result<(Kit, Vec<LeftOut>)> {
    if only.is_empty() {
        return all();
    }
    let (binaries, left_out) = platforms::all_of(Product::Machine, only)?;
    Ok((around(binaries)?, left_out))
}

/// A kit with the component for WebAssembly, too; it is compiled unless unchanged.
///
/// # Errors
/// As [`own`].
pub fn with_component(kit: Kit) -> Result<Kit> {
    let binaries = kit.binaries.with_component(platforms::component()?);
    let mut licences = licences::texts_of(Product::Component, false)?;
    licences.extend(kit.licences);
    Ok(Kit { binaries, licences, ..kit })
}

/// Kit around compiled libraries.
fn around(binaries: Binaries) -> Result<Kit> {
    Ok(Kit { binaries, licences: licences::texts_of(Product::Machine, false)?, date: date::of_sources() })
}

/// Cache of a kit.
#[derive(Clone, Debug)]
struct Shelf {
    file: PathBuf,
    workspace: PathBuf,
    compiler: String,
}

impl Shelf {
    fn of(name: &str) -> Self {
        let file = target().join("fmu/kits").join(name).with_extension("zip");
        Self { file, workspace: workspace().to_owned(), compiler: compiler() }
    }

    /// The cached kit if its inputs are unchanged, otherwise the kit that `make` returns.
    fn kit(&self, make: impl FnOnce() -> Result<(Binaries, Vec<LeftOut>)>) -> Result<(Kit, Vec<LeftOut>)> {
        if let Some(kit) = self.kept() {
            return Ok((kit, Vec::new()));
        }
        // The origin is computed before compiling, so that a change during the compilation
        // invalidates the cached kit.
        let packages = licences::own_packages(Product::Machine)?;
        let origin = self.origin(&packages).map_err(Error::file("reading", &self.workspace))?;
        let (binaries, left_out) = make()?;
        let kit = around(binaries)?;
        if left_out.is_empty() {
            archive::write(&kept_as(&kit, origin), &self.file)?;
        }
        Ok((kit, left_out))
    }

    /// The cached kit, if there is one and its inputs are unchanged.
    fn kept(&self) -> Option<Kit> {
        let mut content = archive::read_all(&self.file).ok()?;
        let origin = String::from_utf8(content.remove(ORIGIN)?).ok()?;
        let packages: Vec<String> = origin.split_once("\n\n")?.1.lines().map(ToOwned::to_owned).collect();
        if self.origin(&packages).ok()? != origin {
            return None;
        }
        // A commit that changes no source of the kit changes only the date.
        Some(Kit { date: date::of_sources(), ..Kit::from_entries(content)? })
    }

    /// Inputs of a kit: the compiler's version, a digest of sources and build settings, and the
    /// folders of our packages. Versions of all other packages are in `Cargo.lock`.
    fn origin(&self, packages: &[String]) -> io::Result<String> {
        let mut digest = MAKERS.iter().fold(EMPTY, |digest, text| extended(digest, text));
        let mut files = vec![self.workspace.join("Cargo.lock"), self.workspace.join("Cargo.toml")];
        for package in packages {
            let folder = self.workspace.join(package);
            files.push(folder.join("Cargo.toml"));
            add_files(&folder.join("src"), &mut files)?;
        }
        for file in files {
            let name = file.strip_prefix(&self.workspace).unwrap_or(&file);
            digest = extended(digest, name.to_string_lossy().as_bytes());
            digest = extended(digest, &fs::read(&file)?);
        }
        Ok(format!("{}{digest:016x}\n\n{}\n", self.compiler, packages.join("\n")))
    }
}

/// A kit as the content of an archive, with its origin.
fn kept_as(kit: &Kit, origin: String) -> archive::Content {
    let mut content = kit.entries();
    content.insert(ORIGIN.to_owned(), origin.into_bytes());
    content
}

/// Adds every file below a folder, in the same order on every machine.
fn add_files(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    let mut entries: Vec<_> = fs::read_dir(folder)?.collect::<io::Result<_>>()?;
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        if entry.file_type()?.is_dir() {
            add_files(&entry.path(), files)?;
        } else {
            files.push(entry.path());
        }
    }
    Ok(())
}

/// Version text of the compiler. The text is empty if the compiler cannot be run; cargo then
/// reports the error.
fn compiler() -> String {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let asked = Command::new(rustc).arg("-vV").current_dir(workspace()).stderr(Stdio::null()).output();
    asked.map(|output| String::from_utf8_lossy(&output.stdout).into_owned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::archive::Content;
    use std::cell::Cell;

    /// A cache over sources of two packages, with the number of kits made.
    fn shelf(folder: &Path) -> Shelf {
        for (name, text) in
            [("Cargo.lock", "lock"), ("Cargo.toml", "all"), ("a/Cargo.toml", "a"), ("a/src/lib.rs", "1")]
        {
            archive::write_file(&folder.join(name), text.as_bytes()).unwrap();
        }
        let file = folder.join("target/kit.zip");
        Shelf { file, workspace: folder.to_owned(), compiler: "rustc 1\n".into() }
    }

    fn keep(shelf: &Shelf) {
        let kit = Kit {
            binaries: Binaries::own(b"library".to_vec()),
            licences: Content::from([("a/LICENSE".to_owned(), b"text".to_vec())]),
            date: None,
        };
        let origin = shelf.origin(&["a".to_owned()]).unwrap();
        archive::write(&kept_as(&kit, origin), &shelf.file).unwrap();
    }

    #[test]
    fn invariant_a_kept_kit_is_what_was_made_and_no_compiler_is_called() {
        let folder = tempfile::tempdir().unwrap();
        let shelf = shelf(folder.path());
        keep(&shelf);
        let made = Cell::new(false);
        let make = || {
            made.set(true);
            Ok((Binaries::default(), Vec::new()))
        };
        let (kit, left_out) = shelf.kit(make).unwrap();
        assert!(!made.get() && left_out.is_empty());
        assert_eq!(kit.binaries, Binaries::own(b"library".to_vec()));
        assert_eq!(kit.licences["a/LICENSE"], b"text");
    }

    #[test]
    fn invariant_whatever_goes_into_a_kit_makes_the_kept_one_old() {
        let folder = tempfile::tempdir().unwrap();
        let kept = shelf(folder.path());
        let changes: [(&str, Option<&str>); 6] = [
            ("Cargo.lock", Some("another lock")),
            ("Cargo.toml", Some("another profile")),
            ("a/Cargo.toml", Some("another dependency")),
            ("a/src/lib.rs", Some("2")),
            ("a/src/new/inner.rs", Some("")),
            ("a/src/lib.rs", None),
        ];
        for (name, text) in changes {
            let shelf = shelf(folder.path());
            keep(&shelf);
            assert!(shelf.kept().is_some(), "before {name}");
            match text {
                Some(text) => archive::write_file(&folder.path().join(name), text.as_bytes()).unwrap(),
                None => fs::remove_file(folder.path().join(name)).unwrap(),
            }
            assert!(shelf.kept().is_none(), "after {name}");
        }
        shelf(folder.path());
        keep(&kept);
        let newer = Shelf { compiler: "rustc 2\n".into(), ..kept.clone() };
        assert!(newer.kept().is_none());
        // A damaged and a missing cache are both ignored.
        fs::write(&kept.file, b"no archive").unwrap();
        assert!(kept.kept().is_none());
        fs::remove_file(&kept.file).unwrap();
        assert!(kept.kept().is_none());
    }
}
