//! The files of a crate use each other in one direction only, and so do their folders at every level. Between crates Cargo sees to it.
//!
//! What a file uses is read off its paths, in `use` lines and inline, each followed through re-exports to the file
//! that defines the item. Not counted: declarations of modules, re-exports, crate roots and `#[cfg(test)]`. Not seen: methods
//! that a file gives to a type of another one.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

const CRATES: [&str; 11] = [
    "engine/core",
    "engine/ride",
    "engine/report",
    "engine/methods",
    "engine/latent_road",
    "engine/mistakes",
    "engine/model",
    "engine/diagnosis",
    "engine/fourier",
    "engine",
    "server",
];

/// The folders of crates, from the top down; each may use those before it.
const MODEL: [&str; 5] = ["policy", "law", "effects", "dataset", "fit"];
const DIAGNOSIS: [&str; 6] = [
    "policy", "residual", "search", "verdict", "explain", "study",
];

#[test]
fn no_circle_of_files() {
    let circles = CRATES.map(|root| Sources::read(root).circles());
    let circles = circles.concat();
    assert!(circles.is_empty(), "\n{}", circles.join("\n"));
}

#[test]
fn no_circle_of_folders() {
    let circles = CRATES.map(|root| Sources::read(root).circles_of_folders());
    let circles = circles.concat();
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

#[test]
fn circles_of_folders_are_found_at_every_level() {
    let files = [
        ("x/lib.rs", "mod a; mod b;"),
        ("x/a/mod.rs", "mod c; mod d; pub use c::e::E;"),
        ("x/a/c/mod.rs", "pub mod e; pub mod f;"),
        ("x/a/c/e.rs", "pub struct E;"),
        ("x/a/c/f.rs", "use super::super::d::D;"),
        ("x/a/d.rs", "pub struct D(super::E);"),
        ("x/b.rs", "use crate::a::E;"),
    ];
    assert!(Sources::of("x", &files).circles().is_empty());
    assert_eq!(
        Sources::of("x", &files).circles_of_folders(),
        ["circle in x/a: c d\n  x/a/c/f.rs -> x/a/d.rs\n  x/a/d.rs -> x/a/c/e.rs"]
    );
}

#[test]
fn model_and_diagnosis_lead_one_way_down() {
    for (folder, order) in [
        ("engine/model", &MODEL[..]),
        ("engine/diagnosis", &DIAGNOSIS),
    ] {
        let wrong = Sources::read(folder).upward(folder, order);
        assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
    }
    let above: Vec<String> = (Sources::read("engine/core").uses().into_iter())
        .filter(|(from, to)| {
            let numerics = "engine/core/numerics";
            within(from, numerics) && !within(to, numerics)
        })
        .map(|(from, to)| format!("{from} uses {to}"))
        .collect();
    assert!(above.is_empty(), "\n{}", above.join("\n"));
}

#[test]
fn circles_are_found_through_reexports_macros_and_inline_paths() {
    let circles = |files: &[(&str, &str)]| Sources::of("x", files).circles();
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
            ["circle of 2 files: x/a.rs x/b.rs"],
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
    assert_eq!(circles(&folder), ["circle of 2 files: x/a/c.rs x/a/mod.rs"]);
}

#[test]
fn steps_upward_are_found() {
    let files = [
        ("x/lib.rs", "mod d;"),
        ("x/d/mod.rs", "mod one; mod two; mod run;"),
        ("x/d/one/mod.rs", "pub fn f() { super::two::g(); }"),
        ("x/d/one/more.rs", "use crate::d::run::h;"),
        ("x/d/run.rs", "use super::one::f; pub fn h() {}"),
        ("x/d/two/mod.rs", "mod g; pub use g::g;"),
        (
            "x/d/two/g.rs",
            "pub fn g() {} fn h() { crate::d::one::f(); }",
        ),
        ("x/d/other/mod.rs", ""),
    ];
    assert_eq!(
        Sources::of("x", &files).upward("x/d", &["one", "two"]),
        [
            "x/d/one/mod.rs uses x/d/two/g.rs, which stands below it",
            "x/d/one/more.rs uses x/d/run.rs, which stands below it",
            "x/d/other is not in the list of folders",
        ]
    );
}

/// Whether a file lies in a folder.
fn within(file: &str, folder: &str) -> bool {
    Path::new(file).starts_with(folder)
}

/// A path as it is written, and what it is called afterwards.
#[derive(Clone, Debug)]
struct Import {
    path: Vec<String>,
    /// Nothing where all names of a module are imported.
    name: Option<String>,
    reexport: bool,
}

/// One module: a file, or a block within one.
#[derive(Default)]
struct Module {
    file: String,
    items: BTreeSet<String>,
    imports: Vec<Import>,
    /// Paths of two names or more outside of `use`, and all names that stand alone.
    paths: Vec<Vec<String>>,
    names: BTreeSet<String>,
}

/// All modules of a crate by their path from its root.
struct Sources {
    modules: BTreeMap<Vec<String>, Module>,
    /// Files that only tests use.
    tests: BTreeSet<Vec<String>>,
}

enum Found {
    Module(Vec<String>),
    Item(String),
}

impl Sources {
    /// The crate in a folder of the repository.
    fn read(root: &str) -> Self {
        let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let mut files = Vec::new();
        collect(&repository.join(root), &mut files);
        let read = |path: PathBuf| {
            let text = std::fs::read_to_string(&path).unwrap();
            let path = path.strip_prefix(&repository).unwrap();
            (path.to_str().unwrap().to_owned(), text)
        };
        let files: Vec<(String, String)> = files.into_iter().map(read).collect();
        assert!(!files.is_empty(), "{root} has no files");
        let files: Vec<_> = files
            .iter()
            .map(|(p, t)| (p.as_str(), t.as_str()))
            .collect();
        Self::of(root, &files)
    }

    fn of(root: &str, files: &[(&str, &str)]) -> Self {
        let mut sources = Self {
            modules: BTreeMap::new(),
            tests: BTreeSet::new(),
        };
        for (file, text) in files {
            let tokens: TokenStream = text.parse().unwrap_or_else(|e| panic!("{file}: {e}"));
            let inside = Path::new(file).strip_prefix(root).unwrap();
            let mut path: Vec<String> = inside
                .with_extension("")
                .iter()
                .map(|part| part.to_str().unwrap().to_owned())
                .collect();
            let last = path.last().unwrap();
            if last == "mod" || path.len() == 1 && (last == "lib" || last == "main") {
                path.pop();
            }
            sources.module(file, path, tokens.into_iter().collect());
        }
        let tests = sources.tests.clone();
        let tested = |path: &Vec<String>| tests.iter().any(|t| path.starts_with(t));
        sources.modules.retain(|path, _| !tested(path));
        sources
    }

    fn module(&mut self, file: &str, path: Vec<String>, tokens: Vec<TokenTree>) {
        let mut reader = Reader {
            file,
            path: path.clone(),
            module: Module {
                file: file.to_owned(),
                ..Module::default()
            },
            inner: Vec::new(),
            tests: Vec::new(),
        };
        reader.read(&tokens, true);
        let (module, inner, tests) = (reader.module, reader.inner, reader.tests);
        self.modules.insert(path.clone(), module);
        self.tests.extend(tests);
        for (name, tokens) in inner {
            self.module(file, [path.clone(), vec![name]].concat(), tokens);
        }
    }

    /// Every use of one file by another.
    fn uses(&self) -> BTreeSet<(String, String)> {
        let mut uses = BTreeSet::new();
        for (path, module) in &self.modules {
            if path.is_empty() {
                continue;
            }
            let imports = module.imports.iter().filter(|import| {
                // A re-export counts if the file needs the name for itself.
                let name = import.name.as_ref();
                !import.reexport || name.is_some_and(|name| module.names.contains(name))
            });
            let imported = imports.map(|import| &import.path);
            for used in imported.chain(&module.paths) {
                if let Some(Found::Item(file)) = self.resolve(path, used, &mut BTreeSet::new()) {
                    uses.insert((module.file.clone(), file));
                }
            }
            // What comes with all names of a module.
            let named = module.imports.iter().filter_map(|i| i.name.as_ref());
            let known: BTreeSet<&String> = named.chain(&module.items).collect();
            for name in module.names.iter().filter(|name| !known.contains(name)) {
                if let Some(Found::Item(file)) = self.named(path, name, true, &mut BTreeSet::new())
                {
                    uses.insert((module.file.clone(), file));
                }
            }
        }
        let root = self.modules.get(&Vec::new()).map(|m| m.file.clone());
        uses.retain(|(from, to)| from != to && Some(to) != root.as_ref());
        uses
    }

    /// What a path means in a module; nothing for other crates and names of a function's own.
    fn resolve(
        &self,
        from: &[String],
        path: &[String],
        seen: &mut BTreeSet<(Vec<String>, String)>,
    ) -> Option<Found> {
        let mut at = from.to_vec();
        let mut rest = path;
        let mut relative = true;
        while let Some((first, more)) = rest.split_first() {
            match first.as_str() {
                "crate" => at.clear(),
                "self" => {}
                "super" => {
                    at.pop();
                }
                _ => break,
            }
            relative = false;
            rest = more;
        }
        let mut first = relative;
        while let Some((name, more)) = rest.split_first() {
            match self.named(&at, name, more.is_empty(), seen) {
                Some(Found::Module(module)) => at = module,
                Some(item) => return Some(item),
                // An item that a macro makes.
                None if !first => {
                    return self.modules.get(&at).map(|m| Found::Item(m.file.clone()));
                }
                None => return None,
            }
            first = false;
            rest = more;
        }
        Some(Found::Module(at))
    }

    fn named(
        &self,
        at: &[String],
        name: &str,
        last: bool,
        seen: &mut BTreeSet<(Vec<String>, String)>,
    ) -> Option<Found> {
        let child = [at, &[name.to_owned()]].concat();
        let child = self.modules.contains_key(&child).then_some(child);
        // Functions may be named as modules are: at the end of a path they are meant.
        if let Some(child) = child.clone().filter(|_| !last) {
            return Some(Found::Module(child));
        }
        let module = self.modules.get(at)?;
        if module.items.contains(name) {
            return Some(Found::Item(module.file.clone()));
        }
        if seen.insert((at.to_vec(), name.to_owned())) {
            let named = |i: &&Import| i.name.as_deref() == Some(name);
            for import in module.imports.iter().filter(named) {
                if let Some(found) = self.resolve(at, &import.path, seen) {
                    return Some(found);
                }
            }
            for import in module.imports.iter().filter(|i| i.name.is_none()) {
                if let Some(Found::Module(all)) = self.resolve(at, &import.path, seen)
                    && let Some(found) = self.named(&all, name, last, seen)
                {
                    return Some(found);
                }
            }
        }
        child.map(Found::Module)
    }

    /// Files that use each other, directly or through others.
    fn circles(&self) -> Vec<String> {
        let uses = self.uses();
        let edges = uses.iter().map(|(from, to)| (from.as_str(), to.as_str()));
        let report = |files: BTreeSet<&str>| {
            let inside = uses
                .iter()
                .filter(|(f, t)| files.contains(&f[..]) && files.contains(&t[..]));
            let steps: Vec<String> = inside.map(|(f, t)| format!("  {f} -> {t}")).collect();
            eprintln!("{}", steps.join("\n"));
            let names: Vec<&str> = files.iter().copied().collect();
            format!("circle of {} files: {}", files.len(), names.join(" "))
        };
        knots(edges).into_iter().map(report).collect()
    }

    /// Entries of a folder, each with all that lies within, that use each other.
    fn circles_of_folders(&self) -> Vec<String> {
        let uses = self.uses();
        let folders: BTreeSet<&Path> = uses
            .iter()
            .flat_map(|(from, to)| [from, to])
            .flat_map(|file| Path::new(file).ancestors().skip(1))
            .filter(|folder| !folder.as_os_str().is_empty())
            .collect();
        let mut circles = Vec::new();
        for folder in folders {
            let steps: Vec<(&str, &str, String)> = uses
                .iter()
                .filter_map(|(from, to)| {
                    let (a, b) = (entry(folder, from)?, entry(folder, to)?);
                    (a != b).then(|| (a, b, format!("  {from} -> {to}")))
                })
                .collect();
            for knot in knots(steps.iter().map(|(a, b, _)| (*a, *b))) {
                let names: Vec<&str> = knot.iter().copied().collect();
                let inside: Vec<&str> = steps
                    .iter()
                    .filter(|(a, b, _)| knot.contains(a) && knot.contains(b))
                    .map(|(_, _, step)| step.as_str())
                    .collect();
                circles.push(format!(
                    "circle in {}: {}\n{}",
                    folder.display(),
                    names.join(" "),
                    inside.join("\n")
                ));
            }
        }
        circles
    }

    /// Files of a folder's folders that use what stands below them, the files beside these folders included.
    fn upward(&self, folder: &str, order: &[&str]) -> Vec<String> {
        let level = |file: &str| -> Option<(usize, String)> {
            let inside = Path::new(file).strip_prefix(folder).ok()?;
            let name = match inside.iter().count() {
                1 => return Some((order.len(), String::new())),
                _ => inside.iter().next()?.to_str()?,
            };
            let at = order.iter().position(|o| *o == name);
            Some((at.unwrap_or(usize::MAX), name.to_owned()))
        };
        let uses = self.uses();
        let up = uses.iter().filter(|(from, to)| {
            matches!((level(from), level(to)), (Some((from, _)), Some((to, _))) if from < to)
        });
        let mut wrong: Vec<String> = up
            .map(|(from, to)| format!("{from} uses {to}, which stands below it"))
            .collect();
        let files: BTreeSet<&str> = self.modules.values().map(|m| m.file.as_str()).collect();
        let unknown: BTreeSet<String> = files
            .into_iter()
            .filter_map(level)
            .filter(|(at, _)| *at == usize::MAX)
            .map(|(_, name)| format!("{folder}/{name} is not in the list of folders"))
            .collect();
        wrong.extend(unknown);
        wrong
    }
}

/// What a file belongs to within a folder: `a` for `a.rs` and all of `a/`.
fn entry<'a>(folder: &Path, file: &'a str) -> Option<&'a str> {
    let inside = Path::new(file).strip_prefix(folder).ok()?;
    let first = inside.iter().next()?.to_str()?;
    Some(first.strip_suffix(".rs").unwrap_or(first))
}

