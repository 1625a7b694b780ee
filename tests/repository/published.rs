//! Packages that crates.io can take: their manifests are complete and name only each other
//! (invariant). `.ci/run` packs them with cargo.

use crate::texts::root;
use std::collections::BTreeSet;
use std::fs;

/// Folders of the published packages, in the order in which they are published.
const PUBLISHED: [&str; 6] =
    [".", "crates/numerics", "crates/machine", "crates/studies", "crates/orbits", "crates/design"];
/// Largest number and length of keywords, and largest number of categories, by the rules of
/// crates.io.
const KEYWORDS: (usize, usize) = (5, 20);
const CATEGORIES: usize = 5;

fn manifest(folder: &str) -> String {
    let path = root().join(folder).join("Cargo.toml");
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The lines of a table of a manifest, such as `[package]`.
fn table<'t>(manifest: &'t str, name: &str) -> impl Iterator<Item = &'t str> {
    let after = manifest.split(&format!("\n[{name}]\n")).nth(1);
    let whole = if name == "package" { manifest.strip_prefix("[package]\n").or(after) } else { after };
    whole.unwrap_or("").lines().take_while(|line| !line.starts_with('['))
}

fn value<'t>(manifest: &'t str, key: &str) -> Option<&'t str> {
    table(manifest, "package").find_map(|line| line.strip_prefix(key)?.strip_prefix(" = "))
}

/// The texts of a list on one line.
fn list<'t>(manifest: &'t str, key: &str) -> Vec<&'t str> {
    value(manifest, key).unwrap_or("").split('"').skip(1).step_by(2).collect()
}

/// Names of the repository's packages on which a package depends.
fn dependencies(manifest: &str) -> BTreeSet<&str> {
    let all = ["dependencies", "dev-dependencies"].into_iter().flat_map(|name| table(manifest, name));
    all.filter_map(|line| line.split(['.', ' ']).next())
        .filter(|name| name.starts_with("vibro") || *name == "fmi-doors")
        .collect()
}

#[test]
fn invariant_published_packages_have_what_their_pages_show() {
    for folder in PUBLISHED {
        let text = manifest(folder);
        assert_eq!(value(&text, "publish"), Some("true"), "{folder}");
        assert!(value(&text, "description").is_some_and(|words| words.len() > 30), "{folder}");
        assert!(text.contains("\nlicense.workspace = true\n"), "{folder}");
        assert_eq!(value(&text, "readme"), Some("\"README.md\""), "{folder}");
        let page = fs::read_to_string(root().join(folder).join("README.md")).expect("a page");
        assert!(page.contains("```rust\n"), "{folder}: no example");
        let (keywords, categories) = (list(&text, "keywords"), list(&text, "categories"));
        assert!((3..=KEYWORDS.0).contains(&keywords.len()), "{folder}: {keywords:?}");
        assert!(keywords.iter().all(|word| word.len() <= KEYWORDS.1 && !word.contains(' ')), "{folder}");
        assert!((1..=CATEGORIES).contains(&categories.len()), "{folder}: {categories:?}");
        assert!(table(&text, "package.metadata.docs.rs").count() > 1, "{folder}: nothing for docs.rs");
        for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
            let own = fs::read(root().join(folder).join(licence)).unwrap_or_default();
            assert_eq!(own, fs::read(root().join(licence)).expect(licence), "{folder}/{licence}");
        }
    }
}

#[test]
fn invariant_published_packages_depend_on_published_ones() {
    let texts = PUBLISHED.map(manifest);
    let names = texts.each_ref().map(|text| value(text, "name").expect("a name").trim_matches('"'));
    let workspace = manifest(".");
    for (text, name) in texts.iter().zip(names) {
        for dependency in dependencies(text) {
            assert!(names.contains(&dependency), "{name} depends on {dependency}, which is not published");
            let required = table(&workspace, "workspace.dependencies")
                .find(|line| line.starts_with(&format!("{dependency} = ")))
                .expect("a dependency of the workspace");
            assert!(required.contains("version = \""), "Cargo.toml: {required}: no version next to the path");
        }
    }
    // Other packages are not published by mistake.
    let members =
        table(&workspace, "workspace").filter_map(|line| line.trim().strip_prefix('"')?.split('"').next());
    let others = members.filter(|member| !PUBLISHED.contains(member));
    let open = others.filter(|member| !manifest(member).contains("publish")).collect::<Vec<_>>();
    assert!(open.is_empty(), "without `publish`: {open:?}");
    assert_eq!(
        dependencies("[package]\n\n[dependencies]\nvibro-a.workspace = true\nserde = \"1\"\n"),
        ["vibro-a"].into()
    );
}
