//! The way from bytes to a [`Ride`], and as far as it is understood, to a [`Preview`].

use serde::{Deserialize, Serialize};

use super::error::ReadError;
use super::file::{FileSummary, RideFile, sha256_of};
use super::preview_table::PreviewTable;
use super::recording::Recording;
use super::several::{Opened, join, names_of, open, open_or_glimpse};
use super::{Column, ReadOptions, Ride, RideSummary, SensorClock};
use crate::channels::channel::Channel;
use crate::channels::sensor::{Placed, SensorKind, channel, lacking};
use crate::formats::format::of_bytes;
use crate::signals::clock_notes::{apart, note};
use crate::signals::common::{Common, basis, has_only_accelerometers};
use crate::signals::{axles, decay, sensed};
use veloid_core::bicycle::{Axle, Bike};

/// Reads a ride of one file.
///
/// The bike is asked for its wheelbase where the
/// rear road is the front's, later. Errors name file, line, column and what was expected.
pub fn read(
    bytes: &[u8],
    file: &str,
    bike: &Bike,
    options: &ReadOptions,
) -> Result<Ride, ReadError> {
    read_on_clocks(&[RideFile::new(file, bytes)], bike, options, &[])
}

/// Reads a ride of one file or several, with the time stamps of sensors set right whose clocks are known to be off.
pub fn read_on_clocks(
    files: &[RideFile<'_>],
    bike: &Bike,
    options: &ReadOptions,
    clocks: &[SensorClock],
) -> Result<Ride, ReadError> {
    let opened = open(files, options)?;
    let sums: Vec<String> = opened.iter().map(|file| file.sha256.clone()).collect();
    let mut ride = join(opened)
        .and_then(|recording| ride(recording, bike, options, clocks))
        .map_err(|e| e.in_file(&names_of(files)))?;
    ride.summary.sha256 = sha256_of(&sums);
    Ok(ride)
}

/// Contents of a file, without the bike.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Preview {
    /// Format of the file, in words.
    pub format: String,
    /// Rows of all files.
    pub rows: usize,
    /// Recognised columns.
    pub columns: Vec<Column>,
    /// The files, where there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<FileSummary>,
    /// Every file with all its columns.
    #[serde(default)]
    pub tables: Vec<PreviewTable>,
    /// Header texts of columns without a recognised channel.
    pub ignored: Vec<String>,
    /// Rate of the common clock (Hz); absent if the ride cannot be identified with these options.
    pub rate_hz: Option<f64>,
    /// Samples on the common clock.
    pub samples: Option<usize>,
    /// Time of the first sample (s).
    pub start_s: Option<f64>,
    /// Time from the first to the last sample (s).
    pub duration_s: Option<f64>,
    /// Missing stretches, at most a hundred of each clock.
    pub gaps: Vec<PreviewGap>,
    /// What was assumed while the files were read, in sentences.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reading: Vec<String>,
    /// Warnings: what was interpolated or looks doubtful.
    pub warnings: Vec<String>,
    /// Why the ride could not be identified with these options.
    pub problem: Option<String>,
}

/// Missing samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PreviewGap {
    /// Channels with missing samples.
    pub channels: Vec<String>,
    /// Time of the sample before (s).
    pub from_s: f64,
    /// Time of the sample after (s).
    pub to_s: f64,
    /// Number of missing samples.
    pub missing: usize,
}

