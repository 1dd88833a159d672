//! What one module defines, imports and names, read off its tokens.

use std::collections::BTreeSet;

use proc_macro2::{Delimiter, Ident, Spacing, TokenTree};

/// A path as it is written, and what it is called afterwards.
#[derive(Clone, Debug)]
pub struct Import {
    pub path: Vec<String>,
    /// Nothing where all names of a module are imported.
    pub name: Option<String>,
    pub reexport: bool,
}

/// One module: a file, or a block within one.
#[derive(Default)]
pub struct Module {
    pub file: String,
    pub items: BTreeSet<String>,
    pub imports: Vec<Import>,
    /// Paths of two names or more outside of `use`, and all names that stand alone.
    pub paths: Vec<Vec<String>>,
    pub names: BTreeSet<String>,
}

/// Reads a module, those within its file included.
pub struct Reader {
    path: Vec<String>,
    pub module: Module,
    /// Modules written within this file.
    pub inner: Vec<(String, Vec<TokenTree>)>,
    /// Paths of modules that only tests use.
    pub tests: Vec<Vec<String>>,
}

impl Reader {
    pub fn of(file: &str, path: &[String], tokens: &[TokenTree]) -> Self {
        let mut reader = Self {
            path: path.to_vec(),
            module: Module {
                file: file.to_owned(),
                ..Module::default()
            },
            inner: Vec::new(),
            tests: Vec::new(),
        };
        reader.read(tokens, true);
        reader
    }

    /// `top` where items are the module's, not a function's own.
    fn read(&mut self, tokens: &[TokenTree], top: bool) {
        let mut i = 0;
        while i < tokens.len() {
            if is_attribute(tokens, i) && is_test(&tokens[i + 1]) {
                i = self.past_test(tokens, i);
                continue;
            }
            i = match &tokens[i] {
                TokenTree::Ident(word) if word == "use" => self.import(tokens, i),
                TokenTree::Ident(word) if word == "mod" => self.inner(tokens, i),
                TokenTree::Ident(word) if top && defines(word) => self.item(tokens, i),
                TokenTree::Ident(word) if word == "pub" => i + 1,
                TokenTree::Ident(_) => self.path(tokens, i),
                TokenTree::Group(group) => {
                    let inside: Vec<TokenTree> = group.stream().into_iter().collect();
                    self.read(&inside, false);
                    i + 1
                }
                TokenTree::Literal(literal) => {
                    self.quoted(&literal.to_string());
                    i + 1
                }
                // A lifetime is no name.
                TokenTree::Punct(p) if p.as_char() == '\'' => i + 2,
                TokenTree::Punct(_) => i + 1,
            };
        }
    }

    /// Notes a `use` line and gives where it ends, as the following do.
    fn import(&mut self, tokens: &[TokenTree], start: usize) -> usize {
        let end = start + 1 + semicolon(&tokens[start + 1..]);
        let mut imports = Vec::new();
        tree(&tokens[start + 1..end], &[], &mut imports);
        let reexport = is_public(&tokens[..start]);
        let imports = imports.into_iter().map(|(path, name)| Import {
            path,
            name,
            reexport,
        });
        self.module.imports.extend(imports);
        end + 1
    }

    fn inner(&mut self, tokens: &[TokenTree], start: usize) -> usize {
        if let (Some(TokenTree::Ident(name)), Some(TokenTree::Group(body))) =
            (tokens.get(start + 1), tokens.get(start + 2))
        {
            let body = body.stream().into_iter().collect();
            self.inner.push((name.to_string(), body));
        }
        start + 3
    }

    /// Notes the name of an item, which is not one that is used.
    fn item(&mut self, tokens: &[TokenTree], start: usize) -> usize {
        let is_before = |t: &TokenTree| match t {
            TokenTree::Ident(word) => defines(word),
            TokenTree::Punct(p) => p.as_char() == '!',
            _ => false,
        };
        let before = tokens[start..].iter().take_while(|t| is_before(t)).count();
        if let Some(TokenTree::Ident(name)) = tokens.get(start + before) {
            self.module.items.insert(name.to_string());
        }
        start + before + 1
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
        i
    }
}

/// Words before the name of an item.
fn defines(word: &Ident) -> bool {
    const WORDS: [&str; 13] = [
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
    WORDS.iter().any(|w| word == w)
}

/// Whether what follows these tokens is `pub` or `pub(...)`.
fn is_public(before: &[TokenTree]) -> bool {
    let before = match before {
        [before @ .., TokenTree::Group(g)] if g.delimiter() == Delimiter::Parenthesis => before,
        _ => before,
    };
    matches!(before, [.., TokenTree::Ident(word)] if word == "pub")
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
