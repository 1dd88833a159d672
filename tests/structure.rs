//! The files of each crate of the workspace use each other in one direction only, and so do their folders at every level.
//! Between crates Cargo sees to it.
//!
//! What a file uses is read off its paths, in `use` lines and inline, each followed through re-exports to the file
//! that defines the item. Not counted: declarations of modules, re-exports, crate roots and `#[cfg(test)]`. Not seen: methods
//! that a file gives to a type of another one.

mod folders;
mod reader;
mod sources;

use std::path::Path;

use sources::Sources;

#[test]
fn no_circle_of_files_or_folders() {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("../Cargo.toml");
    let manifest = std::fs::read_to_string(manifest).unwrap();
    let members = manifest.split_once("members = [").unwrap().1;
    let members = members.split_once(']').unwrap().0;
    let members: Vec<&str> = members.split('"').skip(1).step_by(2).collect();
    assert!(members.contains(&"tests/truth"), "{members:?}");
    let circles = members
        .iter()
        .map(|root| folders::circles(&Sources::read(root).uses()));
    let circles: Vec<String> = circles.flatten().collect();
    assert!(circles.is_empty(), "\n{}", circles.join("\n"));
}

/// Of what once was, and with a place to fill in.
const NAMES_NO_FILE: [&str; 2] = ["docs/decisions/kept-or-gone.md", "CONTRIBUTING.md"];

#[test]
fn documents_name_files_that_exist() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut texts = Vec::new();
    for folder in ["", "docs", "docs/decisions"] {
        for entry in std::fs::read_dir(repository.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(&repository).unwrap().to_owned();
            let is_skipped = NAMES_NO_FILE.iter().any(|n| name == Path::new(n));
            if path.extension().is_some_and(|e| e == "md") && !is_skipped {
                texts.push((name, std::fs::read_to_string(&path).unwrap()));
            }
        }
    }
    assert!(texts.len() > 30, "{} documents", texts.len());
    let mut named = 0;
    let mut gone = Vec::new();
    for (name, text) in &texts {
        for path in text.split('`').skip(1).step_by(2) {
            let roots = ["engine/", "server/", "tests/", "migrations/", "docker/"];
            let plain = |c: char| c.is_ascii_alphanumeric() || "/._-".contains(c);
            if !roots.iter().any(|root| path.starts_with(root)) || !path.chars().all(plain) {
                continue;
            }
            named += 1;
            if !repository.join(path).exists() {
                gone.push(format!("{}: {path}", name.display()));
            }
        }
    }
    assert!(named > 40, "{named} paths");
    assert!(gone.is_empty(), "\n{}", gone.join("\n"));
}

/// The circles of a crate in folder `x`.
fn circles(files: &[(&str, &str)]) -> Vec<String> {
    folders::circles(&Sources::of("x", files).uses())
}

#[test]
fn circles_are_found_at_every_level() {
    let files = [
        ("x/lib.rs", "mod a; mod b;"),
        ("x/a/mod.rs", "mod c; mod d; pub use c::e::E;"),
        ("x/a/c/mod.rs", "pub mod e; pub mod f;"),
        ("x/a/c/e.rs", "pub struct E;"),
        ("x/a/c/f.rs", "use super::super::d::D;"),
        ("x/a/d.rs", "pub struct D(super::E);"),
        ("x/b.rs", "use crate::a::E;"),
    ];
    assert_eq!(
        circles(&files),
        ["circle in x/a: c d\n  x/a/c/f.rs -> x/a/d.rs\n  x/a/d.rs -> x/a/c/e.rs"]
    );
}

#[test]
fn circles_are_found_through_reexports_macros_and_inline_paths() {
    let straight = [
        ("x/lib.rs", "pub mod a; mod b; pub use b::B;"),
        ("x/a.rs", "pub fn f() { crate::B::new(); }"),
        (
            "x/b.rs",
            "pub struct B; #[cfg(test)] mod tests { use crate::a::f; }",
        ),
    ];
    assert!(circles(&straight).is_empty());
    for back in [
        "pub struct B; use crate::a::f;",
        "pub struct B; fn g() { crate::a::f(); }",
        "pub struct B; use crate::a; fn g() { a::f(); }",
        "pub struct B; use super::*; fn g() { a::f(); }",
        "pub struct B; use crate::a::*; fn g() { f(); }",
        "pub struct B; fn g() { println!(\"{}\", crate::a::f()); }",
        "pub struct B { #[serde(with = \"crate::a::f\")] x: u8 }",
        "pub struct B; macro_rules! m { () => { $crate::a::f() }; }",
        "pub struct B; mod inner { use super::super::a::f; }",
    ] {
        let files = [straight[0], straight[1], ("x/b.rs", back)];
        assert_eq!(
            circles(&files),
            ["circle in x: a b\n  x/a.rs -> x/b.rs\n  x/b.rs -> x/a.rs"],
            "{back}"
        );
    }
    let folder = [
        ("x/lib.rs", "mod a;"),
        (
            "x/a/mod.rs",
            "mod b; mod c; pub use b::B; pub struct A; fn f(_: c::C) {}",
        ),
        ("x/a/b.rs", "pub struct B;"),
        ("x/a/c.rs", "pub struct C(super::A, super::B);"),
    ];
    let found = ["circle in x/a: c mod\n  x/a/c.rs -> x/a/mod.rs\n  x/a/mod.rs -> x/a/c.rs"];
    assert_eq!(circles(&folder), found);
    let beside = folder.map(|(file, text)| (file.trim_end_matches("/mod.rs"), text));
    let beside = beside.map(|(file, text)| (if file == "x/a" { "x/a.rs" } else { file }, text));
    let found = ["circle in x/a: c mod\n  x/a.rs -> x/a/c.rs\n  x/a/c.rs -> x/a.rs"];
    assert_eq!(circles(&beside), found);
}
