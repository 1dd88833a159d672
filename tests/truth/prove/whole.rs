//! All that docs/proof.md shows, filled in by one build in one run.

use std::path::{Path, PathBuf};

use super::origin::Origin;
use super::proof::{Proof, ProveError};
use super::{document, real, time};
use crate::suite::files::{self, Order};

/// What is to be filled in, of which document.
pub struct Whole {
    pub binary: Option<PathBuf>,
    pub seed: u64,
    pub work: PathBuf,
    pub docs: PathBuf,
    /// The folder of the real recordings.
    pub real: PathBuf,
}

/// The suites that have a key.
fn orders(seed: u64) -> [Order; 2] {
    [false, true].map(|clean300| Order {
        seed,
        one_in: 1,
        count: usize::MAX,
        clean300,
    })
}

/// Writes the hashes of the keys of a seed that was never used before into the document, to be committed alone.
pub fn seal(seed: u64, work: &Path, docs: &Path) -> Result<String, ProveError> {
    if mentions(&files::read(docs)?, seed) {
        return Err(ProveError::Used(seed));
    }
    let mut text = format!("To be run blind: `--seed {seed}`. SHA-256 of the keys:\n\n");
    for order in orders(seed) {
        let digest = files::make(&work.join(order.name()), &order)?;
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
    /// Suites, times and recordings, each in its own section.
    pub fn run(self) -> Result<String, ProveError> {
        let origin = Origin::of(self.binary.clone())?;
        let proofs = orders(self.seed).map(|order| Proof {
            binary: origin.binary.clone(),
            order,
            work: self.work.clone(),
            docs: Some(self.docs.clone()),
            origin: Some(origin.clone()),
            doubt: None,
        });
        // All keys before the first ride is run.
        let mut digests = Vec::new();
        for proof in &proofs {
            digests.push(proof.make()?);
        }
        let mut text = String::new();
        for (proof, digest) in proofs.iter().zip(digests) {
            text += &proof.judge(&digest)?;
        }
        text += &timing(&origin, self.seed, &self.work, &self.docs, "timing")?;
        text += &recordings(&origin, &self.real, &self.work, &self.docs)?;
        Ok(text)
    }
}

/// Writes how long rides take, one after the other; on a slower machine into a section of another name.
pub fn timing(
    origin: &Origin,
    seed: u64,
    work: &Path,
    docs: &Path,
    section: &str,
) -> Result<String, ProveError> {
    let table = time::alone(&origin.binary, seed, work)?;
    let title = match section {
        "timing" => "Time of a ride, alone on the machine",
        _ => "The same on a slower machine",
    };
    let text = format!("## {title}\n\nSeed {seed}. {}\n{table}", origin.line());
    document::insert(docs, section, &text)?;
    Ok(text)
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
