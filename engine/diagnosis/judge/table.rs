//! The table that decides: from what sets of effects leave of an axle's held-out windows to a verdict. The first row that applies
//! gives it.

use super::numbers::Numbers;
use super::scores::{ScoredSet, Scores};
use super::weights::weights;
use crate::policy;
use veloid_model::effects::Kind;

/// The row of the table that gave the verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// The plain model misses hardly any force and hardly any motion.
    NothingMissed,
    /// It leaves no more than noise, and no set of effects takes a share of that.
    NoiseLeft,
    /// Not even the best set follows the motion of held-out windows.
    NotFollowed,
    /// A law without a name takes a share of what every set of named effects leaves.
    GeneralLaw,
    /// Sets that contain the named effects hold the support, and each of these takes its share.
    Supported,
    /// A few sets hold the support together.
    Tied,
    /// More sets than that share the support, or it lies with sets of which no effect takes its share.
    Unsupported,
}

/// What the scores say of an axle.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    pub rule: Rule,
    /// The supported effects, or the tied sets, the heaviest first; as places in the scores' `effects`.
    pub sets: Vec<Vec<usize>>,
    /// By effect, in the order of the scores' `effects`.
    pub supports: Vec<EffectSupport>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct EffectSupport {
    /// Weight of the sets that contain it.
    pub weight: f64,
    /// Part of what is left without it, above the noise, that it takes off the heaviest set that contains it, by length.
    pub share: Vec<f64>,
    /// The effect that comes nearest in its place.
    pub next: Option<usize>,
}

/// Sets that are reported as tied at most.
const MOST_TIED: usize = 3;
/// Weight of a set from which it is reported as tied.
const COUNTS_AS_TIED: f64 = 0.05;
/// Weight of the sets of which no effect takes its share from which no names are tied.
const MOSTLY_NONE: f64 = 0.5;

/// The verdict on one axle.
pub fn judge(scores: &Scores, numbers: &Numbers) -> Judgement {
    let matrix = Matrix::new(scores, numbers);
    let supports = matrix.supports();
    let says = |rule, sets| Judgement {
        rule,
        sets,
        supports: supports.clone(),
    };
    if matrix.misses() < numbers.floor {
        return says(Rule::NothingMissed, Vec::new());
    }
    if !matrix.follows() {
        return says(Rule::NotFollowed, Vec::new());
    }
    if matrix.has_general_law() {
        return says(Rule::GeneralLaw, Vec::new());
    }
    let named: Vec<usize> = (0..supports.len())
        .filter(|e| supports[*e].weight >= numbers.support && matrix.is_large(&supports[*e].share))
        .collect();
    match matrix.tied_kin(&supports, &named) {
        Some(sets) => return says(Rule::Tied, sets),
        None if !named.is_empty() => return says(Rule::Supported, vec![named]),
        None => {}
    }
    let tally = matrix.tally();
    let of_none: f64 = tally
        .iter()
        .filter(|(set, _)| set.is_empty())
        .map(|(_, w)| w)
        .sum();
    if of_none >= MOSTLY_NONE {
        let rule = match matrix.idle() >= numbers.support && matrix.is_quiet() {
            true => Rule::NoiseLeft,
            false => Rule::Unsupported,
        };
        return says(rule, Vec::new());
    }
    let tied: Vec<Vec<usize>> = (tally.into_iter())
        .filter(|(set, weight)| !set.is_empty() && *weight > COUNTS_AS_TIED)
        .map(|(set, _)| set)
        .collect();
    match tied.len() <= MOST_TIED {
        true => says(Rule::Tied, tied),
        false => says(Rule::Unsupported, Vec::new()),
    }
}

/// Whether a law is a case of a general one.
fn is_case(narrow: Kind, wide: Kind) -> bool {
    narrow.case_of() == Some(wide)
        || matches!(
            (narrow, wide),
            (Kind::CubicStiffness, Kind::PowerStiffness)
                | (Kind::QuadraticDamping, Kind::PowerDamping)
                | (Kind::CoulombFriction, Kind::FrictionCurve)
        )
}

/// The scores with what each set weighs.
struct Matrix<'a> {
    scores: &'a Scores,
    numbers: &'a Numbers,
    /// Sets that can be; those with a general law compete with the others, without a name.
    sets: Vec<&'a ScoredSet>,
    weights: Vec<f64>,
    /// What the best set leaves of each length, or the noise if that is less.
    floors: Vec<f64>,
}

