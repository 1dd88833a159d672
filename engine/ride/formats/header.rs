//! From column names to channels and units.

use crate::channels::channel::{Channel, Heading, heading, with_unit};
use crate::channels::guess::guess;
use crate::channels::table::Spec;
use crate::channels::unit::Unit;
use crate::error::{Problem, ReadError};
use crate::formats::pace::{Pace, steadiest};
use crate::options::ReadOptions;

/// Columns that a file offers. `names` are blank in a file without a header.
pub struct Offered<'a> {
    pub names: &'a [String],
    /// A row of units below the header.
    pub units: &'a [String],
    /// Which columns hold times of day, with dates or without.
    pub are_times: &'a [bool],
    /// The steps of those columns whose cells are times or numbers that do not fall.
    pub paces: &'a [Option<Pace>],
    /// Line of the header.
    pub line: Option<usize>,
}

/// What was made of the columns.
#[derive(Debug, Default)]
pub struct Recognised {
    pub specs: Vec<Spec>,
    /// Channels of the mapping whose column is not here, but may be in another file.
    pub unfound: Vec<String>,
    pub ignored: Vec<String>,
    pub warnings: Vec<String>,
    /// What was assumed, in sentences.
    pub reading: Vec<String>,
}

/// Whether a header names a time, as `t_r` or `time_imu` do.
fn names_a_time(name: &str) -> bool {
    let first = name
        .split(|c: char| !c.is_alphanumeric())
        .next()
        .unwrap_or_default();
    first.eq_ignore_ascii_case(Channel::Time.name())
        || guess(name).is_some_and(|g| g.channel == Channel::Time.name())
}

/// What the words of a header name, and a unit at their end.
#[derive(Clone)]
struct Guessed {
    channel: Channel,
    unit: Option<String>,
}

