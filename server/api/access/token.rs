use sha2::{Digest, Sha256};

use crate::files::hex;

/// Where a key is found in the open, its prefix says what it is.
const PREFIX: &str = "veloid_";

/// A key in the clear, shown once to whoever makes it.
pub struct Token(pub String);

impl Token {
    /// 256 random bits of the operating system.
    pub fn draw() -> Result<Self, getrandom::Error> {
        let mut bits = [0; 32];
        getrandom::fill(&mut bits)?;
        Ok(Self(format!("{PREFIX}{}", hex(&bits))))
    }

    /// What is kept of it.
    pub fn sha256(&self) -> String {
        sha256(&self.0)
    }
}

pub fn sha256(token: &str) -> String {
    hex(&Sha256::digest(token))
}
