//! What a test says that cannot show anything here. cargo hides what a passing test writes, so it also goes
//! to the file that `VELOID_SKIPS` names, one line each, which `.ci/run` prints at its end.
// Included by the tests of engine, server and the binary, none of which needs all of it.
#![allow(dead_code)]

use std::fs::File;
use std::io::Write;
use std::path::PathBuf;

/// What the test needs is not here, but could have been installed, started or given.
pub fn skip(why: &str) {
    say("skipped", why);
}

/// Nothing is lacking: the other database, a release build, recordings that lie outside the repository.
pub fn not_applicable(why: &str) {
    say("not applicable", why);
}

fn say(what: &str, why: &str) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    eprintln!("{what}: {why}");
    let Some(file) = std::env::var_os("VELOID_SKIPS") else {
        return;
    };
    // One write of one line: what several processes append does not mix.
    let mut file = File::options()
        .create(true)
        .append(true)
        .open(file)
        .expect("VELOID_SKIPS names a file");
    file.write_all(format!("{what}\t{test}\t{why}\n").as_bytes())
        .expect("a line appended to VELOID_SKIPS");
}

/// A file of ../shared/real, or of `VELOID_SHARED/real`, where that folder is at hand.
pub fn recording(name: &str) -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared");
    let shared = std::env::var_os("VELOID_SHARED").map_or_else(|| beside.into(), PathBuf::from);
    let path = shared.join("real").join(name);
    if path.exists() {
        return Some(path);
    }
    not_applicable(&format!("../shared/real/{name} is not at hand"));
    None
}
