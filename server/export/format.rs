use std::path::Path;

use serde::Deserialize;
use utoipa::ToSchema;

/// What the model is written as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = ModelFormat)]
pub enum Format {
    #[default]
    Json,
    /// A script for MATLAB and Octave.
    Matlab,
    /// A script for Python with NumPy and SciPy.
    Python,
    /// The ride on the samples that the model was fitted on, for the scripts.
    Csv,
}

impl Format {
    /// What a file's name asks for.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()? {
            "json" => Some(Self::Json),
            "m" => Some(Self::Matlab),
            "py" => Some(Self::Python),
            "csv" => Some(Self::Csv),
            _ => None,
        }
    }

    /// Media type, and the name of the file.
    pub fn media(self) -> [&'static str; 2] {
        match self {
            Self::Json => ["application/json", "veloid_model.json"],
            Self::Matlab => ["text/x-matlab; charset=utf-8", "veloid_model.m"],
            Self::Python => ["text/x-python; charset=utf-8", "veloid_model.py"],
            Self::Csv => ["text/csv; charset=utf-8", "veloid_ride.csv"],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_says_what_it_wants() {
        let of = |name: &str| Format::of(Path::new(name));
        assert_eq!(of("a/model.py"), Some(Format::Python));
        assert_eq!(of("model.m"), Some(Format::Matlab));
        assert_eq!(of("model.json"), Some(Format::Json));
        assert_eq!(of("ride.csv"), Some(Format::Csv));
        assert_eq!(of("model"), None);
    }
}
