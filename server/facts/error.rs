use crate::unique::shown;

/// What is wrong with a fact.
#[derive(Debug, thiserror::Error)]
pub enum FactsError {
    #[error("facts: {0}")]
    Shape(#[from] serde_json::Error),
    #[error("{name}: {found}, expected {expected}")]
    Kind {
        name: String,
        found: String,
        expected: &'static str,
    },
    #[error("{name}: {value} {unit}, expected {least} to {most} {unit}")]
    Range {
        name: String,
        value: f64,
        unit: &'static str,
        least: f64,
        most: f64,
    },
    #[error("{name}: {length} characters, expected at most {most}")]
    Long {
        name: String,
        length: usize,
        most: usize,
    },
    #[error("{what}: {count}, expected at most {most}")]
    Many {
        what: &'static str,
        count: usize,
        most: usize,
    },
    #[error("{name}: U+{code:04X} in the text, expected characters that can be seen")]
    Unseen { name: String, code: u32 },
    #[error("ridden_at: {0}, which is in the future")]
    Ahead(String),
    #[error(
        "unknown fact `{name}`, expected {known}, or a number under a name of small letters, digits and `_`"
    )]
    Unknown { name: String, known: String },
    #[error("{0}: given twice, expected once")]
    Twice(String),
    #[error("line {line}: {error}")]
    Line { line: usize, error: Box<FactsError> },
}

impl FactsError {
    pub(super) fn kind(name: &str, found: &str, expected: &'static str) -> Self {
        Self::Kind {
            name: shown(name),
            found: format!("'{}'", shown(found)),
            expected,
        }
    }
}
