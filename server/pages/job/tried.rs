//! The table from which the verdict on an axle was read.

use veloid_engine::document::format_number::{Quantity, fixed};
use veloid_engine::report::windows::{EffectScore, PartLength, Rule, SetScore, Windows};

use crate::pages::words;

pub struct TriedView {
    pub axle: &'static str,
    pub rule: &'static str,
    pub lengths: Vec<String>,
    /// Effect, support, share, what comes nearest in its place, and why the verdict does not name it.
    pub effects: Vec<[String; 5]>,
    /// Effects, weight, and the share of the plain model's squared error that is left, by length.
    pub sets: Vec<(String, String, Vec<String>)>,
}

const UNKNOWN: &str = "–";

impl TriedView {
    /// `unit`: that of what the record holds.
    pub fn of(axle: &'static str, windows: &Windows, unit: &str) -> Self {
        let mut effects: Vec<&EffectScore> = windows.effects.iter().collect();
        effects.sort_by(|a, b| b.support.weight.total_cmp(&a.support.weight));
        Self {
            axle,
            rule: rule(windows.rule),
            lengths: windows.lengths.iter().map(|l| length(l, unit)).collect(),
            effects: effects.into_iter().map(effect).collect(),
            sets: windows.sets.iter().map(set).collect(),
        }
    }
}

/// The row of the table, in words.
fn rule(rule: Rule) -> &'static str {
    match rule {
        Rule::NothingMissed => "the plain model misses hardly any force and hardly any motion",
        Rule::NoiseLeft => {
            "the plain model leaves no more than noise, and no effect takes a share of that"
        }
        Rule::NotFollowed => "no set of effects follows the motion",
        Rule::GeneralLaw => "a law without a name explains more than every named effect",
        Rule::Supported => "the named effects hold the support, and each takes its share",
        Rule::Tied => "a few sets hold the support together",
        Rule::Unsupported => "no set of effects holds the support",
        Rule::Likelihood => "the likelihood of the whole ride decides",
        Rule::Undetermined => "the record determines neither stiffness nor damping",
        Rule::Unsized => "the record does not determine the size of any effect",
    }
}

fn length(length: &PartLength, unit: &str) -> String {
    let rms = |rms: Option<f64>| {
        rms.map_or(UNKNOWN.to_owned(), |x| {
            Quantity::rough(x, 3, unit).to_string()
        })
    };
    format!(
        "{} parts of {}: the plain model leaves {}, the best set {}",
        length.parts,
        Quantity::rough(length.length_s, 3, "s"),
        rms(length.plain_rms_m),
        rms(length.best_rms_m)
    )
}

fn effect(effect: &EffectScore) -> [String; 5] {
    let support = &effect.support;
    [
        words::title(&effect.id),
        fixed(support.weight, 2),
        (support.share).map_or(UNKNOWN.to_owned(), |share| fixed(share, 2)),
        (support.next.as_ref()).map_or(UNKNOWN.to_owned(), |id| words::plain(id)),
        effect.why_not.clone().unwrap_or("named".to_owned()),
    ]
}

fn set(set: &SetScore) -> (String, String, Vec<String>) {
    let effects: Vec<String> = set.effects.iter().map(|id| words::plain(id)).collect();
    let name = match effects.is_empty() {
        true => "spring and damper".to_owned(),
        false => effects.join(" with "),
    };
    let weight = set
        .weight
        .map_or("not physical".to_owned(), |w| fixed(w, 2));
    let left = |share: &Option<f64>| {
        share.map_or(UNKNOWN.to_owned(), |share| {
            format!("{} %", fixed(100.0 * share, 2))
        })
    };
    (name, weight, set.left_share.iter().map(left).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_a_rig_are_forces() {
        let of = |unit| {
            let parts = PartLength {
                length_s: 2.0,
                parts: 6,
                plain_rms_m: Some(204.0),
                best_rms_m: None,
            };
            length(&parts, unit).replace('\u{a0}', " ")
        };
        assert_eq!(
            of("N"),
            "6 parts of 2 s: the plain model leaves 204 N, the best set –"
        );
    }
}
