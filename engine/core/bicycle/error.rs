use super::{Axle, LimitError};

/// Largest bike file (bytes).
pub(super) const LARGEST_FILE: usize = 64 << 10;
/// Longest name of a bike (bytes).
pub(super) const LONGEST_NAME: usize = 200;

/// What is wrong with a bike file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BikeError {
    /// A value that no bicycle and no bench has.
    #[error("{key} is {value:?}, expected {low} to {high}{}", in_thousandths(.key, *.value, [*.low, *.high]))]
    OutOfRange {
        /// Its key.
        key: String,
        /// Value in the unit of the key's name.
        value: f64,
        /// Least value.
        low: f64,
        /// Largest value.
        high: f64,
    },
    /// The name takes too much room.
    #[error("bike: the name has {bytes} bytes, expected at most {LONGEST_NAME}")]
    NameTooLong {
        /// Its length.
        bytes: usize,
    },
    /// The name cannot stand in an address.
    #[error("bike: the name '{name}' is a step in a path, expected another name")]
    NameIsStep {
        /// The name.
        name: String,
    },
    /// The name holds a character that cannot be seen, or that turns the text around it.
    #[error("bike: U+{:04X} in the name, expected visible characters", *.character as u32)]
    NameUnseen {
        /// The character.
        character: char,
    },
    /// The file is longer than any bike file.
    #[error("{bytes} bytes, expected at most {LARGEST_FILE}")]
    TooLarge {
        /// Its length.
        bytes: usize,
    },
    /// The file is not the JSON of a bike file; says where and what.
    #[error("{0}")]
    Json(String),
    /// Keys that mean nothing here.
    #[error("unknown key {}, expected {}", .unknown.join(", "), .known.join(", "))]
    UnknownKeys {
        /// Those in the file, in quotes; at most five.
        unknown: Vec<String>,
        /// All that exist.
        known: Vec<String>,
    },
    /// What is fixed or bounded cannot be.
    #[error("fix or bound: {0}")]
    Limit(#[from] LimitError),
    /// A standard deviation of a mass that is to be estimated.
    #[error("{key} is {std:?}, but mass_{axle}_kg is null")]
    DeviationOfNoMass {
        /// Key of the deviation.
        key: String,
        /// The deviation (kg).
        std: f64,
        /// Axle whose mass is null.
        axle: Axle,
    },
    /// Neither a mass nor a force by which to estimate it.
    #[error("mass_{axle}_kg is null and the ride has no force_{} channel to estimate it from", match .axle { Axle::Front => "f", Axle::Rear => "r" })]
    NoMass {
        /// Axle whose mass is null.
        axle: Axle,
    },
}

/// The unit that a value seems to be in, where a thousandth of it would be in range.
fn in_thousandths(key: &str, value: f64, [low, high]: [f64; 2]) -> &'static str {
    let unit = match key.rsplit('_').next() {
        Some("m") => ": in millimetres or centimetres?",
        Some("kg") => ": in grams?",
        _ => return "",
    };
    let meant = 1e-3 * value;
    if value > high && (low..=high).contains(&meant) {
        unit
    } else {
        ""
    }
}
