//! Files, functions and folders stay small enough to be read at once.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;

use syn::spanned::Spanned;
use syn::visit::{self, Visit};

/// Lines of a file of a crate's `src`.
const FILE: usize = 450;
/// Lines of a function of `src`, from its signature to its last brace.
const FUNCTION: usize = 80;
/// Files and folders in a folder.
const FOLDER: usize = 20;

/// Tables, a row a thing: these may be longer.
const TABLES: &[&str] = &[];

/// What is in these folders.
const READ: [&str; 10] =
    ["src", "cli", "shaders", "tests", "examples", "benches", "docs", "viewer", "python", "web/src"];

struct Functions<'a> {
    path: &'a str,
    faults: Vec<String>,
}

impl Functions<'_> {
    fn measure(&mut self, name: &syn::Ident, spanned: &dyn Fn() -> proc_macro2::Span, signature: &syn::Signature) {
        let lines = spanned().end().line - signature.span().start().line + 1;
        if lines > FUNCTION && !TABLES.contains(&format!("{}:{name}", self.path).as_str()) {
            self.faults.push(format!("{}: {name} has {lines} lines, at most {FUNCTION} are read", self.path));
        }
    }
}

impl<'ast> Visit<'ast> for Functions<'_> {
    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        self.measure(&item.sig.ident, &|| item.span(), &item.sig);
        visit::visit_item_fn(self, item);
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        self.measure(&item.sig.ident, &|| item.span(), &item.sig);
        visit::visit_impl_item_fn(self, item);
    }
}

/// What is too long in a file of `src`.
fn faults(path: &str, text: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let lines = text.lines().count();
    if lines > FILE && !TABLES.contains(&path) {
        faults.push(format!("{path} has {lines} lines, at most {FILE} are read"));
    }
    let mut functions = Functions { path, faults };
    functions.visit_file(&syn::parse_file(text).unwrap_or_else(|error| panic!("{path}: {error}")));
    functions.faults
}

/// Walks a folder; returns how many files of Rust were read.
fn walk(path: &str, faults_found: &mut Vec<String>) -> usize {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    let entries: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap()).collect();
    let entries: Vec<_> = entries.iter().filter(|entry| entry.file_name() != "__pycache__").collect();
    if entries.len() > FOLDER {
        faults_found.push(format!("{path} has {} entries, at most {FOLDER} are read", entries.len()));
    }
    let mut read = 0;
    for entry in entries {
        let inner = format!("{path}/{}", entry.file_name().to_str().unwrap());
        if entry.file_type().unwrap().is_dir() {
            read += walk(&inner, faults_found);
        } else if inner.split('/').take(2).any(|part| part == "src") && inner.ends_with(".rs") {
            faults_found.extend(faults(&inner, &std::fs::read_to_string(entry.path()).unwrap()));
            read += 1;
        }
    }
    read
}

#[test]
fn files_functions_and_folders_are_small() {
    let mut faults = Vec::new();
    let read: usize = READ.iter().map(|path| walk(path, &mut faults)).sum();
    assert!(read > 100, "only {read} files of Rust were read");
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}

/// The test of the test.
#[test]
fn what_is_too_long_is_found() {
    let function = |lines: usize| format!("fn f() {{\n{}}}\n", "    g();\n".repeat(lines - 2));
    assert!(faults("src/a.rs", &function(FUNCTION)).is_empty());
    assert_eq!(faults("src/a.rs", &function(FUNCTION + 1)).len(), 1);
    let method = format!("impl A {{\n{}}}\n", function(FUNCTION + 1));
    assert_eq!(faults("src/a.rs", &method).len(), 1);
    let file = |lines: usize| "// a line\n".repeat(lines);
    assert!(faults("src/a.rs", &file(FILE)).is_empty());
    assert_eq!(faults("src/a.rs", &file(FILE + 1)).len(), 1);
}
