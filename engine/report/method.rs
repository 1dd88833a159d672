//! The methods, by the names that reports, fleets and pages have for them.

use serde::{Deserialize, Serialize};

/// A method of estimating stiffness and damping.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The base model with the effects that the diagnosis names.
    Extended,
    /// The base model fitted to the simulated displacement.
    OutputError,
    /// Both axles' answers to the same unknown road.
    LatentRoad,
    /// The modified particle swarm of the paper, eqs. (25) to (30).
    Swarm,
    /// Least squares with instruments from the simulated model.
    Instrumental,
    /// Least squares on the observer's states, paper eqs. (19) to (21).
    LeastSquares,
}

impl Method {
    /// All of them, the one that says most of a ride first.
    pub const ALL: [Method; 6] = [
        Method::Extended,
        Method::OutputError,
        Method::LatentRoad,
        Method::Swarm,
        Method::Instrumental,
        Method::LeastSquares,
    ];

    /// Their names, in the same order.
    pub const NAMES: [&str; 6] = {
        let mut names = [""; 6];
        let mut i = 0;
        while i < names.len() {
            names[i] = Self::ALL[i].name();
            i += 1;
        }
        names
    };

    /// The name in documents.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Extended => "extended",
            Self::OutputError => "output_error",
            Self::LatentRoad => "latent_road",
            Self::Swarm => "swarm",
            Self::Instrumental => "instrumental",
            Self::LeastSquares => "least_squares",
        }
    }

    /// The name for people.
    pub const fn title(self) -> &'static str {
        match self {
            Self::Extended => "extended model",
            Self::OutputError => "output error (plain model)",
            Self::LatentRoad => "latent road (none measured)",
            Self::Swarm => "particle swarm",
            Self::Instrumental => "instrumental variables",
            Self::LeastSquares => "least squares",
        }
    }

    /// The method of this name in documents.
    pub fn by_name(name: &str) -> Option<Method> {
        Self::ALL.into_iter().find(|method| method.name() == name)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_method_has_one_name_in_documents_and_code() {
        for (method, name) in Method::ALL.into_iter().zip(Method::NAMES) {
            let written = serde_json::to_value(method).unwrap();
            assert_eq!(written, name);
            assert_eq!(Method::by_name(name), Some(method));
        }
        assert_eq!(Method::by_name("guess"), None);
    }
}
