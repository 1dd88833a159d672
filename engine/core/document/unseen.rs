//! Characters that make a name look like another one, or turn the text around it.

use unicode_joining_type::{JoiningType, get_joining_type};
use unicode_properties::UnicodeEmoji;

const NON_JOINER: char = '\u{200c}';
const JOINER: char = '\u{200d}';
const AS_TEXT: char = '\u{fe0e}';
const AS_EMOJI: char = '\u{fe0f}';
/// Encloses a digit in a key, as an emoji.
const KEYCAP: char = '\u{20e3}';

/// The characters of a text that cannot be seen. Joiners and variation selectors are seen where they change what stands
/// beside them, as in Persian, in the scripts of India and in emoji.
pub fn unseen(text: &str) -> impl Iterator<Item = char> {
    judged(text).filter_map(|(c, is_seen)| (!is_seen).then_some(c))
}

/// The characters of a text that can be seen.
pub fn seen(text: &str) -> impl Iterator<Item = char> {
    judged(text).filter_map(|(c, is_seen)| is_seen.then_some(c))
}

fn judged(text: &str) -> impl Iterator<Item = (char, bool)> {
    let mut before = Before::default();
    text.char_indices().map(move |(at, c)| {
        let is_seen = !is_invisible(c) || before.is_changed_by(c, &text[at + c.len_utf8()..]);
        if is_seen {
            before.goes_on_with(c);
        }
        (c, is_seen)
    })
}

/// Control characters; Unicode's property Default_Ignorable_Code_Point (DerivedCoreProperties.txt, Unicode 16); separators
/// of lines and paragraphs, marks of annotations; and signs that are drawn blank.
fn is_invisible(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{ad}' | '\u{34f}' | '\u{61c}' | '\u{115f}'..='\u{1160}' | '\u{17b4}'..='\u{17b5}'
            | '\u{180b}'..='\u{180f}' | '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{3164}' | '\u{fe00}'..='\u{fe0f}' | '\u{feff}' | '\u{ffa0}'
            | '\u{fff0}'..='\u{fff8}' | '\u{1bca0}'..='\u{1bca3}' | '\u{1d173}'..='\u{1d17a}'
            | '\u{e0000}'..='\u{e0fff}')
        || matches!(c, '\u{2028}'..='\u{2029}' | '\u{fff9}'..='\u{fffb}')
        || matches!(c, '\u{2800}' | '\u{16fe4}' | '\u{1d159}')
}

/// What is seen before a character.
#[derive(Default)]
struct Before {
    last: Option<char>,
    /// The last one that is no mark on another.
    base: Option<char>,
}

impl Before {
    fn goes_on_with(&mut self, c: char) {
        self.last = Some(c);
        if !is_mark(&c) {
            self.base = Some(c);
        }
    }

    /// Whether an invisible character changes how those beside it look.
    fn is_changed_by(&self, c: char, after: &str) -> bool {
        let next = after.chars().next();
        match c {
            NON_JOINER => self.last.is_some_and(is_virama) || self.joins(after) == [true; 2],
            JOINER => {
                [self.last, next].into_iter().flatten().any(is_virama)
                    || [self.base, next]
                        .into_iter()
                        .all(|c| c.is_some_and(is_emoji))
                    || matches!(self.joins(after), [true, false] | [false, true])
            }
            AS_EMOJI if next == Some(KEYCAP) => self.last.is_some_and(is_key),
            AS_TEXT | AS_EMOJI => self.last.is_some_and(is_emoji),
            '\u{180b}'..='\u{180d}' | '\u{180f}' => self.last.is_some_and(is_mongolian),
            '\u{fe00}'..='\u{fe0d}' | '\u{e0100}'..='\u{e01ef}' => {
                self.last.is_some_and(is_ideograph)
            }
            _ => false,
        }
    }

    /// Whether the letter before joins the one after, and the other way round.
    fn joins(&self, after: &str) -> [bool; 2] {
        use JoiningType::{DualJoining, JoinCausing, LeftJoining, RightJoining};
        let next = after.chars().find(|c| !is_mark(c));
        let [before, next] = [self.base, next].map(|c| c.map(get_joining_type));
        [
            matches!(before, Some(DualJoining | JoinCausing | LeftJoining)),
            matches!(next, Some(DualJoining | JoinCausing | RightJoining)),
        ]
    }
}

