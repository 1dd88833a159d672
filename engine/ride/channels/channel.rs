//! The channels that a ride file may hold, and how their names stand in a header.

use crate::channels::unit::{Dimension, Unit};
use veloid_core::bicycle::Axle;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channel {
    Time,
    Road(Axle),
    Displacement(Axle),
    Deflection(Axle),
    Force(Axle),
    Acceleration(Axle),
    Speed,
    Cadence,
    Roll,
    Steer,
    YawRate,
    LateralSpeed,
}

use Axle::{Front, Rear};
use Channel::*;

impl Channel {
    pub const ALL: [Channel; 17] = [
        Time,
        Road(Front),
        Road(Rear),
        Displacement(Front),
        Displacement(Rear),
        Deflection(Front),
        Deflection(Rear),
        Force(Front),
        Force(Rear),
        Acceleration(Front),
        Acceleration(Rear),
        Speed,
        Cadence,
        Roll,
        Steer,
        YawRate,
        LateralSpeed,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Time => "t",
            Road(Front) => "u_f",
            Road(Rear) => "u_r",
            Displacement(Front) => "z_f",
            Displacement(Rear) => "z_r",
            Deflection(Front) => "d_f",
            Deflection(Rear) => "d_r",
            Force(Front) => "force_f",
            Force(Rear) => "force_r",
            Acceleration(Front) => "a_f",
            Acceleration(Rear) => "a_r",
            Speed => "v",
            Cadence => "cadence",
            Roll => "roll",
            Steer => "steer",
            YawRate => "yaw_rate",
            LateralSpeed => "v_lat",
        }
    }

    pub fn dimension(self) -> Dimension {
        match self {
            Time => Dimension::Time,
            Road(_) | Displacement(_) | Deflection(_) => Dimension::Length,
            Force(_) => Dimension::Force,
            Acceleration(_) => Dimension::Acceleration,
            Speed | LateralSpeed => Dimension::Speed,
            Cadence => Dimension::Cadence,
            Roll | Steer => Dimension::Angle,
            YawRate => Dimension::AngularRate,
        }
    }

    /// Another channel of the same axle, or of none, that this is a unit of.
    pub fn of_unit(self, unit: &str) -> Option<Self> {
        let axle = |channel: Self| match channel {
            Road(axle) | Displacement(axle) | Deflection(axle) | Force(axle)
            | Acceleration(axle) => Some(axle),
            _ => None,
        };
        let measures =
            |c: &Self| axle(*c) == axle(self) && Unit::parse(unit, c.dimension()).is_some();
        Self::ALL.into_iter().find(measures)
    }

    /// The channel called exactly `name`, in any case.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|c| c.name().eq_ignore_ascii_case(name.trim()))
    }

    /// Whether the identification stands on this channel.
    pub fn is_essential(self) -> bool {
        self.has_axle()
    }

    /// All names, for messages.
    pub fn known() -> String {
        Self::ALL.map(Self::name).join(", ")
    }

    fn has_axle(self) -> bool {
        matches!(
            self,
            Road(_) | Displacement(_) | Deflection(_) | Force(_) | Acceleration(_)
        )
    }
}

/// Every channel with the units that its numbers may have, SI first.
pub fn channels() -> impl Iterator<Item = (&'static str, &'static [&'static str])> {
    let all = Channel::ALL.into_iter();
    all.map(|channel| (channel.name(), channel.dimension().units()))
}

/// Whether `text` is a unit of this channel.
pub fn is_unit(channel: &str, text: &str) -> bool {
    Channel::named(channel).is_some_and(|c| Unit::parse(text, c.dimension()).is_some())
}

/// A header cell taken apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Heading<'a> {
    pub channel: Option<Channel>,
    /// Header text without the unit.
    pub name: &'a str,
    /// Unit as written, where one is.
    pub unit: Option<&'a str>,
    /// Whether the unit follows an underscore, where a part of the name may be mistaken for one.
    pub underscore: bool,
}

/// Takes `z_f`, `z_f [mm]`, `z_f (mm)`, `z_f:mm` or `z_f_mm` apart.
///
/// After an underscore only a unit of the right dimension counts, except on axle channels, where
/// any ending is taken for a unit (`z_f_furlong` is refused later, `steer_torque` is another column).
pub fn heading(cell: &str) -> Heading<'_> {
    let cell = cell.trim();
    let (name, unit) = split_unit(cell);
    if unit.is_some() {
        return Heading {
            channel: Channel::named(name),
            name,
            unit,
            underscore: false,
        };
    }
    if let Some(channel) = Channel::named(cell) {
        return Heading {
            channel: Some(channel),
            name: cell,
            unit: None,
            underscore: false,
        };
    }
    let suffixed = Channel::ALL.into_iter().find_map(|channel| {
        let head = cell.get(..channel.name().len())?;
        let ending = cell.get(channel.name().len()..)?.strip_prefix('_')?;
        let fits = head.eq_ignore_ascii_case(channel.name())
            && (channel.has_axle() || Unit::parse(ending, channel.dimension()).is_some());
        fits.then_some(Heading {
            channel: Some(channel),
            name: head,
            unit: Some(ending),
            underscore: true,
        })
    });
    suffixed.unwrap_or(Heading {
        channel: None,
        name: cell,
        unit: None,
        underscore: false,
    })
}

