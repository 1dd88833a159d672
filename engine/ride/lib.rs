//! A ride on one uniform clock, as every later step uses it.

mod band;
mod channels;
mod clocks;
mod error;
mod file;
mod formats;
mod logger;
mod options;
mod order;
mod preview_table;
#[cfg(test)]
mod properties;
mod rate_stamps;
mod read;
mod record;
mod recording;
mod several;
mod signals;
#[cfg(test)]
#[path = "../../tests/skips.rs"]
mod skips;
mod stamps;
mod table_layout;
#[cfg(test)]
mod tests;

pub use band::Band;
pub use channels::channel::{channels, is_unit};
pub use channels::guess::{Guess, guess};
pub use channels::sensor::{Placed, SensorKind, SensorRecord, channel_name, lacking};
pub use clocks::rates::RATES_HZ;
pub use clocks::sensor_clock::{ClockOffset, SensorClock};
pub use error::{Problem, ReadError};
pub use file::{Arrays, Content, FileSummary, RideFile, sha256_of};
pub use formats::comments::comments;
pub use formats::loggers::{KNOWN as KNOWN_LOGGERS, LoggerError, parse as parse_logger};
pub use logger::Logger;
pub use options::{FileOptions, Limits, ReadOptions};
pub use preview_table::{PreviewColumn, PreviewTable};
pub use read::{Preview, PreviewGap, parse_only, preview, read, read_on_clocks};
pub use record::{AxleRecord, Column, Ride, RideSummary, RoadDoubt};
pub use signals::clock_notes::unknown as unknown_clocks;
pub use signals::decimate::decimated;
pub use signals::delay::distance;
pub use table_layout::TableLayout;