impl<'a> Matrix<'a> {
    fn new(scores: &'a Scores, numbers: &'a Numbers) -> Self {
        let sets: Vec<&ScoredSet> = (scores.sets.iter())
            .filter(|s| s.is_physical && s.effects.len() <= policy::MOST_BY_WINDOWS)
            .collect();
        let lengths = 0..scores.lengths.len();
        let mut weighed = vec![0.0; sets.len()];
        for length in lengths.clone() {
            let own = weights(scores, &sets, length, numbers);
            weighed
                .iter_mut()
                .zip(own)
                .for_each(|(sum, own)| *sum += own / lengths.len() as f64);
        }
        let floor = |length: usize| {
            let best = sets
                .iter()
                .map(|s| s.mean(length))
                .fold(f64::INFINITY, f64::min);
            scores.lengths[length].noise.min(best)
        };
        Self {
            floors: lengths.map(floor).collect(),
            weights: weighed,
            sets,
            scores,
            numbers,
        }
    }

    fn plain(&self) -> Option<&ScoredSet> {
        self.sets.iter().find(|s| s.effects.is_empty()).copied()
    }

    /// Share of the force or of the motion (RMS) that the plain model misses, whichever is more.
    fn misses(&self) -> f64 {
        let motion = self.plain().map_or(f64::INFINITY, |s| s.mean(0).sqrt());
        self.scores
            .missed_force
            .map_or(f64::INFINITY, |force| force.max(motion))
    }

    /// Whether some set follows the motion of held-out windows of every length.
    fn follows(&self) -> bool {
        let most = policy::FOLLOWS * policy::FOLLOWS;
        (0..self.floors.len()).all(|length| self.sets.iter().any(|s| s.mean(length) <= most))
    }

    /// Part of what is left without something, above the noise, that it takes.
    fn taken(&self, without: f64, with: f64, length: usize) -> f64 {
        let floor = self.floors[length];
        (without - with) / (without - floor).max(floor).max(f64::MIN_POSITIVE)
    }

    /// Part of what is left without an effect that it takes off a set, by length.
    fn share(&self, set: &ScoredSet, effect: usize) -> Vec<f64> {
        let rest = |s: &&&ScoredSet| {
            !s.effects.contains(&effect) && s.effects.iter().all(|e| set.effects.contains(e))
        };
        let most = self
            .sets
            .iter()
            .filter(rest)
            .map(|s| s.effects.len())
            .max()
            .unwrap_or(0);
        let of_length = |length| {
            let without = self
                .sets
                .iter()
                .filter(rest)
                .filter(|s| s.effects.len() == most);
            let without = without
                .map(|s| s.mean(length))
                .fold(f64::INFINITY, f64::min);
            self.taken(without, set.mean(length), length)
        };
        (0..self.floors.len()).map(of_length).collect()
    }

    fn kind(&self, effect: usize) -> Option<Kind> {
        Kind::by_id(&self.scores.effects[effect])
    }

    fn is_general(&self, effect: usize) -> bool {
        self.kind(effect).is_some_and(|kind| kind.spec().is_general)
    }

    /// Whether a set has an effect, or a general law of which it is a case.
    fn speaks_for(&self, set: &ScoredSet, effect: usize) -> bool {
        let wider = |e: &usize| {
            let both = self.kind(effect).zip(self.kind(*e));
            both.is_some_and(|(narrow, wide)| is_case(narrow, wide))
        };
        set.effects.contains(&effect) || set.effects.iter().any(wider)
    }

    fn is_large(&self, share: &[f64]) -> bool {
        share.iter().copied().fold(f64::INFINITY, f64::min) >= self.numbers.share
    }

    fn supports(&self) -> Vec<EffectSupport> {
        let of_effect = |effect: usize| {
            let with = || (0..self.sets.len()).filter(|s| self.speaks_for(self.sets[*s], effect));
            let own =
                |s: &usize| !self.sets[*s].is_general && self.sets[*s].effects.contains(&effect);
            let heaviest = with()
                .filter(own)
                .max_by(|a, b| self.weights[*a].total_cmp(&self.weights[*b]));
            let Some(heaviest) = heaviest else {
                return EffectSupport::default();
            };
            EffectSupport {
                weight: with().map(|s| self.weights[s]).sum(),
                share: self.share(self.sets[heaviest], effect),
                next: self.next(self.sets[heaviest], effect),
            }
        };
        (0..self.scores.effects.len()).map(of_effect).collect()
    }

