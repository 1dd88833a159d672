//! Which rides to make: a suite, or a sample of one.

use super::case::Case;
use super::plan;
use crate::chance::Chance;

/// Which rides a suite holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suite {
    Standard,
    Clean300,
    Beside,
    Quiet,
    Strange,
    Conditions,
}

impl Suite {
    pub const ALL: [Suite; 6] = [
        Suite::Standard,
        Suite::Clean300,
        Suite::Beside,
        Suite::Quiet,
        Suite::Strange,
        Suite::Conditions,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Suite::Standard => "standard",
            Suite::Clean300 => "clean300",
            Suite::Beside => "beside",
            Suite::Quiet => "quiet",
            Suite::Strange => "strange",
            Suite::Conditions => "conditions",
        }
    }

    pub fn is_clean(self) -> bool {
        matches!(self, Suite::Clean300 | Suite::Quiet)
    }

    pub fn cases(self, chance: &mut Chance) -> Vec<Case> {
        match self {
            Suite::Standard => plan::standard(chance),
            Suite::Clean300 => plan::clean(300, chance),
            Suite::Beside => plan::beside(100, chance),
            Suite::Quiet => plan::quiet(100, chance),
            Suite::Strange => plan::strange(chance),
            Suite::Conditions => plan::conditions(chance),
        }
    }
}

/// Which rides to make.
#[derive(Clone, Copy, Debug)]
pub struct Order {
    pub seed: u64,
    /// Every n-th ride of the plan; 1 for all.
    pub one_in: usize,
    /// At most so many.
    pub count: usize,
    pub suite: Suite,
}

impl Order {
    /// Names of the rides, as their files have them.
    pub fn names(&self) -> Vec<String> {
        let cases = self.cases();
        cases.iter().map(|(number, _)| ride_name(*number)).collect()
    }

    /// The planned rides with their numbers. A sample keeps the numbers, and so the bytes, of the whole suite.
    pub fn cases(&self) -> Vec<(u64, Case)> {
        let chance = &mut Chance::new(self.seed, 0);
        let numbered = self
            .suite
            .cases(chance)
            .into_iter()
            .enumerate()
            .map(|(i, c)| (i as u64, c));
        numbered.step_by(self.one_in).take(self.count).collect()
    }

    pub fn name(&self) -> &'static str {
        self.suite.name()
    }
}

/// As the files of a ride are named.
pub fn ride_name(number: u64) -> String {
    format!("{:03}", number + 1)
}