impl Offered<'_> {
    /// Chooses the columns that hold channels: by the mapping first, then by name.
    pub fn recognise(&self, options: &ReadOptions) -> Result<Recognised, ReadError> {
        let mut channels: Vec<Option<Channel>> = vec![None; self.names.len()];
        let mut units: Vec<Option<&str>> = vec![None; self.names.len()];
        let mut unfound = Vec::new();
        for (name, column) in &options.map {
            let channel = Channel::named(name).ok_or_else(|| Problem::UnknownChannel {
                channel: name.clone(),
                known: Channel::known(),
            })?;
            self.is_clear(name, column)?;
            let Some((index, unit)) = self.find(column) else {
                if options.elsewhere.contains(name) {
                    unfound.push(name.clone());
                    continue;
                }
                let missing = Problem::MissingColumn {
                    channel: name.clone(),
                    column: column.clone(),
                    found: self.list(),
                };
                return Err(missing.into());
            };
            if let Some(other) = channels[index] {
                return Err(self.blame(index, duplicate(other, index + 1)));
            }
            channels[index] = Some(channel);
            units[index] = unit;
        }
        self.take_named(options, &mut channels, &mut units);
        let mapped = channels.clone();
        let mut out = Recognised {
            unfound,
            ..Recognised::default()
        };
        let named: Vec<Option<Channel>> = (self.names.iter().zip(&mapped))
            .map(|(name, mapped_to)| {
                let h = heading(name);
                let is_free = |c: &Channel| {
                    !(mapped.contains(&Some(*c)) || h.underscore && self.has_plain(*c))
                };
                mapped_to.or(h.channel.filter(is_free))
            })
            .collect();
        let guessed = self.guesses(&named, options);
        let is_time = |found: &Option<Guessed>| {
            found
                .as_ref()
                .is_some_and(|found| found.channel == Channel::Time)
        };
        let has_time = named.contains(&Some(Channel::Time)) || guessed.iter().any(is_time);
        for (index, name) in self.names.iter().enumerate() {
            let mut h = heading(name);
            let guess = guessed[index].as_ref();
            if let Some(guess) = guess {
                h.unit = h.unit.or(guess.unit.as_deref());
                let unit = h
                    .unit
                    .or(self.units.get(index).map(String::as_str))
                    .filter(|unit| !unit.is_empty());
                out.reading.push(format!(
                    "{name} is read as {} ({})",
                    guess.channel.name(),
                    unit.unwrap_or("no unit is stated")
                ));
            }
            let channel = named[index].or(guess.map(|guess| guess.channel));
            let Some(channel) = channel else {
                if !name.is_empty() {
                    if names_a_time(name) && has_time {
                        out.reading.push(format!(
                            "{name} may be a second time column and is not read: channels with times of their own belong in a file of their own"
                        ));
                    }
                    out.ignored.push(name.clone());
                }
                continue;
            };
            if let Some(first) = out.specs.iter().find(|s| s.channel == channel) {
                return Err(self.blame(index, duplicate(channel, first.number)));
            }
            let given = mapped[index].is_some().then_some(units[index]);
            let unit = self.unit(index, &h, channel, given)?;
            if unit.is_voltage() {
                out.warnings.push(format!(
                    "{name}: volts are read as {} of {}",
                    channel.dimension().si_name(),
                    channel.name()
                ));
            }
            out.specs.push(Spec {
                number: index + 1,
                header: name.clone(),
                channel,
                unit,
                is_guess: guess.is_some(),
            });
        }
        Ok(out)
    }

    /// Takes the columns that the file's logger names, where neither the user nor another column has their channel.
    fn take_named<'o>(
        &self,
        options: &'o ReadOptions,
        channels: &mut [Option<Channel>],
        units: &mut [Option<&'o str>],
    ) {
        for (column, text) in &options.named {
            let (name, unit) = match with_unit(text) {
                Some((name, unit)) => (name, Some(unit)),
                None => (text.as_str(), None),
            };
            let Some(channel) = Channel::named(name) else {
                continue;
            };
            let is_there = channels.contains(&Some(channel))
                || self
                    .names
                    .iter()
                    .any(|name| heading(name).channel == Some(channel));
            let index = self
                .names
                .iter()
                .position(|name| name == column)
                .or_else(|| {
                    self.names
                        .iter()
                        .position(|name| heading(name).name == column)
                });
            if let Some(index) = index.filter(|index| !is_there && channels[*index].is_none()) {
                channels[index] = Some(channel);
                // The header's own unit is nearer to the file.
                let is_stated = heading(&self.names[index]).unit.is_some()
                    || self.units.get(index).is_some_and(|unit| !unit.is_empty());
                units[index] = unit.filter(|_| !is_stated);
            }
        }
    }

    /// Channels that words of the headers name, where one column alone may hold them, nothing else does and the unit is stated; a time
    /// without one is looked at later.
    fn guesses(&self, named: &[Option<Channel>], options: &ReadOptions) -> Vec<Option<Guessed>> {
        let of_name = |(index, name): (usize, &String)| -> Option<Guessed> {
            let found =
                guess(name).filter(|g| named[index].is_none() && g.deflection_sign.is_none())?;
            let channel = Channel::named(found.channel)?;
            let is_open =
                !named.contains(&Some(channel)) && !options.map.contains_key(channel.name());
            let below = self.units.get(index).filter(|unit| !unit.is_empty());
            let has_unit =
                found.unread_unit.is_some() || heading(name).unit.is_some() || below.is_some();
            (is_open && (has_unit || channel == Channel::Time)).then_some(Guessed {
                channel,
                unit: found.unread_unit,
            })
        };
        let all: Vec<Option<Guessed>> = self.names.iter().enumerate().map(of_name).collect();
        let are = |channel: Channel| {
            let at = 0..all.len();
            at.filter(|at| {
                all[*at]
                    .as_ref()
                    .is_some_and(|found| found.channel == channel)
            })
            .collect::<Vec<usize>>()
        };
        let is_chosen = |index: usize, found: &Guessed| match are(found.channel).as_slice() {
            [_] => true,
            several => {
                found.channel == Channel::Time && steadiest(several, self.paces) == Some(index)
            }
        };
        all.iter()
            .enumerate()
            .map(|(index, found)| found.clone().filter(|found| is_chosen(index, found)))
            .collect()
    }

    /// The unit that the mapping `given` for the column says, else that in the header, else in the units row, else SI.
    fn unit(
        &self,
        index: usize,
        heading: &Heading<'_>,
        channel: Channel,
        given: Option<Option<&str>>,
    ) -> Result<Unit, ReadError> {
        let dimension = channel.dimension();
        if channel == Channel::Time && self.are_times.get(index) == Some(&true) {
            // A bracket behind its name says how they are written, as in `loggingTime(txt)`.
            return Ok(Unit::si(dimension));
        }
        let in_header = heading.unit.filter(|unit| {
            // The name of a mapped column is free text: its ending need not be a unit.
            !(given.is_some() && heading.underscore) || Unit::parse(unit, dimension).is_some()
        });
        let below = self.units.get(index).map(String::as_str);
        let text = given.flatten().or(in_header).or(below).unwrap_or_default();
        let text = text.trim_matches(['[', ']', '(', ')', ' ']);
        if text.is_empty() || text == "-" {
            return Ok(Unit::si(dimension));
        }
        Unit::parse(text, dimension).ok_or_else(|| {
            self.blame(
                index,
                Problem::UnknownUnit {
                    unit: text.to_owned(),
                    channel: channel.name(),
                    expected: match channel.of_unit(text) {
                        Some(other) => format!(
                            "{}; {text} is a unit of {}",
                            dimension.expected(),
                            other.name()
                        ),
                        None => dimension.expected(),
                    },
                },
            )
        })
    }

    /// A column of the mapping, and the unit that it gives to it.
    fn find<'c>(&self, column: &'c str) -> Option<(usize, Option<&'c str>)> {
        let uncommented = column.trim_start_matches(['%', '#', ';', ' ']);
        let plain = self.named(column).or_else(|| self.named(uncommented));
        let plain = plain.map(|index| (index, None));
        plain.or_else(|| {
            let (name, unit) = with_unit(uncommented)?;
            Some((self.named(name)?, Some(unit)))
        })
    }

    /// Refuses a name without a unit that several columns have.
    fn is_clear(&self, channel: &str, column: &str) -> Result<(), Problem> {
        let column = column.trim();
        let whole = |n: &&String| n.eq_ignore_ascii_case(column);
        let part = |n: &&String| heading(n).name.eq_ignore_ascii_case(column);
        let found: Vec<String> = self.names.iter().filter(part).cloned().collect();
        match found.len() > 1 && self.names.iter().filter(whole).count() == 0 {
            true => Err(Problem::AmbiguousColumn {
                channel: channel.to_owned(),
                column: column.to_owned(),
                found: found.join(", "),
            }),
            false => Ok(()),
        }
    }

    /// A column by its header text, by its name without the unit, or by its number.
    fn named(&self, column: &str) -> Option<usize> {
        let column = column.trim();
        let by = |f: &dyn Fn(&str) -> bool| self.names.iter().position(|n| f(n));
        let without_unit = |n: &str| heading(n).name.eq_ignore_ascii_case(column);
        if column.is_empty() {
            return None;
        }
        by(&|n| n == column)
            .or_else(|| by(&|n| n.eq_ignore_ascii_case(column)))
            .or_else(|| by(&without_unit))
            .or_else(|| {
                let number: usize = column.parse().ok()?;
                (1..=self.names.len()).contains(&number).then(|| number - 1)
            })
    }

    fn has_plain(&self, channel: Channel) -> bool {
        self.names
            .iter()
            .any(|n| Channel::named(n) == Some(channel))
    }

    fn blame(&self, index: usize, problem: Problem) -> ReadError {
        let error = ReadError::from(problem).in_column(index + 1, &self.names[index]);
        match self.line {
            Some(line) => error.at_line(line),
            None => error,
        }
    }

    /// The columns, for messages.
    pub fn list(&self) -> String {
        let mut shown: Vec<String> = (self.names.iter().enumerate().take(20))
            .map(|(i, n)| match n.as_str() {
                "" => (i + 1).to_string(),
                n => n.chars().take(40).collect(),
            })
            .collect();
        if self.names.len() > shown.len() {
            shown.push(format!("{} more", self.names.len() - shown.len()));
        }
        shown.join(", ")
    }
}