    /// The named effects with each of two near synonyms, such as dry friction and its hysteresis, that hold the support together; nothing
    /// where none do, or one holds it alone.
    fn tied_kin(&self, supports: &[EffectSupport], named: &[usize]) -> Option<Vec<Vec<usize>>> {
        let is_kin = |narrow: usize, wide: usize| {
            let both = self.kind(narrow).zip(self.kind(wide));
            both.is_some_and(|(narrow, wide)| narrow.spec().limit_of.contains(&wide.id()))
        };
        let pairs = (0..supports.len()).flat_map(|a| (0..supports.len()).map(move |b| [a, b]));
        let of_pair = |pair: [usize; 2]| {
            let holds = |s: &ScoredSet| pair.iter().any(|e| s.effects.contains(e));
            let together = self
                .sets
                .iter()
                .zip(&self.weights)
                .filter(|(s, _)| holds(s));
            let weight: f64 = together.map(|(_, weight)| weight).sum();
            let apart = pair
                .iter()
                .all(|e| !named.contains(e) && self.is_large(&supports[*e].share));
            (apart && weight >= self.numbers.support).then_some(pair)
        };
        let mut pair = pairs.filter(|[a, b]| is_kin(*a, *b)).find_map(of_pair)?;
        pair.sort_by(|a, b| supports[*b].weight.total_cmp(&supports[*a].weight));
        let with = |e: &usize| {
            let mut set = [named, &[*e]].concat();
            set.sort_unstable();
            set
        };
        Some(pair.iter().map(with).collect())
    }

    /// The effect that leaves least in another's place in a set.
    fn next(&self, set: &ScoredSet, effect: usize) -> Option<usize> {
        let differs = |s: &&&ScoredSet| {
            s.effects.len() == set.effects.len()
                && !s.effects.contains(&effect)
                && set
                    .effects
                    .iter()
                    .all(|e| *e == effect || s.effects.contains(e))
        };
        let nearest = self
            .sets
            .iter()
            .filter(differs)
            .min_by(|a, b| a.mean(0).total_cmp(&b.mean(0)));
        nearest?
            .effects
            .iter()
            .copied()
            .find(|e| !set.effects.contains(e))
    }

    /// Whether a law without a name takes a share of what every set of named effects leaves, at every length, and one that counts beside
    /// what the plain model leaves.
    fn has_general_law(&self) -> bool {
        let named = || self.sets.iter().filter(|s| !s.is_general);
        let least = |length: usize| {
            named()
                .map(|s| s.mean(length))
                .fold(f64::INFINITY, f64::min)
        };
        let takes = |set: &ScoredSet| {
            let lengths = 0..self.floors.len();
            let share = lengths
                .clone()
                .map(|l| self.taken(least(l), set.mean(l), l));
            let counts = |l: usize| {
                let all = self
                    .plain()
                    .map_or(0.0, |plain| plain.mean(l) - self.floors[l]);
                least(l) - set.mean(l) >= self.numbers.outgrows * all
            };
            self.is_large(&share.collect::<Vec<_>>()) && lengths.clone().all(counts)
        };
        self.sets.iter().filter(|s| s.is_general).any(|s| takes(s))
    }

    /// Sets without the effects that take less than their share, with their weights, the heaviest first, up to those that hold the support.
    fn tally(&self) -> Vec<(Vec<usize>, f64)> {
        let mut order: Vec<usize> = (0..self.sets.len()).collect();
        order.sort_by(|a, b| self.weights[*b].total_cmp(&self.weights[*a]));
        let mut tally: Vec<(Vec<usize>, f64)> = Vec::new();
        let mut total = 0.0;
        for s in order {
            if total >= self.numbers.support {
                break;
            }
            total += self.weights[s];
            let set = self.stripped(self.sets[s]);
            match tally.iter_mut().find(|(other, _)| *other == set) {
                Some((_, weight)) => *weight += self.weights[s],
                None => tally.push((set, self.weights[s])),
            }
        }
        tally.sort_by(|a, b| b.1.total_cmp(&a.1));
        tally
    }

    fn stripped(&self, set: &ScoredSet) -> Vec<usize> {
        let large = |e: &usize| !self.is_general(*e) && self.is_large(&self.share(set, *e));
        set.effects.iter().copied().filter(large).collect()
    }

