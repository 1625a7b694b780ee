//! The release command: it refuses disagreements in sources and build results; the notes; and, on
//! request, the whole (`cargo test -p fmu-build --test release -- --ignored --nocapture`).

mod common;

use flate2::Compression;
use flate2::write::GzEncoder;
use fmu_build::archive::{self, Content};
use fmu_build::compile::workspace;
use fmu_build::kit::{KIT_FILE, Kit};
use fmu_build::platforms::Binaries;
use fmu_build::release::agreement::{Agreed, Intent, agreed};
use fmu_build::release::changelog::{self, ChangelogSection};
use fmu_build::release::contents::{archive_of, disagreements};
use fmu_build::release::notes::{Part, notes};
use fmu_build::release::wheels::{self, ENTRY, WHEELS, WheelPlatform, sdist_file};
use fmu_build::release::{NOTES, SUMS, machines};
use fmu_build::version::Version;
use fmu_build::{compile, licences};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::time::{Duration, SystemTime};
use vibro_pack::{PACKED_PLATFORMS, PackedPlatform};
use vibro_paper_component::component::identity::VERSION;
use vibro_paper_component::fmi2::description::guid;
use vibro_paper_component::fmi3::description::{MAIN, instantiation_token};

/// Files by which the software is cited, archived and packaged by others.
const CITED: [&str; 5] =
    ["CITATION.cff", "codemeta.json", ".zenodo.json", "python/conda/meta.yaml", "docs/paper/paper.md"];
/// The day of the release in the copies.
const DAY: &str = "2026-01-31";

/// Files of the workspace that must agree in some fact.
fn files_that_agree() -> Vec<String> {
    let named = ["Cargo.toml", "CHANGELOG.md", "python/pyproject.toml"].into_iter().chain(CITED);
    let named = named.map(str::to_owned);
    let descriptions = ["modelDescription", "fmi3"].map(|name| format!("modelDescription/{name}.xml"));
    let manifest: toml::Table = fs::read_to_string(workspace().join("Cargo.toml")).unwrap().parse().unwrap();
    let members = manifest["workspace"]["members"].as_array().unwrap().iter();
    let members = members.map(|member| format!("{}/Cargo.toml", member.as_str().unwrap()));
    named.chain(descriptions).chain(members).collect()
}

/// A copy of these files whose changes belong to the version.
fn copy_to_be_released() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in files_that_agree() {
        let text = fs::read_to_string(workspace().join(&name)).unwrap();
        let is_dated = |line: &&str| {
            ["date-released", "dateModified", "publication_date"].iter().any(|key| line.contains(key))
        };
        let stated = text
            .lines()
            .find(is_dated)
            .and_then(|line| line.split(['"', ' ', ',']).find(|word| word.starts_with("20")));
        let text = stated.map_or(text.clone(), |day| text.replace(day, DAY));
        archive::write_file(&folder.path().join(&name), text.as_bytes()).unwrap();
    }
    let changes =
        format!("# Changelog\n\n## [Unreleased]\n\n## [{VERSION}] - {DAY}\n\n### Added\n- Everything.\n");
    fs::write(folder.path().join("CHANGELOG.md"), changes).unwrap();
    folder
}

fn refused(folder: &Path, intent: &Intent) -> String {
    agreed(folder, intent).map(|found| format!("agreed: {found:?}")).unwrap_or_else(|error| error.to_string())
}

#[test]
fn sources_that_agree_are_released() {
    let folder = copy_to_be_released();
    let intent = Intent { tag: Some(format!("v{VERSION}")), preview: false };
    let found = agreed(folder.path(), &intent).unwrap();
    assert_eq!(found.version, VERSION);
    assert_eq!(found.changes.text, "### Added\n- Everything.");
    assert_eq!(found.changes.date.as_deref(), Some("2026-01-31"));
    // The workspace itself, whatever the state of its changelog and work tree.
    agreed(workspace(), &Intent { tag: None, preview: true }).unwrap();
}

