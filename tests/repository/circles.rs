//! Imports among the modules of a crate (invariant): sibling modules in a folder do not import
//! each other in a circle.

use crate::texts::{root, shown, walk};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Path of a module within its crate; empty for the root.
type Module = Vec<String>;

/// Circles that exist: the crate's folder, and the modules of the circle.
const KNOWN: [(&str, &[&str]); 1] = [
    // The component of a machine stores a state that consists of the component's own parts.
    ("crates/machine-component/src", &["machine", "saved_state"]),
];

/// An import.
struct Import {
    /// Whether it re-exports the name: `pub use`.
    hands_on: bool,
    /// Path, such as `crate::flow::Series`.
    path: String,
    /// Name in the importing module.
    name: String,
}

/// The modules of a crate with their imports.
type Crate = BTreeMap<Module, Vec<Import>>;

/// Items of a list, which commas outside braces separate.
fn items(list: &str) -> Vec<&str> {
    let (mut depth, mut from, mut all) = (0, 0, Vec::new());
    for (at, c) in list.char_indices() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if c == ',' && depth == 0 {
            all.push(&list[from..at]);
            from = at + 1;
        }
    }
    all.push(&list[from..]);
    all
}

/// Paths and names of a tree such as `crate::a::{B, c::D as E}`.
fn paths(tree: &str) -> Vec<(String, String)> {
    let tree = tree.trim();
    if let Some((head, list)) = tree.split_once('{') {
        let list = items(list.trim_end().strip_suffix('}').unwrap_or(list));
        let below = list.into_iter().flat_map(paths);
        return below.map(|(path, name)| (format!("{head}{path}"), name)).collect();
    }
    let last = tree.rsplit("::").next().unwrap_or(tree);
    let (path, name) = tree.split_once(" as ").unwrap_or((tree, last));
    if tree.is_empty() { Vec::new() } else { vec![(path.into(), name.into())] }
}

/// Paths from `crate` or `super` in code outside `use`.
fn paths_in_code(code: &str) -> Vec<String> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let words = code.split(|c: char| !is_part(c));
    words
        .filter(|word| word.starts_with("crate::") || word.starts_with("super::"))
        .map(String::from)
        .collect()
}

/// Imports of a file, without its module of tests.
fn imports(text: &str) -> Vec<Import> {
    let code: Vec<&str> = text.lines().map(|line| line.split("//").next().unwrap_or(line)).collect();
    let code = code.join("\n");
    let code = code.split("#[cfg(test)]\nmod tests {").next().unwrap_or(&code);
    let mut found = Vec::new();
    for statement in code.split(';') {
        let starts = |line: &&str| {
            let line = line.trim_start();
            line.starts_with("use ") || (line.starts_with("pub") && line.contains(" use "))
        };
        let line = statement.split('\n').find(starts);
        let at = line.map_or(statement.len(), |line| line.as_ptr() as usize - statement.as_ptr() as usize);
        let (before, import) = statement.split_at(at);
        let in_code = paths_in_code(before).into_iter();
        found.extend(in_code.map(|path| Import { hands_on: false, name: String::new(), path }));
        let Some((public, tree)) = import.split_once("use ") else { continue };
        let hands_on = !public.trim().is_empty();
        found.extend(paths(tree).into_iter().map(|(path, name)| Import { hands_on, path, name }));
    }
    found
}

/// The path from the crate's root of a module's name; `None` for another crate.
fn absolute(modules: &BTreeSet<Module>, from: &[String], path: &str) -> Option<Module> {
    let segments: Vec<&str> = path.split("::").map(str::trim).collect();
    let ups = segments.iter().take_while(|own| **own == "super").count();
    let (base, rest) = match segments[0] {
        "crate" => (&from[..0], &segments[1..]),
        "self" => (from, &segments[1..]),
        "super" => (&from[..from.len().saturating_sub(ups)], &segments[ups..]),
        first => {
            let child = [from, &[first.to_owned()]].concat();
            modules.contains(&child).then_some((from, &segments[..]))?
        }
    };
    Some(base.iter().cloned().chain(rest.iter().map(|own| own.to_string())).collect())
}

/// The module that defines the name of a path from the root, through modules that re-export it.
fn defining(own: &Crate, modules: &BTreeSet<Module>, path: &[String], depth: usize) -> Module {
    let length = (0..=path.len()).rev().find(|&n| modules.contains(&path[..n])).unwrap_or(0);
    let (module, rest) = path.split_at(length);
    let imports = own.get(module).map_or(&[][..], |all| all);
    let handed = imports.iter().find(|import| import.hands_on && rest.first() == Some(&import.name));
    let further = handed.filter(|_| depth > 0).and_then(|own| absolute(modules, module, &own.path));
    match further.filter(|further| further != path) {
        Some(further) => defining(own, modules, &further, depth - 1),
        None => module.to_vec(),
    }
}

