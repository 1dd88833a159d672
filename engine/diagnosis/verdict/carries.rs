//! Whether a record carries a verdict at all.

use crate::policy;
use veloid_core::bicycle::Axle;
use veloid_core::document::format_number::Quantity;
use veloid_model::effects::Kind;
use veloid_report::diagnosis::{Diagnosis, EffectReport, Verdict};
use veloid_report::windows::Rule;

/// Why the record carries no verdict, and what to record instead, with the rule that says so; nothing where it does. `moves`: RMS of
/// what each axle does (m), or of the force that answers (N).
pub fn why_not(d: &Diagnosis, moves: &dyn Fn(Axle) -> f64) -> Option<(Rule, String)> {
    let because = |rule: Rule, why: Option<String>| Some((rule, why?));
    let undetermined = || because(Rule::Undetermined, undetermined(d));
    match d.verdict {
        Verdict::NothingMissing => {
            because(Rule::NotFollowed, unfollowed(d, moves, policy::FOLLOWS)).or_else(undetermined)
        }
        Verdict::CannotTell => because(Rule::NotFollowed, unfollowed(d, moves, 0.0)),
        Verdict::Unnamed => undetermined(),
        // What predicts parts of the record to which it was not fitted acts, whatever its size.
        Verdict::Named | Verdict::Ambiguous if d.rule == Some(Rule::Likelihood) => {
            because(Rule::Unsized, unsized_effects(d))
        }
        Verdict::Named | Verdict::Ambiguous | Verdict::NamedInPart => None,
    }
}

/// That no set of effects follows more of an axle's motion than that share leaves.
fn unfollowed(d: &Diagnosis, moves: &dyn Fn(Axle) -> f64, most: f64) -> Option<String> {
    let left = |(axle, held): (Axle, &veloid_report::diagnosis::HeldOut)| {
        let ([plain, ..], unit) = held.errors();
        let left = plain?;
        (left > most * moves(axle)).then_some((axle, left, unit))
    };
    let (axle, left, unit) = d.held_out.iter().find_map(left)?;
    let size = |rms: f64| Quantity::rough(rms, 3, unit);
    Some(format!(
        "No verdict: the plain spring and damper explain too little of the {axle} axle's response ({} of {} are left), and no \
         effect in the library explains more. Are channels swapped, inverted or only noise?",
        size(left),
        size(moves(axle))
    ))
}

/// That neither k nor B is known on any axle.
fn undetermined(d: &Diagnosis) -> Option<String> {
    let mut axles = d.extended.iter().peekable();
    axles.peek()?;
    let unknown = axles.all(|(_, e)| e.k_std_n_m.is_none() && e.b_std_n_s_m.is_none());
    unknown.then(|| {
        format!(
            "No verdict: this record determines neither stiffness nor damping of any axle. {MORE}"
        )
    })
}

/// That no size of what would explain the record is known.
fn unsized_effects(d: &Diagnosis) -> Option<String> {
    let unknown = !d.effects.is_empty() && !d.effects.iter().any(has_size);
    unknown.then(|| {
        let names: Vec<String> = d.effects.iter().map(|e| e.id.replace('_', " ")).collect();
        format!(
            "No verdict: an effect is missing and {} would explain it, but this record does not determine its size, so a similar \
             effect is as likely. {MORE}",
            names.join(" with ")
        )
    })
}

/// Whether the record determines the size of an effect, or that is expected of any bicycle and said so.
pub fn has_size(effect: &EffectReport) -> bool {
    let expected = |kind: Kind| !kind.spec().expected.is_empty();
    Kind::by_id(&effect.id).is_some_and(expected)
        || (effect.parameters.values()).any(|p| p.std_error.is_some_and(|std| std > 0.0))
}

/// What to record instead.
const MORE: &str = "Record a motion that passes through the axle's resonance at several amplitudes: a road or a force of many \
                    frequencies, or a release from a larger deflection, for at least twenty periods.";

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_core::bicycle::PerAxle;
    use veloid_report::Estimate;
    use veloid_report::diagnosis::{HeldOut, ParameterReport, Place};

    /// A diagnosis of a front axle that moves by 3 mm, of which `left` (m) is left, with an error of `k_std` (N/m).
    fn why(
        verdict: Verdict,
        left: f64,
        k_std: Option<f64>,
        effects: Vec<EffectReport>,
    ) -> Option<String> {
        let held = HeldOut {
            plain_rms_m: Some(left),
            ..HeldOut::default()
        };
        let estimate = Estimate {
            k_std_n_m: k_std,
            ..Estimate::default()
        };
        let d = Diagnosis {
            verdict,
            rule: Some(Rule::Likelihood),
            effects,
            held_out: PerAxle {
                front: Some(held),
                rear: None,
            },
            extended: PerAxle {
                front: Some(estimate),
                rear: None,
            },
            ..Diagnosis::without_verdict(String::new())
        };
        why_not(&d, &|_| 3e-3).map(|(_, why)| why.replace('\u{a0}', " "))
    }

    fn friction(std_error: Option<f64>) -> EffectReport {
        let size = ParameterReport {
            value: 10.0,
            std_error,
            not_identifiable: None,
            unit: "N".to_owned(),
        };
        EffectReport {
            id: "coulomb_friction".to_owned(),
            axle: Place::Front,
            parameters: [("friction".to_owned(), size)].into(),
            p_value: None,
            separation: None,
            affirmed: true,
            support: None,
            adequate: true,
            material: true,
            sentence: String::new(),
        }
    }

    #[test]
    fn what_follows_nothing_is_no_ground_for_a_verdict() {
        let left = |share: f64| why(Verdict::NothingMissing, share * 3e-3, Some(1.0), Vec::new());
        assert_eq!(left(0.997 * policy::FOLLOWS), None);
        let nothing = left(1.003 * policy::FOLLOWS).unwrap_or_default();
        assert!(
            nothing.contains("too little") && nothing.contains("2.71 mm of 3 mm"),
            "{nothing}"
        );
    }

    #[test]
    fn without_k_and_b_there_is_no_verdict() {
        for verdict in [Verdict::NothingMissing, Verdict::Unnamed] {
            assert_eq!(why(verdict, 1e-4, Some(1.0), Vec::new()), None);
            let unknown = why(verdict, 1e-4, None, Vec::new()).unwrap_or_default();
            assert!(
                unknown.contains("neither stiffness nor damping"),
                "{unknown}"
            );
        }
    }

    #[test]
    fn an_effect_without_a_size_is_no_name() {
        assert_eq!(
            why(Verdict::Named, 1e-4, Some(1.0), vec![friction(Some(1.0))]),
            None
        );
        let unknown = why(Verdict::Named, 1e-4, Some(1.0), vec![friction(None)]);
        assert!(
            unknown
                .unwrap_or_default()
                .contains("coulomb friction would explain it")
        );
    }
}