    /// Weight of the sets of which no effect takes its share.
    fn idle(&self) -> f64 {
        let idle = self
            .sets
            .iter()
            .zip(&self.weights)
            .filter(|(s, _)| self.stripped(s).is_empty());
        idle.map(|(_, weight)| weight).sum()
    }

    /// Whether the plain model leaves hardly more than the noise.
    fn is_quiet(&self) -> bool {
        self.plain()
            .is_some_and(|s| s.mean(0) < self.numbers.quiet * self.scores.lengths[0].noise)
    }
}

#[cfg(test)]
mod tests {
    use super::super::scores::ScoredLength;
    use super::*;

    const SAMPLES: usize = 2000;
    const BLOCKS: usize = 10;
    /// Mean of the blocks beside the first.
    const MEAN: f64 = 1.09;
    /// A share of the variance that the sensor's noise takes.
    const NOISE: f64 = 1e-4;

    /// A record of which each set leaves so much, alike in all windows but for a tenth.
    fn record(sets: &[(&[&str], f64)]) -> Scores {
        let mut effects: Vec<String> = Vec::new();
        let mut scored = Vec::new();
        for (names, left) in sets {
            let mut places = Vec::new();
            for name in *names {
                let known = effects.iter().position(|e| e == name);
                places.push(known.unwrap_or(effects.len()));
                if known.is_none() {
                    effects.push((*name).to_owned());
                }
            }
            let of_block = |block: usize| left * (1.0 + 0.1 * f64::from(block as u32 % 3));
            scored.push(ScoredSet {
                parameters: names.len(),
                is_general: names
                    .iter()
                    .any(|name| Kind::by_id(name).is_some_and(|k| k.spec().is_general)),
                is_physical: true,
                left: vec![(0..BLOCKS).map(of_block).collect(); 2],
                effects: places,
            });
        }
        let length = ScoredLength {
            length_s: 1.0,
            samples: SAMPLES,
            noise: NOISE,
        };
        Scores {
            lengths: vec![length.clone(), length],
            missed_force: Some(0.3),
            effects,
            sets: scored,
        }
    }

    fn judged(sets: &[(&[&str], f64)]) -> (Rule, Vec<Vec<String>>) {
        let scores = record(sets);
        let judged = judge(&scores, &Numbers::default());
        let name = |set: &Vec<usize>| set.iter().map(|e| scores.effects[*e].clone()).collect();
        (judged.rule, judged.sets.iter().map(name).collect())
    }

    fn rule(sets: &[(&[&str], f64)]) -> Rule {
        judged(sets).0
    }

    const CUBIC: &str = "cubic_stiffness";
    const DRAG: &str = "quadratic_damping";

    #[test]
    fn an_effect_that_every_heavy_set_has_is_supported() {
        let (rule, sets) = judged(&[
            (&[], 0.1),
            (&[CUBIC], 2e-4),
            (&[DRAG], 0.09),
            (&[CUBIC, DRAG], 1.99e-4),
        ]);
        assert_eq!(
            (rule, sets),
            (Rule::Supported, vec![vec![CUBIC.to_owned()]])
        );
    }

    #[test]
    fn an_effect_takes_its_share_of_what_is_left_above_the_noise() {
        // Next to the noise every sample counts, and what is left is measured by the least of both models.
        let alone = 1.2 * NOISE / MEAN;
        let second = |times: f64| {
            let both = alone / (1.0 + times * policy::SHARE);
            judged(&[
                (&[], 0.3),
                (&[CUBIC], alone),
                (&[DRAG], 0.29),
                (&[CUBIC, DRAG], both),
            ])
            .1
        };
        assert_eq!(second(1.05), [[CUBIC, DRAG]]);
        assert_eq!(second(0.95), [[CUBIC]]);
    }

    #[test]
    fn nothing_is_missed_below_the_floor_of_force_and_of_motion() {
        let misses = |force: f64, motion: f64| {
            let mut scores = record(&[
                (&[], (motion * policy::FLOOR).powi(2) / MEAN),
                (&[CUBIC], 1e-9),
            ]);
            scores.missed_force = Some(force * policy::FLOOR);
            judge(&scores, &Numbers::default()).rule != Rule::NothingMissed
        };
        assert!(!misses(0.99, 0.99));
        assert!(misses(1.01, 0.99) && misses(0.99, 1.01));
    }

