use jiff::Timestamp;
use serde_json::{Map, Value};

use super::Facts;
use super::error::FactsError;
use super::known::MOMENT;
use super::lines::of_lines;

/// Times at which a ride can have been recorded: the years 2000 to 2100 (s). A logger whose clock was never set begins earlier.
const EPOCH: std::ops::Range<f64> = 946_684_800.0..4_102_444_800.0;

/// The mean of the speed that was logged.
const SPEED: &str = "speed_m_s";

/// What a ride file says of its ride: in comments above the header, by the epoch (s) of its first sample where its stamps tell it, and by
/// its mean speed (m/s).
pub fn of_file(
    comments: Vec<(usize, String)>,
    begun_s: Option<f64>,
    speed: Option<f64>,
) -> Result<Map<String, Value>, FactsError> {
    let mut facts = of_lines(comments)?;
    if let Some(mean) = speed.and_then(rounded) {
        facts.entry(SPEED).or_insert(mean.into());
    }
    if let Some(at) = begun_s.and_then(stamped) {
        // A clock that is ahead knows no date.
        let dated = Map::from_iter([(MOMENT.to_owned(), Value::from(at))]);
        if Facts::try_from(dated.clone()).is_ok() {
            facts = dated.into_iter().chain(facts).collect();
        }
    }
    Ok(facts)
}

/// To a millimetre per second.
fn rounded(mean: f64) -> Option<f64> {
    mean.is_finite().then(|| (1e3 * mean).round() / 1e3)
}

fn stamped(begun_s: f64) -> Option<String> {
    let since_1970 = EPOCH.contains(&begun_s).then_some(begun_s as i64)?;
    Some(Timestamp::from_second(since_1970).ok()?.to_string())
}
