//! The documentation site, built with its notebooks run.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// All pages of a folder and its subfolders.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let entries =
        fs::read_dir(folder).expect("a folder of the site").map(|entry| entry.expect("an entry").path());
    let of = |path: PathBuf| match path.is_dir() {
        true => pages(&path),
        false if path.extension().is_some_and(|ending| ending == "html") => vec![path],
        false => vec![],
    };
    entries.flat_map(of).collect()
}

/// Builds the site, where a warning or a failing notebook is an error. The site must load nothing
/// from elsewhere, and its search must have the words of the notebooks.
#[test]
#[ignore = "installs Sphinx, runs seven notebooks: cargo test -p fmu-build --test site -- --ignored"]
fn the_site_is_built_with_its_notebooks_and_loads_nothing_from_elsewhere() {
    let python = common::python::python_with_package();
    let ask = "import sysconfig; print(sysconfig.get_path('platlib'))";
    let libraries = common::python::run("asking for site-packages", Command::new(&python).args(["-c", ask]));
    let mut build = common::python::command(python);
    // The links of the lessons do not depend on the page to which they lead.
    let workbench = common::python::root().join("web/workbench/page/index.html");
    build.args(["docs/site/build.py", "--execute", "--package", libraries.trim(), "--workbench"]);
    build.arg(&workbench);
    common::python::run("building the site", &mut build);

    let site = fmu_build::compile::target().join("site/html");
    let found = pages(&site);
    assert!(found.len() > 50, "{} pages", found.len());
    for page in &found {
        let text = fs::read_to_string(page).expect("a page of the site");
        for tag in text.split('<').filter(|tag| tag.starts_with("script") || tag.starts_with("link ")) {
            let elsewhere =
                tag.contains("src=\"http") || tag.contains("href=\"http") || tag.contains("=\"//");
            assert!(!elsewhere, "{}: <{tag}", page.display());
        }
    }
    let index = fs::read_to_string(site.join("searchindex.js")).expect("the index of the search");
    for word in ["restitut", "docs/notebooks/energy-sink", "reference-commands", "solve_ivp"] {
        assert!(index.contains(word), "the search does not have {word}");
    }
    let lesson = fs::read_to_string(site.join("docs/lessons/restitution.html")).expect("a lesson");
    let link = lesson.split("/workbench.html#z=").nth(1).and_then(|rest| rest.split('"').next());
    let link = link.expect("the link that opens a machine in the workbench");
    let unpack = "import base64,gzip,sys; z = sys.argv[1]; \
        print(gzip.decompress(base64.urlsafe_b64decode(z + '=' * (-len(z) % 4))).decode(), end='')";
    let mut unpacking = common::python::command(common::python::python_with_package());
    let machine = common::python::run("unpacking a link", unpacking.args(["-c", unpack, link]));
    assert!(
        machine.starts_with("name = \"Ball\"\n") && machine.ends_with("restitution = 0.8 }\n"),
        "{machine}"
    );
    assert_eq!(fs::read(site.join("workbench.html")).unwrap(), fs::read(workbench).unwrap());
    let notebook = fs::read_to_string(site.join("docs/notebooks/belt.html")).expect("a notebook");
    assert!(notebook.contains("by hand 0.671238898038 s"), "the notebook has no output");
}
