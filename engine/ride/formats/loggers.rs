//! Loggers that are known: those of the program and those that a lab adds.

use std::borrow::Cow;
use std::sync::LazyLock;

use crate::channels::channel::{Channel, is_unit, with_unit};
use crate::logger::Logger;
use crate::options::ReadOptions;

/// Bytes of a file in which its logger is recognised.
const HEAD: usize = 8 << 10;

macro_rules! known {
    ($($name:literal)*) => {
        [$(include_str!(concat!("../loggers/", $name, ".toml"))),*]
    };
}

/// The program's own.
pub static KNOWN: LazyLock<Vec<Logger>> = LazyLock::new(|| {
    let texts = known![
        "aim" "gcdc" "goldencheetah" "graphtec" "labview" "mbient" "motec" "node-commander" "phyphox" "racechrono" "sensor-logger" "sensorconnect" "sensorlog" "trackaddict" "vbox"
    ];
    // A test reads every one of them.
    texts
        .into_iter()
        .filter_map(|text| parse(text).ok())
        .collect()
});

/// Why the file of a logger cannot be used.
#[derive(Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what each is")]
pub enum LoggerError {
    #[error("{0}")]
    Toml(String),
    #[error(
        "recognise is empty, expected texts that stand in the first 8 KiB of every file of this logger"
    )]
    NothingToRecognise,
    #[error(
        "columns.{column:?}: '{channel}' is no channel, expected one of {known}, perhaps with a unit as in v [km/h]"
    )]
    UnknownChannel {
        column: String,
        channel: String,
        known: String,
    },
    #[error("layout: {0}")]
    Layout(String),
}

/// Reads the description of a logger (TOML).
pub fn parse(text: &str) -> Result<Logger, LoggerError> {
    let logger: Logger = toml::from_str(text).map_err(|e| LoggerError::Toml(e.to_string()))?;
    if logger.recognise.iter().all(|text| text.trim().is_empty()) {
        return Err(LoggerError::NothingToRecognise);
    }
    for (column, channel) in &logger.columns {
        let is_known = match with_unit(channel) {
            Some((name, unit)) => is_unit(name, unit),
            None => Channel::named(channel).is_some(),
        };
        if !is_known {
            return Err(LoggerError::UnknownChannel {
                column: column.clone(),
                channel: channel.clone(),
                known: Channel::known(),
            });
        }
    }
    logger
        .layout
        .validate()
        .map_err(|fault| LoggerError::Layout(fault.to_string()))?;
    Ok(logger)
}

/// The logger that wrote a file which begins so; the lab's own come first.
pub fn of<'a>(head: &[u8], options: &'a ReadOptions) -> Option<&'a Logger> {
    let head = String::from_utf8_lossy(&head[..head.len().min(HEAD)]);
    let is_its = |logger: &&Logger| {
        logger
            .recognise
            .iter()
            .all(|text| head.contains(text.as_str()))
    };
    (options.loggers.iter()).chain(KNOWN.iter()).find(is_its)
}

/// The options with what is known of the file's logger; what the user says stays.
pub fn with<'a>(options: &'a ReadOptions, logger: Option<&Logger>) -> Cow<'a, ReadOptions> {
    let Some(logger) = logger else {
        return Cow::Borrowed(options);
    };
    let mut options = options.clone();
    options.missing.extend(logger.missing.iter().cloned());
    options.layout = options.layout.or(&logger.layout);
    let is_time = |channel: &str| channel.split(' ').next() == Some(Channel::Time.name());
    let named = logger.columns.iter();
    // A rate stands in place of times that may be blank.
    let named = named.filter(|(_, channel)| options.rate_hz.is_none() || !is_time(channel));
    options.named = named
        .map(|(column, channel)| (column.clone(), channel.clone()))
        .collect();
    Cow::Owned(options)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_description_in_the_folder_is_read() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/loggers");
        let files = std::fs::read_dir(folder).map_or(0, Iterator::count);
        assert_eq!(KNOWN.len(), files);
    }

    #[test]
    fn every_one_is_documented() {
        let docs = include_str!("../../../docs/loggers.md");
        for logger in KNOWN.iter() {
            assert!(
                docs.contains(&format!("| {} |", logger.name)),
                "{}",
                logger.name
            );
        }
    }

    #[test]
    fn faults_say_what_is_wrong() {
        let fault = |text: &str| parse(text).map_err(|fault| fault.to_string()).err();
        let says = |text: &str, words: &str| fault(text).is_some_and(|said| said.contains(words));
        assert!(says("name = 'x'", "recognise"));
        assert!(says("name = 'x'\nrecognise = []", "8 KiB"));
        assert!(says("name = 'x'\nrecognise = ['y']\ncolour = 1", "colour"));
        assert!(says(
            "name = 'x'\nrecognise = ['y']\ncolumns.a = 'speed'",
            "'speed'"
        ));
        assert!(says(
            "name = 'x'\nrecognise = ['y']\ncolumns.a = 'v [kg]'",
            "'v [kg]'"
        ));
        assert!(says(
            "name = 'x'\nrecognise = ['y']\nlayout.decimal = 'x'",
            "decimal"
        ));
        assert_eq!(
            fault("name = 'x'\nrecognise = ['y']\ncolumns.a = 'v [km/h]'"),
            None
        );
    }
}