/// The modules of the circles of a graph, and of the ways between circles.
fn in_circles(graph: &BTreeMap<String, BTreeSet<String>>) -> BTreeSet<String> {
    let mut left: BTreeSet<String> = graph.keys().cloned().collect();
    loop {
        let imports = |own: &String| graph[own].iter().any(|other| left.contains(other));
        let is_imported = |own: &String| left.iter().any(|other| graph[other].contains(own));
        let next: BTreeSet<_> = left.iter().filter(|own| imports(own) && is_imported(own)).cloned().collect();
        if next.len() == left.len() {
            return next;
        }
        left = next;
    }
}

/// The modules of circles, by folder of a crate.
fn circles(own: &Crate) -> Vec<BTreeSet<String>> {
    let modules: BTreeSet<Module> =
        own.keys().flat_map(|module| (0..=module.len()).map(|n| module[..n].to_vec())).collect();
    let mut graphs: BTreeMap<Module, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
    for (module, imports) in own {
        for import in imports {
            let Some(path) = absolute(&modules, module, &import.path) else { continue };
            let target = defining(own, &modules, &path, 8);
            let common = module.iter().zip(&target).take_while(|(a, b)| a == b).count();
            if let (Some(from), Some(to)) = (module.get(common), target.get(common)) {
                let graph = graphs.entry(module[..common].to_vec()).or_default();
                graph.entry(to.clone()).or_default();
                graph.entry(from.clone()).or_default().insert(to.clone());
            }
        }
    }
    graphs.values().map(in_circles).filter(|circle| !circle.is_empty()).collect()
}

/// The crate in a folder that has `lib.rs` or `main.rs`; binaries of a library are crates of
/// their own.
fn read(folder: &Path) -> Crate {
    let mut files = Vec::new();
    walk(folder, &mut files);
    let is_root = |folder: &Path| ["lib.rs", "main.rs"].iter().any(|name| folder.join(name).exists());
    let mut all = Crate::new();
    for file in files.into_iter().filter(|file| file.extension().is_some_and(|ending| ending == "rs")) {
        let within = file.strip_prefix(folder).expect("in the folder").with_extension("");
        let mut module: Module = within.iter().map(|own| own.to_string_lossy().into_owned()).collect();
        let above = file.ancestors().skip(1).take_while(|above| *above != folder);
        if above.into_iter().any(is_root) || module.iter().any(|own| own == "tests" || own == "bin") {
            continue;
        }
        module.pop_if(|last| ["lib", "main", "mod"].contains(&last.as_str()));
        all.insert(module, imports(&fs::read_to_string(&file).expect("UTF-8")));
    }
    all
}

#[test]
fn invariant_modules_side_by_side_import_each_other_in_no_circle() {
    let mut files = Vec::new();
    walk(root(), &mut files);
    let roots = files.iter().filter(|file| file.ends_with("lib.rs") || file.ends_with("main.rs"));
    let folders: BTreeSet<&Path> = roots.filter_map(|file| file.parent()).collect();
    let is_test = |folder: &&Path| folder.iter().any(|own| own == "tests" || own == "examples");
    let mut found = Vec::new();
    for folder in folders.into_iter().filter(|folder| !is_test(folder)) {
        for circle in circles(&read(folder)) {
            let (name, modules): (_, Vec<&str>) =
                (shown(folder), circle.iter().map(String::as_str).collect());
            if !KNOWN.contains(&(&*name, &modules)) {
                found.push(format!("{name}: {}", modules.join(", ")));
            }
        }
    }
    assert!(found.is_empty(), "modules that import each other in a circle: {found:#?}");
}

#[test]
fn closed_form_circles_of_small_crates_are_found() {
    let made = |files: &[(&str, &str)]| {
        let module = |path: &str| path.split('/').filter(|own| !own.is_empty()).map(String::from).collect();
        let own: Crate = files.iter().map(|(path, text)| (module(path), imports(text))).collect();
        circles(&own).into_iter().map(|own| own.into_iter().collect::<Vec<_>>().join(" ")).collect::<Vec<_>>()
    };
    let root = ("", "pub mod a;\npub mod b;\npub mod c;\n");
    let b = ("b", "use crate::c::{D, E as F};\n");
    assert!(made(&[root, ("a", "use crate::b::B;\n"), b, ("c", "")]).is_empty());
    assert_eq!(made(&[root, ("a", "use crate::b::B;\n"), b, ("c", "fn f() { crate::a::g() }\n")]), ["a b c"]);
    // A child that uses its parent's items is no circle; children that use each other are one.
    let parent = ("a", "mod x;\nmod y;\npub use x::X;\nuse y::Y;\n");
    let (x, y) = (("a/x", "use super::{A, Y};\nuse super::y::Y;\n"), ("a/y", "use super::A;\n"));
    assert!(made(&[root, parent, x, y]).is_empty());
    assert_eq!(made(&[root, parent, x, ("a/y", "use super::{A, X};\n")]), ["x y"]);
}
