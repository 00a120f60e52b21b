//! Dependencies between packages and between the core's rooms point downwards, and the files of a
//! package import each other without cycles.

use std::collections::{BTreeMap, BTreeSet};

use tidy::{Tracked, report, tracked};

/// A package and the packages that it may depend on; or a room and the rooms that it may use
/// besides [`BASE`].
struct Layer {
    name: &'static str,
    below: &'static [&'static str],
    /// More packages, for the package's tests, examples and benches only.
    in_tests: &'static [&'static str],
}

const fn layer(name: &'static str, below: &'static [&'static str]) -> Layer {
    tested(name, below, &[])
}

const fn tested(
    name: &'static str,
    below: &'static [&'static str],
    in_tests: &'static [&'static str],
) -> Layer {
    Layer {
        name,
        below,
        in_tests,
    }
}

/// The workspace's packages, lowest first. A row may name only packages of earlier rows.
const PACKAGES: &[Layer] = &[
    layer("rt-core", &[]),
    layer("shared-mem", &[]),
    layer("statistics", &[]),
    layer("store", &[]),
    layer("figures", &[]),
    layer("fem-reference", &[]),
    layer("system-tests", &[]),
    layer("xtask", &[]),
    layer("tidy", &[]),
    layer("centre", &["store"]),
    tested("deliver", &["store"], &["system-tests"]),
    layer("hardware", &["rt-core"]),
    layer("link", &["shared-mem"]),
    layer("session", &["shared-mem"]),
    layer("assess", &["figures", "session", "shared-mem"]),
    layer("jitter", &["figures", "shared-mem"]),
    layer(
        "display-host",
        &["assess", "figures", "session", "shared-mem"],
    ),
    layer("scene-load", &["rt-core", "shared-mem"]),
    layer("scene-prepare", &["rt-core", "scene-load", "shared-mem"]),
    layer(
        "rt-process",
        &["hardware", "rt-core", "scene-load", "shared-mem"],
    ),
    tested(
        "surgeon",
        &["assess", "session", "shared-mem"],
        &["rt-process", "scene-prepare"],
    ),
    layer(
        "evaluate",
        &[
            "assess",
            "display-host",
            "fem-reference",
            "figures",
            "rt-core",
            "rt-process",
            "scene-prepare",
            "session",
            "shared-mem",
            "statistics",
        ],
    ),
    tested(
        "calot",
        &[
            "assess",
            "deliver",
            "display-host",
            "figures",
            "hardware",
            "jitter",
            "link",
            "rt-core",
            "rt-process",
            "scene-prepare",
            "session",
            "shared-mem",
            "statistics",
            "store",
            "surgeon",
        ],
        &["system-tests"],
    ),
];

/// Lowest rooms of `rt-core`. Every room may use them, and they may use each other.
const BASE: &[&str] = &[
    "capacity", "fault", "hash", "math", "port", "time", "tool", "words",
];

/// The other rooms of `rt-core`, lowest first. A row may name only rooms of earlier rows.
const ROOMS: &[Layer] = &[
    layer("scene", &[]),
    layer("tissue", &["scene"]),
    layer("contact", &["scene", "tissue"]),
    layer("organs", &["scene", "tissue", "contact"]),
    layer("haptics", &["scene", "tissue", "contact"]),
    layer("procedure", &["scene", "tissue", "contact"]),
    layer(
        "state",
        &[
            "scene",
            "tissue",
            "contact",
            "organs",
            "haptics",
            "procedure",
        ],
    ),
    layer("study", &["scene", "tissue", "contact", "organs", "state"]),
    layer(
        "sim",
        &[
            "scene",
            "tissue",
            "contact",
            "organs",
            "haptics",
            "procedure",
            "state",
        ],
    ),
];

#[test]
fn layers_name_only_earlier_rows() {
    let mut findings = Vec::new();
    for (table, base) in [(PACKAGES, &[][..]), (ROOMS, BASE)] {
        for (row, layer) in table.iter().enumerate() {
            for below in layer.below.iter().chain(layer.in_tests) {
                if !table[..row].iter().any(|it| it.name == *below) {
                    findings.push(format!(
                        "tests/tidy/tests/layers.rs: '{}' names '{below}', which has no earlier row; \
                         put its row earlier, or move the definition that both need into an \
                         earlier layer",
                        layer.name
                    ));
                }
            }
            if base.contains(&layer.name) {
                findings.push(format!("'{}' is in BASE and in ROOMS", layer.name));
            }
        }
    }
    report(&findings);
}

