//! Looks through the XML of a workbook as it is unpacked, before a reader that takes up whole texts and tags sees it. What is
//! not plain, well-nested UTF-8 is refused, so that no reader can understand it in another way.

use crate::error::Problem;
use crate::formats::spreadsheet::FORMAT;

/// Most characters of a cell: Excel's own limit ("Excel specifications and limits"). A text elsewhere has no more.
pub const TEXT: usize = 32_767;
/// Longest tag, comment or the like (bytes): as a line of text. The longest that Excel writes are lists of ranges, of some kilobytes.
const TAG: usize = 64 << 10;
/// Most bytes of a cell or a shared string with all its markup: every character written as a reference of ten bytes, three times.
const ITEM: usize = 1 << 20;
/// Deepest nesting; sheets have five levels, drawings some twenty.
const DEPTH: usize = 256;

/// What texts are gathered up in.
const ITEMS: [&[u8]; 2] = [b"c", b"si"];
/// Where one text of a cell ends and another begins: formula and value, say.
const TEXTS: [&[u8]; 5] = [b"c", b"si", b"is", b"v", b"f"];

enum State {
    Text,
    Tag,
    /// In a tag, until this quote.
    Quoted(u8),
    Comment,
    Data,
    Instruction,
}

pub struct Markup {
    state: State,
    /// What follows the last `<`.
    held: Vec<u8>,
    /// Names of the tags that are open.
    open: Vec<Vec<u8>>,
    /// Characters of the text so far, each reference one.
    characters: usize,
    in_reference: bool,
    /// Bytes since the last tag, or of the cell or string at this depth.
    bytes: usize,
    item: Option<usize>,
}

impl Markup {
    pub fn new() -> Self {
        Self {
            state: State::Text,
            held: Vec::new(),
            open: Vec::new(),
            characters: 0,
            in_reference: false,
            bytes: 0,
            item: None,
        }
    }

    /// Takes what follows; `see` gets each tag without its brackets, and its name without a prefix.
    pub fn feed(
        &mut self,
        xml: &[u8],
        see: &mut impl FnMut(&[u8], &[u8]) -> Result<(), Problem>,
    ) -> Result<(), Problem> {
        for byte in xml {
            self.take(*byte, see)?;
        }
        Ok(())
    }

    fn take(
        &mut self,
        byte: u8,
        see: &mut impl FnMut(&[u8], &[u8]) -> Result<(), Problem>,
    ) -> Result<(), Problem> {
        self.bytes += 1;
        if self.bytes > ITEM {
            return Err(too_long("cell or text with its markup", ITEM, "bytes"));
        }
        if byte == 0 {
            return Err(corrupt(&"its XML is not UTF-8 text"));
        }
        if matches!(self.state, State::Text) {
            return match byte {
                b'<' => {
                    self.held.clear();
                    self.state = State::Tag;
                    Ok(())
                }
                byte => self.count(byte),
            };
        }
        self.held.push(byte);
        if self.held.len() > TAG {
            return Err(too_long("tag", TAG, "bytes"));
        }
        match self.state {
            State::Tag if byte == b'>' => self.tag(see),
            State::Tag => self.begun(byte),
            State::Quoted(quote) => {
                if byte == quote {
                    self.state = State::Tag;
                }
                Ok(())
            }
            _ if byte == b'>' => self.other(),
            _ => Ok(()),
        }
    }

    /// Counts a byte of a text.
    fn count(&mut self, byte: u8) -> Result<(), Problem> {
        let goes_on = byte & 0xc0 == 0x80 || self.in_reference;
        self.in_reference = match byte {
            b'&' => true,
            b';' => false,
            _ => self.in_reference,
        };
        self.characters += usize::from(!goes_on);
        self.bounded()
    }

    fn bounded(&self) -> Result<(), Problem> {
        match self.characters > TEXT {
            true => Err(too_long("text", TEXT, "characters")),
            false => Ok(()),
        }
    }

