//! From a header to a channel.

use serde::Serialize;

use super::channel::{behind_slash, is_unit};
use super::words::{self, holds};

/// What a column may hold in which no channel was recognised.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema), schema(as = ColumnGuess))]
pub struct Guess {
    /// Name of the file, where the ride has several.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(nullable = false))]
    pub file: Option<String>,
    /// Header text as in the file.
    pub header: String,
    /// Likely channel.
    #[cfg_attr(feature = "openapi", schema(value_type = String))]
    pub channel: &'static str,
    /// Unit at the end of the header that is only read if the mapping repeats it in brackets (`z_f=Weg vorne mm [mm]`);
    /// otherwise the column is read as SI.
    pub unread_unit: Option<String>,
    /// -1 for a distance to the road: set `deflection_sign` to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(nullable = false))]
    pub deflection_sign: Option<i8>,
}

/// The guess for one header; none where its words leave a choice.
pub fn guess(header: &str) -> Option<Guess> {
    let (name, is_bracketed) = without_unit(header);
    let unread = (!is_bracketed).then(|| ending(name)).flatten();
    let name = unread.map_or(name, |unit| &name[..name.len() - unit.len()]);
    let words = words::of(name);
    let channel = channel(&words)?;
    if unread.is_some_and(|unit| !is_unit(channel, unit)) {
        return None;
    }
    let is_distance = channel.starts_with("d_") && holds(&words, words::DISTANCE);
    Some(Guess {
        file: None,
        header: header.to_owned(),
        channel,
        unread_unit: unread.map(str::to_owned),
        deflection_sign: is_distance.then_some(-1),
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
    match behind_slash(header) {
        Some((name, _)) => (name, true),
        None => (header, false),
    }
}

/// Units other than SI as they end headers.
const UNITS: [&str; 32] = [
    "milliseconds",
    "millis",
    "microseconds",
    "micros",
    "nanoseconds",
    "minutes",
    "km/h",
    "kmh",
    "km_h",
    "kph",
    "mph",
    "mm/s",
    "ft/s",
    "mm",
    "cm",
    "µm",
    "um",
    "inch",
    "in",
    "ft",
    "ms",
    "us",
    "ns",
    "min",
    "mg",
    "g",
    "kn",
    "lbf",
    "kgf",
    "deg/s",
    "deg",
    "°",
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
        (words::DISTANCE, ["d_f", "d_r"]),
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
    // `ms_elapsed` is in no unit that is read.
    let found = found.filter(|(_, channel)| *channel != "t" || !is(words::PARTS));
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
    fn headers_in_english_and_german_are_guessed() {
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
            ("Einfederung vorne [mm]", "d_f"),
            ("Abstand Fahrbahn Gabel [mm]", "d_f"),
            ("acc_front_m_s2", "a_f"),
            ("time_s", "t"),
            ("time (ms)", "t"),
            ("Kraft vorne [N]", "force_f"),
            ("Geschwindigkeit [km/h]", "v"),
            ("GPS speed", "v"),
            ("Quergeschwindigkeit", "v_lat"),
            ("Giergeschwindigkeit [deg/s]", "yaw_rate"),
            ("Yaw rate", "yaw_rate"),
            ("Zeit [s]", "t"),
            ("Timestamp (ms)", "t"),
            ("seconds_elapsed", "t"),
            ("epoc (ms)", "t"),
            ("Weg vorne/mm", "z_f"),
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
    fn loggers_in_other_languages_are_guessed() {
        for (header, channel) in [
            ("temps (ms)", "t"),
            ("Tiempo [s]", "t"),
            ("tempo", "t"),
            ("Tijd (s)", "t"),
            ("accélération avant", "a_f"),
            ("aceleración trasera [g]", "a_r"),
            ("accelerazione posteriore", "a_r"),
            ("versnelling achter", "a_r"),
            ("distance fourche (mm)", "d_f"),
            ("distancia horquilla", "d_f"),
            ("distanza sella [mm]", "d_r"),
            ("afstand voorvork", "d_f"),
            ("vitesse [km/h]", "v"),
            ("velocidad", "v"),
            ("velocità", "v"),
            ("snelheid", "v"),
        ] {
            let guess = guess(header).unwrap_or_else(|| panic!("{header}"));
            assert_eq!(guess.channel, channel, "{header}");
        }
    }

    #[test]
    fn a_distance_to_the_road_is_a_deflection_turned_round() {
        for (header, channel) in [
            ("Abstand Gabel (mm)", "d_f"),
            ("Abstand Sattel (mm)", "d_r"),
            ("range_fork_mm", "d_f"),
            ("laser distance rear [mm]", "d_r"),
        ] {
            let guess = guess(header).unwrap();
            assert_eq!((guess.channel, guess.deflection_sign), (channel, Some(-1)));
        }
        for header in ["deflection front [mm]", "Weg vorne [mm]", "road front"] {
            assert_eq!(guess(header).unwrap().deflection_sign, None, "{header}");
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
            "distance",
            "Abstand (mm)",
            "orange front",
            "laser front kN",
            "ms_elapsed",
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
            ("time_ms", "t", "ms"),
            ("elapsed_millis", "t", "millis"),
        ] {
            let guess = guess(header).unwrap();
            assert_eq!(
                (guess.channel, guess.unread_unit.as_deref()),
                (channel, Some(unit))
            );
        }
        assert_eq!(guess("Weg vorne m").unwrap().unread_unit, None);
    }
}
