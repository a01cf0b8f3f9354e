//! Imports go one way: the table of rooms in ARCHITECTURE.md holds for every file, and no file imports itself through
//! others. Read are `use` declarations and all other paths, also in macros, through re-exports to the file that defines
//! what is named. Tests (`cfg(test)`) may import what they like.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use syn::visit::{self, Visit};

/// The roots of the crates that are read: the name that other crates have for it, and its file.
const CRATES: [(&str, &str); 3] =
    [("gpu_stereo", "src/lib.rs"), ("command", "cli/src/main.rs"), ("viewer", "viewer/src/main.rs")];

/// The segments of a path, or of a module's name from its crate's on.
type Segments = Vec<String>;

/// What a module names.
#[derive(Default)]
struct Module {
    file: String,
    /// What `use` brings in: the local name, and what it stands for.
    imports: Vec<(String, Segments)>,
    /// `use path::*`.
    globs: Vec<Segments>,
    /// What is defined here.
    items: BTreeSet<String>,
    /// Every path in the code.
    paths: Vec<Segments>,
}

/// All modules of all crates.
#[derive(Default)]
struct Project {
    modules: BTreeMap<Segments, Module>,
}

/// What a path leads to.
#[derive(Clone)]
enum Found {
    Module(Segments),
    /// Something that is defined in a module.
    Item(Segments),
}

/// Reads one file's items into modules.
struct Reader<'a> {
    project: &'a mut Project,
    at: Segments,
    /// `mod name;` of this file.
    declared: Vec<Segments>,
}

fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().filter(|attribute| attribute.path().is_ident("cfg")).any(|attribute| {
        let tokens = attribute.meta.require_list().map(|list| list.tokens.to_string()).unwrap_or_default();
        tokens.contains("test") && !tokens.contains("not")
    })
}

fn attributes(item: &syn::Item) -> &[syn::Attribute] {
    use syn::Item::{Const, Enum, Fn, Impl, Macro, Mod, Static, Struct, Trait, Type, Use};
    match item {
        Const(syn::ItemConst { attrs, .. })
        | Enum(syn::ItemEnum { attrs, .. })
        | Fn(syn::ItemFn { attrs, .. })
        | Impl(syn::ItemImpl { attrs, .. })
        | Macro(syn::ItemMacro { attrs, .. })
        | Mod(syn::ItemMod { attrs, .. })
        | Static(syn::ItemStatic { attrs, .. })
        | Struct(syn::ItemStruct { attrs, .. })
        | Trait(syn::ItemTrait { attrs, .. })
        | Type(syn::ItemType { attrs, .. })
        | Use(syn::ItemUse { attrs, .. }) => attrs,
        _ => &[],
    }
}

impl Reader<'_> {
    fn module(&mut self) -> &mut Module {
        self.project.modules.get_mut(&self.at).unwrap()
    }

    fn import(&mut self, before: &[String], tree: &syn::UseTree) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        let (name, path) = match tree {
            syn::UseTree::Path(path) => return self.import(&with(&path.ident), &path.tree),
            syn::UseTree::Group(group) => return group.items.iter().for_each(|tree| self.import(before, tree)),
            syn::UseTree::Glob(_) => return self.module().globs.push(before.to_vec()),
            syn::UseTree::Name(name) if name.ident == "self" => (before[before.len() - 1].clone(), before.to_vec()),
            syn::UseTree::Name(name) => (name.ident.to_string(), with(&name.ident)),
            syn::UseTree::Rename(rename) if rename.ident == "self" => (rename.rename.to_string(), before.to_vec()),
            syn::UseTree::Rename(rename) => (rename.rename.to_string(), with(&rename.ident)),
        };
        self.module().imports.push((name, path));
    }

    /// Paths in the tokens of a macro: names joined by `::`.
    fn tokens(&mut self, tokens: proc_macro2::TokenStream) {
        let mut path: Segments = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                proc_macro2::TokenTree::Ident(ident) => {
                    if colons != 2 && !path.is_empty() {
                        let path = std::mem::take(&mut path);
                        self.module().paths.push(path);
                    }
                    path.push(ident.to_string());
                    colons = 0;
                }
                proc_macro2::TokenTree::Punct(punct) if punct.as_char() == ':' => colons += 1,
                other => {
                    if let proc_macro2::TokenTree::Group(group) = other {
                        self.tokens(group.stream());
                    }
                    if !path.is_empty() {
                        let path = std::mem::take(&mut path);
                        self.module().paths.push(path);
                    }
                    colons = 0;
                }
            }
        }
        if !path.is_empty() {
            self.module().paths.push(path);
        }
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if is_test(attributes(item)) {
            return;
        }
        use syn::Item::{Const, Enum, Fn, Macro, Mod, Static, Struct, Trait, Type};
        let name = match item {
            Const(syn::ItemConst { ident, .. })
            | Enum(syn::ItemEnum { ident, .. })
            | Fn(syn::ItemFn { sig: syn::Signature { ident, .. }, .. })
            | Macro(syn::ItemMacro { ident: Some(ident), .. })
            | Static(syn::ItemStatic { ident, .. })
            | Struct(syn::ItemStruct { ident, .. })
            | Trait(syn::ItemTrait { ident, .. })
            | Type(syn::ItemType { ident, .. }) => Some(ident.to_string()),
            Mod(inner) => {
                let name = [&self.at[..], &[inner.ident.to_string()]].concat();
                let Some((_, items)) = &inner.content else { return self.declared.push(name) };
                let file = self.module().file.clone();
                self.project.modules.insert(name.clone(), Module { file, ..Module::default() });
                let outer = std::mem::replace(&mut self.at, name);
                items.iter().for_each(|item| self.visit_item(item));
                self.at = outer;
                return;
            }
            _ => None,
        };
        self.module().items.extend(name);
        visit::visit_item(self, item);
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.import(&[], &item.tree);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        if !is_test(&item.attrs) {
            visit::visit_impl_item_fn(self, item);
        }
    }

    fn visit_local(&mut self, item: &'ast syn::Local) {
        if !is_test(&item.attrs) {
            visit::visit_local(self, item);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.module().paths.push(segments);
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, mac: &'ast syn::Macro) {
        visit::visit_path(self, &mac.path);
        self.tokens(mac.tokens.clone());
    }

    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}
}

