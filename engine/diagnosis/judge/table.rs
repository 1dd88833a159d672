//! The table that decides: from what sets of effects leave of an axle's held-out windows to a verdict. The first row that applies
//! gives it.

use super::numbers::Numbers;
use super::scores::{ScoredSet, Scores};
use super::weights::weights;
use crate::policy;
use veloid_core::numerics::finite::finite;
use veloid_model::effects::Kind;
pub use veloid_report::windows::Rule;
use veloid_report::windows::Support;

/// What the scores say of an axle.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    pub rule: Rule,
    /// The supported effects, or the tied sets, the heaviest first; as places in the scores' `effects`.
    pub sets: Vec<Vec<usize>>,
    /// By effect, in the order of the scores' `effects`.
    pub supports: Vec<EffectSupport>,
    /// By set, in the order of the scores' `sets`; nothing for a set that cannot be.
    pub weights: Vec<Option<f64>>,
    /// Those of the supported effects that are named: what a sensor does to the phase of one law is another law, so that effects of
    /// sensors have no names beside others.
    pub named: Vec<usize>,
    /// Whether the supported effects leave no more than noise, or hardly any motion.
    pub is_complete: bool,
    /// Whether sets of which no effect takes its share hold the support.
    pub is_idle: bool,
    /// The heaviest set of effects with names that takes a share of what the plain model leaves, as a place in the scores' `sets`.
    pub nearest: Option<usize>,
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

impl EffectSupport {
    /// The least share of all lengths.
    pub fn least_share(&self) -> Option<f64> {
        self.share.iter().copied().reduce(f64::min)
    }
}

impl Judgement {
    /// An effect's support, as it is reported.
    pub fn support(&self, scores: &Scores, effect: usize) -> Support {
        let support = &self.supports[effect];
        Support {
            weight: support.weight,
            share: support.least_share().and_then(finite),
            windows: scores.parts(),
            next: support.next.map(|e| scores.effects[e].clone()),
        }
    }
}

