//! Archives from a kit in memory: the kit's entries are copied in compressed form, which saves
//! most of the time.

use crate::archive::{self, Content};
use crate::content::content;
use crate::error::{Error, Result};
use crate::kit::{DATE, KIT_FILE, Kit};
use fmi_doors::Version;
use std::io::{Cursor, Read};
use std::path::Path;
use vibro_machine_component::Plan;
use zip::ZipArchive;

/// The archive of a machine for an FMI version, made from the bytes of a kit file. It has the
/// entries of [`content()`] with the same bytes.
///
/// # Errors
/// [`Error::Archive`], [`Error::Missing`] if `kit` is not a kit; otherwise as [`content()`].
pub fn around(version: Version, plan: &Plan, kit: &[u8]) -> Result<Vec<u8>> {
    let mut held = opened(kit)?;
    // A kit with each entry's name instead of its bytes.
    let named = named(&mut held)?;
    let mut entries = content(version, plan, &named)?;
    let borrowed: Vec<String> = entries.keys().filter(|name| is_borrowed(name)).cloned().collect();
    let taken = |name: String| {
        let of = String::from_utf8_lossy(&entries.remove(&name).unwrap_or_default()).into_owned();
        (name, of)
    };
    let borrowed = borrowed.into_iter().map(taken).collect();
    archive::to_bytes_with(&entries, &borrowed, &mut held)
}

/// FMI 3.0 tuples of the platforms in a kit file.
///
/// # Errors
/// [`Error::Archive`], [`Error::Missing`] if `kit` is not a kit.
pub fn platforms_of(kit: &[u8]) -> Result<Vec<&'static str>> {
    Ok(named(&mut opened(kit)?)?.binaries.folders().map(|(tuple, _)| tuple).collect())
}

/// Whether an entry of an archive comes from the kit.
fn is_borrowed(name: &str) -> bool {
    ["binaries/", "licenses/", "documentation/licenses/"].iter().any(|folder| name.starts_with(folder))
}

fn opened(kit: &[u8]) -> Result<ZipArchive<Cursor<&[u8]>>> {
    ZipArchive::new(Cursor::new(kit)).map_err(|source| Error::Archive { path: KIT_FILE.into(), source })
}

fn named(held: &mut ZipArchive<Cursor<&[u8]>>) -> Result<Kit> {
    let failed = |source| Error::Archive { path: KIT_FILE.into(), source };
    let mut entries = Content::new();
    for i in 0..held.len() {
        let mut entry = held.by_index(i).map_err(failed)?;
        let name = entry.name().map_err(failed)?.into_owned();
        let mut bytes = name.clone().into_bytes();
        if name == DATE {
            bytes.clear();
            entry.read_to_end(&mut bytes).map_err(|e| failed(e.into()))?;
        }
        entries.insert(name, bytes);
    }
    let kit = Kit::from_entries(entries).filter(|kit| kit.binaries.folders().next().is_some());
    kit.ok_or_else(|| Error::Missing { path: Path::new(KIT_FILE).into(), name: "binaries/PLATFORM".into() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibro_machine::file::{no_records, parse};

    const BALL: &str = "name = \"Ball\"\ngravity = 9.81\nbody.b = { mass = 1.0, gravity = 1.0 }\n\
        stop.floor = { between = [\"ground\", \"b\"], gap = 1.0, restitution = 0.9 }\n";

    #[test]
    fn second_method_entries_around_a_kit_in_memory_are_those_of_the_packager() {
        let kit = Kit {
            binaries: crate::PACKED_PLATFORMS
                .into_iter()
                .map(|place| (place, place.tuple.repeat(99).into()))
                .collect::<crate::Binaries>()
                .with_component(b"component".to_vec()),
            licences: Content::from([
                ("a/LICENSE".to_owned(), b"text".to_vec()),
                (crate::LICENCE_LIST.to_owned(), b"list".to_vec()),
            ]),
            date: Some("2026-01-01T00:00:00Z".into()),
        };
        let file = archive::to_bytes(&kit.entries()).unwrap();
        assert_eq!(platforms_of(&file).unwrap().len(), crate::PACKED_PLATFORMS.len() + 1);
        let plan = Plan::of(&parse(BALL, "ball.toml", &no_records).unwrap()).unwrap();
        for version in [Version::Fmi2, Version::Fmi3] {
            let packed = around(version, &plan, &file).unwrap();
            let found = archive::of(Cursor::new(packed), Path::new("in memory")).unwrap();
            assert!(found == content(version, &plan, &kit).unwrap());
            // The component has the functions of FMI 3.0 only.
            let wasm = ["binaries/wasm32-wasip2/Ball.wasm", "extra/org.modelica.fmi-ls-wasm/manifest.xml"];
            assert!(wasm.iter().all(|name| found.contains_key(*name) == (version == Version::Fmi3)));
        }
        let none = archive::to_bytes(&Content::from([("a.txt".to_owned(), Vec::new())])).unwrap();
        assert!(matches!(platforms_of(&none), Err(Error::Missing { .. })));
        assert!(matches!(platforms_of(b"no archive"), Err(Error::Archive { .. })));
    }
}
