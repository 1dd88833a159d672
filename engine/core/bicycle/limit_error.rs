use super::Axle;

/// What is wrong with a quantity that is fixed or bounded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LimitError {
    /// No axle with a quantity of it.
    #[error("'{key}', expected AXLE.QUANTITY such as f.k")]
    Key {
        /// As it was given.
        key: String,
    },
    /// An axle that no bicycle has.
    #[error("{key}: unknown axle '{axle}', expected f, front, r or rear")]
    Axle {
        /// As it was given.
        key: String,
        /// Its axle.
        axle: String,
    },
    /// A quantity that no fit determines.
    #[error(
        "{key}: unknown quantity '{quantity}', expected k or B (a mass is given in the bike file)"
    )]
    Quantity {
        /// As it was given.
        key: String,
        /// Its quantity.
        quantity: String,
    },
    /// A value that is no number.
    #[error("{key} is {value}, expected a finite number")]
    NotFinite {
        /// As it was given.
        key: String,
        /// The value in SI units.
        value: f64,
    },
    /// A value that no axle has.
    #[error("{key} is {value}, expected {low:e} to {high:e} {unit}")]
    OutOfReach {
        /// As it was given.
        key: String,
        /// The value in SI units.
        value: f64,
        /// The least that is accepted.
        low: f64,
        /// The most that is accepted.
        high: f64,
        /// Their unit.
        unit: &'static str,
    },
    /// Bounds without anything between them.
    #[error("{key} is bounded by {low} and {high}, expected the lower bound first")]
    Empty {
        /// As it was given.
        key: String,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// A fixed value that the bounds exclude.
    #[error("{key} is fixed at {value}, outside its bounds {low} to {high}")]
    Outside {
        /// As it was given.
        key: String,
        /// The fixed value.
        value: f64,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// One quantity under two names.
    #[error("{first} and {second} are the same quantity, expected one of them")]
    Twice {
        /// One name.
        first: String,
        /// The other.
        second: String,
    },
    /// An axle whose mass is estimated.
    #[error("{key} needs the mass, but mass_{axle}_kg is null")]
    NoMass {
        /// As it was given.
        key: String,
        /// The axle.
        axle: Axle,
    },
    /// One k and one B for both axles.
    #[error("{key} cannot hold beside equal_axles, which fits one k and one B for both axles")]
    EqualAxles {
        /// As it was given.
        key: String,
    },
    /// An axle of which the ride has no road, force or motion.
    #[error(
        "{key}: the ride has no road or force for the {axle} axle; estimates without a road cannot be fixed or bounded"
    )]
    NotRecorded {
        /// As it was given.
        key: String,
        /// The axle.
        axle: Axle,
    },
    /// Several rides.
    #[error("{key}: a study of several rides cannot fix or bound anything")]
    Study {
        /// As it was given.
        key: String,
    },
}