    /// What kind of markup has begun.
    fn begun(&mut self, byte: u8) -> Result<(), Problem> {
        self.state = match self.held.as_slice() {
            b"?" => State::Instruction,
            b"!--" => State::Comment,
            b"![CDATA[" => State::Data,
            [b'!', ..] => {
                let known = [&b"!--"[..], b"![CDATA["];
                if known.iter().any(|start| start.starts_with(&self.held)) {
                    return Ok(());
                }
                return Err(corrupt(&"its XML has a document type declaration"));
            }
            _ if matches!(byte, b'"' | b'\'') => State::Quoted(byte),
            _ => return Ok(()),
        };
        Ok(())
    }

    /// Comment, data or instruction, if it ends here.
    fn other(&mut self) -> Result<(), Problem> {
        let (begins, ends): (&[u8], &[u8]) = match self.state {
            State::Comment => (b"!--", b"-->"),
            State::Data => (b"![CDATA[", b"]]>"),
            _ => (b"?", b"?>"),
        };
        if !self.held.ends_with(ends) {
            return Ok(());
        }
        // `<!-->`, of which some say that it ends there.
        if self.held.len() < begins.len() + ends.len() {
            return Err(corrupt(&"its XML is malformed"));
        }
        match self.state {
            State::Data => self.characters += self.held.len() - begins.len() - ends.len(),
            State::Instruction if !is_utf8(&self.held) => {
                return Err(corrupt(&"its XML is not UTF-8 text"));
            }
            _ => {}
        }
        self.state = State::Text;
        self.bounded()
    }

    /// A tag is whole.
    fn tag(
        &mut self,
        see: &mut impl FnMut(&[u8], &[u8]) -> Result<(), Problem>,
    ) -> Result<(), Problem> {
        self.state = State::Text;
        self.in_reference = false;
        let mut held = std::mem::take(&mut self.held);
        held.pop();
        let closes = held.strip_prefix(b"/");
        let tag = closes.unwrap_or_else(|| held.strip_suffix(b"/").unwrap_or(&held));
        let (name, rest) = split(tag);
        see(&held, local(name))?;
        match closes {
            Some(_) => self.closes(name, rest)?,
            None => self.opens(name, tag.len() < held.len())?,
        }
        self.held = held;
        Ok(())
    }

    fn opens(&mut self, name: &[u8], is_empty: bool) -> Result<(), Problem> {
        if name.is_empty() || self.open.len() >= DEPTH {
            return Err(corrupt(&"its XML is malformed, or nested too deep"));
        }
        let local = local(name);
        if self.item.is_none() {
            (self.bytes, self.characters) = (0, 0);
            if ITEMS.contains(&local) && !is_empty {
                self.item = Some(self.open.len());
            }
        } else if TEXTS.contains(&local) {
            self.characters = 0;
        }
        if !is_empty {
            self.open.push(name.to_owned());
        }
        Ok(())
    }

    fn closes(&mut self, name: &[u8], rest: &[u8]) -> Result<(), Problem> {
        let own = self.open.pop();
        if own.as_deref() != Some(name) || !rest.trim_ascii().is_empty() {
            return Err(corrupt(&"its XML tags are not closed in order"));
        }
        if self.item.is_none_or(|depth| depth == self.open.len()) {
            (self.bytes, self.characters, self.item) = (0, 0, None);
        }
        Ok(())
    }
}

/// Name, and what follows.
fn split(tag: &[u8]) -> (&[u8], &[u8]) {
    let ends = tag.iter().position(u8::is_ascii_whitespace);
    tag.split_at(ends.unwrap_or(tag.len()))
}

/// A name without its prefix.
fn local(name: &[u8]) -> &[u8] {
    let prefix = name.iter().position(|byte| *byte == b':');
    prefix.map_or(name, |at| &name[at + 1..])
}

/// Whether an instruction names no other encoding.
fn is_utf8(instruction: &[u8]) -> bool {
    let text = instruction.to_ascii_lowercase();
    let has = |word: &[u8]| memchr::memmem::find(&text, word).is_some();
    !has(b"encoding") || has(b"utf-8") || has(b"ascii")
}

pub fn corrupt(cause: &dyn std::fmt::Display) -> Problem {
    Problem::Corrupt {
        format: FORMAT,
        cause: cause.to_string(),
    }
}

fn too_long(what: &'static str, limit: usize, unit: &'static str) -> Problem {
    Problem::PartTooLong { what, limit, unit }
}

#[cfg(test)]
mod tests;
