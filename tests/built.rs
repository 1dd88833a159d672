//! The program under test, and what it says that it is built with.

use std::env;
use std::process::{Command, Output};
use std::sync::LazyLock;

use crate::skips::not_applicable;

/// The program under test: the one that was built with the tests, or what `VELOID_TEST_BINARY` names.
pub static VELOID: LazyLock<String> = LazyLock::new(|| {
    env::var("VELOID_TEST_BINARY").unwrap_or_else(|_| env!("CARGO_BIN_EXE_veloid").to_owned())
});

/// What it says of itself.
static SAID: LazyLock<String> = LazyLock::new(|| {
    let said = veloid(&["--version"]).stdout;
    String::from_utf8(said).unwrap()
});

/// Runs `veloid` to its end.
pub fn veloid(args: &[&str]) -> Output {
    Command::new(&*VELOID).args(args).output().unwrap()
}

/// Whether the program under test, whatever build the tests are, can be made to fail at labelled points; says so if not.
pub fn has_points() -> bool {
    let has = SAID.contains("with failure points");
    if !has {
        not_applicable("the program under test has no points to fail at");
    }
    has
}

/// Whether the program under test is built with a feature.
pub fn is_built_with(feature: &str) -> bool {
    let features = SAID
        .lines()
        .find_map(|line| line.strip_prefix("features: "));
    features
        .unwrap_or_default()
        .split(", ")
        .any(|f| f == feature)
}

/// The same, for a test that shows nothing otherwise and says so.
pub fn has(feature: &str) -> bool {
    let has = is_built_with(feature);
    if !has {
        not_applicable(&format!(
            "the program under test is built without the feature `{feature}`"
        ));
    }
    has
}

/// The PostgreSQL that `VELOID_TEST_POSTGRES` names, such as `postgres://postgres@127.0.0.1:5432`, where the program
/// under test and the tests themselves are built for it.
pub fn postgres() -> Option<String> {
    let server = env::var("VELOID_TEST_POSTGRES").ok()?;
    if !cfg!(feature = "postgres") {
        not_applicable("the tests are built without the feature `postgres`");
        return None;
    }
    has("postgres").then_some(server)
}
