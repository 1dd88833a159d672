//! What each set of effects leaves of parts of an axle's record to which it was not fitted.

use serde::{Deserialize, Serialize};

/// The held-out scores of every set of effects that was tried on one axle: the evidence that the verdict is read from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    /// The windows by length, the longer first.
    pub lengths: Vec<ScoredLength>,
    /// Share (0 to 1) of the force (RMS) that the plain model misses in the equation of motion; null where it cannot be computed.
    pub missed_force: Option<f64>,
    /// Ids of the effects in `sets`.
    pub effects: Vec<String>,
    /// The sets of effects; the plain model is the one without any.
    pub sets: Vec<ScoredSet>,
}

/// Windows of one length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ScoredLength {
    /// Length of a window (s); its first half gives the starting state, its second half is scored.
    pub length_s: f64,
    /// Windows, or blocks of the whole record.
    pub parts: usize,
    /// Samples that are scored, of all windows.
    pub samples: usize,
    /// The sensor's noise, as a share of the record's variance; zero where it is not known.
    pub noise: f64,
}

/// One set of effects.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ScoredSet {
    /// Its effects, as places in `effects`.
    pub effects: Vec<usize>,
    /// Number of parameters that its effects add to the plain model.
    pub parameters: usize,
    /// Whether it contains a general law, which has no name.
    pub is_general: bool,
    /// Whether its parameters lie in their physical ranges.
    pub is_physical: bool,
    /// Mean squared error of each block of neighbouring windows, as a share of the record's variance, by length.
    pub left: Vec<Vec<f64>>,
}

impl Scores {
    pub fn plain(&self) -> Option<&ScoredSet> {
        self.sets.iter().find(|s| s.effects.is_empty())
    }

    /// Parts of the record that were judged, of all lengths.
    pub fn parts(&self) -> usize {
        self.lengths.iter().map(|length| length.parts).sum()
    }
}

impl ScoredSet {
    /// Mean over the blocks of one length.
    pub fn mean(&self, length: usize) -> f64 {
        let blocks = self.left.get(length).map_or(&[][..], |blocks| blocks);
        blocks.iter().sum::<f64>() / blocks.len().max(1) as f64
    }
}
