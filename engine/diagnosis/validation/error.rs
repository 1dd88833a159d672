use veloid_model::law::own::LawError;

/// Why a model cannot be compared with a ride. Every message is fit to be shown to the user.
#[derive(Debug, thiserror::Error)]
pub enum Incomparable {
    /// The ride has no channel that says what drove the axles.
    #[error(
        "the ride has no road, no force and no free decay, so that nothing can be simulated: identify it, and compare k and B with \
         their intervals"
    )]
    NoInput,
    /// No axle is left.
    #[error("nothing to compare: {}", .0.join("; "))]
    NothingLeft(Vec<String>),
    /// The document names effects without what simulates them.
    #[error("the model has effects, but its 'simulation' holds none of them: export it again")]
    NoSimulation,
    /// The document names an effect that this version does not have.
    #[error("the model's effect '{0}' is not in the library of this version")]
    UnknownEffect(String),
    /// The document lacks a number of an effect.
    #[error("the model's effect '{effect}' lacks the number '{number}'")]
    NoNumber {
        /// Id of the effect.
        effect: String,
        /// Name of the number.
        number: String,
    },
    /// The law of the user's own in the document cannot be read.
    #[error("the model's own law: {0}")]
    Law(#[from] LawError),
}