impl Project {
    /// Reads a crate from its root file on. `text` gives the text of a file, if there is one.
    fn read(&mut self, name: &str, root: &str, text: &dyn Fn(&str) -> Option<String>) {
        let folder = root.rsplit_once('/').map_or("", |(folder, _)| folder);
        let mut waiting = vec![(vec![name.to_string()], root.to_string())];
        while let Some((at, path)) = waiting.pop() {
            let source = text(&path).unwrap_or_else(|| panic!("{path} cannot be read"));
            let parsed = syn::parse_file(&source).unwrap_or_else(|error| panic!("{path}: {error}"));
            self.modules.insert(at.clone(), Module { file: path, ..Module::default() });
            let mut reader = Reader { project: self, at, declared: Vec::new() };
            parsed.items.iter().for_each(|item| reader.visit_item(item));
            for module in reader.declared {
                let below = format!("{folder}/{}", module[1..].join("/"));
                let files = [format!("{below}.rs"), format!("{below}/mod.rs")];
                let file = files.into_iter().find(|file| text(file).is_some());
                waiting.push((module.clone(), file.unwrap_or_else(|| panic!("{module:?} has no file"))));
            }
        }
    }

    /// What `path` leads to as code in the module `at` names it; nothing for what other packages define.
    fn find(&self, at: &[String], path: &[String], depth: u32) -> Option<Found> {
        let (first, rest) = path.split_first()?;
        let start = match first.as_str() {
            _ if depth == 0 => None,
            "crate" => Some(Found::Module(at[..1].to_vec())),
            "self" => Some(Found::Module(at.to_vec())),
            "super" => Some(Found::Module(at[..at.len() - 1].to_vec())),
            // Another crate is imported as a whole.
            name if at[0] != name && CRATES.iter().any(|(known, _)| *known == name) => {
                return Some(Found::Item(vec![name.to_string()]));
            }
            name => self.find_in(at, name, depth),
        };
        rest.iter().try_fold(start?, |found, name| match found {
            Found::Module(module) if name == "super" => Some(Found::Module(module[..module.len() - 1].to_vec())),
            Found::Module(module) => self.find_in(&module, name, depth),
            item => Some(item), // a variant or a function of a type
        })
    }

    /// What `name` is in a module.
    fn find_in(&self, at: &[String], name: &str, depth: u32) -> Option<Found> {
        let module = self.modules.get(at)?;
        if module.items.contains(name) {
            return Some(Found::Item(at.to_vec()));
        }
        let child = [at, &[name.to_string()]].concat();
        if self.modules.contains_key(&child) {
            return Some(Found::Module(child));
        }
        let imported = module.imports.iter().filter(|(local, path)| local == name && path[0] != name);
        let imported = imported.map(|(_, path)| path.clone());
        let globbed = module.globs.iter().map(|path| [&path[..], &[name.to_string()]].concat());
        imported.chain(globbed).find_map(|path| self.find(at, &path, depth - 1))
    }

