//! Channels in SI units, each on its own clock: what a table says once its times are understood.

use std::collections::BTreeMap;

use super::Column;
use super::error::{Problem, ReadError};
use super::file::FileSummary;
use super::options::ReadOptions;
use super::order::put_in_order;
use super::rate_stamps;
use super::stamps::{Known, Stamps};
use crate::channels::channel::Channel;
use crate::channels::slower::{self, How};
use crate::channels::table::{Places, Spec, Table};
use crate::channels::unit::Unit;
use crate::channels::values::{is_constant, size};
use crate::channels::{implausible, stuck};
use crate::clocks::clock::{Clock, Fit, Pace, drop_at};
use crate::clocks::rates::{RATES_HZ, USUAL_HZ};
use crate::clocks::resample::roughness;
use crate::clocks::sensor_clock::SensorClock;
use crate::formats::moment::EPOCHS_S;

/// Largest share of a channel's samples that may be missing.
const MOST_MISSING: f64 = 0.25;

/// One channel.
#[derive(Debug)]
pub(super) struct Track {
    pub spec: Spec,
    /// Which of [`Recording::clocks`].
    pub clock: usize,
    /// Name of its file, where the ride has several.
    pub file: String,
    pub values: Vec<f64>,
}

#[derive(Debug, Default)]
pub(super) struct Recording {
    pub clocks: Vec<Clock>,
    pub tracks: BTreeMap<Channel, Track>,
    pub rows: usize,
    /// Epoch (s) of the time 0, where the stamps say when they were taken.
    pub epoch_s: Option<f64>,
    /// The files, where there are several.
    pub files: Vec<FileSummary>,
    pub columns: Vec<Column>,
    pub ignored: Vec<String>,
    /// What was assumed while the files were read, in sentences.
    pub reading: Vec<String>,
    pub warnings: Vec<String>,
}

impl Track {
    /// Names the column in `problem`.
    pub fn blame(&self, problem: Problem) -> ReadError {
        let error = ReadError::from(problem).in_column(self.spec.number, &self.spec.header);
        error.in_file(&self.file)
    }
}

impl Recording {
    /// Gives every column its clock.
    pub fn new(mut table: Table, options: &ReadOptions) -> Result<Self, ReadError> {
        let mut out = Self {
            rows: table.rows,
            epoch_s: table.epoch_s,
            ignored: std::mem::take(&mut table.ignored),
            reading: std::mem::take(&mut table.reading),
            warnings: std::mem::take(&mut table.warnings),
            ..Self::default()
        };
        let stamps = out.stamps(&mut table, options)?;
        for (spec, values) in &mut table.columns {
            scale(values, spec.unit.scale);
        }
        out.leave_measured(&mut table, &stamps);
        out.leave_out_stuck(&mut table, &stamps);
        out.leave_out_implausible(&mut table, &stamps)?;
        let mut known: Vec<Known> = Vec::new();
        for (spec, mut values) in std::mem::take(&mut table.columns) {
            let own = stamps.own(&mut values);
            if values.is_empty() {
                out.warnings
                    .push(format!("{} contains no numbers", spec.header));
                out.ignored.push(spec.header);
                continue;
            }
            let clock = out.clock(own, &stamps, values.len(), &mut known);
            drop_at(&mut values, &known[clock].repeats);
            let listed = match (&known[clock].own, &stamps) {
                (None, Stamps::Listed { spec, .. }) => spec,
                _ => &spec,
            };
            out.check_rate(clock, listed)?;
            let span = out.clocks[clock].grid.end_s() - out.clocks[clock].grid.start_s;
            out.columns.push(Column::new(&spec, values.len(), span));
            let track = Track {
                spec,
                clock,
                file: String::new(),
                values,
            };
            out.tracks.insert(track.spec.channel, track);
        }
        out.note_repeats(&known, &stamps, &table.places)?;
        out.settle_jitter();
        out.note_gaps()?;
        out.note_unusual_rate(&stamps);
        Ok(out)
    }

    /// The clock of so many samples at their `own` stamps or at those of the file; one that is `known` already, or a new
    /// one.
    fn clock(
        &mut self,
        own: Option<Vec<f64>>,
        stamps: &Stamps,
        samples: usize,
        known: &mut Vec<Known>,
    ) -> usize {
        if let Some(clock) = known.iter().position(|k| k.own == own) {
            return clock;
        }
        let fit = match (&own, stamps) {
            (Some(times), _) | (None, Stamps::Listed { times, .. }) => Clock::fit(times),
            (None, Stamps::Rate(rate)) => Fit::from(Clock::regular(*rate, samples)),
        };
        self.clocks.push(fit.clock);
        let repeats = fit.repeats;
        known.push(Known { own, repeats });
        known.len() - 1
    }

