//! Rows of numbers in a text file, in one pass.

use crate::channels::table::{Spec, Table};
use crate::channels::unit::Unit;
use crate::error::{Problem, ReadError};
use crate::formats::cells::Separator;
use crate::formats::dialect::{Dialect, sniff};
use crate::formats::header::Offered;
use crate::formats::loggers;
use crate::formats::number::Decimal;
use crate::formats::rows::Rows;
use crate::formats::source::{Source, binary};
use crate::formats::track;
use crate::options::ReadOptions;

/// Reads a text file, packed or not.
pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<Table, ReadError> {
    let mut source = Source::open(bytes, &options.limits)?;
    let most_cells = source.most_cells();
    let packed = source.format();
    let head = head(&mut source)?;
    if ends_with_returns(head) {
        return read(&with_line_feeds(head), options);
    }
    let logger = loggers::of(head, options);
    let options = &*loggers::with(options, logger);
    let dialect = sniff(head, options)?;
    dialect.check(options)?;
    let recognised = offered(&dialect).recognise(options)?;
    for spec in &recognised.specs {
        let unit = dialect.units_in_cells.get(spec.number - 1);
        let unit = unit.and_then(Option::as_ref);
        unit.map_or(Ok(()), |unit| has_unit(spec, unit))?;
    }
    let mut table = described(&dialect, packed);
    table
        .reading
        .extend(logger.map(|logger| format!("the file is read as one of {}", logger.name)));
    table.ignored = recognised.ignored;
    table.unfound = recognised.unfound;
    table.warnings = recognised.warnings;
    table.reading.extend(recognised.reading);
    table
        .reading
        .extend(logger.and_then(|logger| logger.note.clone()));
    let mut rows = Rows::new(&dialect, &recognised.specs, options);
    if let Some((cells, bomb)) = most_cells {
        let most = cells / recognised.specs.len().max(1);
        if most < rows.most {
            (rows.most, rows.beyond) = (most, bomb);
        }
    }
    rows.reserve(head.len() - dialect.offset, &head[dialect.offset..]);
    let mut more = rows.feed(&head[dialect.offset..])?;
    while more && let Some(block) = source.next_block()? {
        more = rows.feed(block)?;
    }
    rows.finish(recognised.specs, &mut table)?;
    Ok(table)
}

/// What a text file seems to hold that is not read, as columns without values; none where it is no text of several lines.
pub fn glimpse(bytes: &[u8], options: &ReadOptions) -> Option<Table> {
    let mut source = Source::open(bytes, &options.limits).ok()?;
    let packed = source.format();
    let head = head(&mut source).ok()?;
    if ends_with_returns(head) {
        return glimpse(&with_line_feeds(head), options);
    }
    let options = &*loggers::with(options, loggers::of(head, options));
    let dialect = sniff(head, options)
        .ok()
        .filter(|dialect| dialect.lines.len() > 1)?;
    let mut table = described(&dialect, packed);
    table.glimpses.truncate(options.limits.columns);
    if let Ok(recognised) = offered(&dialect).recognise(options) {
        let empty = |spec| (spec, Vec::new());
        table.columns = recognised.specs.into_iter().map(empty).collect();
        table.ignored = recognised.ignored;
    }
    Some(table)
}

/// Refuses a column whose cells state another unit than its header.
fn has_unit(spec: &Spec, in_cells: &str) -> Result<(), ReadError> {
    let unit = Unit::parse(in_cells, spec.channel.dimension());
    if unit.is_some_and(|unit| unit.scale == spec.unit.scale) {
        return Ok(());
    }
    Err(spec.blame(Problem::UnitsDiffer {
        header: spec.unit.name.clone(),
        cells: in_cells.to_owned(),
    }))
}

/// Whether a text is JSON: an object, or an array of objects, arrays or texts.
fn is_json(head: &[u8]) -> bool {
    let mut letters = head.iter().filter(|b| !b.is_ascii_whitespace());
    matches!(
        (letters.next(), letters.next()),
        (Some(b'{'), Some(b'"' | b'}')) | (Some(b'['), Some(b'{' | b'[' | b'"'))
    )
}

/// The first block of a text file.
fn head<'a>(source: &'a mut Source<'_>) -> Result<&'a [u8], Problem> {
    let head = source.next_block()?.ok_or(Problem::EmptyFile)?;
    if is_json(head) {
        return Err(Problem::Json);
    }
    match binary(head) {
        Some(what) => Err(Problem::BinaryFile { what }),
        None => Ok(head),
    }
}

/// Whether the lines end as those of old Macintosh programs.
fn ends_with_returns(head: &[u8]) -> bool {
    memchr::memchr(b'\n', head).is_none() && memchr::memchr(b'\r', head).is_some()
}

fn with_line_feeds(head: &[u8]) -> Vec<u8> {
    let line_feed = |b: &u8| if *b == b'\r' { b'\n' } else { *b };
    head.iter().map(line_feed).collect()
}

fn offered(dialect: &Dialect) -> Offered<'_> {
    Offered {
        names: &dialect.names,
        units: &dialect.units,
        are_times: &dialect.are_times,
        paces: &dialect.paces,
        line: dialect.header_line,
    }
}

fn described(dialect: &Dialect, packed: Option<&str>) -> Table {
    Table {
        format: describe(dialect, packed),
        glimpses: dialect.glimpses.clone(),
        lines: dialect.lines.clone(),
        layout: dialect.layout(),
        reading: dialect.reading.clone(),
        ..Table::default()
    }
}

fn describe(dialect: &Dialect, packed: Option<&str>) -> String {
    let separator = match dialect.separator {
        Separator::Byte(b';') => "semicolon".to_owned(),
        Separator::Byte(b',') => "comma".to_owned(),
        other => other.name(),
    };
    let decimal = match dialect.decimal {
        Decimal::Comma => "comma",
        _ => "point",
    };
    if packed == Some(track::FORMAT) {
        return "GPX or TCX track".to_owned();
    }
    let packed = packed.map(|p| format!("{p}, ")).unwrap_or_default();
    format!("{packed}text, separated by {separator}, decimal {decimal}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_is_refused_as_what_it_is() {
        for text in [
            "{\"RIDE\":{\"STARTTIME\":1}}",
            "\n[\n {\"t\": 0}]",
            "{\"t\":0,\"z_f\":1}\n{\"t\":1,\"z_f\":1}\n",
        ] {
            let fault = read(text.as_bytes(), &ReadOptions::default()).map(|_| ());
            assert!(
                fault.as_ref().is_err_and(|fault| fault.kind() == "json"),
                "{fault:?}"
            );
        }
        assert!(!is_json(b"[header]\n") && !is_json(b"t,z_f"));
    }
}