    #[test]
    fn no_more_than_noise_is_left_where_no_set_takes_a_share() {
        let plain = |times: f64| times * policy::QUIET * NOISE / MEAN;
        let left = |times: f64| rule(&[(&[], plain(times)), (&[CUBIC], 0.999 * plain(times))]);
        assert_eq!(left(0.99), Rule::NoiseLeft);
        assert_eq!(left(1.01), Rule::Unsupported);
    }

    #[test]
    fn near_synonyms_that_hold_the_support_together_are_tied() {
        let (rule, sets) = judged(&[
            (&[], 0.2),
            (&["coulomb_friction"], 1e-3),
            (&["hysteresis"], 1.02e-3),
        ]);
        assert_eq!(rule, Rule::Tied);
        assert_eq!(sets, [["coulomb_friction"], ["hysteresis"]]);
    }

    #[test]
    fn a_law_without_a_name_that_takes_a_share_leaves_no_name() {
        let general =
            |left: f64| rule(&[(&[], 0.2), (&[CUBIC], 0.05), (&["power_stiffness"], left)]);
        let outgrown = 0.05 - 1.1 * policy::SHARE * 0.05;
        assert_eq!(general(outgrown), Rule::GeneralLaw);
        assert_ne!(general(0.049), Rule::GeneralLaw);
        // Next to what the name takes of the record that is too little, whatever share of the rest it is.
        let little = |counts: f64| {
            let named = counts * policy::OUTGROWS * 0.2;
            rule(&[(&[], 0.2), (&[CUBIC], named), (&["power_stiffness"], NOISE)])
        };
        assert_eq!(little(1.2), Rule::GeneralLaw);
        assert_eq!(little(0.8), Rule::Supported);
    }

    #[test]
    fn a_set_that_does_not_follow_the_motion_has_no_names() {
        let most = policy::FOLLOWS * policy::FOLLOWS / MEAN;
        assert_eq!(
            rule(&[(&[], 5.0), (&[CUBIC], 1.01 * most)]),
            Rule::NotFollowed
        );
        assert_eq!(
            rule(&[(&[], 5.0), (&[CUBIC], 0.99 * most)]),
            Rule::Supported
        );
    }

    #[test]
    fn incomplete_models_count_as_few_samples() {
        // Two shapes, one of which leaves a tenth less: to within the noise that decides, beside a large rest it does not.
        let leaves = |left: f64| rule(&[(&[], 0.3), (&[CUBIC], left), (&[DRAG], 1.1 * left)]);
        assert_eq!(leaves(NOISE), Rule::Supported);
        assert_eq!(leaves(0.05), Rule::Tied);
        let scores = record(&[(&[], 0.3), (&[CUBIC], 0.05), (&[DRAG], 0.055)]);
        let patient = Numbers {
            patience: 100.0 * policy::PATIENCE,
            ..Numbers::default()
        };
        assert_eq!(judge(&scores, &patient).rule, Rule::Supported);
    }

    #[test]
    fn a_name_needs_the_support() {
        let at = |other: f64| {
            let scores = record(&[(&[], 0.3), (&[CUBIC], 0.05), (&[DRAG], other)]);
            let judged = judge(&scores, &Numbers::default());
            (judged.supports[0].weight, judged.rule)
        };
        let found: Vec<(f64, Rule)> = (11..20).map(|i| at(0.005 * f64::from(i))).collect();
        assert!(
            found.iter().any(|(_, rule)| *rule == Rule::Tied),
            "{found:?}"
        );
        for (weight, rule) in &found {
            let is_supported = *rule == Rule::Supported;
            assert_eq!(is_supported, *weight >= policy::SUPPORT, "{found:?}");
        }
        assert!(
            found.iter().any(|(_, rule)| *rule == Rule::Supported),
            "{found:?}"
        );
    }

    #[test]
    fn a_parameter_costs_its_nats() {
        let scores = |parameters: usize| {
            let mut scores = record(&[(&[], 0.3), (&[CUBIC], 0.05), (&[DRAG], 0.05)]);
            scores.sets[2].parameters = parameters;
            let supports = judge(&scores, &Numbers::default()).supports;
            (supports[0].weight / supports[1].weight).ln()
        };
        assert!((scores(3) - 2.0 * policy::OCCAM).abs() < 1e-6);
    }
}