/// Sets of nodes of a graph that each reach all others of their set and themselves.
fn knots<'a>(edges: impl Iterator<Item = (&'a str, &'a str)>) -> BTreeSet<BTreeSet<&'a str>> {
    let mut next: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (from, to) in edges {
        next.entry(from).or_default().insert(to);
    }
    let mut reach: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for from in next.keys() {
        let mut open = vec![*from];
        let seen = reach.entry(*from).or_default();
        while let Some(at) = open.pop() {
            for to in next.get(at).into_iter().flatten() {
                if seen.insert(*to) {
                    open.push(*to);
                }
            }
        }
    }
    let knot = |from: &&'a str| -> BTreeSet<&'a str> {
        let back = |to: &&str| reach.get(to).is_some_and(|back| back.contains(from));
        reach[from].iter().copied().filter(back).collect()
    };
    let all = reach.keys().map(knot);
    all.filter(|knot| !knot.is_empty()).collect()
}

/// The sources of a crate, its examples left out.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        let is_outside = ["examples", "tests"].contains(&name) || path.join("Cargo.toml").exists();
        if path.is_dir() && !is_outside {
            collect(&path, files);
        } else if path.extension().is_some_and(|e| e == "rs") && name != "main.rs" {
            files.push(path);
        }
    }
}

