//! Where the steps are: one is added at its best place, then each is moved to where it is best beside the others until none moves
//! (binary segmentation with refinement), so that two opposite steps are found where one alone shows nothing.

use super::model::Model;
use super::sums::{Levels, Sums};

const DAY_MS: f64 = 86_400_000.0;
/// Fewest rides between steps, and beside the first and the last.
const SIDE: usize = 3;
/// Most steps.
const STEPS: usize = 4;
/// Rounds in which steps are moved.
const ROUNDS: usize = 10;
/// A larger model has to be better by so much: strong evidence (Kass and Raftery 1995, doi:10.1080/01621459.1995.10476572).
const STRONG: f64 = 6.0;

pub struct Rides {
    /// Sums over the rides before each, and over all.
    before: Vec<Sums>,
    /// What a level alone leaves.
    total: f64,
}

impl Rides {
    /// None where all are alike.
    pub fn new(points: &[(i64, f64, f64)]) -> Option<Self> {
        let mut before = vec![Sums::default()];
        for ride in centred(points) {
            before.push(before[before.len() - 1].and(ride));
        }
        let all = before.last().copied()?;
        let total = Levels::of([all].into_iter(), false).left;
        (total > 0.0 && total.is_finite()).then_some(Self { before, total })
    }

    /// The model that is chosen: each larger one has to be better by strong evidence.
    pub fn best(&self) -> Model {
        let mut found = self.model(Vec::new(), false);
        let (mut level, mut sloped) = (Vec::new(), Vec::new());
        for size in 1..=STEPS + 1 {
            // A drift counts as much as a step.
            let drifting = (sloped.len() + 1 == size).then(|| self.model(sloped.clone(), true));
            let stepped = self.with_another(&mut level, false);
            let stepped = stepped.then(|| self.model(level.clone(), false));
            self.with_another(&mut sloped, true);
            let larger = [stepped, drifting].into_iter().flatten();
            let Some(larger) = larger.min_by(|a, b| a.bic.total_cmp(&b.bic)) else {
                break;
            };
            if larger.bic + STRONG < found.bic {
                found = larger;
            }
        }
        found
    }

    fn rides(&self) -> usize {
        self.before.len() - 1
    }

    fn group(&self, from: usize, to: usize) -> Sums {
        self.before[to].less(self.before[from])
    }

    fn groups<'a>(&'a self, splits: &'a [usize]) -> impl Iterator<Item = Sums> + 'a {
        let begins = std::iter::once(0).chain(splits.iter().copied());
        let ends = splits.iter().copied().chain([self.rides()]);
        begins.zip(ends).map(|(from, to)| self.group(from, to))
    }

    fn model(&self, splits: Vec<usize>, drifts: bool) -> Model {
        let groups: Vec<Sums> = self.groups(&splits).collect();
        Model::of(&groups, splits, drifts, self.rides(), self.total)
    }

    /// Adds a step where there is room for one more; whether there was.
    fn with_another(&self, splits: &mut Vec<usize>, drifts: bool) -> bool {
        if splits.len() == STEPS {
            return false;
        }
        let Some(more) = self.best_beside(splits, drifts) else {
            return false;
        };
        splits.push(more);
        splits.sort_unstable();
        for _ in 0..ROUNDS {
            let mut moved = false;
            for i in 0..splits.len() {
                let old = splits.remove(i);
                let new = self.best_beside(splits, drifts).unwrap_or(old);
                moved |= new != old;
                splits.push(new);
                splits.sort_unstable();
            }
            if !moved {
                break;
            }
        }
        true
    }

    /// The place of one more step that leaves least.
    fn best_beside(&self, splits: &[usize], drifts: bool) -> Option<usize> {
        let mut found: Option<(f64, usize)> = None;
        let mut places = splits.to_vec();
        for split in SIDE..=self.rides().saturating_sub(SIDE) {
            if splits.iter().any(|other| other.abs_diff(split) < SIDE) {
                continue;
            }
            let at = places.partition_point(|other| *other < split);
            places.insert(at, split);
            let left = Levels::of(self.groups(&places), drifts).left;
            places.remove(at);
            if found.is_none_or(|(least, _)| left < least) {
                found = Some((left, split));
            }
        }
        found.map(|(_, split)| split)
    }
}

/// Time (days), value and weight, time and value from their weighted means.
fn centred(points: &[(i64, f64, f64)]) -> Vec<[f64; 3]> {
    let first = points.first().map_or(0, |point| point.0);
    let rides = points
        .iter()
        .map(|(ms, value, deviation)| [(ms - first) as f64 / DAY_MS, *value, deviation.powi(-2)]);
    let all = rides
        .clone()
        .fold(Sums::default(), |sums, ride| sums.and(ride));
    let (t, y) = (all.t / all.w, all.y / all.w);
    rides.map(|[a, b, w]| [a - t, b - y, w]).collect()
}
