//! All that docs/proof.md shows, filled in by one build in one run.

use std::path::{Path, PathBuf};

use super::budget::Budget;
use super::origin::Origin;
use super::proof::{Proof, ProveError};
use super::times::Times;
use super::{document, real};
use crate::suite::case::Suite;
use crate::suite::files::{self, Order};
use crate::suite::made;

/// What is to be filled in, of which document.
pub struct Whole {
    pub binary: Option<PathBuf>,
    pub seed: u64,
    pub work: PathBuf,
    pub docs: PathBuf,
    /// The folder of the real recordings.
    pub real: PathBuf,
    pub budget: Budget,
}

/// The suites that have a key.
fn orders(seed: u64) -> [Order; 2] {
    [Suite::Standard, Suite::Clean300].map(|suite| Order {
        seed,
        one_in: 1,
        count: usize::MAX,
        suite,
    })
}

/// Writes the hashes of the keys of a seed that was never used before into the document, to be committed alone.
pub fn seal(seed: u64, work: &Path, docs: &Path) -> Result<String, ProveError> {
    if mentions(&files::read(docs)?, seed) {
        return Err(ProveError::Used(seed));
    }
    let mut text = format!("To be run blind: `--seed {seed}`. SHA-256 of the keys:\n\n");
    for order in orders(seed) {
        let digest = made::once(&work.join(order.name()), &order)?;
        text += &format!("- `{}`: `{digest}`\n", order.name());
    }
    document::insert(docs, "sealed", &text)?;
    Ok(text)
}

/// Whether a text has the number, by itself.
fn mentions(text: &str, seed: u64) -> bool {
    text.split(|c: char| !c.is_ascii_alphanumeric())
        .any(|word| word == seed.to_string())
}

impl Whole {
    /// Suites, times and recordings, each in its own section, until the budget is used.
    pub fn run(self) -> Result<String, ProveError> {
        let origin = Origin::of(self.binary.clone(), &self.docs)?;
        let proofs = orders(self.seed).map(|order| Proof {
            binary: origin.binary.clone(),
            order,
            work: self.work.clone(),
            docs: Some(self.docs.clone()),
            origin: Some(origin.clone()),
            budget: self.budget,
            doubt: None,
        });
        // All keys before the first ride is run.
        let mut made = Vec::new();
        for proof in &proofs {
            made.push(proof.make()?);
        }
        let mut text = String::new();
        for (proof, made) in proofs.iter().zip(&made) {
            let shown = proof.judge(made)?;
            let is_whole = shown.is_whole();
            text += &shown.said(proof.order.name());
            if !is_whole {
                return Ok(text);
            }
        }
        let times = Times {
            origin: &origin,
            seed: self.seed,
            work: &self.work,
            docs: &self.docs,
            section: "timing",
            budget: self.budget,
        };
        let shown = times.write()?;
        let is_whole = shown.is_whole();
        text += &shown.said(times.section);
        if !is_whole {
            return Ok(text);
        }
        text += &recordings(&origin, &self.real, &self.work, &self.docs)?;
        Ok(text)
    }
}

/// Writes what is said of real recordings.
pub fn recordings(
    origin: &Origin,
    real: &Path,
    work: &Path,
    docs: &Path,
) -> Result<String, ProveError> {
    let table = real::table(&origin.binary, real, &work.join("real"))?;
    let text = format!("## Real recordings\n\n{}\n{table}", origin.line());
    document::insert(docs, "real", &text)?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_that_was_ever_used_is_not_sealed() {
        let docs = std::env::temp_dir().join(format!("veloid-seal-{}.md", std::process::id()));
        std::fs::write(&docs, "| 103, 20261121 |").expect("written");
        let refused = seal(20261121, Path::new("nowhere"), &docs);
        assert!(matches!(refused, Err(ProveError::Used(20261121))));
        std::fs::remove_file(docs).expect("removed");
        assert!(!mentions("| 20261121 | `a103b` |", 103));
    }

    /// Whoever reads the document knows every seed on which anything was developed or tried.
    #[test]
    fn every_seed_is_listed_in_the_proof() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let read = |name: &str| std::fs::read_to_string(root.join(name)).expect(name);
        let proof = read("docs/proof.md");
        let from = proof.find("## Seeds").expect("a table of seeds");
        let listed = proof[from..].split("\n## ").next().unwrap_or_default();
        let mut texts = vec![proof.clone(), read(".ci/run")];
        let decisions = std::fs::read_dir(root.join("docs/decisions")).expect("decisions");
        let paths = decisions.map(|entry| entry.expect("an entry").path());
        texts.extend(paths.map(|path| std::fs::read_to_string(path).expect("a decision")));
        let sealed = proof.split("<!-- end of sealed").next().unwrap_or_default();
        for seed in texts.iter().flat_map(|text| seeds(text)) {
            let known = mentions(listed, seed) || sealed.contains(&format!("`--seed {seed}`"));
            assert!(known, "seed {seed} is not in the table of seeds");
        }
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