#[test]
fn packages_depend_only_on_packages_that_the_table_allows() {
    let mut findings = Vec::new();
    let packages = packages();
    for layer in PACKAGES {
        if !packages.contains_key(layer.name) {
            findings.push(format!("no package '{}'; delete its row", layer.name));
        }
    }
    for (name, package) in &packages {
        let manifest = &package.manifest.path;
        let Some(layer) = PACKAGES.iter().find(|it| it.name == name) else {
            findings.push(format!(
                "{manifest}:1: package '{name}' has no row in PACKAGES (tests/tidy/tests/layers.rs)"
            ));
            continue;
        };
        for (section, also) in [
            ("dependencies", &[][..]),
            ("build-dependencies", &[]),
            ("dev-dependencies", layer.in_tests),
        ] {
            let used = names(&package.table, section);
            for dependency in used.iter().filter(|it| packages.contains_key(*it)) {
                let is_listed = |list: &[&str]| list.contains(&dependency.as_str());
                if !is_listed(layer.below) && !is_listed(also) {
                    let line = line_of(&package.manifest.text, section, dependency);
                    findings.push(format!(
                        "{manifest}:{line}: '{name}' may not depend on '{dependency}'; move what \
                         it needs into a lower package, or allow it in PACKAGES"
                    ));
                }
            }
            let unused = match section {
                "dependencies" => layer.below,
                "dev-dependencies" => layer.in_tests,
                _ => &[],
            };
            for dependency in unused.iter().filter(|it| !used.contains(**it)) {
                findings.push(format!(
                    "{manifest}:1: '{name}' no longer depends on '{dependency}' ({section}); \
                     delete it from its row in PACKAGES"
                ));
            }
        }
    }
    report(&findings);
}

#[test]
fn rooms_of_the_core_import_only_rooms_below_them() {
    let mut findings = Vec::new();
    let files = Files::of(&packages()["rt-core"].folder);
    for import in &files.imports {
        let (from, to) = (room(&import.from), room(&import.to));
        if from == to || BASE.contains(&to) && !BASE.contains(&from) {
            continue;
        }
        let is_allowed = if BASE.contains(&from) {
            BASE.contains(&to)
        } else {
            ROOMS
                .iter()
                .any(|it| it.name == from && it.below.contains(&to))
        };
        if !is_allowed {
            findings.push(format!(
                "{}:{}: room '{from}' may not use room '{to}'; move the definition into a lower \
                 room, or allow it in ROOMS (tests/tidy/tests/layers.rs)",
                files.paths[&import.from], import.line
            ));
        }
    }
    report(&findings);
}

#[test]
fn files_of_a_package_import_each_other_without_cycles() {
    let mut findings = Vec::new();
    for package in packages().values() {
        let files = Files::of(&package.folder);
        let cycles = files.cycles();
        for import in &files.imports {
            let closes = |cycle: &BTreeSet<String>| {
                [&import.from, &import.to]
                    .iter()
                    .all(|it| cycle.contains(*it))
            };
            if cycles.iter().any(closes) {
                findings.push(format!(
                    "{}:{}: imports '{}' in a cycle of files; move the definition that both need \
                     into a file below them",
                    files.paths[&import.from], import.line, import.to
                ));
            }
        }
    }
    report(&findings);
}

struct Package {
    /// Folder from the root of the checkout.
    folder: String,
    manifest: Tracked,
    table: toml::Table,
}

/// The packages of the workspace, and of those beside it that it names, by name.
fn packages() -> BTreeMap<String, Package> {
    let manifests = tracked("Cargo.toml");
    let parse = |file: &Tracked| -> toml::Table {
        file.text
            .parse()
            .unwrap_or_else(|error| panic!("{}: {error}", file.path))
    };
    let root = manifests.iter().find(|it| it.path == "Cargo.toml");
    let root = parse(root.expect("the workspace has a manifest"));
    let listed = |key: &str| {
        let list = root["workspace"][key].as_array();
        list.expect("a list of paths").iter()
    };
    let members: Vec<String> = listed("members")
        .chain(listed("exclude"))
        .map(|it| it.as_str().expect("a member is a path").to_owned())
        .collect();
    let mut packages = BTreeMap::new();
    for manifest in manifests {
        let folder = manifest.path.trim_end_matches("Cargo.toml");
        let folder = folder.trim_end_matches('/').to_owned();
        if members.contains(&folder) {
            let table = parse(&manifest);
            let name = table["package"]["name"].as_str().expect("a package's name");
            packages.insert(
                name.to_owned(),
                Package {
                    folder,
                    manifest,
                    table,
                },
            );
        }
    }
    assert_eq!(packages.len(), members.len(), "every member has a manifest");
    packages
}