    /// Refuses a rate that nothing is logged at; `stamped` is the column whose stamps say so.
    fn check_rate(&self, clock: usize, stamped: &Spec) -> Result<(), ReadError> {
        let step_s = self.clocks[clock].grid.step_s;
        if RATES_HZ.contains(&(1.0 / step_s)) {
            return Ok(());
        }
        let problem = Problem::RateOutOfRange { step_s };
        Err(ReadError::from(problem).in_column(stamped.number, &stamped.header))
    }

    /// Says how many stamps repeat on the clock with most of them; refuses a ride with many.
    fn note_repeats(
        &mut self,
        known: &[Known],
        stamps: &Stamps,
        places: &Places,
    ) -> Result<(), ReadError> {
        let (mut repeats, mut first_repeat) = (0, None);
        for clock in known {
            if clock.repeats.len() > repeats {
                repeats = clock.repeats.len();
                first_repeat = stamps.row(&clock.own, clock.repeats[0]);
            }
        }
        if repeats > 10.max(self.rows / 100) {
            let problem = Problem::TimeRepeats {
                repeated: repeats,
                stamps: self.rows,
            };
            return Err(match first_repeat {
                Some(row) => places.blame(row, problem),
                None => problem.into(),
            });
        }
        if repeats > 0 {
            self.warnings.push(format!(
                "{repeats} time stamp(s) repeat, or nearly repeat, the previous one: one sample of each was kept"
            ));
        }
        Ok(())
    }

    /// Blanks the samples that lie far outside of all others.
    fn leave_out_implausible(
        &mut self,
        table: &mut Table,
        stamps: &Stamps,
    ) -> Result<(), ReadError> {
        let duration_s = stamps.duration_s(table.rows);
        for found in implausible::find(&table.columns, duration_s) {
            let (spec, values) = &mut table.columns[found.column];
            let (row, samples) = (found.rows[0], found.rows.len());
            let (channel, value) = (spec.channel, size(spec.channel, values[row]));
            if found.too_many() {
                let problem = Problem::Implausible {
                    channel: channel.name(),
                    implausible: samples,
                    samples: found.samples,
                    value,
                };
                let error = table.places.blame(row, problem);
                return Err(error.in_column(spec.number, &spec.header));
            }
            let first = if samples > 1 { "the first " } else { "" };
            self.warnings.push(format!(
                "{}: {samples} sample(s) far outside the range of all others, {first}{value} at {:.3} s; treated as missing",
                channel.name(),
                stamps.time_s(row)
            ));
            for row in found.rows {
                values[row] = f64::NAN;
            }
        }
        Ok(())
    }

    /// Blanks what was filled in between the samples of slower channels.
    fn leave_measured(&mut self, table: &mut Table, stamps: &Stamps) {
        let rate = table.rows.saturating_sub(1) as f64 / stamps.duration_s(table.rows);
        for (spec, values) in &mut table.columns {
            let Some(slower) = slower::find(spec, values) else {
                continue;
            };
            slower.leave_measured(values);
            let how = match slower.how {
                How::Held => "repeats each value",
                How::Straight => "is interpolated on a straight line between values",
            };
            self.reading.push(format!(
                "{} {how} {} times: a slower channel, read at {} Hz",
                spec.channel.name(),
                slower.every,
                short(rate / slower.every as f64)
            ));
        }
    }

    /// Blanks the samples that a sensor did not measure.
    fn leave_out_stuck(&mut self, table: &mut Table, stamps: &Stamps) {
        for found in stuck::find(&table.columns, stamps.duration_s(table.rows)) {
            let (spec, values) = &mut table.columns[found.column];
            let [first, last] = [found.rows[0], found.rows[found.rows.len() - 1]];
            let [from_s, to_s] = [first, last].map(|row| stamps.time_s(row));
            let (channel, count) = (spec.channel.name(), found.rows.len());
            self.warnings.push(match found.lost {
                Some(mark) => format!(
                    "{channel}: {count} values of {} between others far from it, the first at {from_s:.3} s; treated as missing",
                    short(mark / spec.unit.scale)
                ),
                None => format!(
                    "{channel}: {count} samples between {from_s:.3} s and {to_s:.3} s repeat the same value while other channels move; \
                     treated as missing"
                ),
            });
            for row in found.rows {
                values[row] = f64::NAN;
            }
        }
    }

