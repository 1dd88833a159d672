//! All that docs/proof.md shows, filled in by one build.

use std::path::{Path, PathBuf};

use super::begun::Register;
use super::budget::Budget;
use super::proof::{Proof, ProveError, Shown};
use super::real;
use super::times::Times;
use crate::suite::order::Order;
use crate::suite::order::Suite;

/// What is to be filled in, of which document.
pub struct Whole<'a> {
    pub register: &'a Register,
    /// The folder of the real recordings.
    pub real: PathBuf,
    pub budget: Budget,
}

impl Whole<'_> {
    /// Suites, times and recordings, each in its own section, until the budget is used; what is whole stays as it is.
    pub fn run(self) -> Result<String, ProveError> {
        let mut text = String::new();
        for suite in Suite::ALL {
            if !self.part(suite.name(), &mut text, || self.proof(suite).run())? {
                return Ok(text);
            }
        }
        let times = Times {
            register: self.register,
            section: "timing",
            budget: self.budget,
        };
        if self.part("timing", &mut text, || times.write())? {
            text += &recordings(self.register, &self.real)?;
        }
        Ok(text)
    }

    /// Adds what a section shows; whether it is whole.
    fn part(
        &self,
        section: &str,
        text: &mut String,
        run: impl FnOnce() -> Result<Shown, ProveError>,
    ) -> Result<bool, ProveError> {
        if self.register.is_whole(section)? {
            return Ok(true);
        }
        let shown = run()?;
        let is_whole = shown.is_whole();
        *text += &shown.said(section);
        Ok(is_whole)
    }

    fn proof(&self, suite: Suite) -> Proof {
        Proof {
            binary: self.register.origin.binary.clone(),
            order: Order {
                seed: self.register.seal.seed,
                one_in: 1,
                count: usize::MAX,
                suite,
            },
            work: self.register.work.clone(),
            register: Some(self.register.clone()),
            budget: self.budget,
            doubt: None,
        }
    }
}

/// Writes what is said of real recordings.
pub fn recordings(register: &Register, real: &Path) -> Result<String, ProveError> {
    let origin = &register.origin;
    let count = real::RECORDINGS.len();
    let listed = register.begin("real", count)?;
    let table = real::table(&origin.binary, real, &register.work.join("real"))?;
    let text = format!("## Real recordings\n\n{}\n{table}", origin.line());
    listed.write(&text, count, count)?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::super::begun;
    use super::*;

    /// Whoever reads the document knows every seed on which anything was developed or tried.
    #[test]
    fn every_seed_is_listed_in_the_proof() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let read = |name: &str| std::fs::read_to_string(root.join(name)).expect(name);
        let proof = read("docs/proof.md");
        let from = proof.find("## Seeds used").expect("a table of seeds");
        let listed = proof[from..].split("\n## ").next().unwrap_or_default();
        let mut texts = vec![proof.clone(), read(".ci/run")];
        let decisions = std::fs::read_dir(root.join("docs/decisions")).expect("decisions");
        let paths = decisions.map(|entry| entry.expect("an entry").path());
        texts.extend(paths.map(|path| std::fs::read_to_string(path).expect("a decision")));
        let sealed = begun::seeds(&root.join("docs/proof.md")).expect("a document");
        for seed in texts.iter().flat_map(|text| seeds(text)) {
            let known = mentions(listed, seed) || sealed.contains(&seed);
            assert!(known, "seed {seed} is not in the table of seeds");
        }
    }

    /// Whether a text has the number, by itself.
    fn mentions(text: &str, seed: u64) -> bool {
        text.split(|c: char| !c.is_ascii_alphanumeric())
            .any(|word| word == seed.to_string())
    }

    /// The numbers after "seed", "seeds" or "--seed", as far as they follow one another.
    fn seeds(text: &str) -> Vec<u64> {
        let mut found = Vec::new();
        for (at, _) in text.match_indices("seed") {
            let rest = text[at + 4..].trim_start_matches('s');
            let words = rest.split([' ', ',', ')', '.', ';', '\n', '`']);
            let words = words.filter(|word| !["", "and", "to"].contains(word));
            found.extend(words.map_while(|word| word.parse::<u64>().ok()));
        }
        found
    }
}
