//! MATLAB files of level 4 (saved with -v4) and 5 (-v6 or -v7): vectors, columns of matrices and fields of structures become
//! columns (`m#2` is the second of a matrix m).
//!
//! Read with bounds on everything, in two passes: names and shapes first, then only the columns
//! that hold channels.

use std::ops::Range;

use crate::channels::channel::Channel;
use crate::channels::glimpse::Glimpse;
use crate::channels::table::{Spec, Table, measured};
use crate::error::{Problem, ReadError};
use crate::formats::header::{Offered, Recognised};
use crate::formats::matrix::{Offer, Visit, corrupt};
use crate::formats::{level4, level5};
use crate::options::ReadOptions;

pub fn is_mat(bytes: &[u8]) -> bool {
    level5::begins(bytes) || level4::begins(bytes)
}

/// Reads a .mat file.
pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<Table, ReadError> {
    if bytes.len() as u64 > options.limits.bytes {
        return Err(Problem::TooLarge {
            bytes: bytes.len() as u64,
            limit: options.limits.bytes,
        }
        .into());
    }
    if bytes.starts_with(b"MATLAB 7.3") {
        return Err(Problem::MatV73.into());
    }
    let offered = offered(bytes, options)?;
    let mut recognised = recognised(&offered, options)?;
    structures(&offered, &recognised.specs, options)?;
    let others = left_out(&offered, &mut recognised.specs, options);
    let objects = objects(&offered);
    if !objects.is_empty() && !offered.iter().any(is_vector) {
        return Err(Problem::MatObjects { objects }.into());
    }
    let rows = rows(&offered, &recognised.specs)?;
    let most = options
        .limits
        .rows
        .min(options.limits.most_numbers(bytes.len()) / recognised.specs.len().max(1));
    let taken = taken(rows, most, options)?;
    let mut table = Table {
        rows: taken.len(),
        warnings: [
            recognised.warnings,
            unread(objects),
            wide(&offered, &recognised.specs),
            others,
        ]
        .concat(),
        unfound: recognised.unfound,
        format: match level5::begins(bytes) {
            true => "MATLAB level 5",
            false => "MATLAB level 4",
        }
        .to_owned(),
        ignored: (offered.iter().enumerate())
            .filter(|(i, _)| recognised.specs.iter().all(|s| s.number != i + 1))
            .map(|(_, offer)| offer.name.clone())
            .collect(),
        ..Table::default()
    };
    let (mut number, mut missing) = (0, 0);
    columns(bytes, options, &mut |offer, numbers| {
        number += 1;
        let values = numbers.iter().skip(taken.start);
        table
            .glimpses
            .push(Glimpse::of_numbers(&offer.name, values));
        let Some(spec) = recognised.specs.iter().find(|s| s.number == number) else {
            return Ok(());
        };
        let values: Vec<f64> = (numbers.iter().skip(taken.start))
            .take(taken.len())
            .collect();
        let nan_is_missing = options.is_missing(b"NaN");
        let is_time = spec.channel == Channel::Time;
        if !nan_is_missing && !is_time {
            missing += values.iter().filter(|value| value.is_nan()).count();
        }
        measured(&values, nan_is_missing || !is_time)
            .map_err(|(at, problem)| spec.blame(problem).at_sample(taken.start + at + 1))?;
        table.columns.push((spec.clone(), values));
        Ok(())
    })?;
    if missing > 0 {
        let values = if missing == 1 {
            "value is"
        } else {
            "values are"
        };
        (table.warnings).push(format!("NaN: {missing} {values} read as missing"));
    }
    Ok(table)
}

/// Visits every column in the order of the file.
fn columns(bytes: &[u8], options: &ReadOptions, visit: &mut Visit<'_>) -> Result<(), ReadError> {
    match level5::begins(bytes) {
        true => level5::columns(bytes, options.limits.bytes, visit),
        false => level4::columns(bytes, visit),
    }
}

/// Refuses a file whose channels lie in an array of structures, unless enough of them are mapped.
fn structures(offered: &[Offer], specs: &[Spec], options: &ReadOptions) -> Result<(), Problem> {
    let has_time = options.rate_hz.is_some() || specs.iter().any(|s| s.channel == Channel::Time);
    let has_channel = specs.iter().any(|s| s.channel != Channel::Time);
    let inside: Vec<&Offer> = (offered.iter())
        .filter(|offer| offer.structures.is_some() && is_vector(offer))
        .collect();
    let Some(field) = inside.first().and_then(|offer| offer.structures.clone()) else {
        return Ok(());
    };
    if has_time && has_channel {
        return Ok(());
    }
    let names: Vec<&str> = inside.iter().take(10).map(|o| o.name.as_str()).collect();
    Err(Problem::MatStructures {
        field,
        vectors: names.join(", "),
    })
}

