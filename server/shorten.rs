//! Texts of clients in messages and in the log.

use std::borrow::Cow;

/// Most of one that is repeated (characters).
const MOST: usize = 200;

/// The text, or its beginning and an ellipsis.
pub fn shortened(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(MOST) {
        None => text.into(),
        Some((end, _)) => format!("{}…", &text[..end]).into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_end_with_an_ellipsis() {
        let text = "ä".repeat(MOST);
        assert_eq!(shortened(&text), text);
        assert_eq!(shortened(&format!("{text}b")), format!("{text}…"));
    }
}
