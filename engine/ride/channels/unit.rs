//! Units that may stand in a header, and the factors that make them SI.

/// What a channel measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    Time,
    Length,
    Speed,
    Acceleration,
    Force,
    Angle,
    AngularRate,
    /// Crank rate, kept in revolutions per minute.
    Cadence,
}

use Dimension::*;

/// A unit as written in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    pub name: String,
    /// Multiplies the file's numbers to make them SI (rpm for cadence).
    pub scale: f64,
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const RPM: f64 = std::f64::consts::TAU / 60.0;
const G: f64 = veloid_core::bicycle::GRAVITY;

const UNITS: &[(Dimension, &[&str], f64)] = &[
    (
        Time,
        &["s", "sec", "secs", "second", "seconds", "unixtime"],
        1.0,
    ),
    (
        Time,
        &["ms", "msec", "millis", "millisecond", "milliseconds"],
        1e-3,
    ),
    (
        Time,
        &["us", "usec", "micros", "microsecond", "microseconds"],
        1e-6,
    ),
    (Time, &["ns", "nanos", "nanosecond", "nanoseconds"], 1e-9),
    (Time, &["min", "minute", "minutes"], 60.0),
    (Length, &["m", "metre", "meter", "metres", "meters"], 1.0),
    (
        Length,
        &[
            "mm",
            "millimetre",
            "millimeter",
            "millimetres",
            "millimeters",
        ],
        1e-3,
    ),
    (
        Length,
        &[
            "cm",
            "centimetre",
            "centimeter",
            "centimetres",
            "centimeters",
        ],
        1e-2,
    ),
    (Length, &["um"], 1e-6),
    (Length, &["in", "inch"], 0.0254),
    (Length, &["ft"], 0.3048),
    (Speed, &["m/s", "mps", "ms-1", "m.s-1", "m/sec"], 1.0),
    (Speed, &["mm/s"], 1e-3),
    (
        Speed,
        &["km/h", "kmh", "kph", "km/hr", "kmph", "kmh-1"],
        1.0 / 3.6,
    ),
    (Speed, &["mph", "mi/h"], 0.44704),
    (Speed, &["ft/s", "fps"], 0.3048),
    (
        Speed,
        &["knots", "knot", "kt", "kts", "kn"],
        1852.0 / 3600.0,
    ),
    (
        Acceleration,
        &[
            "m/s2", "ms2", "ms-2", "mps2", "m/s/s", "m.s-2", "m/sec2", "m/s**2",
        ],
        1.0,
    ),
    (Acceleration, &["mm/s2"], 1e-3),
    (Acceleration, &["cm/s2"], 1e-2),
    (Acceleration, &["ft/s2"], 0.3048),
    (Acceleration, &["g", "gs", "g's", "gn"], G),
    (Acceleration, &["mg"], 1e-3 * G),
    (Force, &["n", "newton", "newtons"], 1.0),
    (Force, &["kn"], 1e3),
    (Force, &["lbf"], 4.448_221_615_260_5),
    (Force, &["kgf"], G),
    (Angle, &["rad", "radian", "radians"], 1.0),
    (Angle, &["mrad"], 1e-3),
    (Angle, &["deg", "degree", "degrees"], DEGREE),
    (AngularRate, &["rad/s", "rad/sec", "rads-1"], 1.0),
    (AngularRate, &["mrad/s"], 1e-3),
    (AngularRate, &["deg/s", "dps", "deg/sec", "degs-1"], DEGREE),
    (AngularRate, &["rpm"], RPM),
    (Cadence, &["rpm", "1/min", "rev/min"], 1.0),
    (Cadence, &["hz", "1/s", "rps", "rev/s"], 60.0),
    (Cadence, &["rad/s"], 1.0 / RPM),
    (Cadence, &["deg/s"], DEGREE / RPM),
];

/// Units without a dimension of their own: a sensor's voltage stands for whatever it is mapped to.
const PLAIN: &[(&str, f64)] = &[("v", 1.0), ("volt", 1.0), ("mv", 1e-3), ("si", 1.0)];

impl Unit {
    pub fn si(dimension: Dimension) -> Self {
        Self {
            name: dimension.si_name().to_owned(),
            scale: 1.0,
        }
    }

    /// Of stamps that nothing else can be.
    pub fn milliseconds() -> Self {
        Self {
            name: "ms".to_owned(),
            scale: 1e-3,
        }
    }

    /// Of stamps that are times of day: they are in seconds since the first one.
    pub fn time_of_day() -> Self {
        Self {
            name: "time of day".to_owned(),
            scale: 1.0,
        }
    }

