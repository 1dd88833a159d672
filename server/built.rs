//! What this program was built with, and what it says where something else is asked for.

/// What `veloid --version` says: the features, and whether this program has points to fail at.
pub const VERSION: &str = match cfg!(debug_assertions) {
    true => concat!(
        env!("CARGO_PKG_VERSION"),
        "\nfeatures: ",
        env!("VELOID_FEATURES"),
        "\nwith failure points, for tests"
    ),
    false => concat!(
        env!("CARGO_PKG_VERSION"),
        "\nfeatures: ",
        env!("VELOID_FEATURES")
    ),
};

/// Something that needs a Cargo feature which this program was built without.
#[derive(Clone, Debug, thiserror::Error)]
#[error(
    "{what}: this veloid is built without the feature `{feature}`; build it with `cargo build --release --features {feature}`"
)]
pub struct NotBuilt {
    what: String,
    feature: &'static str,
}

impl NotBuilt {
    pub fn of(feature: &'static str, what: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            feature,
        }
    }
}
