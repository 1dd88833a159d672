use crate::bicycle::{Axle, BikeError, LimitError};
use crate::document::NotFinite;

/// Why an identification could not be carried out. Every message is fit to be shown to the user.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// The bike file lacks something that this ride needs, or holds an impossible value.
    #[error("bike file: {0}")]
    Bike(#[from] BikeError),
    /// A setting, or what was asked for beside the ride, cannot be used.
    #[error("setting {name}: {problem}")]
    Setting {
        /// Its key, or what it is where it has none.
        name: &'static str,
        /// What is wrong with it.
        problem: SettingProblem,
    },
    /// The ride holds too little to identify anything on this axle.
    #[error("{axle} axle: {problem}")]
    Ride {
        /// The axle that lacks something.
        axle: Axle,
        /// What is lacking.
        problem: RideProblem,
    },
    /// A fit left the numbers' range or did not reach a minimum.
    #[error("{stage}: {problem}")]
    Diverged {
        /// Where it happened: `swarm`, `output error` or `diagnosis`.
        stage: &'static str,
        /// What happened.
        problem: Divergence,
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

/// What is wrong with a setting.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingProblem {
    /// A number that is too small or too large.
    #[error("{value} is outside {low} to {high}")]
    OutOfRange {
        /// Value in the unit of the setting.
        value: f64,
        /// Least value.
        low: f64,
        /// Largest value.
        high: f64,
    },
    /// All weights of the swarm's errors are zero.
    #[error("at least one must be positive")]
    NoWeight,
    /// More simulations of the whole ride than the swarm may do.
    #[error("{simulations} simulations requested, at most {most} allowed")]
    TooManySimulations {
        /// Trials times particles times iterations.
        simulations: usize,
        /// Largest number of them.
        most: usize,
    },
    /// What is fixed or bounded cannot be.
    #[error("{0}")]
    Limit(#[from] LimitError),
    /// The text of the user's own law cannot be read; says where and why.
    #[error("{0}")]
    Law(String),
    /// The user's own law is called as an effect of the library is.
    #[error("id: '{id}' is already an effect of the library")]
    LawTaken {
        /// Its id.
        id: String,
    },
    /// One record among the rides of a study twice, where it would count twice.
    #[error("{first} and {second} are the same record; each ride counts once")]
    SameRecord {
        /// Name of the ride that comes first.
        first: String,
        /// Name of the other.
        second: String,
    },
    /// Fewer than two rides of a study can take part.
    #[error("{ready} of {given} can be used, at least 2 are needed. {}", .left_aside.iter().map(|(name, why)| format!("{name}: {why}")).collect::<Vec<_>>().join("; "))]
    TooFewRides {
        /// Rides that can.
        ready: usize,
        /// Rides that were given.
        given: usize,
        /// Name of each ride that cannot, and why.
        left_aside: Vec<(String, String)>,
    },
    /// Rides of a study that do not have the same axles.
    #[error("{first} and {second} were recorded on different axles")]
    DifferentAxles {
        /// Name of the ride that comes first.
        first: String,
        /// Name of the other.
        second: String,
    },
    /// Two lasers to be simulated on one axle.
    #[error("there are two on the {axle} axle")]
    TwoLasers {
        /// The axle.
        axle: Axle,
    },
    /// An effect that cannot be put into a simulated ride.
    #[error("{id}: {problem}")]
    Effect {
        /// Its id as it was given.
        id: String,
        /// What is wrong with it.
        problem: ImposedProblem,
    },
    /// The effects that were put into a simulated ride make it run away.
    #[error("the motion grows without bound")]
    RunsAway,
}

/// Why an effect cannot be put into a simulated ride.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImposedProblem {
    /// The library has no such effect.
    #[error("no such effect, expected one of {}", .known.join(", "))]
    Unknown {
        /// Ids of all that exist.
        known: Vec<&'static str>,
    },
    /// The same effect in the same place a second time.
    #[error("is given twice")]
    Twice,
    /// The ride lacks what the effect needs.
    #[error("{why}")]
    Lacking {
        /// What it lacks, in a sentence.
        why: String,
    },
    /// It cannot act there.
    #[error("the axle can be {} here", .possible.join(" or "))]
    Axle {
        /// Where it can: `front`, `rear`, `both`.
        possible: Vec<&'static str>,
    },
    /// The axle that it acts on is not part of the ride.
    #[error("nothing is simulated on this axle")]
    NotSimulated,
    /// A parameter that the effect does not have.
    #[error("has no parameter '{name}', only {}", .known.join(", "))]
    UnknownParameter {
        /// Its name as it was given.
        name: String,
        /// Names of all that the effect has.
        known: Vec<String>,
    },
    /// A parameter that was not given.
    #[error("{name} is missing; expected {}", .known.join(", "))]
    MissingParameter {
        /// Its name.
        name: String,
        /// Names of all that the effect has.
        known: Vec<String>,
    },
    /// A parameter that no bicycle has, or that this ride cannot show.
    #[error("{name} = {value} is outside its range on this ride")]
    OutOfRange {
        /// Its name.
        name: String,
        /// Value in the parameter's unit.
        value: f64,
    },
}

/// What a ride lacks on an axle.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RideProblem {
    /// k and B do not show in the motion, or only with numbers that are not finite.
    #[error("the motion does not determine stiffness and damping ({method})")]
    Undetermined {
        /// Method that finds no estimate: `least squares` or `instrumental variables`.
        method: &'static str,
    },
    /// k and B do not show because the record was read wrongly.
    #[error("{sentence}")]
    Misread {
        /// What is wrong and how to fix it.
        sentence: String,
    },
    /// The swarm has nothing to compare with.
    #[error("the {signal} does not vary over the samples that the swarm compares")]
    NoVariation {
        /// `displacement`, `velocity` or `acceleration`.
        signal: &'static str,
    },
    /// A laser is to be simulated on an axle that is not.
    #[error("there is a laser, but nothing else is recorded")]
    OnlyLaser,
    /// The benchmark was given a ride without this axle.
    #[error("the benchmark needs both axles")]
    NotBothAxles,
}

