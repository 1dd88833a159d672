//! Characters that make a name look like another one, or turn the text around it.

/// Control characters, line and paragraph separators, marks and overrides of direction (Unicode's Bidi_Control), and
/// characters without any width that no script is written with.
pub fn is_unseen(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{ad}' | '\u{61c}' | '\u{200b}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}

#[cfg(test)]
mod tests {
    use super::is_unseen;

    #[test]
    fn what_cannot_be_seen_is_reported_from_what_scripts_are_written_with() {
        let ranges = [
            '\0'..='\u{1f}',
            '\u{7f}'..='\u{9f}',
            '\u{200e}'..='\u{200f}',
            '\u{2028}'..='\u{202e}',
            '\u{2066}'..='\u{2069}',
            '\u{feff}'..='\u{feff}',
        ];
        for c in ranges.into_iter().flatten() {
            assert!(is_unseen(c), "U+{:04X}", c as u32);
        }
        // Persian and emoji join with U+200C and U+200D.
        for c in "lab 7, Räder, \u{5d0}\u{627}\u{200c}\u{200d}\u{301}\u{1f6b2}".chars() {
            assert!(!is_unseen(c), "U+{:04X}", c as u32);
        }
    }
}