/// Whether joining looks through a character.
fn is_mark(c: &char) -> bool {
    get_joining_type(*c) == JoiningType::Transparent
}

/// Viramas of the scripts in which joiners choose the form of a conjunct.
fn is_virama(c: char) -> bool {
    matches!(
        c,
        '\u{94d}'
            | '\u{9cd}'
            | '\u{a4d}'
            | '\u{acd}'
            | '\u{b4d}'
            | '\u{bcd}'
            | '\u{c4d}'
            | '\u{ccd}'
            | '\u{d4d}'
            | '\u{dca}'
    )
}

fn is_emoji(c: char) -> bool {
    !c.is_ascii() && c.is_emoji_char()
}

fn is_key(c: char) -> bool {
    c.is_ascii_digit() || matches!(c, '#' | '*')
}

fn is_mongolian(c: char) -> bool {
    matches!(c, '\u{1820}'..='\u{18aa}')
}

fn is_ideograph(c: char) -> bool {
    matches!(c, '\u{3400}'..='\u{4dbf}' | '\u{4e00}'..='\u{9fff}' | '\u{f900}'..='\u{faff}' | '\u{20000}'..='\u{3ffff}')
}

#[cfg(test)]
mod tests {
    use super::{seen, unseen};

    #[test]
    fn what_cannot_be_seen_is_reported() {
        let ranges = [
            '\0'..='\u{1f}',
            '\u{7f}'..='\u{9f}',
            '\u{200b}'..='\u{200f}',
            '\u{2028}'..='\u{202e}',
            '\u{2060}'..='\u{206f}',
            '\u{fe00}'..='\u{fe0f}',
            '\u{1bca0}'..='\u{1bca3}',
            '\u{e0000}'..='\u{e01ef}',
        ];
        let single = "\u{ad}\u{34f}\u{61c}\u{115f}\u{1160}\u{17b4}\u{180b}\u{180e}\u{2800}\u{3164}\u{feff}\u{ffa0}\u{1d173}";
        for c in ranges.into_iter().flatten().chain(single.chars()) {
            let found: Vec<char> = unseen(&format!("a{c}b")).collect();
            assert_eq!(found, [c], "U+{:04X}", c as u32);
        }
    }

    #[test]
    fn scripts_and_emoji_keep_what_they_are_written_with() {
        for text in [
            "lab 7, Räder, e\u{301}, 10\u{a0}km",
            "می\u{200c}خواهم",
            "مَ\u{200c}ی",
            "ه\u{200d}.ش",
            "क्\u{200d}ष क्\u{200c}ष",
            "র\u{200d}\u{9cd}যাম",
            "🚲⚡\u{fe0f} ❤\u{fe0f}\u{200d}🔥 ❤\u{fe0e}",
            "🚴🏽\u{200d}♀\u{fe0f}",
            "1\u{fe0f}\u{20e3}",
            "葛\u{e0100}城",
            "ᠠ\u{180b}",
        ] {
            assert_eq!(unseen(text).count(), 0, "{text:?}");
            assert_eq!(seen(text).collect::<String>(), text);
        }
    }

    #[test]
    fn what_changes_nothing_beside_it_is_unseen() {
        for text in [
            "a\u{200c}b",
            "a\u{200d}b",
            "د\u{200c}ر",
            "ب\u{200d}ب",
            "1\u{200d}2",
            "🚲\u{200d}",
            "a\u{fe0f}",
            "1\u{fe0f}",
            "❤\u{fe0f}\u{fe0f}",
            "a\u{200b}\u{fe0f}\u{200d}🔥",
            "a\u{e0100}",
            "a\u{180b}",
        ] {
            assert!(unseen(text).count() > 0, "{text:?}");
            let rest: String = seen(text).collect();
            assert_eq!(unseen(&rest).count(), 0, "{text:?} leaves {rest:?}");
        }
    }
}
