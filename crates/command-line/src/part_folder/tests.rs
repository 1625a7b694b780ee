use super::*;
use crate::long_study::{LongStudy, StudyKind};
use crate::manifest::Invocation;
use vibro_studies::basin::BasinRequest;
use vibro_studies::paper::ParameterSet;
use vibro_studies::paper::basin::{InitialValueRange, in_the_middle};
use vibro_studies::parts::{Shard, Task};

/// The manifest of a study with `discard` discarded periods.
fn manifest(discard: u32) -> Manifest {
    let axis = |text: &str| text.parse::<InitialValueRange>().unwrap().cells(32);
    let kind = StudyKind::Basin(BasinRequest {
        x: axis("x1=-1:1"),
        y: axis("v2=-1:1"),
        discard,
        start: in_the_middle(),
    });
    let options = [("discard".to_owned(), discard.to_string())].into();
    let command_line = format!("vibro basin --discard {discard}");
    let invocation = Invocation { command: "basin".into(), command_line, options };
    Manifest::of_parts(&LongStudy::new("basin", kind, &ParameterSet::basic()), &invocation)
}

fn open(folder: &Path, discarded_periods: u32) -> Result<PartFolder> {
    PartFolder::open(folder, &manifest(discarded_periods), false)
}

fn square(index: usize) -> vibro_studies::Result<usize> {
    Ok(index * index)
}

#[test]
fn parts_of_shards_come_together_in_one_folder() {
    let base = tempfile::tempdir().unwrap();
    let all = open(&base.path().join("all"), 1).unwrap();
    for index in 0..3 {
        let folder = base.path().join(format!("shard{index}"));
        let store = open(&folder, 1).unwrap();
        let task = Task { store: &store, shard: Shard { index, count: 3 }, ..Task::ALL };
        assert_eq!(task.complete(10, square).unwrap(), None);
        let missing = all.missing(10);
        all.take_over(&folder).unwrap();
        assert!(all.missing(10) < missing);
    }
    let nothing = |_| -> vibro_studies::Result<usize> { panic!("all parts are there") };
    let whole = Task { store: &all, ..Task::ALL }.complete(10, nothing).unwrap().unwrap();
    assert_eq!(whole, (0..10).map(|i| i * i).collect::<Vec<_>>());
}

#[test]
fn a_damaged_part_is_computed_again() {
    let base = tempfile::tempdir().unwrap();
    let store = open(&base.path().join("parts"), 1).unwrap();
    Task { store: &store, ..Task::ALL }.complete(4, square).unwrap();
    std::fs::write(store.path(3), []).unwrap();
    let again = Task { store: &store, ..Task::ALL }.complete(4, square).unwrap().unwrap();
    assert_eq!(again, [0, 1, 4, 9]);
}