    fn stamps(&mut self, table: &mut Table, options: &ReadOptions) -> Result<Stamps, ReadError> {
        let at = (table.columns.iter()).position(|(spec, _)| spec.channel == Channel::Time);
        let Some(at) = at else {
            let found = self.found(&table.columns);
            let rate = options.rate_hz.ok_or(Problem::TimeMissing { found })?;
            return Ok(Stamps::Rate(rate));
        };
        let (mut spec, mut times) = table.columns.remove(at);
        self.note_epoch(&mut spec, &times);
        if let Some(rate) = options
            .rate_hz
            .filter(|rate| rate_stamps::are_useless(&times, spec.unit.scale, *rate))
        {
            if rate_stamps::count_samples(&times) {
                self.reading.extend(put_in_order(table, &mut times));
                scale(&mut times, 1.0 / rate);
                self.reading.push(format!(
                    "{} counts samples: at {rate} Hz each is {} s, and numbers that are missing are missing samples",
                    spec.header,
                    short(1.0 / rate)
                ));
                self.rows = table.rows;
                return Ok(Stamps::Listed { spec, times });
            }
            scale(&mut times, spec.unit.scale);
            if let Some([stamped_s, rows_s]) = rate_stamps::contradicted(&times, rate) {
                let problem = Problem::RowsMissing {
                    stamped_s,
                    rows_s,
                    rate_hz: rate,
                };
                return Err(spec.blame(problem));
            }
            self.reading.push(format!(
                "the rate of {rate} Hz replaces the stamps of {}, which repeat or give another rate",
                spec.header
            ));
            return Ok(Stamps::Rate(rate));
        }
        if options.rate_hz.is_some() {
            self.warnings.push(format!(
                "the rate was ignored: the column {} contains the time",
                spec.header
            ));
        }
        self.reading.extend(put_in_order(table, &mut times));
        self.rows = table.rows;
        scale(&mut times, spec.unit.scale);
        if let Some(row) = times.iter().position(|time| time.is_nan()) {
            let error = table.places.blame(row, Problem::TimeBlank);
            return Err(error.in_column(spec.number, &spec.header));
        }
        let span = times.last().unwrap_or(&0.0) - times.first().unwrap_or(&0.0);
        self.columns.push(Column::new(&spec, times.len(), span));
        Ok(Stamps::Listed { spec, times })
    }

    /// Finds out whether numbers are times since 1970.
    fn note_epoch(&mut self, spec: &mut Spec, times: &[f64]) {
        let Some(first) = times.first().filter(|_| self.epoch_s.is_none()) else {
            return;
        };
        if spec.unit.scale == 1.0 && EPOCHS_S.contains(&(1e-3 * first)) {
            spec.unit = Unit::milliseconds();
            self.warnings.push(format!(
                "{}: stamps near {first:e} are read as milliseconds since 1970",
                spec.header
            ));
        }
        if EPOCHS_S.contains(&(spec.unit.scale * first)) {
            self.epoch_s = Some(0.0);
        }
    }

    /// Time (s) of the first sample, and of the last.
    pub fn starts_s(&self) -> f64 {
        let starts = self.clocks.iter().map(|clock| clock.grid.start_s);
        starts.fold(f64::INFINITY, f64::min)
    }