/// Says what would be read from the files of a ride. What lacks to identify a ride (a time, an axle), or keeps a text file from being read, is
/// reported in [`Preview::problem`]; other files that are not tables, and options that do not fit the files, are errors.
pub fn preview(files: &[RideFile<'_>], options: &ReadOptions) -> Result<Preview, ReadError> {
    let (opened, fault) = open_or_glimpse(files, options)?;
    let mut preview = Preview::default();
    for file in &opened {
        preview.offer(file, opened.len() > 1);
    }
    let fault = fault.or_else(|| preview.look(opened, options).err());
    preview.problem = fault.map(|fault| fault.in_file(&names_of(files)).to_string());
    // The wheelbase is the bike's, which may be given later.
    Ok(preview.without_dead_end(true))
}

impl Preview {
    /// Says what `bike` lacks for this ride, where nothing else is in the way.
    pub fn with_bike(self, bike: &Bike) -> Self {
        let has = |channel: Channel| self.columns.iter().any(|c| c.channel == channel.name());
        let fault = Axle::BOTH
            .into_iter()
            .filter(|axle| {
                let alone = has_only_accelerometers(has) && has(Channel::Acceleration(*axle));
                alone || basis(has, *axle).is_some()
            })
            .find_map(|axle| bike.mass_or_force(axle, has(Channel::Force(axle))).err());
        let fault = fault.map(|fault| fault.to_string());
        self.or_problem(fault)
            .without_dead_end(bike.wheelbase().is_some())
    }

    /// Says why accelerometers and a speed alone cannot give k and B.
    fn without_dead_end(self, has_wheelbase: bool) -> Self {
        let column = |channel: Channel| self.columns.iter().find(|c| c.channel == channel.name());
        if !has_only_accelerometers(|channel| column(channel).is_some()) {
            return self;
        }
        let kinds = [SensorKind::Acceleration, SensorKind::Deflection];
        let all = Axle::BOTH
            .into_iter()
            .flat_map(|axle| kinds.map(|kind| (axle, kind)));
        let placed = all.filter_map(|(axle, kind)| {
            let file = column(channel(kind, axle))?.file.as_deref();
            Some(Placed { axle, kind, file })
        });
        let placed: Vec<Placed<'_>> = placed.collect();
        let lack = lacking(&placed, has_wheelbase);
        self.or_problem(lack)
    }

    fn or_problem(mut self, problem: Option<String>) -> Self {
        self.problem = self.problem.or(problem);
        self
    }

    /// Adds what one of `several` files offers.
    fn offer(&mut self, file: &Opened, several: bool) {
        let Opened { name, table, .. } = file;
        self.tables.push(PreviewTable::new(name, table));
        let name = several.then(|| name.clone());
        if !self.format.is_empty() {
            self.format.push_str("; ");
        }
        self.format.push_str(&match &name {
            Some(name) => format!("{name}: {}", table.format),
            None => table.format.clone(),
        });
        self.rows += table.rows;
        self.ignored.extend(table.ignored.iter().cloned());
        self.reading.extend(table.reading.iter().cloned());
        let there = |values: &[f64]| values.iter().filter(|v| !v.is_nan()).count();
        let columns = table.columns.iter().map(|(spec, values)| Column {
            file: name.clone(),
            ..Column::new(spec, there(values), 0.0)
        });
        self.columns.extend(columns);
    }

    fn look(&mut self, files: Vec<Opened>, options: &ReadOptions) -> Result<(), ReadError> {
        let mut recording = join(files)?;
        self.files.clone_from(&recording.files);
        self.columns = recording.columns.clone();
        self.gaps = gaps(&recording);
        let found = Common::new(&mut recording, options).map(|common| common.grid);
        self.reading = recording.reading;
        self.warnings = recording.warnings;
        let grid = found?;
        self.rate_hz = Some(grid.rate_hz());
        self.samples = Some(grid.count);
        self.start_s = Some(grid.start_s);
        self.duration_s = Some(grid.end_s() - grid.start_s);
        Ok(())
    }
}

fn gaps(recording: &Recording) -> Vec<PreviewGap> {
    let of = |index: usize| -> Vec<String> {
        let tracks = recording.tracks.iter().filter(|(_, t)| t.clock == index);
        tracks.map(|(c, _)| c.name().to_owned()).collect()
    };
    (recording.clocks.iter().enumerate())
        .flat_map(|(index, clock)| clock.gaps.iter().take(100).map(move |gap| (index, gap)))
        .map(|(index, gap)| PreviewGap {
            channels: of(index),
            from_s: gap.from_s,
            to_s: gap.to_s,
            missing: gap.missing,
        })
        .collect()
}

/// Parses without making a ride of it; the number of rows. For benchmarks.
pub fn parse_only(bytes: &[u8], options: &ReadOptions) -> Result<usize, ReadError> {
    of_bytes(bytes, options).map(|table| table.rows)
}

fn ride(
    mut recording: Recording,
    bike: &Bike,
    options: &ReadOptions,
    clocks: &[SensorClock],
) -> Result<Ride, ReadError> {
    for clock in apart(clocks) {
        recording.correct(clock);
    }
    note(&mut recording, clocks);
    let mut common = Common::new(&mut recording, options)?;
    let sensors = sensed::recorded(&common, options.deflection_sign);
    let axles = axles::build(&mut common, bike, options)?;
    sensed::used(&mut common, &sensors);
    if axles.iter().next().is_none() {
        common.warn("the road was not measured; it is estimated together with k and B".to_owned());
    }
    let mut ride = Ride {
        start_s: common.grid.start_s,
        epoch_s: common.recording.epoch_s,
        step_s: common.grid.step_s,
        samples: common.grid.count,
        axles,
        sensors,
        road_doubts: Vec::new(),
        speed: common.take(Channel::Speed),
        cadence: common.take(Channel::Cadence),
        roll: common.take(Channel::Roll),
        steer: common.take(Channel::Steer),
        yaw_rate: common.take(Channel::YawRate),
        lateral_speed: common.take(Channel::LateralSpeed),
        summary: RideSummary::default(),
    };
    let unused: Vec<&str> = (common.recording.tracks.iter())
        .filter(|(_, track)| !track.values.is_empty())
        .map(|(channel, _)| channel.name())
        .collect();
    if !unused.is_empty() {
        let unused = unused.join(", ");
        common.warn(format!(
            "not used, because the axle has no displacement: {unused}"
        ));
    }
    let part_s = decay::cut(&mut ride).map(|said| {
        common.warn(said);
        [ride.start_s, ride.time_s(ride.samples.saturating_sub(1))]
    });
    ride.summary = RideSummary {
        sha256: String::new(),
        rows: recording.rows,
        samples: ride.samples,
        duration_s: ride.duration_s(),
        part_s,
        rate_hz: 1.0 / ride.step_s,
        columns: recording.columns,
        files: recording.files,
        clocks: clocks.to_vec(),
        ignored: recording.ignored,
        reading: recording.reading,
        warnings: recording.warnings,
    };
    Ok(ride)
}