/// Reads what one module defines, imports and names.
struct Reader<'a> {
    file: &'a str,
    path: Vec<String>,
    module: Module,
    /// Modules written within this file.
    inner: Vec<(String, Vec<TokenTree>)>,
    tests: Vec<Vec<String>>,
}

impl Reader<'_> {
    /// `top` where items are the module's, not a function's own.
    fn read(&mut self, tokens: &[TokenTree], top: bool) {
        let mut i = 0;
        let mut public = false;
        while i < tokens.len() {
            if is_attribute(tokens, i) && is_test(&tokens[i + 1]) {
                i = self.past_test(tokens, i);
                continue;
            }
            match &tokens[i] {
                TokenTree::Ident(word) if word == "pub" => {
                    public = true;
                    let limit = matches!(tokens.get(i + 1), Some(TokenTree::Group(g)) if g.delimiter() == Delimiter::Parenthesis);
                    i += if limit { 2 } else { 1 };
                    continue;
                }
                TokenTree::Ident(word) if word == "use" => {
                    let end = i + 1 + semicolon(&tokens[i + 1..]);
                    let mut imports = Vec::new();
                    tree(&tokens[i + 1..end], &[], &mut imports);
                    for (path, name) in imports {
                        let reexport = public;
                        self.module.imports.push(Import {
                            path,
                            name,
                            reexport,
                        });
                    }
                    i = end + 1;
                }
                TokenTree::Ident(word) if word == "mod" => {
                    if let (Some(TokenTree::Ident(name)), Some(TokenTree::Group(body))) =
                        (tokens.get(i + 1), tokens.get(i + 2))
                    {
                        let body = body.stream().into_iter().collect();
                        self.inner.push((name.to_string(), body));
                    }
                    i += 3;
                }
                TokenTree::Ident(word) if top && defines(&word.to_string()) => {
                    let name = tokens[i + 1..].iter().find_map(|t| match t {
                        TokenTree::Ident(name) if !defines(&name.to_string()) => {
                            Some(name.to_string())
                        }
                        _ => None,
                    });
                    self.module.items.extend(name);
                    // The name is not one that is used.
                    i += 1;
                    while matches!(&tokens.get(i), Some(TokenTree::Ident(word)) if defines(&word.to_string()))
                        || matches!(&tokens.get(i), Some(TokenTree::Punct(p)) if p.as_char() == '!')
                    {
                        i += 1;
                    }
                    i += 1;
                }
                TokenTree::Ident(_) => i = self.path(tokens, i),
                TokenTree::Group(group) => {
                    let inside: Vec<TokenTree> = group.stream().into_iter().collect();
                    self.read(&inside, false);
                    i += 1;
                }
                TokenTree::Literal(literal) => {
                    self.quoted(&literal.to_string());
                    i += 1;
                }
                // A lifetime is no name.
                TokenTree::Punct(p) if p.as_char() == '\'' => i += 2,
                TokenTree::Punct(_) => i += 1,
            }
            public = false;
        }
    }

    /// Notes the path that begins here and gives where it ends.
    fn path(&mut self, tokens: &[TokenTree], start: usize) -> usize {
        let mut path = Vec::new();
        let mut i = start;
        while let Some(TokenTree::Ident(word)) = tokens.get(i) {
            path.push(word.to_string());
            i += 1;
            if !colons(tokens, i) {
                break;
            }
            i += 2;
        }
        // `::name` is another crate's, `.name` a field or a method.
        let outside = start >= 2 && colons(tokens, start - 2);
        let of_value = start >= 1
            && matches!(&tokens[start - 1], TokenTree::Punct(p) if p.as_char() == '.')
            && !(start >= 2
                && matches!(&tokens[start - 2], TokenTree::Punct(p) if p.as_char() == '.'));
        if !outside && !of_value {
            self.module.names.insert(path[0].clone());
            if path.len() > 1 {
                self.module.paths.push(path);
            }
        }
        i
    }

    /// A path in quotes, as attributes have it.
    fn quoted(&mut self, literal: &str) {
        let inside = literal.trim_matches('"');
        let path: Vec<String> = inside.split("::").map(str::to_owned).collect();
        let word =
            |w: &String| !w.is_empty() && w.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if literal.starts_with('"') && path.len() > 1 && path.iter().all(word) {
            self.module.paths.push(path);
        }
    }

    /// Behind an item that only tests see.
    fn past_test(&mut self, tokens: &[TokenTree], start: usize) -> usize {
        let mut i = start;
        while is_attribute(tokens, i) {
            i += 2;
        }
        let mut use_or_value = false;
        while let Some(token) = tokens.get(i) {
            i += 1;
            match token {
                TokenTree::Ident(word) if word == "use" || word == "const" || word == "static" => {
                    use_or_value = true;
                }
                TokenTree::Ident(word) if word == "mod" => {
                    if let Some(TokenTree::Ident(name)) = tokens.get(i) {
                        let path = [self.path.clone(), vec![name.to_string()]].concat();
                        self.tests.push(path);
                    }
                }
                TokenTree::Ident(word) if word == "fn" => use_or_value = false,
                TokenTree::Punct(p) if p.as_char() == ';' => break,
                TokenTree::Group(g) if g.delimiter() == Delimiter::Brace && !use_or_value => break,
                _ => {}
            }
        }
        assert!(i > start, "{}", self.file);
        i
    }
}