fn duplicate(channel: Channel, first: usize) -> Problem {
    Problem::DuplicateColumn {
        channel: channel.name().to_owned(),
        first,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn recognise(names: &str, units: &str, map: &[(&str, &str)]) -> Result<Recognised, ReadError> {
        let split = |s: &str| -> Vec<String> { s.split(',').map(|s| s.trim().into()).collect() };
        let map = map
            .iter()
            .map(|(a, b)| ((*a).into(), (*b).into()))
            .collect();
        let options = ReadOptions {
            map,
            ..ReadOptions::default()
        };
        let units = if units.is_empty() {
            Vec::new()
        } else {
            split(units)
        };
        Offered {
            names: &split(names),
            units: &units,
            are_times: &[],
            paces: &[],
            line: Some(1),
        }
        .recognise(&options)
    }

    fn found(names: &str, units: &str, map: &[(&str, &str)]) -> Vec<(usize, &'static str, f64)> {
        let out = recognise(names, units, map).unwrap();
        out.specs
            .iter()
            .map(|s| (s.number, s.channel.name(), s.unit.scale))
            .collect()
    }

    #[test]
    fn channels_by_name_and_by_mapping() {
        assert_eq!(
            found("t,z_f [mm],gps", "", &[]),
            [(1, "t", 1.0), (2, "z_f", 1e-3)]
        );
        assert_eq!(
            found("V1,V2 [mV],", "", &[("force_f", "V1"), ("z_f", "v2")]),
            [(1, "force_f", 1.0), (2, "z_f", 1e-3)]
        );
        assert_eq!(
            found(",,,", "", &[("t", "2"), ("z_f", "3")]),
            [(2, "t", 1.0), (3, "z_f", 1.0)]
        );
        assert_eq!(
            found("z_f,raw_in", "", &[("z_f", "raw_in")]),
            [(2, "z_f", 1.0)]
        );
        assert_eq!(
            found("z_f_raw", "", &[("z_f", "z_f_raw")]),
            [(1, "z_f", 1.0)]
        );
        assert_eq!(found("z_f_raw,z_f", "", &[]), [(2, "z_f", 1.0)]);
        assert_eq!(
            found("t,z_f", "ms,(mm)", &[]),
            [(1, "t", 1e-3), (2, "z_f", 1e-3)]
        );
        assert_eq!(recognise("t,z_f,gps,", "", &[]).unwrap().ignored, ["gps"]);
    }

    #[test]
    fn a_mapping_may_give_the_unit() {
        for (names, units, column, scale) in [
            ("Weg vorne mm", "", "Weg vorne mm [mm]", 1e-3),
            ("disp_f", "", "1 [cm]", 1e-2),
            ("disp [mm]", "", "disp [mm]", 1e-3),
            ("disp [mm]", "", "disp [mm] [cm]", 1e-2),
            ("disp [mm]", "", "disp [cm]", 1e-2),
            ("disp", "mm", "disp [um]", 1e-6),
        ] {
            assert_eq!(
                found(names, units, &[("z_f", column)]),
                [(1, "z_f", scale)],
                "{column}"
            );
        }
        let fault = |column| {
            let fault = recognise("t,disp", "", &[("z_f", column)]).unwrap_err();
            (fault.kind(), fault.column().map(|(n, _)| n))
        };
        assert_eq!(fault("disp [kg]"), ("unknown-unit", Some(2)));
        assert_eq!(fault("other [mm]"), ("missing-column", None));
    }

    #[test]
    fn faults_name_the_column() {
        let fault = |names, units, map: &[_]| {
            let e = recognise(names, units, map).unwrap_err();
            (e.kind(), e.column().map(|(n, _)| n))
        };
        assert_eq!(fault("t,z_f [furlong]", "", &[]), ("unknown-unit", Some(2)));
        assert_eq!(fault("t,z_f", "s,kg", &[]), ("unknown-unit", Some(2)));
        assert_eq!(fault("z_f,z_f", "", &[]), ("duplicate-column", Some(2)));
        assert_eq!(
            fault("z_f [mm],z_f_mm", "", &[]),
            ("duplicate-column", Some(2))
        );
        assert_eq!(
            fault("a", "", &[("z_f", "a"), ("z_r", "1")]),
            ("duplicate-column", Some(1))
        );
        assert_eq!(fault("a", "", &[("z_f", "b")]), ("missing-column", None));
        assert_eq!(fault("a", "", &[("z_f", "0")]), ("missing-column", None));
        assert_eq!(fault("a", "", &[("z", "a")]), ("unknown-channel", None));
    }
}