#[test]
fn each_altered_copy_of_the_sources_is_refused_by_name() {
    let (guid, main) = (guid(), instantiation_token(MAIN));
    let (version, in_xml) = (format!("version = \"{VERSION}\""), format!(" version=\"{VERSION}\""));
    let section = format!("## [{VERSION}] - {DAY}");
    let required = format!("version = \"{VERSION}\" }}");
    let other = "{00000000-0000-0000-0000-000000000000}";
    let alterations: [(&str, &str, &str, &str); 25] = [
        ("Cargo.toml", &version, "version = \"7.0.0\"", "was compiled from"),
        (
            "crates/paper-component/Cargo.toml",
            "version.workspace = true",
            "version = \"7.0.0\"",
            "crates/paper-component/Cargo.toml",
        ),
        ("python/Cargo.toml", "version.workspace = true", "version = \"7.0.0\"", "python/Cargo.toml"),
        ("python/pyproject.toml", "dynamic = [\"version\"]", "version = \"7.0.0\"", "python/pyproject.toml"),
        ("Cargo.toml", &required, "version = \"7.0.0\" }", "is required in version 7.0.0"),
        ("CITATION.cff", VERSION, "7.0.0", "CITATION.cff: version \"7.0.0\""),
        (
            "CITATION.cff",
            DAY,
            "2026-02-01",
            "CITATION.cff: date-released \"2026-02-01\", expected \"2026-01-31\"",
        ),
        ("CITATION.cff", "title: ", "name: ", "codemeta.json: name"),
        ("codemeta.json", VERSION, "7.0.0", "codemeta.json: version \"7.0.0\""),
        ("codemeta.json", "text files", "files", "codemeta.json: description"),
        ("codemeta.json", "{", "", "codemeta.json: text"),
        (".zenodo.json", DAY, "2026-02-01", ".zenodo.json: publication_date"),
        (".zenodo.json", "periodic orbits", "orbits", ".zenodo.json: title"),
        ("python/conda/meta.yaml", VERSION, "7.0.0", "python/conda/meta.yaml: version"),
        ("docs/paper/paper.md", "periodic orbits", "orbits", "docs/paper/paper.md: title"),
        (
            "modelDescription/modelDescription.xml",
            &in_xml,
            " version=\"7.0.0\"",
            "modelDescription.xml: version",
        ),
        ("modelDescription/fmi3.xml", &in_xml, " version=\"7.0.0\"", "fmi3.xml: version"),
        ("modelDescription/modelDescription.xml", &guid, other, "modelDescription.xml: instantiation token"),
        ("modelDescription/fmi3.xml", &main, other, "fmi3.xml: instantiation token"),
        ("CHANGELOG.md", &section, "## [7.0.0] - 2026-01-31", "no section"),
        ("CHANGELOG.md", "- 2026-01-31", "", "has no day"),
        ("CHANGELOG.md", "2026-01-31", "2026-13-31", "has no day"),
        ("CHANGELOG.md", "### Added\n- Everything.", "", "has no text"),
        ("CHANGELOG.md", "[Unreleased]\n", "[Unreleased]\n- Nobody's.\n", "[Unreleased] has changes"),
        ("CHANGELOG.md", "[Unreleased]\n", "[7.0.0] - 2026-02-01\n- Later.\n", "is below [7.0.0]"),
    ];
    for (name, from, to, expected) in alterations {
        let folder = copy_to_be_released();
        let path = folder.path().join(name);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{name} has no {from}");
        fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let error = refused(folder.path(), &Intent::default());
        assert!(error.starts_with("no release:") && error.contains(expected), "{name} with {to}: {error}");
    }
}