/// Names in a section of a manifest.
fn names(manifest: &toml::Table, section: &str) -> BTreeSet<String> {
    let section = manifest.get(section).and_then(toml::Value::as_table);
    section.map_or_else(BTreeSet::new, |it| it.keys().cloned().collect())
}

/// Line of a dependency in a manifest's section.
fn line_of(manifest: &str, section: &str, dependency: &str) -> usize {
    let head = format!("[{section}]");
    let is_dependency = |line: &str| {
        let rest = line.strip_prefix(dependency);
        rest.is_some_and(|it| it.starts_with(['.', ' ', '=']))
    };
    let lines = manifest.lines().enumerate();
    let mut inside = lines.skip_while(|(_, line)| line.trim() != head);
    inside
        .find(|(_, line)| is_dependency(line))
        .map_or(1, |(row, _)| row + 1)
}

/// First part of a module's path.
fn room(module: &str) -> &str {
    module.split("::").next().unwrap_or(module)
}

struct Import {
    /// Module that imports.
    from: String,
    /// Deepest module with a file of its own on the imported path.
    to: String,
    line: usize,
}

/// Modules of a package that have a file, and their imports of each other. The crate's root, test
/// modules, and imports between a module and its ancestors are left out.
struct Files {
    /// Paths by module.
    paths: BTreeMap<String, String>,
    imports: Vec<Import>,
}

impl Files {
    fn of(folder: &str) -> Self {
        let source = format!("{folder}/src/");
        let mut texts = BTreeMap::new();
        let mut paths = BTreeMap::new();
        for file in tracked(".rs") {
            let Some(inside) = file.path.strip_prefix(&source) else {
                continue;
            };
            let module = inside.trim_end_matches(".rs").trim_end_matches("/mod");
            let is_test = module.split('/').any(|it| it == "tests");
            if is_test || ["lib", "main"].contains(&module) {
                continue;
            }
            let module = module.replace('/', "::");
            texts.insert(module.clone(), without_tests(&file.text).to_owned());
            paths.insert(module, file.path);
        }
        let mut imports = Vec::new();
        for (module, text) in &texts {
            for (line, path) in uses(text) {
                let to = absolute(module, &path).and_then(|it| deepest(it, &paths));
                let Some(to) = to else { continue };
                let is_same = |it: &Import| it.from == *module && it.to == to;
                if imports.iter().any(is_same) {
                    continue;
                }
                // Imports between a module and its ancestor do not count: both directions are
                // normal.
                let is_kin = |a: &str, b: &str| a == b || a.starts_with(&format!("{b}::"));
                if !is_kin(&to, module) && !is_kin(module, &to) {
                    let from = module.clone();
                    imports.push(Import { from, to, line });
                }
            }
        }
        Self { paths, imports }
    }

    /// Sets of modules in which every module imports every other, directly or through others.
    fn cycles(&self) -> Vec<BTreeSet<String>> {
        let mut next: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        for import in &self.imports {
            next.entry(&import.from).or_default().insert(&import.to);
        }
        let reached = |start: &str| {
            let mut seen = BTreeSet::new();
            let mut left = vec![start.to_owned()];
            while let Some(module) = left.pop() {
                for to in next.get(module.as_str()).into_iter().flatten() {
                    if seen.insert((*to).to_owned()) {
                        left.push((*to).to_owned());
                    }
                }
            }
            seen
        };
        let from: BTreeMap<&str, BTreeSet<String>> = next
            .keys()
            .map(|module| (*module, reached(module)))
            .collect();
        let mut cycles: Vec<BTreeSet<String>> = Vec::new();
        for (module, seen) in &from {
            let is_known = cycles.iter().any(|it| it.contains(*module));
            if seen.contains(*module) && !is_known {
                let goes_back = |it: &&String| from[it.as_str()].contains(*module);
                let with_next = |it: &&String| from.contains_key(it.as_str());
                let cycle = seen.iter().filter(with_next).filter(goes_back);
                cycles.push(cycle.cloned().collect());
            }
        }
        cycles
    }
}

/// A file's text up to a module of tests that it contains.
fn without_tests(text: &str) -> &str {
    let mut start = 0;
    while let Some(at) = text[start..].find("#[cfg(test)]") {
        let at = start + at;
        let rest = text[at + "#[cfg(test)]".len()..].trim_start();
        let head = rest.split(['{', ';']).next().unwrap_or("");
        let is_module = head.trim_start_matches("pub(crate) ").starts_with("mod ");
        if is_module && rest[head.len()..].starts_with('{') {
            return &text[..at];
        }
        start = at + 1;
    }
    text
}

