//! A seed that nobody can know before the code is committed and the nonce is out.

use std::fmt;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::origin::{self, OriginError};
use crate::files::{self, FilesError};

/// What the program and its proof are made of.
const PARTS: [&str; 4] = ["engine", "server", "tests/truth", "Cargo.lock"];

#[derive(Debug, thiserror::Error)]
pub enum SealError {
    #[error("{0} is not a nonce of 8 hexadecimal digits or more")]
    Nonce(String),
    #[error(transparent)]
    Origin(#[from] OriginError),
    #[error(transparent)]
    Files(#[from] FilesError),
}

/// The seed, and what it was computed from.
#[derive(Clone, Debug)]
pub struct Seal {
    pub seed: u64,
    /// Git's ids of [`PARTS`].
    ids: [String; 4],
    nonce: String,
}

impl Seal {
    /// Of what is committed in `root`, and the nonce in a file.
    pub fn of(root: &Path, nonce: &Path) -> Result<Self, SealError> {
        let mut ids = [const { String::new() }; 4];
        for (id, part) in ids.iter_mut().zip(PARTS) {
            *id = origin::git(root, &["rev-parse", &format!("HEAD:{part}")])?;
        }
        let text = files::read(nonce)?.trim().to_owned();
        let is_hex = text.len() >= 8 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
        if !is_hex {
            return Err(SealError::Nonce(nonce.display().to_string()));
        }
        Ok(Self::from(ids, text))
    }

    fn from(ids: [String; 4], nonce: String) -> Self {
        let sum = Sha256::digest(format!("{}\n{nonce}", ids.join("\n")));
        let bytes = sum.iter().take(8);
        let first = bytes.fold(0, |number: u64, byte| number << 8 | u64::from(*byte));
        Self {
            seed: first >> 11,
            ids,
            nonce,
        }
    }

    #[cfg(test)]
    pub fn from_parts(ids: [&str; 4], nonce: &str) -> Self {
        Self::from(ids.map(str::to_owned), nonce.to_owned())
    }

    /// The ids of the trees, short.
    pub fn trees(&self) -> String {
        let short = |id: &String| id.chars().take(7).collect::<String>();
        self.ids.each_ref().map(short).join(" ")
    }

    /// The nonce's first digits.
    pub fn nonce(&self) -> String {
        self.nonce.chars().take(8).collect()
    }
}

impl fmt::Display for Seal {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "The seed {} is sealed by", self.seed)?;
        for (id, part) in self.ids.iter().zip(PARTS) {
            writeln!(f, "{id} {part}")?;
        }
        write!(f, "{} nonce", self.nonce)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seal(last: &str, nonce: &str) -> Seal {
        Seal::from_parts(["aa", "bb", "cc", last], nonce)
    }

    /// Computed apart from this, by `printf 'aa\nbb\ncc\ndd\n01234567' | sha256sum`.
    #[test]
    fn the_seed_is_the_head_of_a_hash() {
        assert_eq!(seal("dd", "01234567").seed, 0x2dca56c34f8a37d5 >> 11);
        assert_ne!(seal("ee", "01234567").seed, seal("dd", "01234567").seed);
        assert_ne!(seal("dd", "01234568").seed, seal("dd", "01234567").seed);
        assert!(
            seal("dd", "01234567")
                .to_string()
                .contains("cc tests/truth")
        );
    }
}
