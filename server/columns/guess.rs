//! From a header to a channel.

use serde::Serialize;
use utoipa::ToSchema;

use super::words::{self, holds};

/// What a column may hold that no channel was recognised in.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = ColumnGuess)]
pub struct Guess {
    /// Header text as in the file.
    pub header: String,
    /// Channel that it may be.
    #[schema(value_type = String)]
    pub channel: &'static str,
    /// Unit that the header seems to end in but that is not read there: the channel would be taken as SI. In brackets it is read.
    pub unread_unit: Option<String>,
}

/// Guesses for these headers. A channel that is there already, or that two headers may be, is not guessed.
pub fn guesses<'a>(headers: &[String], known: impl Iterator<Item = &'a str>) -> Vec<Guess> {
    let known: Vec<&str> = known.collect();
    let all: Vec<Guess> = headers.iter().filter_map(|header| guess(header)).collect();
    let is_alone = |channel| all.iter().filter(|other| other.channel == channel).count() == 1;
    (all.iter())
        .filter(|guess| is_alone(guess.channel) && !known.contains(&guess.channel))
        .cloned()
        .collect()
}

fn guess(header: &str) -> Option<Guess> {
    let (name, is_bracketed) = without_unit(header);
    let unread = (!is_bracketed).then(|| ending(name)).flatten();
    let name = unread.map_or(name, |unit| &name[..name.len() - unit.len()]);
    Some(Guess {
        header: header.to_owned(),
        channel: channel(&words::of(name))?,
        unread_unit: unread.map(str::to_owned),
    })
}

/// The header before a unit in brackets, and whether there is one.
fn without_unit(header: &str) -> (&str, bool) {
    let header = header.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some(inside) = header.strip_suffix(close)
            && let Some((name, _)) = inside.rsplit_once(open)
        {
            return (name.trim_end(), true);
        }
    }
    (header, false)
}

/// Units other than SI as they end headers.
const UNITS: [&str; 26] = [
    "km/h", "kmh", "km_h", "kph", "mph", "mm/s", "ft/s", "mm", "cm", "µm", "um", "inch", "in",
    "ft", "ms", "us", "ns", "min", "mg", "g", "kn", "lbf", "kgf", "deg/s", "deg", "°",
];

/// The unit that a header ends in, behind a blank or an underscore.
fn ending(name: &str) -> Option<&str> {
    let start = name.len()
        - UNITS.iter().find_map(|unit| {
            let at = name.len().checked_sub(unit.len())?;
            let (before, end) = (name.get(..at)?, name.get(at..)?);
            let is_apart = before.ends_with([' ', '_']);
            (is_apart && end.to_lowercase() == *unit).then_some(unit.len())
        })?;
    name.get(start..)
}

/// The channel that these words name.
fn channel(words: &[String]) -> Option<&'static str> {
    let is = |known| holds(words, known);
    if is(words::OTHER) {
        return None;
    }
    if is(words::YAW) {
        return is(words::RATE).then_some("yaw_rate");
    }
    for (known, names) in [
        (words::ACCELERATION, ["a_f", "a_r"]),
        (words::ROAD, ["u_f", "u_r"]),
        (words::FORCE, ["force_f", "force_r"]),
        (words::DEFLECTION, ["d_f", "d_r"]),
        (words::DISPLACEMENT, ["z_f", "z_r"]),
    ] {
        if is(known) {
            return of_axle(words, names);
        }
    }
    if is(words::SPEED) {
        return Some(if is(words::LATERAL) { "v_lat" } else { "v" });
    }
    if is(words::RATE) {
        return None;
    }
    let rest = [
        (words::TIME, "t"),
        (words::CADENCE, "cadence"),
        (words::ROLL, "roll"),
        (words::STEER, "steer"),
    ];
    let found = rest.into_iter().find(|(known, _)| is(known));
    found.map(|(_, channel)| channel)
}

fn of_axle(words: &[String], [front, rear]: [&'static str; 2]) -> Option<&'static str> {
    match (holds(words, words::FRONT), holds(words, words::REAR)) {
        (true, false) => Some(front),
        (false, true) => Some(rear),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn headers_of_two_languages_are_guessed() {
        for (header, channel) in [
            ("AccZ_front [g]", "a_f"),
            ("Accel rear (m/s^2)", "a_r"),
            ("Vorderradbeschleunigung [m/s^2]", "a_f"),
            ("Beschl. hinten", "a_r"),
            ("Fahrbahn vorne [mm]", "u_f"),
            ("roadRear", "u_r"),
            ("Weg hinten [mm]", "z_r"),
            ("displacement_front", "z_f"),
            ("Laser rear [mm]", "d_r"),
            ("Kraft vorne [N]", "force_f"),
            ("Geschwindigkeit [km/h]", "v"),
            ("GPS speed", "v"),
            ("Quergeschwindigkeit", "v_lat"),
            ("Giergeschwindigkeit [deg/s]", "yaw_rate"),
            ("Yaw rate", "yaw_rate"),
            ("Zeit [s]", "t"),
            ("Timestamp (ms)", "t"),
            ("Trittfrequenz", "cadence"),
            ("Rollwinkel [deg]", "roll"),
            ("Lenkwinkel", "steer"),
        ] {
            let guess = guess(header).unwrap_or_else(|| panic!("{header}"));
            assert_eq!(
                (guess.channel, guess.unread_unit),
                (channel, None),
                "{header}"
            );
        }
    }

    #[test]
    fn what_may_be_anything_is_not_guessed() {
        for header in [
            "",
            "V1",
            "Weg",
            "AccZ",
            "AccX_front",
            "acc front rear",
            "steer torque",
            "roll rate",
            "Winkelbeschleunigung vorne",
            "Temperatur vorne",
            "GyroZ",
            "yaw",
            "max speed",
            "µ",
            "Druck hinten [bar]",
            "lat",
            "row",
        ] {
            assert_eq!(guess(header), None, "{header}");
        }
    }

    #[test]
    fn a_unit_that_is_not_read_is_reported() {
        for (header, channel, unit) in [
            ("Weg vorne mm", "z_f", "mm"),
            ("Geschwindigkeit km/h", "v", "km/h"),
            ("disp_rear_cm", "z_r", "cm"),
            ("AccZ_front g", "a_f", "g"),
        ] {
            let guess = guess(header).unwrap();
            assert_eq!(
                (guess.channel, guess.unread_unit.as_deref()),
                (channel, Some(unit))
            );
        }
        assert_eq!(guess("Weg vorne m").unwrap().unread_unit, None);
    }

    #[test]
    fn a_channel_is_guessed_once_and_only_where_it_is_not_there() {
        let headers = ["Weg vorne", "displacement front", "Weg hinten", "speed"].map(str::to_owned);
        let seen = guesses(&headers, ["v"].into_iter());
        let channels: Vec<&str> = seen.iter().map(|guess| guess.channel).collect();
        assert_eq!(channels, ["z_r"]);
    }
}