    /// The files that each file imports from.
    fn imports(&self) -> BTreeMap<String, BTreeSet<String>> {
        let mut all: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (at, module) in &self.modules {
            let entry = all.entry(module.file.clone()).or_default();
            let used = module.imports.iter().map(|(_, path)| path).chain(&module.paths);
            for path in used {
                if let Some(Found::Item(home)) = self.find(at, path, 16) {
                    let file = &self.modules[&home].file;
                    if *file != module.file {
                        entry.insert(file.clone());
                    }
                }
            }
        }
        all
    }
}

/// A row of the table of rooms.
#[derive(Debug)]
struct Room {
    /// Its files: paths, or folders that end in `/`.
    holds: Vec<String>,
    /// The rooms that its files may import besides their own, by their first path.
    imports: Vec<String>,
}

/// The table of ARCHITECTURE.md under the heading `## Rooms`: from the lowest room to the highest.
fn rooms(page: &str) -> Vec<Room> {
    let section = page.split("\n## ").find(|section| section.starts_with("Rooms\n")).unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    let named = |cell: &str| cell.split('`').skip(1).step_by(2).map(String::from).collect::<Vec<_>>();
    rows.map(|row| {
        let cells: Vec<&str> = row.split('|').collect();
        Room { holds: named(cells[1]), imports: named(cells[3]) }
    })
    .collect()
}

/// What is wrong with the imports, a sentence each.
fn faults(imports: &BTreeMap<String, BTreeSet<String>>, rooms: &[Room]) -> Vec<String> {
    let mut faults = Vec::new();
    for (i, room) in rooms.iter().enumerate() {
        for lower in &room.imports {
            if !rooms[..i].iter().any(|other| other.holds[0] == *lower) {
                faults.push(format!(
                    "the room {} imports {lower}, which is no room above it in the table",
                    room.holds[0]
                ));
            }
        }
    }
    let room_of = |file: &str| {
        let length = |room: &&Room| {
            let holds =
                room.holds.iter().filter(|held| file == *held || held.ends_with('/') && file.starts_with(*held));
            holds.map(String::len).max()
        };
        rooms.iter().filter(|room| length(room).is_some()).max_by_key(length)
    };
    for (file, imported) in imports {
        let Some(room) = room_of(file) else {
            faults.push(format!("{file} is in no room of the table"));
            continue;
        };
        for other in imported {
            let allowed =
                room_of(other).is_none_or(|lower| lower.holds == room.holds || room.imports.contains(&lower.holds[0]));
            if !allowed {
                faults.push(format!("{file} imports {other}, which its room may not"));
            }
        }
    }
    faults.extend(circles(imports).iter().map(|circle| format!("a circle: {}", circle.join(" -> "))));
    faults
}

/// Takes away, again and again, the files that import nothing of what is left, or that nothing of it imports.
fn without_ends<'a>(left: &mut BTreeMap<&'a String, BTreeSet<&'a String>>) {
    loop {
        let files: BTreeSet<&String> = left.keys().copied().collect();
        left.values_mut().for_each(|to| to.retain(|file| files.contains(file)));
        let imported: BTreeSet<&String> = left.values().flatten().copied().collect();
        left.retain(|file, to| !to.is_empty() && imported.contains(file));
        if left.len() == files.len() {
            return;
        }
    }
}

/// Files that import each other, directly or through others, as one way through each group of them.
fn circles(imports: &BTreeMap<String, BTreeSet<String>>) -> Vec<Vec<String>> {
    let mut left: BTreeMap<&String, BTreeSet<&String>> =
        imports.iter().map(|(file, imported)| (file, imported.iter().collect())).collect();
    let mut circles = Vec::new();
    without_ends(&mut left);
    while let Some((&start, _)) = left.first_key_value() {
        // Every file that is left imports another one that is left.
        let mut way = vec![start];
        let begin = loop {
            let next = *left[way[way.len() - 1]].first().unwrap();
            if let Some(begin) = way.iter().position(|file| *file == next) {
                break begin;
            }
            way.push(next);
        };
        circles.push(way[begin..].iter().chain([&way[begin]]).map(|file| file.to_string()).collect());
        left.retain(|file, _| !way.contains(file));
        without_ends(&mut left);
    }
    circles
}

fn text_of(path: &str) -> Option<String> {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).ok()
}

