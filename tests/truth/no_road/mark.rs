//! A verdict against the truth.

use serde::{Deserialize, Serialize};

use super::class::Class;
use crate::outcome::{Name, Outcome as Said};
use crate::trial::coverage::Covered;

/// A verdict against the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mark {
    Right,
    /// No verdict where none is asked for, with the reason.
    Withheld,
    Wrong,
    /// Neither the truth nor anything false.
    #[default]
    Silent,
}

/// What a verdict is judged by.
pub struct Judged<'a> {
    pub class: Class,
    pub is_clean: bool,
    pub truth: &'a Vec<Name>,
    /// Whether `cannot_tell` says why.
    pub has_reason: bool,
}

impl Judged<'_> {
    pub fn mark(&self, said: &Said, covered: &Covered) -> Mark {
        match self.class {
            Class::Absorbed => self.absorbed(said, covered),
            Class::Outside => outside(said),
            _ => self.by_name(said),
        }
    }

    fn by_name(&self, said: &Said) -> Mark {
        let may_withhold = self.is_clean || self.class == Class::Equal;
        match said.verdict.as_str() {
            "nothing_missing" if self.is_clean => Mark::Right,
            "cannot_tell" if may_withhold && self.has_reason => Mark::Withheld,
            "unnamed" if self.is_clean => Mark::Wrong,
            "named" | "named_in_part" | "ambiguous" => match self.offers_truth(said) {
                true => Mark::Right,
                false => Mark::Wrong,
            },
            _ => Mark::Silent,
        }
    }

    /// The one set that is named, or one of several that explain the ride as well.
    fn offers_truth(&self, said: &Said) -> bool {
        !self.truth.is_empty() && said.sets().contains(self.truth)
    }

    /// Nothing false is named, and no interval of a stiffness leaves out the truth.
    fn absorbed(&self, said: &Said, covered: &Covered) -> Mark {
        match self.by_name(said) {
            Mark::Wrong => Mark::Wrong,
            _ if said.verdict == "failed" => Mark::Silent,
            _ if covered.stiffness.contains(&Some(false)) => Mark::Wrong,
            _ => Mark::Right,
        }
    }
}

fn outside(said: &Said) -> Mark {
    match said.verdict.as_str() {
        "unnamed" => Mark::Right,
        _ if is_named(said) => Mark::Wrong,
        _ => Mark::Silent,
    }
}

pub fn is_named(said: &Said) -> bool {
    matches!(said.verdict.as_str(), "named" | "named_in_part")
}

/// What a report with this verdict and these sets of effects says.
#[cfg(test)]
pub fn said(verdict: &str, sets: &[&[(&str, &str)]]) -> Said {
    use serde_json::{Value, json};

    let set = |set: &&[(&str, &str)]| -> Vec<Value> {
        set.iter()
            .map(|(id, axle)| json!({"id": id, "axle": axle, "affirmed": true}))
            .collect()
    };
    let sets: Vec<Vec<Value>> = sets.iter().map(set).collect();
    let first = sets.first().cloned().unwrap_or_default();
    let others: Vec<_> = sets.iter().skip(1).collect();
    let diagnosis = json!({"verdict": verdict, "effects": first, "alternatives": others});
    Said::read(&json!({"diagnosis": diagnosis}), 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(id: &str, axle: &str) -> Name {
        (id.to_owned(), axle.to_owned())
    }

    fn mark(class: Class, truth: &[Name], said: &Said) -> Mark {
        let judged = Judged {
            class,
            is_clean: truth.is_empty() && class != Class::Outside,
            truth: &truth.to_vec(),
            has_reason: true,
        };
        judged.mark(said, &Covered::default())
    }

    #[test]
    fn clean_rides_are_right_without_a_verdict_that_has_a_reason() {
        let clean = |verdict| mark(Class::Clean, &[], &said(verdict, &[]));
        assert_eq!(clean("nothing_missing"), Mark::Right);
        assert_eq!(clean("cannot_tell"), Mark::Withheld);
        assert_eq!(clean("unnamed"), Mark::Wrong);
        assert_eq!(clean(""), Mark::Silent);
        let stop = said("named", &[&[("bump_stop", "front")]]);
        assert_eq!(mark(Class::Clean, &[], &stop), Mark::Wrong);
        let failed = Judged {
            class: Class::Clean,
            is_clean: true,
            truth: &Vec::new(),
            has_reason: false,
        };
        let unexplained = failed.mark(&said("cannot_tell", &[]), &Covered::default());
        assert_eq!(unexplained, Mark::Silent);
    }

    #[test]
    fn effects_are_right_by_name_and_axle_or_in_a_set() {
        let truth = [name("wheel_out_of_round", "front")];
        let marked =
            |class, verdict, sets: &[&[(&str, &str)]]| mark(class, &truth, &said(verdict, sets));
        let [front, rear] = ["front", "rear"].map(|axle| [("wheel_out_of_round", axle)]);
        let effect = |verdict, sets: &[&[(&str, &str)]]| marked(Class::Effect, verdict, sets);
        assert_eq!(effect("named", &[&front]), Mark::Right);
        assert_eq!(effect("named", &[&rear]), Mark::Wrong);
        assert_eq!(effect("ambiguous", &[&rear, &front]), Mark::Right);
        assert_eq!(effect("ambiguous", &[&rear]), Mark::Wrong);
        let both = [front[0], ("bump_stop", "front")];
        assert_eq!(effect("named", &[&both]), Mark::Wrong);
        for verdict in ["unnamed", "nothing_missing", "cannot_tell"] {
            assert_eq!(effect(verdict, &[&front]), Mark::Silent);
        }
        assert_eq!(marked(Class::Equal, "cannot_tell", &[]), Mark::Withheld);
    }

    #[test]
    fn laws_outside_are_wrong_only_where_a_name_is_affirmed() {
        let marked = |verdict| {
            let said = said(verdict, &[&[("coulomb_friction", "rear")]]);
            mark(Class::Outside, &[], &said)
        };
        assert_eq!(marked("unnamed"), Mark::Right);
        assert_eq!(marked("named"), Mark::Wrong);
        assert_eq!(marked("ambiguous"), Mark::Silent);
        assert_eq!(marked("nothing_missing"), Mark::Silent);
    }

    #[test]
    fn what_is_absorbed_must_leave_the_stiffness_right() {
        let truth = vec![name("viscoelastic_tyre", "rear")];
        let judged = Judged {
            class: Class::Absorbed,
            is_clean: false,
            truth: &truth,
            has_reason: true,
        };
        let with = |verdict, stiffness: &[Option<bool>]| {
            let covered = Covered {
                stiffness: stiffness.to_vec(),
                ..Covered::default()
            };
            judged.mark(&said(verdict, &[&[("bump_stop", "rear")]]), &covered)
        };
        assert_eq!(with("nothing_missing", &[Some(true), None]), Mark::Right);
        assert_eq!(with("nothing_missing", &[Some(false), None]), Mark::Wrong);
        assert_eq!(with("named", &[Some(true), Some(true)]), Mark::Wrong);
        assert_eq!(with("unnamed", &[None, None]), Mark::Right);
    }
}