#[test]
fn another_tag_and_an_uncommitted_work_tree_are_refused() {
    let folder = copy_to_be_released();
    let tag = Intent { tag: Some("v7.0.0".into()), preview: false };
    assert!(refused(folder.path(), &tag).contains(&format!("tag v7.0.0: expected v{VERSION}")));

    let git = |arguments: &[&str]| {
        let identity = ["-c", "user.name=test", "-c", "user.email=test@localhost"];
        let mut git = Command::new("git");
        common::python::run("git", git.args(identity).args(arguments).current_dir(folder.path()));
    };
    git(&["init", "--quiet"]);
    git(&["add", "."]);
    git(&["commit", "--quiet", "--message", "all"]);
    agreed(folder.path(), &Intent::default()).unwrap();
    fs::write(folder.path().join("new"), "").unwrap();
    assert!(refused(folder.path(), &Intent::default()).contains("not committed (1 files, the first: new)"));
    agreed(folder.path(), &Intent { tag: None, preview: true }).unwrap();
}

const CHANGELOG: &str = "# Changelog\n\n## [Unreleased]\n- Next.\n\n## [0.2.0] - 2026-03-01\n\n### Fixed\n- That.\n\n## [0.1.0] - 2026-01-31\n- First.\n";

#[test]
fn the_notes_have_the_section_of_the_version_and_a_preview_says_so() {
    // Only the version's changes: neither the next version's nor the previous version's.
    let released = changelog::of(&CHANGELOG.replace("- Next.\n", ""), "0.2.0", false).unwrap();
    assert_eq!(released.text, "### Fixed\n- That.");
    let part = Part { file: "x.fmu".into(), size: 1_234_567, what: "FMU".into(), tried: "ran".into() };
    let text = notes(&Agreed { version: "0.2.0".into(), changes: released }, &[part], &[]);
    assert!(text.starts_with("# vibro-impact 0.2.0, 2026-03-01\n"), "{text}");
    assert!(
        text.contains("| `x.fmu` | 1.23 | FMU | ran |\n")
            && text.ends_with("## Changes\n\n### Fixed\n- That.\n"),
        "{text}"
    );
    assert!(!text.contains("Left out"), "{text}");

    let preview = changelog::of(CHANGELOG, "0.3.0", true).unwrap();
    let expected = ChangelogSection { name: "Unreleased".into(), date: None, text: "- Next.".into() };
    assert_eq!(preview, expected);
    let text =
        notes(&Agreed { version: "0.3.0".into(), changes: preview }, &[], &["win64 is left out".into()]);
    assert!(text.contains("A preview, not a release") && text.contains("\n- win64 is left out\n"), "{text}");
    assert!(changelog::of(CHANGELOG, "0.3.0", false).unwrap_err().contains("--preview"));
}

/// A library with a single function and no dependencies.
fn module(folder: &Path, function: &str) -> Vec<u8> {
    let (source, library) = (folder.join("module.c"), folder.join("module.so"));
    fs::write(&source, format!("int {function}(void) {{ return 0; }}\n")).unwrap();
    let mut cc = Command::new("cc");
    common::python::run("cc", cc.args(["-shared", "-nostdlib", "-fPIC", "-o"]).arg(&library).arg(&source));
    fs::read(library).unwrap()
}

/// 1980-01-01 in seconds since 1970, as in the source distribution.
const DATE: u64 = 315_532_800;

/// A folder of both archives, a wheel for this machine and a source distribution, each with the
/// compared content.
struct Dist {
    folder: tempfile::TempDir,
    platform: WheelPlatform,
    wheel: Content,
    sdist: Content,
}

