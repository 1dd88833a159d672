//! How the table of a text file is laid out, as the user says it and as it was read.

use serde::{Deserialize, Serialize};

use crate::error::Problem;

/// Most bytes of a time format.
const LONGEST: usize = 64;

/// Where the table of a text file stands and how it is written; what is absent follows from the file's first 200 lines.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(default, deny_unknown_fields)]
pub struct TableLayout {
    /// Line of the column names, counted from 1; 0 for none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub header_row: Option<usize>,
    /// Line of the units; 0 for none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units_row: Option<usize>,
    /// Line of the first numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_row: Option<usize>,
    /// `tab`, `blanks` or a character: `,`, `;`, `|`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub separator: Option<String>,
    /// Decimal mark: `.` or `,`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decimal: Option<String>,
    /// Format of the times, as strptime has it: `%d/%m/%Y %H:%M:%S%.f`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_format: Option<String>,
}

impl TableLayout {
    /// These, and those of `other` that are absent here.
    pub(super) fn or(self, other: &Self) -> Self {
        let other = other.clone();
        Self {
            header_row: self.header_row.or(other.header_row),
            units_row: self.units_row.or(other.units_row),
            first_row: self.first_row.or(other.first_row),
            separator: self.separator.or(other.separator),
            decimal: self.decimal.or(other.decimal),
            time_format: self.time_format.or(other.time_format),
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    pub(super) fn validate(&self) -> Result<(), Problem> {
        let bad = |name, value: &str, expected| {
            Err(Problem::BadOption {
                name,
                value: value.to_owned(),
                expected,
            })
        };
        if let Some(text) = &self.separator
            && self.separator().is_none()
        {
            return bad(
                "layout.separator",
                text,
                "tab, blanks or a character such as ; that no number has",
            );
        }
        if let Some(text) = &self.decimal
            && self.decimal().is_none()
        {
            return bad("layout.decimal", text, ". or ,");
        }
        if self.first_row == Some(0) {
            return bad("layout.first_row", "0", "a line, counted from 1");
        }
        if let Some(text) = &self.time_format
            && (text.len() > LONGEST || !text.contains('%'))
        {
            return bad(
                "layout.time_format",
                text,
                "at most 64 characters such as %d/%m/%Y %H:%M:%S%.f",
            );
        }
        Ok(())
    }

    /// The separating byte; a blank where runs of blanks separate.
    pub(super) fn separator(&self) -> Option<u8> {
        match self.separator.as_deref()? {
            "tab" | "\t" => Some(b'\t'),
            "blanks" | " " => Some(b' '),
            one => match *one.as_bytes() {
                [byte] if byte.is_ascii_punctuation() && !b".+-\"#%".contains(&byte) => Some(byte),
                _ => None,
            },
        }
    }

    pub(super) fn decimal(&self) -> Option<u8> {
        match self.decimal.as_deref()? {
            "." => Some(b'.'),
            "," => Some(b','),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_layouts_are_refused() {
        let of = |edit: fn(&mut TableLayout)| {
            let mut layout = TableLayout::default();
            edit(&mut layout);
            layout.validate().map_err(|fault| fault.to_string())
        };
        assert_eq!(of(|l| l.separator = Some("|".into())), Ok(()));
        for fault in [
            of(|l| l.separator = Some("5".into())),
            of(|l| l.separator = Some("-".into())),
            of(|l| l.decimal = Some("'".into())),
            of(|l| l.first_row = Some(0)),
            of(|l| l.time_format = Some("HH:MM".into())),
        ] {
            assert!(fault.is_err_and(|text| text.contains("layout.")));
        }
    }
}