/// Every path that a file's `use` items import from its own crate, with the item's line.
fn uses(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut line = 0;
    let mut rest = text;
    while !rest.is_empty() {
        line += 1;
        let here = rest;
        rest = rest.split_once('\n').map_or("", |it| it.1);
        let item = here.trim_start_matches([' ', '\t']);
        let item = item
            .strip_prefix("pub(")
            .and_then(|it| it.split_once(") "))
            .map_or(item, |it| it.1);
        let item = item.strip_prefix("pub ").unwrap_or(item);
        let Some(tree) = item.strip_prefix("use ") else {
            continue;
        };
        let tree = tree.split(';').next().unwrap_or(tree);
        if ["crate::", "super::", "self::"]
            .iter()
            .any(|it| tree.starts_with(it))
        {
            let tree: String = tree
                .lines()
                .map(|it| it.split("//").next().unwrap_or(it))
                .collect::<Vec<_>>()
                .join(" ")
                .replace(" as ", "@")
                .split_whitespace()
                .collect();
            let mut paths = Vec::new();
            leaves("", &tree, &mut paths);
            found.extend(paths.into_iter().map(|path| (line, path)));
        }
    }
    found
}

/// Paths of a `use` tree without blanks: `a::{b, c::{d, e}}` has `a::b`, `a::c::d` and `a::c::e`.
fn leaves(base: &str, tree: &str, found: &mut Vec<String>) {
    let Some((head, inside)) = tree.split_once('{') else {
        let path = tree.split('@').next().unwrap_or(tree);
        if !path.is_empty() {
            found.push(format!("{base}{path}"));
        }
        return;
    };
    let base = format!("{base}{head}");
    let inside = inside.strip_suffix('}').unwrap_or(inside);
    let (mut depth, mut start) = (0, 0);
    for (at, letter) in inside.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                leaves(&base, &inside[start..at], found);
                start = at + 1;
            }
            _ => {}
        }
    }
    leaves(&base, &inside[start..], found);
}

/// Parts, from the crate's root, of a path that `module` imports. `None` if the path does not begin
/// with `crate`, `self` or `super`, or climbs above the root.
fn absolute(module: &str, path: &str) -> Option<Vec<String>> {
    let parts: Vec<&str> = path.split("::").collect();
    let mut here: Vec<&str> = module.split("::").collect();
    let mut rest = &parts[..];
    match parts.first() {
        Some(&"crate") => {
            here.clear();
            rest = &rest[1..];
        }
        Some(&"self") => rest = &rest[1..],
        Some(&"super") => {
            while let Some((&"super", after)) = rest.split_first() {
                here.pop()?;
                rest = after;
            }
        }
        _ => return None,
    }
    Some(here.iter().chain(rest).map(|&it| it.to_owned()).collect())
}

/// Deepest module on a path that has a file.
fn deepest(mut path: Vec<String>, paths: &BTreeMap<String, String>) -> Option<String> {
    while !path.is_empty() {
        let module = path.join("::");
        if paths.contains_key(&module) {
            return Some(module);
        }
        path.pop();
    }
    None
}

#[test]
fn nested_use_trees_are_read_to_their_leaves() {
    let text = "use std::fmt;\npub(crate) use crate::a::{\n    self as x, b::{C, d::E}, // note\n    F,\n};\nuse super::g;\n";
    let found: Vec<String> = uses(text).into_iter().map(|it| it.1).collect();
    assert_eq!(
        found,
        [
            "crate::a::self",
            "crate::a::b::C",
            "crate::a::b::d::E",
            "crate::a::F",
            "super::g"
        ]
    );
    assert_eq!(
        absolute("m::n", "super::g").map(|it| it.join("::")),
        Some("m::g".to_owned())
    );
}

#[test]
fn cycles_hold_every_file_that_reaches_itself() {
    let import = |from: &str, to: &str| Import {
        from: from.to_owned(),
        to: to.to_owned(),
        line: 1,
    };
    let files = Files {
        paths: BTreeMap::new(),
        imports: vec![
            import("a", "b"),
            import("b", "c"),
            import("c", "a"),
            import("c", "d"),
            import("e", "a"),
        ],
    };
    let cycle: BTreeSet<String> = ["a", "b", "c"].map(str::to_owned).into();
    assert_eq!(files.cycles(), [cycle]);
}