/// Words before the name of an item.
fn defines(word: &str) -> bool {
    let words = [
        "fn",
        "struct",
        "enum",
        "trait",
        "const",
        "static",
        "type",
        "union",
        "macro_rules",
        "unsafe",
        "async",
        "mut",
        "extern",
    ];
    words.contains(&word)
}

fn is_attribute(tokens: &[TokenTree], i: usize) -> bool {
    matches!(tokens.get(i), Some(TokenTree::Punct(p)) if p.as_char() == '#')
        && matches!(tokens.get(i + 1), Some(TokenTree::Group(g)) if g.delimiter() == Delimiter::Bracket)
}

fn is_test(attribute: &TokenTree) -> bool {
    attribute.to_string().replace(' ', "") == "[cfg(test)]"
}

fn colons(tokens: &[TokenTree], i: usize) -> bool {
    let colon = |t: Option<&TokenTree>| match t {
        Some(TokenTree::Punct(p)) if p.as_char() == ':' => Some(p.spacing()),
        _ => None,
    };
    // The colon before a type stands alone.
    colon(tokens.get(i)) == Some(Spacing::Joint) && colon(tokens.get(i + 1)).is_some()
}

/// Where the next semicolon stands.
fn semicolon(tokens: &[TokenTree]) -> usize {
    let is_end = |t: &TokenTree| matches!(t, TokenTree::Punct(p) if p.as_char() == ';');
    tokens.iter().position(is_end).unwrap_or(tokens.len())
}