/// The set of just these effects, or the best one that contains them, as a place in the scores' `sets`.
pub fn place_of(scores: &Scores, effects: &[usize]) -> Option<usize> {
    let contains = |s: &ScoredSet| effects.iter().all(|e| s.effects.contains(e));
    let can_be = |(_, s): &(usize, &ScoredSet)| s.is_physical && !s.is_general && contains(s);
    let sets = scores.sets.iter().enumerate().filter(can_be);
    let least = sets.min_by(|(_, a), (_, b)| {
        let key = |s: &ScoredSet| (s.effects.len(), s.mean(0));
        let (a, b) = (key(a), key(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    least.map(|(place, _)| place)
}

/// Sets that are reported as tied at most.
const MOST_TIED: usize = 3;

/// The verdict on one axle.
pub fn judge(scores: &Scores, numbers: &Numbers) -> Judgement {
    let matrix = Matrix::new(scores, numbers);
    let (supports, weights) = (matrix.supports(), matrix.by_set());
    let tally = matrix.tally();
    let no_effect = |(set, _): &&(Vec<usize>, f64)| set.is_empty();
    let idle: f64 = (tally.iter().filter(no_effect))
        .map(|(_, weight)| weight)
        .sum();
    let is_idle = idle >= numbers.support;
    let says = |rule, sets: Vec<Vec<usize>>| Judgement {
        rule,
        named: match (rule, sets.first()) {
            (Rule::Supported, Some(set)) => matrix.without_sensors(set.clone()),
            _ => Vec::new(),
        },
        is_complete: sets.first().is_some_and(|set| matrix.is_complete(set)),
        sets,
        supports: supports.clone(),
        is_idle,
        nearest: matrix.nearest(&weights),
        weights: weights.clone(),
    };
    let named = matrix.named(&supports);
    let follows = matrix.follows();
    let is_general = follows && matrix.has_general_law();
    let is_supported = follows && !is_general && !named.is_empty();
    if matrix.misses() < numbers.floor && !(is_supported && matrix.leaves_noise_with(&named)) {
        return says(Rule::NothingMissed, Vec::new());
    }
    if !follows {
        return says(Rule::NotFollowed, Vec::new());
    }
    if is_general {
        return says(Rule::GeneralLaw, Vec::new());
    }
    if is_supported {
        return says(Rule::Supported, vec![named]);
    }
    if is_idle && matrix.is_quiet() {
        return says(Rule::NoiseLeft, Vec::new());
    }
    let mut tied = tally;
    tied.retain(|(set, _)| !set.is_empty());
    tied.truncate(MOST_TIED);
    let together: f64 = tied.iter().map(|(_, weight)| weight).sum();
    match !numbers.is_ridden && tied.len() > 1 && together >= numbers.support {
        true => says(Rule::Tied, fewest(tied, numbers.support)),
        false => says(Rule::Unsupported, Vec::new()),
    }
}

/// Of sets, the heaviest first, as many as hold the support together.
fn fewest(sets: Vec<(Vec<usize>, f64)>, support: f64) -> Vec<Vec<usize>> {
    let mut held = 0.0;
    let needed = sets.into_iter().take_while(|(_, weight)| {
        let is_needed = held < support;
        held += weight;
        is_needed
    });
    needed.map(|(set, _)| set).collect()
}

/// Whether a law is a case of a general one.
fn is_case(narrow: Kind, wide: Kind) -> bool {
    narrow.case_of() == Some(wide)
        || matches!(
            (narrow, wide),
            (Kind::CubicStiffness, Kind::PowerStiffness)
                | (Kind::QuadraticDamping, Kind::PowerDamping)
                | (
                    Kind::CoulombFriction,
                    Kind::FrictionCurve | Kind::PowerDamping
                )
        )
}

/// Whether a spring holds the mass: models with one, of which `sprung` are the scores, hold the support against those without.
pub fn needs_spring(sprung: &Scores, bare: &Scores, numbers: &Numbers) -> bool {
    let mut both = sprung.clone();
    let spring = both.effects.len();
    both.effects.push("spring".to_owned());
    for set in &mut both.sets {
        set.effects.push(spring);
        set.parameters += 1;
    }
    let place = |both: &mut Scores, id: &String| {
        let known = both.effects.iter().position(|other| other == id);
        known.unwrap_or_else(|| {
            both.effects.push(id.clone());
            both.effects.len() - 1
        })
    };
    for set in &bare.sets {
        let effects = set.effects.iter();
        let effects = effects
            .map(|e| place(&mut both, &bare.effects[*e]))
            .collect();
        both.sets.push(ScoredSet {
            effects,
            ..set.clone()
        });
    }
    let found = Matrix::new(&both, numbers).supports();
    let with = &found[spring];
    with.weight >= numbers.support && with.least_share().is_some_and(|s| s >= numbers.share)
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
        let sets: Vec<&ScoredSet> = (scores.sets.iter()).filter(|s| s.is_physical).collect();
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

    /// Whether some set of effects with names follows the motion at every length.
    fn follows(&self) -> bool {
        let most = policy::FOLLOWS * policy::FOLLOWS;
        let lengths = 0..self.floors.len();
        let follows = |s: &ScoredSet| lengths.clone().all(|length| s.mean(length) <= most);
        self.sets.iter().any(|s| !s.is_general && follows(s))
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

    /// Whether a set has an effect, or on a bench a general law of which it is a case.
    fn speaks_for(&self, set: &ScoredSet, effect: usize) -> bool {
        let wider = |e: &usize| {
            let both = self.kind(effect).zip(self.kind(*e));
            both.is_some_and(|(narrow, wide)| is_case(narrow, wide))
        };
        set.effects.contains(&effect) || !self.numbers.is_ridden && set.effects.iter().any(wider)
    }

    /// Whether an effect takes its share; what a sensor does also stands for much that is none of its own.
    fn is_large(&self, effect: usize, share: &[f64]) -> bool {
        let wanted = match self.is_of_sensor(effect) {
            true => self.numbers.strict_share,
            false => self.numbers.share,
        };
        share.iter().copied().fold(f64::INFINITY, f64::min) >= wanted
    }

    fn is_of_sensor(&self, effect: usize) -> bool {
        let kind = self.kind(effect);
        kind.is_some_and(|kind| kind.spec().on_sensor)
    }

    fn supports(&self) -> Vec<EffectSupport> {
        let of_effect = |effect: usize| {
            let limit = self.as_limit(effect);
            let Some(own) = limit.map_or_else(|| self.heaviest(effect), |(_, set)| Some(set))
            else {
                return EffectSupport::default();
            };
            let speaks = |set: &ScoredSet| {
                let wide = limit.is_some_and(|(wide, _)| set.effects.contains(&wide));
                wide || self.speaks_for(set, effect)
            };
            let both = self.sets.iter().zip(&self.weights);
            let with = both.filter(|(set, _)| speaks(set));
            EffectSupport {
                weight: with.map(|(_, weight)| weight).sum(),
                share: self.share(own, effect),
                next: self.next(own, effect),
            }
        };
        (0..self.scores.effects.len()).map(of_effect).collect()
    }

    /// The effects that hold the support and take their share. Where that is strict, one beside which another law of its variable takes a
    /// share is no name: both draw a curve.
    fn named(&self, supports: &[EffectSupport]) -> Vec<usize> {
        let holds = |e: &usize| supports[*e].weight >= self.numbers.support;
        let held: Vec<usize> = (0..supports.len()).filter(holds).collect();
        let share = |e: usize| supports[e].least_share().unwrap_or_default();
        let family = |e: usize| self.kind(e).and_then(|kind| kind.spec().family);
        let is_bent = |e: usize| {
            let mut others = held.iter().filter(|o| **o != e && family(**o) == family(e));
            family(e).is_some()
                && others.any(|o| {
                    share(*o) >= self.numbers.nameless_share && share(*o) < self.numbers.share
                })
        };
        let named = held.iter().copied();
        let named = named.filter(|e| self.is_large(*e, &supports[*e].share) && !is_bent(*e));
        self.without_limits(named.collect())
    }

    /// The heaviest set of laws with names that contains an effect.
    fn heaviest(&self, effect: usize) -> Option<&ScoredSet> {
        let both = self.sets.iter().zip(&self.weights);
        let own = both.filter(|(set, _)| !set.is_general && set.effects.contains(&effect));
        own.max_by(|a, b| a.1.total_cmp(b.1)).map(|(set, _)| *set)
    }

    /// The wider law of which an effect is a limit that stands for it, such as dry friction for its hysteresis, with the set in which it
    /// does: in its place it lacks less than a share of what that takes.
    fn as_limit(&self, narrow: usize) -> Option<(usize, &ScoredSet)> {
        let is_wider = |wide: &usize| {
            let both = self.kind(narrow).zip(self.kind(*wide));
            both.is_some_and(|(narrow, wide)| narrow.is_limit_of(wide))
        };
        let wide = (0..self.scores.effects.len()).find(is_wider)?;
        let heaviest = self.stripped(self.heaviest(wide)?);
        let rest: Vec<usize> = heaviest.into_iter().filter(|e| *e != wide).collect();
        let of = |set: &[usize]| self.sets.iter().find(|s| is_set(s, set));
        let with = |e: usize| of(&[&rest[..], &[e]].concat());
        let (without, limit, law) = (of(&rest)?, with(narrow)?, with(wide)?);
        let beyond = |l: usize| {
            let all = (without.mean(l) - law.mean(l)).max(f64::MIN_POSITIVE);
            (limit.mean(l) - law.mean(l)) / all
        };
        let stands = (0..self.floors.len()).all(|l| beyond(l) < self.numbers.nameless_share);
        stands.then_some((wide, limit))
    }

    /// Of a law and its limit that both have a name one: the law where the model is complete with it.
    fn without_limits(&self, named: Vec<usize>) -> Vec<usize> {
        let mut kept = named.clone();
        for narrow in &named {
            let Some((wide, _)) = self.as_limit(*narrow).filter(|(w, _)| named.contains(w)) else {
                continue;
            };
            let others: Vec<usize> = named.iter().copied().filter(|e| e != narrow).collect();
            let goes = if self.is_complete(&others) {
                *narrow
            } else {
                wide
            };
            kept.retain(|e| *e != goes);
        }
        kept
    }

    /// Without effects of sensors beside others.
    fn without_sensors(&self, mut named: Vec<usize>) -> Vec<usize> {
        if !named.iter().all(|e| self.is_of_sensor(*e)) {
            named.retain(|e| !self.is_of_sensor(*e));
        }
        named
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
    /// what the plain model leaves, or leaves no more than noise.
    fn has_general_law(&self) -> bool {
        let named = || self.sets.iter().filter(|s| !s.is_general);
        let least = |length: usize| {
            named()
                .map(|s| s.mean(length))
                .fold(f64::INFINITY, f64::min)
        };
        let takes = |set: &ScoredSet| {
            let lengths = 0..self.floors.len();
            let share = |l: usize| self.taken(least(l), set.mean(l), l);
            let counts = |l: usize| {
                let all = self
                    .plain()
                    .map_or(0.0, |plain| plain.mean(l) - self.floors[l]);
                least(l) - set.mean(l) >= self.numbers.outgrows * all
            };
            (lengths.clone()).all(|l| share(l) >= self.numbers.nameless_share)
                && (self.leaves_noise(set) || lengths.clone().all(counts))
        };
        self.sets.iter().filter(|s| s.is_general).any(|s| takes(s))
    }

    /// Sets without the effects that take less than their share, with their weights, the heaviest first.
    fn tally(&self) -> Vec<(Vec<usize>, f64)> {
        let mut tally: Vec<(Vec<usize>, f64)> = Vec::new();
        for (set, weight) in self.sets.iter().zip(&self.weights) {
            let set = self.stripped(set);
            match tally.iter_mut().find(|(other, _)| *other == set) {
                Some((_, sum)) => *sum += weight,
                None => tally.push((set, *weight)),
            }
        }
        tally.sort_by(|a, b| b.1.total_cmp(&a.1));
        tally
    }

    fn stripped(&self, set: &ScoredSet) -> Vec<usize> {
        let large = |e: &usize| !self.is_general(*e) && self.is_large(*e, &self.share(set, *e));
        set.effects.iter().copied().filter(large).collect()
    }

    /// Whether the plain model leaves hardly more than the noise.
    fn is_quiet(&self) -> bool {
        self.plain().is_some_and(|s| self.leaves_noise(s))
    }

    fn leaves_noise(&self, set: &ScoredSet) -> bool {
        set.mean(0) < self.numbers.quiet * self.scores.lengths[0].noise
    }

    /// Whether these effects leave hardly more than the noise, or hardly any motion.
    fn is_complete(&self, effects: &[usize]) -> bool {
        self.set_of(effects)
            .is_some_and(|s| self.leaves_noise(s) || s.mean(0).sqrt() < self.numbers.floor)
    }

    /// Whether these effects leave hardly more than the noise.
    fn leaves_noise_with(&self, effects: &[usize]) -> bool {
        self.set_of(effects).is_some_and(|s| self.leaves_noise(s))
    }

    fn set_of(&self, effects: &[usize]) -> Option<&ScoredSet> {
        place_of(self.scores, effects).map(|place| &self.scores.sets[place])
    }

    /// The weights of the scores' sets.
    fn by_set(&self) -> Vec<Option<f64>> {
        let weight = |set: &ScoredSet| {
            let place = self.sets.iter().position(|s| std::ptr::eq(*s, set))?;
            Some(self.weights[place])
        };
        self.scores.sets.iter().map(weight).collect()
    }

    /// The heaviest set of effects with names that takes its share, by the weights of the scores' sets.
    fn nearest(&self, weights: &[Option<f64>]) -> Option<usize> {
        let plain = self.plain().map_or(f64::INFINITY, |plain| plain.mean(0));
        let most = (1.0 - self.numbers.nameless_share) * plain;
        let named = |s: &ScoredSet| !s.is_general && !s.effects.is_empty() && s.mean(0) <= most;
        let weights = weights.iter().enumerate();
        let weighed = weights.filter_map(|(s, weight)| Some((s, (*weight)?)));
        let named = weighed.filter(|(s, _)| named(&self.scores.sets[*s]));
        named.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(s, _)| s)
    }
}

fn is_set(scored: &ScoredSet, effects: &[usize]) -> bool {
    scored.effects.len() == effects.len() && effects.iter().all(|e| scored.effects.contains(e))
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
            parts: BLOCKS,
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
        let sets = match judged.rule {
            Rule::Supported => vec![judged.named],
            _ => judged.sets,
        };
        (judged.rule, sets.iter().map(name).collect())
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
        let ruled = |force: f64, motion: f64, left: f64| {
            let plain = (motion * policy::FLOOR).powi(2) / MEAN;
            let mut scores = record(&[(&[], plain), (&[CUBIC], left)]);
            scores.missed_force = Some(force * policy::FLOOR);
            judge(&scores, &Numbers::default()).rule
        };
        let loud = 1.1 * policy::QUIET * NOISE;
        assert_eq!(ruled(0.99, 0.99, loud), Rule::NothingMissed);
        assert_ne!(ruled(1.01, 0.99, loud), Rule::NothingMissed);
        assert_ne!(ruled(0.99, 1.01, loud), Rule::NothingMissed);
        // What leaves no more than the measured noise acts, however little that is.
        let quiet = 0.1 * policy::QUIET * NOISE / MEAN;
        assert_eq!(ruled(0.99, 0.99, quiet), Rule::Supported);
    }

    #[test]
    fn no_more_than_noise_is_left_where_no_set_takes_a_share() {
        let plain = |times: f64| times * policy::QUIET * NOISE / MEAN;
        let left = |times: f64| rule(&[(&[], plain(times)), (&[CUBIC], 0.999 * plain(times))]);
        assert_eq!(left(0.99), Rule::NoiseLeft);
        assert_eq!(left(1.01), Rule::Unsupported);
    }

    #[test]
    fn a_law_and_its_limit_are_one_answer() {
        let (friction, hysteresis) = ("coulomb_friction", "hysteresis");
        // Beside a rest the limit stands for the law as long as it lacks less than a share of what that takes.
        let beside = |lacks: f64| {
            let law = 0.05;
            let limit = law + lacks * policy::SHARE * (0.2 - law);
            judged(&[(&[], 0.2), (&[friction], limit), (&[hysteresis], law)])
        };
        assert_eq!(
            beside(0.9),
            (Rule::Supported, vec![vec![friction.to_owned()]])
        );
        assert_eq!(
            beside(1.1),
            (Rule::Supported, vec![vec![hysteresis.to_owned()]])
        );
        // A law that leaves no more than noise is no stand-in.
        let complete = judged(&[(&[], 0.2), (&[friction], 1e-3), (&[hysteresis], NOISE)]);
        assert_eq!(complete.1, [[hysteresis]]);
    }

    #[test]
    fn an_effect_of_a_sensor_is_no_name_beside_another() {
        let delay = "sensor_delay";
        let both = [
            (&[][..], 0.3),
            (&[CUBIC], 0.03),
            (&[delay], 0.03),
            (&[CUBIC, delay], 2e-4),
        ];
        assert_eq!(judged(&both).1, [[CUBIC]]);
        assert_eq!(
            judged(&[(&[], 0.3), (&[CUBIC], 0.29), (&[delay], 0.03)]).1,
            [[delay]]
        );
    }

    #[test]
    fn two_laws_of_one_variable_are_a_curve_where_the_share_is_strict() {
        let (drag, hysteresis) = (DRAG, "hysteresis");
        let named = |second: &str, left: f64| {
            let sets = [
                (&[][..], 0.3),
                (&[hysteresis], 2e-3),
                (&[second], 0.29),
                (&[hysteresis, second], left),
            ];
            judge(&record(&sets), &Numbers::on_road()).named.len()
        };
        let bends = |times: f64| 2e-3 * (1.0 - times * policy::SHARE);
        assert_eq!(named(drag, bends(1.5)), 0);
        assert_eq!(named(drag, bends(0.5)), 1);
        assert_eq!(named(CUBIC, bends(1.5)), 1);
    }

    #[test]
    fn on_a_road_and_of_sensors_the_share_is_strict() {
        let named = |id: &str, numbers: Numbers, times: f64| {
            let left = 0.3 * (1.0 - times * policy::STRICT_SHARE);
            !judge(&record(&[(&[], 0.3), (&[id], left)]), &numbers)
                .named
                .is_empty()
        };
        for (id, numbers) in [
            (CUBIC, Numbers::on_road()),
            ("sensor_gain", Numbers::default()),
        ] {
            assert!(named(id, numbers, 1.01) && !named(id, numbers, 0.99));
        }
        assert!(named(CUBIC, Numbers::default(), 0.99));
    }

    #[test]
    fn on_a_road_shapes_do_not_tie_and_a_general_law_speaks_for_none() {
        let on_road = |sets: &[(&[&str], f64)]| {
            let judged = judge(&record(sets), &Numbers::on_road());
            (judged.rule, judged.named.len())
        };
        let tied = [(&[][..], 0.3), (&[CUBIC], 0.01), (&[DRAG], 0.0101)];
        assert_eq!(rule(&tied), Rule::Tied);
        assert_eq!(on_road(&tied), (Rule::Unsupported, 0));
        let general = [
            (&[][..], 0.3),
            (&[CUBIC], 0.01),
            (&["power_stiffness"], 0.0099),
        ];
        assert_eq!(rule(&general), Rule::Supported);
        assert_eq!(on_road(&general), (Rule::Unsupported, 0));
    }

    #[test]
    fn sets_without_a_sizeable_effect_are_idle() {
        let idle = |left: f64| {
            judge(
                &record(&[(&[], 0.3), (&[CUBIC], left)]),
                &Numbers::default(),
            )
            .is_idle
        };
        assert!(idle(0.299) && !idle(0.01));
    }

    #[test]
    fn a_spring_is_a_base_where_models_with_one_hold_the_support() {
        let needs = |sprung: f64| {
            let sprung = record(&[(&[], 0.5), (&[CUBIC], sprung)]);
            let bare = record(&[(&[], 0.5), (&["coulomb_friction"], 0.01)]);
            needs_spring(&sprung, &bare, &Numbers::default())
        };
        assert!(needs(0.001) && !needs(0.01));
    }

    #[test]
    fn a_law_without_a_name_that_takes_a_share_leaves_no_name() {
        let general =
            |left: f64| rule(&[(&[], 0.2), (&[CUBIC], 0.05), (&["power_stiffness"], left)]);
        let outgrown = 0.05 - 1.1 * policy::SHARE * 0.05;
        assert_eq!(general(outgrown), Rule::GeneralLaw);
        assert_ne!(general(0.049), Rule::GeneralLaw);
        // Next to what the name takes of the record that is too little, whatever share of the rest it is, unless only noise is left.
        let little = |counts: f64, left: f64| {
            let named = left + counts * policy::OUTGROWS * 0.2;
            rule(&[(&[], 0.2), (&[CUBIC], named), (&["power_stiffness"], left)])
        };
        let loud = 1.2 * policy::QUIET * NOISE;
        assert_eq!(little(1.2, loud), Rule::GeneralLaw);
        assert_eq!(little(0.8, loud), Rule::Supported);
        assert_eq!(
            little(0.8, 0.8 * policy::QUIET * NOISE / MEAN),
            Rule::GeneralLaw
        );
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
