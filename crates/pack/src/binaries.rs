//! Compiled libraries and their folders in archives.

use crate::archive::Content;
use fmi_doors::Version;
use std::collections::BTreeMap;

/// A platform, named as in archives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PackedPlatform {
    /// Folder under `binaries/`: the FMI 2.0 name for x86; for other processors the FMI 3.0
    /// platform tuple, as in FMI 2.0.4 (2.3).
    pub folder: &'static str,
    /// Folder under `binaries/` in FMI 3.0 (2.5.1.4.1): the platform tuple.
    pub tuple: &'static str,
    /// Suffix of the library's name.
    pub ending: &'static str,
}

const fn place(folder: &'static str, tuple: &'static str, ending: &'static str) -> PackedPlatform {
    PackedPlatform { folder, tuple, ending }
}

/// Platforms for which libraries are packed; [`PackedPlatform::OWN`] may be a further one.
pub const PACKED_PLATFORMS: [PackedPlatform; 7] = [
    place("linux64", "x86_64-linux", ".so"),
    place("win64", "x86_64-windows", ".dll"),
    // Hosts on Apple's own processors look in this folder too.
    place("darwin64", "x86_64-darwin", ".dylib"),
    place("aarch64-darwin", "aarch64-darwin", ".dylib"),
    place("aarch64-linux", "aarch64-linux", ".so"),
    place("linux32", "x86-linux", ".so"),
    place("win32", "x86-windows", ".dll"),
];

/// The component of the layered standard for WebAssembly, which runs on any platform. It has the
/// functions of FMI 3.0 only.
pub const WASM_COMPONENT: PackedPlatform = place("wasm32-wasip2", "wasm32-wasip2", ".wasm");

/// Folder in which hosts on this platform look for the binary in an FMI 2.0 archive (2.3). It
/// depends only on operating system and pointer width, not on the processor.
pub const PLATFORM: &str = match (cfg!(target_os = "windows"), cfg!(target_os = "macos"), usize::BITS) {
    (true, _, 64) => "win64",
    (true, _, _) => "win32",
    (_, true, _) => "darwin64",
    (_, _, 64) => "linux64",
    _ => "linux32",
};

/// Folder of this platform's binary in an FMI 3.0 archive (2.5.1.4.1): processor and system.
pub const PLATFORM_TUPLE: &str = match (std::env::consts::ARCH.as_bytes(), std::env::consts::OS.as_bytes()) {
    (b"x86_64", b"windows") => "x86_64-windows",
    (b"x86_64", b"macos") => "x86_64-darwin",
    (b"x86_64", _) => "x86_64-linux",
    (b"aarch64", b"windows") => "aarch64-windows",
    (b"aarch64", b"macos") => "aarch64-darwin",
    (b"aarch64", _) => "aarch64-linux",
    (_, b"windows") => "x86-windows",
    _ => "x86-linux",
};

/// Suffix of a shared library's name on this platform, with its dot.
pub const SHARED_LIBRARY: &str = std::env::consts::DLL_SUFFIX;

/// This platform.
const OWN: PackedPlatform = place(PLATFORM, PLATFORM_TUPLE, SHARED_LIBRARY);

/// Path in an archive of a model's binary for a platform.
pub fn binary_path(version: Version, model_identifier: &str, place: PackedPlatform) -> String {
    format!("binaries/{}/{model_identifier}{}", place.in_archive(version), place.ending)
}

impl PackedPlatform {
    /// This platform.
    pub const OWN: Self = OWN;

    /// The folder of a platform under `binaries/`: its name in FMI 2.0, or its tuple in FMI 3.0.
    pub fn in_archive(self, version: Version) -> &'static str {
        if version == Version::Fmi2 { self.folder } else { self.tuple }
    }

    /// Whether archives of a version have binaries for this platform.
    fn is_in(self, version: Version) -> bool {
        self != WASM_COMPONENT || version == Version::Fmi3
    }
}

/// Compiled libraries by platform; FMI 2.0 and 3.0 archives have different folders for them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Binaries(Vec<(PackedPlatform, Vec<u8>)>);

impl FromIterator<(PackedPlatform, Vec<u8>)> for Binaries {
    fn from_iter<T: IntoIterator<Item = (PackedPlatform, Vec<u8>)>>(libraries: T) -> Self {
        Self(libraries.into_iter().collect())
    }
}

impl Binaries {
    /// One library, for this platform.
    pub fn own(bytes: Vec<u8>) -> Self {
        Self(vec![(OWN, bytes)])
    }

    /// The libraries and the component of the layered standard for WebAssembly.
    #[must_use]
    pub fn with_component(mut self, component: Vec<u8>) -> Self {
        self.0.retain(|(place, _)| *place != WASM_COMPONENT);
        self.0.push((WASM_COMPONENT, component));
        self
    }

    /// Whether the archive of a version has the component for WebAssembly.
    pub fn has_component(&self, version: Version) -> bool {
        self.places(version).any(|place| place == WASM_COMPONENT)
    }

    /// Platforms in the archive of a version.
    fn places(&self, version: Version) -> impl Iterator<Item = PackedPlatform> {
        self.0.iter().map(|(place, _)| *place).filter(move |place| place.is_in(version))
    }

    /// The libraries for some platforms, given by their FMI 3.0 tuples.
    #[must_use]
    pub fn only(&self, tuples: &[&str]) -> Self {
        self.0.iter().filter(|(place, _)| tuples.contains(&place.tuple)).cloned().collect()
    }

    /// The libraries with their FMI 3.0 tuples.
    pub fn folders(&self) -> impl Iterator<Item = (&'static str, &[u8])> {
        self.0.iter().map(|(place, bytes)| (place.tuple, &**bytes))
    }

    /// Inverse of [`folders`](Self::folders); `None` for an unknown tuple.
    pub fn from_folders(libraries: BTreeMap<String, Vec<u8>>) -> Option<Self> {
        // A web page has no platform of its own.
        let own = Some(OWN).filter(|_| !cfg!(target_family = "wasm"));
        let all = || own.into_iter().chain(PACKED_PLATFORMS).chain([WASM_COMPONENT]);
        let known = |name: &str| all().find(|place| place.tuple == name);
        libraries.into_iter().map(|(name, bytes)| Some((known(&name)?, bytes))).collect()
    }

    /// Files of a model's binaries in an archive: path and bytes.
    pub fn of(&self, version: Version, model_identifier: &str) -> Content {
        self.0
            .iter()
            .filter(|(place, _)| place.is_in(version))
            .map(|(at, bytes)| (binary_path(version, model_identifier, *at), bytes.clone()))
            .collect()
    }

    /// Names of the folders in the archive of a version, this platform's first.
    pub fn names(&self, version: Version) -> Vec<&'static str> {
        let (own, others): (Vec<PackedPlatform>, _) =
            self.places(version).partition(|place| place.tuple == PLATFORM_TUPLE);
        own.into_iter().chain(others).map(|place| place.in_archive(version)).collect()
    }
}