    /// The unit written as `text`, if it measures `dimension`.
    pub fn parse(text: &str, dimension: Dimension) -> Option<Self> {
        let key = normalise(text);
        // `hh:mm:ss` is how the cells are written, which say the rest.
        let is_pattern = dimension == Time && key.contains("hh:mm");
        let scale = UNITS
            .iter()
            .find(|(d, names, _)| *d == dimension && names.contains(&key.as_str()))
            .map(|(_, _, scale)| *scale)
            .or_else(|| PLAIN.iter().find(|(n, _)| *n == key).map(|(_, s)| *s))
            .or_else(|| is_pattern.then_some(1.0))?;
        Some(Self {
            name: text.trim().to_owned(),
            scale,
        })
    }

    /// Whether `text` is a unit of anything.
    pub fn is_one(text: &str) -> bool {
        let key = normalise(text);
        UNITS
            .iter()
            .any(|(_, names, _)| names.contains(&key.as_str()))
            || PLAIN.iter().any(|(n, _)| *n == key)
    }

    pub fn is_voltage(&self) -> bool {
        matches!(normalise(&self.name).as_str(), "v" | "volt" | "mv")
    }
}

impl Dimension {
    pub fn si_name(self) -> &'static str {
        match self {
            Time => "s",
            Length => "m",
            Speed => "m/s",
            Acceleration => "m/s^2",
            Force => "N",
            Angle => "rad",
            AngularRate => "rad/s",
            Cadence => "rpm",
        }
    }

    /// The units of this dimension, as people write them.
    pub fn units(self) -> &'static [&'static str] {
        match self {
            Time => &["s", "ms", "us", "ns", "min"],
            Length => &["m", "mm", "cm", "um", "in", "ft"],
            Speed => &["m/s", "mm/s", "km/h", "mph", "ft/s"],
            Acceleration => &["m/s^2", "mm/s^2", "cm/s^2", "ft/s^2", "g", "mg"],
            Force => &["N", "kN", "lbf", "kgf"],
            Angle => &["rad", "mrad", "deg"],
            AngularRate => &["rad/s", "mrad/s", "deg/s", "rpm"],
            Cadence => &["rpm", "Hz", "rad/s", "deg/s"],
        }
    }

    /// The same, for messages.
    pub fn expected(self) -> String {
        match self.units().split_last() {
            Some((last, others)) => format!("{} or {last}", others.join(", ")),
            None => String::new(),
        }
    }
}

/// Lower case, without blanks, brackets and carets, with ASCII in place of signs.
fn normalise(text: &str) -> String {
    let mut key = String::new();
    for c in text.trim().chars().flat_map(char::to_lowercase) {
        match c {
            ' ' | '^' | '(' | ')' | '\u{b7}' | '\u{22c5}' => {}
            '\u{207b}' | '\u{2212}' => key.push('-'),
            '\u{b9}' => key.push('1'),
            '\u{b5}' | '\u{3bc}' => key.push('u'),
            '\u{b2}' => key.push('2'),
            '\u{b0}' => key.push_str("deg"),
            '_' => key.push('/'),
            c => key.push(c),
        }
    }
    key
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn scales_are_exact() {
        let scale = |text, dimension| Unit::parse(text, dimension).map(|u| u.scale);
        assert_eq!(scale("mm", Length), Some(1e-3));
        assert_eq!(scale("\u{b5}m", Length), Some(1e-6));
        assert_eq!(scale("in", Length), Some(0.0254));
        assert_eq!(scale("km/h", Speed), Some(1.0 / 3.6));
        assert_eq!(scale("km_h", Speed), Some(1.0 / 3.6));
        assert_eq!(scale("m/s\u{b2}", Acceleration), Some(1.0));
        assert_eq!(scale("m/s^2", Acceleration), Some(1.0));
        assert_eq!(scale("m/(s^2)", Acceleration), Some(1.0));
        assert_eq!(scale("g", Acceleration), Some(9.80665));
        assert_eq!(scale("kN", Force), Some(1e3));
        assert_eq!(scale("min", Time), Some(60.0));
        assert_eq!(scale("\u{b0}/s", AngularRate), Some(DEGREE));
        assert!((scale("rad/s", Cadence).unwrap() - 9.549_296_585_513_72).abs() < 1e-12);
        assert_eq!(scale("V", Force), Some(1.0));
        assert_eq!(scale("HH:mm:ss.fff", Time), Some(1.0));
        assert_eq!(scale("hh:mm", Length), None);
    }

    #[test]
    fn other_dimensions_are_refused() {
        for (text, dimension) in [
            ("kg", Length),
            ("m", Force),
            ("furlong", Length),
            ("", Time),
        ] {
            assert_eq!(Unit::parse(text, dimension), None, "{text}");
        }
        assert!(Unit::is_one("km/h") && Unit::is_one("V") && !Unit::is_one("z_f"));
    }

    #[test]
    fn messages_list_only_units_that_are_known() {
        for d in [
            Time,
            Length,
            Speed,
            Acceleration,
            Force,
            Angle,
            AngularRate,
            Cadence,
        ] {
            for unit in d.units() {
                assert!(Unit::parse(unit, d).is_some(), "{unit}");
            }
            assert_eq!(Unit::parse(d.si_name(), d).unwrap().scale, 1.0);
        }
    }
}
