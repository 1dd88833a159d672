//! The generated sections of docs/proof.md.

use std::path::Path;

use super::origin::Origin;
use super::score::{SHOWN, Scored};
use super::time::Timed;
use super::{conditions, tables, time};
use crate::files::{self, FilesError};
use crate::suite::order::Order;

/// Everything that one suite showed with the rides that are in, as Markdown.
pub fn section(
    order: &Order,
    digest: &str,
    ours: &[Scored],
    others: &[(&str, Vec<Scored>)],
    origin: Option<&Origin>,
) -> String {
    let mut methods: Vec<(&str, &[Scored])> = vec![("veloid", ours)];
    methods.extend(
        others
            .iter()
            .map(|(name, scored)| (*name, scored.as_slice())),
    );
    let mut text = format!(
        "## Suite `{}`\n\n{}",
        order.name(),
        preface(order, digest, ours, origin)
    );
    text += &tables::main_table(&methods, order.suite);
    text += "\n### Clean rides by noise\n\n";
    text += &tables::breakdown(ours, "noise, setting", |r| {
        (r.class == "clean").then(|| {
            format!(
                "{}, {}",
                r.noise,
                r.circumstance.as_ref().unwrap_or(&r.setting)
            )
        })
    });
    text += "\n### Coverage of k and B\n\n";
    text += &tables::coverage(ours);
    if !order.suite.is_clean() {
        text += "\n### By what is concealed\n\n";
        text += &tables::breakdown(ours, "concealed", concealed);
        text += "\n### Parameters of the effects found\n\n";
        text += &tables::parameters(ours);
        text += &conditions::table(ours);
    }
    text += "\n### Every ride that counts and was not answered right\n\n";
    text += &tables::confusions(ours);
    text += &format!(
        "\n### Time of a ride, {} at once\n\n",
        rayon::current_num_threads()
    );
    text += &time::table(&ours.iter().map(timed).collect::<Vec<_>>());
    text
}

fn preface(order: &Order, digest: &str, ours: &[Scored], origin: Option<&Origin>) -> String {
    let sample = if order.one_in > 1 {
        format!(", one in {}", order.one_in)
    } else {
        String::new()
    };
    let mut text = format!(
        "{} rides, {} seed {}{sample}. SHA-256 of the key: `{digest}`.\n",
        of(ours.len(), order.cases().len()),
        if origin.is_some() {
            "sealed"
        } else {
            "development"
        },
        order.seed
    );
    let concealing = ours.iter().filter(|r| r.class != "clean").count();
    if concealing > 0 {
        let shown = ours
            .iter()
            .filter(|r| r.class != "clean" && r.shown)
            .count();
        text += &format!(
            "Something is concealed in {concealing}; the plain model shows it (held-out RMS at least {SHOWN} x the floor) in {shown}, and these count.\n"
        );
    }
    text += &origin.map(Origin::line).unwrap_or_default();
    text + "\n"
}

/// How many are in: `120 of 330`.
pub fn of(rides: usize, planned: usize) -> String {
    format!("{rides} of {planned}")
}

fn timed(r: &Scored) -> Timed {
    Timed {
        class: r.class.clone(),
        duration_s: r.duration_s,
        seconds: r.outcome.seconds,
        verdict: r.outcome.verdict.clone(),
    }
}

fn concealed(r: &Scored) -> Option<String> {
    match (r.class.as_str(), &r.outside) {
        ("single", _) => r.truth.first().map(|(id, _)| format!("`{id}`")),
        ("outside", Some(id)) => Some(format!("not in the library: {id}")),
        ("two", _) => Some("two effects".to_owned()),
        ("beside", Some(id)) => Some(format!("beside {id}")),
        _ => None,
    }
}

/// Replaces what stands between the suite's two marks, or appends it.
pub fn insert(docs: &Path, suite: &str, text: &str) -> Result<(), FilesError> {
    let old = if docs.exists() {
        files::read(docs)?
    } else {
        "# Proof\n\n".to_owned()
    };
    files::write(docs, &replaced(&old, suite, text))
}

/// What stands between the marks of a section.
pub fn section_of<'a>(document: &'a str, name: &str) -> Option<&'a str> {
    let (_, after) = document.split_once(&begin(name))?;
    Some(after.split_once(&end(name))?.0)
}

fn begin(name: &str) -> String {
    format!("<!-- {name}: written by veloid-truth prove -->\n")
}

fn end(name: &str) -> String {
    format!("<!-- end of {name} -->\n")
}

fn replaced(old: &str, suite: &str, text: &str) -> String {
    let (begin, end) = (begin(suite), end(suite));
    let section = format!("{begin}\n{text}\n{end}");
    match (old.find(&begin), old.find(&end)) {
        (Some(from), Some(to)) if from < to => {
            format!("{}{section}{}", &old[..from], &old[to + end.len()..])
        }
        _ => format!("{old}\n{section}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_replaces_only_itself() {
        let first = replaced("# Proof\n", "standard", "one");
        let both = replaced(&first, "clean300", "two");
        let again = replaced(&both, "standard", "three");
        assert_eq!(section_of(&again, "standard"), Some("\nthree\n"));
        assert!(again.starts_with("# Proof\n"));
        assert!(again.contains("three") && again.contains("two") && !again.contains("one"));
        assert_eq!(replaced(&again, "standard", "three"), again);
    }
}
