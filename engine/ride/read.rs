//! The way from bytes to a [`Ride`], and as far as it is understood, to a [`Preview`].

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::channel::Channel;
use super::common::{Common, basis};
use super::error::{Problem, ReadError};
use super::recording::Recording;
use super::table::Table;
use super::{Column, ReadOptions, Ride, RideSummary, axles, csv, mat};
use crate::bicycle::{Axle, Bike};

/// Reads a ride file: CSV in any dialect, gzip or zstd around it, or MATLAB v5/v7.
///
/// `file` is only used to name the file in messages. The bike is asked for its wheelbase where the
/// rear road is the front's, later. Errors name file, line, column and what was expected.
pub fn read(
    bytes: &[u8],
    file: &str,
    bike: &Bike,
    options: &ReadOptions,
) -> Result<Ride, ReadError> {
    table(bytes, options)
        .and_then(|table| ride(table, bike, options))
        .map(|mut ride| {
            ride.summary.sha256 = sha256(bytes);
            ride
        })
        .map_err(|e| e.in_file(file))
}

/// What a file holds, without needing the bike.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Preview {
    /// How the file is written, in words.
    pub format: String,
    pub rows: usize,
    pub columns: Vec<Column>,
    /// Header texts of columns that no channel was recognised in.
    pub ignored: Vec<String>,
    /// The common clock; absent if the file cannot be identified as it is.
    pub rate_hz: Option<f64>,
    pub samples: Option<usize>,
    pub start_s: Option<f64>,
    pub duration_s: Option<f64>,
    pub gaps: Vec<PreviewGap>,
    pub warnings: Vec<String>,
    /// Why the ride could not be identified with these options.
    pub problem: Option<String>,
}

/// Missing samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PreviewGap {
    pub channels: Vec<String>,
    /// Times of the samples before and after (s).
    pub from_s: f64,
    pub to_s: f64,
    pub missing: usize,
}

/// Says what would be read from a file. Files that are not tables at all are errors; what lacks to
/// identify a ride (a time, an axle) is told in [`Preview::problem`].
pub fn preview(bytes: &[u8], file: &str, options: &ReadOptions) -> Result<Preview, ReadError> {
    let table = table(bytes, options).map_err(|e| e.in_file(file))?;
    let mut preview = Preview {
        format: table.format.clone(),
        rows: table.rows,
        ignored: table.ignored.clone(),
        columns: (table.columns.iter())
            .map(|(spec, values)| {
                Column::new(spec, values.iter().filter(|v| !v.is_nan()).count(), 0.0)
            })
            .collect(),
        ..Preview::default()
    };
    if let Err(e) = preview.look(table, options) {
        preview.problem = Some(e.in_file(file).to_string());
    }
    Ok(preview)
}

impl Preview {
    /// Says what `bike` lacks for this ride, where nothing else is in the way.
    pub fn with_bike(mut self, bike: &Bike) -> Self {
        let has = |channel: Channel| self.columns.iter().any(|c| c.channel == channel.name());
        let fault = Axle::BOTH
            .into_iter()
            .filter(|axle| basis(has, *axle).is_some())
            .find_map(|axle| bike.mass_or_force(axle, has(Channel::Force(axle))).err());
        if self.problem.is_none() {
            self.problem = fault.map(|fault| fault.to_string());
        }
        self
    }

    fn look(&mut self, table: Table, options: &ReadOptions) -> Result<(), ReadError> {
        let mut recording = Recording::new(table, options)?;
        self.columns = recording.columns.clone();
        self.gaps = gaps(&recording);
        let found = Common::new(&mut recording, options).map(|common| common.grid);
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
    table(bytes, options).map(|table| table.rows)
}

fn table(bytes: &[u8], options: &ReadOptions) -> Result<Table, ReadError> {
    options.validate()?;
    if bytes.is_empty() {
        return Err(Problem::EmptyFile.into());
    }
    if mat::is_mat(bytes) {
        mat::read(bytes, options)
    } else {
        csv::read(bytes, options)
    }
}

fn ride(table: Table, bike: &Bike, options: &ReadOptions) -> Result<Ride, ReadError> {
    let mut recording = Recording::new(table, options)?;
    let mut common = Common::new(&mut recording, options)?;
    let axles = axles::build(&mut common, bike, options)?;
    let mut ride = Ride {
        start_s: common.grid.start_s,
        step_s: common.grid.step_s,
        samples: common.grid.count,
        axles,
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
            "not used, as its axle has no displacement: {unused}"
        ));
    }
    ride.summary = RideSummary {
        sha256: String::new(),
        rows: recording.rows,
        samples: ride.samples,
        duration_s: ride.duration_s(),
        rate_hz: 1.0 / ride.step_s,
        columns: recording.columns,
        ignored: recording.ignored,
        warnings: recording.warnings,
    };
    Ok(ride)
}

fn sha256(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().map(|b| format!("{b:02x}")).collect()
}
