//! Every threshold that decides a verdict: its unit, what it trades, and where it comes from. What one trades is measured on recordings by
//! `cargo run --example judge` (docs/real.md) and on simulated rides by `veloid-truth` (docs/proof.md).
//!
//! Shares and ratios are of squares unless they are said to be of anything else; gains are differences in log likelihood (nats).

pub use veloid_model::policy::*;

// What the likelihood selects and chooses.

/// Gain (nats) for each sample that a second effect must make. Fewer second effects where the noise is not what it is taken for; seeds 101 to 104.
pub const SECOND_GAINS: f64 = 0.02;
/// Share of the held-out squares that it must remove instead; where the road is noisy, in any case. Seeds 101 to 104.
pub const SECOND_REMOVES: f64 = 0.08;
/// Share of the squares which other effects remove that one more must remove, of the held-out or of the fitted part: a law is right to
/// about half a percent of what it does.
pub const TRIFLE: f64 = 2.5e-5;
/// Nats behind the best within which a candidate is chosen by merit. Twice [`TIE`].
pub const CLOSE: f64 = 8.0;
/// Share of its gain for each sample that an effect must repeat on the held-out part. One in three: a gain by chance repeats none.
pub const HELD: f64 = 0.3;
/// Share of the held-out squares that a slow effect may leave, which noise of a slow colour explains as well. Seeds 101 to 104.
pub const SLOWLY: f64 = 0.8;
/// Times the gain of chance that an effect must make which the held-out part cannot confirm, since it belongs to a moment of the fitted part.
pub const UNCONFIRMED: f64 = 2.0;
/// Effects that may act at once.
pub const MOST_TERMS: usize = 3;
/// Nats behind the best within which a model explains a ride as well: odds of 50 to 1.
pub const TIE: f64 = 4.0;
/// The same for a rival that is ahead on the held-out part, where the road is noisy: what that noise alone has led by on fitted parts.
/// Seed 8161090458096550, ride 223.
pub const NOISY_TIE: f64 = 13.0;
/// Nats behind one outside its physical ranges within which a model stands in for it. Seeds 101 to 104.
pub const NEARLY_PHYSICAL: f64 = 70.0;
/// Ties that are reported.
pub const MOST_TIES: usize = 2;
/// Share of the explainable held-out variance from which an extension is adequate, whatever is left. Lower, and incomplete models get names.
pub const ADEQUATE: f64 = 0.98;
/// Times the plain model's held-out error (RMS) that a model with a name may leave: more than chance makes of an effect that hardly shows.
pub const MISLEADS: f64 = 1.1;
/// Nats by which a general curve must lead the named laws of which it is the general case.
pub const CURVE_LEADS: f64 = 10.0;

// Whether anything is left.

/// Gain in held-out log score (nats) from which the free form counts as something left. Lower, and clean rides are no longer clean.
pub const STRUCTURED: f64 = 6.0;
/// Standard deviations of the residual's coherence with what drives the axle from which it is no noise.
pub const DRIVEN: f64 = 9.0;
/// Gain (nats) by forces in the residual's spectrum from which a force counts as left.
pub const RESONANT: f64 = 30.0;
/// Share of the residual's power that these forces must have where nothing is named: the noise of a jittering clock comes in bursts, and
/// its spectrum scatters more than Whittle's likelihood knows.
pub const RESONANT_SHARE: f64 = 0.27;
/// Standard deviations of the residual's kurtosis from which it is no noise of a sensor.
pub const BURSTS: f64 = 6.0;
/// Share of the noise (RMS) that a model must leave: one that leaves less shows that the noise is another.
pub const NOISE_AGREES: f64 = 0.9;
/// Factor by which the noise that replicates of the road are given may be too small.
pub const ROAD_NOISE_UNSURE: f64 = 1.4;
/// Standard deviations of the replicates' scores by which a score must lie above their mean.
pub const BEYOND: f64 = 3.5;
/// Factor by which a measured noise floor may be too low.
pub const FLOOR_UNSURE: f64 = 1.3;
/// Share of the motion (RMS) that a model may leave and still be said to follow it: a fifth of its power is explained.
pub const FOLLOWS: f64 = 0.9;

// What the judge decides by (`judge/table.rs`, docs/diagnosis.md). Where no source is given: ../shared/research/judge/NOTE.md; what each
// trades on recordings is in docs/real.md.

/// Weight of the sets that contain an effect from which it is named, and of those that a verdict rests on.
pub const SUPPORT: f64 = 0.9;
/// Share of what is left without an effect, above the noise, that it must take.
pub const SHARE: f64 = 0.25;
/// The same on a ridden road, and of what a sensor does. Set on strange physics of seed 103: friction that falls with the rate, by dry
/// friction, takes off 0.76; a stop with impact, by a stop, 0.83; where the sensor sits on another mass than the force, a sensor's gain
/// 0.84.
pub const STRICT_SHARE: f64 = 0.85;
/// Share of the force and of the motion (RMS) below which the plain model lacks nothing that is physics of the record.
pub const FLOOR: f64 = 0.02;
/// Samples that a record is worth in which even the best set leaves nothing but the error of the model.
pub const PATIENCE: f64 = 20.0;
/// Nats that a parameter costs.
pub const OCCAM: f64 = 1.0;
/// Times the noise that the plain model may leave (squares) and lack nothing.
pub const QUIET: f64 = 2.0;
/// Share of what the plain model leaves (squares) that a law without a name must take beyond every named one. Set on the sled's chirp
/// of ../shared/real with parts cut off: dry friction takes 0.96 to 0.98 there, and a curve 0.01 to 0.025 beyond it.
pub const OUTGROWS: f64 = 0.03;
/// Contiguous blocks of a record, or of its windows, that models are compared on.
pub const BLOCKS: usize = 10;
/// Length of the shorter windows, beside the ordinary one.
pub const SHORTER: f64 = 0.5;
/// Effects of a set on an axle at most.
pub const MOST_BY_WINDOWS: usize = 3;

