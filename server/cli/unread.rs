//! Ride files that lack a channel: which column may hold it.

use veloid_engine::ride::{ReadError, ReadOptions, RideFile};

use super::CliError;
use crate::columns::{Guess, guesses};

/// Faults that a column with another name may explain.
const LACKING: [&str; 4] = [
    "time-missing",
    "axle-missing",
    "rear-road-missing",
    "no-channel",
];

/// The fault, with the options that name the columns, where a channel is missing.
pub fn explained(source: ReadError, files: &[RideFile<'_>], options: &ReadOptions) -> CliError {
    if !LACKING.contains(&source.kind()) {
        return source.into();
    }
    let preview = veloid_engine::ride::preview(files, options);
    let found = preview.map_or_else(|_| Vec::new(), |preview| guesses(&preview.tables));
    // A column of distances would need its sign as well, and a header with a separator in it is none.
    let is_whole = |guess: &Guess| !guess.header.contains([',', ';', '\t', '\n']);
    let found: Vec<Guess> = (found.into_iter())
        .filter(|guess| guess.deflection_sign.is_none() && is_whole(guess))
        .collect();
    let mut options: Vec<String> = found.iter().map(option).collect();
    if source.kind() == "time-missing" && found.iter().all(|guess| guess.channel != "t") {
        options.push("--map t=COLUMN, or --rate HZ without a column of time".to_owned());
    }
    match options.is_empty() {
        true => source.into(),
        false => CliError::Unread {
            source,
            options: options.join(" "),
        },
    }
}

/// As a shell takes it.
fn option(guess: &Guess) -> String {
    let file = guess.file.iter().map(|file| format!("{file}:"));
    let unit = guess.unread_unit.iter().map(|unit| format!(" [{unit}]"));
    let text: String = file
        .chain([format!("{}={}", guess.channel, guess.header)])
        .chain(unit)
        .collect();
    format!("--map '{}'", text.replace('\'', r"'\''"))
}