/// A column of a mapping and the unit in square brackets behind it: `Weg vorne mm [mm]`.
pub fn with_unit(column: &str) -> Option<(&str, &str)> {
    let (name, unit) = column.trim().strip_suffix(']')?.rsplit_once('[')?;
    Some((name.trim(), unit.trim()))
}

fn split_unit(cell: &str) -> (&str, Option<&str>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some(inside) = cell.strip_suffix(close)
            && let Some((name, unit)) = inside.rsplit_once(open)
        {
            return match counts(unit) {
                true => (cell, None),
                false => (
                    name.trim().trim_end_matches('/').trim_end(),
                    Some(unit.trim()),
                ),
            };
        }
    }
    if let Some((name, unit)) = behind_slash(cell) {
        return (name, Some(unit));
    }
    // `41:ch3` is the channel of a node.
    let is_unit = |name: &str, unit: &str| Unit::is_one(unit) || Channel::named(name).is_some();
    match cell.split_once(':') {
        Some((name, unit)) if !unit.trim().is_empty() && is_unit(name.trim(), unit.trim()) => {
            (name.trim(), Some(unit.trim()))
        }
        _ => (cell, None),
    }
}

/// `accSmooth[0]`, `timestamp (+0200)`: a number in the brackets is an index or a zone and belongs to the name.
fn counts(inside: &str) -> bool {
    let digits = inside.trim().trim_start_matches(['+', '-']);
    !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit())
}

/// `z_f/mm`, as DIN writes it; in `speed m/s` the slash belongs to the unit.
pub fn behind_slash(cell: &str) -> Option<(&str, &str)> {
    let (name, unit) = cell.split_once('/')?;
    let last = name.rsplit([' ', '_']).next()?;
    let word = &cell[name.len() - last.len()..];
    let is_apart = !name.trim().is_empty() && Unit::is_one(unit) && !Unit::is_one(word);
    is_apart.then(|| (name.trim(), unit.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_way_to_write_a_unit() {
        for cell in ["z_f [mm]", "z_f(mm)", " z_f:mm", "z_f_mm", "Z_F [ mm ]"] {
            let h = heading(cell);
            assert_eq!(
                (h.channel, h.unit),
                (Some(Displacement(Front)), Some("mm")),
                "{cell}"
            );
        }
        assert_eq!(heading("z_r").unit, None);
        assert_eq!(heading("v_lat").channel, Some(LateralSpeed));
        assert_eq!(heading("v_km_h").unit, Some("km_h"));
        assert_eq!(heading("yaw_rate_deg_s").channel, Some(YawRate));
        assert_eq!(heading("t_ms").channel, Some(Time));
    }

    #[test]
    fn units_behind_a_slash_and_indices_in_brackets() {
        for (cell, name, unit) in [
            ("z_f/mm", "z_f", Some("mm")),
            ("v/(km/h)", "v", Some("km/h")),
            ("Weg vorne / mm", "Weg vorne", Some("mm")),
            ("t/ms", "t", Some("ms")),
            ("v/km/h", "v", Some("km/h")),
            ("speed m/s", "speed m/s", None),
            ("m/s", "m/s", None),
            ("n/a", "n/a", None),
            ("accSmooth[0]", "accSmooth[0]", None),
            ("timestamp (+0200)", "timestamp (+0200)", None),
            ("a[2] [g]", "a[2]", Some("g")),
        ] {
            let found = heading(cell);
            assert_eq!((found.name, found.unit), (name, unit), "{cell}");
        }
        assert_eq!(heading("z_f/mm").channel, Some(Displacement(Front)));
    }

    #[test]
    fn other_columns_stay_other() {
        for cell in [
            "steer_torque",
            "t_gps",
            "velocity",
            "roll_rate",
            "",
            "V1 [V]",
            "\u{b5}",
        ] {
            assert_eq!(heading(cell).channel, None, "{cell}");
        }
        assert_eq!(heading("V1 [V]").name, "V1");
        assert_eq!(heading("41:ch3").name, "41:ch3");
        assert_eq!(heading("41:g").unit, Some("g"));
        assert_eq!(heading("z_f_furlong").unit, Some("furlong"));
    }

    #[test]
    fn names_round_trip() {
        for c in Channel::ALL {
            assert_eq!(Channel::named(c.name()), Some(c));
        }
    }
}