#[test]
fn parts_of_another_study_are_refused_and_kept_unless_discarded() {
    let base = tempfile::tempdir().unwrap();
    let folder = base.path().join("parts");
    let store = open(&folder, 1).unwrap();
    Task { store: &store, ..Task::ALL }.complete(3, square).unwrap();
    drop(store);
    assert_eq!(open(&folder, 1).unwrap().missing(3), 0);
    let error = open(&folder, 2).unwrap_err();
    let text = error.to_string();
    assert!(error.is_usage() && text.contains("holds 3 of 8 finished parts"), "{text}");
    for word in ["--discard: 1 there, 2 here", "vibro basin --discard 1", "--discard-unfinished"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    assert_eq!(open(&folder, 1).unwrap().missing(3), 0);
    assert_eq!(PartFolder::open(&folder, &manifest(2), true).unwrap().missing(3), 3);
}

#[test]
fn parts_of_another_form_are_refused_and_kept_unless_discarded() {
    let base = tempfile::tempdir().unwrap();
    let folder = base.path().join("parts");
    let store = open(&folder, 1).unwrap();
    Task { store: &store, ..Task::ALL }.complete(3, square).unwrap();
    drop(store);
    // The manifest of a build that did not write the form.
    let path = folder.join(MANIFEST);
    let text = std::fs::read_to_string(&path).unwrap();
    let older = text.replace(&format!("format = {FORMAT}\n"), "");
    assert!(older != text);
    std::fs::write(&path, older).unwrap();
    let read = PartFolder::manifest(&folder).unwrap();
    // Opened by this program, and by a merge of such shards.
    for asked in [&manifest(1), &read] {
        let error = PartFolder::open(&folder, asked, false).unwrap_err();
        let text = error.to_string();
        assert!(error.is_usage(), "{text}");
        for word in ["3 finished parts in form 1", &format!("writes form {FORMAT}"), "--discard-unfinished"] {
            assert!(text.contains(word), "{word}: {text}");
        }
        assert_eq!(PartFolder::kept(&folder), 3);
    }
    assert_eq!(PartFolder::open(&folder, &manifest(1), true).unwrap().missing(3), 3);
}

#[test]
fn a_manifest_of_another_form_that_cannot_be_read_says_which() {
    let base = tempfile::tempdir().unwrap();
    let folder = base.path().join("parts");
    drop(open(&folder, 1).unwrap());
    let path = folder.join(MANIFEST);
    let text = std::fs::read_to_string(&path).unwrap();
    let unreadable = text.replace("discard = 1\n", "discard = \"many\"\n");
    assert!(unreadable != text);
    let older = unreadable.replace(&format!("format = {FORMAT}\n"), "format = 2\n");
    for (manifest, word) in [(&unreadable, "damaged"), (&older, "in form 2, but this version of vibro")] {
        std::fs::write(&path, manifest).unwrap();
        let error = open(&folder, 1).unwrap_err();
        assert!(error.is_usage() && error.to_string().contains(word), "{error}");
    }
}

#[test]
fn a_folder_belongs_to_one_program_at_a_time() {
    let base = tempfile::tempdir().unwrap();
    let first = open(base.path(), 1).unwrap();
    let error = open(base.path(), 1).unwrap_err();
    assert!(error.is_usage() && error.to_string().contains("another vibro"), "{error}");
    drop(first);
    open(base.path(), 1).unwrap();
}

#[test]
fn files_of_others_are_never_removed() {
    let base = tempfile::tempdir().unwrap();
    let (damaged, foreign, mixed) = (base.path().join("a"), base.path().join("b"), base.path().join("c"));
    std::fs::create_dir_all(&damaged).unwrap();
    std::fs::create_dir_all(&foreign).unwrap();
    std::fs::write(damaged.join(MANIFEST), "half a manif").unwrap();
    std::fs::write(damaged.join("00000.part"), "a part").unwrap();
    std::fs::write(foreign.join("thesis.tex"), "years").unwrap();
    for folder in [&damaged, &foreign] {
        let before = entries(folder).unwrap();
        let error = PartFolder::open(folder, &manifest(1), true).unwrap_err();
        assert!(error.is_usage() && error.to_string().contains("was not changed"), "{error}");
        assert_eq!(entries(folder).unwrap(), before);
    }
    let store = open(&mixed, 1).unwrap();
    std::fs::write(mixed.join("notes.txt"), "mine").unwrap();
    store.save(0, &[0]).unwrap();
    store.remove().unwrap();
    assert_eq!(entries(&mixed).unwrap(), [mixed.join("notes.txt")]);
}

#[test]
fn a_folder_that_cannot_be_written_is_no_usage_error() {
    let base = tempfile::tempdir().unwrap();
    let store = open(&base.path().join("parts"), 1).unwrap();
    std::fs::remove_dir_all(&store.folder).unwrap();
    let error = Task { store: &store, ..Task::ALL }.complete(1, square).unwrap_err();
    let error = Error::from(error);
    assert!(
        error.to_string().contains("cannot be written: there is no folder") && !error.is_usage(),
        "{error}"
    );
}