impl Dist {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let platform = *WHEELS.iter().find(|p| p.is_own()).expect("a machine for which there is a wheel");
        let about = format!("Metadata-Version: 2.4\nName: vibro-impact\nVersion: {VERSION}\n").into_bytes();
        let information = format!("vibro_impact-{VERSION}.dist-info");
        let tags: String = platform.tag.split('.').map(|tag| format!("Tag: cp39-abi3-{tag}\n")).collect();
        let mut wheel = Content::from([
            (format!("{information}/METADATA"), about.clone()),
            (format!("{information}/WHEEL"), tags.into_bytes()),
            (platform.module.to_owned(), module(folder.path(), ENTRY)),
        ]);
        for name in ["LICENSE-MIT", "LICENSE-APACHE"].iter().chain(&licences::OF_WHEEL) {
            wheel.insert(format!("{information}/licenses/{name}"), b"text".to_vec());
        }
        let mut sdist = Content::from([(format!("vibro_impact-{VERSION}/PKG-INFO"), about)]);
        static BUILT: OnceLock<PathBuf> = OnceLock::new();
        let built = BUILT.get_or_init(common::python::fmu);
        for version in Version::USUAL {
            let bytes = fs::read(version.beside(built)).unwrap();
            let path = archive_of(folder.path(), version);
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            wheel.insert(format!("vibro_impact/fmu/{name}"), bytes.clone());
            sdist.insert(format!("vibro_impact-{VERSION}/package/vibro_impact/fmu/{name}"), bytes.clone());
            fs::write(path, bytes).unwrap();
        }
        static KIT: OnceLock<PathBuf> = OnceLock::new();
        let kit = fs::read(KIT.get_or_init(common::python::kit)).unwrap();
        wheel.insert(format!("vibro_impact/fmu/{KIT_FILE}"), kit.clone());
        sdist.insert(format!("vibro_impact-{VERSION}/package/vibro_impact/fmu/{KIT_FILE}"), kit);
        Self { folder, platform, wheel, sdist }
    }

    /// Writes the packages and compares.
    fn disagreements(&self) -> Vec<String> {
        let wheel = self.folder.path().join(self.platform.file(VERSION));
        archive::write(&self.wheel, &wheel).unwrap();
        let file = fs::File::create(self.folder.path().join(sdist_file(VERSION))).unwrap();
        let mut tar = tar::Builder::new(GzEncoder::new(file, Compression::fast()));
        for (name, bytes) in &self.sdist {
            let mut header = tar::Header::new_gnu();
            header.set_size(bytes.len() as u64);
            header.set_mtime(DATE);
            tar.append_data(&mut header, name, bytes.as_slice()).unwrap();
        }
        tar.into_inner().unwrap().finish().unwrap();
        disagreements(self.folder.path(), VERSION).unwrap()
    }

    /// Rewrites an archive with one file altered.
    fn alter_archive(&self, version: Version, alter: impl Fn(&mut Content)) {
        let path = archive_of(self.folder.path(), version);
        let mut content = archive::read_all(&path).unwrap();
        alter(&mut content);
        archive::write(&content, &path).unwrap();
    }
}

#[test]
fn files_that_agree_are_released() {
    assert_eq!(Dist::new().disagreements(), [""; 0]);
}

/// Cargo compares modification times: with the times stored in the source distribution it would
/// reuse a build of other sources.
#[test]
fn unpacked_sources_are_newer_than_what_was_built_before() {
    let before = SystemTime::now() - Duration::from_secs(60); // disks have coarse clocks
    let dist = Dist::new();
    assert_eq!(dist.disagreements(), [""; 0]);
    let sdist = dist.folder.path().join(sdist_file(VERSION));
    let unpacked = wheels::unpack(&sdist, VERSION, &dist.folder.path().join("source")).unwrap();
    assert!(fs::metadata(unpacked.join("PKG-INFO")).unwrap().modified().unwrap() > before);
}

/// A kit file with a library for another platform.
fn other_kit() -> Vec<u8> {
    let other =
        PACKED_PLATFORMS.into_iter().find(|place| place.folder != PackedPlatform::OWN.folder).unwrap();
    let kit = Kit { binaries: [(other, b"library".to_vec())].into_iter().collect(), ..Kit::default() };
    archive::to_bytes(&kit.entries()).unwrap()
}

