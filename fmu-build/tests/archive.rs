//! The archive: the same content gives the same bytes, and reads back as written.

use fmu_build::archive::{self, Content};
use fmu_build::package;
use fmu_build::platforms::Binaries;
use fmu_build::version::Version;
use vibro_pack::Error;

fn content() -> Content {
    Content::from([
        ("modelDescription.xml".to_owned(), b"<x/>".to_vec()),
        ("binaries/linux64/x.so".to_owned(), (0..=255).cycle().take(10_000).collect()),
    ])
}

#[test]
fn what_is_written_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("new/folder/x.fmu");
    archive::write(&content(), &path).unwrap();
    for (name, bytes) in content() {
        assert_eq!(archive::read(&path, &name).unwrap(), bytes);
    }
    assert!(matches!(archive::read(&path, "model.png"), Err(Error::Missing { .. })));
    assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1, "nothing temporary is left");
}

#[test]
fn no_archive_is_an_error_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.fmu");
    assert!(archive::read(&path, "x").unwrap_err().to_string().contains("x.fmu"));
    std::fs::write(&path, "no archive").unwrap();
    assert!(matches!(archive::read(&path, "x"), Err(Error::Archive { .. })));
}

/// Times, permissions and order could differ between two builds.
#[test]
fn entries_carry_nothing_of_the_moment() {
    let bytes = archive::to_bytes(&content()).unwrap();
    let mut zip = zip::ZipArchive::new(std::io::Cursor::new(&bytes)).unwrap();
    let mut names = Vec::new();
    for i in 0..zip.len() {
        let entry = zip.by_index(i).unwrap();
        let time = entry.last_modified().unwrap();
        assert_eq!((time.year(), time.month(), time.day(), time.hour()), (1980, 1, 1, 0));
        let name = entry.name().unwrap().into_owned();
        let mode = if name.starts_with("binaries/") { 0o755 } else { 0o644 };
        assert_eq!(entry.unix_mode().unwrap() & 0o777, mode);
        names.push(name);
    }
    assert!(names.is_sorted(), "{names:?}");
}

/// Everything except the binary, which has a separate test.
#[test]
fn packing_twice_gives_the_same_bytes() {
    let binaries = || Binaries::own(vec![7; 10_000]);
    for version in Version::ALL {
        let pack = || archive::to_bytes(&package::content(version, &binaries(), None).unwrap()).unwrap();
        assert!(pack() == pack(), "{version:?}");
    }
}
