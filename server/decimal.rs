//! Numbers as people type them: with a decimal point or a decimal comma.

use std::borrow::Cow;

/// `12,5` as `12.5`. What is no number with one comma and no point stays as it is.
pub fn with_point(text: &str) -> Cow<'_, str> {
    let is_of_number = |c: char| c.is_ascii_digit() || matches!(c, ',' | '+' | '-' | 'e' | 'E');
    match text.matches(',').count() == 1 && text.chars().all(is_of_number) {
        true => Cow::Owned(text.replace(',', ".")),
        false => Cow::Borrowed(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comma_is_a_decimal_sign_in_a_number_alone() {
        for (text, read) in [
            ("12,5", "12.5"),
            ("-0,5", "-0.5"),
            ("1,5e-3", "1.5e-3"),
            ("12.5", "12.5"),
            ("1.234,5", "1.234,5"),
            ("1,234,5", "1,234,5"),
            ("a,b", "a,b"),
            ("[1,2]", "[1,2]"),
        ] {
            assert_eq!(with_point(text), read);
        }
    }
}
