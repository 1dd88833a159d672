//! Has a binary identify a ride, as a user would.

use std::path::Path;
use std::process::{Command, Output, Stdio};

/// `BINARY identify RIDE --bike BIKE --json OUT` of the ride of that name in a folder.
pub fn ride(binary: &Path, folder: &Path, name: &str, out: &Path) -> std::io::Result<Output> {
    Command::new(binary)
        .arg("identify")
        .arg(folder.join(format!("ride_{name}.csv")))
        .arg("--bike")
        .arg(folder.join(format!("bike_{name}.json")))
        .arg("--json")
        .arg(out)
        .stdin(Stdio::null())
        .output()
}
