//! The archives as ZIP files, parsed byte by byte by a reader independent of the writer's crate:
//! rules of FMI 3.0.2, 2.5.

use fmu_build::platforms::Binaries;
use fmu_build::version::Version;
use fmu_build::{archive, explorer, package};
use std::collections::BTreeSet;

/// A reader of little-endian numbers.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn u16(&self, at: usize) -> u16 {
        u16::from_le_bytes([self.0[at], self.0[at + 1]])
    }
    fn u32(&self, at: usize) -> u32 {
        u32::from(self.u16(at)) | u32::from(self.u16(at + 2)) << 16
    }
}

/// Data of an entry in the central directory (APPNOTE.TXT, 4.3.12).
struct Entry {
    name: String,
    made_by: u16,
    needed: u16,
    flags: u16,
    method: u16,
    disk: u16,
    external: u32,
    local: usize,
}

fn entries(zip: &[u8]) -> Vec<Entry> {
    let bytes = Bytes(zip);
    // The end of the central directory: 22 bytes without a comment.
    let end = zip.len() - 22;
    assert_eq!(bytes.u32(end), 0x0605_4b50, "an archive with a comment, or none");
    assert_eq!((bytes.u16(end + 4), bytes.u16(end + 6)), (0, 0), "a split archive");
    let (count, mut at) = (bytes.u16(end + 10), bytes.u32(end + 16) as usize);
    let mut found = Vec::new();
    for _ in 0..count {
        assert_eq!(bytes.u32(at), 0x0201_4b50);
        let (name, extra, comment) = (bytes.u16(at + 28), bytes.u16(at + 30), bytes.u16(at + 32));
        let begin = at + 46;
        found.push(Entry {
            name: String::from_utf8(zip[begin..begin + usize::from(name)].to_vec()).unwrap(),
            made_by: bytes.u16(at + 4),
            needed: bytes.u16(at + 6),
            flags: bytes.u16(at + 8),
            method: bytes.u16(at + 10),
            disk: bytes.u16(at + 34),
            external: bytes.u32(at + 38),
            local: bytes.u32(at + 42) as usize,
        });
        at = begin + usize::from(name) + usize::from(extra) + usize::from(comment);
    }
    assert_eq!(at, end, "something between directory and its end: a ZIP64 archive");
    found
}

/// Kind of file in the upper half of a Unix entry's attributes.
const KIND: u32 = 0o170_000;
const REGULAR: u32 = 0o100_000;

#[test]
fn archives_keep_the_rules_of_the_standard() {
    const DEFLATE: u16 = 8;
    const STORE: u16 = 0;
    const ENCRYPTED: u16 = 1;
    const DESCRIPTOR: u16 = 8;
    for version in Version::ALL {
        let content = package::content(version, &Binaries::own(vec![7; 10_000]), None).unwrap();
        let zip = archive::to_bytes(&content).unwrap();
        let (bytes, entries) = (Bytes(&zip), entries(&zip));
        let names: BTreeSet<&str> = entries.iter().map(|entry| entry.name.as_str()).collect();
        assert_eq!(names.len(), entries.len(), "a name twice");
        assert_eq!(names, content.keys().map(String::as_str).collect());
        for entry in &entries {
            let name = &entry.name;
            assert!(entry.method == DEFLATE || entry.method == STORE, "{name}");
            assert!(entry.needed & 0xff <= 20, "{name} needs version {}", entry.needed);
            assert_eq!(entry.flags & ENCRYPTED, 0, "{name}");
            assert!(entry.flags & DESCRIPTOR == 0 || entry.method == DEFLATE, "{name}");
            assert_eq!(entry.disk, 0, "{name}");
            // Made on Unix: the kind of file is in the upper half of its attributes; links are of
            // another kind.
            assert_eq!(entry.made_by >> 8, 3, "{name}");
            let kind = (entry.external >> 16) & KIND;
            assert!(kind == REGULAR || kind == 0, "{name}: {kind:o}");
            assert!(name.is_ascii() && !name.contains('\\') && !name.starts_with('/'), "{name}");
            assert!(!name.split('/').any(|part| part == ".." || part.is_empty()), "{name}");
            // The local header agrees with the central directory.
            assert_eq!(bytes.u32(entry.local), 0x0403_4b50, "{name}");
            let local = (bytes.u16(entry.local + 4), bytes.u16(entry.local + 6), bytes.u16(entry.local + 8));
            assert_eq!(local, (entry.needed, entry.flags, entry.method), "{name}");
        }
    }
}

/// The live page comes with the licences of its parts.
#[test]
fn archives_with_the_live_page_hold_it_and_its_licences() {
    for version in Version::USUAL {
        let content = package::content(version, &Binaries::own(vec![7]), Some(b"<!DOCTYPE html>")).unwrap();
        assert_eq!(content[explorer::PATH], b"<!DOCTYPE html>");
        let page = String::from_utf8(content["documentation/index.html"].clone()).unwrap();
        assert!(page.contains("href=\"explorer.html\""));
        for package in ["wasm-bindgen", "rayon", "nalgebra"] {
            let text = format!("/{package}-");
            assert!(
                content.keys().any(|name| name.contains("icenses/") && name.contains(&text)),
                "{package}"
            );
        }
    }
}

/// FMI 3.0.2, 2.5.1: the folders and files of these names, and no others at the top.
#[test]
fn archives_of_fmi3_have_its_structure() {
    for version in [Version::Fmi3, Version::Arrays, Version::Clocked] {
        let content = package::content(version, &Binaries::own(vec![7]), None).unwrap();
        let top: BTreeSet<&str> = content.keys().map(|name| name.split('/').next().unwrap()).collect();
        let allowed =
            ["binaries", "documentation", "extra", "modelDescription.xml", "resources", "terminalsAndIcons"];
        assert_eq!(top, allowed.into());
        for name in [
            "documentation/index.html",
            "documentation/diagram.png",
            "documentation/diagram.svg",
            "documentation/externalDependencies.txt",
            "documentation/licenses/license.txt",
            "terminalsAndIcons/icon.png",
            "terminalsAndIcons/icon.svg",
            "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml",
        ] {
            assert!(content.contains_key(name), "{name}");
        }
        assert!(content.contains_key(&version.own_binary()));
    }
}