/// How a fit failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Divergence {
    /// Every particle's simulation leaves the numbers' range.
    #[error("no particle of trial {trial} gives a finite simulation")]
    NoParticle {
        /// Index of the swarm's trial (from 0).
        trial: usize,
    },
    /// The plain model's simulation leaves the numbers' range wherever the fit starts.
    #[error(
        "the plain model reaches no finite error from any of {starts} starts: is a channel's sign or unit wrong?"
    )]
    NoStart {
        /// Number of starts that were tried.
        starts: usize,
    },
    /// The diagnosis has no plain model of an axle to add effects to.
    #[error("the plain model of the {axle} axle has no finite fit")]
    NoPlainModel {
        /// The axle.
        axle: Axle,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_read_as_they_are_documented_and_name_their_numbers() {
        let setting = |name, problem| EngineError::Setting { name, problem }.to_string();
        let (value, low, high) = (200.0, 1.0, 100.0);
        assert_eq!(
            setting("trials", SettingProblem::OutOfRange { value, low, high }),
            "setting trials: 200 is outside 1 to 100"
        );
        let aside = |name: &str| (name.to_owned(), format!("{name} is short"));
        let few = SettingProblem::TooFewRides {
            ready: 1,
            given: 3,
            left_aside: vec![aside("a"), aside("b")],
        };
        assert_eq!(
            setting("rides of a study", few),
            "setting rides of a study: 1 of 3 can be used, at least 2 are needed. a: a is short; b: b is short"
        );
        let effect = |problem| {
            let id = "bump_stop".to_owned();
            setting("effect", SettingProblem::Effect { id, problem })
        };
        let known = vec!["gap".to_owned(), "side".to_owned()];
        let missing = ImposedProblem::MissingParameter {
            name: "gap".to_owned(),
            known: known.clone(),
        };
        assert_eq!(
            effect(missing),
            "setting effect: bump_stop: gap is missing; expected gap, side"
        );
        let name = "hue".to_owned();
        assert_eq!(
            effect(ImposedProblem::UnknownParameter { name, known }),
            "setting effect: bump_stop: has no parameter 'hue', only gap, side"
        );
        let possible = vec!["front", "both"];
        assert_eq!(
            effect(ImposedProblem::Axle { possible }),
            "setting effect: bump_stop: the axle can be front or both here"
        );
        let ride = EngineError::Ride {
            axle: Axle::Rear,
            problem: RideProblem::Undetermined {
                method: "least squares",
            },
        };
        assert_eq!(
            ride.to_string(),
            "rear axle: the motion does not determine stiffness and damping (least squares)"
        );
        let diverged = EngineError::Diverged {
            stage: "output error",
            problem: Divergence::NoStart { starts: 4 },
        };
        assert_eq!(
            diverged.to_string(),
            "output error: the plain model reaches no finite error from any of 4 starts: is a channel's sign or unit wrong?"
        );
        assert!(ride.is_input() && !diverged.is_input());
    }
}
