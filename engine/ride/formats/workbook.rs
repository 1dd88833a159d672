//! The parts of a workbook that its reader gets: a zip archive, whose sizes anybody may write, is unpacked once with a bound, and
//! what is read of it is looked through ([`Markup`]) before a reader has it.

use std::io::{Cursor, Read, Write};

use memchr::memmem;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::error::Problem;
use crate::formats::markup::{Markup, corrupt};
use crate::options::Limits;

/// Rows that a sheet can have.
pub const ROWS: u32 = 1 << 20;
/// Most entries of the archive; a workbook of many sheets has a hundred.
const ENTRIES: usize = 4096;
/// Most formats of cells, Excel's own limit ("Excel specifications and limits"): a reader takes some 500 bytes for each.
const FORMATS: usize = 65_490;
/// Longest tag that says how numbers are written (bytes): its code has at most 255 characters. A reader copies it for each
/// format that names it.
const NUMBER_FORMAT: usize = 2 << 10;
/// Bytes of a string of the shared ones at least: `<si/>`.
const SHARED: u64 = 5;
/// Bytes that are looked through at a time.
const PIECE: usize = 64 << 10;

/// Of the styles the reader gets how numbers are written, and no fonts and fills.
const STYLES: [&[u8]; 5] = [b"styleSheet", b"numFmts", b"numFmt", b"cellXfs", b"xf"];

/// An archive of the parts that are read. What it holds unpacked is bounded: 4 MiB and its own size again for anything but a
/// sheet, as for packed text all together. So is the number of cells, as that of the numbers of packed text; they are counted
/// while it is unpacked, which ends with the first that is too many.
pub fn sifted(bytes: &[u8], limits: &Limits) -> Result<Vec<u8>, Problem> {
    if memmem::find_iter(bytes, b"PK\x01\x02")
        .nth(ENTRIES)
        .is_some()
    {
        return Err(Problem::TooMany {
            what: "entries in the archive",
            limit: ENTRIES,
        });
    }
    let packed = bytes.len() as u64;
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|e| corrupt(&e))?;
    let mut sifted = ZipWriter::new(Cursor::new(Vec::new()));
    let mut left = limits.most_unpacked(bytes.len());
    let most_cells = limits.most_numbers(bytes.len());
    let mut cells = 0;
    for i in 0..archive.len() {
        let entry = archive.by_index(i).map_err(|e| corrupt(&e))?;
        let name = entry.name().map_err(|e| corrupt(&e))?.to_lowercase();
        if !is_read(&name) {
            continue;
        }
        let own = match name.contains("worksheets/") {
            true => left,
            false => left.min((4 << 20) + packed),
        };
        let is_styles = name.ends_with("styles.xml");
        let mut part = Part::new(is_styles, cells, most_cells);
        let size = part.look_through(entry.take(own + 1), own, bytes.len())?;
        left -= size;
        cells = part.cells;
        if is_styles {
            let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
            sifted.start_file(name, stored).map_err(|e| corrupt(&e))?;
            sifted.write_all(&part.styles).map_err(|e| corrupt(&e))?;
        } else {
            let raw = archive.by_index_raw(i).map_err(|e| corrupt(&e))?;
            sifted.raw_copy_file(raw).map_err(|e| corrupt(&e))?;
        }
    }
    let sifted = sifted.finish().map_err(|e| corrupt(&e))?;
    Ok(sifted.into_inner())
}

/// Whether a part, by its name in lower case, can say something of a sheet: no picture, no query, no order of formulas, nothing
/// about the document.
fn is_read(name: &str) -> bool {
    let is_xml = name.ends_with(".xml") || name.ends_with(".rels");
    let is_other = name.starts_with("customxml") || name.starts_with("docprops");
    is_xml && !is_other && !name.ends_with("calcchain.xml")
}

/// What was met in one part.
struct Part {
    is_styles: bool,
    /// The styles, without what is not read.
    styles: Vec<u8>,
    formats: usize,
    /// Most shared strings that it says it has.
    strings: u64,
    rows: usize,
    /// Cells so far, with those of the parts before it.
    cells: usize,
    most_cells: usize,
}

impl Part {
    fn new(is_styles: bool, cells: usize, most_cells: usize) -> Self {
        Self {
            is_styles,
            styles: Vec::new(),
            formats: 0,
            strings: 0,
            rows: 0,
            cells,
            most_cells,
        }
    }

    /// Its size, if it holds no more than `limit` bytes and nothing in it is too long.
    fn look_through(
        &mut self,
        mut xml: impl Read,
        limit: u64,
        packed: usize,
    ) -> Result<u64, Problem> {
        let (mut markup, mut piece, mut size) = (Markup::new(), vec![0; PIECE], 0);
        loop {
            let read = xml.read(&mut piece).map_err(|e| corrupt(&e))?;
            if read == 0 {
                break;
            }
            size += read as u64;
            if size > limit {
                return Err(Problem::GzipBomb {
                    packed,
                    what: "bytes",
                    limit,
                });
            }
            markup.feed(&piece[..read], &mut |tag, name| self.see(tag, name))?;
        }
        // A reader makes room for as many.
        match self.strings > size / SHARED {
            true => Err(corrupt(&format!(
                "it declares {} shared strings in {size} bytes",
                self.strings
            ))),
            false => Ok(size),
        }
    }

    fn see(&mut self, tag: &[u8], name: &[u8]) -> Result<(), Problem> {
        let opens = !tag.starts_with(b"/");
        match name {
            b"sst" => self.strings = self.strings.max(shared_strings(tag)),
            b"row" if opens => count(&mut self.rows, "rows in a sheet", ROWS as usize)?,
            b"c" if opens => count(&mut self.cells, "cells in the workbook", self.most_cells)?,
            _ => {}
        }
        if !self.is_styles || !STYLES.contains(&name) {
            return Ok(());
        }
        if name == b"xf" && opens {
            count(&mut self.formats, "cell formats", FORMATS)?;
        }
        if tag.len() > NUMBER_FORMAT {
            return Err(Problem::PartTooLong {
                what: "number format",
                limit: NUMBER_FORMAT,
                unit: "bytes",
            });
        }
        self.styles.push(b'<');
        self.styles.extend_from_slice(tag);
        self.styles.push(b'>');
        Ok(())
    }
}

fn count(counted: &mut usize, what: &'static str, limit: usize) -> Result<(), Problem> {
    *counted += 1;
    match *counted > limit {
        true => Err(Problem::TooMany { what, limit }),
        false => Ok(()),
    }
}

/// How many strings a tag says there are, for which a reader makes room at once.
fn shared_strings(tag: &[u8]) -> u64 {
    const ATTRIBUTE: &[u8] = b"uniqueCount";
    let said = memmem::find_iter(tag, ATTRIBUTE).map(|at| {
        let digits = tag[at + ATTRIBUTE.len()..]
            .iter()
            .skip_while(|byte| !byte.is_ascii_digit())
            .take_while(|byte| byte.is_ascii_digit());
        digits.fold(0, |number: u64, digit| {
            number
                .saturating_mul(10)
                .saturating_add(u64::from(digit - b'0'))
        })
    });
    said.max().unwrap_or(0)
}
