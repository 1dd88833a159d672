/// Why a law cannot be used.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum LawError {
    #[error("{bytes} bytes, expected at most {most}")]
    Long { bytes: usize, most: usize },
    #[error("line {line}, column {column}: {problem}")]
    Toml {
        line: usize,
        column: usize,
        problem: String,
    },
    #[error("{field}: {problem}")]
    Field { field: String, problem: String },
    #[error("{field}, column {column}: {problem}")]
    Expression {
        field: String,
        column: usize,
        problem: String,
    },
}
