//! The modules of a crate, and which file uses which.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};

use super::reader::{Import, Module, Reader};

/// All modules of a crate by their path from its root.
pub struct Sources {
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
    pub fn read(root: &str) -> Self {
        let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let src = format!("{root}/src");
        let root = match repository.join(&src).exists() {
            true => &src,
            false => root,
        };
        let mut files = Vec::new();
        collect(&repository.join(root), &mut files);
        let read = |path: &PathBuf| {
            let text = std::fs::read_to_string(path).unwrap();
            let path = path.strip_prefix(&repository).unwrap();
            (path.to_str().unwrap().to_owned(), text)
        };
        let files: Vec<(String, String)> = files.iter().map(read).collect();
        assert!(!files.is_empty(), "{root} has no files");
        let files = files.iter().map(|(p, t)| (p.as_str(), t.as_str()));
        Self::of(root, &files.collect::<Vec<_>>())
    }

    pub fn of(root: &str, files: &[(&str, &str)]) -> Self {
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
        let reader = Reader::of(file, &path, &tokens);
        let (module, inner, tests) = (reader.module, reader.inner, reader.tests);
        self.modules.insert(path.clone(), module);
        self.tests.extend(tests);
        for (name, tokens) in inner {
            self.module(file, [path.clone(), vec![name]].concat(), tokens);
        }
    }

    /// Every use of one file by another.
    pub fn uses(&self) -> BTreeSet<(String, String)> {
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
