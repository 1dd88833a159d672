//! Which build is proved, and of which commit.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use crate::files::{self, FilesError};

#[derive(Debug, thiserror::Error)]
pub enum OriginError {
    #[error("{what}: {why}")]
    Command { what: String, why: String },
    #[error("the tree is dirty, so no commit says what is proved; commit or stash:\n{0}")]
    Dirty(String),
    #[error(transparent)]
    Files(#[from] FilesError),
}

/// A binary and where it comes from.
#[derive(Clone, Debug)]
pub struct Origin {
    pub binary: PathBuf,
    commit: String,
    sha256: String,
    built: bool,
}

impl Origin {
    /// Builds the program, unless a binary is given, of a tree that is as committed; the document may hold what a run before
    /// has written.
    pub fn of(binary: Option<PathBuf>, docs: &Path) -> Result<Self, OriginError> {
        let commit = committed(Path::new("."), docs)?;
        let built = binary.is_none();
        let binary = match binary {
            Some(binary) => binary,
            None => build()?,
        };
        Ok(Self {
            sha256: sha256(&binary)?,
            binary,
            commit,
            built,
        })
    }

    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    pub fn commit(&self) -> &str {
        &self.commit
    }

    #[cfg(test)]
    pub fn given(commit: &str, sha256: &str) -> Self {
        Self {
            binary: PathBuf::from("veloid"),
            commit: commit.to_owned(),
            sha256: sha256.to_owned(),
            built: false,
        }
    }

    /// One line of the document.
    pub fn line(&self) -> String {
        let how = if self.built {
            "built by this run from"
        } else {
            "given, and said to be of"
        };
        format!(
            "Binary of SHA-256 `{}`, {how} commit `{}`; {}.\n",
            self.sha256,
            self.commit,
            machine()
        )
    }
}

/// SHA-256 of a file, in hexadecimal.
pub fn sha256(file: &Path) -> Result<String, FilesError> {
    files::read_bytes(file).map(files::digest)
}

/// The commit that the tree in `root` is at; refused where anything that git follows, the document aside, differs from it.
fn committed(root: &Path, docs: &Path) -> Result<String, OriginError> {
    let aside = format!(":(exclude){}", docs.display());
    let status = ["status", "--porcelain", "--untracked-files=no", "--", ":/"];
    let changed = git(root, &[&status[..], &[&aside]].concat())?;
    if !changed.is_empty() {
        return Err(OriginError::Dirty(changed));
    }
    git(root, &["rev-parse", "--short=12", "HEAD"])
}

fn build() -> Result<PathBuf, OriginError> {
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--release", "--locked", "-p", "veloid"]);
    done("cargo build", cargo.stderr(Stdio::inherit()).output())?;
    let target =
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    Ok(target.join("release/veloid"))
}

pub fn git(root: &Path, arguments: &[&str]) -> Result<String, OriginError> {
    let output = Command::new("git")
        .arg("-C")
        .arg(root)
        .args(arguments)
        .output();
    done(&format!("git {}", arguments[0]), output)
}

fn done(what: &str, output: std::io::Result<Output>) -> Result<String, OriginError> {
    let failed = |why: String| OriginError::Command {
        what: what.to_owned(),
        why,
    };
    let output = output.map_err(|error| failed(error.to_string()))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(failed(format!("{}: {}", output.status, said.trim())));
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Date and time, UTC.
pub fn today() -> Result<String, OriginError> {
    let output = Command::new("date").args(["-u", "+%F %H:%M"]).output();
    done("date", output)
}

/// The processor, and how many of it.
fn machine() -> String {
    let reported = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = reported
        .lines()
        .find_map(|line| Some(line.strip_prefix("model name")?.split_once(": ")?.1))
        .unwrap_or("processor unknown");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{model}, {cores} cores")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A repository of its own.
    struct Repository(PathBuf);

    impl Repository {
        fn new(name: &str) -> Self {
            let folder = std::env::temp_dir().join(format!("veloid-{name}-{}", std::process::id()));
            std::fs::create_dir_all(folder.join("docs")).expect("a folder");
            let made = Self(folder);
            made.git(&["init", "--quiet"]);
            made
        }

        fn git(&self, arguments: &[&str]) {
            let identity = ["-c", "user.name=a", "-c", "user.email=a@b"];
            git(&self.0, &[&identity, arguments].concat()).expect("git");
        }

        fn commit(&self, files: &[(&str, &str)]) {
            for (name, text) in files {
                std::fs::write(self.0.join(name), text).expect("written");
            }
            self.git(&["add", "."]);
            self.git(&["commit", "--quiet", "--message", "as it is"]);
        }
    }

    impl Drop for Repository {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn what_is_not_committed_is_not_proved() {
        let repository = Repository::new("dirty");
        repository.commit(&[("code.rs", "")]);
        repository.commit(&[("docs/proof.md", "Proof")]);
        let committed = || committed(&repository.0, Path::new("docs/proof.md"));
        std::fs::write(repository.0.join("docs/proof.md"), "120 of 330").expect("written");
        assert_eq!(committed().expect("a commit").len(), 12);
        std::fs::write(repository.0.join("code.rs"), "changed").expect("written");
        let refused = committed();
        assert!(matches!(refused, Err(OriginError::Dirty(what)) if what.contains("code.rs")));
    }
}
