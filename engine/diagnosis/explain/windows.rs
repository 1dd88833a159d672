//! What windows of a record say, as it is reported.

use crate::verdict::twice::Sights;
use crate::verdict::windows::{Sight, Supported};
use veloid_core::numerics::finite::finite;
use veloid_model::dataset::{Dataset, Track};
use veloid_model::fit::shooting::Prediction;
use veloid_report::windows::{SingleEffect, WindowEffect, WindowStart, Windows};

/// Single effects that are reported.
const SINGLE: usize = 8;

/// By length; the longer windows come first.
pub fn windows(dataset: &Dataset, track: &Track, sights: &Sights) -> Vec<Windows> {
    let of_length = |(i, sight): (usize, &Sight)| {
        let starts = match i {
            0 => &sights.predictions[..],
            _ => &[],
        };
        let spread = track.spread();
        Windows {
            period_s: sight.period,
            length_s: sight.length,
            count: sight.plain.errors.len(),
            plain_rms_m: finite(spread * sight.plain.left().sqrt()),
            extended_rms_m: finite(spread * sight.found.left().sqrt()),
            effects: sight.effects.iter().map(|e| effect(dataset, e)).collect(),
            single: (sight.single.iter().take(SINGLE))
                .map(|(term, left)| SingleEffect {
                    id: term.id(dataset).to_owned(),
                    left_share: finite(left / sight.plain.left()),
                })
                .collect(),
            starts: starts.iter().map(|p| start(p, spread)).collect(),
        }
    };
    sights.of_length.iter().enumerate().map(of_length).collect()
}

fn effect(dataset: &Dataset, effect: &Supported) -> WindowEffect {
    let [blocks, blocks_led] = effect.blocks;
    let [unseen_blocks, unseen_blocks_led] = [0, 1].map(|i| effect.unseen.map(|unseen| unseen[i]));
    WindowEffect {
        id: effect.term.id(dataset).to_owned(),
        removed_share: finite(effect.share).unwrap_or_default(),
        blocks,
        blocks_led,
        unseen_blocks,
        unseen_blocks_led,
        rival: effect.rival.map(|(term, _)| term.id(dataset).to_owned()),
        rival_ratio: effect.rival.and_then(|(_, ratio)| finite(ratio)),
        holds: effect.holds(),
    }
}

fn start(prediction: &Prediction, spread: f64) -> WindowStart {
    let [height_m, velocity_m_s] = prediction.start;
    WindowStart {
        first_sample: prediction.span.start,
        samples: prediction.span.len(),
        height_m,
        velocity_m_s,
        hidden: prediction.hidden.clone(),
        zero_m: prediction.zero,
        rms_m: finite(spread * prediction.left.sqrt()),
    }
}
