//! What imports what within `core`, as ARCHITECTURE.md says.
//!
//! - *Room*: what stands directly in `core/src` or `core/output/src`, a file or a folder.
//! - *Arrow*: a file names what another file defines. Code for tests only makes no arrows.

use petgraph::algo::tarjan_scc;
use petgraph::graphmap::DiGraphMap;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemMod, ItemUse, UseTree, Visibility};

/// Names from the crate's root on; the root has none.
type Module = Vec<String>;

/// What lays paths, and what it is asked for.
const PLANNER: [&str; 17] = [
    "centring",
    "cutter_location",
    "engagement",
    "flat_path",
    "job",
    "level_set",
    "lift",
    "link",
    "outline",
    "pattern",
    "plan",
    "regions",
    "removal",
    "rest",
    "strips",
    "trochoid",
    "walls",
];
/// Rooms that read a finished path and know nothing of how it was planned.
const READERS: [&str; 4] = ["post", "preview", "report", "verify"];
/// All that the judge shares with anything, so that no mistake of the planner is its own, too.
const JUDGE_KNOWS: [&str; 4] = ["geometry", "parallel", "tool", "toolpath"];

#[test]
fn no_files_import_each_other_in_a_circle() {
    let arrows = arrows();
    let names: Vec<String> = arrows.keys().map(|module| module.join("::")).collect();
    let index: BTreeMap<&Module, usize> = arrows.keys().zip(0..).collect();
    let mut graph: DiGraphMap<usize, ()> = DiGraphMap::new();
    for (from, to) in &arrows {
        to.iter().for_each(|to| {
            graph.add_edge(index[from], index[to], ());
        });
    }
    let mut within = Vec::new();
    for circle in tarjan_scc(&graph).iter().filter(|circle| circle.len() > 1) {
        let edges = graph.all_edges().filter(|(a, b, ())| circle.contains(a) && circle.contains(b));
        within.extend(edges.map(|(a, b, ())| format!("{} -> {}", names[a], names[b])));
    }
    assert!(graph.edge_count() > 500, "{} arrows: most were overlooked", graph.edge_count());
    assert!(within.is_empty(), "arrows of circles: {within:#?}");
}

#[test]
fn who_reads_a_finished_path_knows_neither_planner_nor_job() {
    for ((from, to), files) in arrows_of_rooms() {
        let from_reader = READERS.contains(&from.as_str());
        assert!(!(from_reader && PLANNER.contains(&to.as_str())), "{from} -> {to}: {files:?}");
        let is_allowed = from != "verify" || JUDGE_KNOWS.contains(&to.as_str());
        assert!(is_allowed, "the judge knows {to}: {files:?}");
    }
}

#[test]
fn the_rooms_that_these_tests_name_exist() {
    let rooms: BTreeSet<String> = arrows().into_keys().filter_map(|m| m.first().cloned()).collect();
    for name in PLANNER.iter().chain(&READERS).chain(&JUDGE_KNOWS) {
        assert!(rooms.contains(*name), "{name} is no room");
    }
}

/// What every room imports, as ARCHITECTURE.md says it; with `UPDATE_GOLDEN` set, the file is written.
#[test]
fn the_imports_in_the_documentation_are_those_of_the_rooms() {
    let mut rooms: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (from, to) in arrows_of_rooms().into_keys() {
        rooms.entry(from).or_default().push(to);
    }
    let lines = rooms.iter().map(|(from, to)| format!("{from}: {}\n", to.join(", ")));
    let list: String = lines.collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../ARCHITECTURE.md");
    let text = fs::read_to_string(&path).unwrap();
    let (before, rest) = text.split_once("```imports\n").unwrap();
    let (found, after) = rest.split_once("```").unwrap();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        fs::write(&path, format!("{before}```imports\n{list}```{after}")).unwrap();
        return;
    }
    assert!(found == list, "run with UPDATE_GOLDEN=1 and read the difference\n--- is\n{list}");
}

#[test]
fn no_rooms_import_each_other_in_a_circle() {
    let arrows = arrows_of_rooms();
    let mut graph: DiGraphMap<&str, ()> = DiGraphMap::new();
    arrows.keys().for_each(|(from, to)| {
        graph.add_edge(from, to, ());
    });
    let circles: Vec<_> =
        tarjan_scc(&graph).into_iter().filter(|circle| circle.len() > 1).collect();
    assert!(circles.is_empty(), "{circles:#?}");
}

/// Arrows between rooms, and the files that make them.
fn arrows_of_rooms() -> BTreeMap<(String, String), Vec<String>> {
    let mut rooms: BTreeMap<(String, String), Vec<String>> = BTreeMap::new();
    for (from, to) in arrows() {
        for to in to {
            if let (Some(a), Some(b)) = (from.first(), to.first())
                && a != b
            {
                rooms.entry((a.clone(), b.clone())).or_default().push(from.join("::"));
            }
        }
    }
    rooms
}