#[test]
fn imports_go_one_way() {
    let mut project = Project::default();
    CRATES.iter().for_each(|(name, root)| project.read(name, root, &text_of));
    let imports = project.imports();
    assert!(imports.len() > 100 && imports.values().map(BTreeSet::len).sum::<usize>() > 300, "too little was read");
    let faults = faults(&imports, &rooms(&text_of("ARCHITECTURE.md").unwrap()));
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

/// Of a small project: what is wrong, with the file that a change adds to.
fn faults_with(file: &str, added: &str) -> Vec<String> {
    let files = [
        ("src/lib.rs", "mod low; mod middle; mod high; pub use high::{High, act}; pub use low::Low;"),
        ("src/low.rs", "pub struct Low;"),
        ("src/middle/mod.rs", "mod one; mod two; pub use one::One; pub use two::Two;"),
        ("src/middle/one.rs", "use crate::Low; pub struct One(Low);"),
        ("src/middle/two.rs", "use super::One; pub struct Two(One);"),
        ("src/high.rs", "use crate::middle; pub struct High(middle::Two); pub fn act() {} macro_rules! m { () => {} }"),
    ];
    let text = |path: &str| {
        let (_, text) = files.iter().find(|(known, _)| *known == path)?;
        Some(format!("{text} {}", if path == file { added } else { "" }))
    };
    let mut project = Project::default();
    project.read("gpu_stereo", "src/lib.rs", &text);
    let page = "# Page\n\n## Rooms\n\n| room | is | imports |\n|---|---|---|\n| `src/low.rs` | | |\n\
                | `src/middle/` | | `src/low.rs` |\n| `src/high.rs` | | `src/low.rs`, `src/middle/` |\n\
                | `src/lib.rs` | | `src/low.rs`, `src/middle/`, `src/high.rs` |\n\n## More\n";
    faults(&project.imports(), &rooms(page))
}

/// The test of the test: each way in which a file can import a higher one, and circles within a room.
#[test]
fn imports_that_go_up_are_found() {
    assert!(faults_with("", "").is_empty(), "{:?}", faults_with("", ""));
    for (file, added, found) in [
        ("src/low.rs", "use crate::high::High;", "src/high.rs"),
        ("src/low.rs", "use crate::High;", "src/high.rs"),
        ("src/low.rs", "use super::High as Other;", "src/high.rs"),
        ("src/low.rs", "use crate::{Low as Own, middle::{self, One}};", "src/middle/one.rs"),
        ("src/low.rs", "use crate::high; fn f() { high::act() }", "src/high.rs"),
        ("src/low.rs", "use crate::*; fn f() { act() }", "src/high.rs"),
        ("src/low.rs", "fn f(high: &crate::High) {}", "src/high.rs"),
        ("src/low.rs", "fn f() { println!(\"{}\", g(crate::high::act())) }", "src/high.rs"),
        ("src/low.rs", "mod inner { use super::super::High; }", "src/high.rs"),
        ("src/low.rs", "impl Low { fn f() { super::act() } }", "src/high.rs"),
        ("src/middle/one.rs", "use super::Two;", "src/middle/two.rs"),
        ("src/middle/one.rs", "use crate::middle::two::Two;", "src/middle/two.rs"),
    ] {
        let faults = faults_with(file, added);
        assert!(faults.iter().any(|fault| fault.contains(file) && fault.contains(found)), "{added:?}: {faults:?}");
    }
    let circle = faults_with("src/middle/one.rs", "use super::Two;");
    assert_eq!(circle, ["a circle: src/middle/one.rs -> src/middle/two.rs -> src/middle/one.rs"]);
    // Two circles, of which one hangs on the other.
    let circles = circles(
        &[("a", "b"), ("b", "a"), ("c", "a"), ("c", "d"), ("d", "e"), ("e", "c"), ("f", "c"), ("b", "g"), ("g", "")]
            .map(|(file, to)| (file.to_string(), to.to_string()))
            .into_iter()
            .fold(BTreeMap::new(), |mut all: BTreeMap<String, BTreeSet<String>>, (file, to)| {
                all.entry(file).or_default().extend((!to.is_empty()).then_some(to));
                all
            }),
    );
    assert_eq!(circles.iter().map(|circle| circle.join("")).collect::<Vec<_>>(), ["aba", "cdec"]);
    // What does not go up.
    for (file, added) in [
        ("src/low.rs", "#[cfg(test)] mod tests { use crate::High; }"),
        ("src/low.rs", "/// [`crate::High`] \n fn f() { let high = \"crate::High\"; }"),
        ("src/high.rs", "use crate::Low; use crate::middle::One;"),
    ] {
        assert!(faults_with(file, added).is_empty(), "{added:?}: {:?}", faults_with(file, added));
    }
    assert_eq!(faults_with("src/lib.rs", "mod nowhere { pub struct N; }").len(), 0);
}