#[test]
fn each_altered_package_is_refused_by_name() {
    let information = format!("vibro_impact-{VERSION}.dist-info");
    let replace = |content: &mut Content, name: &str, from: &str, to: &str| {
        let text = String::from_utf8(content[name].clone()).unwrap();
        assert!(text.contains(from), "{name} has no {from}");
        content.insert(name.to_owned(), text.replace(from, to).into_bytes());
    };
    type Alteration<'a> = (&'a dyn Fn(&mut Dist), &'a str);
    let alterations: [Alteration<'_>; 10] = [
        (
            &|d| replace(&mut d.wheel, &format!("{information}/METADATA"), VERSION, "7.0.0"),
            "METADATA gives vibro-impact 7.0.0",
        ),
        (
            &|d| replace(&mut d.sdist, &format!("vibro_impact-{VERSION}/PKG-INFO"), VERSION, "7.0.0"),
            "PKG-INFO gives vibro-impact 7.0.0",
        ),
        (
            &|d| replace(&mut d.wheel, &format!("{information}/METADATA"), "2.4", "2.1"),
            "METADATA differs from PKG-INFO",
        ),
        (
            &|d| replace(&mut d.wheel, &format!("{information}/WHEEL"), "abi3-", "abi3-old_"),
            "differ from the tags in its name",
        ),
        (
            &|d| drop(d.wheel.insert("vibro_impact/fmu/VibroImpact3DOF.fmu".into(), Vec::new())),
            "vibro_impact/fmu/VibroImpact3DOF.fmu is not the archive next to it",
        ),
        (
            &|d| drop(d.wheel.remove(&format!("{information}/licenses/{}", licences::OF_WHEEL[0]))),
            "lacks LICENSE-THIRD-PARTY.txt",
        ),
        (
            &|d| drop(d.wheel.insert(d.platform.module.into(), module(d.folder.path(), "another"))),
            "does not export PyInit__native",
        ),
        (&|d| drop(d.wheel.insert(d.platform.module.into(), b"no library".to_vec())), "cannot be read"),
        (&|d| drop(d.wheel.remove(&format!("vibro_impact/fmu/{KIT_FILE}"))), "lacks machine-kit.zip"),
        (
            &|d| drop(d.wheel.insert(format!("vibro_impact/fmu/{KIT_FILE}"), other_kit())),
            "lacks the library for",
        ),
    ];
    for (alter, expected) in alterations {
        let mut dist = Dist::new();
        alter(&mut dist);
        let found = dist.disagreements();
        assert!(found.iter().any(|text| text.contains(expected)), "{expected}: {found:?}");
    }
}

#[test]
fn each_altered_archive_is_refused_by_name() {
    let token = |content: &mut Content, from: &str| {
        let text = String::from_utf8(content["modelDescription.xml"].clone()).unwrap();
        assert!(text.contains(from));
        content.insert("modelDescription.xml".into(), text.replacen(from, "other", 1).into_bytes());
    };
    let of_fmi3 = Version::Fmi3.own_binary();
    type Alteration<'a> = (Version, &'a dyn Fn(&mut Content), &'a str);
    let alterations: [Alteration<'_>; 4] = [
        (Version::Fmi2, &|c| token(c, &guid()), "VibroImpact3DOF.fmu: instantiation token other"),
        (
            Version::Fmi3,
            &|c| token(c, &instantiation_token(MAIN)),
            "VibroImpact3DOF-FMI3.fmu: instantiation token other",
        ),
        (
            Version::Fmi2,
            &|c| token(c, &format!(" version=\"{VERSION}\"")),
            "VibroImpact3DOF.fmu: version none",
        ),
        (
            Version::Fmi3,
            &|c| drop(c.insert(of_fmi3.clone(), b"no library".to_vec())),
            "hold different libraries",
        ),
    ];
    for (version, alter, expected) in alterations {
        let dist = Dist::new();
        dist.alter_archive(version, alter);
        let found = dist.disagreements();
        assert!(found.iter().any(|text| text.contains(expected)), "{expected}: {found:?}");
        // The packages no longer contain the files next to them.
        assert!(found.iter().any(|text| text.contains("is not the archive next to it")), "{found:?}");
    }
}

