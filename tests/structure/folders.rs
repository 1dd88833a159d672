//! Circles among the entries of a folder, each with all that lies within.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A circle of each folder that has one, from the uses of one file by another. Files that use each other show in the
/// folder that holds them all.
pub fn circles(uses: &BTreeSet<(String, String)>) -> Vec<String> {
    let places: BTreeMap<&str, String> = places(uses);
    let folders: BTreeSet<&Path> = (places.values())
        .flat_map(|place| Path::new(place).ancestors().skip(1))
        .collect();
    let mut circles = Vec::new();
    for folder in folders {
        let steps: Vec<(&str, &str, String)> = uses
            .iter()
            .filter_map(|(from, to)| {
                let entry = |file: &str| entry(folder, &places[file]);
                let (a, b) = (entry(from)?, entry(to)?);
                (a != b).then(|| (a, b, format!("\n  {from} -> {to}")))
            })
            .collect();
        for knot in knots(steps.iter().map(|(a, b, _)| (*a, *b))) {
            let names: Vec<&str> = knot.iter().copied().collect();
            let inside = |(a, b, _): &&(&str, &str, String)| knot.contains(a) && knot.contains(b);
            let steps: String = (steps.iter().filter(inside))
                .map(|(_, _, step)| step.as_str())
                .collect();
            circles.push(format!(
                "circle in {}: {}{steps}",
                folder.display(),
                names.join(" ")
            ));
        }
    }
    circles
}

/// Where each file belongs: `a.rs` beside a folder `a` is in it, as `a/mod.rs` is.
fn places(uses: &BTreeSet<(String, String)>) -> BTreeMap<&str, String> {
    let files: BTreeSet<&str> = (uses.iter().flat_map(|(from, to)| [from, to]))
        .map(String::as_str)
        .collect();
    let place = |file: &&str| {
        let folder = file.trim_end_matches(".rs");
        match files.iter().any(|f| f.starts_with(&format!("{folder}/"))) {
            true => format!("{folder}/mod.rs"),
            false => (*file).to_owned(),
        }
    };
    files.iter().map(|file| (*file, place(file))).collect()
}

/// What a file belongs to within a folder: itself, or the folder in it that holds the file.
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