/// The paths of a `use` line, each with its name here.
fn tree(tokens: &[TokenTree], before: &[String], imports: &mut Vec<(Vec<String>, Option<String>)>) {
    let comma = |t: &TokenTree| matches!(t, TokenTree::Punct(p) if p.as_char() == ',');
    for one in tokens.split(comma).filter(|one| !one.is_empty()) {
        let mut path = before.to_vec();
        let mut name = None;
        let mut words = one.iter();
        let mut whole = true;
        while let Some(token) = words.next() {
            match token {
                TokenTree::Ident(word) if word == "as" => {
                    name = words.next().map(ToString::to_string);
                }
                // `{self}` is the module itself.
                TokenTree::Ident(word) if word == "self" && !path.is_empty() => {
                    name = path.last().cloned();
                }
                TokenTree::Ident(word) => {
                    path.push(word.to_string());
                    name = Some(word.to_string());
                }
                TokenTree::Group(group) => {
                    let inside: Vec<TokenTree> = group.stream().into_iter().collect();
                    tree(&inside, &path, imports);
                    whole = false;
                }
                TokenTree::Punct(p) if p.as_char() == '*' => name = None,
                TokenTree::Punct(_) | TokenTree::Literal(_) => {}
            }
        }
        if whole {
            imports.push((path, name));
        }
    }
}