/// For every file of both crates, named by its module, the files that it imports.
fn arrows() -> BTreeMap<Module, BTreeSet<Module>> {
    let core = Path::new(env!("CARGO_MANIFEST_DIR")).join("../core");
    let mut texts = BTreeMap::new();
    // Of the roots, which only name rooms, that of `core` has one for tests.
    read(&core.join("output/src"), &[], &mut texts);
    read(&core.join("src"), &[], &mut texts);
    let parsed = |(module, text): (Module, String)| {
        let file = syn::parse_file(&text).unwrap_or_else(|e| panic!("{module:?}: {e}"));
        (module, file)
    };
    let mut texts: BTreeMap<Module, syn::File> = texts.into_iter().map(parsed).collect();
    let only_for_tests: Vec<Module> =
        texts.iter().flat_map(|(m, file)| test_modules(m, file)).collect();
    texts.retain(|module, _| !only_for_tests.iter().any(|test| module.starts_with(test)));
    let modules: BTreeSet<Module> = texts.keys().cloned().collect();
    let mut arrows = BTreeMap::new();
    for (module, file) in &texts {
        let mut names =
            Names { here: module.clone(), file: module, modules: &modules, found: BTreeSet::new() };
        names.visit_file(file);
        arrows.insert(module.clone(), names.found);
    }
    arrows
}

/// The modules that a file declares for tests only.
fn test_modules(module: &[String], file: &syn::File) -> Vec<Module> {
    let name = |item: &Item| match item {
        Item::Mod(item) if item.attrs.iter().any(is_for_tests) => Some(item.ident.to_string()),
        _ => None,
    };
    let within = |name| module.iter().cloned().chain([name]).collect();
    file.items.iter().filter_map(name).map(within).collect()
}

/// All source files of a folder.
fn read(folder: &Path, module: &[String], texts: &mut BTreeMap<Module, String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let within: Module = module.iter().cloned().chain([name.clone()]).collect();
        if path.is_dir() {
            read(&path, &within, texts);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let of_folder = name == "mod" || name == "lib";
            let module = if of_folder { module.to_vec() } else { within };
            texts.insert(module, fs::read_to_string(&path).unwrap());
        }
    }
}

/// Collects what a file names.
struct Names<'a> {
    /// Where names are resolved: the file's module or one written out in it.
    here: Module,
    file: &'a Module,
    modules: &'a BTreeSet<Module>,
    found: BTreeSet<Module>,
}

impl Names<'_> {
    /// Adds the file that a path leads to, if it begins at the root, at a parent or at a child of this module.
    fn add(&mut self, path: &[String]) {
        let Some(first) = path.first() else { return };
        let child: Module = self.here.iter().cloned().chain([first.clone()]).collect();
        let mut whole: Module = match first.as_str() {
            "crate" | "evencut_core" => path[1..].to_vec(),
            "self" => self.here.iter().chain(&path[1..]).cloned().collect(),
            "super" => {
                let ups = path.iter().take_while(|name| *name == "super").count();
                let parent = &self.here[..self.here.len() - ups];
                parent.iter().chain(&path[ups..]).cloned().collect()
            }
            _ if self.modules.contains(&child) => self.here.iter().chain(path).cloned().collect(),
            _ => return,
        };
        while !whole.is_empty() && !self.modules.contains(&whole) {
            whole.pop();
        }
        // The crate's root only names its rooms.
        if whole != *self.file && !whole.is_empty() {
            self.found.insert(whole);
        }
    }

    fn add_use(&mut self, before: &[String], tree: &UseTree) {
        let with = |name: &syn::Ident| -> Module {
            before.iter().cloned().chain([name.to_string()]).collect()
        };
        match tree {
            UseTree::Path(path) => self.add_use(&with(&path.ident), &path.tree),
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.add_use(before, tree)),
            UseTree::Name(name) => self.add(&with(&name.ident)),
            UseTree::Rename(name) => self.add(&with(&name.ident)),
            UseTree::Glob(_) => self.add(before),
        }
    }
}

impl<'ast> Visit<'ast> for Names<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        if !attributes(item).iter().any(is_for_tests) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, module: &'ast ItemMod) {
        self.here.push(module.ident.to_string());
        visit::visit_item_mod(self, module);
        self.here.pop();
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        self.add_use(&[], &item.tree);
    }

    /// Who may name an item is no arrow.
    fn visit_visibility(&mut self, _: &'ast Visibility) {}

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        if names.len() > 1 {
            self.add(&names);
        }
        visit::visit_path(self, path);
    }
}

fn is_for_tests(attribute: &Attribute) -> bool {
    attribute.path().is_ident("cfg")
        && attribute.meta.require_list().is_ok_and(|list| list.tokens.to_string() == "test")
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}