    pub fn ends_s(&self) -> f64 {
        let ends = self.clocks.iter().map(|clock| clock.grid.end_s());
        ends.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Moves everything in time.
    pub fn shift(&mut self, by_s: f64) {
        for clock in &mut self.clocks {
            clock.grid.start_s += by_s;
            for gap in &mut clock.gaps {
                gap.from_s += by_s;
                gap.to_s += by_s;
            }
        }
    }

    /// Headers in the file, for messages.
    fn found(&self, columns: &[(Spec, Vec<f64>)]) -> String {
        let headers = columns.iter().map(|(spec, _)| &spec.header);
        list(headers.chain(&self.ignored))
    }

    /// Where stamps jitter, decides whether the samples were taken at those stamps or evenly: the
    /// channels that the identification stands on are smoother placed where they were taken.
    fn settle_jitter(&mut self) {
        for (index, clock) in self.clocks.iter_mut().enumerate() {
            let Pace::Jitter { rms_s } = clock.pace else {
                continue;
            };
            let tracks = || self.tracks.values().filter(|t| t.clock == index);
            let names: Vec<&str> = tracks().map(|t| t.spec.channel.name()).collect();
            let names = names.join(", ");
            let mut evidence = 0.0;
            for track in tracks().filter(|t| t.spec.channel.is_essential()) {
                let n = track.values.len();
                let even: Vec<f64> = match &clock.even_knots {
                    Some(knots) => knots.clone(),
                    None => (0..n).map(|k| k as f64).collect(),
                };
                let stamped = clock.knots.as_deref().unwrap_or(&even);
                let (a, b) = (
                    roughness(stamped, &track.values),
                    roughness(&even, &track.values),
                );
                if a > 0.0 && b > 0.0 {
                    evidence += (a / b).ln();
                }
            }
            let rate = clock.grid.rate_hz();
            let jitter = format!(
                "the time stamps of {names} jitter by {:.3} ms rms about {rate:.6} Hz",
                rms_s * 1e3
            );
            if evidence > 0.1 {
                clock.knots = clock.even_knots.take();
                self.warnings.push(format!(
                    "{jitter}; the samples fit equal steps better and were treated as evenly spaced"
                ));
            } else {
                self.warnings.push(format!(
                    "{jitter}; resampled to equal steps by a cubic spline through the stamps"
                ));
            }
        }
    }

    /// Sets the stamps right of a channel, or of all that its file holds where the clock is the file's.
    pub fn correct(&mut self, clock: &SensorClock) {
        let Some(found) = clock.correction() else {
            return;
        };
        let is_on_it = |channel: &Channel, track: &Track| match &clock.file {
            Some(file) => track.file == *file,
            None => channel.name() == clock.channel,
        };
        for (channel, track) in &mut self.tracks {
            if !is_on_it(channel, track) {
                continue;
            }
            let mut own = self.clocks[track.clock].clone();
            own.grid = found.set_grid_right(own.grid);
            for gap in &mut own.gaps {
                gap.from_s = found.set_right(gap.from_s);
                gap.to_s = found.set_right(gap.to_s);
            }
            track.clock = self.clocks.len();
            self.clocks.push(own);
        }
    }

    /// Doubts the time's unit where no channel that a ride rests on has a usual rate.
    fn note_unusual_rate(&mut self, stamps: &Stamps) {
        let essential = self.tracks.values().filter(|t| {
            t.spec.channel.is_essential() && t.values.len() > 1 && !is_constant(&t.values)
        });
        let rate = essential
            .map(|t| self.clocks[t.clock].grid.rate_hz())
            .fold(0.0, f64::max);
        if rate > 0.0 && !USUAL_HZ.contains(&rate) {
            self.warnings.push(format!(
                "{stamps} gives {} samples a second, but rides are logged at {} Hz to {} Hz: is its unit right?",
                short(rate),
                USUAL_HZ.start(),
                USUAL_HZ.end()
            ));
        }
    }

    fn note_gaps(&mut self) -> Result<(), ReadError> {
        for (index, clock) in self.clocks.iter().enumerate() {
            let missing = clock.missing();
            if missing == 0 {
                continue;
            }
            let tracks = || self.tracks.values().filter(|t| t.clock == index);
            let essential = tracks().find(|t| t.spec.channel.is_essential());
            if missing as f64 > MOST_MISSING * clock.grid.count as f64
                && let Some(track) = essential
            {
                return Err(track.blame(Problem::GapTooLong {
                    missing_s: missing as f64 * clock.grid.step_s,
                    total_s: clock.grid.count as f64 * clock.grid.step_s,
                }));
            }
            let names: Vec<&str> = tracks().map(|t| t.spec.channel.name()).collect();
            let spans: Vec<String> = (clock.gaps.iter().take(3))
                .map(|g| format!("{:.3} s to {:.3} s", g.from_s, g.to_s))
                .collect();
            let more = match clock.gaps.len().saturating_sub(spans.len()) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            self.warnings.push(format!(
                "{}: {missing} sample(s) missing from {}{more}; interpolated and not trusted",
                names.join(", "),
                spans.join(", ")
            ));
        }
        Ok(())
    }
}

fn scale(values: &mut [f64], factor: f64) {
    if factor != 1.0 {
        values.iter_mut().for_each(|v| *v *= factor);
    }
}

impl Column {
    /// `samples` spread over `span_s` seconds.
    pub(super) fn new(spec: &Spec, samples: usize, span_s: f64) -> Self {
        Self {
            file: None,
            header: spec.header.clone(),
            channel: spec.channel.name().to_owned(),
            unit: spec.unit.name.clone(),
            scale: spec.unit.scale,
            samples,
            rate_hz: if span_s > 0.0 {
                samples.saturating_sub(1) as f64 / span_s
            } else {
                0.0
            },
        }
    }
}

/// A number with at most three decimals.
pub(super) fn short(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// At most twenty names, for messages.
pub(super) fn list<'a>(names: impl Iterator<Item = &'a String>) -> String {
    let short = |n: &'a String| n.chars().take(40).collect::<String>();
    let names: Vec<String> = names.take(20).map(short).collect();
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}
