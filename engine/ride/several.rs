//! The files of a ride become one recording: each has a clock of its own, and all of them are put on one.

use super::error::{Problem, ReadError};
use super::file::{FileSummary, RideFile};
use super::options::ReadOptions;
use super::recording::{Recording, list};
use crate::channels::table::Table;
use crate::formats::format::{glimpse, table};

/// A file as a table.
pub(super) struct Opened {
    pub name: String,
    pub sha256: String,
    pub options: ReadOptions,
    /// Begins so much later than it would.
    offset_s: Option<f64>,
    pub table: Table,
}

/// Opens every file as the options say of it.
pub(super) fn open(
    files: &[RideFile<'_>],
    options: &ReadOptions,
) -> Result<Vec<Opened>, ReadError> {
    check(files, options)?;
    let opened = files.iter().map(|file| {
        let options = options.of_file(file.name, files.len());
        let table = table(file, &options).map_err(|e| e.in_file(file.name))?;
        Ok(Opened::new(file, options, table))
    });
    let opened = opened.collect::<Result<Vec<_>, ReadError>>()?;
    every_mapping_is_used(options, &opened)
        .map_err(|problem| ReadError::from(problem).in_file(&names_of(files)))?;
    Ok(opened)
}

/// The same for a preview: a text file that cannot be read gives its columns without values, and the first fault of any file.
pub(super) fn open_or_glimpse(
    files: &[RideFile<'_>],
    options: &ReadOptions,
) -> Result<(Vec<Opened>, Option<ReadError>), ReadError> {
    check(files, options)?;
    let (mut seen, mut first) = (Vec::new(), None);
    for file in files {
        let options = options.of_file(file.name, files.len());
        let table = match table(file, &options).map_err(|e| e.in_file(file.name)) {
            Ok(table) => table,
            Err(fault) => match glimpse(file, &options) {
                Some(table) => {
                    first.get_or_insert(fault);
                    table
                }
                None => return Err(first.unwrap_or(fault)),
            },
        };
        seen.push(Opened::new(file, options, table));
    }
    let unused = || every_mapping_is_used(options, &seen).err();
    let first = first.or_else(|| unused().map(ReadError::from));
    Ok((seen, first))
}

impl Opened {
    fn new(file: &RideFile<'_>, options: ReadOptions, table: Table) -> Self {
        let own = options.own(file.name);
        Self {
            name: file.name.to_owned(),
            sha256: file.sha256(),
            offset_s: own.and_then(|(_, own)| own.offset_s),
            options,
            table,
        }
    }
}

pub(super) fn names_of(files: &[RideFile<'_>]) -> String {
    let names: Vec<&str> = files.iter().map(|file| file.name).collect();
    names.join(", ")
}

/// Whether the options fit the files.
fn check(files: &[RideFile<'_>], options: &ReadOptions) -> Result<(), ReadError> {
    let names: Vec<&str> = files.iter().map(|file| file.name).collect();
    let in_ride = |problem: Problem| ReadError::from(problem).in_file(&names.join(", "));
    options.validate().map_err(in_ride)?;
    let limit = options.limits.files;
    if !(1..=limit).contains(&files.len()) {
        let files = files.len();
        return Err(in_ride(Problem::FileCount { files, limit }));
    }
    if let Some(at) = (1..names.len()).find(|at| names[..*at].contains(&names[*at])) {
        return Err(ReadError::from(Problem::SameName).in_file(names[at]));
    }
    let used: Vec<&str> = (names.iter())
        .filter_map(|name| Some(options.own(name)?.0))
        .collect();
    if let Some(file) = options
        .files
        .keys()
        .find(|file| !used.contains(&file.as_str()))
    {
        return Err(in_ride(Problem::UnknownFile {
            file: file.clone(),
            known: names.join(", "),
        }));
    }
    if files.len() > 1
        && let Some((from, to)) = options.rows
    {
        return Err(in_ride(Problem::BadOption {
            name: "rows",
            value: format!("{from}:{to}"),
            expected: "the file that the rows belong to, as FILE:FROM:TO",
        }));
    }
    Ok(())
}

/// A column that is mapped without a file stands in one of them.
fn every_mapping_is_used(options: &ReadOptions, files: &[Opened]) -> Result<(), Problem> {
    let unfound = |channel: &&String| files.iter().all(|f| f.table.unfound.contains(channel));
    let Some(channel) = options.map.keys().find(unfound) else {
        return Ok(());
    };
    let tables = files.iter().map(|file| &file.table);
    let headers = tables.flat_map(|t| {
        let known = t.columns.iter().map(|(spec, _)| &spec.header);
        known.chain(&t.ignored)
    });
    Err(Problem::MissingColumn {
        channel: channel.clone(),
        column: options.map[channel].clone(),
        found: list(headers),
    })
}

/// One recording of all files.
pub(super) fn join(files: Vec<Opened>) -> Result<Recording, ReadError> {
    let several = files.len() > 1;
    let mut parts = Vec::new();
    for file in files {
        let (rows, format) = (file.table.rows, file.table.format.clone());
        let recording =
            Recording::new(file.table, &file.options).map_err(|e| e.in_file(&file.name))?;
        if !several {
            return Ok(recording);
        }
        let summary = FileSummary {
            name: file.name,
            sha256: file.sha256,
            format,
            rows,
            dated: recording.epoch_s.is_some(),
            offset_s: file.offset_s,
            shift_s: file.offset_s.unwrap_or(0.0),
            ..FileSummary::default()
        };
        parts.push((summary, recording));
    }
    let mut out = Recording {
        epoch_s: place(&mut parts)?,
        ..Recording::default()
    };
    for (summary, recording) in parts {
        take_in(&mut out, summary, recording)?;
    }
    Ok(out)
}

/// Finds what is to be added to each file's stamps: those that say when they were taken are placed by that; the others begin
/// with the first one that does, or else with the first file. What the user says comes on top. The epoch (s) of the common time 0, where
/// a file has one.
fn place(parts: &mut [(FileSummary, Recording)]) -> Result<Option<f64>, ReadError> {
    for (file, recording) in parts.iter() {
        if recording.clocks.is_empty() {
            let found = list(
                recording
                    .columns
                    .iter()
                    .map(|c| &c.header)
                    .chain(&recording.ignored),
            );
            let example = format!("{}:a_f", file.name);
            return Err(ReadError::from(Problem::NoChannel { example, found }).in_file(&file.name));
        }
    }
    let first = parts.iter().find(|(file, _)| file.dated).or(parts.first());
    let Some((epoch_s, begins_s)) = first.map(|(_, r)| (r.epoch_s, r.starts_s())) else {
        return Ok(None);
    };
    let origin_s = epoch_s.unwrap_or(0.0);
    for (file, recording) in parts.iter_mut() {
        file.shift_s += match recording.epoch_s {
            Some(epoch_s) => epoch_s - origin_s,
            None => begins_s - recording.starts_s(),
        };
        recording.shift(file.shift_s);
        file.from_s = recording.starts_s();
        file.to_s = recording.ends_s();
    }
    let files = || parts.iter().map(|(file, _)| file);
    let from_s = files().map(|f| f.from_s).fold(f64::NEG_INFINITY, f64::max);
    let to_s = files().map(|f| f.to_s).fold(f64::INFINITY, f64::min);
    if from_s > to_s {
        let span = |f: &FileSummary| {
            let [from, to] = [f.from_s, f.to_s].map(|t| t - begins_s);
            format!("{} from {from:.1} s to {to:.1} s", f.name)
        };
        let spans = files().map(span).collect::<Vec<_>>().join(", ");
        let names = files()
            .map(|f| f.name.as_str())
            .collect::<Vec<_>>()
            .join(", ");
        return Err(ReadError::from(Problem::FilesApart { spans }).in_file(&names));
    }
    Ok(epoch_s)
}

/// Adds a file's channels to those of the files before.
fn take_in(out: &mut Recording, file: FileSummary, part: Recording) -> Result<(), ReadError> {
    let before = out.clocks.len();
    for (channel, mut track) in part.tracks {
        track.file.clone_from(&file.name);
        // A guessed channel gives way to a named one.
        let other = out.tracks.get(&channel);
        if track.spec.is_guess && other.is_some() {
            out.ignored.push(track.spec.header);
            continue;
        }
        if let Some(other) = other.filter(|other| !other.spec.is_guess) {
            return Err(track.blame(Problem::ChannelTwice {
                channel: channel.name(),
                first: format!(
                    "{}, column {} ({})",
                    other.file, other.spec.number, other.spec.header
                ),
            }));
        }
        track.clock += before;
        out.tracks.insert(channel, track);
    }
    out.clocks.extend(part.clocks);
    out.rows += part.rows;
    out.columns
        .extend(part.columns.into_iter().map(|column| super::Column {
            file: Some(file.name.clone()),
            ..column
        }));
    out.ignored.extend(part.ignored);
    let named = |warning| format!("{}: {warning}", file.name);
    out.warnings.extend(part.warnings.into_iter().map(named));
    out.reading.extend(part.reading.into_iter().map(named));
    out.files.push(file);
    Ok(())
}

#[cfg(test)]
mod tests;