// Without a road (`no_road`, docs/latent-road.md). Gains are of twice the log likelihood.

/// Gain, less what its parameters cost, from which an effect is looked at. Clean rides of ../shared/research/no_road: 19 at most.
pub const DETECTED: f64 = 30.0;
/// The same of effects that are linear as the axles are. A clean ride with tracks 1.4 cm apart: 43.
pub const LINEAR_DETECTED: f64 = 60.0;
/// Gain from which such an effect makes k and B doubtful where nothing is named. 14 clean rides: 1 at most; 9 rides with a relaxing tyre
/// or a rider that nobody named: 7 to 40 in 7, nothing in 2.
pub const DOUBT: f64 = 3.0;
/// Part of the first effects' gain that one more must make: laws are right to some percent only.
pub const BESIDE_FIRST: f64 = 0.06;
/// Gain behind the best model within which a twin of one of its effects explains the ride as well.
pub const BEHIND: f64 = 12.0;
/// Times its lead over all others that one more effect may gain and leave the names.
pub const LEADS: f64 = 1.0;
/// Delay (s) of a sensor that is said, and in its standard errors: noise of a GPS speed makes 3 ms of nothing.
pub const LATE_S: f64 = 4e-3;
pub const LATE_ERRORS: f64 = 2.0;
/// Relative standard error of k from which the axles are too similar.
pub const ALIKE: f64 = 0.05;
/// Share by which a friction is unsure whose sign is rounded off over a tenth of the RMS rate or more.
pub const ROUNDED_OFF: f64 = 0.15;
/// Standard error of a damper's size at 100 Hz (share), since road beyond the logger's band shakes it unseen.
pub const SHAKEN: f64 = 0.12;
/// Times the fit's standard errors by which k and B scatter: on 53 simulated rides 1.96 of the fit's contained 87 and 91 % of them.
pub const SCATTER: f64 = 1.3;
/// Standard errors of k and B (shares) that patches, filters and the clock leave whatever the fit says.
pub const LAW_ERRORS: [f64; 2] = [2e-3, 5e-3];
/// Times that much on an axle on which an effect acts: k was 1 to 3 % off beside friction that sticks and beside a strong cubic spring.
pub const BESIDE_EFFECT: f64 = 6.0;
/// The same of the axle beside that one: of 86 intervals of B each 11 were missed, 9 of them there.
pub const BESIDE_OTHER: f64 = 3.0;
/// Rate (Hz) of a logger from which a friction's sign is sharp, and the rate of the deflection, in its RMS values, over which it may then be
/// rounded off: 0.05 to 0.20 of friction, 0.38 to 0.40 of a damper of the power 1/2; up to 200 Hz both are 0.34 to 0.40.
pub const SHARP_HZ: f64 = 225.0;
pub const SHARP: f64 = 0.3;
/// Share of the other axle's acceleration (squares) above which the wheels do not ride on the same road.
pub const OWN_ROAD: f64 = 0.3;

// When a verdict by likelihood is asked again.

/// Share of the held-out squares from which what an effect takes off can be swallowed by the noise.
pub const TAKEN_OFF: f64 = 0.5;
/// Part of the gain in likelihood which that would be in white noise below which it has been.
pub const SWALLOWED: f64 = 0.01;

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::path::Path;

    /// The text of every test in a folder, whole files of tests and the modules at the ends of others.
    fn tests(folder: &Path, text: &mut String) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                tests(&path, text);
            } else if !path.ends_with("policy/mod.rs") {
                let source = std::fs::read_to_string(&path).unwrap();
                let own = source.split_once("#[cfg(test)]\nmod tests {");
                text.push_str(own.map_or("", |(_, own)| own));
            }
        }
    }

    #[test]
    fn every_threshold_has_a_test_beside_its_use_that_is_built_with_it() {
        let mut text = String::new();
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        tests(here, &mut text);
        tests(&here.join("../model"), &mut text);
        let named = |name: &str| {
            let used = format!("policy::{name}");
            let mut after = text.split(&used).skip(1);
            after.any(|rest| !rest.starts_with(|c: char| c.is_ascii_uppercase() || c == '_'))
        };
        let sources = [
            include_str!("mod.rs"),
            include_str!("../../model/policy/mod.rs"),
        ];
        let thresholds: Vec<&str> = (sources.iter().flat_map(|source| source.lines()))
            .filter_map(|line| line.strip_prefix("pub const ")?.split(':').next())
            .collect();
        let untested: Vec<&&str> = thresholds.iter().filter(|name| !named(name)).collect();
        assert!(untested.is_empty(), "{untested:?}");
    }

    #[test]
    fn thresholds_that_are_said_to_go_together_do() {
        assert_eq!(super::CLOSE, 2.0 * super::TIE);
        let rising = [
            [super::SHORTEST_PERIODS, super::DOMINANT_PERIODS],
            [super::TIE, super::NEARLY_PHYSICAL],
        ];
        assert!(rising.iter().all(|[less, more]| less < more), "{rising:?}");
    }
}
