//! Instants, and times of day in their usual writing.

use jiff::civil::{Date, Time};
use jiff::tz::Offset;

/// Epochs (s) of the years 1990 and 2100: a time stamp between them says when it was taken.
pub const EPOCHS_S: std::ops::Range<f64> = 631_152_000.0..4_102_444_800.0;
pub const DAY_S: i64 = 86_400;

/// An instant: whole seconds since 1970 (UTC), or since midnight where the day is not known, and the rest of a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    pub second: i64,
    pub part: f64,
    pub is_dated: bool,
}

impl Moment {
    pub fn of_day(time: Time) -> Self {
        let second = 3600 * i64::from(time.hour())
            + 60 * i64::from(time.minute())
            + i64::from(time.second());
        Self {
            second,
            part: 1e-9 * f64::from(time.subsec_nanosecond()),
            is_dated: false,
        }
    }

    /// `ahead_s`: how much the zone is ahead of UTC.
    pub fn dated(date: Date, time: Time, ahead_s: i64) -> Option<Self> {
        let at = Offset::UTC.to_timestamp(date.to_datetime(time)).ok()?;
        let nanoseconds = i64::from(at.subsec_nanosecond());
        Some(Self {
            second: at.as_second() - i64::from(nanoseconds < 0) - ahead_s,
            part: 1e-9 * nanoseconds.rem_euclid(1_000_000_000) as f64,
            is_dated: true,
        })
    }

    pub fn epoch_s(&self) -> f64 {
        self.second as f64 + self.part
    }

    /// Seconds since another one.
    pub fn since(&self, other: Moment) -> f64 {
        (self.second - other.second) as f64 + (self.part - other.part)
    }

    /// A time of day that follows `before`, perhaps on the next day.
    pub fn after(mut self, before: Moment) -> Self {
        if !self.is_dated {
            let days = (before.second - self.second + DAY_S / 2).div_euclid(DAY_S);
            self.second += DAY_S * days.max(0);
        }
        self
    }
}

/// `10:00:00.25`, `10:00`, `10:00:00,25`, `10:00:00:250`, `100000.25` or `10:00:00 PM`.
pub fn time_of_day(text: &str) -> Option<Time> {
    let text = text.trim_end_matches(['.', ',']);
    let mut plain = text.replace(',', ".");
    if plain.matches(':').count() == 3
        && let Some(last) = plain.rfind(':')
    {
        plain.replace_range(last..=last, ".");
    }
    let patterns: &[&str] = match plain.as_bytes().last() {
        Some(b'M' | b'm') => &["%I:%M:%S%.f %p", "%I:%M:%S%.f%p", "%I:%M %p"],
        _ if !plain.contains(':') => &["%H%M%S%.f"],
        _ => &["%H:%M:%S%.f", "%H:%M"],
    };
    patterns
        .iter()
        .find_map(|pattern| Time::strptime(pattern, &plain).ok())
}