/// A kit of two platforms whose libraries are texts.
fn kit() -> Kit {
    let folders = ["x86_64-linux", "x86-linux"].map(|tuple| (tuple.to_owned(), tuple.as_bytes().to_vec()));
    Kit { binaries: Binaries::from_folders(folders.into()).unwrap(), ..Kit::default() }
}

#[test]
fn every_example_machine_is_shipped_with_one_library_that_packs_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(machines::EXAMPLES);
    archive::write(&machines::examples(&kit()).unwrap(), &file).unwrap();
    let shipped = archive::read_all(&file).unwrap();
    for (name, content) in &shipped {
        fs::write(folder.path().join(name), content).unwrap();
    }
    let kit = Kit::read(&folder.path().join(KIT_FILE)).unwrap();
    assert_eq!(kit.binaries.folders().count(), 2);
    let machines: Vec<&String> = shipped.keys().filter(|name| name.ends_with(".toml")).collect();
    assert!(machines.len() > 25, "{machines:?}");
    // Records and matrices are next to the machines that read them.
    for name in machines {
        let machine = vibro_machine::file::read(&folder.path().join(name)).unwrap();
        let packed = folder.path().join("machine.fmu");
        vibro_pack::write(&machine, fmi_doors::Version::Fmi3, &kit, &packed).unwrap();
        let content = archive::read_all(&packed).unwrap();
        let binaries = content.keys().filter(|name| name.starts_with("binaries/")).count();
        assert!(binaries == 2 && content.contains_key("resources/machine.toml"), "{name}");
    }
}

/// The truth suite of a release has what its score and its build read, and nothing that Python left.
#[test]
fn the_truth_suite_is_shipped_whole() {
    let shipped = machines::suite().unwrap();
    for name in ["README.md", "LICENSE", "CITATION.cff", "score.py", "build.py", "solvers/run.py"] {
        assert!(shipped.contains_key(&format!("truth/{name}")), "{name}");
    }
    let cases: Vec<_> = shipped.keys().filter_map(|name| name.strip_suffix("/case.toml")).collect();
    assert!(cases.len() >= 30, "{cases:?}");
    for case in cases {
        for file in ["machine.toml", "truth.csv", "events.csv"] {
            assert!(shipped.contains_key(&format!("{case}/{file}")), "{case}/{file}");
        }
    }
    assert!(shipped.keys().all(|name| !name.contains("__pycache__")));
}

#[test]
fn the_command_line_is_shipped_for_each_platform_with_its_licences() {
    let folders =
        ["x86_64-linux", "x86_64-windows"].map(|tuple| (tuple.to_owned(), tuple.as_bytes().to_vec()));
    let texts = Content::from([("LICENSE-MIT".to_owned(), b"text".to_vec())]);
    let binaries = Binaries::from_folders(folders.into()).unwrap();
    let shipped = machines::programs(&binaries, VERSION, &texts).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for tuple in ["x86_64-linux", "x86_64-windows"] {
        let name = format!("vibro-{VERSION}-{tuple}.zip");
        let path = folder.path().join(&name);
        fs::write(&path, &shipped[&name]).unwrap();
        let content = archive::read_all(&path).unwrap();
        assert_eq!(content["licenses/LICENSE-MIT"], b"text");
        assert!(String::from_utf8_lossy(&content["README.txt"]).contains("check machine.toml"));
        let program = if tuple.ends_with("windows") { "vibro.exe" } else { "vibro" };
        assert_eq!(content[program], tuple.as_bytes(), "{name}");
    }
}

#[test]
fn a_folder_with_anything_else_in_it_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mine"), "").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_fmu-build"));
    let output = command.args(["release", "--preview", "--out"]).arg(folder.path()).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(
        !output.status.success() && told.contains("--out ") && told.contains("earlier release"),
        "{told}"
    );
    assert!(folder.path().join("mine").exists());
    let output = Command::new(env!("CARGO_BIN_EXE_fmu-build"))
        .args(["release", "--preview", "--platform", "vax"])
        .output()
        .unwrap();
    assert!(String::from_utf8_lossy(&output.stderr).contains("--platform = vax: expected one of x86_64-"));
}

