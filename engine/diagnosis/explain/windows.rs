//! The table from which a verdict is read, as it is reported.

use crate::judge::scores::{ScoredSet, Scores};
use crate::judge::table::{EffectSupport, Judgement, Rule};
use crate::policy;
use veloid_core::numerics::finite::finite;
use veloid_report::windows::{EffectScore, PartLength, SetScore, Windows};

/// Sets that are reported.
const SETS: usize = 12;

/// The table of a record whose standard deviation is `spread`.
pub fn windows(spread: f64, scores: &Scores, judgement: &Judgement) -> Windows {
    let mut order: Vec<usize> = (0..scores.sets.len()).collect();
    let weight = |s: &usize| judgement.weights[*s].unwrap_or(-1.0);
    order.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
    order.truncate(SETS);
    let supports = judgement.supports.iter().enumerate();
    Windows {
        rule: judgement.rule,
        lengths: lengths(scores, spread),
        sets: (order.iter())
            .map(|s| set(scores, &scores.sets[*s], judgement.weights[*s]))
            .collect(),
        effects: supports
            .map(|(e, support)| EffectScore {
                id: scores.effects[e].clone(),
                support: judgement.support(scores, e),
                why_not: why_not(judgement, e, support),
            })
            .collect(),
    }
}

/// By length, where the record's standard deviation is `spread`.
fn lengths(scores: &Scores, spread: f64) -> Vec<PartLength> {
    let rms = |left: f64| finite(spread * left.sqrt());
    let of_length = |l: usize| {
        let all = scores.sets.iter().map(|s| s.mean(l));
        PartLength {
            length_s: scores.lengths[l].length_s,
            parts: scores.lengths[l].parts,
            plain_rms_m: scores.plain().and_then(|plain| rms(plain.mean(l))),
            best_rms_m: rms(all.fold(f64::INFINITY, f64::min)),
        }
    };
    (0..scores.lengths.len()).map(of_length).collect()
}

fn set(scores: &Scores, set: &ScoredSet, weight: Option<f64>) -> SetScore {
    let share = |l: usize| finite(set.mean(l) / scores.plain()?.mean(l));
    SetScore {
        effects: (set.effects.iter())
            .map(|e| scores.effects[*e].clone())
            .collect(),
        weight,
        left_share: (0..scores.lengths.len()).map(share).collect(),
    }
}

/// Why the verdict does not name an effect; nothing where it does.
pub fn why_not(judgement: &Judgement, effect: usize, support: &EffectSupport) -> Option<String> {
    if judgement.named.contains(&effect) {
        return None;
    }
    let Some(share) = support.least_share() else {
        return Some("in no physical set".to_owned());
    };
    Some(if support.weight < policy::SUPPORT {
        format!("support below {}", policy::SUPPORT)
    } else if share < policy::SHARE {
        format!("share below {}", policy::SHARE)
    } else {
        match judgement.rule {
            Rule::Supported => "a sensor's, beside another".to_owned(),
            Rule::Tied => "tied".to_owned(),
            Rule::GeneralLaw => "a law without a name explains more".to_owned(),
            Rule::NotFollowed => "no set follows the motion".to_owned(),
            _ => "the plain model misses too little".to_owned(),
        }
    })
}
