use crate::bicycle::{Axle, BikeError};
use crate::document::NotFinite;

/// Why an identification could not be carried out. Every message is fit to be shown to the user.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// The bike file lacks something that this ride needs, or holds an impossible value.
    #[error("bike file: {0}")]
    Bike(#[from] BikeError),
    /// A setting is outside its allowed range.
    #[error("setting {name}: {problem}")]
    Setting {
        /// Its key.
        name: &'static str,
        /// What is wrong with it.
        problem: String,
    },
    /// The ride holds too little to identify anything on this axle.
    #[error("{axle} axle: {problem}")]
    Ride {
        /// The axle that it is reported of.
        axle: Axle,
        /// What is lacking.
        problem: String,
    },
    /// A fit left the numbers' range or did not reach a minimum.
    #[error("{stage}: {problem}")]
    Diverged {
        /// Where it happened.
        stage: &'static str,
        /// What happened.
        problem: String,
    },
    /// A mistake of this program: a result holds a number that is none.
    #[error(transparent)]
    NotFinite(#[from] NotFinite),
    /// The caller asked to stop.
    #[error("cancelled")]
    Cancelled,
}

impl EngineError {
    /// Whether the input is at fault, so that trying again cannot help.
    pub fn is_input(&self) -> bool {
        matches!(
            self,
            Self::Bike(_) | Self::Setting { .. } | Self::Ride { .. }
        )
    }
}