/// The whole release for this machine, without release optimisations; then the user's steps:
/// checksums, and the source distribution built and imported in a clean environment.
#[test]
#[ignore = "builds archives, wheels and pages: needs minutes, fmu-build/requirements.txt on the PATH and a package index"]
fn the_whole_for_this_machine_has_the_same_bytes_in_two_folders_and_builds_from_its_sources() {
    if let Some(tools) = wheels::missing_tool() {
        panic!("not tested: {tools}");
    }
    let folder = tempfile::tempdir().unwrap();
    let dist = folder.path().join("dist");
    let quick = |command: &mut Command| {
        let options = [("LTO", "off"), ("CODEGEN_UNITS", "16"), ("OPT_LEVEL", "1")];
        command.envs(options.map(|(name, value)| (format!("CARGO_PROFILE_FMU_{name}"), value)));
    };
    let release = |into: &Path| {
        let mut release = Command::new(env!("CARGO_BIN_EXE_fmu-build"));
        release.args(["release", "--preview", "--platform", compile::PLATFORM_TUPLE, "--out"]).arg(into);
        quick(&mut release);
        release
    };
    println!("{}", common::python::run("the release", &mut release(&dist)));
    // Everything is compiled again in another folder, and the wheel from unpacked sources there.
    let (again, elsewhere) = (folder.path().join("again"), folder.path().join("elsewhere"));
    common::python::run("the release again", release(&again).env("CARGO_TARGET_DIR", &elsewhere));
    let [first, second] = [&dist, &again].map(|dist| fs::read_to_string(dist.join(SUMS)).unwrap());
    assert_eq!(first, second, "two folders, the same bytes");
    let notes = fs::read_to_string(dist.join(NOTES)).unwrap();
    println!("{notes}");
    let own = WHEELS.iter().find(|p| p.is_own()).unwrap().file(VERSION);
    let program = format!("vibro-{VERSION}-{}.zip", compile::PLATFORM_TUPLE);
    let archives = ["VibroImpact3DOF.fmu", "VibroImpact3DOF-FMI3.fmu", machines::EXAMPLES, machines::SUITE];
    for name in archives.into_iter().chain(["documentation.html", &program, &own, &sdist_file(VERSION)]) {
        assert!(notes.contains(&format!("`{name}`")) && dist.join(name).is_file(), "{name}");
    }
    assert!(notes.contains("installed in a clean environment"), "{notes}");
    let mut check = Command::new("sha256sum");
    common::python::run("sha256sum", check.args(["--check", "--quiet", SUMS]).current_dir(&dist));
    let sums = fs::read_to_string(dist.join(SUMS)).unwrap().lines().count();
    assert_eq!(sums, fs::read_dir(&dist).unwrap().count() - 1, "every file but the sums has one");

    let environment = folder.path().join("venv");
    common::python::run("venv", Command::new("python3").args(["-m", "venv"]).arg(&environment));
    let python: PathBuf = environment.join("bin/python");
    let mut pip = Command::new(&python);
    pip.args(["-m", "pip", "install", "--quiet"]).arg(dist.join(sdist_file(VERSION)));
    quick(&mut pip);
    common::python::run("pip install of the source distribution", &mut pip);
    let script = "import vibro_impact as vi; print(vi.__version__, len(vi.PaperMachine().simulate(periods=50).impacts), vi.fmu_path(3).exists() and vi.Machine({'name': 'A', 'body': {'b': {'mass': 1.0}}, 'stop': {'s': {'between': ['ground', 'b'], 'gap': 1.0, 'restitution': 1.0}}}).fmu().exists())";
    let printed = common::python::run(
        "import",
        Command::new(&python).args(["-I", "-c", script]).current_dir(folder.path()),
    );
    assert!(printed.starts_with(VERSION) && printed.trim().ends_with("True"), "{printed}");
}