/// Says which matrices are read by rows.
fn wide(offered: &[Offer], specs: &[Spec]) -> Vec<String> {
    let used = specs.iter().map(|spec| &offered[spec.number - 1]);
    let mut said: Vec<String> = used
        .filter_map(|offer| {
            let (rows, name) = (offer.wide?, variable(&offer.name));
            let length = offer.length;
            Some(format!(
                "{name} ({rows} x {length}) has a row per channel: its rows are read as the columns {name}#1 to {name}#{rows}"
            ))
        })
        .collect();
    said.dedup();
    said
}

/// The variable that a column is of.
fn variable(name: &str) -> &str {
    name.split('#').next().unwrap_or(name)
}

/// Leaves out channels of another length than most, the time only beside a rate. What is mapped stays, to be refused.
fn left_out(offered: &[Offer], specs: &mut Vec<Spec>, options: &ReadOptions) -> Vec<String> {
    let length = |spec: &Spec| offered[spec.number - 1].length;
    let alike = |spec: &Spec| specs.iter().filter(|s| length(s) == length(spec)).count();
    let Some(rows) = (specs.iter())
        .max_by_key(|s| (alike(s), length(s)))
        .map(length)
    else {
        return Vec::new();
    };
    let stays = |spec: &Spec| match spec.channel {
        Channel::Time => options.rate_hz.is_none(),
        channel => options
            .map
            .iter()
            .any(|(name, _)| Channel::named(name) == Some(channel)),
    };
    let (kept, out): (Vec<Spec>, Vec<Spec>) =
        (specs.drain(..)).partition(|spec| length(spec) == rows || stays(spec));
    *specs = kept;
    let said = out.iter().map(|spec| {
        let (name, found) = (&spec.header, length(spec));
        format!("{name} has {found} values, the other channels {rows}: it is left out")
    });
    said.collect()
}

/// All columns of the file.
fn offered(bytes: &[u8], options: &ReadOptions) -> Result<Vec<Offer>, ReadError> {
    let limit = options.limits.columns;
    let mut offered = Vec::new();
    columns(bytes, options, &mut |column, _| {
        if offered.len() == limit {
            let what = "columns";
            return Err(Problem::TooMany { what, limit }.into());
        }
        offered.push(column.clone());
        Ok(())
    })?;
    if offered.is_empty() {
        return Err(corrupt("no variables in it").into());
    }
    Ok(offered)
}

/// Whether it can be a channel. What MATLAB stores of its objects has no name.
fn is_vector(offer: &Offer) -> bool {
    offer.length > 1 && !offer.name.is_empty()
}

/// Names of the variables whose numbers only MATLAB can read.
fn objects(offered: &[Offer]) -> String {
    let objects = offered.iter().filter(|offer| offer.object);
    let names: Vec<&str> = objects.map(|offer| offer.name.as_str()).take(5).collect();
    names.join(", ")
}

fn unread(objects: String) -> Vec<String> {
    let found = (!objects.is_empty()).then_some(objects);
    let warning = |objects| Problem::MatObjects { objects }.to_string();
    found.map(warning).into_iter().collect()
}

/// The columns that hold channels.
fn recognised(offered: &[Offer], options: &ReadOptions) -> Result<Recognised, ReadError> {
    // Scalars and texts cannot be channels: unnamed, they are not recognised.
    let vectors: Vec<String> = (offered.iter())
        .map(|o| {
            if is_vector(o) {
                o.name.clone()
            } else {
                String::new()
            }
        })
        .collect();
    Offered {
        names: &vectors,
        units: &[],
        are_times: &[],
        paces: &[],
        line: None,
    }
    .recognise(options)
}

/// Rows of the channels, of which all hold equally many real numbers.
fn rows(offered: &[Offer], specs: &[Spec]) -> Result<usize, ReadError> {
    let rows = specs
        .iter()
        .map(|s| offered[s.number - 1].length)
        .max()
        .unwrap_or(0);
    for spec in specs {
        let Offer {
            name,
            length: found,
            complex,
            ..
        } = &offered[spec.number - 1];
        if *complex {
            let variable = variable(name).to_owned();
            let problem = Problem::ComplexNumbers { variable };
            return Err(ReadError::from(problem).in_column(spec.number, &spec.header));
        }
        let found = *found;
        if found != rows {
            let problem = Problem::RaggedRow {
                found,
                expected: rows,
            };
            return Err(ReadError::from(problem).in_column(spec.number, &spec.header));
        }
    }
    Ok(rows)
}

/// The rows that are read, of at most so many.
fn taken(rows: usize, most: usize, options: &ReadOptions) -> Result<Range<usize>, ReadError> {
    if rows > most {
        return Err(Problem::TooMany {
            what: "rows",
            limit: most,
        }
        .into());
    }
    let (from, to) = options.rows.unwrap_or((0, rows));
    if rows > 0 && from >= rows {
        return Err(Problem::BadRows { from, to, rows }.into());
    }
    let to = to.min(rows);
    Ok(from.min(to)..to)
}

#[cfg(test)]
pub mod tests;
